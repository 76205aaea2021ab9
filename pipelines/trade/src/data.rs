//! What less of a recording, or another setup of the simulated device, does to the metrics, as
//! tables.

use crate::setup::Rehearsed;
use crate::{Less, TradeError};
use zwidth_study::{Perception, is_felt};
use zwidth_tables::{Column, Table};

/// A table's name, title and note.
type About = [&'static str; 3];
const RECORDINGS: About = [
    "trade_data",
    "What coarser recordings do to the metrics",
    "Each trial is compared with itself. What is just felt is known for forces, angles, ways, work, stiffnesses and viscosities alone.",
];
const TWIN: About = [
    "trade_twin",
    "What another setup of the simulated device does to the metrics",
    "Each simulated trial is compared with the one of the same intent at the study's own setup; the loop runs with the setup, and the hand feels it.",
];

/// What the bounds of metrics depend on.
#[derive(Debug, Clone, Copy)]
pub struct Bounds<'a> {
    /// What a person can feel.
    pub perception: &'a Perception,
    /// Lever length, m; 0 where there is none, for then nothing is in metres or joules.
    pub lever_m: f64,
}

impl Bounds<'_> {
    /// The change of a metric that is just felt.
    fn of(&self, metric: &str, unit: &str, mean: f64) -> Option<f64> {
        let bound = self.perception.bound(mean, unit, self.lever_m);
        bound.filter(|bound| *bound > 0.0 && is_felt(metric))
    }
}

/// A metric with less of the recordings, or with another setup.
struct Row {
    kind: &'static str,
    less: String,
    metric: String,
    unit: String,
    trials: usize,
    lost: usize,
    mean: f64,
    change: f64,
    /// Of the changes' sizes: the median, the 90th percentile, the largest.
    sizes: [f64; 3],
    bound: Option<f64>,
}

/// For everything that is taken from the recordings and each metric: its mean with all of them, how
/// its changes are spread over the trials, how many trials lose it, and the change that a person
/// would feel, where one is known for its unit. `whole` and each of `lessened` have one row per
/// trial, in the same order.
///
/// # Errors
/// None that tables of one form can cause.
pub fn data_table(
    condition: &str,
    whole: &Table,
    lessened: &[(Less, Table)],
    bounds: &Bounds<'_>,
) -> Result<Table, TradeError> {
    let of =
        |(less, table): &(Less, Table)| rows((less.kind(), less.words()), whole, table, bounds);
    table(RECORDINGS, condition, &lessened.iter().flat_map(of).collect::<Vec<_>>())
}

/// The same for other setups of the simulated device, each beside the study's own.
///
/// # Errors
/// None that tables of one form can cause.
pub fn twin_table(
    condition: &str,
    rehearsed: &[Rehearsed],
    bounds: &Bounds<'_>,
) -> Result<Table, TradeError> {
    let of = |r: &Rehearsed| rows((r.setup.kind(), r.setup.words()), &r.own, &r.changed, bounds);
    table(TWIN, condition, &rehearsed.iter().flat_map(of).collect::<Vec<_>>())
}

