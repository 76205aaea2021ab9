//! The rows as a table: SI units, one row per trial.

use crate::columns::{GROUPS, Get, PLANT_GROUPS, Spec, is_taken};
use crate::{PlantMetrics, TrialMetrics};
use std::collections::BTreeMap;
use zwidth_results::{Row as _, TrialKey};
use zwidth_study::{OutsideMetric, OwnMetric, ParticipantId, SessionId, TrialMeta};
use zwidth_tables::{Column, Field, Table, TableError, Type, Values};

/// One row per trial, in the order given: which trial it is, then every metric, those of the study's own
/// last. SI units; null
/// where a metric does not apply or the recording lacks what it needs. The columns' definitions are
/// at the fields of [`TrialMetrics`]'s parts and, by column, in `docs/analysis.md`.
///
/// # Errors
/// A metric that is not finite.
pub fn table(rows: &[TrialMetrics], own: &[OwnMetric]) -> Result<Table, TableError> {
    let mut columns = keys(rows.iter().map(|row| &row.meta));
    columns.extend(GROUPS.into_iter().flatten().map(|spec| column(spec, rows)));
    // One whose name is taken has no column.
    let named = own.iter().enumerate().filter(|(_, metric)| !is_taken(metric.id.as_str()));
    columns.extend(named.map(|(k, metric)| {
        let values = rows.iter().map(|row| row.own.get(k).copied().flatten());
        let field = Field {
            name: metric.id.to_string().into(),
            unit: metric.unit.clone().into(),
            description: metric.label.clone().into(),
            kind: Type::Float,
        };
        Column { field, values: Values::Float(values.collect()) }
    }));
    Table::new("metrics", "Metrics, one row per trial", columns)
}

/// One row per trial, in the order given: which trial it is, then every metric that depends on the
/// plant.
///
/// # Errors
/// A metric that is not finite.
pub fn plant_table(rows: &[PlantMetrics]) -> Result<Table, TableError> {
    let mut columns = keys(rows.iter().map(|row| &row.meta));
    columns.extend(PLANT_GROUPS.into_iter().flatten().map(|spec| column(spec, rows)));
    Table::new("metrics", "Metrics that rest on the plant, one row per trial", columns)
}

/// The table of metrics with those that depend on the plant beside them; null for a trial that has
/// no row there.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_plant(metrics: &Table, plant: &Table) -> Result<Table, TableError> {
    let (plants, trials): (Vec<TrialKey>, Vec<TrialKey>) = (plant.to_rows()?, metrics.to_rows()?);
    // Without the rest of the key, which a trial's identity does not need.
    let [plants, trials] = [plants, trials].map(|keys| {
        keys.into_iter().map(|key| (key.participant, key.session, key.trial)).collect::<Vec<_>>()
    });
    let places: BTreeMap<_, usize> = plants.into_iter().zip(0..).collect();
    let rows: Vec<Option<usize>> = trials.iter().map(|key| places.get(key).copied()).collect();
    let mut columns = metrics.columns().to_vec();
    for spec in PLANT_GROUPS.into_iter().flatten() {
        let column = plant.column(spec.name)?;
        let values = column.values.of_rows(rows.iter().copied());
        columns.push(Column { field: column.field.clone(), values });
    }
    let joined = Table::new(metrics.name(), metrics.title(), columns)?;
    let notes = metrics.notes_by_kind();
    Ok(notes.fold(joined, |table, (kind, note)| table.with_note_of(kind, note)))
}

/// A metric that another program computed, and its value after each trial that has one.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideColumn {
    /// The metric.
    pub metric: OutsideMetric,
    /// Its values by participant, session and trial.
    pub values: BTreeMap<(ParticipantId, SessionId, u32), f64>,
}

/// The table of metrics with those of other programs behind them; null for a trial without a value. A value of a trial
/// that the table does not have is left out.
///
/// # Errors
/// A table that is not of this stage; a column that it has already.
pub fn join_outside(metrics: &Table, outside: &[OutsideColumn]) -> Result<Table, TableError> {
    let trials: Vec<TrialKey> = metrics.to_rows()?;
    let names: Vec<_> =
        trials.into_iter().map(|key| (key.participant, key.session, key.trial)).collect();
    let mut columns = metrics.columns().to_vec();
    for OutsideColumn { metric, values } in outside {
        let field = Field {
            name: metric.column.to_string().into(),
            unit: metric.unit.clone().into(),
            description: metric.label.clone().into(),
            kind: Type::Float,
        };
        let values = names.iter().map(|name| values.get(name).copied()).collect();
        columns.push(Column { field, values: Values::Float(values) });
    }
    let joined = Table::new(metrics.name(), metrics.title(), columns)?;
    let notes = metrics.notes_by_kind();
    Ok(notes.fold(joined, |table, (kind, note)| table.with_note_of(kind, note)))
}

/// The metrics of several sessions as one table in the order of participant, session and trial;
/// `None` without tables.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_sessions(sessions: Vec<Table>) -> Result<Option<Table>, TableError> {
    let joined = Table::concat("metrics", "Metrics, one row per trial", sessions)?;
    let Some(all) = joined else { return Ok(None) };
    let keys: Vec<TrialKey> = all.to_rows()?;
    Ok(Some(all.sorted(|row| {
        let TrialKey { participant, session, trial, .. } = &keys[row];
        (participant, session, trial)
    })))
}

/// The columns that say which trial a row is about.
fn keys<'t>(trials: impl Iterator<Item = &'t TrialMeta>) -> Vec<Column> {
    TrialKey::columns(&trials.map(TrialKey::from).collect::<Vec<_>>())
}

