//! The stage's tables: models, parameters, curve.

use crate::{Candidate, CharacteriseError, Characteristic, FirstOrder, Parameter, curve};
use std::borrow::Cow;
use zwidth_tables::{Column, Field, Table, TableError, Type, Values};

/// What a table of this stage can fail with.
#[derive(Debug, thiserror::Error)]
pub enum StageError {
    /// The fit failed.
    #[error(transparent)]
    Characterise(#[from] CharacteriseError),
    /// A table failed.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// What was characterised: names and units for the tables.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The actuator or sensor.
    pub actuator: &'a str,
    /// Unit of the command.
    pub command_unit: &'a str,
    /// Unit of the response.
    pub response_unit: &'a str,
}

/// One row a candidate model: its errors, and why it was chosen or rejected.
pub fn models_table(of: Subject, c: &Characteristic) -> Result<Table, TableError> {
    let all = &c.candidates;
    let text = |name, about, get: fn(&Candidate) -> &str| {
        Column::text(name, about, all.iter().map(|m| Some(get(m).to_owned())))
    };
    let error = |name, about, get: fn(&crate::Quality) -> Option<f64>| {
        float(name, of.response_unit, about, all.iter().map(|m| m.quality.as_ref().and_then(get)).collect())
    };
    let number = |name, about, get: fn(&crate::Quality) -> Option<f64>| {
        float(name, "1", about, all.iter().map(|m| m.quality.as_ref().and_then(get)).collect())
    };
    let table = Table::new(
        &format!("characteristic.{}", of.actuator),
        &format!("Characteristic of the {}: candidate models", of.actuator.replace('_', " ")),
        vec![
            text("model", "candidate model", |m| m.name),
            text("formula", "its equation", |m| m.formula),
            error("rms", "root mean square of the residuals", |q| Some(q.rms)),
            error("left_out_rms", "root mean square error on what was left out of the fit", |q| {
                Some(q.cv_rms)
            }),
            number("rms_over_noise", "rms over the scatter that no curve explains", |q| q.rms_over_noise),
            number("r2", "coefficient of determination R²", |q| q.r2),
            number("autocorrelation", "of neighbouring residuals; near 0 for a fit that fits", |q| {
                q.autocorrelation
            }),
            number("aicc", "AICc on per-command bins; reported, not decisive", |q| q.aicc),
            text("verdict", "chosen or not, and why", |m| &m.verdict_text),
        ],
    )?;
    let noise = c.noise.map(|n| format!("Scatter that no curve explains: {n:.3} {}.", of.response_unit));
    let plural = if c.sweeps == 1 { "" } else { "s" };
    let (sweeps, points, folds, grouping) = (c.sweeps, c.points, c.folds, c.grouping.name());
    let sweeps = format!("{sweeps} sweep{plural}, {points} points; left out in turn: {folds} {grouping}s.");
    let notes = [Some(c.reason.clone()), Some(sweeps), noise];
    Ok(notes.into_iter().flatten().fold(table, Table::with_note))
}

/// One row a parameter of each candidate model, with its bootstrap interval.
pub fn parameters_table(of: Subject, c: &Characteristic) -> Result<Table, TableError> {
    let rows: Vec<(&Candidate, &Parameter)> =
        c.candidates.iter().flat_map(|m| m.parameters.iter().map(move |p| (m, p))).collect();
    let text = |name, about, get: fn(&(&Candidate, &Parameter)) -> Option<String>| {
        Column::text(name, about, rows.iter().map(get))
    };
    let value = |name, about, get: fn(&Parameter) -> Option<f64>| {
        Column::float(name, "1", about, rows.iter().map(|(_, p)| get(p)))
    };
    Table::new(
        &format!("parameters.{}", of.actuator),
        &format!("Characteristic of the {}: parameters", of.actuator.replace('_', " ")),
        vec![
            text("model", "candidate model", |(m, _)| Some(m.name.to_owned())),
            text("parameter", "symbol in the model's equation", |(_, p)| Some(p.name.to_owned())),
            value("estimate", "least-squares estimate, in `unit`", |p| Some(p.estimate)),
            value("std_error", "standard deviation over the bootstrap resamples", |p| p.std_error),
            value("ci_low", "lower end of the bootstrap interval", |p| p.ci_low),
            value("ci_high", "upper end of the bootstrap interval", |p| p.ci_high),
            text("unit", "unit of the estimate", |(_, p)| Some(p.unit.clone())),
            text("note", "what the number must not be taken for", |(_, p)| p.note.clone()),
        ],
    )
}

/// Points of the curve's grid.
const GRID_POINTS: usize = 201;

/// The chosen fit with its bands, and the first-order fit, on an even grid over the commands.
pub fn curve_table(
    of: Subject,
    c: &Characteristic,
    line: &FirstOrder,
    level: f64,
) -> Result<Table, StageError> {
    let step = (c.command_max - c.command_min) / (GRID_POINTS - 1) as f64;
    let grid: Vec<f64> = (0..GRID_POINTS).map(|i| c.command_min + step * i as f64).collect();
    let first_order = line.curve(&grid);
    let chosen = curve(&c.candidates[c.chosen], &grid, level)?.unwrap_or_else(|| first_order.clone());
    let response = |name, about, values: &[f64]| {
        float(name, of.response_unit, about, values.iter().copied().map(Some).collect())
    };
    Ok(Table::new(
        &format!("curve.{}", of.actuator),
        &format!("Characteristic of the {}: fitted curve", of.actuator.replace('_', " ")),
        vec![
            float("command", of.command_unit, "command", chosen.command.iter().copied().map(Some).collect()),
            response("fit", "chosen model", &chosen.fit),
            response("ci_low", "lower end of the band of the mean", &chosen.ci_low),
            response("ci_high", "upper end of the band of the mean", &chosen.ci_high),
            response("prediction_low", "lower end of the band of a new response", &chosen.prediction_low),
            response("prediction_high", "upper end of the band of a new response", &chosen.prediction_high),
            response("first_order", "straight line over all samples, as in the thesis", &first_order.fit),
        ],
    )?)
}

/// A column whose unit is only known from the sweep.
fn float(name: &'static str, unit: &str, about: &'static str, values: Vec<Option<f64>>) -> Column {
    let unit = Cow::Owned(unit.to_owned());
    let field = Field { name: name.into(), unit, description: about.into(), kind: Type::Float };
    Column { field, values: Values::Float(values) }
}
