//! How far several questions measure one thing.

use crate::error::{all_finite, check_level};
use crate::f_distribution::quantile;
use crate::tested::{at_least, not_constant};
use crate::{StatsError, Unestimable};
use zwidth_numerics::moments::Moments;

/// With fewer people there is no α: its interval would hold nearly everything.
pub const LEAST: usize = 4;

/// Cronbach's α.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alpha {
    /// The estimate; below 0 where questions contradict each other.
    pub alpha: f64,
    /// The ends of its interval.
    pub ends: [f64; 2],
}

/// α of people's answers, a row of them per person: k/(k − 1) (1 − Σ s²ᵢ / s²) with the variances of each
/// question and of the sums (Cronbach 1951, Psychometrika 16:297). The interval is 1 − (1 − α) F with n − 1 and
/// (n − 1)(k − 1) degrees of freedom (Feldt, Woodruff & Salih 1987, Appl. Psychol. Meas. 11:93).
///
/// # Errors
/// Fewer than four people or two questions; a question, or the sums, without scatter; rows of different length; a
/// value that is not finite; a level outside (0, 1).
pub fn alpha(people: &[Vec<f64>], level: f64) -> Result<Alpha, Unestimable> {
    let n = people.len();
    at_least("participants with every question", n, LEAST)?;
    check_level(level)?;
    let k = people[0].len();
    at_least("questions", k, 2)?;
    for (row, answers) in people.iter().enumerate() {
        if answers.len() != k {
            return Err(StatsError::Ragged { row, expected: k, found: answers.len() }.into());
        }
        all_finite(answers)?;
    }
    let variance = |values: Vec<f64>| Moments::of(&values).variance().unwrap_or(0.0);
    let each: Vec<f64> =
        (0..k).map(|i| variance(people.iter().map(|row| row[i]).collect())).collect();
    let whole = variance(people.iter().map(|row| row.iter().sum()).collect());
    let is_flat = |variance: &f64| *variance <= 0.0;
    not_constant("answers to a question", each.iter().any(is_flat))?;
    not_constant("sums of answers", is_flat(&whole))?;
    let k = k as f64;
    let alpha = k / (k - 1.0) * (1.0 - each.iter().sum::<f64>() / whole);
    let [df, error] = [(n - 1) as f64, (n - 1) as f64 * (k - 1.0)];
    let tail = (1.0 - level) / 2.0;
    let end = |share: f64| Ok::<f64, StatsError>(1.0 - (1.0 - alpha) * quantile(share, df, error)?);
    Ok(Alpha { alpha, ends: [end(1.0 - tail)?, end(tail)?] })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten people's answers to the ten questions of a System Usability Scale by formula, turned. R by definition,
    /// and pingouin 0.7's `cronbach_alpha`.
    #[test]
    fn alpha_is_that_of_pingouin() {
        let u = |of: &[u64]| {
            let weights = [131, 173, 197, 211];
            let h = 1 + of.iter().zip(weights).map(|(value, weight)| value * weight).sum::<u64>();
            (h * h * h % 9941) as f64 / 9941.0 - 0.5
        };
        let answers = |mode: u64| -> Vec<Vec<f64>> {
            let person = |p: u64| {
                let g = 1.8 * u(&[p, 1]) + 0.7 * u(&[p, 2, mode]) + 0.4 * mode as f64;
                let answer = |i: u64| {
                    let s = g + 1.2 * u(&[p, 20 + i, mode + 1]);
                    // Even questions are the other way round, and turned again.
                    match i % 2 {
                        1 => (3.3 + s + 0.5).floor().clamp(1.0, 5.0),
                        _ => 6.0 - (3.0 - s + 0.5).floor().clamp(1.0, 5.0),
                    }
                };
                (1..=10).map(answer).collect()
            };
            (1..=10).map(person).collect()
        };
        let near = |found: f64, expected: f64| {
            assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{found} {expected}");
        };
        for (mode, expected) in [
            (0, [0.920056348, 0.818096844, 0.976622338]),
            (1, [0.936924494, 0.856478490, 0.981555030]),
        ] {
            let found = alpha(&answers(mode), 0.95).unwrap();
            near(found.alpha, expected[0]);
            near(found.ends[0], expected[1]);
            near(found.ends[1], expected[2]);
        }
        let odd = |mode: u64| -> Vec<Vec<f64>> {
            let rows = answers(mode).into_iter();
            rows.map(|row| row.into_iter().step_by(2).collect()).collect()
        };
        near(alpha(&odd(1), 0.95).unwrap().alpha, 0.918703008);
        near(alpha(&odd(0), 0.95).unwrap().alpha, 0.895833333);
    }

    #[test]
    fn what_has_no_alpha_says_why() {
        let words = |rows: &[Vec<f64>]| alpha(rows, 0.95).unwrap_err().to_string();
        let three = vec![vec![1.0, 2.0]; 3];
        assert_eq!(words(&three), "3 participants with every question, 4 are needed");
        let flat: Vec<Vec<f64>> = (0..5).map(|i| vec![f64::from(i), 3.0]).collect();
        assert!(words(&flat).starts_with("all answers to a question are equal"));
        let ragged = vec![vec![1.0, 2.0], vec![2.0], vec![1.0, 2.0], vec![2.0, 1.0]];
        assert!(alpha(&ragged, 0.95).is_err());
    }
}
