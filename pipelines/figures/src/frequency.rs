//! Impedance against frequency with its coherence, an environment a column.

use crate::words::plain;
use zwidth_draw::style;
use zwidth_draw::{Axis, Band, Cell, Figure, Layer, Line, Panel, Range, Ticks};
use zwidth_tables::{Table, TableError};

/// Height of a panel, mm.
const PANEL_MM: f64 = 46.0;

/// What a panel shows.
#[derive(Clone, Copy, PartialEq)]
enum Shows {
    Magnitude,
    Phase,
    Coherence,
}

/// One mode of an environment, as it stands on the axes.
struct Curve {
    mode: String,
    frequency: Vec<f64>,
    /// NaN where the coherence may be chance.
    magnitude: Vec<[f64; 3]>,
    phase: Vec<[f64; 3]>,
    coherence: Vec<f64>,
    chance: Vec<f64>,
}

/// |Z|, phase and coherence against frequency; `responses` is the table of responses. Where the coherence
/// may be chance, |Z| and phase are not drawn.
///
/// # Errors
/// A table that lacks a column.
pub fn impedance_frequency(
    responses: &Table,
    notes: &[String],
    mark: Option<String>,
) -> Result<Figure, TableError> {
    let environments = distinct(&responses.texts("environment")?);
    let mut panels = Vec::new();
    for (column, environment) in environments.iter().enumerate() {
        let curves = curves(responses, environment)?;
        let all = [Shows::Magnitude, Shows::Phase, Shows::Coherence];
        panels.extend(all.into_iter().enumerate().map(|(row, shows)| {
            let panel = panel(&curves, shows, Cell::at(row, column));
            let letter = char::from(b'a' + ((row * environments.len() + column) % 26) as u8);
            let of = if row == 0 { plain(environment) } else { String::new() };
            panel.titled(format!("**{letter}**  {of}"))
        }));
    }
    Ok(Figure {
        title: Some(plain(responses.title())),
        description: "Size and phase of the impedance that a user feels at the lever's end, force over velocity, and \
                      their coherence, against frequency, for each mode; bands are intervals."
            .to_owned(),
        panels,
        footnotes: notes.iter().map(|note| plain(note)).collect(),
        mark,
        ..Figure::default()
    })
}

fn distinct(words: &[Option<String>]) -> Vec<String> {
    let mut seen: Vec<String> = Vec::new();
    for word in words.iter().flatten() {
        if !seen.contains(word) {
            seen.push(word.clone());
        }
    }
    seen
}

fn curves(table: &Table, environment: &str) -> Result<Vec<Curve>, TableError> {
    let (environments, modes) = (table.texts("environment")?, table.texts("mode")?);
    let float = |name| table.floats(name);
    let frequency = float("frequency_hz")?;
    let (size, low, high) = (float("magnitude_ns_per_m")?, float("ci_low")?, float("ci_high")?);
    let (phase, half) = (float("phase_rad")?, float("phase_half_interval_rad")?);
    let (coherence, chance) = (float("coherence")?, float("chance")?);
    let is_here = |i: &usize| environments[*i].as_deref() == Some(environment);
    let here: Vec<usize> = (0..table.height()).filter(is_here).collect();
    let own: Vec<Option<String>> = here.iter().map(|i| modes[*i].clone()).collect();
    let curve = |mode: String| {
        let rows: Vec<usize> =
            here.iter().copied().filter(|i| modes[*i].as_ref() == Some(&mode)).collect();
        let known = |i: &usize| coherence[*i] > chance[*i];
        let log = |value: Option<f64>| value.filter(|v| *v > 0.0).map_or(f64::NAN, libm::log10);
        let degrees = |value: Option<f64>| value.map_or(f64::NAN, f64::to_degrees);
        let magnitude = |i: &usize| match known(i) {
            true => [log(size[*i]), log(low[*i]), log(high[*i])],
            false => [f64::NAN; 3],
        };
        let turned = |i: &usize| match known(i) {
            true => {
                let (at, by) = (degrees(phase[*i]), degrees(half[*i]).min(180.0));
                [at, at - by, at + by]
            }
            false => [f64::NAN; 3],
        };
        let value = |values: &[Option<f64>]| -> Vec<f64> {
            rows.iter().map(|i| values[*i].unwrap_or(f64::NAN)).collect()
        };
        Curve {
            frequency: rows.iter().map(|i| log(frequency[*i])).collect(),
            magnitude: rows.iter().map(magnitude).collect(),
            phase: rows.iter().map(turned).collect(),
            coherence: value(&coherence),
            chance: value(&chance),
            mode,
        }
    };
    Ok(distinct(&own).into_iter().map(curve).collect())
}

