//! The metric's values by cell: one participant in one session, environment and mode.

use crate::measure::Measure;
use crate::{CompareError, Parameters};
use std::collections::BTreeSet;
use zwidth_frames::{Aggregate, Frame, Statistic};
use zwidth_stats::welch::Group;
use zwidth_tables::{Column, Field, Table, Type};

/// What a cell is one of.
pub(crate) const KEYS: [&str; 4] = ["participant", "session", "environment", "mode"];

/// The repeats of one participant in one session, environment and mode.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cell {
    /// Index among [`Cells::participants`].
    pub(crate) participant: usize,
    /// Index among [`Cells::sessions`].
    pub(crate) session: usize,
    /// Index among the study's environments.
    pub(crate) environment: usize,
    /// Index among the study's modes.
    pub(crate) mode: usize,
    /// Trials that count.
    pub(crate) trials: usize,
    /// Those of them that have the metric.
    pub(crate) n: usize,
    /// Their mean; `None` without such a trial.
    pub(crate) mean: Option<f64>,
    /// Their standard deviation (n − 1); `None` for fewer than two.
    pub(crate) sd: Option<f64>,
}

/// Every cell, in the order of participant and session.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Cells {
    /// Codes, in their order.
    pub(crate) participants: Vec<String>,
    /// Codes of sessions, in their order; people share them.
    pub(crate) sessions: Vec<String>,
    /// The cells.
    pub(crate) cells: Vec<Cell>,
}

impl Cell {
    /// Its count, mean and standard deviation; 0 if it has no trials.
    pub(crate) fn group(&self) -> Group {
        Group { n: self.n, mean: self.mean.unwrap_or(0.0), sd: self.sd.unwrap_or(0.0) }
    }
}

impl Cells {
    /// The cells of a metric. `metrics` has one row per trial. Conditions that the study does not
    /// have are left out.
    pub(crate) fn of(
        metrics: &Table,
        measure: &Measure,
        parameters: &Parameters,
    ) -> Result<Self, CompareError> {
        let grouped = grouped(metrics, measure)?;
        let [participant, session, environment, mode] = KEYS.map(|key| grouped.texts(key));
        let (participant, session) = (known(participant?), known(session?));
        let (environment, mode) = (known(environment?), known(mode?));
        let (trials, n) = (grouped.integers("trials")?, grouped.integers("n")?);
        let (mean, sd) =
            (grouped.floats(&measure.named("mean"))?, grouped.floats(&measure.named("sd"))?);
        let (participants, sessions) = (sorted(&participant), sorted(&session));
        let mut cells = Vec::new();
        for row in 0..grouped.height() {
            let condition = parameters.condition(&environment[row], &mode[row]);
            let Some([environment, mode]) = condition else { continue };
            cells.push(Cell {
                participant: place(&participants, &participant[row]),
                session: place(&sessions, &session[row]),
                environment,
                mode,
                trials: counted(trials[row]),
                n: counted(n[row]),
                mean: mean[row],
                sd: sd[row],
            });
        }
        cells.sort_by_key(|c| (c.participant, c.session, c.environment, c.mode));
        Ok(Self { participants, sessions, cells })
    }

    /// The cells of one condition, in the order of participant and session.
    pub(crate) fn of_condition(
        &self,
        environment: usize,
        mode: usize,
    ) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |c| (c.environment, c.mode) == (environment, mode))
    }

    /// The cells as a table, by their names.
    pub(crate) fn table(
        &self,
        measure: &Measure,
        parameters: &Parameters,
    ) -> Result<Table, CompareError> {
        let cells = || self.cells.iter();
        let columns = vec![
            Column::text(
                "participant",
                "who",
                cells().map(|c| Some(&*self.participants[c.participant])),
            ),
            Column::text(
                "session",
                "in which session",
                cells().map(|c| Some(&*self.sessions[c.session])),
            ),
            Column::text(
                "environment",
                "what was rendered",
                cells().map(|c| Some(parameters.environments[c.environment].as_str())),
            ),
            Column::text(
                "mode",
                "how it was rendered",
                cells().map(|c| Some(parameters.modes[c.mode].as_str())),
            ),
            Column::integer("trials", "1", "trials that count", cells().map(|c| whole(c.trials))),
            Column::integer("n", "1", "trials that have the metric", cells().map(|c| whole(c.n))),
            measure.column("mean", "mean of these trials", cells().map(|c| c.mean)),
            measure.column("sd", "standard deviation of these trials", cells().map(|c| c.sd)),
        ];
        let title = format!("By participant, session and condition: {}", measure.description);
        Ok(Table::new(&format!("cells_{}", measure.name), &title, columns)?)
    }
}

/// One row a cell, by polars.
fn grouped(metrics: &Table, measure: &Measure) -> Result<Table, CompareError> {
    let wanted = KEYS.iter().copied().chain([measure.name.as_str()]);
    let columns =
        wanted.map(|name| metrics.column(name).cloned()).collect::<Result<Vec<_>, _>>()?;
    let fields = columns[..KEYS.len()].iter().map(|column| column.field.clone());
    let aggregate =
        |statistic, name: String| Aggregate { of: measure.name.clone(), statistic, name };
    let aggregates = [
        aggregate(Statistic::Mean, measure.named("mean")),
        aggregate(Statistic::Deviation, measure.named("sd")),
        aggregate(Statistic::Count, "n".to_owned()),
    ];
    let made = |name: String, kind| Field {
        name: name.into(),
        unit: "1".into(),
        description: "".into(),
        kind,
    };
    let fields = fields.chain([
        made("trials".to_owned(), Type::Integer),
        made("n".to_owned(), Type::Integer),
        made(measure.named("mean"), Type::Float),
        made(measure.named("sd"), Type::Float),
    ]);
    let fields = fields.collect();
    let values = Table::new(metrics.name(), metrics.title(), columns)?;
    let frame = Frame::new(&values)?.grouped(&KEYS, "trials", &aggregates)?;
    Ok(frame.to_table("cells", "", fields)?)
}

fn known(texts: Vec<Option<String>>) -> Vec<String> {
    texts.into_iter().map(Option::unwrap_or_default).collect()
}

fn sorted(names: &[String]) -> Vec<String> {
    names.iter().collect::<BTreeSet<_>>().into_iter().cloned().collect()
}

/// The place of a name among sorted ones that have it.
fn place(names: &[String], name: &String) -> usize {
    names.partition_point(|before| before < name)
}

fn counted(n: Option<i64>) -> usize {
    n.and_then(|n| usize::try_from(n).ok()).unwrap_or(0)
}

/// A count as a column holds it.
pub(crate) fn whole(n: usize) -> Option<i64> {
    i64::try_from(n).ok()
}
