//! The fitted model.

use super::likelihood::{Integral, Likelihood};
use super::model::{Model, Terms};
use super::point::Point;
use super::search::{Peak, Start, climb};
use crate::answers::Scale;
use crate::error::StatsError;
use crate::reference::normal_wald;
use crate::tested::{Tested, Unestimable};
use zwidth_numerics::dense::Matrix;

/// An SD below this is compared with none at all.
const SMALL_SD: f64 = 0.1;
/// An SD above this, in logits: who answers decides the answer, and the likelihood only grows flat
/// towards infinite thresholds and SDs.
const ENDLESS_SD: f64 = 20.0;
/// A log-likelihood that an SD raises by less than this is no higher than without it: what searches
/// leave.
const NO_GAIN: f64 = 1e-9;

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The categories of the model, and those that nobody chose.
    pub scale: Scale,
    /// θₖ, one between each two neighbours of the categories used, ascending.
    pub thresholds: Vec<f64>,
    /// β, one per column: for one person, the logarithm of the odds ratio of a higher answer per
    /// unit of the column.
    pub coefficients: Vec<f64>,
    /// SD of the participants' effects, on the scale of the logits.
    pub sd_participant: f64,
    /// SD of the effects of participant and mode; `None` if they are not in the model.
    pub sd_participant_mode: Option<f64>,
    /// Whether an SD of the model is estimated as zero: an outcome of little data as often as of
    /// people who are alike, and no error.
    pub singular: bool,
    /// Covariance of thresholds and coefficients, in this order: of the inverse of the observed
    /// information, in which an SD of zero counts as known.
    pub covariance: Vec<Vec<f64>>,
    /// The maximum of the log-likelihood, by the requested integral.
    pub log_likelihood: f64,
    /// Largest slope left at the maximum, per standard error of a parameter.
    pub slope: f64,
    /// The start of further searches.
    pub(super) start: Start,
}

impl Fit {
    /// The coefficient of `column` with its Wald test: estimate / std_error is referred to the
    /// normal distribution (`df` is infinite), and so is the interval. Too confident for few
    /// participants: [`super::test_columns`] and [`super::profile_interval`] are not.
    ///
    /// # Errors
    /// `level` outside (0, 1).
    pub fn wald(&self, column: usize, level: f64) -> Result<Tested, StatsError> {
        let place = self.thresholds.len() + column;
        normal_wald(self.coefficients[column], self.covariance[place][place].sqrt(), level)
    }
}

/// Fits a model by maximum likelihood.
///
/// # Errors
/// [`Unestimable::Separated`] where each participant's answers hardly vary, so that the SDs have no
/// end; [`Unestimable::NotConverged`] if the search found no maximum.
pub fn fit(model: &Model, integral: Integral) -> Result<Fit, Unestimable> {
    let (start, peak) = settled(model, integral)?;
    let thresholds = model.thresholds();
    let by_coordinates = covariance(model, integral, &start, &peak)?;
    let Point { theta, beta, sd } = Point::at(&peak.coordinates, thresholds);
    let held = &start.held[start.held.len() - 2..];
    let both = model.terms == Terms::ParticipantAndMode;
    Ok(Fit {
        scale: model.answers.scale.clone(),
        covariance: of_parameters(&by_coordinates, &peak.coordinates, thresholds),
        thresholds: theta,
        coefficients: beta,
        // The search lets SDs have any sign.
        sd_participant: sd[0].abs(),
        sd_participant_mode: both.then_some(sd[1].abs()),
        singular: held[0] || both && held[1],
        log_likelihood: peak.log_likelihood,
        slope: peak.slope,
        start: Start {
            coordinates: peak.coordinates,
            covariance: by_coordinates,
            held: start.held,
        },
    })
}

