//! How far several questions measure one thing.

use crate::error::{all_finite, check_level};
use crate::f_distribution::quantile;
use crate::tested::{at_least, not_constant};
use crate::{StatsError, Unestimable};
use zwidth_numerics::dense::Matrix;
use zwidth_numerics::minimise::minimise;
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

/// With fewer people ω is often improper: of five questions a uniqueness goes to 0 in 72 of 100 studies of 6 people, in
/// 8 of 20.
pub const LEAST_FOR_OMEGA: usize = 20;

/// A uniqueness below this, as a share of the question's variance, is at 0: one question is the factor itself.
const IMPROPER: f64 = 0.005;

/// A slope of the likelihood that ends its search.
const SLOPE: f64 = 1e-9;

/// ω of people's answers, a row of them per person: (Σλ)² / ((Σλ)² + Σψ) with the loadings λ and uniquenesses ψ of one
/// factor by maximum likelihood (McDonald 1999, *Test Theory*; Jöreskog 1967, Psychometrika 32:443).
///
/// # Errors
/// Not more people than questions, fewer than three questions; a question without scatter; a uniqueness at 0; values as of
/// [`alpha`].
pub fn omega(people: &[Vec<f64>]) -> Result<f64, Unestimable> {
    let k = people.first().map_or(0, Vec::len);
    at_least("questions", k, 3)?;
    at_least("participants with every question", people.len(), k + 1)?;
    for (row, answers) in people.iter().enumerate() {
        if answers.len() != k {
            return Err(StatsError::Ragged { row, expected: k, found: answers.len() }.into());
        }
        all_finite(answers)?;
    }
    let each: Vec<Moments> = (0..k)
        .map(|i| Moments::of(&people.iter().map(|row| row[i]).collect::<Vec<f64>>()))
        .collect();
    let sds: Vec<f64> = each.iter().map(|moments| moments.sd().unwrap_or(0.0)).collect();
    not_constant("answers to a question", sds.iter().any(|sd| *sd <= 0.0))?;
    let correlations = Matrix::from_fn(k, k, |i, j| {
        let products = people.iter().map(|row| (row[i] - each[i].mean) * (row[j] - each[j].mean));
        products.sum::<f64>() / ((people.len() - 1) as f64 * sds[i] * sds[j])
    });
    // The loadings that are best with these uniquenesses, and minus the log-likelihood (times 2/n).
    let at = |logs: &[f64]| {
        let roots: Vec<f64> = logs.iter().map(|log| libm::exp(log / 2.0)).collect();
        let scaled = Matrix::from_fn(k, k, |i, j| correlations[(i, j)] / (roots[i] * roots[j]));
        let (values, vectors) = scaled.eigen();
        let first = (0..k).max_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
        let size = (values[first] - 1.0).max(0.0).sqrt();
        let loadings: Vec<f64> = (0..k).map(|i| size * roots[i] * vectors[(first, i)]).collect();
        let others = values.iter().enumerate().filter(|(place, _)| *place != first);
        let deviance: f64 = others.map(|(_, value)| value - libm::log(*value) - 1.0).sum();
        // ∂/∂ log ψᵢ of the profile (Lawley & Maxwell 1971, *Factor Analysis*, §4.3).
        let slope = |i: usize| {
            let psi = roots[i] * roots[i];
            (loadings[i] * loadings[i] + psi - correlations[(i, i)]) / psi
        };
        let gradient: Vec<f64> = (0..k).map(slope).collect();
        (loadings, deviance, gradient)
    };
    let criterion = |logs: &[f64]| {
        let (_, deviance, gradient) = at(logs);
        // A uniqueness far below what counts as 0 is no place to search on.
        let is_there = logs.iter().all(|log| *log > 4.0 * libm::log(IMPROPER));
        (if is_there { deviance } else { f64::NAN }, gradient)
    };
    let minimum = minimise(criterion, &vec![libm::log(0.5); k], SLOPE).map_err(StatsError::from)?;
    let uniquenesses: Vec<f64> = minimum.point.iter().map(|log| libm::exp(*log)).collect();
    if uniquenesses.iter().any(|unique| *unique < IMPROPER) {
        let what = "one question from the factor that all share".to_owned();
        return Err(Unestimable::Confounded { what });
    }
    if minimum.slope() > SLOPE.sqrt() {
        return Err(Unestimable::NotConverged { what: "the factor", slope: minimum.slope() });
    }
    let (loadings, ..) = at(&minimum.point);
    let shared: f64 = loadings.iter().zip(&sds).map(|(loading, sd)| loading * sd).sum();
    let own: f64 = uniquenesses.iter().zip(&sds).map(|(unique, sd)| unique * sd * sd).sum();
    Ok(shared * shared / (shared * shared + own))
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
        // R's `factanal` of one factor; in the other mode it leaves a uniqueness at its bound.
        near(omega(&odd(1)).unwrap(), 0.917815110);
        let improper = omega(&odd(0)).unwrap_err();
        assert!(matches!(improper, Unestimable::Confounded { .. }), "{improper}");
        // The unit of the answers is of no account.
        let scaled: Vec<Vec<f64>> =
            odd(1).iter().map(|row| row.iter().map(|answer| 10.0 * answer).collect()).collect();
        near(omega(&scaled).unwrap(), 0.917815110);
    }

    #[test]
    fn what_has_no_alpha_says_why() {
        let words = |rows: &[Vec<f64>]| alpha(rows, 0.95).unwrap_err().to_string();
        let three = vec![vec![1.0, 2.0]; 3];
        assert_eq!(words(&three), "3 participants with every question, 4 are needed");
        let flat: Vec<Vec<f64>> = (0..5).map(|i| vec![f64::from(i), 3.0]).collect();
        assert!(words(&flat).starts_with("all answers to a question are equal"));
        let ragged = vec![vec![1.0, 2.0], vec![2.0], vec![1.0, 2.0], vec![2.0, 1.0]];
        assert!(alpha(&ragged, 0.95).is_err() && omega(&ragged).is_err());
        assert_eq!(omega(&three).unwrap_err().to_string(), "2 questions, 3 are needed");
    }
}
