//! The sign-flip test: if the modes do not differ, each participant's difference could equally have
//! had the other sign.

use crate::error::all_finite;
use crate::null::{Null, SAME, Sampling, sampled_p};
use crate::paired::nonzero;
use crate::{StatsError, Unestimable};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use zwidth_numerics::moments::Moments;

/// Up to here all 2ⁿ flips are counted.
pub const EXACT_UP_TO: usize = 40;

/// The sign-flip test of the mean of paired differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SignFlip {
    /// Mean of the differences, in their unit.
    pub estimate: f64,
    /// Differences that are not zero: only their signs tell anything.
    pub nonzero: usize,
    /// Two-sided p value of "each difference is as likely to have the other sign".
    pub p_value: f64,
    /// The smallest p that as many differences other than zero can reach: each zero doubles it.
    pub smallest_p: f64,
    /// How the p value was found.
    pub null: Null,
}

/// The smallest two-sided p that `n` differences reach: 2 / 2ⁿ, where all have one sign; 1 for
/// `n` = 0 and 1.
pub fn smallest_p(n: usize) -> f64 {
    libm::ldexp(2.0, -(n.min(2000) as i32)).min(1.0)
}

/// Tests the mean of paired `differences` by the share of all 2ⁿ flips of their signs with |sum| ≥
/// |observed sum| (Fisher 1935, *The Design of Experiments*, § 21; Pitman 1937, Suppl. J. R. Stat.
/// Soc. 4:119).
///
/// Sums that differ by less than 1e-9 Σ|d| count as equal. Up to [`EXACT_UP_TO`] differences other
/// than zero every flip is counted, in the time of 2^(n/2) of them: the sums of either half are
/// sorted, and one sum of the one half meets all of the other at once (Horowitz & Sahni 1974,
/// J. ACM 21:277). Beyond, flips are drawn by `sampling`.
///
/// # Errors
/// No difference other than zero; a value that is not finite.
pub fn test(differences: &[f64], sampling: Sampling) -> Result<SignFlip, Unestimable> {
    all_finite(differences)?;
    let nonzero = nonzero(differences)?;
    let observed = sum(&nonzero).abs();
    let total = nonzero.iter().map(|d| d.abs()).sum::<f64>();
    // Finite values may have an infinite sum, against which every flip would count as equal.
    if !total.is_finite() {
        return Err(StatsError::NonFinite { index: 0, value: total }.into());
    }
    let threshold = observed - SAME * total;
    let n = nonzero.len();
    let (p_value, null, least) = if n <= EXACT_UP_TO {
        (exact_p(&nonzero, threshold), Null::Exact, 0.0)
    } else {
        let draws = sampling.draws;
        let p = sampled_p(sampling, |rng| flipped(&nonzero, rng).abs() >= threshold);
        (p, Null::Sampled { draws }, 1.0 / (1 + draws) as f64)
    };
    Ok(SignFlip {
        estimate: Moments::of(differences).mean,
        nonzero: n,
        p_value,
        smallest_p: smallest_p(n).max(least),
        null,
    })
}

fn sum(values: &[f64]) -> f64 {
    values.iter().sum()
}

/// The sum of `values`, each with a sign at random.
fn flipped(values: &[f64], rng: &mut ChaCha8Rng) -> f64 {
    let sums = values.chunks(u64::BITS as usize).map(|chunk| {
        // One draw of 64 bits for 64 signs.
        let bits = rng.next_u64();
        let numbered = chunk.iter().enumerate();
        numbered.map(|(i, v)| if bits >> i & 1 == 1 { -v } else { *v }).sum::<f64>()
    });
    sums.sum()
}

/// The share of all flips whose sum is `threshold` or more, or −`threshold` or less.
fn exact_p(values: &[f64], threshold: f64) -> f64 {
    if threshold <= 0.0 {
        // Every flip is as extreme, and sums on both sides of 0 would be counted twice.
        return 1.0;
    }
    let (left, right) = values.split_at(values.len() / 2);
    let left = sorted_sums(left);
    let right = sorted_sums(right);
    // Flips come in pairs of opposite sums: those of at least the threshold are half of all.
    let mut enough = right.len();
    let mut count: u64 = 0;
    // As the left sums rise, ever more of the right ones are enough: none is visited twice.
    for sum in &left {
        while enough > 0 && sum + right[enough - 1] >= threshold {
            enough -= 1;
        }
        count += (right.len() - enough) as u64;
    }
    libm::ldexp(count as f64, 1 - values.len() as i32)
}

