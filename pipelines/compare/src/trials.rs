//! The trials that count, by the places of the names that they have.

use crate::measure::Measure;
use crate::{CompareError, Parameters};
use std::collections::BTreeSet;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{IdError, ParticipantId, SessionId};
use zwidth_tables::{Table, TableError};

/// What a condition of a participant is one of.
pub(crate) const KEYS: [&str; 4] = ["participant", "session", "environment", "mode"];

/// A trial in a condition that the study has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Trial {
    /// Index among [`Trials::participants`].
    pub(crate) participant: usize,
    /// Index among [`Trials::sessions`].
    pub(crate) session: usize,
    /// Index among the study's environments.
    pub(crate) environment: usize,
    /// Index among the study's modes.
    pub(crate) mode: usize,
    /// Its number in the session.
    pub(crate) number: u32,
    /// Which repeat of its condition it is.
    pub(crate) repeat: Option<i64>,
    /// The metric, where it has it.
    pub(crate) value: Option<f64>,
}

/// All trials, in the order of the table of metrics.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Trials {
    /// Codes, in their order.
    pub(crate) participants: Vec<ParticipantId>,
    /// Codes of sessions, in their order; people share them.
    pub(crate) sessions: Vec<SessionId>,
    /// The trials.
    pub(crate) trials: Vec<Trial>,
}

impl Trials {
    /// The trials with their values of a metric. `metrics` has one row per trial. Conditions that the
    /// study does not have are left out.
    pub(crate) fn of(
        metrics: &Table,
        measure: &Measure,
        parameters: &Parameters,
    ) -> Result<Self, CompareError> {
        let [participant, session, environment, mode] = KEYS.map(|key| known(metrics, key));
        let (participant, session) = (participant?, session?);
        let (environment, mode) = (environment?, mode?);
        let (numbers, repeats) = (metrics.integers("trial")?, metrics.integers("repeat")?);
        let values = metrics.floats(measure.parameters.metric.as_str())?;
        let (participants, sessions) = (sorted(&participant), sorted(&session));
        let mut trials = Vec::new();
        for row in 0..metrics.height() {
            let condition = parameters.condition(&environment[row], &mode[row]);
            let Some([environment, mode]) = condition else { continue };
            trials.push(Trial {
                participant: place(&participants, &participant[row]),
                session: place(&sessions, &session[row]),
                environment,
                mode,
                number: numbers[row].and_then(|number| u32::try_from(number).ok()).unwrap_or(0),
                repeat: repeats[row],
                value: values[row],
            });
        }
        Ok(Self { participants: ids(&participants)?, sessions: ids(&sessions)?, trials })
    }

    /// Those of one condition.
    pub(crate) fn of_condition(
        &self,
        environment: usize,
        mode: usize,
    ) -> impl Iterator<Item = &Trial> {
        self.trials.iter().filter(move |t| (t.environment, t.mode) == (environment, mode))
    }
}

/// The texts of a column; a trial always has one.
pub(crate) fn known(table: &Table, column: &str) -> Result<Vec<Arc<str>>, TableError> {
    let texts = table.shared_texts(column)?.iter().cloned();
    Ok(texts.map(|text| text.unwrap_or_else(|| Arc::from(""))).collect())
}

/// The names that there are, in their order.
pub(crate) fn sorted(names: &[Arc<str>]) -> Vec<Arc<str>> {
    names.iter().collect::<BTreeSet<_>>().into_iter().cloned().collect()
}

/// The place of a name among sorted ones that have it.
pub(crate) fn place(names: &[Arc<str>], name: &Arc<str>) -> usize {
    names.partition_point(|before| before < name)
}

pub(crate) fn ids<T: FromStr<Err = IdError>>(names: &[Arc<str>]) -> Result<Vec<T>, IdError> {
    names.iter().map(|name| name.parse()).collect()
}
