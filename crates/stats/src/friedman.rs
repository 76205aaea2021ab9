//! Friedman's test: whether participants rank the modes alike.

use crate::Unestimable;
use crate::bootstrap::index_below;
use crate::error::{all_finite, same_length};
use crate::null::{Null, Sampling, doubled_midranks, sampled_p};
use crate::tested::{at_least, not_constant};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeMap;

/// The p value is exact as long as counting takes at most this many sums: about a second.
const STEPS: usize = 5_000_000;

/// Friedman's test of several modes on complete participants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friedman {
    /// Friedman's χ², corrected for ties: n (k − 1) W.
    pub statistic: f64,
    /// Kendall's coefficient of concordance W, from 0 (no common order) to 1 (all order alike).
    pub concordance: f64,
    /// p value of "each order of a participant's values was equally likely".
    pub p_value: f64,
    /// How the p value was found.
    pub null: Null,
}

/// Tests whether the modes differ, from one row per participant with one value per mode (Friedman
/// 1937, J. Am. Stat. Assoc. 32:675; Kendall & Babington Smith 1939, Ann. Math. Stat. 10:275).
///
/// Values are ranked within their row, equal ones (to 1e-9 of the row's largest magnitude) by the
/// mean of their ranks: with R_j the sum of mode j's ranks over n rows of k modes and t the sizes
/// of ties, W = 12 Σ (R_j − n (k + 1) / 2)² / (n² (k³ − k) − n Σ (t³ − t)). The p value is the
/// share of all (k!)ⁿ orders within rows whose W is at least the observed one, ties kept: rows are
/// taken in one by one, the sums of ranks after each being a distribution that the next convolves.
/// Where that would take more than five million sums (three modes: from some 130 participants on;
/// four: 25; five: 9), orders are drawn by `sampling`.
///
/// # Errors
/// No row; fewer than two modes; rows that are all of one value each; a value that is not finite;
/// rows of different lengths.
pub fn test(rows: &[&[f64]], sampling: Sampling) -> Result<Friedman, Unestimable> {
    let modes = check(rows)?;
    let ranks: Vec<Vec<u64>> = rows.iter().map(|row| doubled_midranks(row)).collect();
    let sums = ranks.iter().fold(vec![0; modes], |sums, row| added(&sums, row));
    // In twice the ranks: n rows sum to k (k + 1) each, so a mode's mean sum is n (k + 1).
    let centre = (rows.len() * (modes + 1)) as u64;
    let observed = spread(&sums, centre);
    // The denominator of W; the ties of each row make it smaller.
    let largest =
        rows.len() as u64 * ranks.iter().map(|row| spread(row, modes as u64 + 1)).sum::<u64>();
    not_constant("values within each participant", largest == 0)?;
    let concordance = observed as f64 / largest as f64;
    let (p_value, null) = match exact_p(&ranks, centre, observed) {
        Some(p) => (p, Null::Exact),
        None => {
            let p = sampled_p(sampling, |rng| spread(&drawn(&ranks, rng), centre) >= observed);
            (p, Null::Sampled { draws: sampling.draws })
        }
    };
    let statistic = (rows.len() * (modes - 1)) as f64 * concordance;
    Ok(Friedman { statistic, concordance, p_value, null })
}

/// The number of modes of rows that can be tested.
fn check(rows: &[&[f64]]) -> Result<usize, Unestimable> {
    let Some(first) = rows.first() else {
        return Err(Unestimable::TooFew { units: "participants", found: 0, needed: 1 });
    };
    at_least("modes", first.len(), 2)?;
    for row in rows {
        all_finite(row)?;
        same_length("a participant's row", first.len(), row.len())?;
    }
    Ok(first.len())
}

/// Sums of ranks with one more row.
fn added(sums: &[u64], row: &[u64]) -> Vec<u64> {
    sums.iter().zip(row).map(|(sum, rank)| sum + rank).collect()
}

/// Σ (sum − centre)².
fn spread(sums: &[u64], centre: u64) -> u64 {
    sums.iter().map(|sum| sum.abs_diff(centre).pow(2)).sum()
}

/// The sums of rows in orders drawn at random.
fn drawn(ranks: &[Vec<u64>], rng: &mut ChaCha8Rng) -> Vec<u64> {
    let mut sums = vec![0; ranks[0].len()];
    for row in ranks {
        let mut row = row.clone();
        for i in (1..row.len()).rev() {
            row.swap(i, index_below(rng, i + 1));
        }
        sums = added(&sums, &row);
    }
    sums
}

