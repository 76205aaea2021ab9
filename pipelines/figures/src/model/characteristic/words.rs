//! A characteristic in words: the text under its figure.

use crate::words::plain;
use zwidth_results::{CurvePoint, FittedModel, FittedParameter, Row};

/// The chosen model and its error in words, and where its coefficients stand.
pub(super) fn about(chosen: &FittedModel, unit: &str, actuator: &str) -> String {
    let name = chosen.model.shape().as_str();
    let formula = typeset(&chosen.formula);
    let rms = chosen.rms.map(|rms| format!("; RMS {} {}", significant(rms), plain(unit)));
    let rms = rms.unwrap_or_default();
    let table = plain(&format!("{}.{actuator}", FittedParameter::NAME));
    format!("Chosen: {name}, {formula}{rms}. Coefficients: table {table}.")
}

/// Why a force at the end of these fits is not the one that the calibration gives; nothing where
/// both ways have one fit, or what responds is no force.
pub(super) fn why_not_calibrated(
    curve: &[CurvePoint],
    command_unit: &str,
    unit: &str,
) -> Option<String> {
    let are_apart = curve.windows(2).any(|pair| pair[0].branch != pair[1].branch);
    if !are_apart || unit != "N" {
        return None;
    }
    // The first of equal commands: on the way up.
    let end = curve.iter().reduce(|most, next| match next.command > most.command {
        true => next,
        false => most,
    })?;
    Some(format!(
        "This is what the load cell reads, with the friction of the transmission in it: {} N at {} {}, where the \
         command turns and friction turns with it. The calibration (figure {}) gives the actuator's own \
         force, without friction; near the turn it goes on along the tangent.",
        significant(end.fit),
        significant(end.command),
        plain(command_unit),
        plain("rendering_range"),
    ))
}

/// A plain formula as markup: `max(x - x0, 0)^p` → max(x − x₀, 0)ᵖ.
fn typeset(formula: &str) -> String {
    formula
        .replace(" - ", " − ")
        .replace("x0", "x_{0}")
        .replace("x1", "x_{1}")
        .replace("^p", "^{p}")
}

/// Three significant digits, with a minus sign, not a hyphen.
pub(super) fn significant(value: f64) -> String {
    const DIGITS: f64 = 3.0;
    let magnitude = if value == 0.0 { 0.0 } else { libm::floor(libm::log10(value.abs())) };
    let decimals = (DIGITS - 1.0 - magnitude).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}").replace('-', "−")
}