fn column<R>(spec: &Spec<R>, rows: &[R]) -> Column {
    let Spec { name, unit, description, get, .. } = spec;
    match get {
        Get::Float(get) => Column::float(name, unit, description, rows.iter().map(get)),
        Get::Count(get) => Column::integer(name, unit, description, rows.iter().map(get)),
        Get::Flag(get) => Column::flag(name, description, rows.iter().map(get)),
        Get::Word(get) => {
            Column::text(name, description, rows.iter().map(|r| get(r).map(str::to_owned)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, in_spring, stroke, trial};
    use crate::{plant_metrics, trial_metrics};

    #[test]
    fn a_column_ends_in_its_unit() {
        let endings = [
            ("s", "_s"),
            ("rad", "_rad"),
            ("rad/s", "_rad_s"),
            ("N", "_n"),
            ("J", "_j"),
            ("m", "_m"),
            ("N·s", "_n_s"),
            ("N/rad", "_n_per_rad"),
            ("Hz", "_hz"),
            ("N/W", "_n_per_w"),
        ];
        let tables = [table(&[], &[]).unwrap(), plant_table(&[]).unwrap()];
        for field in tables.iter().flat_map(Table::fields).filter(|f| f.unit != "1") {
            let (_, ending) = endings.iter().find(|(unit, _)| *unit == field.unit).unwrap();
            assert!(field.name.ends_with(ending), "{}: {}", field.name, field.unit);
        }
    }

    #[test]
    fn the_trials_of_several_sessions_come_together_in_their_order() {
        let of = |person: &str, numbers: [u32; 2]| {
            let row = |number| {
                let mut trial = trial(&stroke(1.0, 2.0), |theta, _| 4.0 * (theta - REST_RAD));
                trial.meta.participant = person.parse().unwrap();
                trial.meta.trial = number;
                trial_metrics(&trial, &in_spring(4.0, REST_RAD)).unwrap()
            };
            table(&numbers.map(row), &[]).unwrap()
        };
        let all = join_sessions(vec![of("P02", [3, 4]), of("P01", [10, 9])]).unwrap().unwrap();
        let keys: Vec<TrialKey> = all.to_rows().unwrap();
        let keys: Vec<_> = keys.iter().map(|key| (key.participant.as_str(), key.trial)).collect();
        assert_eq!(keys, [("P01", 9), ("P01", 10), ("P02", 3), ("P02", 4)]);
        assert!(join_sessions(Vec::new()).unwrap().is_none());
    }

    fn names() -> impl Iterator<Item = &'static str> {
        let of_trial = GROUPS.into_iter().flatten().map(|spec| spec.name);
        of_trial.chain(PLANT_GROUPS.into_iter().flatten().map(|spec| spec.name))
    }

    #[test]
    fn metrics_of_the_plant_come_beside_those_of_their_own_trial_and_a_missing_one_is_null() {
        let parameters = in_spring(4.0, REST_RAD);
        let of = |number: u32, friction_n: f64| {
            let force = |theta: f64, v: f64| 4.0 * (theta - REST_RAD) + friction_n * v.signum();
            let mut made = trial(&stroke(1.0, 2.0), force);
            made.meta.trial = number;
            made
        };
        let trials = [of(3, 0.1), of(1, 0.2), of(2, 0.3)];
        let rows: Vec<_> = trials.iter().map(|t| trial_metrics(t, &parameters).unwrap()).collect();
        let with: Vec<_> =
            trials[..2].iter().map(|t| plant_metrics(t, &parameters, None).unwrap()).collect();
        let with = plant_table(&[with[1].clone(), with[0].clone()]).unwrap();
        let joined = join_plant(&table(&rows, &[]).unwrap(), &with).unwrap();
        let least = joined.floats("closed_loop_energy_min_j").unwrap();
        let area = joined.floats("loop_area_j").unwrap();
        assert!((least[0].unwrap() / area[0].unwrap() - 1.0).abs() < 0.02, "{least:?} {area:?}");
        assert!((least[1].unwrap() / area[1].unwrap() - 1.0).abs() < 0.02, "{least:?} {area:?}");
        assert_eq!(least[2], None);
        assert_eq!(joined.floats("discrepancy_actuator_mean_n").unwrap(), [None; 3]);
    }

    /// `docs/analysis.md` is the page on which a reader looks a column up.
    #[test]
    fn every_column_is_defined_on_the_page_about_the_analysis() {
        let page = include_str!("../../../docs/analysis.md");
        for name in names() {
            let part = name.contains("_ci_") || name.contains("_std_error_");
            assert!(part || page.contains(&format!("`{name}`")), "{name} is not defined");
        }
    }

    #[test]
    fn a_row_lands_in_its_columns_and_what_does_not_apply_is_null() {
        let trial = trial(&stroke(1.0, 2.0), |theta, _| 4.0 * (theta - REST_RAD));
        let row = trial_metrics(&trial, &at_wall(4.0, REST_RAD, 3.0)).unwrap();
        let table = table(std::slice::from_ref(&row), &[]).unwrap();
        assert_eq!(table.floats("stiffness_n_per_rad").unwrap(), [row.spring.stiffness_n_per_rad]);
        assert_eq!(table.flags("wall_reached").unwrap(), [Some(false)]);
        assert_eq!(table.floats("wall_dwell_s").unwrap(), [None]);
        assert_eq!(table.texts("mode").unwrap(), [Some("hybrid".to_owned())]);
    }
}
