//! Differences between two modes, participant by participant.

use crate::cells::{Cell, Cells};
use std::collections::BTreeMap;
use zwidth_stats::welch::{self, Group};
use zwidth_stats::{Tested, Unestimable};

/// One participant's difference between two modes in one environment: the mean over the sessions
/// that have both.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Difference {
    /// Index among [`Cells::participants`].
    pub(crate) participant: usize,
    /// Sessions that have both modes.
    pub(crate) sessions: usize,
    /// Trials with the metric in either mode, of these sessions.
    pub(crate) trials: [usize; 2],
    /// The two modes' means over these sessions.
    pub(crate) means: [f64; 2],
    /// Mean of the one minus mean of the other.
    pub(crate) estimate: f64,
    /// The same with its interval within this participant, repeats as units.
    pub(crate) within: Result<Tested, Unestimable>,
}

/// The differences of everybody who has both modes, in the order of participants.
pub(crate) fn of_everybody(
    cells: &Cells,
    environment: usize,
    modes: [usize; 2],
    level: f64,
) -> Vec<Difference> {
    let [these, those] = modes.map(|mode| {
        cells.of_condition(environment, mode).filter(|c| c.mean.is_some()).collect::<Vec<_>>()
    });
    let those: BTreeMap<_, &Cell> =
        those.into_iter().map(|cell| ((cell.participant, cell.session), cell)).collect();
    let pairs: Vec<[&Cell; 2]> = these
        .into_iter()
        .filter_map(|cell| Some([cell, *those.get(&(cell.participant, cell.session))?]))
        .collect();
    pairs
        .chunk_by(|a, b| a[0].participant == b[0].participant)
        .map(|own| {
            let difference = difference(own, level);
            match cells.lines {
                Some(_) => Difference { within: Err(Unestimable::Adjusted), ..difference },
                None => difference,
            }
        })
        .collect()
}

/// The difference of one participant, who has these sessions; at least one.
fn difference(pairs: &[[&Cell; 2]], level: f64) -> Difference {
    let strata: Vec<[Group; 2]> = pairs.iter().map(|pair| pair.map(Cell::group)).collect();
    let means =
        [0, 1].map(|side| strata.iter().map(|s| s[side].mean).sum::<f64>() / pairs.len() as f64);
    Difference {
        participant: pairs[0][0].participant,
        sessions: pairs.len(),
        trials: [0, 1].map(|side| pairs.iter().map(|pair| pair[side].n).sum()),
        means,
        estimate: means[0] - means[1],
        within: welch::difference(&strata, level),
    }
}
