//! Distributions of a statistic under its null hypothesis: counted, sampled or approximated.

use crate::bootstrap::stream;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Values that differ by less than this share of their scale are one value: what was computed in
/// two ways differs by rounding, and a tie broken by rounding would make p too small.
pub(crate) const SAME: f64 = 1e-9;

/// How the p value of a test without a model was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Null {
    /// Every case was counted.
    Exact,
    /// Cases were drawn at random: p = (1 + those at least as extreme) / (1 + all drawn), which
    /// holds its level for any number of draws (Phipson & Smyth 2010, Stat. Appl. Genet. Mol. Biol.
    /// 9:39).
    Sampled {
        /// Number of draws.
        draws: usize,
    },
    /// The normal distribution stands in for the counts.
    Normal,
}

/// How to sample where there are too many cases to count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Number of draws.
    pub draws: usize,
    /// The seed: one seed, one p value, on any machine and any number of threads.
    pub seed: u64,
}

/// The p value by `sampling`: `extreme` draws a case and says whether it is at least as extreme as
/// what was observed.
pub(crate) fn sampled_p(
    sampling: Sampling,
    extreme: impl Fn(&mut ChaCha8Rng) -> bool + Sync,
) -> f64 {
    let draws = (0..sampling.draws as u64).into_par_iter();
    let extreme = draws.filter(|number| extreme(&mut stream(sampling.seed, *number))).count();
    (1 + extreme) as f64 / (1 + sampling.draws) as f64
}

/// Twice the ranks of `values` from 1, those of one value being the mean of their places: whole
/// numbers, so that sums of them are exact. Values that differ by less than 1e-9 of the largest
/// magnitude are one value.
pub(crate) fn doubled_midranks(values: &[f64]) -> Vec<u64> {
    let scale = values.iter().fold(0.0_f64, |largest, v| largest.max(v.abs()));
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|i, j| values[*i].total_cmp(&values[*j]));
    let mut ranks = vec![0; values.len()];
    let mut first = 0;
    // Neighbour by neighbour: the first and the last of many near ones may lie further apart.
    for group in order.chunk_by(|i, j| values[*j] - values[*i] <= SAME * scale) {
        // Places first + 1 … first + len: their mean, twice.
        let doubled = (2 * first + group.len() + 1) as u64;
        group.iter().for_each(|index| ranks[*index] = doubled);
        first += group.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::rand_core::Rng;

    /// SciPy: `2 * rankdata(values)`.
    #[test]
    fn midranks_are_those_of_scipy() {
        assert_eq!(doubled_midranks(&[3.0, 1.0, 3.0, 2.0, 3.0, -5.0]), [10, 4, 10, 6, 10, 2]);
        assert_eq!(doubled_midranks(&[0.1 + 0.2, 0.3, 0.4]), [3, 3, 6]);
        assert_eq!(doubled_midranks(&[0.0, -0.0]), [3, 3]);
        assert_eq!(doubled_midranks(&[]), [0; 0]);
    }

    #[test]
    fn a_sampled_p_is_the_same_on_any_number_of_threads_and_never_zero() {
        let sampling = Sampling { draws: 4000, seed: 3 };
        let run = || sampled_p(sampling, |rng| rng.next_u64() % 4 == 0);
        let on = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(run)
        };
        assert_eq!(on(1).to_bits(), on(3).to_bits());
        assert!((run() - 0.25).abs() < 0.03);
        assert!((sampled_p(sampling, |_| false) - 1.0 / 4001.0).abs() < 1e-18);
    }
}
