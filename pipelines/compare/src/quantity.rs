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

/// A difference of means, in points of the scale.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Difference {
    /// `None` if nobody has both modes. One person has a difference, and so have people who differ
    /// by the same: only a test is lacking.
    pub(crate) estimate: Option<f64>,
    /// Its test against zero, or why there is none.
    pub(crate) tested: Result<Tested, Unestimable>,
}

/// The unweighted mean over participants of (mean in the one mode − mean in the other), sessions
/// that have both averaged with equal weight, tested by Student's t with n − 1 degrees of freedom:
/// the estimate of a metric's contrast.
///
/// There is no test of fewer than two participants with both modes, nor of differences that are all
/// equal.
pub(crate) fn difference(scores: &[Score], modes: [usize; 2], level: f64) -> Difference {
    let differences = paired::differences(&pairs(scores, modes));
    let tested = paired::mean_difference(&differences, level);
    let estimate = match &tested {
        Ok(tested) => Some(tested.estimate),
        Err(_) if differences.is_empty() => None,
        Err(_) => Some(differences.iter().sum::<f64>() / differences.len() as f64),
    };
    Difference { estimate, tested }
}

/// Sum and number of the answers in either mode.
type Sums = [(f64, f64); 2];

/// The means in both modes of everybody who has both, in the order of participants: over the
/// sessions that have both.
fn pairs(scores: &[Score], modes: [usize; 2]) -> Vec<[f64; 2]> {
    // Sorted maps, because the order of a sum is part of its bits.
    let mut cells: BTreeMap<usize, BTreeMap<usize, Sums>> = BTreeMap::new();
    for score in scores {
        let Some(side) = modes.iter().position(|mode| *mode == score.mode) else { continue };
        let sessions = cells.entry(score.participant).or_default();
        let (sum, n) = &mut sessions.entry(score.session).or_default()[side];
        (*sum, *n) = (*sum + score.value, *n + 1.0);
    }
    let people = cells.values().filter_map(|sessions| {
        let whole: Vec<[f64; 2]> = sessions
            .values()
            .filter(|sums| sums.iter().all(|(_, n)| *n > 0.0))
            .map(|sums| sums.map(|(sum, n)| sum / n))
            .collect();
        (!whole.is_empty()).then(|| {
            [0, 1]
                .map(|side| whole.iter().map(|means| means[side]).sum::<f64>() / whole.len() as f64)
        })
    });
    people.collect()
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
        let found = difference(&scores, [1, 0], 0.95).tested.unwrap();
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
    fn one_participant_and_equal_ones_have_a_difference_without_a_test() {
        let of = |who, a, b| [score(who, 0, 1, b), score(who, 0, 0, a)];
        let one = difference(&of(0, 5.0, 10.25), [1, 0], 0.95);
        assert_eq!(one.estimate, Some(5.25));
        assert!(matches!(one.tested, Err(Unestimable::TooFew { .. })));
        let equal = [of(0, 47.25, 53.75), of(1, 50.5, 57.0)].concat();
        let equal = difference(&equal, [1, 0], 0.95);
        assert_eq!(equal.estimate, Some(6.5));
        assert!(matches!(equal.tested, Err(Unestimable::Constant { .. })));
        let nobody = difference(&[score(0, 0, 1, 10.0), score(1, 0, 0, 5.0)], [1, 0], 0.95);
        assert_eq!(nobody.estimate, None);
    }
}
