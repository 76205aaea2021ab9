//! That an oscillation is the method's and not the device's, at a glance: three runs of one scene,
//! and how size and number of the swings go with the step.

use crate::words::{model_mark, plain};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{
    Axis, Cell, Figure, Layer, Line, Panel, Points, Range, TWO_COLUMNS_MM, Text, TextPlace, Ticks,
};
use zwidth_dynamics::NAMED_SOLVERS;
use zwidth_tables::{Table, TableError};

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

/// Of which solver the finding is, and what is said of it.
pub struct Felt<'a> {
    /// The solver that chatters.
    pub solver: &'a str,
    /// Whether it can be felt, in a sentence.
    pub sentence: String,
}

/// The finding. `courses` has the runs (the coarsest first, the one that finds events last),
/// `settings` is the stage `trade`'s table of the scene.
///
/// # Errors
/// A table that lacks a column.
pub fn finding(courses: &Table, settings: &Table, felt: &Felt) -> Result<Figure, TableError> {
    let runs = runs(courses)?;
    let steps = steps(settings, felt.solver)?;
    let changes = runs.iter().find(|run| run.step_ms.is_none()).map_or(0, |run| run.changes);
    let powers = |label: &str, unit: &str| Axis { ticks: Ticks::Powers, ..Axis::new(label, unit) };
    let x = || powers("step *h*", "ms").linked("step");
    let curve = |y: &[f64], expect: &str| {
        let (x, y) = (logarithms(&steps.step_ms), logarithms(y));
        let number = NAMED_SOLVERS.iter().position(|named| named.name == felt.solver);
        let colour = style::solver_colour(number.unwrap_or(0));
        let points = Points { x: x.clone(), y: y.clone(), colour, ..Points::default() };
        let line = Line { x, y, stroke: style::mean(colour), ..Line::default() };
        let words = Text { lines: vec![expect.to_owned()], place: TextPlace::EmptiestCorner };
        vec![Layer::Line(line), Layer::Points(points), Layer::Text(words)]
    };
    let panels = vec![
        courses_panel(&runs),
        panel(
            0,
            x(),
            powers("size of a swing", "°"),
            curve(&steps.amplitude_deg, "found by events: none"),
            "**b**  Half the step: a quarter of the swing …",
        ),
        panel(
            1,
            x(),
            powers("changes of direction", ""),
            curve(&steps.reversals, &format!("found by events: {changes} changes")),
            "**c**  … and twice as many",
        ),
    ];
    Ok(Figure {
        title: Some("The oscillation is the method’s, not the device’s".to_owned()),
        description: format!(
            "{}. Top: the lever's angle, run with a coarse step, a tenth of it, and with events found. Bottom left: \
             the size of a swing goes to zero with the step. Bottom right: their number goes to infinity.",
            settings.title()
        ),
        width_mm: TWO_COLUMNS_MM,
        panels,
        footnotes: vec![plain(&felt.sentence)],
        mark: model_mark(),
        ..Figure::default()
    })
}

/// A run of the table of courses.
struct Run {
    step_ms: Option<f64>,
    changes: i64,
    t_s: Vec<f64>,
    theta_deg: Vec<f64>,
}

/// Rows that follow each other with one solver and one step.
fn runs(courses: &Table) -> Result<Vec<Run>, TableError> {
    let (solvers, steps) = (courses.texts("solver")?, courses.floats("step_s")?);
    let (t, theta) = (courses.floats("t_s")?, courses.floats("theta_rad")?);
    let changes = courses.integers("motion_changes")?;
    let mut runs: Vec<Run> = Vec::new();
    for i in 0..courses.height() {
        let key = |i: usize| (&solvers[i], steps[i].map(f64::to_bits));
        if i == 0 || key(i) != key(i - 1) {
            let step_ms = steps[i].map(|s| MS_PER_S * s);
            let changes = changes[i].unwrap_or_default();
            runs.push(Run { step_ms, changes, t_s: Vec::new(), theta_deg: Vec::new() });
        }
        if let Some(run) = runs.last_mut() {
            run.t_s.push(t[i].unwrap_or(f64::NAN));
            run.theta_deg.push(theta[i].map_or(f64::NAN, f64::to_degrees));
        }
    }
    Ok(runs)
}

/// The angle while the lever should rest at its top, and a little before and after, of each run.
fn courses_panel(runs: &[Run]) -> Panel {
    let right = runs.iter().rev().find(|run| run.step_ms.is_none()).or(runs.last());
    let (top_deg, from, to) = right.map_or((0.0, 0.0, 1.0), rest);
    let inside = |(t, _): &(f64, f64)| (from..=to).contains(t);
    let layers = runs.iter().enumerate().map(|(i, run)| {
        let pairs = run.t_s.iter().copied().zip(run.theta_deg.iter().copied());
        let (x, y) = pairs.filter(inside).unzip();
        let name = match run.step_ms {
            Some(step_ms) => format!("RK4, step {step_ms} ms"),
            None => format!("events found: {} changes of motion", run.changes),
        };
        Layer::Line(Line { x, y, stroke: pen(i, run), name: Some(plain(&name)), ..Line::default() })
    });
    let highest = runs.iter().flat_map(|run| run.theta_deg.iter().copied()).fold(top_deg, f64::max);
    let room = Range::Fixed(top_deg - BELOW_DEG, highest + ABOVE_DEG);
    let x = Axis::new("*t*", "s").ranged(Range::Fixed(from, to));
    let y = Axis::new("*θ*", "°").ranged(room);
    let cell = Cell { row: 0, column: 0, rows: 1, columns: 2 };
    let title = "**a**  One scene, three runs: the lever should stop and stay";
    let panel = Panel::new(cell, x, y, layers.collect()).titled(title);
    Panel { height_mm: Some(COURSES_MM), ..panel }
}

