//! Figure 31: the bow tie of two actuators of unequal strength, on a lever whose motion is given.

use crate::about::FigureKind;
use crate::words::{Words, model_mark, plain};
use zwidth_draw::style::{self, Dash, Stroke};
use zwidth_draw::{Axis, Cell, Direction, Figure, Layer, Line, ONE_COLUMN_MM, Panel, Reference};
use zwidth_results::BowTieSample;
use zwidth_study::Coordinate;

/// The bow tie of a scene of the model.
pub const SCENE_BOW_TIE: FigureKind = FigureKind::new(
    "scenes",
    "forces of two unequal actuators along the way there and back",
    "scene",
);

/// Height of the panel, mm.
const PANEL_MM: f64 = 60.0;
/// Width of the pens of brake and motor, pt: they show on both sides of the total's, which lies
/// over them.
const UNDER_PT: f64 = 3.0;

/// Force against angle of one stroke there and back: total black, brake dotted, motor dashed; the
/// force shown is the one felt by the hand, which resists. `note` goes below the figure.
pub fn bow_tie(scene: &str, samples: &[BowTieSample], note: &str) -> Figure {
    let words = Words::new(Coordinate::Rotational);
    let theta = words.positions(samples.iter().map(|sample| Some(sample.theta_rad)));
    let mut layers = [Direction::Horizontal, Direction::Vertical]
        .map(|direction| Layer::Reference(Reference::new(direction, 0.0, style::reference())))
        .to_vec();
    let brake = acting(samples.iter().map(|sample| -sample.force_brake_n));
    let motor = acting(samples.iter().map(|sample| -sample.force_motor_n));
    let total: Vec<f64> = samples.iter().map(|sample| -sample.force_total_n).collect();
    for (name, y, colour, dash) in [
        ("brake (stronger)", brake, style::BRAKE, Dash::Dotted),
        ("motor (weaker)", motor, style::MOTOR, Dash::Dashed),
    ] {
        let stroke = Stroke { width_pt: UNDER_PT, dash, ..style::mean(colour) };
        let name = Some(name.to_owned());
        layers.push(Layer::Line(Line { x: theta.clone(), y, stroke, name, ..Line::default() }));
    }
    layers.push(Layer::Line(Line {
        x: closed(&theta),
        y: closed(&total),
        stroke: style::single(style::INK),
        name: Some("total".to_owned()),
        ..Line::default()
    }));
    let y = Axis::new("resisting force *F*", "N");
    let panel = Panel::new(Cell::at(0, 0), words.position_axis(), y, layers).tall(PANEL_MM);
    Figure {
        title: Some(plain(scene)),
        description: format!(
            "{scene}: resisting force against angle of one stroke there and back. The total, and what brake and motor make \
             of it; where they change over, the force jumps."
        ),
        width_mm: ONE_COLUMN_MM,
        panels: vec![panel],
        footnotes: vec![plain(note)],
        mark: model_mark(),
        ..Figure::default()
    }
}

/// The stroke ends where it began.
fn closed(values: &[f64]) -> Vec<f64> {
    values.iter().chain(values.first()).copied().collect()
}

/// An actuator that makes no force is not drawn.
fn acting(forces: impl Iterator<Item = f64>) -> Vec<f64> {
    forces.map(|force| if force.abs() > 0.0 { force } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_force_is_the_one_that_resists_an_idle_actuator_leaves_a_gap_and_the_total_is_closed() {
        let sample = |force_brake_n: f64, force_motor_n: f64| BowTieSample {
            t_s: 0.0,
            theta_rad: 0.5,
            theta_dot_rad_s: 1.0,
            force_ex_n: 0.0,
            force_total_n: force_brake_n + force_motor_n,
            force_brake_n,
            force_motor_n,
        };
        let figure = bow_tie("Bow tie", &[sample(-3.0, 0.0), sample(0.0, -1.0)], "a model");
        let lines: Vec<&Line> = figure.panels[0].lines().collect();
        assert_eq!((lines[0].y[0], lines[0].stroke.dash), (3.0, Dash::Dotted));
        assert_eq!((lines[1].y[1], lines[1].stroke.dash), (1.0, Dash::Dashed));
        assert!(lines[0].y[1].is_nan() && lines[1].y[0].is_nan());
        assert_eq!(lines[2].y, [3.0, 1.0, 3.0]);
        assert!(figure.mark.unwrap().starts_with("SIMULATION"));
    }
}
