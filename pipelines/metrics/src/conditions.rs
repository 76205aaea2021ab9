//! The metrics by condition: mean and standard deviation of the repeats, as a query.

use crate::columns::numbers;
use std::borrow::Cow;
use std::collections::BTreeMap;
use zwidth_frames::{Aggregate, Frame, FrameError, Statistic};
use zwidth_study::Condition;
use zwidth_tables::{Field, Table, TableError, Type, of_trials, split_unit};

/// What the repeats of a condition share: the unit of analysis is one participant in one session.
const GROUP: [&str; 4] = ["participant", "session", "environment", "mode"];

/// The columns that [`by_condition`] looks at.
pub fn condition_columns() -> Vec<&'static str> {
    GROUP.into_iter().chain(summarised()).collect()
}

/// The metrics that are summarised.
fn summarised() -> impl Iterator<Item = &'static str> {
    numbers().filter(|(_, summarised)| *summarised).map(|(name, _)| name)
}

/// One row per participant, session and condition, sessions in the order of the trials and the
/// conditions of each in that of `conditions`: number of trials, then mean and standard deviation
/// (n − 1) of each summarised metric over the trials that have it. Null if no trial has it; the
/// deviation is null for a single trial. A metric that no trial has is left out.
///
/// # Errors
/// A table that is not the stage's.
pub fn by_condition(metrics: &Table, conditions: &[Condition]) -> Result<Table, FrameError> {
    let metrics = &ordered(metrics, conditions)?;
    let present: Vec<&Field> = summarised()
        .filter_map(|name| metrics.fields().find(|f| f.name == name))
        .filter(|f| metrics.floats(&f.name).is_ok_and(|v| v.iter().any(Option::is_some)))
        .collect();
    let aggregates: Vec<Aggregate> = present.iter().flat_map(|field| aggregates(field)).collect();
    let grouped = Frame::new(metrics)?.grouped(&GROUP, "n", &aggregates)?;
    let title = "Metrics by condition: mean and SD of each participant's repeats";
    let table = grouped.to_table("conditions", title, fields(metrics, &present))?;
    Ok(incomplete(metrics, &present, &grouped)?.into_iter().fold(table, Table::with_note))
}

/// The rows of each session in the order of `conditions`; those of others after them.
fn ordered(metrics: &Table, conditions: &[Condition]) -> Result<Table, TableError> {
    let [people, sessions, environments, modes] = GROUP.map(|name| metrics.words(name));
    let rows = people?.zip(sessions?).zip(environments?.zip(modes?));
    // In the order of their first rows.
    let mut sessions = BTreeMap::new();
    let mut keys = Vec::new();
    for (session, (environment, mode)) in rows {
        let number = sessions.len();
        let number = *sessions.entry(session).or_insert(number);
        let is = |c: &Condition| {
            (Some(c.environment.as_str()), Some(c.mode.as_str())) == (environment, mode)
        };
        keys.push((number, conditions.iter().position(is).unwrap_or(conditions.len())));
    }
    let mut rows: Vec<usize> = (0..keys.len()).collect();
    rows.sort_by_key(|row| keys[*row]);
    Ok(metrics.rows(&rows))
}

/// The metrics of several sessions as one table in the order of participant, session and trial;
/// `None` without tables.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_sessions(sessions: Vec<Table>) -> Result<Option<Table>, TableError> {
    of_trials("metrics", "Metrics, one row per trial", sessions)
}

/// What is made of a metric's values in one condition.
fn aggregates(field: &Field) -> [Aggregate; 3] {
    let aggregate =
        |statistic, name: String| Aggregate { of: field.name.to_string(), statistic, name };
    [
        aggregate(Statistic::Mean, field.name.to_string()),
        aggregate(Statistic::Deviation, deviation(field)),
        aggregate(Statistic::Count, count(field)),
    ]
}

