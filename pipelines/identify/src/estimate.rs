//! How well each parameter is known.

use crate::IdentifyError;
use crate::fit::{Block, Problem, sum};
use crate::profile::{Curve, Point};
use crate::slopes::Parameter;
use crate::verdict::{Verdict, inflation, verdict};
use zwidth_numerics::nonlinear::Minimum;
use zwidth_stats::student_t::critical_value;

/// A fitted parameter; unit as the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value.
    pub fitted: f64,
    /// Standard error by leaving out each trial in turn; `None` where the trials do not determine the parameter, or not
    /// without one of them.
    pub std_error: Option<f64>,
    /// Effective degrees of freedom of the standard error; `None` likewise.
    pub df: Option<f64>,
    /// Where the profile stays within the level asked for; an end may be a bound. `None` likewise.
    pub interval: Option<(f64, f64)>,
    /// Variance inflation: by how much its variance is larger than if the other parameters were known, 1 at least;
    /// `None` for a parameter that the trials do not determine.
    pub inflation: Option<f64>,
    /// Its profile, by rising value; empty without standard error.
    pub profile: Vec<Point>,
    /// Whether the trials say what it is.
    pub verdict: Verdict,
}

/// A standard error below this share of the value is that of the arithmetic: there is no noise, and nothing to profile.
const NOISELESS: f64 = 1e-6;

/// How far an estimate scatters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    pub(crate) std_error: f64,
    pub(crate) df: f64,
}

/// The spread of free parameter `j`, from what its estimate becomes without each trial in turn: the trial-block
/// jackknife (Efron 1982; as the covariance CR3 of Bell & McCaffrey 2002, Surv. Methodol. 28:169), V = (G − 1)/G Σ_g (p_g − p̄)².
/// It holds whatever the errors within a trial are like. Its degrees of freedom are Satterthwaite's (1946),
/// (Σ_g h_g)² / Σ_g h_g² with the trials' shares h_g = (A⁻¹ A_g A⁻¹)_jj of the variance: few where few trials tell.
pub(crate) fn spread<const P: usize>(blocks: &[Block<P>], free: &[bool; P], j: usize) -> Option<Spread> {
    let all = sum(blocks);
    let inverse_all = inverse(&all.curvature, free)?;
    let without = |g: usize| {
        let others = sum(blocks.iter().enumerate().filter(|(i, _)| *i != g).map(|(_, block)| block));
        let inverse = inverse(&others.curvature, free)?;
        Some(-(0..P).map(|k| inverse[j][k] * others.gradient[k]).sum::<f64>())
    };
    let moved: Vec<f64> = (0..blocks.len()).map(without).collect::<Option<_>>()?;
    let n = moved.len() as f64;
    let mean = moved.iter().sum::<f64>() / n;
    let variance = (n - 1.0) / n * moved.iter().map(|m| (m - mean) * (m - mean)).sum::<f64>();
    let share = |block: &Block<P>| {
        let row = |k: usize| (0..P).map(|l| block.curvature[k][l] * inverse_all[l][j]).sum::<f64>();
        (0..P).map(|k| inverse_all[j][k] * row(k)).sum::<f64>()
    };
    let (total, squares) = blocks.iter().map(share).fold((0.0, 0.0), |(s, q), h| (s + h, q + h * h));
    Some(Spread { std_error: variance.sqrt(), df: total * total / squares })
        .filter(|s| s.std_error.is_finite() && s.df > 0.0)
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

/// What the trials' parts of the normal equations, and the fits with one parameter held, say of each parameter.
pub(crate) fn estimates<const P: usize>(
    problem: &Problem<P>,
    minimum: &Minimum<P>,
    blocks: &[Block<P>],
    level: f64,
) -> Result<Vec<Estimate>, IdentifyError> {
    let all = sum(blocks);
    let free = free(problem.parameters, &minimum.parameters, &all);
    let inflation = inflation(&all, &free);
    let one = |j: usize| {
        // one on its bound may leave it, to tell how far: the bracket that is left of its interval
        let mut free = free;
        free[j] = all.curvature[j][j] > 0.0;
        let spread = spread(blocks, &free, j).filter(|_| free[j]);
        let fitted = minimum.parameters[j];
        let noisy = spread.filter(|spread| spread.std_error > NOISELESS * fitted.abs());
        let curve = noisy.and_then(|spread| Curve::new(problem, minimum, &all, &free, (j, spread)));
        let critical = spread.map(|spread| critical_value(level, spread.df)).transpose()?;
        let interval = match (noisy, &curve) {
            (None, _) => spread.map(|_| (fitted, fitted)),
            (_, curve) => curve.as_ref().zip(critical).and_then(|(curve, t)| curve.interval(t)),
        };
        let mut estimate = Estimate {
            parameter: problem.parameters[j],
            fitted,
            std_error: spread.map(|s| s.std_error),
            df: spread.map(|s| s.df),
            interval,
            inflation: inflation[j],
            profile: curve.map(|curve| curve.points()).unwrap_or_default(),
            verdict: Verdict::OnBound,
        };
        estimate.verdict = verdict(&estimate, all.curvature[j][j]);
        Ok(estimate)
    };
    (0..P).map(one).collect()
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
