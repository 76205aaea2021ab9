//! The proportional-odds model without random effects: logit P(Y ≤ k) = θₖ − xβ (McCullagh 1980,
//! JRSS B 42:109), by maximum likelihood.
//!
//! Its log-likelihood is concave in the thresholds and the coefficients (Pratt 1981, JASA 76:103),
//! so Newton's method with halved steps finds the only maximum; its existence is checked first. All
//! answers count as independent; in a group, those of one person are not. So the model is for the
//! trials of one participant, and is the start of the model with random effects.

use crate::answers::Answers;
pub use crate::answers::{Column, Scale};
use crate::error::StatsError;

use crate::logistic::{by_threshold, inner, logit, softplus_and_share};
use crate::profile;
use crate::reference;
pub use crate::reference::ChiSquareTest;
use crate::separation::Pattern;
use crate::tested::{Tested, Unestimable};
use zwidth_numerics::dense::{Matrix, dot};

/// Newton's method has converged where the next step promises less of the log-likelihood.
const PROMISE: f64 = 1e-18;
/// Where a step promises less than this, rounding hides whether it helped: it is taken.
const TRUSTED: f64 = 1e-9;
/// Ends are searched up to this many standard errors from the estimate.
const FARTHEST: f64 = 1000.0;
/// More steps than a log-likelihood with a maximum takes.
const MAX_STEPS: usize = 200;

/// Screened answers with the columns that may explain them.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    answers: Answers,
    patterns: Vec<Pattern>,
}

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The categories of the model, and those that nobody chose.
    pub scale: Scale,
    /// θₖ, one between each two neighbours of the categories used, ascending.
    pub thresholds: Vec<f64>,
    /// β, one per column: the logarithm of the odds ratio of a higher answer per unit of the
    /// column.
    pub coefficients: Vec<f64>,
    /// Covariance of thresholds and coefficients, in this order: the inverse of the observed
    /// information.
    pub covariance: Vec<Vec<f64>>,
    /// The maximum of the log-likelihood.
    pub log_likelihood: f64,
}

/// The log-likelihood at a point, its gradient and its negative second derivatives.
struct Surface {
    value: f64,
    gradient: Vec<f64>,
    information: Matrix,
}

impl Model {
    /// `answers` from 1 to `points`, one row each, with the `columns` of the fixed effects.
    ///
    /// # Errors
    /// An answer off its scale, columns of another length or not finite
    /// ([`Unestimable::Refused`]); fewer answers than parameters; all answers equal; columns that
    /// cannot be told apart; answers that columns separate.
    pub fn new(answers: &[u8], points: u8, columns: &[Column]) -> Result<Self, Unestimable> {
        let answers = Answers::new(answers, points, columns)?;
        answers.screen()?;
        Ok(Self::of(answers))
    }

    /// The model of answers that were screened, or that need not have a maximum.
    pub(crate) fn of(answers: Answers) -> Self {
        let patterns = answers.patterns(0..answers.codes.len());
        Self { answers, patterns }
    }

    fn thresholds(&self) -> usize {
        self.answers.categories() - 1
    }

    /// The logits of the cumulated shares: the thresholds without effects of the columns.
    pub(crate) fn cumulated_logits(&self) -> Vec<f64> {
        let all = self.answers.codes.len() as f64;
        let counts =
            (0..self.thresholds()).map(|k| self.answers.codes.iter().filter(|&&c| c <= k).count());
        counts.map(|up_to| logit(up_to as f64 / all)).collect()
    }

    fn start(&self) -> Vec<f64> {
        let mut start = self.cumulated_logits();
        start.resize(self.thresholds() + self.answers.columns.len(), 0.0);
        start
    }
}

impl Fit {
    /// The coefficient of `column` with its Wald test: estimate / std_error is referred to the
    /// normal distribution (`df` is infinite), and so is the interval.
    ///
    /// # Errors
    /// `level` outside (0, 1).
    pub fn wald(&self, column: usize, level: f64) -> Result<Tested, StatsError> {
        let place = self.thresholds.len() + column;
        let std_error = self.covariance[place][place].sqrt();
        reference::normal_wald(self.coefficients[column], std_error, level)
    }
}

/// Fits a model by maximum likelihood.
///
/// # Errors
/// [`Unestimable::NotConverged`] if Newton's method did not end: on screened answers it would be a
/// model next to separation.
pub fn fit(model: &Model) -> Result<Fit, Unestimable> {
    let (point, surface) = maximise(model, model.start(), None)?;
    let l = surface.information.cholesky(0.0).ok_or_else(|| not_converged(&surface))?;
    let (thresholds, coefficients) = point.split_at(model.thresholds());
    Ok(Fit {
        scale: model.answers.scale.clone(),
        thresholds: thresholds.to_vec(),
        coefficients: coefficients.to_vec(),
        covariance: l.inverse_by_triangle(),
        log_likelihood: surface.value,
    })
}

/// Whether the columns that only `larger` has matter: the likelihood-ratio test. `smaller` is the
/// fit of the same answers with some of the same columns.
///
/// # Errors
/// `smaller` has no column less.
pub fn likelihood_ratio(larger: &Fit, smaller: &Fit) -> Result<ChiSquareTest, StatsError> {
    let df = larger.coefficients.len() as f64 - smaller.coefficients.len() as f64;
    let gain = (larger.log_likelihood - smaller.log_likelihood).max(0.0);
    reference::chi_square(2.0 * gain, df)
}

