//! A characteristic in words: what stands under its figure.

use super::Characterised;
use crate::words::plain;
use zwidth_tables::{Table, TableError};

/// Name of the chosen model; empty without one.
pub(super) fn chosen(models: &Table) -> Result<String, TableError> {
    let (names, verdicts) = (models.texts("model")?, models.texts("verdict")?);
    let row = verdicts
        .iter()
        .position(|verdict| verdict.as_deref().is_some_and(|v| v.starts_with("chosen")));
    Ok(row.and_then(|row| names[row].clone()).unwrap_or_default())
}

/// The row of a model in the table of models.
pub(super) fn row_of(models: &Table, name: &str) -> Result<Option<usize>, TableError> {
    Ok(models.texts("model")?.iter().position(|n| n.as_deref() == Some(name)))
}

/// A parameter of the chosen model, as its table says it.
pub(super) struct Parameter {
    pub(super) symbol: String,
    pub(super) branch: String,
    pub(super) estimate: f64,
    interval: Option<(f64, f64)>,
    pub(super) unit: String,
    pub(super) note: String,
}

pub(super) fn parameters(table: &Table, model: &str) -> Result<Vec<Parameter>, TableError> {
    let names = ["model", "parameter", "branch", "unit", "note"];
    let texts = names.iter().map(|name| table.texts(name)).collect::<Result<Vec<_>, _>>()?;
    let names = ["estimate", "ci_low", "ci_high"];
    let numbers = names.iter().map(|name| table.floats(name)).collect::<Result<Vec<_>, _>>()?;
    let text = |column: usize, row: usize| texts[column][row].clone().unwrap_or_default();
    let parameter = |row: usize| {
        Some(Parameter {
            symbol: text(1, row),
            branch: text(2, row),
            unit: text(3, row),
            note: text(4, row),
            estimate: numbers[0][row]?,
            interval: numbers[1][row].zip(numbers[2][row]),
        })
    };
    Ok((0..table.height()).filter(|&row| text(0, row) == model).filter_map(parameter).collect())
}

/// The chosen model with its parameters and error, and the first-order fit, in words.
pub(super) fn about(
    of: Characterised,
    chosen: &str,
    unit: &str,
) -> Result<Vec<String>, TableError> {
    let Some(row) = row_of(of.models, chosen)? else { return Ok(Vec::new()) };
    let formula = of.models.texts("formula")?[row].as_deref().map(typeset).unwrap_or_default();
    let is_told = |p: &&Parameter| p.note.is_empty() && !p.symbol.starts_with('s');
    let mut words =
        vec![format!("Chosen: {}, {formula}", chosen.replace("_up_down", "").replace('_', " "))];
    words.extend(parameters(of.parameters, chosen)?.iter().filter(is_told).map(estimate));
    words.extend(
        of.models.floats("rms")?[row]
            .map(|rms| format!("RMS {} {}", significant(rms), plain(unit))),
    );
    let mut notes = vec![format!("{}.", words.join("; "))];
    let line: Vec<String> = parameters(of.parameters, "line")?.iter().map(estimate).collect();
    if chosen != "line" && !line.is_empty() {
        notes.push(format!("First order: y = a + b x; {}.", line.join("; ")));
    }
    Ok(notes)
}

/// `b = 1.856 [1.840, 1.868] N/V`: decimals for two significant digits of half the interval.
fn estimate(p: &Parameter) -> String {
    let way = if p.branch == "both" { String::new() } else { format!(" ({})", p.branch) };
    let number = match p.interval {
        Some((low, high)) if high > low => {
            let digits = decimals(0.5 * (high - low), 2.0);
            let [estimate, low, high] = [p.estimate, low, high].map(|x| fixed(x, digits));
            format!("{estimate} [{low}, {high}]")
        }
        _ => significant(p.estimate),
    };
    let unit =
        p.unit.strip_suffix("^p").map_or_else(|| plain(&p.unit), |unit| plain(unit) + "^{p}");
    let words = format!("{}{way} = {number} {unit}", typeset(&p.symbol));
    words.trim_end().to_owned()
}

/// A plain formula as markup: `max(x - x0, 0)^p` → max(x − x₀, 0)ᵖ.
fn typeset(formula: &str) -> String {
    formula
        .replace(" - ", " − ")
        .replace("x0", "x_{0}")
        .replace("x1", "x_{1}")
        .replace("^p", "^{p}")
}

/// Three significant digits.
pub(super) fn significant(value: f64) -> String {
    fixed(value, decimals(value, 3.0))
}

/// Decimals that show so many significant digits of `value`.
fn decimals(value: f64, digits: f64) -> usize {
    let magnitude = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    (digits - 1.0 - magnitude).clamp(0.0, 9.0) as usize
}

/// With so many decimals and a true minus sign.
fn fixed(value: f64, decimals: usize) -> String {
    format!("{value:.decimals$}").replace('-', "−")
}
