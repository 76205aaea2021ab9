//! A recorded oscillation beside that of its loop run again.

use crate::course::replay::RECORDED;
use crate::words::plain;
use zwidth_draw::style;
use zwidth_draw::{Axis, Cell, Figure, Layer, Line, Panel, Range};

/// Height of a panel, mm.
const PANEL_MM: f64 = 60.0;
/// What is shown of a trial: so many periods either side of the swings.
const PERIODS: f64 = 6.0;
/// The names of the courses.
const NAMES: [&str; 3] =
    ["recorded", "loop with the user's force", "loop with its slow part alone"];

/// θ (rad) against time (s): as recorded, of the loop with the user's force, and with the slow part
/// of that alone, about the swings.
pub fn oscillation(
    courses: &[(&[f64], &[f64])],
    [from_s, to_s]: [f64; 2],
    period_s: f64,
    notes: &[String],
    mark: Option<String>,
) -> Figure {
    let from_s = (from_s - PERIODS * period_s).max(0.0);
    let to_s = to_s + PERIODS * period_s;
    let mut layers = Vec::new();
    for (i, (t_s, theta_rad)) in courses.iter().enumerate() {
        let inside = t_s.iter().zip(*theta_rad).filter(|(t, _)| (from_s..=to_s).contains(*t));
        let (x, y) = inside.map(|(t, theta)| (*t, theta.to_degrees())).unzip();
        let name = NAMES.get(i).map(|name| (*name).to_owned());
        // Broad and pale below what is run again, which must be told apart where it lies on it.
        let stroke = match i {
            0 => RECORDED,
            _ => style::single(style::environment_colour(i - 1)).dashed(style::dash(i - 1)),
        };
        layers.push(Layer::Line(Line { x, y, name, stroke, ..Line::default() }));
    }
    let x = Axis::new("time", "s").ranged(Range::Fixed(from_s, to_s));
    let y = Axis::new("lever angle *θ*", "°");
    Figure {
        title: Some("A recorded oscillation, and the loop run again".to_owned()),
        description: "Lever angle against time about a recorded oscillation: as recorded, of the loop of device and \
                      controller with the user's recorded force, and with the slow part of that force alone."
            .to_owned(),
        panels: vec![Panel::new(Cell::at(0, 0), x, y, layers).tall(PANEL_MM)],
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark,
        ..Figure::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_about_the_swings_is_drawn_with_its_name() {
        let t: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.01).collect();
        let y: Vec<f64> = t.iter().map(|t| libm::sin(50.0 * t)).collect();
        let figure = oscillation(&[(&t[..], &y[..]); 3], [1.0, 2.0], 0.125, &[], None);
        let lines: Vec<&Line> = figure.panels[0].lines().collect();
        assert_eq!((lines[0].name.as_deref(), lines[0].x.len()), (Some("recorded"), 251));
        assert_eq!((lines.len(), figure.panels[0].layers.len()), (3, 3));
        assert!(lines[1].stroke.dash != lines[2].stroke.dash, "told apart without colour");
        zwidth_draw::draw(&figure).unwrap();
    }
}
