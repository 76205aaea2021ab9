//! Swings of solvers against their step, on logarithmic axes: an oscillation of the method vanishes
//! with its step, one of the model stays.

use crate::words::{logarithms, model_mark, plain, powers_axis};
use zwidth_draw::style::{self, Stroke};
use zwidth_draw::{Cell, Figure, Layer, Line, Panel, Points};
use zwidth_dynamics::NAMED_SOLVERS;
use zwidth_results::ChatteringRun;

/// Height of a panel, mm.
const PANEL_MM: f64 = 55.0;
/// Milliseconds in a second.
const MS_PER_S: f64 = 1e3;

/// The rows of one solver, as they stand on the axes (not yet logarithms).
#[derive(Clone)]
struct Curve {
    name: String,
    stroke: Stroke,
    step_ms: Vec<f64>,
    amplitude_deg: Vec<f64>,
    excess_deg: Vec<f64>,
    reversals: Vec<f64>,
}

/// Amplitude of the swings, largest angle beyond the exact one, and reversals, each against
/// the step. `note` goes below the figure.
pub fn chattering(title: &str, runs: &[ChatteringRun], note: &str) -> Figure {
    let curves = curves(runs);
    let swinging: Vec<&Curve> = curves.iter().filter(|curve| curve.swings()).collect();
    let counted = merged(&curves);
    let counted: Vec<&Curve> = counted.iter().collect();
    let panels = vec![
        panel(0, "amplitude of swings", "°", &swinging, |curve| &curve.amplitude_deg),
        panel(1, "largest angle beyond the exact one", "°", &swinging, |curve| &curve.excess_deg),
        panel(2, "number of reversals", "", &counted, |curve| &curve.reversals),
    ];
    let mut footnotes = vec![plain(note)];
    let still: Vec<&str> = curves.iter().filter(|c| !c.swings()).map(|c| c.name.as_str()).collect();
    if !still.is_empty() {
        footnotes.push(plain(&format!("No oscillation at any step: {}.", still.join(", "))));
    }
    Figure {
        title: Some(plain(title)),
        description: format!(
            "{title}. Against the step, for each solver: median amplitude of the swings, largest angle beyond the exact \
             solver's, number of reversals. All axes are logarithmic."
        ),
        panels,
        footnotes,
        mark: model_mark(),
        ..Figure::default()
    }
}

impl Curve {
    /// Whether it oscillates at any step.
    fn swings(&self) -> bool {
        self.amplitude_deg.iter().any(|amplitude| *amplitude > 0.0)
    }
}

/// Curves without swings that turn equally often lie on each other: they are drawn as one, with all
/// their names.
fn merged(curves: &[Curve]) -> Vec<Curve> {
    let mut merged: Vec<Curve> = Vec::new();
    for curve in curves {
        let mut others = merged.iter_mut().filter(|other| !other.swings() && !curve.swings());
        match others.find(|other| other.reversals == curve.reversals) {
            Some(other) => other.name.push_str(&format!(", {}", curve.name)),
            None => merged.push(curve.clone()),
        }
    }
    merged
}

fn curves(runs: &[ChatteringRun]) -> Vec<Curve> {
    let mut curves = Vec::new();
    for runs in runs.chunk_by(|a, b| a.solver == b.solver) {
        let reversals = runs.iter().map(|run| run.reversals.map_or(f64::NAN, |n| n as f64));
        curves.push(Curve {
            name: words(&runs[0].solver),
            stroke: style::mean(style::INK),
            step_ms: runs.iter().map(|run| MS_PER_S * run.step_s).collect(),
            amplitude_deg: runs.iter().map(|run| degrees(run.swing_amplitude_rad)).collect(),
            excess_deg: runs.iter().map(|run| degrees(run.theta_excess_rad)).collect(),
            reversals: reversals.collect(),
        });
    }
    // Colours and dashes of their own only for those that are told apart: the others share a line.
    for (i, curve) in curves.iter_mut().filter(|curve| curve.swings()).enumerate() {
        curve.stroke = style::mean(style::solver_colour(i + 1)).dashed(style::dash(i));
    }
    curves
}

