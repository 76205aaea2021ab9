//! Whether a cumulative-link model has finite estimates: the screen for separation.
//!
//! With answers k and columns x the log-likelihood Σ ln(F(θₖ − xβ) − F(θₖ₋₁ − xβ)) is concave.
//! Along a direction (δ, b) an answer's term never falls if δₖ − xb ≥ 0 (for all but the last
//! category) and δₖ₋₁ − xb ≤ 0 (for all but the first); any other direction takes it to −∞. So a
//! finite, unique maximum exists if and only if no direction but 0 meets all of these (the
//! recession cone of Rockafellar 1970, *Convex Analysis*, Theorem 27.1; for logistic models Albert
//! & Anderson 1984, Biometrika 71:1; for cumulative links Haberman 1980 and Kosmidis 2014, JRSS B
//! 76:169). Where one does, the answers are separated, completely or quasi-completely.
//!
//! With the conditions as rows of A this asks for d with A d ≥ 0, A d ≠ 0 (A has full column rank).
//! By Stiemke's lemma there is none if and only if Aᵀy = 0 for some y > 0, that is y ≥ 1. The least
//! ‖Aᵀy‖ over y ≥ 1 decides it: a problem of non-negative least squares (Lawson & Hanson 1974,
//! chapter 23). Where its residual r = Aᵀy is not 0, the conditions of optimality say A r ≥ 0 and
//! A r ≠ 0: the residual itself is the direction, a proof that can be checked.

use zwidth_numerics::dense::{Matrix, dot};

/// Answers that share their values of all columns.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pattern {
    /// The values, one per column.
    pub(crate) x: Vec<f64>,
    /// Number of answers by category.
    pub(crate) counts: Vec<f64>,
}

/// Lengths and slopes below this share of what they are made of are rounding: entries are small
/// whole numbers as a rule, and solutions ratios of such.
const ROUNDING: f64 = 1e-7;
/// Rounds of the search per row of A, at most.
const ROUNDS_PER_ROW: usize = 10;

/// The coefficients' part of a direction along which the likelihood never falls; `None` where the
/// estimates are finite. Each of the categories must occur, and the columns be independent of each
/// other and of a column of ones.
pub(crate) fn direction(patterns: &[Pattern], categories: usize) -> Option<Vec<f64>> {
    // Columns of size 1, so that one measure of rounding serves all; the direction is scaled back.
    let scales = scales(patterns);
    let rows = conditions(patterns, categories, &scales);
    let residual = least_combination(&rows)?;
    Some(residual[categories - 1..].iter().zip(&scales).map(|(b, scale)| b / scale).collect())
}

/// The largest absolute value of each column.
fn scales(patterns: &[Pattern]) -> Vec<f64> {
    let columns = patterns.first().map_or(0, |p| p.x.len());
    (0..columns).map(|j| patterns.iter().fold(0.0_f64, |most, p| most.max(p.x[j].abs()))).collect()
}

/// The rows of A, each of length 1. A direction's thresholds never cross (each category occurs), so
/// of a pattern's answers only the lowest and the highest matter.
fn conditions(patterns: &[Pattern], categories: usize, scales: &[f64]) -> Vec<Vec<f64>> {
    let thresholds = categories - 1;
    let width = thresholds + scales.len();
    let mut rows = Vec::new();
    for k in 1..thresholds {
        let mut row = vec![0.0; width];
        (row[k], row[k - 1]) = (1.0, -1.0);
        rows.push(row);
    }
    for pattern in patterns {
        let lowest = pattern.counts.iter().position(|count| *count > 0.0);
        let highest = pattern.counts.iter().rposition(|count| *count > 0.0);
        let above = lowest.filter(|&k| k < thresholds).map(|k| (k, 1.0));
        let below = highest.filter(|&k| k > 0).map(|k| (k - 1, -1.0));
        for (threshold, sign) in above.into_iter().chain(below) {
            let mut row = vec![0.0; width];
            row[threshold] = sign;
            for (j, (x, scale)) in pattern.x.iter().zip(scales).enumerate() {
                row[thresholds + j] = -sign * x / scale;
            }
            rows.push(row);
        }
    }
    for row in &mut rows {
        let length = dot(row, row).sqrt();
        row.iter_mut().for_each(|entry| *entry /= length);
    }
    rows
}

/// The shortest Aᵀy with y ≥ 1, or `None` where it is 0 (or where rounding keeps it from being
/// found: then nothing is proved, and the search for the estimates decides).
fn least_combination(rows: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut y = vec![1.0; rows.len()];
    let mut free: Vec<usize> = Vec::new();
    // Each round ends nearer to 0, with another set of free rows; a few per row are the rule.
    for _ in 0..ROUNDS_PER_ROW * rows.len() {
        let residual = combination(rows, &y);
        let length = dot(&residual, &residual).sqrt();
        if length <= ROUNDING * y.iter().sum::<f64>() {
            return None;
        }
        let held = (0..rows.len()).filter(|i| !free.contains(i));
        let slopes = held.map(|i| (i, dot(&rows[i], &residual) / length));
        let steepest = slopes.min_by(|(_, a), (_, b)| a.total_cmp(b));
        match steepest.filter(|(_, slope)| *slope < -ROUNDING) {
            None => return Some(residual),
            Some((entering, _)) => free.push(entering),
        }
        if !settle(rows, &mut y, &mut free) {
            return None;
        }
    }
    None
}

