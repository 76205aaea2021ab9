//! The bootstrap over blocks: resampled statistics and their percentile interval.
//!
//! Samples of one recording are not independent, but blocks of it (or whole sweeps, trials,
//! participants) nearly are, so blocks are drawn. Efron & Tibshirani (1993), *An Introduction to
//! the Bootstrap*; Künsch (1989), Ann. Statist. 17:1217 for blocks of a series.
//!
//! Each resample draws from its own stream of the ChaCha8 cipher, keyed with the seed: the numbers
//! are those of the cipher's definition, on any machine, in any later version, and with any number
//! of threads.

use crate::error::{StatsError, all_finite, check_level};
use crate::student_t::critical_value;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;
use zwidth_numerics::order::{quantile, sorted};

/// Number of bytes of the cipher's key.
const KEY_BYTES: usize = 32;

/// Evaluates `statistic` on `resamples` samples of `draws` blocks each, drawn from `blocks` with
/// replacement.
///
/// `draws` is `blocks.len()` for the ordinary bootstrap. One value per resample, in the order of
/// the resamples; the same for one seed whatever the number of threads. Empty if there are no
/// blocks.
pub fn resample<B: Sync, T: Send>(
    blocks: &[B],
    draws: usize,
    resamples: usize,
    seed: u64,
    statistic: impl Fn(&[&B]) -> T + Sync,
) -> Vec<T> {
    if blocks.is_empty() {
        return Vec::new();
    }
    let numbers = (0..resamples).into_par_iter();
    numbers
        .map(|number| {
            let mut rng = stream(seed, number as u64);
            let drawn: Vec<&B> =
                (0..draws).map(|_| &blocks[index_below(&mut rng, blocks.len())]).collect();
            statistic(&drawn)
        })
        .collect()
}

/// The percentile interval of resampled `values`: their (1 ∓ level)/2 quantiles
/// ([`quantile`]). Unit as the values; `None` without values.
///
/// # Errors
/// A value that is not finite, `level` outside (0, 1).
pub fn percentile_interval(values: &[f64], level: f64) -> Result<Option<(f64, f64)>, StatsError> {
    check_level(level)?;
    all_finite(values)?;
    let sorted = sorted(values.iter().copied());
    let tail = (1.0 - level) / 2.0;
    Ok(quantile(&sorted, tail).zip(quantile(&sorted, 1.0 - tail)))
}

/// The level at which percentiles of a bootstrap over `n` independent blocks make an interval of
/// `level` (Hesterberg 2015, Amer. Statist. 69:371, the "expanded percentile interval"): 2Φ(z) − 1
/// with z = √(n / (n − 1)) t(level, df n − 1). Resampled means of n values scatter by √((n − 1)/n)
/// too little, and know the variance from n values only; for 15 blocks 95 % becomes 97.4 %. Below 1
/// always; at n = 2 it is the whole range of the resamples.
///
/// # Errors
/// `level` outside (0, 1), `n` below 2.
pub fn expanded_level(level: f64, n: usize) -> Result<f64, StatsError> {
    /// The largest level: a share of resamples that no one draws.
    const NEARLY_ALL: f64 = 1.0 - 1e-12;
    let df = n as f64 - 1.0;
    let z = (n as f64 / df).sqrt() * critical_value(level, df)?;
    Ok(libm::erf(z / core::f64::consts::SQRT_2).min(NEARLY_ALL))
}

/// The random numbers of one draw: stream `number` of the cipher keyed with `seed`.
pub(crate) fn stream(seed: u64, number: u64) -> ChaCha8Rng {
    let mut key = [0; KEY_BYTES];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    let mut rng = ChaCha8Rng::from_seed(key);
    // A stream per draw: threads may take draws in any order.
    rng.set_stream(number);
    rng
}

/// A whole number below `n`, from the high half of a 64 × 64 bit product (Lemire 2019); its bias is
/// below n / 2⁶⁴.
pub(crate) fn index_below(rng: &mut ChaCha8Rng, n: usize) -> usize {
    ((u128::from(rng.next_u64()) * n as u128) >> u64::BITS) as usize
}

