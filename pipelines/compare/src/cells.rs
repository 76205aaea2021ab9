//! The metric's values by cell: one participant in one session, environment and mode.

use crate::measure::Measure;
use crate::over_trials::Lines;
use crate::trials::{Trials, place, sorted};
use crate::{CompareError, Parameters};
use zwidth_frames::{Statistics, grouped};
use zwidth_results as results;
use zwidth_results::{ConditionKey, TrialKey, UnitOfAnalysis};
use zwidth_stats::welch::Group;
use zwidth_study::{ParticipantId, SessionId};
use zwidth_tables::Measured;

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
    /// The number of these that have the metric.
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
    /// The lines along which their means are adjusted, if they are.
    pub(crate) lines: Option<Lines>,
}

impl Cell {
    /// Its count, mean and standard deviation; 0 if it has no trials.
    pub(crate) fn group(&self) -> Group {
        Group { n: self.n, mean: self.mean.unwrap_or(0.0), sd: self.sd.unwrap_or(0.0) }
    }
}

impl Cells {
    /// The cells of a metric, of which `trials` have the values. Conditions that the study does not have are left
    /// out.
    pub(crate) fn of(
        metrics: &Measured,
        measure: &Measure,
        trials: &Trials,
        parameters: &Parameters,
    ) -> Result<Self, CompareError> {
        let keys: Vec<ConditionKey> = metrics.trials().iter().map(TrialKey::condition).collect();
        let mut values = metrics.numbers(measure.parameters.metric.as_str())?;
        let participants = sorted(keys.iter().map(|key| &key.participant));
        let sessions = sorted(keys.iter().map(|key| &key.session));
        // One participant's claims are of the trials as they are.
        let over = parameters.over.filter(|_| participants.len() > 1);
        let lines = over.map(|over| (over, Lines::of(trials, over)));
        if let Some((over, lines)) = &lines {
            let mut adjusted = lines.adjusted(trials, *over).into_iter();
            for (key, value) in keys.iter().zip(&mut values) {
                // The trials are those in conditions of the study, in the same order.
                let is_known = parameters.condition(&key.environment, &key.mode).is_some();
                *value = if is_known { adjusted.next().flatten() } else { None };
            }
        }
        let mut cells = Vec::new();
        for group in grouped(&keys, &[&values])? {
            let key = group.key;
            let condition = parameters.condition(&key.environment, &key.mode);
            let Some([environment, mode]) = condition else { continue };
            let [Statistics { count, mean, sd }] = group.numbers[..] else { continue };
            cells.push(Cell {
                participant: place(&participants, &key.participant),
                session: place(&sessions, &key.session),
                environment,
                mode,
                trials: group.rows,
                n: count,
                mean,
                sd,
            });
        }
        // `grouped` keeps the order of rows; readers take the cells of a participant as neighbours.
        cells.sort_by_key(|c| (c.participant, c.session, c.environment, c.mode));
        Ok(Self { participants, sessions, cells, lines: lines.map(|(_, lines)| lines) })
    }

    /// The unit that n counts: the trials if there is one participant.
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

    /// Everybody's mean over sessions in one condition, by the place of the participant.
    pub(crate) fn people_in(
        &self,
        environment: usize,
        mode: usize,
    ) -> impl Iterator<Item = (usize, f64)> {
        let with: Vec<&Cell> =
            self.of_condition(environment, mode).filter(|cell| cell.mean.is_some()).collect();
        let people = with.chunk_by(|a, b| a.participant == b.participant).map(|sessions| {
            let sum = sessions.iter().filter_map(|cell| cell.mean).sum::<f64>();
            (sessions[0].participant, sum / sessions.len() as f64)
        });
        people.collect::<Vec<_>>().into_iter()
    }

    /// The cells by their names.
    pub(crate) fn rows(&self, measure: &Measure, parameters: &Parameters) -> Vec<results::Cell> {
        let rows = self.cells.iter().map(|cell| results::Cell {
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
        });
        rows.collect()
    }
}