/// Moves the free y to their least-squares values; one that would fall below 1 stops there and is
/// held. Whether that could be solved: rows that depend on each other to rounding cannot.
fn settle(rows: &[Vec<f64>], y: &mut [f64], free: &mut Vec<usize>) -> bool {
    loop {
        let held: Vec<f64> =
            (0..y.len()).map(|i| if free.contains(&i) { 0.0 } else { y[i] }).collect();
        let rest = combination(rows, &held);
        let products =
            Matrix::from_fn(free.len(), free.len(), |a, b| dot(&rows[free[a]], &rows[free[b]]));
        let Some(l) = products.cholesky(0.0) else { return false };
        let pulls: Vec<f64> = free.iter().map(|&i| -dot(&rows[i], &rest)).collect();
        let target = l.solve_by_triangle(&pulls);
        let falling = free.iter().zip(&target).filter(|(_, to)| **to < 1.0);
        let shares = falling.map(|(&i, to)| (y[i] - 1.0) / (y[i] - to));
        let step = shares.fold(1.0_f64, f64::min);
        for (&i, to) in free.iter().zip(&target) {
            y[i] += step * (to - y[i]);
        }
        if step >= 1.0 {
            return true;
        }
        // One that stands at its bound but for rounding would end the next step at its beginning.
        free.retain(|&i| y[i] > 1.0 + ROUNDING);
        (0..y.len()).filter(|i| !free.contains(i)).for_each(|i| y[i] = 1.0);
    }
}

/// Aᵀy.
fn combination(rows: &[Vec<f64>], y: &[f64]) -> Vec<f64> {
    let width = rows.first().map_or(0, Vec::len);
    let mut sum = vec![0.0; width];
    for (row, y) in rows.iter().zip(y) {
        sum.iter_mut().zip(row).for_each(|(sum, entry)| *sum += y * entry);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(patterns: &[(&[f64], &[f64])], expect: Option<&[bool]>) {
        let patterns: Vec<Pattern> = patterns
            .iter()
            .map(|(x, counts)| Pattern { x: x.to_vec(), counts: counts.to_vec() })
            .collect();
        let categories = patterns[0].counts.len();
        let found = direction(&patterns, categories);
        let moved = found.as_ref().map(|d| {
            let largest = d.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
            d.iter().map(|b| b.abs() > 1e-6 * largest).collect::<Vec<_>>()
        });
        assert_eq!(moved.as_deref(), expect, "{found:?}");
    }

    #[test]
    fn a_level_whose_answers_do_not_overlap_the_others_is_separated() {
        // complete: 1 and 2 against 3
        check(&[(&[0.0], &[3.0, 2.0, 0.0]), (&[1.0], &[0.0, 0.0, 4.0])], Some(&[true]));
        // quasi-complete: they share the category 2, and nothing else
        check(&[(&[0.0], &[3.0, 2.0, 0.0]), (&[1.0], &[0.0, 2.0, 4.0])], Some(&[true]));
        // overlap: a 1 where there are 3s
        check(&[(&[0.0], &[3.0, 2.0, 0.0]), (&[1.0], &[1.0, 0.0, 4.0])], None);
    }

    #[test]
    fn a_shared_middle_category_alone_does_not_overlap() {
        check(
            &[(&[0.0], &[1.0, 1.0, 0.0]), (&[1.0], &[0.0, 5.0, 0.0]), (&[2.0], &[0.0, 1.0, 1.0])],
            Some(&[true]),
        );
    }

    #[test]
    fn one_separated_level_of_three_is_told_from_the_others() {
        let levels: [(&[f64], &[f64]); 3] = [
            (&[0.0, 0.0], &[2.0, 3.0, 1.0]),
            (&[1.0, 0.0], &[1.0, 3.0, 2.0]),
            (&[0.0, 1.0], &[0.0, 0.0, 6.0]),
        ];
        check(&levels, Some(&[false, true]));
    }

    #[test]
    fn no_single_column_but_a_sum_of_two_can_separate() {
        // The answer is "2" where x + z > 1.5, on a grid where neither x nor z alone decides.
        let mut patterns: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
        for (x, z) in (0..9).map(|i| (f64::from(i % 3), f64::from(i / 3))) {
            let high = x + z > 1.5;
            patterns.push((vec![x, z], if high { vec![0.0, 1.0] } else { vec![1.0, 0.0] }));
        }
        let borrowed: Vec<(&[f64], &[f64])> =
            patterns.iter().map(|(x, c)| (x.as_slice(), c.as_slice())).collect();
        check(&borrowed, Some(&[true, true]));
        patterns[4].1 = vec![1.0, 1.0];
        patterns[2].1 = vec![1.0, 1.0];
        patterns[8].1 = vec![1.0, 1.0];
        let borrowed: Vec<(&[f64], &[f64])> =
            patterns.iter().map(|(x, c)| (x.as_slice(), c.as_slice())).collect();
        check(&borrowed, None);
    }

    #[test]
    fn the_scale_of_a_column_does_not_matter() {
        for scale in [1e-9, 1.0, 1e9] {
            let at = |x: f64| vec![x * scale];
            let (low, middle, high) = (at(-1.0), at(0.5), at(2.0));
            check(
                &[(&low, &[3.0, 0.0]), (&middle, &[1.0, 1.0]), (&high, &[0.0, 1.0])],
                Some(&[true]),
            );
            check(&[(&low, &[3.0, 0.0]), (&middle, &[1.0, 1.0]), (&high, &[1.0, 1.0])], None);
        }
    }

    #[test]
    fn without_columns_nothing_is_separated() {
        check(&[(&[], &[1.0, 4.0, 2.0])], None);
    }
}