/// The share of all orders within rows whose sums spread by `observed` or more; `None` beyond
/// [`STEPS`].
///
/// Every order of a row being equally likely, so is every order of the sums: they are kept sorted,
/// k! of them as one.
fn exact_p(ranks: &[Vec<u64>], centre: u64, observed: u64) -> Option<f64> {
    let modes = ranks[0].len();
    // A single row with more orders would take too long, and their list too much memory.
    let orders = (1..=modes).try_fold(1_usize, |orders, k| orders.checked_mul(k));
    orders.filter(|orders| *orders <= STEPS)?;
    let mut shares = BTreeMap::from([(vec![0_u64; modes], 1.0)]);
    let mut left = STEPS;
    for row in ranks {
        let orders = distinct_orders(row);
        left = left.checked_sub(shares.len() * orders.len())?;
        let mut next = BTreeMap::new();
        for (sums, share) in &shares {
            let each = share / orders.len() as f64;
            for order in &orders {
                let mut sums = added(sums, order);
                sums.sort_unstable();
                *next.entry(sums).or_insert(0.0) += each;
            }
        }
        shares = next;
    }
    let extreme = shares.iter().filter(|(sums, _)| spread(sums, centre) >= observed);
    // Rounding may leave the sum of all shares above 1.
    Some(extreme.map(|(_, share)| share).sum::<f64>().min(1.0))
}

