//! The trials that count, with their names as indices.

use crate::measure::Measure;
use crate::{CompareError, Parameters};
use std::collections::BTreeSet;
use zwidth_study::{ParticipantId, SessionId};
use zwidth_tables::Measured;

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
    pub(crate) repeat: u32,
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
    /// The trials with their values of a metric. Conditions that the study does not have are left
    /// out.
    pub(crate) fn of(
        metrics: &Measured,
        measure: &Measure,
        parameters: &Parameters,
    ) -> Result<Self, CompareError> {
        let values = metrics.numbers(measure.parameters.metric.as_str())?;
        let participants = sorted(metrics.trials().iter().map(|trial| &trial.participant));
        let sessions = sorted(metrics.trials().iter().map(|trial| &trial.session));
        let mut trials = Vec::new();
        for (trial, value) in metrics.trials().iter().zip(values) {
            let condition = parameters.condition(&trial.environment, &trial.mode);
            let Some([environment, mode]) = condition else { continue };
            trials.push(Trial {
                participant: place(&participants, &trial.participant),
                session: place(&sessions, &trial.session),
                environment,
                mode,
                number: trial.trial,
                repeat: trial.repeat,
                value,
            });
        }
        Ok(Self { participants, sessions, trials })
    }

    /// The trials of one condition.
    pub(crate) fn of_condition(
        &self,
        environment: usize,
        mode: usize,
    ) -> impl Iterator<Item = &Trial> {
        self.trials.iter().filter(move |t| (t.environment, t.mode) == (environment, mode))
    }
}

/// The ids that there are, in their order.
pub(crate) fn sorted<'a, T: Ord + Clone + 'a>(ids: impl Iterator<Item = &'a T>) -> Vec<T> {
    ids.collect::<BTreeSet<_>>().into_iter().cloned().collect()
}

/// The place of an id among sorted ones that have it.
pub(crate) fn place<T: Ord>(ids: &[T], id: &T) -> usize {
    ids.partition_point(|before| before < id)
}