/// The profile interval of the coefficient of `column` at confidence `level`: the values at which
/// the log-likelihood, maximised over all else, is at most z²/2 below its maximum.
///
/// # Errors
/// `level` outside (0, 1); a search that did not converge.
pub fn profile_interval(
    model: &Model,
    fit: &Fit,
    column: usize,
    level: f64,
) -> Result<(f64, f64), Unestimable> {
    let z = reference::normal_critical(level)?;
    let place = fit.thresholds.len() + column;
    let std_error = fit.covariance[place][place].sqrt();
    let peak: Vec<f64> = fit.thresholds.iter().chain(&fit.coefficients).copied().collect();
    let mut ends = [-1.0, 1.0];
    for end in &mut ends {
        let sign = *end;
        let mut point = peak.clone();
        let fall = |distance: f64| {
            point[place] = peak[place] + sign * distance * std_error;
            let (best, surface) = maximise(model, point.clone(), Some(place))?;
            // The next search is near by: it begins where this one ended.
            point = best;
            Ok((2.0 * (fit.log_likelihood - surface.value).max(0.0)).sqrt())
        };
        // Concave and bounded by its maximum, the profile falls below any level.
        let distance = profile::end(fall, z, FARTHEST)?.unwrap_or(f64::INFINITY);
        *end = peak[place] + sign * distance * std_error;
    }
    Ok(ends.into())
}

/// The maximum of the log-likelihood from `start`, with the parameter `held`, if any, at its value.
fn maximise(
    model: &Model,
    start: Vec<f64>,
    held: Option<usize>,
) -> Result<(Vec<f64>, Surface), Unestimable> {
    let mut point = start;
    let mut here = surface(model, &point);
    for _ in 0..MAX_STEPS {
        if let Some(held) = held {
            // The step along this parameter becomes 0, and that of the others independent of it.
            here.gradient[held] = 0.0;
            for i in 0..here.information.rows {
                here.information[(i, held)] = 0.0;
            }
            here.information.row_mut(held).fill(0.0);
            here.information[(held, held)] = 1.0;
        }
        let l = here.information.cholesky(0.0).ok_or_else(|| not_converged(&here))?;
        let step = l.solve_by_triangle(&here.gradient);
        // How far the parabola at this point rises to its top.
        let promise = dot(&step, &here.gradient) / 2.0;
        if promise <= PROMISE {
            return Ok((point, here));
        }
        let mut share = 1.0;
        loop {
            let trial: Vec<f64> = point.iter().zip(&step).map(|(p, s)| p + share * s).collect();
            // Where thresholds cross there is no likelihood.
            let is_ascending = trial[..model.thresholds()].windows(2).all(|t| t[0] < t[1]);
            let ahead = is_ascending.then(|| surface(model, &trial));
            if let Some(ahead) = ahead.filter(|s| promise < TRUSTED || s.value > here.value) {
                (point, here) = (trial, ahead);
                break;
            }
            share /= 2.0;
            if share < f64::EPSILON {
                return Err(not_converged(&here));
            }
        }
    }
    Err(not_converged(&here))
}

/// The error of a search that ended at a point with this surface.
fn not_converged(surface: &Surface) -> Unestimable {
    let slope = surface.gradient.iter().fold(0.0_f64, |most, g| most.max(g.abs()));
    Unestimable::NotConverged { what: "the thresholds and coefficients", slope }
}

/// The log-likelihood with its derivatives by (θ, β), summed over patterns in their order.
fn surface(model: &Model, point: &[f64]) -> Surface {
    let thresholds = model.thresholds();
    let (theta, beta) = point.split_at(thresholds);
    let mut sum = Surface {
        value: 0.0,
        gradient: vec![0.0; point.len()],
        information: Matrix::zeros(point.len(), point.len()),
    };
    for pattern in &model.patterns {
        let eta = dot(&pattern.x, beta);
        let (below, beside) = by_threshold(&pattern.counts);
        for j in 0..thresholds {
            let z = theta[j] - eta;
            let (softplus, share) = softplus_and_share(z);
            sum.value += below[j] * z - beside[j] * softplus;
            let slope = below[j] - beside[j] * share;
            let bend = beside[j] * share * (1.0 - share);
            // z falls along β by x.
            sum.gradient[j] += slope;
            sum.information[(j, j)] += bend;
            for (a, xa) in pattern.x.iter().enumerate() {
                let row = thresholds + a;
                sum.gradient[row] -= slope * xa;
                sum.information[(row, j)] -= bend * xa;
                for (b, xb) in pattern.x[..=a].iter().enumerate() {
                    sum.information[(row, thresholds + b)] += bend * xa * xb;
                }
            }
        }
    }
    for k in 1..thresholds {
        let count: f64 = model.patterns.iter().map(|p| p.counts[k]).sum();
        let [value, slope, bend] = inner(count, theta[k] - theta[k - 1]);
        sum.value += value;
        sum.gradient[k] += slope;
        sum.gradient[k - 1] -= slope;
        sum.information[(k, k)] -= bend;
        sum.information[(k - 1, k - 1)] -= bend;
        sum.information[(k, k - 1)] += bend;
    }
    // Until here the lower triangle alone was summed.
    for i in 0..point.len() {
        for j in i + 1..point.len() {
            sum.information[(i, j)] = sum.information[(j, i)];
        }
    }
    sum
}

#[cfg(test)]
mod tests;
