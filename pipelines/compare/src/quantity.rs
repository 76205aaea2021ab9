//! Answers on a scale of many points (0 to 100): compared by means, as a metric is.

use std::collections::BTreeMap;
use zwidth_stats::{Tested, Unestimable, paired};

/// One answer, by the places of the names of who gave it, in which session and in which mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Score {
    pub(crate) participant: usize,
    pub(crate) session: usize,
    pub(crate) mode: usize,
    pub(crate) value: f64,
}

/// The unweighted mean over participants of (mean in the one mode − mean in the other), sessions
/// that have both averaged with equal weight, tested by Student's t with n − 1 degrees of freedom:
/// the estimate of a metric's contrast. In points of the scale.
///
/// # Errors
/// Fewer than two participants with both modes; differences that are all equal; a level outside
/// (0, 1).
pub(crate) fn difference(
    scores: &[Score],
    modes: [usize; 2],
    level: f64,
) -> Result<Tested, Unestimable> {
    paired::mean_difference(&paired::differences(&pairs(scores, modes)), level)
}

/// Sum and number of the answers in either mode.
type Sums = [(f64, f64); 2];

/// The means in both modes of everybody who has both, in the order of participants.
fn pairs(scores: &[Score], modes: [usize; 2]) -> Vec<[f64; 2]> {
    let mut cells: BTreeMap<usize, BTreeMap<usize, Sums>> = BTreeMap::new();
    for score in scores {
        let Some(side) = modes.iter().position(|mode| *mode == score.mode) else { continue };
        let sessions = cells.entry(score.participant).or_default();
        let (sum, n) = &mut sessions.entry(score.session).or_default()[side];
        (*sum, *n) = (*sum + score.value, *n + 1.0);
    }
    cells.values().filter_map(mean_of_sessions).collect()
}

/// The means over the sessions that have both modes; `None` without one.
fn mean_of_sessions(sessions: &BTreeMap<usize, Sums>) -> Option<[f64; 2]> {
    let whole: Vec<[f64; 2]> = sessions
        .values()
        .filter(|sums| sums.iter().all(|(_, n)| *n > 0.0))
        .map(|sums| sums.map(|(sum, n)| sum / n))
        .collect();
    let mean =
        |side: usize| whole.iter().map(|means| means[side]).sum::<f64>() / whole.len() as f64;
    (!whole.is_empty()).then(|| [mean(0), mean(1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn score(participant: usize, session: usize, mode: usize, value: f64) -> Score {
        Score { participant, session, mode, value }
    }

    /// Closed forms of t with two degrees of freedom: p = 1 − t / √(2 + t²).
    #[test]
    fn means_are_compared_within_participants_as_by_a_paired_t_test() {
        let scores = [
            score(0, 0, 1, 50.0),
            score(0, 0, 1, 60.0),
            score(0, 0, 0, 30.0),
            score(1, 0, 1, 40.0),
            score(1, 0, 0, 35.0),
            score(2, 0, 1, 70.0),
            score(2, 0, 0, 20.0),
            // Nobody else has both modes.
            score(3, 0, 1, 100.0),
            score(3, 1, 0, 0.0),
        ];
        let found = difference(&scores, [1, 0], 0.95).unwrap();
        assert!((found.estimate - 80.0 / 3.0).abs() < 1e-12);
        assert!((found.statistic - 2.0485900789263356).abs() < 1e-12, "{found:?}");
        // p values and quantiles are stored to so many digits (`zwidth_stats::rounded`).
        assert!((found.p_value - 0.1770488002021764).abs() < 1e-8, "{found:?}");
        assert!((found.ci_low - -29.341320146774347).abs() < 1e-7, "{found:?}");
        assert!((found.df - 2.0).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn sessions_weigh_the_same_however_often_was_answered() {
        let scores = [
            score(0, 0, 1, 10.0),
            score(0, 0, 1, 10.0),
            score(0, 0, 1, 10.0),
            score(0, 0, 0, 0.0),
            score(0, 1, 1, 40.0),
            score(0, 1, 0, 0.0),
        ];
        assert_eq!(pairs(&scores, [1, 0]), [[25.0, 0.0]]);
    }

    #[test]
    fn one_participant_has_no_test() {
        let scores = [score(0, 0, 1, 10.0), score(0, 0, 0, 5.0)];
        assert!(matches!(difference(&scores, [1, 0], 0.95), Err(Unestimable::TooFew { .. })));
    }
}
