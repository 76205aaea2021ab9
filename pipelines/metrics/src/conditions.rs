//! The metrics by condition: mean and standard deviation of the repeats.

use crate::columns::numbers;
use std::collections::BTreeMap;
use zwidth_frames::{FrameError, Group, grouped};
use zwidth_results::{ConditionKey, ConditionTrials, Row as _};
use zwidth_study::{Condition, MetricId};
use zwidth_tables::{Column, Field, Measured, Table, TableError, Values, split_unit};

/// Why there are no metrics by condition.
#[derive(Debug, thiserror::Error)]
pub enum ConditionsError {
    /// The trials could not be grouped.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The result does not make a table.
    #[error(transparent)]
    Table(#[from] TableError),
}

/// The metrics that are summarised, those of the study's `own` last. A table need not have all of them.
pub fn summarised(own: &[MetricId]) -> Vec<&str> {
    let of_all = numbers(true).filter(|(_, summarised)| *summarised).map(|(name, _)| name);
    // A study without axes may have one of its own that is called as one of a study with axes.
    let of_all = of_all.filter(|name| own.iter().all(|own| own.as_str() != *name));
    of_all.chain(own.iter().map(MetricId::as_str)).collect()
}

/// One row per participant, session and condition, sessions in the order of the trials and the
/// conditions of each in that of `conditions`, others after them: number of trials, then mean and
/// standard deviation (n − 1) of each summarised metric over the trials that have it. Null if no
/// trial has it; the deviation is null for a single trial. A metric that no trial has is left out.
///
/// # Errors
/// Metrics that are not the stage's.
pub fn by_condition(
    metrics: &Measured,
    conditions: &[Condition],
    own: &[MetricId],
) -> Result<Table, ConditionsError> {
    let keys: Vec<ConditionKey> = metrics.trials().iter().map(|trial| trial.condition()).collect();
    let present: Vec<(&Field, &[Option<f64>])> = summarised(own)
        .into_iter()
        .filter_map(|name| metrics.metric(name))
        .filter_map(|column| match &column.values {
            Values::Float(values) => Some((&column.field, values.as_slice())),
            _ => None,
        })
        .filter(|(_, values)| values.iter().any(Option::is_some))
        .collect();
    let values: Vec<_> = present.iter().map(|(_, values)| *values).collect();
    let groups = ordered(grouped(&keys, &values)?, conditions);

    let trials: Vec<ConditionTrials> = groups.iter().map(row).collect();
    let mut columns = ConditionTrials::columns(&trials);
    let mut notes = Vec::new();
    for (place, (field, _)) in present.iter().enumerate() {
        let mean = Field {
            description: format!("mean of: {}", field.description).into(),
            ..(*field).clone()
        };
        let sd = Field {
            name: deviation(field).into(),
            description: format!("standard deviation of: {}", field.description).into(),
            ..(*field).clone()
        };
        let means = groups.iter().map(|group| group.numbers[place].mean).collect();
        let sds = groups.iter().map(|group| group.numbers[place].sd).collect();
        columns.push(Column { field: mean, values: Values::Float(means) });
        columns.push(Column { field: sd, values: Values::Float(sds) });
        for Group { key, rows, numbers } in &groups {
            let count = numbers[place].count;
            // A mean over no trial is null and speaks for itself.
            if 0 < count && count < *rows {
                notes.push(format!(
                    "{}: {} × {}: over {count} of the {rows} trials.",
                    field.description, key.environment, key.mode
                ));
            }
        }
    }
    let table = Table::new(ConditionTrials::NAME, ConditionTrials::TITLE, columns)?;
    Ok(notes.into_iter().fold(table, Table::with_note))
}

fn row(group: &Group<ConditionKey>) -> ConditionTrials {
    let ConditionKey { participant, session, environment, mode } = group.key.clone();
    ConditionTrials { participant, session, environment, mode, n: group.rows }
}

/// The groups of each session in the order of `conditions`; those of others after them.
fn ordered(
    mut groups: Vec<Group<ConditionKey>>,
    conditions: &[Condition],
) -> Vec<Group<ConditionKey>> {
    // In the order of their first rows.
    let mut sessions = BTreeMap::new();
    for Group { key, .. } in &groups {
        let number = sessions.len();
        sessions.entry((key.participant.clone(), key.session.clone())).or_insert(number);
    }
    groups.sort_by_cached_key(|Group { key, .. }| {
        let place = conditions
            .iter()
            .position(|c| (&c.environment, &c.mode) == (&key.environment, &key.mode))
            .unwrap_or(conditions.len());
        (sessions.get(&(key.participant.clone(), key.session.clone())).copied(), place)
    });
    groups
}

/// `stiffness_n_per_rad` → `stiffness_sd_n_per_rad`: the unit stays last.
fn deviation(field: &Field) -> String {
    let (stem, unit) = split_unit(&field.name, &field.unit);
    format!("{stem}_sd{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::TrialKey;
    use zwidth_study::Source;

    fn metrics(rows: &[(&str, Option<f64>)]) -> Measured {
        let key = |(trial, (mode, _)): (u32, &(&str, Option<f64>))| TrialKey {
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial,
            repeat: 1,
            environment: "spring".parse().unwrap(),
            mode: mode.parse().unwrap(),
            source: Source::Recorded,
        };
        let mut columns = TrialKey::columns(&(1..).zip(rows).map(key).collect::<Vec<_>>());
        columns.extend([
            Column::float("duration_s", "s", "duration", rows.iter().map(|(_, v)| *v)),
            Column::float("wall_dwell_s", "s", "time past the wall", rows.iter().map(|_| None)),
        ]);
        Measured::of(Table::new("metrics", "", columns).unwrap()).unwrap()
    }

    fn condition(mode: &str) -> Condition {
        let environment = zwidth_study::EnvironmentId::new("spring").unwrap();
        Condition { environment, mode: zwidth_study::ModeId::new(mode).unwrap() }
    }

    #[test]
    fn conditions_stand_in_the_order_of_the_study_and_unknown_ones_after_them() {
        let rows =
            [("c", Some(3.0)), ("new", None), ("a", Some(1.0)), ("b", Some(2.0)), ("a", Some(1.0))];
        let table = by_condition(&metrics(&rows), &["a", "b", "c"].map(condition), &[]).unwrap();
        let modes: Vec<_> = table.texts("mode").unwrap().into_iter().flatten().collect();
        assert_eq!(modes, ["a", "b", "c", "new"]);
        assert_eq!(table.floats("duration_s").unwrap(), [Some(1.0), Some(2.0), Some(3.0), None]);
    }

    #[test]
    fn repeats_become_mean_and_deviation_of_their_condition() {
        let rows = [("b", Some(1.0)), ("a", Some(5.0)), ("b", Some(3.0)), ("b", None)];
        let table = by_condition(&metrics(&rows), &[condition("b"), condition("a")], &[]).unwrap();
        assert_eq!(table.texts("mode").unwrap(), [Some("b".to_owned()), Some("a".to_owned())]);
        assert_eq!(table.integers("n").unwrap(), [Some(3), Some(1)]);
        assert_eq!(table.floats("duration_s").unwrap(), [Some(2.0), Some(5.0)]);
        assert_eq!(table.notes(), ["duration: spring × b: over 2 of the 3 trials."]);
        assert_eq!(table.floats("duration_sd_s").unwrap(), [Some(std::f64::consts::SQRT_2), None]);
    }

    #[test]
    fn a_metric_that_no_trial_has_is_left_out() {
        let table = by_condition(&metrics(&[("a", Some(1.0))]), &[], &[]).unwrap();
        assert!(table.floats("wall_dwell_s").is_err());
    }
}
