//! The effect on the metrics of fewer recorded data, or of another setup of the simulated device.

use crate::Less;
use crate::setup::Rehearsed;
use zwidth_numerics::order::{quantile, sorted};
use zwidth_results::{LessKind, MetricShift, Row};
use zwidth_study::{Perception, is_felt};
use zwidth_tables::{Table, TableError};

/// Name and title of a table of shifts, and the note below it.
pub(crate) struct About {
    name: &'static str,
    title: &'static str,
    pub(crate) note: &'static str,
}

const RECORDINGS: About = About {
    name: MetricShift::NAME,
    title: MetricShift::TITLE,
    note: "Each trial is compared with itself. What is just felt is known for forces, angles, ways, work, stiffnesses and viscosities alone.",
};
pub(crate) const TWIN: About = About {
    name: "trade_twin",
    title: "What another setup of the simulated device does to the metrics",
    note: "Each simulated trial is compared with the one of the same intent at the study's own setup; the loop runs with the setup, and the hand feels it.",
};

/// What the bounds of metrics depend on.
#[derive(Debug, Clone, Copy)]
pub struct Bounds<'a> {
    /// What a person can feel.
    pub perception: &'a Perception,
    /// Lever length, m; 0 where there is none, for then nothing is in metres or joules.
    pub lever_m: f64,
}

/// For each degradation of the recordings and each metric: its mean with the full recordings, the
/// spread of its changes over the trials, how many trials lose it, and the change that a person
/// would feel, if this is known for its unit. `whole` and each of `lessened` have one row per
/// trial, in the same order.
pub fn less_shifts(
    condition: &str,
    whole: &Table,
    lessened: &[(Less, Table)],
    bounds: &Bounds<'_>,
) -> Vec<MetricShift> {
    let shifts = lessened.iter().flat_map(|(less, table)| {
        let taken = Taken { condition, kind: less.kind(), less: &less.words() };
        shifts(&taken, whole, table, bounds)
    });
    shifts.collect()
}

/// The same for other setups of the simulated device, each beside the study's own.
pub fn setup_shifts(
    condition: &str,
    rehearsed: &[Rehearsed],
    bounds: &Bounds<'_>,
) -> Vec<MetricShift> {
    let shifts = rehearsed.iter().flat_map(|Rehearsed { setup, own, changed }| {
        let taken = Taken { condition, kind: setup.kind(), less: &setup.words() };
        shifts(&taken, own, changed, bounds)
    });
    shifts.collect()
}

/// What is taken away or set otherwise, and in which condition.
struct Taken<'a> {
    condition: &'a str,
    kind: LessKind,
    less: &'a str,
}

fn shifts(taken: &Taken, whole: &Table, table: &Table, bounds: &Bounds<'_>) -> Vec<MetricShift> {
    let mut rows = Vec::new();
    for field in whole.fields() {
        let (Ok(a), Ok(b)) = (whole.floats(&field.name), table.floats(&field.name)) else {
            continue;
        };
        // A trial without the metric to begin with cannot lose it.
        let pairs = a.into_iter().zip(b).filter_map(|(a, b)| Some((a?, b)));
        let pairs: Vec<(f64, Option<f64>)> = pairs.collect();
        let changes: Vec<f64> = pairs.iter().filter_map(|(a, b)| Some((*b)? - a)).collect();
        let mean = mean(pairs.iter().map(|pair| pair.0));
        let sizes = sorted(changes.iter().map(|x| x.abs()));
        let [Some(median), Some(p90), Some(largest)] =
            [0.5, 0.9, 1.0].map(|share| quantile(&sizes, share))
        else {
            continue;
        };
        // The change that is just felt; a metric that is none of a sensation's has no such bound.
        let bound = bounds.perception.bound(mean, &field.unit, bounds.lever_m);
        let bound = bound.filter(|bound| *bound > 0.0 && is_felt(&field.name));
        rows.push(MetricShift {
            condition: taken.condition.into(),
            kind: taken.kind,
            less: taken.less.into(),
            metric: (&*field.name).into(),
            unit: (&*field.unit).into(),
            trials: pairs.len(),
            lost: pairs.len() - changes.len(),
            mean,
            change: self::mean(changes.iter().copied()),
            median_change: median,
            p90_change: p90,
            largest_change: largest,
            bound,
            median_share: bound.map(|bound| median / bound),
            p90_share: bound.map(|bound| p90 / bound),
        });
    }
    rows
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

/// The table of [`less_shifts`], of one condition or of many.
///
/// # Errors
/// A number that is not finite.
pub fn recordings_table(rows: &[MetricShift]) -> Result<Table, TableError> {
    table(&RECORDINGS, rows)
}

/// The table of [`setup_shifts`], of one condition or of many.
///
/// # Errors
/// A number that is not finite.
pub fn twin_table(rows: &[MetricShift]) -> Result<Table, TableError> {
    table(&TWIN, rows)
}

fn table(about: &About, rows: &[MetricShift]) -> Result<Table, TableError> {
    Ok(Table::of_rows(rows)?.called(about.name, about.title).with_note(about.note))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    fn peaks(values: [Option<f64>; 3]) -> Table {
        Table::new("m", "M", vec![Column::float("peak_n", "N", "", values)]).unwrap()
    }

    #[test]
    fn changes_are_of_each_trial_with_itself_and_lost_values_are_counted() {
        let whole = peaks([Some(4.0), Some(5.0), Some(6.0)]);
        let less = peaks([Some(4.5), None, Some(5.0)]);
        let lessened = [(Less::AngleBits(8), less)];
        let bounds = Bounds { perception: &Perception::default(), lever_m: 0.045 };
        let found = less_shifts("P01.S01.spring.hybrid", &whole, &lessened, &bounds);
        let shift = &found[0];
        assert!((shift.mean - 5.0).abs() < 1e-12 && (shift.change + 0.25).abs() < 1e-12);
        assert!((shift.largest_change - 1.0).abs() < 1e-12);
        assert!((shift.median_share.unwrap() - 0.75 / 0.35).abs() < 1e-12);
        assert!((shift.p90_change - 0.95).abs() < 1e-12);
        assert_eq!((shift.lost, shift.kind), (1, LessKind::Angle));
        let table = recordings_table(&found).unwrap();
        assert_eq!(table.to_rows::<MetricShift>().unwrap(), found);
        assert_eq!(twin_table(&found).unwrap().name(), "trade_twin");
    }
}
