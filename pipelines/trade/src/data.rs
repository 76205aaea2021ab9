//! What less of a recording does to its metrics, as a table.

use crate::{Less, TradeError};
use zwidth_dynamics::force_bound_n;
use zwidth_study::{Perception, is_felt};
use zwidth_tables::{Column, Table};

/// The table's name, title and note.
const NAME: &str = "trade_data";
const TITLE: &str = "Less of the recordings: what it does to the metrics";
const NOTE: &str = "Each trial is compared with itself; what is felt is known for forces, angles and stiffnesses alone. At the left edge: a thousandth or less.";

/// A metric with less of the recordings.
struct Row {
    kind: &'static str,
    less: String,
    metric: String,
    unit: String,
    trials: usize,
    lost: usize,
    mean: f64,
    change: f64,
    largest: f64,
    bound: Option<f64>,
}

/// For everything that is taken from the recordings and each metric: its mean with all of them, the mean
/// and the largest of its changes over the trials, how many trials lose it, and the change that a person
/// would feel, where one is known for its unit. `whole` and each of `lessened` have a row a trial, in the
/// same order.
///
/// # Errors
/// None that tables of one form can cause.
pub fn data_table(
    condition: &str,
    whole: &Table,
    lessened: &[(Less, Table)],
    perception: &Perception,
) -> Result<Table, TradeError> {
    let mut rows = Vec::new();
    for (less, table) in lessened {
        for field in whole.fields() {
            let (Ok(a), Ok(b)) = (whole.floats(&field.name), table.floats(&field.name)) else {
                continue;
            };
            rows.extend(row(*less, &field.name, &field.unit, &a, &b, perception));
        }
    }
    let text = |name, about, get: fn(&Row) -> &String| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row).clone())))
    };
    let float = |name, about, get: fn(&Row) -> Option<f64>| {
        Column::float(name, "1", about, rows.iter().map(get))
    };
    let count = |name, about, get: fn(&Row) -> usize| {
        Column::integer(name, "1", about, rows.iter().map(|row| Some(get(row) as i64)))
    };
    let columns = vec![
        Column::text(
            "condition",
            "participant, session, environment and mode",
            rows.iter().map(|_| Some(condition.to_owned())),
        ),
        Column::text(
            "kind",
            "what that is a degree of",
            rows.iter().map(|row| Some(row.kind.to_owned())),
        ),
        text("less", "what is taken from the recordings", |row| &row.less),
        text("metric", "the metric", |row| &row.metric),
        text("unit", "the unit of mean, changes and bound", |row| &row.unit),
        count("trials", "trials that have it with all of the recording", |row| row.trials),
        count("lost", "those of them that have it no longer", |row| row.lost),
        float("mean", "mean with all of the recordings", |row| Some(row.mean)),
        float("change", "mean of its changes", |row| Some(row.change)),
        float("largest_change", "largest of its changes, either way", |row| Some(row.largest)),
        float("bound", "change that is just felt", |row| row.bound),
        float("felt_share", "largest change over that", |row| {
            row.bound.map(|bound| row.largest / bound)
        }),
    ];
    let table = Table::new(NAME, TITLE, columns)?;
    Ok(table.with_note(NOTE))
}

/// The tables of conditions, one after the other.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_conditions(conditions: &[Table]) -> Result<Option<Table>, TradeError> {
    Ok(Table::concat(NAME, TITLE, conditions)?.map(|table| table.with_note(NOTE)))
}

fn row(
    less: Less,
    metric: &str,
    unit: &str,
    whole: &[Option<f64>],
    less_of: &[Option<f64>],
    perception: &Perception,
) -> Option<Row> {
    let pairs = whole.iter().zip(less_of).filter_map(|(a, b)| Some(((*a)?, *b)));
    let pairs: Vec<(f64, Option<f64>)> = pairs.collect();
    let changes: Vec<f64> = pairs.iter().filter_map(|(a, b)| Some((*b)? - a)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let all: Vec<f64> = pairs.iter().map(|pair| pair.0).collect();
    (!changes.is_empty()).then(|| Row {
        kind: less.kind(),
        less: less.words(),
        metric: metric.to_owned(),
        unit: unit.to_owned(),
        trials: pairs.len(),
        lost: pairs.len() - changes.len(),
        mean: mean(&all),
        change: mean(&changes),
        largest: changes.iter().map(|x| x.abs()).fold(0.0, f64::max),
        bound: bound(unit, mean(&all), perception).filter(|_| is_felt(metric)),
    })
}

/// The change of a metric that is just felt, by its unit.
fn bound(unit: &str, mean: f64, perception: &Perception) -> Option<f64> {
    match unit {
        "N" => Some(force_bound_n(mean, perception)),
        "rad" => Some(perception.angle_rad),
        "N/rad" => Some(perception.compliance_share * mean.abs()).filter(|bound| *bound > 0.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_are_of_each_trial_with_itself_and_lost_values_are_counted() {
        let table = |values: [Option<f64>; 3]| {
            Table::new("m", "M", vec![Column::float("peak_n", "N", "", values)]).unwrap()
        };
        let whole = table([Some(4.0), Some(5.0), Some(6.0)]);
        let less = table([Some(4.5), None, Some(5.0)]);
        let perception = Perception::default();
        let found =
            data_table("P01.S01.spring.hybrid", &whole, &[(Less::AngleBits(8), less)], &perception)
                .unwrap();
        let float = |name: &str| found.floats(name).unwrap()[0].unwrap();
        assert!((float("mean") - 5.0).abs() < 1e-12 && (float("change") + 0.25).abs() < 1e-12);
        assert!((float("largest_change") - 1.0).abs() < 1e-12);
        assert!((float("felt_share") - 1.0 / 0.35).abs() < 1e-12);
        assert_eq!(found.integers("lost").unwrap(), [Some(1)]);
    }
}