/// The top of a run, °, and from when to when it is near it, s, with some room.
fn rest(run: &Run) -> (f64, f64, f64) {
    let top_deg = run.theta_deg.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let pairs = || run.t_s.iter().zip(&run.theta_deg);
    let mut near = pairs().filter(|(_, theta)| **theta > top_deg - NEAR_DEG).map(|(t, _)| *t);
    let first = near.next().unwrap_or(0.0);
    let last = near.next_back().unwrap_or(first);
    let room = ROOM * (last - first).max(SHORTEST_S);
    (top_deg, first - room, last + room)
}

fn pen(number: usize, run: &Run) -> Stroke {
    match run.step_ms {
        None => Stroke { width_pt: 1.8, ..style::mean(style::INK) },
        Some(_) => style::mean(style::environment_colour(number)),
    }
}

fn panel(column: usize, x: Axis, y: Axis, layers: Vec<Layer>, title: &str) -> Panel {
    let panel = Panel::new(Cell::at(1, column), x, y, layers).titled(title);
    Panel { height_mm: Some(STEPS_MM), ..panel }
}

/// Swings by step of one solver.
struct Steps {
    step_ms: Vec<f64>,
    amplitude_deg: Vec<f64>,
    reversals: Vec<f64>,
}

fn steps(settings: &Table, solver: &str) -> Result<Steps, TableError> {
    let solvers = settings.texts("solver")?;
    let swings = settings.integers("swings")?;
    let (steps, amplitudes) = (settings.floats("step_s")?, settings.floats("swing_amplitude_rad")?);
    let reversals = settings.integers("reversals")?;
    let rows = (0..solvers.len()).filter(|i| {
        solvers[*i].as_deref() == Some(solver) && swings[*i].is_some_and(|swings| swings > 0)
    });
    let rows: Vec<usize> = rows.collect();
    let pick = |get: &dyn Fn(usize) -> Option<f64>| -> Vec<f64> {
        rows.iter().map(|i| get(*i).unwrap_or(f64::NAN)).collect()
    };
    Ok(Steps {
        step_ms: pick(&|i| steps[i].map(|s| MS_PER_S * s)),
        amplitude_deg: pick(&|i| amplitudes[i].filter(|a| *a > LEAST_RAD).map(f64::to_degrees)),
        reversals: pick(&|i| reversals[i].map(|n| n as f64)),
    })
}

/// What an axis of powers of ten takes; what is not above zero has no place on it.
fn logarithms(values: &[f64]) -> Vec<f64> {
    values.iter().map(|&v| if v > 0.0 { libm::log10(v) } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    /// A coarse run that overshoots, and one that finds events and rests from 1 s to 2 s.
    fn courses() -> Table {
        let t: Vec<f64> = (0..40).map(|i| f64::from(i) * 0.1).collect();
        let right = |t: f64| if t < 1.0 { 0.2 * t } else { 0.2 - 0.1 * (t - 2.0).max(0.0) };
        let coarse = t.iter().map(|t| right(*t) + 0.05);
        let theta: Vec<Option<f64>> = coarse.chain(t.iter().map(|t| right(*t))).map(Some).collect();
        let both = |a: Option<f64>, b| (0..80).map(move |i| if i < 40 { a } else { b });
        let columns = vec![
            Column::text(
                "solver",
                "",
                (0..80).map(|i| Some(if i < 40 { "rk4_per_step" } else { "exact" }.to_owned())),
            ),
            Column::float("step_s", "s", "", both(Some(8.3e-3), None)),
            Column::float("t_s", "s", "", t.iter().chain(&t).map(|t| Some(*t))),
            Column::float("theta_rad", "rad", "", theta),
            Column::integer("motion_changes", "1", "", (0..80).map(|_| Some(3))),
        ];
        Table::new("courses", "Courses", columns).unwrap()
    }

    #[test]
    fn the_top_panel_shows_the_time_at_which_the_lever_should_rest() {
        let runs = runs(&courses()).unwrap();
        assert_eq!(runs.len(), 2);
        let (top_deg, from, to) = rest(&runs[1]);
        assert!((top_deg - 0.2_f64.to_degrees()).abs() < 1e-9);
        assert!((from - 0.65).abs() < 0.05 && (to - 2.35).abs() < 0.05, "{from} {to}");
    }

    #[test]
    fn swings_of_a_solver_are_drawn_by_step_and_it_is_said_whether_they_are_felt() {
        let float = |name, unit, values: [Option<f64>; 3]| Column::float(name, unit, "", values);
        let columns = vec![
            Column::text(
                "solver",
                "",
                ["exact", "rk4_per_step", "rk4_per_step"].map(|s| Some(s.to_owned())),
            ),
            float("step_s", "s", [None, Some(1e-3), Some(2e-3)]),
            float("swing_amplitude_rad", "rad", [Some(0.0), Some(1e-3), Some(4e-3)]),
            Column::integer("swings", "1", "", [0, 20, 10].map(Some)),
            Column::integer("reversals", "1", "", [2, 20, 10].map(Some)),
        ];
        let settings = Table::new("trade", "Trade", columns).unwrap();
        let felt = Felt { solver: "rk4_per_step", sentence: "It is felt.".to_owned() };
        let figure = finding(&courses(), &settings, &felt).unwrap();
        assert_eq!((figure.panels.len(), figure.footnotes.len()), (3, 1));
        assert!(zwidth_draw::draw(&figure).is_ok());
        assert_eq!(steps(&settings, "rk4_per_step").unwrap().step_ms, [1.0, 2.0]);
    }
}
