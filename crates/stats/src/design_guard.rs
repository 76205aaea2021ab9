//! What a design can show at all: the smallest p value that its tests can reach, and the design
//! that would reach the desired one.
//!
//! A test that counts cases has a smallest p, however large the effect. Tests with a t or an F have
//! none: for these, state the power.

use crate::StatsError;
use crate::sign_flip::smallest_p;

/// The smallest p value, adjusted after Holm over `contrasts`, of a sign-flip or signed-rank test
/// of `pairs` participants: contrasts × 2 / 2ⁿ, at most 1. Participants whose difference is zero do
/// not count as pairs.
pub fn reachable_p(pairs: usize, contrasts: usize) -> f64 {
    (contrasts.max(1) as f64 * smallest_p(pairs)).min(1.0)
}

/// The fewest pairs with which the claim of one of `contrasts` contrasts can come below `alpha`.
///
/// # Errors
/// `alpha` outside (0, 0.5).
pub fn pairs_needed(contrasts: usize, alpha: f64) -> Result<usize, StatsError> {
    if !(alpha > 0.0 && alpha < 0.5) {
        return Err(StatsError::Alpha { alpha });
    }
    let mut pairs = 1;
    // This ends: with each pair more p is halved.
    while reachable_p(pairs, contrasts) >= alpha {
        pairs += 1;
    }
    Ok(pairs)
}

/// Whether the claim of one of `contrasts` contrasts over `pairs` participants can come below
/// `alpha`: the smallest adjusted p value that it reaches.
///
/// # Errors
/// A claim out of reach, in words, with the number of participants that would carry it; `alpha`
/// outside (0, 0.5).
pub fn check(pairs: usize, contrasts: usize, alpha: f64) -> Result<f64, StatsError> {
    let reachable = reachable_p(pairs, contrasts);
    let needed = pairs_needed(contrasts, alpha)?;
    match pairs >= needed {
        true => Ok(reachable),
        false => Err(StatsError::OutOfReach { pairs, contrasts, reachable, alpha, needed }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{friedman, holm, null::Sampling, sign_flip, signed_rank};

    const SAMPLING: Sampling = Sampling { draws: 1, seed: 1 };

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-14, "{found} {expected}");
    }

    #[test]
    fn six_pairs_and_two_contrasts_reach_0_0625_three_0_094_and_seven_pairs_0_031() {
        near(reachable_p(6, 2), 0.0625);
        near(reachable_p(6, 3), 0.09375);
        near(reachable_p(7, 2), 0.03125);
        assert_eq!([1, 2, 3, 6].map(|m| pairs_needed(m, 0.05).unwrap()), [6, 7, 7, 8]);
    }

    /// The largest effect there can be: all differences of one sign, in every contrast.
    #[test]
    fn the_tests_reach_what_the_guard_says_and_no_less() {
        for pairs in 1..12 {
            let differences: Vec<f64> = (1..=pairs).map(|i| i as f64).collect();
            for contrasts in 1..5 {
                let flip = sign_flip::test(&differences, SAMPLING).unwrap().p_value;
                let rank = signed_rank::test(&differences).unwrap().p_value;
                for p in [flip, rank] {
                    let adjusted = holm::adjusted(&vec![p; contrasts]).unwrap();
                    near(adjusted[0], reachable_p(pairs, contrasts));
                }
            }
        }
    }

    #[test]
    fn a_claim_out_of_reach_is_refused_with_the_design_that_would_carry_it() {
        let words = check(6, 2, 0.05).unwrap_err().to_string();
        assert_eq!(
            words,
            "with 6 pairs and 2 contrasts, however large the effect, they cannot bring an adjusted p below \
             0.0625; below 0.05 takes 7 pairs"
        );
        near(check(7, 2, 0.05).unwrap(), 0.03125);
        for contrasts in 1..20 {
            let needed = pairs_needed(contrasts, 0.05).unwrap();
            assert!(check(needed, contrasts, 0.05).is_ok());
            assert!(check(needed - 1, contrasts, 0.05).is_err());
        }
    }

    /// A p equal to alpha is not below it.
    #[test]
    fn a_p_of_alpha_itself_does_not_do() {
        assert_eq!(pairs_needed(1, 0.03125), Ok(7));
        assert!(check(6, 1, 0.03125).is_err());
    }

    /// All order the k modes alike: (1 / k!)^(n − 1).
    #[test]
    fn friedmans_test_reaches_one_of_all_orders() {
        for (n, k, of) in [(1, 3, 1.0), (2, 3, 6.0), (4, 3, 216.0), (3, 4, 576.0), (6, 2, 32.0)] {
            let row: Vec<f64> = (0..k).map(f64::from).collect();
            let found = friedman::test(&vec![row.as_slice(); n], SAMPLING).unwrap();
            near(found.p_value, 1.0 / of);
        }
        assert!(friedman::test(&[], SAMPLING).is_err());
    }

    #[test]
    fn nothing_is_reached_without_pairs_and_every_alpha_has_an_answer() {
        near(reachable_p(0, 2), 1.0);
        near(reachable_p(1, 1), 1.0);
        assert!(pairs_needed(2, f64::MIN_POSITIVE).unwrap() > 1000);
        for alpha in [0.0, -1.0, 0.5, f64::NAN] {
            assert!(matches!(check(6, 2, alpha), Err(StatsError::Alpha { .. })));
        }
    }
}
