//! Figures 22 and 23: what came of a command, every sweep, with the chosen fit and its bands.

use crate::data::gaps;
use crate::words::{mark, percent, plain};
use zwidth_draw::style::{self, Colour};
use zwidth_draw::{Axis, Band, Cell, Figure, Layer, Line, Panel, Points, Text, TextPlace};
use zwidth_store::{Quantity, Sweep};
use zwidth_tables::{Table, TableError};

/// Width of the figure, mm.
const WIDTH_MM: f64 = 110.0;
/// Height of its panel, mm.
const PANEL_MM: f64 = 65.0;
/// More points than this hide one another: they are drawn smaller and paler.
const MANY_POINTS: usize = 1000;

/// The characteristic of one actuator or sensor. `models` and `curve` are the stage's tables, `level` the level of their intervals.
pub fn characteristic(
    actuator: &str,
    sweeps: &[Sweep],
    models: &Table,
    curve: &Table,
    level: f64,
) -> Result<Figure, TableError> {
    let quantity = |of: fn(&Sweep) -> &Quantity| sweeps.first().map(of).cloned().unwrap_or_else(nothing);
    let (command, response) = (quantity(|s| &s.command), quantity(|s| &s.response));
    let mut layers = vec![points(sweeps)];
    layers.extend(fit(curve, level, style::mode_colour(0))?);
    let lines = about(models, &response.unit)?;
    layers.push(Layer::Text(Text { lines, place: TextPlace::EmptiestCorner }));
    let panel = Panel::new(Cell::at(0, 0), axis(&command), axis(&response), layers);
    Ok(Figure {
        title: Some(format!("Characteristic: {}", actuator.replace('_', " "))),
        description: format!(
            "{} against {} of the {actuator}, {} sweeps, with the chosen fit, the band of its mean and the band for a \
             new response.",
            response.name,
            command.name,
            sweeps.len()
        ),
        width_mm: WIDTH_MM,
        panels: vec![Panel { height_mm: Some(PANEL_MM), ..panel }],
        mark: mark(sweeps.iter().map(|s| s.source)),
        ..Figure::default()
    })
}

/// A plain formula as markup: `max(x - x0, 0)^p` → *max*(x − x₀, 0)ᵖ.
fn typeset(formula: &str) -> String {
    formula.replace(" - ", " − ").replace("x0", "x_{0}").replace("^p", "^{p}")
}

fn nothing() -> Quantity {
    Quantity { name: String::new(), unit: String::new() }
}

/// The chosen model and its error, in words.
fn about(models: &Table, unit: &str) -> Result<Vec<String>, TableError> {
    let (verdicts, formulas) = (models.texts("verdict")?, models.texts("formula")?);
    let (names, rms) = (models.texts("model")?, models.floats("rms")?);
    let is_chosen = |v: &Option<String>| v.as_deref().is_some_and(|v| v.starts_with("chosen"));
    let Some(row) = verdicts.iter().position(is_chosen) else { return Ok(Vec::new()) };
    let mut lines = vec![format!("chosen: {}", names[row].as_deref().unwrap_or_default().replace('_', " "))];
    lines.extend(formulas[row].as_deref().map(typeset));
    lines.extend(rms[row].map(|rms| format!("RMS {rms:.3} {unit}")));
    Ok(lines)
}

fn axis(quantity: &Quantity) -> Axis {
    Axis::new(plain(&quantity.name), plain(&quantity.unit))
}

fn points(sweeps: &[Sweep]) -> Layer {
    let all = |values: fn(&Sweep) -> &Vec<f64>| sweeps.iter().flat_map(values).copied().collect::<Vec<f64>>();
    let x = all(|s| &s.command_values);
    let many = x.len() > MANY_POINTS;
    Layer::Points(Points {
        y: all(|s| &s.response_values),
        x,
        colour: style::GREY,
        opacity: if many { 0.25 } else { 0.6 },
        diameter_pt: if many { 1.4 } else { style::POINT_PT },
        name: Some("samples".to_owned()),
    })
}

fn fit(curve: &Table, level: f64, colour: Colour) -> Result<Vec<Layer>, TableError> {
    let column = |name: &str| Ok::<_, TableError>(gaps(curve.floats(name)?));
    let x = column("command")?;
    let band = |low: &str, high: &str, name: &str| {
        let (low, high) = (column(low)?, column(high)?);
        Ok::<_, TableError>(Layer::Band(Band {
            x: x.clone(),
            low,
            high,
            colour,
            name: Some(name.to_owned()),
        }))
    };
    let line = |name: &str, label: &str, stroke| {
        let y = column(name)?;
        Ok::<_, TableError>(Layer::Line(Line {
            x: x.clone(),
            y,
            stroke,
            name: Some(label.to_owned()),
            ..Line::default()
        }))
    };
    let first_order = style::reference();
    Ok(vec![
        band("prediction_low", "prediction_high", &format!("{} prediction band", percent(level)))?,
        line("first_order", "first-order fit", first_order)?,
        line("fit", "chosen fit", style::mean(colour))?,
    ])
}
