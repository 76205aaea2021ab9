//! The trials that count, with their names as indices.

use crate::measure::Measure;
use crate::{CompareError, Parameters};
use std::collections::{BTreeMap, BTreeSet};
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

    /// The modes of an environment in the order in which everybody had them; none where somebody had two of them the
    /// other way round, or mingled so that neither came first, as A B B A.
    pub(crate) fn one_order(&self, environment: usize) -> Option<Vec<usize>> {
        /// The share of pairs of trials, of one mode and of another, in which the first one comes earlier, from which on
        /// their order tells practice from neither: that of A B A B. Orders that were drawn are about even, and a trial
        /// that was done again at the end moves it little.
        const MOSTLY: f64 = 0.75;
        let mut sessions: BTreeMap<[usize; 2], BTreeMap<usize, Vec<u32>>> = BTreeMap::new();
        for trial in self.trials.iter().filter(|trial| trial.environment == environment) {
            let own = sessions.entry([trial.participant, trial.session]).or_default();
            own.entry(trial.mode).or_default().push(trial.number);
        }
        // Of each two modes the share in every session that has both; who lacks a mode has the others in that order.
        let mut shares: BTreeMap<[usize; 2], Vec<f64>> = BTreeMap::new();
        for modes in sessions.values() {
            for (first, of_first) in modes {
                for (second, of_second) in modes.range(first + 1..) {
                    let earlier = |one: &u32| of_second.iter().filter(|other| one < other).count();
                    let earlier: usize = of_first.iter().map(earlier).sum();
                    let share = earlier as f64 / (of_first.len() * of_second.len()) as f64;
                    shares.entry([*first, *second]).or_default().push(share);
                }
            }
        }
        shares.retain(|_, own| own.len() > 1);
        let mut before: BTreeMap<usize, usize> = BTreeMap::new();
        for ([first, second], own) in shares {
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            let (is_one, later) = match mean > 0.5 {
                true => (own.iter().all(|share| *share > 0.5), second),
                false => (own.iter().all(|share| *share < 0.5), first),
            };
            if !is_one || mean.max(1.0 - mean) < MOSTLY {
                return None;
            }
            for mode in [first, second] {
                *before.entry(mode).or_default() += usize::from(mode == later);
            }
        }
        let mut order: Vec<usize> = before.keys().copied().collect();
        order.sort_by_key(|mode| before[mode]);
        (!order.is_empty()).then_some(order)
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
