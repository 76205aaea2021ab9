//! Some rows of the table of metrics: the trials of one condition.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{EnvironmentId, ModeId};
use zwidth_tables::{Table, TableError};

/// Values by participant and session, in the order of the trials.
pub(crate) type People = BTreeMap<String, BTreeMap<String, Vec<f64>>>;

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
pub(crate) fn mean_of_one(sessions: &BTreeMap<String, Vec<f64>>) -> f64 {
    mean(sessions.values().map(|values| mean(values.iter().copied())))
}

/// Trials of one mode, in one environment or in all.
#[derive(Debug, Clone)]
pub(crate) struct Trials<'a> {
    metrics: &'a Table,
    rows: Vec<usize>,
}

impl<'a> Trials<'a> {
    pub(crate) fn of(
        metrics: &'a Table,
        environment: Option<&EnvironmentId>,
        mode: &ModeId,
    ) -> Result<Self, TableError> {
        let rows = metrics.words("environment")?.zip(metrics.words("mode")?).enumerate();
        let wanted = rows.filter(|(_, (in_environment, in_mode))| {
            environment.is_none_or(|e| *in_environment == Some(e.as_str()))
                && *in_mode == Some(mode.as_str())
        });
        Ok(Self { metrics, rows: wanted.map(|(row, _)| row).collect() })
    }

    pub(crate) fn len(&self) -> usize {
        self.rows.len()
    }

    /// The words of those trials.
    fn words(&self, column: &str) -> Result<Vec<Option<&'a str>>, TableError> {
        let all: Vec<_> = self.metrics.words(column)?.collect();
        Ok(self.rows.iter().map(|row| all[*row]).collect())
    }

    /// The values of those trials that have one.
    pub(crate) fn floats(&self, column: &str) -> Result<Vec<f64>, TableError> {
        let values = self.metrics.floats(column)?;
        Ok(self.rows.iter().filter_map(|row| values[*row]).collect())
    }

    /// Whether any of those trials says yes.
    pub(crate) fn any(&self, column: &str) -> Result<bool, TableError> {
        let values = self.metrics.flags(column)?;
        Ok(self.rows.iter().any(|row| values[*row] == Some(true)))
    }

    /// The values by participant and session of those trials that have one; of two columns their
    /// difference. Counts are numbers too.
    pub(crate) fn people(&self, column: &str, less: Option<&str>) -> Result<People, TableError> {
        let values = self.metrics.numbers(column)?;
        let less = less.map(|column| self.metrics.numbers(column)).transpose()?;
        let whose = self.words("participant")?.into_iter().zip(self.words("session")?);
        let mut people = People::new();
        for (row, (who, session)) in self.rows.iter().zip(whose) {
            let taken = less.as_ref().map_or(Some(0.0), |less| less[*row]);
            let (Some(value), Some(taken)) = (values[*row], taken) else { continue };
            let [who, session] = [who, session].map(|of| of.unwrap_or_default().to_owned());
            people.entry(who).or_default().entry(session).or_default().push(value - taken);
        }
        Ok(people)
    }

    /// The mean over participants of each one's mean, sessions with equal weight; `None` where no
    /// trial has a value.
    pub(crate) fn mean(&self, column: &str) -> Result<Option<Mean>, TableError> {
        let people = self.people(column, None)?;
        let trials = people.values().flat_map(BTreeMap::values).map(Vec::len).sum();
        Ok((trials > 0).then(|| Mean {
            mean: mean(people.values().map(mean_of_one)),
            trials,
            participants: people.len(),
        }))
    }

    /// Whose trials they are.
    pub(crate) fn participants(&self) -> Result<BTreeSet<String>, TableError> {
        Ok(self.words("participant")?.into_iter().flatten().map(str::to_owned).collect())
    }

    /// Number of trials with this word, and of trials with any.
    pub(crate) fn count(&self, column: &str, word: &str) -> Result<(usize, usize), TableError> {
        let of: Vec<&str> = self.words(column)?.into_iter().flatten().collect();
        Ok((of.iter().filter(|w| **w == word).count(), of.len()))
    }
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::columns::metric_columns;
    use zwidth_tables::Column;

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

    pub(crate) fn metrics(rows: &[MetricsRow]) -> Table {
        let text = |name, get: fn(&MetricsRow) -> &'static str| {
            Column::text(name, "", rows.iter().map(|r| Some(get(r).to_owned())))
        };
        let float = |name, get: fn(&MetricsRow) -> Option<f64>| {
            Column::float(name, "1", "", rows.iter().map(get))
        };
        let count = |name, n| Column::integer(name, "1", "", rows.iter().map(move |_| Some(n)));
        let mut columns = vec![
            text("participant", |r| r.participant),
            text("session", |_| "S01"),
            Column::integer("trial", "1", "", (1..).zip(rows).map(|(trial, _)| Some(trial))),
            text("environment", |r| r.condition.0),
            text("mode", |r| r.condition.1),
            text("source", |r| r.source),
            text("recorded_stability", |r| r.stability),
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
        Table::new("metrics", "", columns).unwrap()
    }
}
