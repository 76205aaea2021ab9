//! Wilcoxon's signed-rank test of paired differences.

use crate::Unestimable;
use crate::error::all_finite;
use crate::null::{Null, doubled_midranks};
use crate::paired::nonzero;
use crate::sign_flip::smallest_p;

/// Up to here all 2ⁿ signs of the ranks are counted.
pub const EXACT_UP_TO: usize = 50;

/// The signed-rank test of paired differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignedRank {
    /// W₊: the sum of the ranks of differences above zero.
    pub statistic: f64,
    /// Matched-pairs rank-biserial correlation (W₊ − W₋) / (W₊ + W₋), from −1 to 1 (Kerby 2014,
    /// Compr. Psychol. 3:1); the ranks of zeros are in neither sum.
    pub rank_biserial: f64,
    /// Differences that are not zero.
    pub nonzero: usize,
    /// Two-sided p value of "the differences are symmetric about zero".
    pub p_value: f64,
    /// The smallest p that as many differences other than zero can reach: each zero doubles it.
    pub smallest_p: f64,
    /// How the p value was found.
    pub null: Null,
}

/// Tests paired `differences` by the signs of their ranks (Wilcoxon 1945, Biometrics Bull. 1:80).
///
/// Equal magnitudes share the mean of their ranks; magnitudes that differ by less than 1e-9 of the
/// largest are equal. Zeros take the lowest ranks and are then left out (Pratt 1959, J. Am. Stat.
/// Assoc. 54:655), so that many zeros cannot make a few differences significant by moving their
/// ranks. Up to [`EXACT_UP_TO`] differences other than zero all signs of these ranks are counted,
/// with ties as they are, by recursion over twice the ranks; beyond, the normal distribution with
/// variance Σ rank² / 4 and a correction of ½ for continuity stands in.
///
/// # Errors
/// No difference other than zero; a value that is not finite.
pub fn test(differences: &[f64]) -> Result<SignedRank, Unestimable> {
    all_finite(differences)?;
    let n = nonzero(differences)?.len();
    let magnitudes: Vec<f64> = differences.iter().map(|d| d.abs()).collect();
    // Ranked with the zeros, which take the lowest ranks (Pratt).
    let ranks = doubled_midranks(&magnitudes);
    let mut above = Vec::new();
    let mut below = Vec::new();
    for (difference, rank) in differences.iter().zip(&ranks) {
        if *difference > 0.0 {
            above.push(*rank);
        } else if *difference < 0.0 {
            below.push(*rank);
        }
    }
    let plus = above.iter().sum::<u64>();
    let minus = below.iter().sum::<u64>();
    let ranks = [above, below].concat();
    let (p_value, null) = if n <= EXACT_UP_TO {
        (exact_p(&ranks, plus.min(minus)), Null::Exact)
    } else {
        (normal_p(&ranks, plus.abs_diff(minus)), Null::Normal)
    };
    Ok(SignedRank {
        statistic: plus as f64 / 2.0,
        rank_biserial: (plus as f64 - minus as f64) / (plus + minus) as f64,
        nonzero: n,
        p_value,
        smallest_p: smallest_p(n),
        null,
    })
}

/// The share of all signs of `ranks` for which the smaller of the two sums is at most `smaller`:
/// twice the share whose positive sum is, as both sums have one distribution.
fn exact_p(ranks: &[u64], smaller: u64) -> f64 {
    let total: u64 = ranks.iter().sum();
    if 2 * smaller >= total {
        return 1.0;
    }
    // counts[s]: choices of positive ranks so far with sum s; at most 2^50 in all.
    let mut counts = vec![0_u64; smaller as usize + 1];
    counts[0] = 1;
    for rank in ranks.iter().map(|rank| *rank as usize) {
        // From above, so that no sum has this rank in it twice.
        for sum in (rank..counts.len()).rev() {
            counts[sum] += counts[sum - rank];
        }
    }
    libm::ldexp(counts.iter().sum::<u64>() as f64, 1 - ranks.len() as i32)
}

