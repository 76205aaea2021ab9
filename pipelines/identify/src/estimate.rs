//! How well each parameter is known.

use crate::IdentifyError;
use crate::fit::{Block, Problem, sum};
use crate::slopes::Parameter;
use crate::verdict::{Verdict, inflation, verdict};
use zwidth_numerics::nonlinear::Minimum;
use zwidth_stats::bootstrap::{expanded_level, percentile_interval, resample};
use zwidth_stats::interval::sd;

/// Resamples of the trials: the ends of a 95 % interval then scatter by a few per cent of its width.
const RESAMPLES: usize = 2000;
/// Seed of the resamples: any will do, and it stays.
const SEED: u64 = 24;

/// A fitted parameter; unit as the parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value.
    pub fitted: f64,
    /// Standard deviation over the resamples; `None` for a parameter that is not free to move.
    pub std_error: Option<f64>,
    /// Ends of its interval, within the bounds; `None` likewise.
    pub interval: Option<(f64, f64)>,
    /// Variance inflation: by how much its variance is larger than if the other parameters were known, 1 at least;
    /// `None` likewise.
    pub inflation: Option<f64>,
    /// Its profile: what becomes of the error when it is changed and the others are fitted anew.
    pub profile: Profile,
    /// Whether the trials say what it is.
    pub verdict: Verdict,
}

/// Root mean square error over the samples of all fitted trials, unit as the recording; `None` where the changed
/// value lies outside the bounds, or the model does not run there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    /// At the fit.
    pub fitted: f64,
    /// With half of the fitted value, all other parameters fitted anew.
    pub halved: Option<f64>,
    /// With twice the fitted value.
    pub doubled: Option<f64>,
}

/// The profile of parameter `j` around a minimum.
fn profile<const P: usize>(problem: &Problem<P>, minimum: &Minimum<P>, j: usize) -> Profile {
    let rms = |rss: f64| (rss / problem.samples() as f64).sqrt();
    let (value, Parameter { lower, upper, .. }) = (minimum.parameters[j], problem.parameters[j]);
    let at = |value: f64| {
        let inside = value > 0.0 && (lower..=upper).contains(&value);
        inside.then(|| problem.profile(&minimum.parameters, j, value)).flatten().map(rms)
    };
    Profile { fitted: rms(minimum.rss), halved: at(value / 2.0), doubled: at(2.0 * value) }
}

/// Which parameters are free to move: those that are on no bound and that the recordings feel.
pub(crate) fn free<const P: usize>(parameters: &[Parameter; P], at: &[f64; P], all: &Block<P>) -> [bool; P] {
    core::array::from_fn(|j| !on_bound(&parameters[j], at[j]) && all.curvature[j][j] > 0.0)
}

/// Whether a value sits on one of its bounds.
pub(crate) fn on_bound(parameter: &Parameter, value: f64) -> bool {
    value <= parameter.lower || value >= parameter.upper
}

/// One Gauss–Newton step from `at` with the normal equations of some trials, over the parameters that are free and
/// within the bounds; `None` where these trials do not determine them.
pub(crate) fn stepped<const P: usize>(
    parameters: &[Parameter; P],
    at: &[f64; P],
    free: &[bool; P],
    of: &Block<P>,
) -> Option<[f64; P]> {
    let inverse = inverse(&of.curvature, free)?;
    let step = |j: usize| (0..P).map(|k| inverse[j][k] * of.gradient[k]).sum::<f64>();
    Some(core::array::from_fn(|j| match free[j] {
        true => (at[j] - step(j)).clamp(parameters[j].lower, parameters[j].upper),
        false => at[j],
    }))
}

/// The inverse over the free parameters, 0 elsewhere, by Gauss–Jordan elimination of the matrix scaled to a
/// diagonal of ones; `None` if it is singular.
pub(crate) fn inverse<const P: usize>(matrix: &[[f64; P]; P], free: &[bool; P]) -> Option<[[f64; P]; P]> {
    let scale: [f64; P] = core::array::from_fn(|j| matrix[j][j].sqrt());
    let both = |j: usize, k: usize| free[j] && free[k];
    let mut left: [[f64; P]; P] = core::array::from_fn(|j| {
        core::array::from_fn(|k| match both(j, k) {
            true => matrix[j][k] / (scale[j] * scale[k]),
            false => f64::from(u8::from(j == k)),
        })
    });
    let mut right: [[f64; P]; P] =
        core::array::from_fn(|j| core::array::from_fn(|k| f64::from(u8::from(j == k))));
    for j in 0..P {
        let pivot = left[j][j];
        // positive definite: every pivot is above 0, and rounding is what is left of one that is not
        if pivot.is_nan() || pivot <= f64::EPSILON {
            return None;
        }
        for k in 0..P {
            left[j][k] /= pivot;
            right[j][k] /= pivot;
        }
        let (row, of) = (left[j], right[j]);
        for i in (0..P).filter(|i| *i != j) {
            let share = left[i][j];
            for k in 0..P {
                left[i][k] -= share * row[k];
                right[i][k] -= share * of[k];
            }
        }
    }
    Some(core::array::from_fn(|j| {
        core::array::from_fn(|k| if both(j, k) { right[j][k] / (scale[j] * scale[k]) } else { 0.0 })
    }))
}

/// What the trials' parts of the normal equations say of the parameters at the fit.
pub(crate) fn estimates<const P: usize>(
    problem: &Problem<P>,
    minimum: &Minimum<P>,
    blocks: &[Block<P>],
    level: f64,
) -> Result<[Estimate; P], IdentifyError> {
    let (parameters, at) = (problem.parameters, &minimum.parameters);
    let all = sum(blocks);
    let free = free(parameters, at, &all);
    let step = |drawn: &[&Block<P>]| stepped(parameters, at, &free, &sum(drawn.iter().copied()));
    let drawn: Vec<[f64; P]> =
        resample(blocks, blocks.len(), RESAMPLES, SEED, step).into_iter().flatten().collect();
    let inflation = inflation(&all, &free);
    let level = expanded_level(level, blocks.len())?;
    let mut found = core::array::from_fn(|j| Estimate {
        parameter: parameters[j],
        fitted: at[j],
        std_error: None,
        interval: None,
        inflation: inflation[j],
        profile: profile(problem, minimum, j),
        verdict: Verdict::OnBound,
    });
    for (j, estimate) in found.iter_mut().enumerate() {
        if free[j] {
            let values: Vec<f64> = drawn.iter().map(|p| p[j]).collect();
            estimate.std_error = sd(&values);
            estimate.interval = percentile_interval(&values, level)?;
        }
        estimate.verdict = verdict(estimate, all.curvature[j][j]);
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_over_free_parameters_undoes_the_matrix() {
        let matrix = [[4.0, 2.0, 9.0], [2.0, 9.0, 9.0], [9.0, 9.0, 0.0]];
        let found = inverse(&matrix, &[true, true, false]).unwrap();
        let expect = [[9.0 / 32.0, -2.0 / 32.0, 0.0], [-2.0 / 32.0, 4.0 / 32.0, 0.0], [0.0; 3]];
        for (found, expect) in found.iter().flatten().zip(expect.iter().flatten()) {
            assert!((found - expect).abs() < 1e-15, "{found} instead of {expect}");
        }
        assert_eq!(inverse(&[[1.0, 1.0], [1.0, 1.0]], &[true; 2]), None);
    }
}
