//! The stage's tables: models, parameters, curve.

use crate::curve::mean_response;
use crate::models;
use crate::{
    Branch, Candidate, CandidateVerdict, CharacteriseError, Characteristic, Chosen, Curve,
    Parameter, Sweep, curve, first_order,
};
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
        float(
            name,
            of.response_unit,
            about,
            all.iter().map(|m| m.quality.as_ref().and_then(get)).collect(),
        )
    };
    let number = |name, about, get: fn(&crate::Quality) -> Option<f64>| {
        float(name, "1", about, all.iter().map(|m| m.quality.as_ref().and_then(get)).collect())
    };
    let table = Table::new(
        &format!("characteristic.{}", of.actuator),
        &format!("Characteristic of the {}: candidate models", of.actuator.replace('_', " ")),
        vec![
            text("model", "candidate model", |m| m.name),
            text("formula", "its equation", |m| &m.formula),
            error("rms", "root mean square of the residuals", |q| Some(q.rms)),
            error("left_out_rms", "root mean square error on what was left out of the fit", |q| {
                Some(q.cv_rms)
            }),
            number("rms_over_noise", "rms over the scatter that no curve explains", |q| {
                q.rms_over_noise
            }),
            number("r2", "coefficient of determination R²", |q| q.r2),
            number(
                "autocorrelation",
                "of neighbouring residuals; near 0 for a fit that fits",
                |q| q.autocorrelation,
            ),
            number("aicc", "AICc on per-command bins; reported, not decisive", |q| q.aicc),
            text("verdict", "chosen or not, and why", |m| &m.verdict_text),
        ],
    )?;
    let noise =
        c.noise.map(|n| format!("Scatter that no curve explains: {n:.3} {}.", of.response_unit));
    let plural = if c.sweeps == 1 { "" } else { "s" };
    let (sweeps, points, folds, grouping) = (c.sweeps, c.points, c.folds, c.grouping.name());
    let sweeps =
        format!("{sweeps} sweep{plural}, {points} points; left out in turn: {folds} {grouping}s.");
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
            text("branch", "way of the command whose curve it belongs to", |(_, p)| {
                Some(branch_name(p.branch).to_owned())
            }),
            value("estimate", "least-squares estimate, in `unit`", |p| Some(p.estimate)),
            value("std_error", "standard deviation over the bootstrap resamples", |p| p.std_error),
            value("ci_low", "lower end of the bootstrap interval", |p| p.ci_low),
            value("ci_high", "upper end of the bootstrap interval", |p| p.ci_high),
            text("unit", "unit of the estimate", |(_, p)| Some(p.unit.clone())),
            text("note", "what the number must not be taken for", |(_, p)| p.note.clone()),
        ],
    )
}

/// What a table says for both branches at once.
pub(crate) const BOTH: &str = "both";

fn branch_name(branch: Option<Branch>) -> &'static str {
    branch.map_or(BOTH, Branch::name)
}

/// Points of the curve's grid.
const GRID_POINTS: usize = 201;