/// The two-sided p of the normal approximation, from twice |W₊ − W₋|.
fn normal_p(ranks: &[u64], apart: u64) -> f64 {
    // W₊ is |W₊ − W₋| / 2 from its mean; its variance is Σ rank² / 4, ranks being half of ours.
    let sd = (ranks.iter().map(|rank| (rank * rank) as f64).sum::<f64>() / 16.0).sqrt();
    let z = (apart as f64 / 4.0 - 0.5).max(0.0) / sd;
    libm::erfc(z / core::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bootstrap::stream;
    use rand_chacha::rand_core::Rng;

    fn check(differences: &[f64], statistic: f64, p: f64) {
        let found = test(differences).unwrap();
        assert!((found.statistic - statistic).abs() < 1e-12, "{found:?}");
        assert!((found.p_value / p - 1.0).abs() < 1e-12, "{found:?} {p}");
    }

    /// R 4.2: `wilcox.test(d, exact = TRUE)`.
    #[test]
    fn without_ties_the_p_value_is_that_of_r() {
        check(&[0.5, -0.1, 1.1, 0.3, 0.8, 0.4], 20.0, 0.0625);
        check(&[0.31, -0.12, 0.77, 0.45, -0.2, 0.9, 0.05, 0.6], 31.0, 0.078125);
        check(&TWENTY, R_TWENTY.0, R_TWENTY.1);
    }
    const TWENTY: [f64; 20] = [
        1.9, -0.4, 2.7, 0.6, -1.2, 3.1, 0.9, -2.2, 1.4, 2.9, -0.7, 0.2, 3.6, -1.7, 2.1, 0.8, -0.3,
        1.1, 2.4, 4.0,
    ];
    const R_TWENTY: (f64, f64) = (166.0, 0.021484375);

    /// Ties, zeros, and every choice of signs one by one.
    #[test]
    fn with_ties_and_zeros_the_p_value_is_the_share_of_all_signs_counted_one_by_one() {
        let mut rng = stream(12, 0);
        for round in 0..200 {
            let n = 1 + round % 12;
            let values: Vec<f64> =
                (0..n).map(|_| (rng.next_u64() % 9) as f64 * 0.1 - 0.3).collect();
            let values: Vec<f64> =
                values.iter().map(|v| if v.abs() < 1e-9 { 0.0 } else { *v }).collect();
            let Ok(found) = test(&values) else { continue };
            let ranks = doubled_midranks(&values.iter().map(|v| v.abs()).collect::<Vec<_>>());
            let kept: Vec<(i64, bool)> = (0..n)
                .filter(|i| values[*i].abs() > 0.0)
                .map(|i| (ranks[i] as i64, values[i] > 0.0))
                .collect();
            let sum = |flip: u32| {
                let term = |(i, (r, up)): (usize, &(i64, bool))| {
                    if (flip >> i & 1 == 1) == *up { *r } else { -*r }
                };
                kept.iter().enumerate().map(term).sum::<i64>().abs()
            };
            let (all, as_is) = (1_u32 << kept.len(), (1 << kept.len()) - 1);
            let extreme = (0..all).filter(|flip| sum(*flip) >= sum(as_is)).count();
            let share = extreme as f64 / f64::from(all);
            assert!((found.p_value - share).abs() < 1e-15, "{values:?}");
        }
    }

    /// Pratt (1959): zeros keep the lowest ranks from the others.
    #[test]
    fn zeros_take_the_lowest_ranks() {
        let found = test(&[0.0, 0.0, 1.0, -2.0, 3.0]).unwrap();
        assert!((found.statistic - 8.0).abs() < 1e-15 && found.nonzero == 3);
        assert!((found.rank_biserial - 4.0 / 12.0).abs() < 1e-15);
    }

    #[test]
    fn each_zero_doubles_the_smallest_p() {
        let found = test(&[0.0, 1.0, 1.0, 2.0, 3.0, 4.0]).unwrap();
        assert!((found.p_value - 0.0625).abs() < 1e-15);
        assert!((found.smallest_p - 0.0625).abs() < 1e-15);
    }

    #[test]
    fn differences_of_one_sign_reach_the_smallest_p_and_a_correlation_of_one() {
        for n in [1, 2, 6, 50] {
            let values: Vec<f64> = (1..=n).map(f64::from).collect();
            let found = test(&values).unwrap();
            assert!((found.p_value / smallest_p(n as usize) - 1.0).abs() < 1e-15);
            assert!((found.rank_biserial - 1.0).abs() < 1e-15);
            let opposite = test(&values.iter().map(|v| -v).collect::<Vec<_>>()).unwrap();
            assert!((opposite.rank_biserial + 1.0).abs() < 1e-15);
            assert!((opposite.p_value - found.p_value).abs() < 1e-18);
        }
    }

    /// R 4.2: `wilcox.test(d, exact = FALSE)`, with its correction for continuity.
    #[test]
    fn many_differences_have_the_p_value_of_rs_normal_approximation() {
        let many: Vec<f64> = (0..60).map(|i| f64::from((i * 37) % 61) - 24.0 + 0.25).collect();
        let found = test(&many).unwrap();
        assert_eq!(found.null, Null::Normal);
        assert!((found.statistic - R_MANY.0).abs() < 1e-12, "{found:?}");
        assert!((found.p_value / R_MANY.1 - 1.0).abs() < 1e-10, "{found:?}");
        let ties: Vec<f64> = many.iter().map(|v| (v / 4.0).trunc() * 4.0 + 1.0).collect();
        let found = test(&ties).unwrap();
        assert!((found.statistic - R_TIES.0).abs() < 1e-12, "{found:?}");
        assert!((found.p_value / R_TIES.1 - 1.0).abs() < 1e-10, "{found:?}");
    }
    const R_MANY: (f64, f64) = (1254.0, 0.012706086969350508);
    const R_TIES: (f64, f64) = (1320.0, 0.002885815093174032);

    #[test]
    fn the_approximation_is_near_the_counts_where_they_meet() {
        let values: Vec<f64> = (0..50).map(|i| f64::from((i * 37) % 53) - 21.3).collect();
        let exact = test(&values).unwrap();
        let ranks: Vec<u64> = (1..=50).map(|r| 2 * r).collect();
        let apart = (2.0 * exact.statistic - 1275.0).abs() * 2.0;
        assert!((normal_p(&ranks, apart as u64) - exact.p_value).abs() < 0.002);
    }

    #[test]
    fn data_without_an_answer_say_why() {
        let words = |values: &[f64]| test(values).unwrap_err().to_string();
        assert_eq!(words(&[]), "0 participants, 1 is needed");
        assert_eq!(words(&[0.0; 4]), "0 differences other than zero, 1 is needed");
        assert!(words(&[1.0, f64::INFINITY]).contains("value 1"));
        assert!((test(&[0.7]).unwrap().p_value - 1.0).abs() < 1e-15);
    }
}
