//! Some rows of the table of metrics: the trials of one condition.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{EnvironmentId, ModeId, ParticipantId, SessionId};
use zwidth_tables::{Measured, TableError};

/// Values by participant and session, in the order of the trials.
pub(crate) type People = BTreeMap<ParticipantId, BTreeMap<SessionId, Vec<f64>>>;

/// A mean, and what it is over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mean {
    pub(crate) mean: f64,
    /// Trials that have a value.
    pub(crate) trials: usize,
    /// People who have such a trial.
    pub(crate) participants: usize,
}

impl Mean {
    /// What it is over: `mean of 6 participants`; of one participant, `mean of 6 trials`.
    pub(crate) fn words(&self) -> String {
        match (self.participants, self.trials) {
            (1, 1) => "one trial".to_owned(),
            (1, trials) => format!("mean of {trials} trials"),
            (participants, _) => format!("mean of {participants} participants"),
        }
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// The mean of a participant's values, sessions with equal weight.
pub(crate) fn mean_of_one(sessions: &BTreeMap<SessionId, Vec<f64>>) -> f64 {
    mean(sessions.values().map(|values| mean(values.iter().copied())))
}

/// Trials of one mode, in one environment or in all.
#[derive(Debug, Clone)]
pub(crate) struct Trials<'a> {
    metrics: &'a Measured,
    rows: Vec<usize>,
}

impl<'a> Trials<'a> {
    pub(crate) fn of(
        metrics: &'a Measured,
        environment: Option<&EnvironmentId>,
        mode: &ModeId,
    ) -> Self {
        let trials = metrics.trials().iter().enumerate();
        let wanted = trials.filter(|(_, trial)| {
            environment.is_none_or(|e| trial.environment == *e) && trial.mode == *mode
        });
        Self { metrics, rows: wanted.map(|(row, _)| row).collect() }
    }

    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The values of those trials that have one.
    pub(crate) fn floats(&self, metric: &str) -> Result<Vec<f64>, TableError> {
        let values = self.metrics.numbers(metric)?;
        Ok(self.rows.iter().filter_map(|row| values[*row]).collect())
    }

    /// Whether any of those trials says yes.
    pub(crate) fn any(&self, metric: &str) -> Result<bool, TableError> {
        let values = self.metrics.flags(metric)?;
        Ok(self.rows.iter().any(|row| values[*row] == Some(true)))
    }

    /// The values by participant and session of those trials that have one; of two metrics their
    /// difference. Counts are numbers too.
    pub(crate) fn people(&self, metric: &str, less: Option<&str>) -> Result<People, TableError> {
        let values = self.metrics.numbers(metric)?;
        let less = less.map(|metric| self.metrics.numbers(metric)).transpose()?;
        let mut people = People::new();
        for row in &self.rows {
            let taken = less.as_ref().map_or(Some(0.0), |less| less[*row]);
            let (Some(value), Some(taken)) = (values[*row], taken) else { continue };
            let trial = &self.metrics.trials()[*row];
            let sessions = people.entry(trial.participant.clone()).or_default();
            sessions.entry(trial.session.clone()).or_default().push(value - taken);
        }
        Ok(people)
    }

    /// The mean over participants of each one's mean, sessions with equal weight; `None` where no
    /// trial has a value.
    pub(crate) fn mean(&self, metric: &str) -> Result<Option<Mean>, TableError> {
        let people = self.people(metric, None)?;
        let trials = people.values().flat_map(BTreeMap::values).map(Vec::len).sum();
        Ok((trials > 0).then(|| Mean {
            mean: mean(people.values().map(mean_of_one)),
            trials,
            participants: people.len(),
        }))
    }

    /// Whose trials they are: `trials of P01`, `trials of 3 participants`.
    pub(crate) fn whose(&self) -> String {
        let trials = self.rows.iter().map(|row| &self.metrics.trials()[*row]);
        let people: BTreeSet<_> = trials.map(|trial| &trial.participant).collect();
        match people.first() {
            Some(who) if people.len() == 1 => format!("trials of {who}"),
            _ => format!("trials of {} participants", people.len()),
        }
    }

    /// Number of trials with this word, and of trials with any.
    pub(crate) fn count(&self, metric: &str, word: &str) -> Result<(usize, usize), TableError> {
        let words = self.metrics.words(metric)?;
        let present: Vec<&str> = self.rows.iter().filter_map(|row| words[*row]).collect();
        Ok((present.iter().filter(|w| **w == word).count(), present.len()))
    }
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::columns::metric_columns;
    use zwidth_results::{Row as _, TrialKey};
    use zwidth_study::Source;
    use zwidth_tables::{Column, Table};

    /// One trial of made-up metrics: environment, mode, and the values that the report reads.
    pub(crate) struct MetricsRow {
        pub(crate) condition: (&'static str, &'static str),
        pub(crate) stiffness: Option<f64>,
        pub(crate) saturation: Option<f64>,
        pub(crate) returned: Option<f64>,
        pub(crate) past_rad: Option<f64>,
        /// Electrical energy, J, and force per power, N/W, by recorded currents.
        pub(crate) recorded: Option<[f64; 2]>,
        pub(crate) stability: &'static str,
        pub(crate) source: &'static str,
        pub(crate) participant: &'static str,
    }

    pub(crate) fn row(environment: &'static str, mode: &'static str) -> MetricsRow {
        MetricsRow {
            condition: (environment, mode),
            stiffness: Some(4.0),
            saturation: None,
            returned: Some(0.0),
            past_rad: None,
            recorded: None,
            stability: "smooth",
            source: "recorded",
            participant: "P01",
        }
    }

    pub(crate) fn metrics(rows: &[MetricsRow]) -> Measured {
        let key = |(trial, row): (u32, &MetricsRow)| TrialKey {
            participant: row.participant.parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial,
            repeat: trial,
            environment: row.condition.0.parse().unwrap(),
            mode: row.condition.1.parse().unwrap(),
            source: Source::from_word(row.source).unwrap(),
        };
        let float = |name, get: fn(&MetricsRow) -> Option<f64>| {
            Column::float(name, "1", "", rows.iter().map(get))
        };
        let count = |name, n| Column::integer(name, "1", "", rows.iter().map(move |_| Some(n)));
        let mut columns = vec![
            Column::text("recorded_stability", "", rows.iter().map(|r| Some(r.stability))),
            float("stiffness_n_per_rad", |r| r.stiffness),
            float("saturation_force_n", |r| r.saturation),
            float("returned_energy_share", |r| r.returned),
            float("wall_past_max_rad", |r| r.past_rad),
            float("discrepancy_user_step_n", |_| None),
            float("discrepancy_actuator_step_n", |_| None),
            float("electrical_energy_j", |r| r.recorded.map(|of| of[0])),
            float("electrical_energy_max_j", |_| Some(1.5)),
            float("force_per_power_recorded_n_per_w", |r| r.recorded.map(|of| of[1])),
            float("wall_rigidity_n_per_rad", |_| None),
            float("wall_hold_rigidity_min_n_per_rad", |_| None),
            Column::flag("wall_rigidity_at_least", "", rows.iter().map(|_| None)),
            count("wall_contacts", 1),
            count("wall_contacts_active", 0),
            count("closed_loops", 0),
            count("closed_loops_active", 0),
        ];
        // As it is read: what is looked at and not listed is not there.
        columns.retain(|column| metric_columns().contains(&&*column.field.name));
        let keys = TrialKey::columns(&(1..).zip(rows).map(key).collect::<Vec<_>>());
        Measured::of(Table::new("metrics", "", [keys, columns].concat()).unwrap()).unwrap()
    }
}
