//! The metric's values by cell: one participant in one session, environment and mode.

use crate::measure::Measure;
use crate::trials::{KEYS, ids, known, place, sorted};
use crate::{CompareError, Parameters};
use zwidth_frames::{Aggregate, Frame, Statistic};
use zwidth_results as results;
use zwidth_results::UnitOfAnalysis;
use zwidth_stats::welch::Group;
use zwidth_study::{ParticipantId, SessionId};
use zwidth_tables::{Field, Table, Type};

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
    pub(crate) participants: Vec<ParticipantId>,
    /// Codes of sessions, in their order; people share them.
    pub(crate) sessions: Vec<SessionId>,
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
        let [participant, session, environment, mode] = KEYS.map(|key| known(&grouped, key));
        let (participant, session) = (participant?, session?);
        let (environment, mode) = (environment?, mode?);
        let (trials, n) = (grouped.integers("trials")?, grouped.integers("n")?);
        let (mean, sd) = (grouped.floats("mean")?, grouped.floats("sd")?);
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
        Ok(Self { participants: ids(&participants)?, sessions: ids(&sessions)?, cells })
    }

    /// What n counts: with one participant the trials.
    pub(crate) fn unit(&self) -> UnitOfAnalysis {
        match self.participants.as_slice() {
            [only] => UnitOfAnalysis::TrialsOf(only.clone()),
            _ => UnitOfAnalysis::Participants,
        }
    }

    /// The cells of one condition, in the order of participant and session.
    pub(crate) fn of_condition(
        &self,
        environment: usize,
        mode: usize,
    ) -> impl Iterator<Item = &Cell> {
        self.cells.iter().filter(move |c| (c.environment, c.mode) == (environment, mode))
    }

    /// The cells by their names.
    pub(crate) fn rows(&self, measure: &Measure, parameters: &Parameters) -> Vec<results::Cell> {
        let row = |cell: &Cell| results::Cell {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            participant: self.participants[cell.participant].clone(),
            session: self.sessions[cell.session].clone(),
            environment: parameters.environments[cell.environment].clone(),
            mode: parameters.modes[cell.mode].clone(),
            trials: cell.trials,
            n: cell.n,
            mean: cell.mean,
            sd: cell.sd,
        };
        self.cells.iter().map(row).collect()
    }
}

/// One row a cell, by polars.
fn grouped(metrics: &Table, measure: &Measure) -> Result<Table, CompareError> {
    let metric = measure.parameters.metric.as_str();
    let wanted = KEYS.iter().copied().chain([metric]);
    let columns =
        wanted.map(|name| metrics.column(name).cloned()).collect::<Result<Vec<_>, _>>()?;
    let keys = columns[..KEYS.len()].iter().map(|column| column.field.clone());
    let aggregates =
        [(Statistic::Mean, "mean"), (Statistic::Deviation, "sd"), (Statistic::Count, "n")].map(
            |(statistic, name)| Aggregate {
                of: metric.to_owned(),
                statistic,
                name: name.to_owned(),
            },
        );
    let made = [
        ("trials", Type::Integer),
        ("n", Type::Integer),
        ("mean", Type::Float),
        ("sd", Type::Float),
    ]
    .map(|(name, kind)| Field {
        name: name.into(),
        unit: "1".into(),
        description: "".into(),
        kind,
    });
    let fields = keys.chain(made).collect();
    let values = Table::new(metrics.name(), metrics.title(), columns)?;
    let frame = Frame::new(&values)?.grouped(&KEYS, "trials", &aggregates)?;
    Ok(frame.to_table("cells", "", fields)?)
}

fn counted(n: Option<i64>) -> usize {
    n.and_then(|n| usize::try_from(n).ok()).unwrap_or(0)
}
