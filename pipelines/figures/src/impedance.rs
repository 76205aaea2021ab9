//! The Z-width of a device: the stiffest wall against its damping, mode by mode, a panel a push.

use crate::words::{mark, plain};
use zwidth_draw::style::{self, Dash, Marker};
use zwidth_draw::{
    Axis, Cell, Direction, Figure, Intervals, Layer, Line, Panel, Text, TextPlace, Ticks,
};
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// Height of a panel, mm.
const PANEL_MM: f64 = 70.0;

/// `bounds` is the table of a Z-width test, `linear` the boundary (B, K) of the lifted map, the
/// limit of large pushes; `synthetic` says that the device was simulated.
///
/// # Errors
/// A table that lacks a column.
pub fn impedance(
    bounds: &Table,
    linear: &[[f64; 2]],
    notes: &[String],
    synthetic: bool,
) -> Result<Figure, TableError> {
    let mut pushes: Vec<f64> = bounds.floats("push_m")?.into_iter().flatten().collect();
    pushes.sort_by(|a, b| b.total_cmp(a));
    pushes.dedup_by(|a, b| a.to_bits() == b.to_bits());
    let panels = pushes.iter().enumerate().map(|(i, push_m)| panel(bounds, linear, i, *push_m));
    Ok(Figure {
        title: Some(plain(bounds.title())),
        description: "The stiffest wall without oscillation that goes on, against the wall's damping, for each mode, \
                      with intervals; at least so stiff where an actuator saturated first. Dashed: the limit of \
                      large pushes, from the lifted map."
            .to_owned(),
        panels: panels.collect::<Result<_, _>>()?,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark: if synthetic { mark([Source::Twin]) } else { None },
        ..Figure::default()
    })
}

fn panel(
    bounds: &Table,
    linear: &[[f64; 2]],
    number: usize,
    push_m: f64,
) -> Result<Panel, TableError> {
    let (modes, pushes) = (bounds.texts("mode")?, bounds.floats("push_m")?);
    let float = |name| bounds.floats(name);
    let (damping, stiffness) = (float("damping_ns_per_m")?, float("stiffness_n_per_m")?);
    let (low, high) = (float("ci_low")?, float("ci_high")?);
    let censored = bounds.flags("is_censored")?;
    let is_push = |i: usize| pushes[i].is_some_and(|push| push.to_bits() == push_m.to_bits());
    let log = |value: Option<f64>| value.filter(|x| *x > 0.0).map_or(f64::NAN, libm::log10);
    let mut layers = vec![Layer::Line(Line {
        x: linear.iter().map(|p| p[0]).collect(),
        y: linear.iter().map(|p| log(Some(p[1]))).collect(),
        stroke: style::single(style::INK).dashed(Dash::Dashed),
        name: Some("large push (lifted map)".to_owned()),
        ..Line::default()
    })];
    let mut names: Vec<&String> = modes.iter().flatten().collect();
    let mut seen = Vec::new();
    names.retain(|name| {
        let new = !seen.contains(name);
        seen.push(name);
        new
    });
    for (k, name) in names.into_iter().enumerate() {
        let rows: Vec<usize> = (0..bounds.height())
            .filter(|i| is_push(*i) && modes[*i].as_ref() == Some(name))
            .collect();
        let of = |values: &[Option<f64>]| rows.iter().map(|i| log(values[*i])).collect::<Vec<_>>();
        layers.push(Layer::Intervals(Intervals {
            direction: Direction::Vertical,
            at: rows.iter().map(|i| damping[*i].unwrap_or(f64::NAN)).collect(),
            estimate: of(&stiffness),
            low: of(&low),
            high: of(&high),
            colour: style::mode_colour(k),
            marker: Marker::default(),
            name: Some(plain(name)),
        }));
        let at_least = rows.iter().filter(|i| censored[**i] == Some(true));
        layers.extend(at_least.filter_map(|i| {
            let place = TextPlace::Over(damping[*i]?, log(stiffness[*i]));
            Some(Layer::Text(Text { lines: vec!["≥".to_owned()], place }))
        }));
    }
    let letter = char::from(b'a' + (number % 26) as u8);
    let x = Axis::new("wall damping *B*", "N s/m").linked("damping");
    let y =
        Axis { ticks: Ticks::Powers, ..Axis::new("stiffest wall *K*", "N/m") }.linked("stiffness");
    let title = format!("**{letter}**  push of {} mm", 1e3 * push_m);
    let panel = Panel::new(Cell::at(0, number), x, y, layers).titled(title);
    Ok(Panel { height_mm: Some(PANEL_MM), ..panel })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;
    use zwidth_tables::Column;

    #[test]
    fn a_panel_a_push_and_what_is_censored_says_at_least() {
        let float = |name, values: [f64; 3]| Column::float(name, "", "", values.map(Some));
        let columns = vec![
            Column::text("mode", "", ["active", "active", "hybrid"].map(|m| Some(m.to_owned()))),
            float("push_m", [5e-3, 1e-3, 5e-3]),
            float("damping_ns_per_m", [0.0, 0.0, 1.0]),
            float("stiffness_n_per_m", [768.0, 1148.0, 832.0]),
            float("ci_low", [760.0, 1140.0, 832.0]),
            float("ci_high", [776.0, 1155.0, 832.0]),
            Column::flag("is_censored", "", [false, false, true].map(Some)),
        ];
        let table = Table::new("bounds", "Stiffest wall", columns).unwrap();
        let figure = impedance(&table, &[[0.0, 651.0], [1.0, 800.0]], &[], true).unwrap();
        assert_eq!(figure.panels.len(), 2);
        let words =
            |panel: &Panel| panel.layers.iter().filter(|l| matches!(l, Layer::Text(_))).count();
        assert_eq!([words(&figure.panels[0]), words(&figure.panels[1])], [1, 0]);
        assert!(figure.mark.as_deref().is_some_and(|mark| mark.starts_with("SYNTHETIC")));
        draw(&figure).unwrap();
    }
}