/// The chosen fit with its bands, the mean of the samples and the first-order fit, on an even grid
/// over the commands; up and then down if the chosen model has hysteresis.
pub fn curve_table(
    of: Subject,
    sweeps: &[Sweep],
    c: &Characteristic,
    level: f64,
) -> Result<Table, StageError> {
    let step = (c.command_max - c.command_min) / (GRID_POINTS - 1) as f64;
    let grid: Vec<f64> = (0..GRID_POINTS).map(|i| c.command_min + step * i as f64).collect();
    let line = first_order(sweeps, level)?.curve(&grid);
    let chosen = &c.candidates[c.chosen];
    let (mut all, mut names, mut mean, mut first_order) =
        (Curve::default(), vec![], vec![], vec![]);
    for branch in models::by_name(chosen.name).map_or(&[None][..], |model| model.branches()) {
        let curve = curve(chosen, &grid, branch.unwrap_or(Branch::Up), level)?;
        all.append(curve.unwrap_or_else(|| line.clone()));
        names.extend(vec![Some(branch_name(*branch).to_owned()); GRID_POINTS]);
        mean.extend(mean_response(sweeps, &grid, *branch));
        first_order.extend_from_slice(&line.fit);
    }
    let response = |name, about, values: &[f64]| {
        float(name, of.response_unit, about, values.iter().copied().map(Some).collect())
    };
    Ok(Table::new(
        &format!("curve.{}", of.actuator),
        &format!("Characteristic of the {}: fitted curve", of.actuator.replace('_', " ")),
        vec![
            Column::text("branch", "way of the command: up, down or both", names),
            float(
                "command",
                of.command_unit,
                "command",
                all.command.iter().copied().map(Some).collect(),
            ),
            float(
                "mean",
                of.response_unit,
                "mean of all samples within half a step of the command",
                mean,
            ),
            response("fit", "chosen model", &all.fit),
            response("ci_low", "lower end of the band of the mean", &all.ci_low),
            response("ci_high", "upper end of the band of the mean", &all.ci_high),
            response(
                "prediction_low",
                "lower end of the band of a new response",
                &all.prediction_low,
            ),
            response(
                "prediction_high",
                "upper end of the band of a new response",
                &all.prediction_high,
            ),
            response(
                "first_order",
                "straight line over all samples, as in the thesis",
                &first_order,
            ),
        ],
    )?)
}

/// The chosen curve of `actuator` (`motor` or `brake`), read back from its tables.
///
/// # Errors
/// Tables that are not those of this stage, units other than N against V, no chosen model.
pub fn chosen_from(
    actuator: &'static str,
    models: &Table,
    parameters: &Table,
    curve: &Table,
) -> Result<Chosen, StageError> {
    let refuse =
        |problem: &str| CharacteriseError::Calibration { actuator, problem: problem.to_owned() };
    let unit = |name: &str| curve.fields().find(|f| f.name == name).map_or("", |f| f.unit.as_ref());
    if (unit("command"), unit("fit")) != ("V", "N") {
        let problem = format!(
            "its sweeps hold {} against {}, not N against V: convert them on import, or give them another actuator's name",
            unit("fit"),
            unit("command")
        );
        return Err(refuse(&problem).into());
    }
    let remedy = "its tables do not hold a chosen model; make them again";
    let names = models.texts("model")?;
    let row = chosen_row(models)?.and_then(|row| names[row].clone());
    let (name, model) =
        row.and_then(|n| models::by_name(&n).map(|m| (n, m))).ok_or_else(|| refuse(remedy))?;
    let of = parameters.texts("model")?;
    let mine =
        of.iter().zip(parameters.floats("estimate")?).filter(|(of, _)| of.as_ref() == Some(&name));
    let parameters: Vec<f64> = mine.filter_map(|(_, estimate)| estimate).collect();
    let command: Vec<f64> = curve.floats("command")?.into_iter().flatten().collect();
    match (command.first(), command.last()) {
        (Some(&low), Some(&high)) if parameters.len() == model.parameters().len() => {
            Ok(Chosen { model, parameters, voltage_v: (low, high) })
        }
        _ => Err(refuse(remedy).into()),
    }
}

/// Row of the chosen model in a [`models_table`].
fn chosen_row(models: &Table) -> Result<Option<usize>, TableError> {
    let is_chosen = |text: &Option<String>| {
        text.as_deref().is_some_and(|t| t.starts_with(CandidateVerdict::Chosen.name()))
    };
    Ok(models.texts("verdict")?.iter().position(is_chosen))
}

/// A column whose unit is only known from the sweep.
fn float(name: &'static str, unit: &str, about: &'static str, values: Vec<Option<f64>>) -> Column {
    let unit = Cow::Owned(unit.to_owned());
    let field = Field { name: name.into(), unit, description: about.into(), kind: Type::Float };
    Column { field, values: Values::Float(values) }
}
