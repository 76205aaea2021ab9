//! What other setups of the simulated device do to the metrics, in short.

use crate::TradeError;
use crate::setup::Setup;
use zwidth_tables::{Column, NoteKind, Table};

/// Trials of a condition that safety refused or ended at a setup.
#[derive(Debug, Clone, PartialEq)]
pub struct Stops {
    /// The setup.
    pub setup: Setup,
    /// How many.
    pub trials: usize,
    /// Which and why, in words.
    pub why: String,
}

/// A row a setup: how many metrics the median trial of some condition has changed by more than is
/// just felt, the one that changes most, and how many trials safety stopped. `twin` is a table of
/// [`crate::join_twin`].
///
/// # Errors
/// A table that is not one of those.
pub fn twin_summary(twin: &Table, stops: &[Stops]) -> Result<Table, TradeError> {
    let [less, metrics, conditions] = ["less", "metric", "condition"].map(|name| twin.texts(name));
    let (less, metrics, conditions) = (less?, metrics?, conditions?);
    let (median, p90) = (twin.floats("median_share")?, twin.floats("p90_share")?);
    let lost = twin.integers("lost")?;
    let rows: Vec<Row> = setups(&less, stops)
        .into_iter()
        .map(|setup| {
            let at = (0..twin.height()).filter(|i| less[*i].as_ref() == Some(&setup)).collect();
            Row::of(setup, at, &metrics, &median, &lost, stops)
        })
        .collect();
    let text = |name, about, get: &dyn Fn(&Row) -> Option<String>| {
        Column::text(name, about, rows.iter().map(get))
    };
    let share = |name, about, of: &[Option<f64>]| {
        Column::float(name, "1", about, rows.iter().map(|row| of[row.worst?]))
    };
    let count = |name, about, get: fn(&Row) -> i64| {
        Column::integer(name, "1", about, rows.iter().map(|row| Some(get(row))))
    };
    let columns = vec![
        text("setup", "the setup", &|row| Some(row.setup.clone())),
        count("metrics", "metrics of which a change is known to be felt", |row| row.metrics),
        count("felt", "those that the median trial of a condition has changed by more", |row| {
            row.felt
        }),
        text("metric", "the one that changes most", &|row| metrics[row.worst?].clone()),
        text("condition", "where it does", &|row| conditions[row.worst?].clone()),
        share("median_share", "its change in the median trial over what is just felt", &median),
        share("p90_share", "the 90th percentile of that", &p90),
        count("lost", "values of metrics that trials lose", |row| row.lost),
        count("stopped", "trials that safety refused or ended", |row| row.stopped),
    ];
    let title = format!("{}, in short", twin.title());
    let table = Table::new("trade_twin_summary", &title, columns)?;
    let table = twin.notes().iter().fold(table, |table, note| table.with_note(note.clone()));
    let stopped = stops.iter().map(|stop| &stop.why);
    Ok(stopped.fold(table, |table, why| table.with_note_of(NoteKind::Care, why.clone())))
}

/// Each setup once, those last that no trial came through.
fn setups(less: &[Option<String>], stops: &[Stops]) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let stopped = stops.iter().map(|stop| stop.setup.words());
    for name in less.iter().flatten().cloned().chain(stopped) {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// What a setup does.
struct Row {
    setup: String,
    metrics: i64,
    felt: i64,
    /// The row of the metric that changes most in the median trial.
    worst: Option<usize>,
    lost: i64,
    stopped: i64,
}

impl Row {
    fn of(
        setup: String,
        at: Vec<usize>,
        metrics: &[Option<String>],
        median: &[Option<f64>],
        lost: &[Option<i64>],
        stops: &[Stops],
    ) -> Self {
        let names = |is: &dyn Fn(f64) -> bool| {
            let known = at.iter().filter(|i| median[**i].is_some_and(is));
            let mut names: Vec<&Option<String>> = known.map(|i| &metrics[*i]).collect();
            names.sort();
            names.dedup();
            names.len() as i64
        };
        let share = |i: usize| median[i].unwrap_or(f64::NEG_INFINITY);
        let known = at.iter().copied().filter(|i| median[*i].is_some());
        let stopped = stops.iter().filter(|stop| stop.setup.words() == setup);
        Self {
            metrics: names(&|_| true),
            felt: names(&|share| share > 1.0),
            worst: known.reduce(|a, b| if share(b) > share(a) { b } else { a }),
            lost: at.iter().filter_map(|i| lost[*i]).sum(),
            stopped: stopped.map(|stop| stop.trials as i64).sum(),
            setup,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bounds, Rehearsed, join_twin, twin_table};
    use zwidth_study::Perception;

    fn peaks(off: f64) -> Table {
        let values = [4.0, 5.0, 6.0].map(|peak| Some(peak + off));
        Table::new("m", "M", vec![Column::float("peak_n", "N", "", values)]).unwrap()
    }

    /// The peaks of a condition, off by so much with an angle of 8 bits and with a force of 10 Hz.
    fn rehearsed(condition: &str, off: [f64; 2]) -> Table {
        let one = |setup, off| Rehearsed { setup, own: peaks(0.0), changed: peaks(off) };
        let setups = [one(Setup::AngleBits(8), off[0]), one(Setup::ForceRateHz(10.0), off[1])];
        let bounds = Bounds { perception: &Perception::default(), lever_m: 0.045 };
        twin_table(condition, &setups, &bounds).unwrap()
    }

    #[test]
    fn a_summary_names_the_metric_that_a_setup_changes_most_and_counts_what_was_stopped() {
        let tables = vec![rehearsed("a", [0.07, 0.1]), rehearsed("b", [0.7, 0.2])];
        let stops = [Setup::ForceRateHz(10.0), Setup::SampleRateHz(30.0)];
        let stops = stops.map(|setup| Stops { setup, trials: 6, why: "refused".to_owned() });
        let found = twin_summary(&join_twin(tables).unwrap().unwrap(), &stops).unwrap();
        assert_eq!(found.integers("felt").unwrap(), [Some(1), Some(0), Some(0)]);
        assert_eq!(found.integers("stopped").unwrap(), [Some(0), Some(6), Some(6)]);
        let conditions = found.texts("condition").unwrap();
        assert_eq!((conditions[0].as_deref(), conditions[2].as_deref()), (Some("b"), None));
        assert!((found.floats("median_share").unwrap()[0].unwrap() - 2.0).abs() < 1e-9);
    }
}
