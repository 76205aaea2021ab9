//! How often an answer in one mode is higher than in another: P(A > B) + ½ P(A = B).
//!
//! The probability of superiority (Grissom 1994, J. Appl. Psychol. 79:314) or, over all pairs of
//! repeats of one person, her Mann–Whitney U as a share. It needs no distance between the points
//! of a scale and no model. Participants are the units: their probabilities are averaged with equal
//! weight, however many repeats there are.

use crate::error::check_level;
use crate::tested::{Tested, Unestimable, at_least, not_constant};
use crate::welch;
use zwidth_numerics::moments::Moments;

/// One participant's answers in two modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repeats<'a, T> {
    /// Answers in mode A.
    pub a: &'a [T],
    /// Answers in mode B.
    pub b: &'a [T],
}

/// The probability of superiority of A over B.
#[derive(Debug, Clone, PartialEq)]
pub struct Superiority {
    /// Each participant's P(A > B) + ½ P(A = B) over all pairs of repeats; `None` for one who
    /// lacks a mode, who does not count.
    pub shares: Vec<Option<f64>>,
    /// Their mean: ½ if neither mode is above the other.
    pub probability: f64,
    /// t interval of the mean over participants, clipped to [0, 1]; or why there is none.
    pub interval: Result<(f64, f64), Unestimable>,
    /// Cliff's δ = 2P − 1 = P(A > B) − P(A < B), with its t test against 0 and an interval clipped
    /// to [−1, 1]; or why there is none.
    pub cliff_delta: Result<Tested, Unestimable>,
}

/// The [`Superiority`] of A over B, with intervals at confidence `level`.
///
/// # Errors
/// No participant with answers in both modes; `level` outside (0, 1).
pub fn superiority<T: Ord>(
    participants: &[Repeats<T>],
    level: f64,
) -> Result<Superiority, Unestimable> {
    check_level(level)?;
    let shares: Vec<Option<f64>> = participants.iter().map(share).collect();
    let present: Vec<f64> = shares.iter().copied().flatten().collect();
    at_least("participants", present.len(), 1)?;
    let moments = Moments::of(&present);
    let probability = moments.mean;
    let sd_of_delta = moments.sd().map(|sd| 2.0 * sd);
    let cliff_delta = tested(present.len(), 2.0 * probability - 1.0, sd_of_delta, level);
    let interval =
        cliff_delta.clone().map(|delta| ((1.0 + delta.ci_low) / 2.0, (1.0 + delta.ci_high) / 2.0));
    Ok(Superiority { shares, probability, interval, cliff_delta })
}

/// One participant's probability, over all pairs.
fn share<T: Ord>(repeats: &Repeats<T>) -> Option<f64> {
    let pairs = repeats.a.len() * repeats.b.len();
    let doubled: usize = repeats
        .a
        .iter()
        .flat_map(|a| repeats.b.iter().map(move |b| a.cmp(b)))
        // Lower, equal and higher as 0, 1 and 2: whole numbers, whose sum is exact.
        .map(|order| (order as i8 + 1) as usize)
        .sum();
    (pairs > 0).then(|| doubled as f64 / (2 * pairs) as f64)
}

/// The t test of a mean of `n` values of δ.
fn tested(n: usize, estimate: f64, sd: Option<f64>, level: f64) -> Result<Tested, Unestimable> {
    let sd = sd.ok_or(Unestimable::TooFew { units: "participants", found: n, needed: 2 })?;
    // Shares are fractions of few pairs: what is left of equal ones is rounding.
    not_constant("participants' shares", sd <= 1e-14)?;
    let tested = welch::tested(estimate, sd / (n as f64).sqrt(), n as f64 - 1.0, level)?;
    Ok(Tested { ci_low: tested.ci_low.max(-1.0), ci_high: tested.ci_high.min(1.0), ..tested })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(participants: &[(&[u8], &[u8])]) -> Superiority {
        let repeats: Vec<Repeats<u8>> =
            participants.iter().map(|&(a, b)| Repeats { a, b }).collect();
        superiority(&repeats, 0.95).unwrap()
    }

    #[test]
    fn pairs_count_one_for_higher_and_half_for_equal() {
        // 9 pairs: 5 higher, 1 equal, 3 lower
        let found = of(&[(&[2, 3, 5], &[1, 3, 4]), (&[1], &[2]), (&[4], &[4])]);
        let first = (5.0 + 0.5) / 9.0;
        assert_eq!(found.shares, [Some(first), Some(0.0), Some(0.5)]);
        assert!((found.probability - (first + 0.5) / 3.0).abs() < 1e-15);
    }

    /// R: `t.test(c(1, 0.75, 0.5, 0.875))$conf.int`, and `t.test(2 * p - 1)`.
    #[test]
    fn the_interval_is_the_t_interval_over_participants_clipped() {
        let found =
            of(&[(&[5, 5], &[1, 2]), (&[3, 3], &[2, 3]), (&[3, 1], &[2, 2]), (&[4, 3], &[3, 2])]);
        assert_eq!(found.shares, [Some(1.0), Some(0.75), Some(0.5), Some(0.875)]);
        let (low, high) = found.interval.unwrap();
        assert!((low - 0.441558639525).abs() < 1e-8, "{low}");
        assert!((high - 1.0).abs() < 1e-15);
        let delta = found.cliff_delta.unwrap();
        assert!((delta.estimate - 0.5625).abs() < 1e-15);
        assert!((delta.p_value - 0.0779943264302).abs() < 1e-8, "{}", delta.p_value);
        assert_eq!((delta.df, delta.ci_high), (3.0, 1.0));
    }

    #[test]
    fn exchanging_the_modes_turns_the_sign_of_delta() {
        let (a, b): (&[u8], &[u8]) = (&[1, 4, 4, 2], &[3, 4, 5]);
        let forward = of(&[(a, b), (&[2], &[1, 3, 3])]);
        let backward = of(&[(b, a), (&[1, 3, 3], &[2])]);
        assert!((forward.probability + backward.probability - 1.0).abs() < 1e-15);
        let (f, g) = (forward.cliff_delta.unwrap(), backward.cliff_delta.unwrap());
        assert!((f.statistic + g.statistic).abs() < 1e-12);
        assert_eq!(Some(f.p_value), Some(g.p_value));
    }

    #[test]
    fn what_cannot_be_estimated_is_said() {
        let missing = of(&[(&[1], &[2]), (&[3], &[])]);
        assert_eq!(missing.shares, [Some(0.0), None]);
        assert!(matches!(missing.interval, Err(Unestimable::TooFew { found: 1, .. })));
        let alike = of(&[(&[5], &[1]), (&[4], &[2])]);
        assert!((alike.probability - 1.0).abs() < 1e-15);
        assert!(matches!(alike.cliff_delta, Err(Unestimable::Constant { .. })));
        assert!(superiority::<u8>(&[], 0.95).is_err());
        assert!(superiority(&[Repeats { a: &[1], b: &[1] }], 95.0).is_err());
    }
}