/// The sums of all flips of `values`, from the smallest.
fn sorted_sums(values: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums = sums.iter().flat_map(|sum| [sum - value, sum + value]).collect();
    }
    sums.sort_by(f64::total_cmp);
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bootstrap::stream;

    const SAMPLING: Sampling = Sampling { draws: 20_000, seed: 5 };

    fn p(differences: &[f64]) -> f64 {
        test(differences, SAMPLING).unwrap().p_value
    }

    /// All 2ⁿ flips one by one, in whole numbers.
    fn brute(differences: &[i64]) -> f64 {
        let observed = differences.iter().sum::<i64>().abs();
        let flips = 1_u32 << differences.len();
        let extreme = |flip: &u32| {
            let signed = |(i, d): (usize, &i64)| if flip >> i & 1 == 1 { -d } else { *d };
            differences.iter().enumerate().map(signed).sum::<i64>().abs() >= observed
        };
        (0..flips).filter(extreme).count() as f64 / f64::from(flips)
    }

    /// SciPy 1.17: `permutation_test((d,), np.mean, permutation_type="samples", n_resamples=inf)`.
    #[test]
    fn the_p_value_is_that_of_scipy() {
        assert!((p(&[0.5, -0.1, 1.1, 0.3, 0.8, 0.4]) - 0.0625).abs() < 1e-15);
        let eight = [0.31, -0.12, 0.77, 0.45, -0.2, 0.9, 0.05, 0.6];
        assert!((p(&eight) - 0.0625).abs() < 1e-15);
    }

    /// Multiples of 0.1 have sums that tie in numbers but not in rounding.
    #[test]
    fn the_p_value_is_the_share_of_all_flips_counted_one_by_one() {
        let mut rng = stream(11, 0);
        for round in 0..300 {
            let n = 1 + round % 13;
            let whole: Vec<i64> = (0..n).map(|_| (rng.next_u64() % 15) as i64 - 5).collect();
            if whole.iter().all(|d| *d == 0) {
                continue;
            }
            let tenths: Vec<f64> = whole.iter().map(|d| *d as f64 * 0.1).collect();
            assert!((p(&tenths) - brute(&whole)).abs() < 1e-15, "{whole:?}");
        }
    }

    #[test]
    fn differences_of_one_sign_reach_the_smallest_p() {
        for n in [1, 2, 6, 7, 20, 21] {
            let found = test(&vec![0.3; n], SAMPLING).unwrap();
            assert_eq!((found.nonzero, found.null), (n, Null::Exact));
            assert!((found.p_value - smallest_p(n)).abs() < 1e-18, "{n}");
            assert!((found.smallest_p - smallest_p(n)).abs() < 1e-18, "{n}");
        }
        let least = [(0, 1.0), (1, 1.0), (2, 0.5), (6, 0.03125), (7, 0.015625)];
        assert!(least.iter().all(|(n, p)| (smallest_p(*n) - p).abs() < 1e-18));
        assert!(smallest_p(900) > 0.0 && smallest_p(usize::MAX) >= 0.0);
    }

    /// Flipping a zero changes nothing.
    #[test]
    fn zeros_change_the_mean_and_not_the_p_value() {
        let found = test(&[0.5, 0.0, 0.2, -0.1, 0.0], SAMPLING).unwrap();
        assert!((found.p_value - p(&[0.5, 0.2, -0.1])).abs() < 1e-15);
        assert!((found.estimate - 0.12).abs() < 1e-15 && found.nonzero == 3);
    }

    #[test]
    fn each_zero_doubles_the_smallest_p() {
        let found = test(&[0.0, 1.0, 1.0, 2.0, 3.0, 4.0], SAMPLING).unwrap();
        assert!((found.p_value - 0.0625).abs() < 1e-15);
        assert!((found.smallest_p - 0.0625).abs() < 1e-15);
        assert!((smallest_p(6) - 0.03125).abs() < 1e-15);
    }

    #[test]
    fn differences_that_cancel_tell_nothing() {
        assert!((p(&[0.1, 0.2, -0.3]) - 1.0).abs() < 1e-15);
    }

    #[test]
    fn many_differences_are_sampled_near_the_exact_share() {
        let values: Vec<f64> = (0..41).map(|i| libm::sin(f64::from(i) * 7.0) + 0.25).collect();
        let found = test(&values, SAMPLING).unwrap();
        assert_eq!(found.null, Null::Sampled { draws: 20_000 });
        let exact = test(&values[..40], SAMPLING).unwrap();
        let drawn =
            sampled_p(SAMPLING, |rng| flipped(&values[..40], rng).abs() >= sum(&values[..40]));
        let scatter = (exact.p_value * (1.0 - exact.p_value) / 20_000.0).sqrt();
        assert!((drawn - exact.p_value).abs() < 4.0 * scatter, "{drawn} {}", exact.p_value);
        assert!(found.smallest_p > 4e-5);
    }

    #[test]
    fn data_without_an_answer_say_why() {
        let words = |values: &[f64]| test(values, SAMPLING).unwrap_err().to_string();
        assert_eq!(words(&[]), "0 participants, 1 is needed");
        assert_eq!(words(&[0.0; 4]), "0 differences other than zero, 1 is needed");
        assert!(words(&[f64::NAN]).contains("NaN"));
        assert!(test(&[f64::MAX; 3], SAMPLING).is_err());
    }
}
