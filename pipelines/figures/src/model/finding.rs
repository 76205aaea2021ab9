//! That an oscillation is the method's and not the device's, at a glance: three runs of one scene,
//! and how size and number of the swings depend on the step.

use crate::words::{logarithms, model_mark, plain, powers_axis, solver_colour};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Figure, Layer, Line, Panel, Points, Range, TWO_COLUMNS_MM, Text, TextPlace,
};
use zwidth_results::{TradeRun, TradeSetting};

/// Heights of the panels, mm.
const COURSES_MM: f64 = 48.0;
const STEPS_MM: f64 = 40.0;
/// Milliseconds in a second.
const MS_PER_S: f64 = 1e3;
/// The lever is near its top within this, °.
const NEAR_DEG: f64 = 0.05;
/// Drawn is this share of the time that it is there before it and after it, and of no less than
/// this time, s.
const ROOM: f64 = 0.35;
const SHORTEST_S: f64 = 0.1;
/// And so far below the top and above the highest run, °.
const BELOW_DEG: f64 = 2.0;
const ABOVE_DEG: f64 = 0.4;
/// Swings whose median is smaller are not drawn, rad: ten times the smallest that exist.
const LEAST_RAD: f64 = 1e-8;

/// The solver of the finding, and the remarks on it.
pub struct Felt<'a> {
    /// The solver that chatters.
    pub solver: &'a str,
    /// Whether it can be felt, in a sentence.
    pub sentence: String,
    /// What its scene is called.
    pub title: String,
}

/// The finding. `runs` are the coarsest first, the one that finds events last; `settings` are those
/// of the scene.
pub fn finding(runs: &[TradeRun], settings: &[TradeSetting], felt: &Felt) -> Figure {
    let steps = Steps::of(settings, felt.solver);
    let exact = runs.iter().find(|run| run.step_s.is_none());
    let changes = exact.map_or(0, |run| run.motion_changes);
    let size = steps_panel(
        Cell::at(1, 0),
        powers_axis("size of a swing", "°"),
        [&steps.step_ms, &steps.amplitude_deg],
        felt.solver,
        "found by events: none".to_owned(),
    )
    .titled("**b**  Half the step: a quarter of the swing …");
    let number = steps_panel(
        Cell::at(1, 1),
        powers_axis("changes of direction", ""),
        [&steps.step_ms, &steps.reversals],
        felt.solver,
        format!("found by events: {changes} changes"),
    )
    .titled("**c**  … and twice as many");
    Figure {
        title: Some("The oscillation is the method’s, not the device’s".to_owned()),
        description: format!(
            "{}. Top: the lever's angle, run with a coarse step, a tenth of it, and with events found. Bottom left: \
             the size of a swing goes to zero with the step. Bottom right: their number goes to infinity.",
            felt.title
        ),
        width_mm: TWO_COLUMNS_MM,
        panels: vec![courses_panel(runs), size, number],
        footnotes: vec![plain(&felt.sentence)],
        mark: model_mark(),
        ..Figure::default()
    }
}

/// The angle of a run as it stands on the axis.
fn theta_deg(run: &TradeRun) -> impl Iterator<Item = f64> {
    run.theta_rad.iter().map(|rad| rad.to_degrees())
}

/// The angle while the lever should rest at its top, and a little before and after, of each run.
fn courses_panel(runs: &[TradeRun]) -> Panel {
    // What finds events is right; without it, the finest step is nearest to it.
    let right = runs.iter().rev().find(|run| run.step_s.is_none()).or(runs.last());
    let Rest { top_deg, from_s, to_s } =
        right.map_or(Rest { top_deg: 0.0, from_s: 0.0, to_s: 1.0 }, rest);
    let mut layers = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let pairs = run.t_s.iter().copied().zip(theta_deg(run));
        let (x, y) = pairs.filter(|(t, _)| (from_s..=to_s).contains(t)).unzip();
        let (name, stroke) = match run.step_s {
            Some(step_s) => (
                format!("RK4, step {} ms", MS_PER_S * step_s),
                style::mean(style::environment_colour(i)),
            ),
            None => (
                format!("events found: {} changes of motion", run.motion_changes),
                Stroke { width_pt: 1.8, ..style::mean(style::INK) },
            ),
        };
        let name = Some(plain(&name));
        layers.push(Layer::Line(Line { x, y, stroke, name, ..Line::default() }));
    }
    let highest = runs.iter().flat_map(theta_deg).fold(top_deg, f64::max);
    let room = Range::Fixed(top_deg - BELOW_DEG, highest + ABOVE_DEG);
    let x = Axis::new("*t*", "s").ranged(Range::Fixed(from_s, to_s));
    let y = Axis::new("*θ*", "°").ranged(room);
    let title = "**a**  One scene, three runs: the lever should stop and stay";
    Panel::new(Cell::at(0, 0).spanning(1, 2), x, y, layers).titled(title).tall(COURSES_MM)
}

