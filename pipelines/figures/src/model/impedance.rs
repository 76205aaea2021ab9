//! The Z-width of a device: the stiffest wall against its damping, mode by mode, one panel per
//! push.

use crate::words::{distinct, lettered, logarithm, mark, plain, powers_axis};
use zwidth_draw::style::{self, Dash};
use zwidth_draw::{Axis, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Text, TextPlace};
use zwidth_results::{Row, WallBound};
use zwidth_study::Source;

/// Height of a panel, mm.
const PANEL_MM: f64 = 70.0;

/// `bounds` are those of a Z-width test, `linear` the boundary (B, K) of the lifted map, the
/// limit of large pushes; `synthetic` says that the device was simulated.
pub fn impedance(
    bounds: &[WallBound],
    linear: &[[f64; 2]],
    notes: &[String],
    synthetic: bool,
) -> Figure {
    let mut pushes: Vec<f64> = bounds.iter().map(|bound| bound.push_m).collect();
    // The largest first: the lifted map is the limit of large pushes.
    pushes.sort_by(|a, b| b.total_cmp(a));
    pushes.dedup_by(|a, b| a.to_bits() == b.to_bits());
    let panels = pushes.iter().enumerate().map(|(i, push_m)| panel(bounds, linear, i, *push_m));
    Figure {
        title: Some(plain(WallBound::TITLE)),
        description: "The stiffest wall without oscillation that goes on, against the wall's damping, for each mode, \
                      with intervals; at least so stiff where an actuator saturated first. Dashed: the limit of \
                      large pushes, from the lifted map."
            .to_owned(),
        panels: panels.collect(),
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: if synthetic { mark([Source::Twin]) } else { None },
        ..Figure::default()
    }
}

fn panel(bounds: &[WallBound], linear: &[[f64; 2]], number: usize, push_m: f64) -> Panel {
    let mut layers = vec![Layer::Line(Line {
        x: linear.iter().map(|p| p[0]).collect(),
        y: linear.iter().map(|p| logarithm(p[1])).collect(),
        stroke: style::single(style::INK).dashed(Dash::Dashed),
        name: Some("large push (lifted map)".to_owned()),
        ..Line::default()
    })];
    for (k, mode) in distinct(bounds.iter().map(|bound| &bound.mode)).iter().enumerate() {
        let own: Vec<&WallBound> = bounds
            .iter()
            .filter(|bound| bound.push_m.to_bits() == push_m.to_bits() && bound.mode == *mode)
            .collect();
        let at = own.iter().map(|bound| bound.damping_ns_per_m).collect();
        let logarithms = |pick: fn(&WallBound) -> f64| -> Vec<f64> {
            own.iter().map(|bound| logarithm(pick(bound))).collect()
        };
        let ends = [
            logarithms(|bound| bound.stiffness_n_per_m),
            logarithms(|bound| bound.ci_low),
            logarithms(|bound| bound.ci_high),
        ];
        layers.push(Layer::Intervals(Intervals {
            colour: style::mode_colour(k),
            name: Some(plain(mode)),
            ..Intervals::new(Direction::Vertical, at, ends)
        }));
        layers.extend(own.iter().filter(|bound| bound.is_censored).map(|bound| {
            let stiffness = logarithm(bound.stiffness_n_per_m);
            let place = TextPlace::Over(bound.damping_ns_per_m, stiffness);
            Layer::Text(Text { lines: vec!["≥".to_owned()], place })
        }));
    }
    let x = Axis::new("wall damping *B*", "N s/m").linked("damping");
    let y = powers_axis("stiffest wall *K*", "N/m").linked("stiffness");
    let title = lettered(number, &format!("push of {} mm", 1e3 * push_m));
    Panel::new(Cell::at(0, number), x, y, layers).titled(title).tall(PANEL_MM)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;

    #[test]
    fn a_panel_a_push_and_what_is_censored_says_at_least() {
        let bound = |mode: &str, push_m, damping_ns_per_m, stiffness_n_per_m, is_censored| {
            let off = if is_censored { 0.0 } else { 8.0 };
            WallBound {
                mode: mode.into(),
                push_m,
                damping_ns_per_m,
                stiffness_n_per_m,
                ci_low: stiffness_n_per_m - off,
                ci_high: stiffness_n_per_m + off,
                is_censored,
                repeats: 3,
            }
        };
        let bounds = [
            bound("active", 5e-3, 0.0, 768.0, false),
            bound("active", 1e-3, 0.0, 1148.0, false),
            bound("hybrid", 5e-3, 1.0, 832.0, true),
        ];
        let figure = impedance(&bounds, &[[0.0, 651.0], [1.0, 800.0]], &[], true);
        assert_eq!(figure.panels.len(), 2);
        let words =
            |panel: &Panel| panel.layers.iter().filter(|l| matches!(l, Layer::Text(_))).count();
        assert_eq!([words(&figure.panels[0]), words(&figure.panels[1])], [1, 0]);
        assert!(figure.mark.as_deref().is_some_and(|mark| mark.starts_with("SYNTHETIC")));
        draw(&figure).unwrap();
    }
}