/// The maximum of the log-likelihood as [`highest`] finds it, at SDs that have an end.
pub(super) fn settled(model: &Model, integral: Integral) -> Result<(Start, Peak), Unestimable> {
    let (start, peak) = highest(model, integral)?;
    if peak.coordinates[start.held.len() - 2..].iter().any(|sd| sd.abs() > ENDLESS_SD) {
        return Err(Unestimable::Separated { what: "participants".to_owned() });
    }
    Ok((start, peak))
}

/// The maximum of the log-likelihood, with the start that led there: SDs that gain nothing are
/// held at zero.
pub(super) fn highest(model: &Model, integral: Integral) -> Result<(Start, Peak), Unestimable> {
    let mut start = Start::new(model);
    let mut peak = climb(model, integral, &start)?;
    let width = start.coordinates.len();
    for sd in [width - 1, width - 2] {
        if start.held[sd] || peak.coordinates[sd].abs() > SMALL_SD {
            continue;
        }
        let mut without = start.clone();
        without.coordinates.clone_from(&peak.coordinates);
        without.hold_at(sd, 0.0);
        let lower = climb(model, integral, &without)?;
        if lower.log_likelihood >= peak.log_likelihood - NO_GAIN {
            (start, peak) = (without, lower);
        }
    }
    Ok((start, peak))
}

/// The covariance of the coordinates: the inverse of the negative second derivatives, by central
/// differences of the gradient; 0 for those held.
fn covariance(
    model: &Model,
    integral: Integral,
    start: &Start,
    peak: &Peak,
) -> Result<Vec<Vec<f64>>, Unestimable> {
    /// Step of the differences, as a share of what is known of a coordinate's standard error.
    const STEP: f64 = 1e-3;
    let mut likelihood = Likelihood::new(model, integral);
    let free = start.free();
    let mut information = Matrix::zeros(free.len(), free.len());
    for (a, &i) in free.iter().enumerate() {
        let step = STEP * start.covariance[i][i].sqrt();
        let [low, high] = [-1.0, 1.0].map(|sign| {
            let mut moved = peak.coordinates.clone();
            moved[i] += sign * step;
            let point = Point::at(&moved, model.thresholds());
            likelihood.at(&point).1.by_coordinates(&moved)
        });
        for (b, &j) in free.iter().enumerate() {
            let bend = (low[j] - high[j]) / (2.0 * step);
            // By differences the two sides are not quite equal: half of each goes to both.
            information[(a, b)] += bend / 2.0;
            information[(b, a)] += bend / 2.0;
        }
    }
    let what = "standard errors";
    let l =
        information.cholesky(0.0).ok_or(Unestimable::NotConverged { what, slope: peak.slope })?;
    let mut all = vec![vec![0.0; start.held.len()]; start.held.len()];
    for (row, &i) in l.inverse_by_triangle().iter().zip(&free) {
        row.iter().zip(&free).for_each(|(entry, &j)| all[i][j] = *entry);
    }
    Ok(all)
}

/// The covariance of (θ, β) from that of the coordinates.
fn of_parameters(covariance: &[Vec<f64>], coordinates: &[f64], thresholds: usize) -> Vec<Vec<f64>> {
    let width = coordinates.len() - 2;
    // The Jacobian: what a parameter gains from each coordinate.
    let jacobian = Matrix::from_fn(width, width, |parameter, c| match parameter < thresholds {
        true if c == 0 => 1.0,
        true if c <= parameter => libm::exp(coordinates[c]),
        false if c == parameter => 1.0,
        _ => 0.0,
    });
    let mut by_parameters = vec![vec![0.0; width]; width];
    for (a, row) in by_parameters.iter_mut().enumerate() {
        for (b, entry) in row.iter_mut().enumerate() {
            let gains = jacobian.row(b);
            let parts = jacobian.row(a).iter().zip(covariance);
            *entry = parts
                .map(|(x, row)| x * row.iter().zip(gains).map(|(c, y)| c * y).sum::<f64>())
                .sum();
        }
    }
    by_parameters
}
