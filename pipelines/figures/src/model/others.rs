//! Other people's simulators beside our solvers: error of the angle against the time of a run.

use crate::words::{logarithm, model_mark, plain, powers_axis};
use zwidth_draw::style;
use zwidth_draw::{Cell, Figure, Layer, Line, Panel, Points, TWO_COLUMNS_MM, Text, TextPlace};
use zwidth_dynamics::NAMED_SOLVERS;
use zwidth_results::{JudgedTrajectory, RunTime, TradeSetting, TrajectoryVerdict};

/// Height of the panel, mm.
const PANEL_MM: f64 = 78.0;
/// Errors below this are drawn at it: rounding, in degrees.
const LEAST_DEG: f64 = 1e-10;
/// Diameter of the point of another program, and of one of ours, pt.
const THEIRS_PT: f64 = 5.0;
const OURS_PT: f64 = 2.0;

/// Largest error of the angle against the time that a run took, on logarithmic axes: our solvers at
/// every step, timed on this machine, and the trajectories of other programs, with the time that is
/// said of them. Each of these has a number, which the footnotes explain; one without a time stands
/// there alone.
pub fn others(
    title: &str,
    settings: &[TradeSetting],
    times: &[RunTime],
    judged: &[JudgedTrajectory],
) -> Figure {
    let mut layers = Vec::new();
    for (number, named) in NAMED_SOLVERS.into_iter().enumerate() {
        let own = settings.iter().filter(|setting| *setting.solver == *named.name);
        let points = own.filter_map(|setting| {
            let time = times.iter().find(|time| {
                time.solver == setting.solver
                    && time.step_s == setting.step_s
                    && time.tolerance == setting.tolerance
            })?;
            Some((logarithm(time.time_s), logarithm(error_deg(setting.theta_error_max_rad?))))
        });
        let (x, y): (Vec<f64>, Vec<f64>) = points.unzip();
        if x.is_empty() {
            continue;
        }
        let stroke = style::single(style::solver_colour(number)).dashed(style::dash(number));
        let name = Some(plain(named.label));
        layers.push(Layer::Line(Line {
            x: x.clone(),
            y: y.clone(),
            stroke,
            name,
            ..Line::default()
        }));
        let colour = stroke.colour;
        layers.push(Layer::Points(Points {
            x,
            y,
            colour,
            diameter_pt: OURS_PT,
            ..Points::default()
        }));
    }
    for (is_right, colour, name) in [
        (true, style::FINGER, "another program: right"),
        (false, style::MARK, "another program: with a fault"),
    ] {
        let these = judged.iter().filter(|one| passes(one) == is_right);
        let (x, y): (Vec<f64>, Vec<f64>) = these.map(place).unzip();
        let name = (!x.is_empty()).then(|| name.to_owned());
        let points = Points { x, y, colour, diameter_pt: THEIRS_PT, name, ..Points::default() };
        layers.push(Layer::Points(points));
    }
    for (number, one) in judged.iter().enumerate() {
        let (x, y) = place(one);
        if x.is_finite() && y.is_finite() {
            let lines = vec![(number + 1).to_string()];
            layers.push(Layer::Text(Text { lines, place: TextPlace::Over(x, y) }));
        }
    }
    let named: Vec<String> = judged
        .iter()
        .enumerate()
        .map(|(number, one)| format!("{} {}", number + 1, words(one)))
        .collect();
    let x = powers_axis("time of a run", "s");
    let y = powers_axis("largest error of *θ*", "°");
    Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}. Largest error of the angle against the time of a run, both logarithmic: our solvers at every step or \
             tolerance, and trajectories of other programs, judged beside the same right answer."
        ),
        width_mm: TWO_COLUMNS_MM,
        panels: vec![Panel::new(Cell::at(0, 0), x, y, layers).tall(PANEL_MM)],
        footnotes: vec![
            plain(&format!("{}.", named.join("; "))),
            "Times of our solvers were measured on the machine that drew this; those of others are as their table says. At \
             the foot: 10⁻¹⁰° or less."
                .to_owned(),
        ],
        mark: model_mark(),
        ..Figure::default()
    }
}

fn passes(one: &JudgedTrajectory) -> bool {
    matches!(one.verdict, TrajectoryVerdict::Right | TrajectoryVerdict::Stands)
}

/// Where it stands on the axes; nowhere without a time.
fn place(one: &JudgedTrajectory) -> (f64, f64) {
    (one.cost_s.map_or(f64::NAN, logarithm), logarithm(error_deg(one.theta_error_max_rad)))
}

fn error_deg(rad: f64) -> f64 {
    rad.to_degrees().max(LEAST_DEG)
}

/// A program, its setting and its verdict.
fn words(one: &JudgedTrajectory) -> String {
    let name = one.engine.as_deref().unwrap_or(&one.trajectory);
    let setting = one.setting.as_deref().filter(|setting| !setting.is_empty());
    let setting = setting.map_or(String::new(), |setting| format!(", {setting}"));
    let time = if one.cost_s.is_none() { " (no time)" } else { "" };
    format!("{name}{setting}: {}{time}", one.verdict.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::trade_setting;
    use zwidth_results::Proof;

    fn judged(verdict: TrajectoryVerdict, cost_s: Option<f64>) -> JudgedTrajectory {
        JudgedTrajectory {
            scene: "s".into(),
            trajectory: "t.csv".into(),
            engine: Some("an engine".into()),
            setting: None,
            cost_s,
            verdict,
            faults: 0,
            yardstick: Proof::Proven,
            by: "exact".into(),
            samples: 100,
            step_s: 1e-3,
            theta_resolution_rad: 1e-16,
            theta_dot_resolution_rad_s: 1e-16,
            velocity_computed: false,
            theta_error_max_rad: 1e-2,
            theta_error_rms_rad: 1e-2,
            theta_dot_error_max_rad_s: 0.0,
            theta_dot_error_rms_rad_s: 0.0,
            force_error_max_n: 0.0,
            force_error_rms_n: 0.0,
            impulse_error_ns: 0.0,
            peak_error_rad: 0.0,
            input_error_max_n: None,
            event_error_s: None,
            felt_force_share: 0.0,
            felt_angle_share: 0.0,
            felt_vibration_share: None,
            is_felt: false,
            creep_rad_s: None,
            energy_residual_j: None,
            energy_bound_j: None,
            energy_scale_j: None,
        }
    }

    #[test]
    fn each_program_has_its_number_and_one_without_a_time_stands_in_the_footnote_alone() {
        let time = RunTime {
            solver: "exact".into(),
            step_s: None,
            tolerance: None,
            work: 1,
            time_s: 1e-4,
            time_low_s: 1e-4,
            time_high_s: 1e-4,
            time_share: 1e-4,
        };
        let exact = TradeSetting { theta_error_max_rad: Some(0.0), ..trade_setting("exact") };
        let all =
            [judged(TrajectoryVerdict::Creeps, Some(1e-2)), judged(TrajectoryVerdict::Right, None)];
        let figure = others("s", &[exact], &[time], &all);
        assert!(zwidth_draw::draw(&figure).is_ok());
        let texts = figure.panels[0].layers.iter().filter(|layer| matches!(layer, Layer::Text(_)));
        assert_eq!(texts.count(), 1);
        let note = &figure.footnotes[0];
        assert!(
            note.contains("1 an engine: creeps") && note.contains("2 an engine: right (no time)"),
            "{note}"
        );
    }
}