fn rows(
    (kind, less): (&'static str, String),
    whole: &Table,
    table: &Table,
    bounds: &Bounds<'_>,
) -> Vec<Row> {
    let mut rows = Vec::new();
    for field in whole.fields() {
        let (Ok(a), Ok(b)) = (whole.floats(&field.name), table.floats(&field.name)) else {
            continue;
        };
        let pairs = a.into_iter().zip(b).filter_map(|(a, b)| Some((a?, b)));
        let pairs: Vec<(f64, Option<f64>)> = pairs.collect();
        let changes: Vec<f64> = pairs.iter().filter_map(|(a, b)| Some((*b)? - a)).collect();
        if changes.is_empty() {
            continue;
        }
        let mean = mean(pairs.iter().map(|pair| pair.0));
        let mut sizes: Vec<f64> = changes.iter().map(|x| x.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        rows.push(Row {
            kind,
            less: less.clone(),
            metric: field.name.to_string(),
            unit: field.unit.to_string(),
            trials: pairs.len(),
            lost: pairs.len() - changes.len(),
            mean,
            change: self::mean(changes.iter().copied()),
            sizes: [0.5, 0.9, 1.0].map(|level| quantile(&sizes, level)),
            bound: bounds.of(&field.name, &field.unit, mean),
        });
    }
    rows
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// The quantile of sorted values, on straight lines between them (Hyndman & Fan 1996, type 7).
fn quantile(sorted: &[f64], level: f64) -> f64 {
    let place = level * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

fn table([name, title, note]: About, condition: &str, rows: &[Row]) -> Result<Table, TradeError> {
    let text = |name, about, get: fn(&Row) -> &str| {
        Column::text(name, about, rows.iter().map(|row| Some(get(row).to_owned())))
    };
    let float = |name, about, get: fn(&Row) -> Option<f64>| {
        Column::float(name, "1", about, rows.iter().map(get))
    };
    let count = |name, about, get: fn(&Row) -> usize| {
        Column::integer(name, "1", about, rows.iter().map(|row| Some(get(row) as i64)))
    };
    let share = |row: &Row, which: usize| row.bound.map(|bound| row.sizes[which] / bound);
    let shares = |which: usize| rows.iter().map(move |row| share(row, which));
    let columns = vec![
        Column::text(
            "condition",
            "participant, session, environment and mode",
            rows.iter().map(|_| Some(condition.to_owned())),
        ),
        text("kind", "what that is a degree of", |row| row.kind),
        text("less", "what is taken away or set otherwise", |row| &row.less),
        text("metric", "the metric", |row| &row.metric),
        text("unit", "the unit of mean, changes and bound", |row| &row.unit),
        count("trials", "trials that have it as they are", |row| row.trials),
        count("lost", "those of them that have it no longer", |row| row.lost),
        float("mean", "mean of the trials as they are", |row| Some(row.mean)),
        float("change", "mean of its changes", |row| Some(row.change)),
        float("median_change", "median of the changes' sizes", |row| Some(row.sizes[0])),
        float("p90_change", "their 90th percentile", |row| Some(row.sizes[1])),
        float("largest_change", "the largest of them", |row| Some(row.sizes[2])),
        float("bound", "change that is just felt", |row| row.bound),
        Column::float("median_share", "1", "median change over that", shares(0)),
        Column::float("p90_share", "1", "90th percentile over that", shares(1)),
    ];
    Ok(Table::new(name, title, columns)?.with_note(note))
}

/// The tables of conditions, one after the other.
///
/// # Errors
/// Tables that are not of this stage.
pub fn join_conditions(conditions: Vec<Table>) -> Result<Option<Table>, TradeError> {
    join(RECORDINGS, conditions)
}

/// The same for tables of the simulated device.
///
/// # Errors
/// Tables that are not of [`twin_table`].
pub fn join_twin(conditions: Vec<Table>) -> Result<Option<Table>, TradeError> {
    join(TWIN, conditions)
}

fn join([name, title, note]: About, tables: Vec<Table>) -> Result<Option<Table>, TradeError> {
    Ok(Table::concat(name, title, tables)?.map(|table| table.with_note(note)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peaks(values: [Option<f64>; 3]) -> Table {
        Table::new("m", "M", vec![Column::float("peak_n", "N", "", values)]).unwrap()
    }

    #[test]
    fn changes_are_of_each_trial_with_itself_and_lost_values_are_counted() {
        let whole = peaks([Some(4.0), Some(5.0), Some(6.0)]);
        let less = peaks([Some(4.5), None, Some(5.0)]);
        let lessened = [(Less::AngleBits(8), less)];
        let bounds = Bounds { perception: &Perception::default(), lever_m: 0.045 };
        let found = data_table("P01.S01.spring.hybrid", &whole, &lessened, &bounds).unwrap();
        let float = |name: &str| found.floats(name).unwrap()[0].unwrap();
        assert!((float("mean") - 5.0).abs() < 1e-12 && (float("change") + 0.25).abs() < 1e-12);
        assert!((float("largest_change") - 1.0).abs() < 1e-12);
        assert!((float("median_share") - 0.75 / 0.35).abs() < 1e-12);
        assert!((float("p90_change") - 0.95).abs() < 1e-12);
        assert_eq!(found.integers("lost").unwrap(), [Some(1)]);
    }

    #[test]
    fn a_quantile_lies_on_straight_lines_between_the_values() {
        let values = [1.0, 2.0, 4.0];
        let at = |level| quantile(&values, level);
        assert!((at(0.5) - 2.0).abs() < 1e-15 && (at(0.9) - 3.6).abs() < 1e-12);
        assert!((at(1.0) - 4.0).abs() < 1e-15 && (quantile(&[7.0], 0.9) - 7.0).abs() < 1e-15);
    }
}