/// Where a metric is over fewer trials than the condition's n, in words.
fn incomplete(
    metrics: &Table,
    present: &[&Field],
    grouped: &Frame,
) -> Result<Vec<String>, FrameError> {
    let mut fields: Vec<Field> = fields(metrics, &[]);
    let counted = |f: &&Field| Field { name: count(f).into(), kind: Type::Integer, ..(*f).clone() };
    fields.extend(present.iter().map(counted));
    let counts = grouped.to_table("counts", "", fields)?;
    let (environments, modes, n) =
        (counts.texts("environment")?, counts.texts("mode")?, counts.integers("n")?);
    let mut notes = Vec::new();
    for field in present {
        for (row, has) in counts.integers(&count(field))?.into_iter().enumerate() {
            let (has, of) = (has.unwrap_or(0), n[row].unwrap_or(0));
            if 0 < has && has < of {
                let of_row = |c: &[Option<String>]| c[row].clone().unwrap_or_default();
                let condition = format!("{} × {}", of_row(&environments), of_row(&modes));
                notes.push(format!(
                    "{}: {condition}: over {has} of the {of} trials.",
                    field.description
                ));
            }
        }
    }
    Ok(notes)
}

fn fields(metrics: &Table, present: &[&Field]) -> Vec<Field> {
    let keys = metrics.fields().filter(|f| GROUP.contains(&f.name.as_ref())).cloned();
    let n = Field {
        name: "n".into(),
        unit: "1".into(),
        description: "trials".into(),
        kind: Type::Integer,
    };
    let numbers = present.iter().flat_map(|f| {
        let mean =
            Field { description: format!("mean of: {}", f.description).into(), ..(*f).clone() };
        let sd = Field {
            name: Cow::Owned(deviation(f)),
            description: format!("standard deviation of: {}", f.description).into(),
            ..(*f).clone()
        };
        [mean, sd]
    });
    keys.chain([n]).chain(numbers).collect()
}

/// The column that counts a metric's trials.
fn count(field: &Field) -> String {
    format!("{} trials", field.name)
}

/// `stiffness_n_per_rad` → `stiffness_sd_n_per_rad`: the unit stays last.
fn deviation(field: &Field) -> String {
    let (stem, unit) = split_unit(&field.name, &field.unit);
    format!("{stem}_sd{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn metrics(rows: &[(&str, Option<f64>)]) -> Table {
        let same =
            |name, value: &str| Column::text(name, "", rows.iter().map(|_| Some(value.to_owned())));
        let columns = vec![
            same("participant", "P01"),
            same("session", "S01"),
            same("environment", "spring"),
            Column::text("mode", "", rows.iter().map(|(mode, _)| Some((*mode).to_owned()))),
            Column::float("duration_s", "s", "duration", rows.iter().map(|(_, v)| *v)),
            Column::float("wall_dwell_s", "s", "time past the wall", rows.iter().map(|_| None)),
        ];
        Table::new("metrics", "", columns).unwrap()
    }

    fn condition(mode: &str) -> Condition {
        let environment = zwidth_study::EnvironmentId::new("spring").unwrap();
        Condition { environment, mode: zwidth_study::ModeId::new(mode).unwrap() }
    }

    #[test]
    fn conditions_stand_in_the_order_of_the_study_and_unknown_ones_after_them() {
        let rows =
            [("c", Some(3.0)), ("new", None), ("a", Some(1.0)), ("b", Some(2.0)), ("a", Some(1.0))];
        let table = by_condition(&metrics(&rows), &["a", "b", "c"].map(condition)).unwrap();
        let modes: Vec<_> = table.texts("mode").unwrap().into_iter().flatten().collect();
        assert_eq!(modes, ["a", "b", "c", "new"]);
        assert_eq!(table.floats("duration_s").unwrap(), [Some(1.0), Some(2.0), Some(3.0), None]);
    }

    #[test]
    fn repeats_become_mean_and_deviation_of_their_condition() {
        let rows = [("b", Some(1.0)), ("a", Some(5.0)), ("b", Some(3.0)), ("b", None)];
        let table = by_condition(&metrics(&rows), &[condition("b"), condition("a")]).unwrap();
        assert_eq!(table.texts("mode").unwrap(), [Some("b".to_owned()), Some("a".to_owned())]);
        assert_eq!(table.integers("n").unwrap(), [Some(3), Some(1)]);
        assert_eq!(table.floats("duration_s").unwrap(), [Some(2.0), Some(5.0)]);
        assert_eq!(table.notes(), ["duration: spring × b: over 2 of the 3 trials."]);
        assert_eq!(table.floats("duration_sd_s").unwrap(), [Some(std::f64::consts::SQRT_2), None]);
    }

    #[test]
    fn a_metric_that_no_trial_has_is_left_out() {
        let table = by_condition(&metrics(&[("a", Some(1.0))]), &[]).unwrap();
        assert!(table.floats("wall_dwell_s").is_err());
    }
}
