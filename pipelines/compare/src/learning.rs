//! Learning: how a metric changes from one repeat of a condition to the next.

use crate::cells::{KEYS, whole};
use crate::measure::Measure;
use crate::unit::Unit;
use crate::{CompareError, Parameters, columns};
use std::collections::BTreeMap;
use zwidth_stats::paired::mean_difference;
use zwidth_stats::{Tested, Unestimable, line};
use zwidth_tables::{Column, Table};

/// The change per repeat in one condition.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    environment: usize,
    mode: usize,
    n: usize,
    change: Result<Tested, Unestimable>,
}

/// The points (repeat, value) of one participant in one condition, a list per session.
type Sessions = BTreeMap<String, Vec<[f64; 2]>>;

/// The change per repeat in every condition, as a table: the mean over participants of each one's
/// slope; of one participant, the slope of the trials. Each session has a level of its own.
pub(crate) fn table(
    metrics: &Table,
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let by_condition = by_condition(metrics, measure)?;
    let mut rows = Vec::new();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for (m, mode) in parameters.modes.iter().enumerate() {
            let key = (environment.to_string(), mode.to_string());
            let Some(people) = by_condition.get(&key) else { continue };
            rows.push(Row { environment: e, mode: m, ..row(people, unit, parameters.level) });
        }
    }
    as_table(&rows, unit, measure, parameters)
}

/// The points of each participant by condition: environment and mode.
type ByCondition = BTreeMap<(String, String), BTreeMap<String, Sessions>>;

fn by_condition(metrics: &Table, measure: &Measure) -> Result<ByCondition, CompareError> {
    let [participants, sessions, environments, modes] = KEYS.map(|key| metrics.texts(key));
    let (participants, sessions) = (participants?, sessions?);
    let (environments, modes) = (environments?, modes?);
    let (repeats, values) = (metrics.integers("repeat")?, metrics.floats(&measure.name)?);
    let mut found: BTreeMap<_, BTreeMap<_, Sessions>> = BTreeMap::new();
    for row in 0..metrics.height() {
        let (Some(repeat), Some(value)) = (repeats[row], values[row]) else { continue };
        let text = |column: &[Option<String>]| column[row].clone().unwrap_or_default();
        let condition = found.entry((text(&environments), text(&modes))).or_default();
        let sessions_of = condition.entry(text(&participants)).or_default();
        sessions_of.entry(text(&sessions)).or_default().push([repeat as f64, value]);
    }
    Ok(found)
}

fn row(people: &BTreeMap<String, Sessions>, unit: &Unit, level: f64) -> Row {
    let lists = |sessions: &Sessions| sessions.values().cloned().collect::<Vec<_>>();
    match unit {
        Unit::Participants => {
            let slopes: Vec<f64> =
                people.values().filter_map(|sessions| line::slope(&lists(sessions))).collect();
            Row {
                environment: 0,
                mode: 0,
                n: slopes.len(),
                change: mean_difference(&slopes, level),
            }
        }
        Unit::Trials { .. } => {
            let trials = people.values().flat_map(BTreeMap::values).map(Vec::len).sum();
            let none = Unestimable::TooFew { units: "trials", found: 0, needed: 3 };
            let sessions = people.values().next();
            let change = sessions.map_or(Err(none), |of| line::common_slope(&lists(of), level));
            Row { environment: 0, mode: 0, n: trials, change }
        }
    }
}

fn as_table(
    rows: &[Row],
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let remarks = rows.iter().map(|row| row.change.as_ref().err().map(ToString::to_string));
    let tested = |of: fn(&Tested) -> f64| {
        rows.iter().map(move |row| row.change.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let change: Vec<Option<Tested>> = rows.iter().map(|row| row.change.clone().ok()).collect();
    let mut all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        columns::modes(parameters, rows.iter().map(|row| row.mode)),
        columns::units(unit, rows.len()),
        Column::integer("n", "1", "units of analysis", rows.iter().map(|row| whole(row.n))),
    ];
    all.extend(columns::tested(
        measure,
        "change",
        "mean change from one repeat to the next",
        &change,
    ));
    all.extend([
        Column::float("df", "1", "degrees of freedom", tested(|t| t.df)),
        Column::float("p_value", "1", "p value of no change, not adjusted", tested(|t| t.p_value)),
        Column::text("remark", "why there is no test", remarks),
    ]);
    let title = format!("Learning per repeat: {}", measure.description);
    let table = Table::new(&format!("learning_{}", measure.name), &title, all)?;
    Ok(table.with_note("Exploratory: no claim is made from this table."))
}