/// The top of a run, and from when to when it is near it, with some room.
struct Rest {
    top_deg: f64,
    from_s: f64,
    to_s: f64,
}

fn rest(run: &TradeRun) -> Rest {
    let top_deg = theta_deg(run).fold(f64::NEG_INFINITY, f64::max);
    let pairs = run.t_s.iter().zip(&run.theta_rad);
    let near = pairs.filter(|(_, theta)| theta.to_degrees() > top_deg - NEAR_DEG);
    let mut near = near.map(|(t, _)| *t);
    let first = near.next().unwrap_or(0.0);
    // Whatever lies between: a lever that chatters leaves its top now and then.
    let last = near.next_back().unwrap_or(first);
    let room = ROOM * (last - first).max(SHORTEST_S);
    Rest { top_deg, from_s: first - room, to_s: last + room }
}

/// Values of a solver against its step, ms, and in words what the one that finds events has.
fn steps_panel(
    cell: Cell,
    y_axis: Axis,
    [step_ms, values]: [&[f64]; 2],
    solver: &str,
    exact: String,
) -> Panel {
    let x = logarithms(step_ms);
    let y = logarithms(values);
    let colour = solver_colour(solver);
    let points = Points { x: x.clone(), y: y.clone(), colour, ..Points::default() };
    let line = Line { x, y, stroke: style::mean(colour), ..Line::default() };
    let words = Text { lines: vec![exact], place: TextPlace::EmptiestCorner };
    let layers = vec![Layer::Line(line), Layer::Points(points), Layer::Text(words)];
    let x_axis = powers_axis("step *h*", "ms").linked("step");
    Panel::new(cell, x_axis, y_axis, layers).tall(STEPS_MM)
}

/// Swings by step of one solver.
#[derive(Default)]
struct Steps {
    step_ms: Vec<f64>,
    amplitude_deg: Vec<f64>,
    reversals: Vec<f64>,
}

impl Steps {
    /// Those of a solver that swings.
    fn of(settings: &[TradeSetting], solver: &str) -> Self {
        let mut steps = Self::default();
        let own = settings.iter().filter(|setting| *setting.solver == *solver);
        for setting in own.filter(|setting| setting.swings.is_some_and(|swings| swings > 0)) {
            let amplitude_rad = setting.swing_amplitude_rad.filter(|rad| *rad > LEAST_RAD);
            steps.step_ms.push(setting.step_s.map_or(f64::NAN, |step_s| MS_PER_S * step_s));
            steps.amplitude_deg.push(amplitude_rad.map_or(f64::NAN, f64::to_degrees));
            steps.reversals.push(setting.reversals.map_or(f64::NAN, |n| n as f64));
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::trade_setting;

    /// A coarse run that overshoots, and one that finds events and rests from 1 s to 2 s.
    fn courses() -> [TradeRun; 2] {
        let t_s: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.1).collect();
        let right = |t: &f64| if *t < 1.0 { 0.2 * t } else { 0.2 - 0.1 * (t - 2.0).max(0.0) };
        let run = |solver: &str, step_s, above| TradeRun {
            solver: solver.into(),
            step_s,
            motion_changes: 3,
            theta_rad: t_s.iter().map(|t| right(t) + above).collect(),
            t_s: t_s.clone(),
        };
        [run("rk4_per_step", Some(8.3e-3), 0.05), run("exact", None, 0.0)]
    }

    #[test]
    fn the_top_panel_shows_the_time_at_which_the_lever_should_rest() {
        let Rest { top_deg, from_s: from, to_s: to } = rest(&courses()[1]);
        assert!((top_deg - 0.2_f64.to_degrees()).abs() < 1e-9);
        assert!((from - 0.65).abs() < 0.05 && (to - 2.35).abs() < 0.05, "{from} {to}");
    }

    #[test]
    fn swings_of_a_solver_are_drawn_by_step_and_it_is_said_whether_they_are_felt() {
        let rk4 = |step_s, amplitude_rad, n| TradeSetting {
            step_s: Some(step_s),
            swing_amplitude_rad: Some(amplitude_rad),
            swings: Some(n),
            reversals: Some(n),
            ..trade_setting("rk4_per_step")
        };
        let exact = TradeSetting { swings: Some(0), reversals: Some(2), ..trade_setting("exact") };
        let settings = [exact, rk4(1e-3, 1e-3, 20), rk4(2e-3, 4e-3, 10)];
        let felt = Felt {
            solver: "rk4_per_step",
            sentence: "It is felt.".to_owned(),
            title: "Trade".to_owned(),
        };
        let figure = finding(&courses(), &settings, &felt);
        assert_eq!((figure.panels.len(), figure.footnotes.len()), (3, 1));
        assert!(zwidth_draw::draw(&figure).is_ok());
        assert_eq!(Steps::of(&settings, "rk4_per_step").step_ms, [1.0, 2.0]);
    }
}
