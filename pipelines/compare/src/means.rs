//! Means by condition over the units of analysis: one row per environment and mode.

use crate::cells::{Cell, Cells, whole};
use crate::measure::Measure;
use crate::unit::Unit;
use crate::{CompareError, Parameters, columns};
use zwidth_stats::interval;
use zwidth_stats::welch::{self, Group};
use zwidth_tables::{Column, Table};

/// A condition's mean.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Row {
    pub(crate) environment: usize,
    pub(crate) mode: usize,
    /// Trials that count, and those of them that have the metric.
    pub(crate) trials: [usize; 2],
    /// Units of analysis that have the metric.
    pub(crate) n: usize,
    /// The mean over them.
    pub(crate) mean: f64,
    /// Their standard deviation; of one participant's trials, that within sessions.
    pub(crate) sd: Option<f64>,
    /// The interval of the mean.
    pub(crate) interval: Option<[f64; 2]>,
}

/// The mean of every condition in which somebody has the metric.
pub(crate) fn rows(
    cells: &Cells,
    unit: &Unit,
    parameters: &Parameters,
) -> Result<Vec<Row>, CompareError> {
    let mut rows = Vec::new();
    for environment in 0..parameters.environments.len() {
        for mode in 0..parameters.modes.len() {
            let all: Vec<&Cell> = cells.of_condition(environment, mode).collect();
            let with: Vec<&Cell> = all.iter().copied().filter(|c| c.mean.is_some()).collect();
            if with.is_empty() {
                continue;
            }
            let trials = [all.iter().map(|c| c.trials).sum(), with.iter().map(|c| c.n).sum()];
            let row = match unit {
                Unit::Participants => over_people(&with, parameters.level)?,
                Unit::Trials { .. } => within_one(&with, parameters.level),
            };
            rows.push(Row { environment, mode, trials, ..row });
        }
    }
    Ok(rows)
}

/// Over participants, each the mean of their sessions.
fn over_people(with: &[&Cell], level: f64) -> Result<Row, CompareError> {
    let people = with.chunk_by(|a, b| a.participant == b.participant).map(|sessions| {
        sessions.iter().filter_map(|c| c.mean).sum::<f64>() / sessions.len() as f64
    });
    let mean = interval::mean(&people.collect::<Vec<_>>(), level)?;
    Ok(Row {
        n: mean.n,
        mean: mean.estimate.unwrap_or_default(),
        sd: mean.sd,
        interval: mean.interval.map(|i| [i.ci_low, i.ci_high]),
        ..Row::default()
    })
}

/// Over one participant's trials, sessions with equal weight.
fn within_one(with: &[&Cell], level: f64) -> Row {
    let groups: Vec<Group> = with.iter().map(|cell| cell.group()).collect();
    let squares: f64 = groups.iter().map(|g| (g.n - 1) as f64 * g.sd * g.sd).sum();
    let spare: usize = groups.iter().map(|g| g.n - 1).sum();
    Row {
        n: groups.iter().map(|g| g.n).sum(),
        mean: groups.iter().map(|g| g.mean).sum::<f64>() / groups.len() as f64,
        sd: (spare > 0).then(|| (squares / spare as f64).sqrt()),
        interval: welch::mean(&groups, level).ok().map(|t| [t.ci_low, t.ci_high]),
        ..Row::default()
    }
}

/// The means as a table.
pub(crate) fn table(
    rows: &[Row],
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let counts = |name, description, of: fn(&Row) -> usize| {
        Column::integer(name, "1", description, rows.iter().map(|row| whole(of(row))))
    };
    let end = |side: usize| rows.iter().map(move |row| row.interval.map(|ends| ends[side]));
    let all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        columns::modes(parameters, rows.iter().map(|row| row.mode)),
        columns::units(unit, rows.len()),
        counts("n", "units of analysis", |row| row.n),
        counts("trials", "trials that count", |row| row.trials[0]),
        counts("trials_with_value", "trials that have the metric", |row| row.trials[1]),
        measure.column("mean", "mean over the units", rows.iter().map(|row| Some(row.mean))),
        measure.column("sd", "standard deviation of the units", rows.iter().map(|row| row.sd)),
        measure.column("ci_low", "lower end of the mean's interval", end(0)),
        measure.column("ci_high", "upper end of the mean's interval", end(1)),
    ];
    let title = format!("Means by condition: {}", measure.description);
    Ok(Table::new(&format!("means_{}", measure.name), &title, all)?)
}