/// A number in (0, 1), from the upper 53 bits.
pub(crate) fn uniform(rng: &mut ChaCha8Rng) -> f64 {
    // Half a step off: 0 has no logarithm.
    ((rng.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// A standard normal number (Box & Muller 1958, Ann. Math. Statist. 29:610).
pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let radius = (-2.0 * libm::log(uniform(rng))).sqrt();
    radius * libm::cos(2.0 * core::f64::consts::PI * uniform(rng))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(drawn: &[&f64]) -> f64 {
        drawn.iter().copied().sum::<f64>() / drawn.len() as f64
    }

    #[test]
    fn one_thread_gives_the_bits_of_many() {
        let values: Vec<f64> = (0..50).map(|i| libm::sin(f64::from(i))).collect();
        let run = || resample(&values, values.len(), 200, 7, mean);
        let on = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
        };
        assert_eq!(on(1), on(4));
        assert_ne!(run(), resample(&values, values.len(), 200, 8, mean));
    }

    /// The draws are part of every stored interval: this fails if a new version of anything changes
    /// them. The numbers come from a separate ChaCha8 written in Python: key = seed, nonce =
    /// number of the resample.
    #[test]
    fn the_draws_of_a_seed_are_fixed() {
        let blocks: Vec<usize> = (0..10).collect();
        let drawn = resample(&blocks, 6, 2, 1, |d| d.iter().map(|b| **b).collect::<Vec<_>>());
        assert_eq!(drawn, [[3, 2, 7, 9, 8, 1], [1, 8, 6, 3, 3, 9]]);
    }

    /// The bootstrap variance of a mean is Σ (x − x̄)² / n², in expectation.
    #[test]
    fn the_spread_of_resampled_means_is_the_standard_error() {
        let values: Vec<f64> = (0..40).map(f64::from).collect();
        let means = resample(&values, 40, 20_000, 3, mean);
        let centre = means.iter().sum::<f64>() / 20_000.0;
        let variance = means.iter().map(|m| (m - centre) * (m - centre)).sum::<f64>() / 20_000.0;
        let expected = (40.0 * 40.0 - 1.0) / 12.0 / 40.0;
        assert!((variance / expected - 1.0).abs() < 0.03, "{variance} {expected}");
        assert!((centre - 19.5).abs() < 0.05);
    }

    /// NumPy: `np.quantile([3, 1, 2, 5, 4, 9], [0.025, 0.975])`.
    #[test]
    fn percentiles_are_those_of_numpy() {
        let (low, high) =
            percentile_interval(&[3.0, 1.0, 2.0, 5.0, 4.0, 9.0], 0.95).unwrap().unwrap();
        assert!((low - 1.125).abs() < 1e-14 && (high - 8.5).abs() < 1e-14);
        assert_eq!(percentile_interval(&[2.0], 0.95).unwrap(), Some((2.0, 2.0)));
        assert_eq!(percentile_interval(&[], 0.95).unwrap(), None);
        assert!(percentile_interval(&[f64::NAN], 0.95).is_err());
    }

    /// SciPy: `2 * norm.cdf(sqrt(n / (n - 1)) * t) - 1`, t = `t.ppf(0.975, n - 1)` to nine digits.
    #[test]
    fn expanded_levels_are_those_of_scipy() {
        for (n, scipy) in EXPANDED {
            assert!((expanded_level(0.95, n).unwrap() - scipy).abs() < 1e-12, "{n}");
        }
        assert!(expanded_level(0.95, 2).unwrap() < 1.0);
        assert!(expanded_level(0.95, 1).is_err() && expanded_level(0.95, 0).is_err());
    }
    const EXPANDED: [(usize, f64); 3] =
        [(5, 0.9980917989308646), (15, 0.9735856538926595), (30, 0.9624921992446787)];

    #[test]
    fn no_blocks_give_no_resamples() {
        assert!(resample(&[] as &[f64], 5, 10, 1, mean).is_empty());
    }
}
