//! Profile intervals of fixed effects.

use super::fit::Fit;
use super::likelihood::Integral;
use super::model::Model;
use super::search::{Start, climb};
use crate::profile::end;
use crate::student_t::critical_value;
use crate::tested::Unestimable;

/// The values of a coefficient that its likelihood-ratio test does not reject.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProfileInterval {
    /// The lower end; `None` where the likelihood never falls that far.
    pub low: Option<f64>,
    /// The upper end; `None` as below.
    pub high: Option<f64>,
}

/// The profile interval of the coefficient of `column`: where twice the log-likelihood, maximised
/// over all else, is at most t² below its maximum, t the critical value at confidence `level` of
/// Student's t with `df` degrees of freedom. So the interval holds what the test referred to
/// F(1, `df`) does not reject.
///
/// # Errors
/// `level` outside (0, 1), `df` not positive; a search that found no maximum.
pub fn profile_interval(
    model: &Model,
    integral: Integral,
    fit: &Fit,
    column: usize,
    level: f64,
    df: f64,
) -> Result<ProfileInterval, Unestimable> {
    let critical = critical_value(level, df)?;
    let place = model.thresholds() + column;
    let peak = &fit.start.coordinates;
    let std_error = fit.start.covariance[place][place].sqrt();
    let distance = |sign: f64| {
        let mut start = Start::again(model, peak, &fit.start.covariance);
        let fall = |distance: f64| {
            start.hold_at(place, peak[place] + sign * distance * std_error);
            let found = climb(model, integral, &start)?;
            start.coordinates = found.coordinates;
            Ok((2.0 * (fit.log_likelihood - found.log_likelihood).max(0.0)).sqrt())
        };
        end(fall, critical)
    };
    let at = |sign: f64, distance: f64| peak[place] + sign * distance * std_error;
    Ok(ProfileInterval {
        low: distance(-1.0)?.map(|d| at(-1.0, d)),
        high: distance(1.0)?.map(|d| at(1.0, d)),
    })
}