/// All distinct orders of `row`, each as likely as the others.
fn distinct_orders(row: &[u64]) -> Vec<Vec<u64>> {
    let mut order = row.to_vec();
    order.sort_unstable();
    let mut orders = vec![order.clone()];
    // The next in lexicographic order, until nothing rises: so equal ranks are not exchanged.
    while let Some(rises) = order.windows(2).rposition(|pair| pair[0] < pair[1]) {
        let larger = order.iter().rposition(|v| *v > order[rises]).unwrap_or(rises);
        order.swap(rises, larger);
        order[rises + 1..].reverse();
        orders.push(order.clone());
    }
    orders
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bootstrap::stream;
    use rand_chacha::rand_core::Rng;

    const SAMPLING: Sampling = Sampling { draws: 10_000, seed: 9 };

    fn tested(rows: &[Vec<f64>]) -> Friedman {
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        test(&rows, SAMPLING).unwrap()
    }

    /// All orders of all rows one by one, each of the k! of them, ties or not.
    fn brute(rows: &[Vec<f64>]) -> f64 {
        let ranks: Vec<Vec<u64>> = rows.iter().map(|row| doubled_midranks(row)).collect();
        let modes = rows[0].len();
        let places = distinct_orders(&(0..modes as u64).collect::<Vec<_>>());
        let centre = (rows.len() * (modes + 1)) as u64;
        let spread_of = |number: usize| {
            let mut left = number;
            let mut sums = vec![0; modes];
            for row in &ranks {
                let place = &places[left % places.len()];
                left /= places.len();
                let row: Vec<u64> = place.iter().map(|p| row[*p as usize]).collect();
                sums = added(&sums, &row);
            }
            spread(&sums, centre)
        };
        let all = places.len().pow(rows.len() as u32);
        let observed = spread_of(0);
        (0..all).filter(|number| spread_of(*number) >= observed).count() as f64 / all as f64
    }

    /// R 4.2: `friedman.test(m)`; W = χ² / (n (k − 1)).
    #[test]
    fn the_statistic_is_that_of_r() {
        let found = tested(&UNTIED.map(|row| row.to_vec()));
        assert!((found.statistic - 8.333333333333334).abs() < 1e-12, "{found:?}");
        assert!((found.concordance - 8.333333333333334 / 12.0).abs() < 1e-12);
        let found = tested(&TIED.map(|row| row.to_vec()));
        assert!((found.statistic - R_TIED).abs() < 1e-12, "{found:?}");
    }
    const UNTIED: [[f64; 3]; 6] = [
        [5.1, 4.6, 3.9],
        [4.8, 4.9, 4.1],
        [6.2, 5.1, 4.4],
        [5.5, 5.2, 5.0],
        [4.9, 4.1, 4.3],
        [6.0, 5.6, 5.1],
    ];
    const TIED: [[f64; 4]; 5] = [
        [3.0, 3.0, 5.0, 4.0],
        [2.0, 4.0, 4.0, 4.0],
        [1.0, 2.0, 5.0, 2.0],
        [3.0, 3.0, 3.0, 3.0],
        [2.0, 5.0, 4.0, 1.0],
    ];
    const R_TIED: f64 = 6.617647058823529;

    /// Friedman (1937), table V, three modes: P(χ² ≥ 6) = 0.028 for three rows, P(χ² ≥ 6.5) = 0.042
    /// for four. Rows that all order alike have (1/k!)^(n − 1).
    #[test]
    fn small_tables_have_the_published_p_values() {
        let alike = |n: usize| vec![vec![1.0, 2.0, 3.0]; n];
        for n in 1..8 {
            let p = tested(&alike(n)).p_value;
            assert!((p * 6.0_f64.powi(n as i32 - 1) - 1.0).abs() < 1e-12, "{n}");
        }
        let mut four = alike(4);
        four[3] = vec![1.0, 3.0, 2.0];
        let found = tested(&four);
        assert!((found.statistic - 6.5).abs() < 1e-12);
        assert!((found.p_value - 9.0 / 216.0).abs() < 1e-12, "{}", found.p_value);
    }

    #[test]
    fn the_p_value_is_the_share_of_all_orders_counted_one_by_one() {
        let mut rng = stream(13, 0);
        for round in 0..60 {
            let (modes, n) = [(2, 9), (3, 6), (4, 3), (3, 4), (5, 2)][round % 5];
            let values = 2 + rng.next_u64() % 6;
            let rows: Vec<Vec<f64>> = (0..n)
                .map(|_| (0..modes).map(|_| (rng.next_u64() % values) as f64 * 0.1).collect())
                .collect();
            let slices: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
            let Ok(found) = test(&slices, SAMPLING) else { continue };
            assert_eq!(found.null, Null::Exact);
            assert!((found.p_value - brute(&rows)).abs() < 1e-12, "{rows:?}");
        }
    }

    /// Two modes: W ranks by signs alone, so Friedman's test is the sign test.
    #[test]
    fn two_modes_make_it_the_sign_test() {
        let rows: Vec<Vec<f64>> = (0..8).map(|i| vec![f64::from(u8::from(i == 3)), 0.5]).collect();
        assert!((tested(&rows).p_value - 18.0 / 256.0).abs() < 1e-14);
    }

    #[test]
    fn participants_who_find_all_modes_alike_change_nothing_but_the_concordance() {
        let rows = UNTIED.map(|row| row.to_vec()).to_vec();
        let with = [rows.clone(), vec![vec![4.0; 3]]].concat();
        assert!((tested(&rows).p_value - tested(&with).p_value).abs() < 1e-14);
    }

    #[test]
    fn many_modes_are_sampled_near_the_exact_share() {
        let mut rng = stream(14, 0);
        let mut row = |k: usize| (0..k).map(|i| (rng.next_u64() % 40) as f64 + i as f64).collect();
        let wide: Vec<Vec<f64>> = (0..4).map(|_| row(11)).collect();
        assert_eq!(tested(&wide).null, Null::Sampled { draws: 10_000 });
        let rows: Vec<Vec<f64>> = (0..50).map(|_| row(3)).collect();
        let exact = tested(&rows);
        assert_eq!(exact.null, Null::Exact);
        let ranks: Vec<Vec<u64>> = rows.iter().map(|row| doubled_midranks(row)).collect();
        let sums = ranks.iter().fold(vec![0; 3], |sums, row| added(&sums, row));
        let p = sampled_p(SAMPLING, |rng| spread(&drawn(&ranks, rng), 200) >= spread(&sums, 200));
        let scatter = (exact.p_value * (1.0 - exact.p_value) / 10_000.0).sqrt();
        assert!((p - exact.p_value).abs() < 4.0 * scatter + 1e-4, "{p} {}", exact.p_value);
    }

    #[test]
    fn data_without_an_answer_say_why() {
        let words = |rows: &[&[f64]]| test(rows, SAMPLING).unwrap_err().to_string();
        assert_eq!(words(&[]), "0 participants, 1 is needed");
        assert_eq!(words(&[&[1.0]]), "1 mode, 2 are needed");
        assert_eq!(words(&[&[]]), "0 modes, 2 are needed");
        assert!(words(&[&[1.0, 1.0], &[0.3, 0.1 + 0.2]]).contains("within each participant"));
        assert!(words(&[&[1.0, f64::NAN]]).contains("NaN"));
        assert!(words(&[&[1.0, 2.0], &[1.0]]).contains("1 values where 2"));
        let many: Vec<f64> = (0..30).map(f64::from).collect();
        assert!((tested(&[many]).p_value - 1.0).abs() < 1e-14);
        assert!((tested(&[vec![1.0, 2.0, 3.0]]).p_value - 1.0).abs() < 1e-14);
    }
}