fn degrees(angle_rad: Option<f64>) -> f64 {
    angle_rad.map_or(f64::NAN, |rad| 1_f64.to_degrees() * rad)
}

/// A panel; where there is nothing to show it says so.
fn panel(
    column: usize,
    label: &str,
    unit: &str,
    curves: &[&Curve],
    pick: fn(&Curve) -> &Vec<f64>,
) -> Panel {
    let layers = curves.iter().flat_map(|curve| {
        let x = logarithms(&curve.step_ms);
        let y = logarithms(pick(curve));
        let stroke = curve.stroke;
        let name = Some(plain(&curve.name));
        let points =
            Points { x: x.clone(), y: y.clone(), colour: stroke.colour, ..Points::default() };
        [Layer::Points(points), Layer::Line(Line { x, y, stroke, name, ..Line::default() })]
    });
    let x = powers_axis("step *h*", "ms").linked("step");
    let y = powers_axis(label, unit);
    // What is 0 has no place on an axis of powers, and an axis without a place no ends.
    let nothing = !curves.iter().flat_map(|curve| pick(curve)).any(|value| *value > 0.0);
    let note = nothing.then(|| "none".to_owned());
    let panel = Panel::new(Cell::at(0, column), x, y, layers.collect()).tall(PANEL_MM);
    Panel { note, ..panel }
}

/// A solver as people write it.
fn words(solver: &str) -> String {
    let named = NAMED_SOLVERS.into_iter().find(|named| named.name == solver);
    named.map_or_else(|| solver.replace('_', " "), |named| named.label.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::Ticks;

    fn run(solver: &str, step_s: f64, swing: f64, excess: f64, turns: usize) -> ChatteringRun {
        ChatteringRun {
            solver: solver.to_owned(),
            step_s,
            reversals: Some(turns),
            theta_max_rad: None,
            theta_excess_rad: Some(excess),
            swings: None,
            swing_amplitude_rad: Some(swing),
            verdict: "smooth".to_owned(),
        }
    }

    fn figure() -> Figure {
        let runs = [
            run("exact", 0.01, 0.0, 0.0, 2),
            run("exact", 0.001, 0.0, 0.0, 2),
            run("moreau_jean", 0.01, 0.0, -1e-3, 2),
            run("moreau_jean", 0.001, 0.0, 1e-6, 2),
            run("rk4_per_step", 0.01, 0.1, 0.1, 30),
            run("rk4_per_step", 0.001, 0.01, 0.01, 300),
        ];
        chattering("Chattering", &runs, "a model")
    }

    #[test]
    fn axes_carry_logarithms_of_milliseconds_and_degrees() {
        let figure = figure();
        let amplitude = figure.panels[0].lines().next().unwrap();
        assert!((amplitude.x[0] - 1.0).abs() < 1e-12 && (amplitude.x[1] - 0.0).abs() < 1e-12);
        assert!((10_f64.powf(amplitude.y[0]) - 0.1_f64.to_degrees()).abs() < 1e-12);
        assert!(
            figure.panels.iter().all(|p| p.x.ticks == Ticks::Powers && p.y.ticks == Ticks::Powers)
        );
    }

    #[test]
    fn a_scene_without_swings_leaves_panels_that_say_so() {
        let figure = chattering("Chattering", &[run("exact", 0.01, 0.0, 0.0, 0)], "a model");
        assert!(figure.panels.iter().all(|panel| panel.note.as_deref() == Some("none")));
        assert!(zwidth_draw::draw(&figure).is_ok());
    }

    #[test]
    fn solvers_that_do_not_swing_share_a_line_of_reversals_and_are_named_below() {
        let figure = figure();
        let names: Vec<_> =
            figure.panels[2].lines().filter_map(|line| line.name.as_deref()).collect();
        assert_eq!(names, ["exact, Moreau–Jean", "RK4, switched per step"]);
        assert_eq!(figure.panels[1].lines().count(), 1);
        assert!(
            figure.footnotes.concat().contains("No oscillation at any step: exact, Moreau–Jean.")
        );
        assert!(figure.mark.unwrap().starts_with("SIMULATION"));
    }
}
