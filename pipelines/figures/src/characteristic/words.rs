//! A characteristic in words: what stands under its figure.

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
    pub(super) note: String,
}

pub(super) fn parameters(table: &Table, model: &str) -> Result<Vec<Parameter>, TableError> {
    let names = ["model", "parameter", "branch", "note"];
    let texts = names.iter().map(|name| table.texts(name)).collect::<Result<Vec<_>, _>>()?;
    let estimates = table.floats("estimate")?;
    let text = |column: usize, row: usize| texts[column][row].clone().unwrap_or_default();
    let parameter = |row: usize| {
        let [symbol, branch, note] = [1, 2, 3].map(|column| text(column, row));
        Some(Parameter { symbol, branch, note, estimate: estimates[row]? })
    };
    Ok((0..table.height()).filter(|&row| text(0, row) == model).filter_map(parameter).collect())
}

/// The chosen model and its error in words, and where its coefficients stand.
pub(super) fn about(
    models: &Table,
    chosen: &str,
    unit: &str,
    actuator: &str,
) -> Result<Vec<String>, TableError> {
    let Some(row) = row_of(models, chosen)? else { return Ok(Vec::new()) };
    let formula = models.texts("formula")?[row].as_deref().map(typeset).unwrap_or_default();
    let name = chosen.replace("_up_down", "").replace('_', " ");
    let rms = models.floats("rms")?[row];
    let rms = rms.map(|rms| format!("; RMS {} {}", significant(rms), plain(unit)));
    let rms = rms.unwrap_or_default();
    let table = plain(&format!("parameters.{actuator}"));
    Ok(vec![format!("Chosen: {name}, {formula}{rms}. Coefficients: table {table}.")])
}

/// Why a force at the end of these fits is not the one that the calibration gives; nothing where
/// both ways have one fit, or what responds is no force.
pub(super) fn why_not_calibrated(
    curve: &Table,
    command_unit: &str,
    unit: &str,
) -> Result<Option<String>, TableError> {
    let (branches, commands) = (curve.texts("branch")?, curve.floats("command")?);
    let are_apart = branches.windows(2).any(|pair| pair[0] != pair[1]);
    let fits = curve.floats("fit")?;
    let ends = commands.into_iter().zip(fits).filter_map(|(command, fit)| Some((command?, fit?)));
    let end = ends.reduce(|most, next| if next.0 > most.0 { next } else { most });
    let Some((command, force_n)) = end.filter(|_| are_apart && unit == "N") else {
        return Ok(None);
    };
    Ok(Some(format!(
        "This is what the load cell reads, with the friction of the transmission in it: {} N at {} {}, where the \
         command turns and friction turns with it. The calibration (figure {}) gives the actuator's own \
         force, without friction; near the turn it goes on along the tangent.",
        significant(force_n),
        significant(command),
        plain(command_unit),
        plain("rendering_range"),
    )))
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
