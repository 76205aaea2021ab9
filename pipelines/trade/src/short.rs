//! What other setups of the simulated device do to the metrics, in short.

use crate::data::TWIN;
use crate::setup::Setup;
use std::collections::BTreeSet;
use std::sync::Arc;
use zwidth_results::{MetricShift, SetupSummary};
use zwidth_tables::{NoteKind, Table, TableError};

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

/// One row per setup: how many metrics change by more than is just felt in the median trial of some
/// condition, the one that changes most, and how many trials safety stopped. `shifts` are those of
/// all conditions.
pub fn twin_summary(shifts: &[MetricShift], stops: &[Stops]) -> Vec<SetupSummary> {
    // Each setup once, those last that no trial came through.
    let mut setups: Vec<Arc<str>> = Vec::new();
    let stopped = stops.iter().map(|stop| Arc::from(stop.setup.words()));
    for setup in shifts.iter().map(|shift| shift.less.clone()).chain(stopped) {
        if !setups.contains(&setup) {
            setups.push(setup);
        }
    }
    setups.into_iter().map(|setup| summary(setup, shifts, stops)).collect()
}

fn summary(setup: Arc<str>, shifts: &[MetricShift], stops: &[Stops]) -> SetupSummary {
    let own: Vec<&MetricShift> = shifts.iter().filter(|shift| shift.less == setup).collect();
    let shares: Vec<(&MetricShift, f64)> =
        own.iter().filter_map(|shift| Some((*shift, shift.median_share?))).collect();
    // By name: a metric that changes in several conditions counts once.
    let [metrics, felt] = [f64::NEG_INFINITY, 1.0].map(|least| {
        let above = shares.iter().filter(|(_, share)| *share > least);
        above.map(|(shift, _)| &shift.metric).collect::<BTreeSet<_>>().len()
    });
    // Of equal ones the first.
    let worst = shares.iter().reduce(|most, next| if next.1 > most.1 { next } else { most });
    let worst = worst.map(|(shift, _)| *shift);
    let stopped = stops.iter().filter(|stop| stop.setup.words() == *setup);
    SetupSummary {
        metrics,
        felt,
        metric: worst.map(|shift| shift.metric.clone()),
        condition: worst.map(|shift| shift.condition.clone()),
        median_share: worst.and_then(|shift| shift.median_share),
        p90_share: worst.and_then(|shift| shift.p90_share),
        lost: own.iter().map(|shift| shift.lost).sum(),
        stopped: stopped.map(|stop| stop.trials).sum(),
        setup,
    }
}

/// The table of [`twin_summary`], with why safety stopped trials.
///
/// # Errors
/// None that its rows can cause.
pub fn twin_summary_table(rows: &[SetupSummary], stops: &[Stops]) -> Result<Table, TableError> {
    let table = Table::of_rows(rows)?.with_note(TWIN.note);
    let stopped = stops.iter().map(|stop| &stop.why);
    Ok(stopped.fold(table, |table, why| table.with_note_of(NoteKind::Care, why.clone())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bounds, Rehearsed, setup_shifts};
    use zwidth_study::Perception;
    use zwidth_tables::Column;

    fn peaks(off: f64) -> Table {
        let values = [4.0, 5.0, 6.0].map(|peak| Some(peak + off));
        Table::new("m", "M", vec![Column::float("peak_n", "N", "", values)]).unwrap()
    }

    /// The peaks of a condition, off by so much with an angle of 8 bits and with a force of 10 Hz.
    fn rehearsed(condition: &str, off: [f64; 2]) -> Vec<MetricShift> {
        let one = |setup, off| Rehearsed { setup, own: peaks(0.0), changed: peaks(off) };
        let setups = [one(Setup::AngleBits(8), off[0]), one(Setup::ForceRateHz(10.0), off[1])];
        let bounds = Bounds { perception: &Perception::default(), lever_m: 0.045 };
        setup_shifts(condition, &setups, &bounds)
    }

    #[test]
    fn a_summary_names_the_metric_that_a_setup_changes_most_and_counts_what_was_stopped() {
        let shifts = [rehearsed("a", [0.07, 0.1]), rehearsed("b", [0.7, 0.2])].concat();
        let stops = [Setup::ForceRateHz(10.0), Setup::SampleRateHz(30.0)];
        let stops = stops.map(|setup| Stops { setup, trials: 6, why: "refused".to_owned() });
        let found = twin_summary(&shifts, &stops);
        assert_eq!(found.iter().map(|row| row.felt).collect::<Vec<_>>(), [1, 0, 0]);
        assert_eq!(found.iter().map(|row| row.stopped).collect::<Vec<_>>(), [0, 6, 6]);
        assert_eq!(
            (found[0].condition.as_deref(), found[2].condition.as_deref()),
            (Some("b"), None)
        );
        assert!((found[0].median_share.unwrap() - 2.0).abs() < 1e-9);
        let table = twin_summary_table(&found, &stops).unwrap();
        assert_eq!(table.to_rows::<SetupSummary>().unwrap(), found);
        assert_eq!(table.notes().len(), 3);
    }
}