fn panel(curves: &[Curve], shows: Shows, cell: Cell) -> Panel {
    let mut layers = Vec::new();
    for (i, curve) in curves.iter().enumerate() {
        let colour = style::mode_colour(i);
        let name = Some(plain(&curve.mode));
        let x = || curve.frequency.clone();
        let part = |values: &[[f64; 3]], at: usize| values.iter().map(|v| v[at]).collect();
        let values = match shows {
            Shows::Magnitude => &curve.magnitude,
            Shows::Phase => &curve.phase,
            Shows::Coherence => {
                let line = |y: &[f64], stroke, name| {
                    Layer::Line(Line { x: x(), y: y.to_vec(), stroke, name, ..Line::default() })
                };
                layers.push(line(&curve.coherence, style::mean(colour), name));
                let dotted = style::single(colour).dashed(style::Dash::Dotted);
                layers.push(line(&curve.chance, dotted, None));
                continue;
            }
        };
        layers.push(Layer::Band(Band {
            x: x(),
            low: part(values, 1),
            high: part(values, 2),
            colour,
            name: name.clone(),
        }));
        let y = part(values, 0);
        layers.push(Layer::Line(Line {
            x: x(),
            y,
            stroke: style::mean(colour),
            name,
            ..Line::default()
        }));
    }
    let x = Axis { ticks: Ticks::Powers, ..Axis::new("frequency", "Hz") }.linked("frequency");
    let y = match shows {
        Shows::Magnitude => {
            Axis { ticks: Ticks::Powers, ..Axis::new("|*Z*|", "N s/m") }.linked("magnitude")
        }
        Shows::Phase => Axis::new("phase of *Z*", "°").ranged(Range::Fixed(-200.0, 200.0)),
        Shows::Coherence => Axis::new("coherence *γ*²", "").ranged(Range::Fixed(0.0, 1.0)),
    };
    Panel { height_mm: Some(PANEL_MM), ..Panel::new(cell, x, y, layers) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_draw::draw;
    use zwidth_tables::Column;

    #[test]
    fn three_panels_an_environment_and_chance_is_not_drawn() {
        let float = |name, values: [f64; 4]| Column::float(name, "", "", values.map(Some));
        let text = |name, values: [&str; 4]| {
            Column::text(name, "", values.map(|value| Some(value.to_owned())))
        };
        let columns = vec![
            text("environment", ["spring", "spring", "spring", "wall"]),
            text("mode", ["active", "active", "hybrid", "active"]),
            float("frequency_hz", [1.0, 2.0, 1.0, 1.0]),
            float("magnitude_ns_per_m", [10.0, 5.0, 8.0, 9.0]),
            float("ci_low", [9.0, 4.0, 0.0, 8.0]),
            float("ci_high", [11.0, 6.0, 9.0, 10.0]),
            float("phase_rad", [-1.5, -1.4, -1.0, -1.0]),
            float("phase_half_interval_rad", [0.1, 0.1, 0.1, 0.1]),
            float("coherence", [0.9, 0.1, 0.8, 0.7]),
            float("chance", [0.2, 0.2, 0.2, 0.2]),
        ];
        let table = Table::new("frequency", "Impedance against frequency", columns).unwrap();
        let figure = impedance_frequency(&table, &[], None).unwrap();
        assert_eq!(figure.panels.len(), 6);
        let Layer::Line(line) = &figure.panels[0].layers[1] else { panic!("no line") };
        assert!((line.y[0] - 1.0).abs() < 1e-12 && line.y[1].is_nan());
        draw(&figure).unwrap();
    }
}
