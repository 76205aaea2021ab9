//! The mean at each repeat of a condition, over the units of analysis: what learning looks like.

use crate::cells::{KEYS, whole};
use crate::measure::Measure;
use crate::unit::Unit;
use crate::{CompareError, Parameters};
use std::collections::BTreeMap;
use zwidth_stats::interval::{Mean, mean};
use zwidth_tables::{Column, Table};

/// Values of a repeat by participant, over their sessions.
type ByPerson = BTreeMap<String, Vec<f64>>;

/// One row per environment, mode and repeat: the mean over participants of each one's mean over
/// sessions, with its interval; of one participant, the mean over sessions.
pub(crate) fn table(
    metrics: &Table,
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let mut rows: Vec<([usize; 2], i64, Mean)> = Vec::new();
    for ((condition, repeat), people) in by_repeat(metrics, measure, parameters)? {
        let own = people.values().map(|values| values.iter().sum::<f64>() / values.len() as f64);
        let over = mean(&own.collect::<Vec<_>>(), parameters.level)?;
        rows.push((condition, repeat, over));
    }
    let end = |of: fn(&zwidth_stats::interval::Estimate) -> f64| {
        rows.iter().map(move |(_, _, mean)| mean.interval.as_ref().map(of)).collect::<Vec<_>>()
    };
    let columns = vec![
        Column::text(
            "environment",
            "what was rendered",
            rows.iter().map(|(of, _, _)| Some(parameters.environments[of[0]].as_str())),
        ),
        Column::text(
            "mode",
            "how it was rendered",
            rows.iter().map(|(of, _, _)| Some(parameters.modes[of[1]].as_str())),
        ),
        Column::integer("repeat", "1", "repeat of the condition", rows.iter().map(|r| Some(r.1))),
        Column::integer("n", "1", "participants", rows.iter().map(|r| whole(r.2.n))),
        measure.column("mean", "mean over participants", rows.iter().map(|r| r.2.estimate)),
        measure.column("ci_low", "lower end of its interval", end(|e| e.ci_low)),
        measure.column("ci_high", "upper end of its interval", end(|e| e.ci_high)),
    ];
    let title = format!("By repeat: {}", measure.description);
    let table = Table::new(&format!("repeats_{}", measure.name), &title, columns)?;
    Ok(table.with_note(match unit {
        Unit::Participants => {
            "Mean over participants, whiskers: its interval; no claim is made about single repeats."
        }
        Unit::Trials { .. } => {
            "One participant: each dot is one trial, or the mean of the sessions."
        }
    }))
}

/// Everybody's values at each repeat of each condition.
fn by_repeat(
    metrics: &Table,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<BTreeMap<([usize; 2], i64), ByPerson>, CompareError> {
    let [participants, _, environments, modes] = KEYS.map(|key| metrics.texts(key));
    let (participants, environments, modes) = (participants?, environments?, modes?);
    let (repeats, values) = (metrics.integers("repeat")?, metrics.floats(&measure.name)?);
    let mut found: BTreeMap<_, ByPerson> = BTreeMap::new();
    for row in 0..metrics.height() {
        let text = |column: &[Option<String>]| column[row].clone().unwrap_or_default();
        let (environment, mode) = (text(&environments), text(&modes));
        let condition = parameters.condition(&environment, &mode);
        let (Some(condition), Some(repeat), Some(value)) = (condition, repeats[row], values[row])
        else {
            continue;
        };
        let people = found.entry((condition, repeat)).or_default();
        people.entry(text(&participants)).or_default().push(value);
    }
    Ok(found)
}
