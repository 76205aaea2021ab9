//! Non-linear least squares with bounds, by a projected Levenberg–Marquardt method.
//!
//! Marquardt (1963), damping after Nielsen (1999, IMM-REP-1999-05), bounds by projection after
//! Kanzow, Yamashita & Fukushima (2004, J. Comput. Appl. Math. 172). The few parameters live in
//! fixed arrays and the Jacobian is never stored: one pass over the samples sums what a step needs,
//! in the samples' order.

use crate::dense::solve_symmetric;
use crate::error::NumericsError;

/// First damping, as a share of the diagonal of JᵀJ: nearly a Gauss–Newton step.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping shrinks to no less than a third of itself after one good step.
const SMALLEST_SHRINK: f64 = 1.0 / 3.0;
/// A step that promises less than this share of the sum of squares is not worth taking: the
/// rounding error of the sum itself.
const REDUCTION_TOLERANCE: f64 = 1e-14;
/// A step shorter than this share of every parameter is none.
const STEP_TOLERANCE: f64 = 1e-12;
/// More steps than a fit with a sensible start takes.
const MAX_ITERATIONS: usize = 200;

/// Where a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Minimum<const P: usize> {
    /// The parameters found, within their bounds.
    pub parameters: [f64; P],
    /// Sum of squared residuals there.
    pub rss: f64,
    /// Steps tried.
    pub iterations: usize,
    /// Whether a stopping rule was met, rather than the iterations used up.
    pub converged: bool,
}

/// Lower and upper bound of every parameter; infinities where there is none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds<const P: usize> {
    /// Smallest value allowed.
    pub lower: [f64; P],
    /// Largest value allowed.
    pub upper: [f64; P],
}

impl<const P: usize> Bounds<P> {
    /// No bounds.
    #[cfg(test)]
    pub(crate) const NONE: Self = Self { lower: [f64::NEG_INFINITY; P], upper: [f64::INFINITY; P] };

    fn project(&self, parameters: [f64; P]) -> [f64; P] {
        core::array::from_fn(|j| parameters[j].max(self.lower[j]).min(self.upper[j]))
    }
}

/// Σ r², Jᵀr and JᵀJ at one point.
struct Sums<const P: usize> {
    rss: f64,
    gradient: [f64; P],
    hessian: [[f64; P]; P],
}

/// Minimises Σᵢ rᵢ(θ)² over `samples` residuals from `start` within `bounds`.
///
/// `residual(i, θ)` gives rᵢ and its gradient ∂rᵢ/∂θ. A local minimum is found: the start decides
/// which one.
///
/// # Errors
/// [`NumericsError::BadStart`] if the sum of squares at `start` (moved into the bounds) is not
/// finite.
pub fn least_squares<const P: usize>(
    samples: usize,
    residual: impl Fn(usize, &[f64; P]) -> (f64, [f64; P]),
    start: [f64; P],
    bounds: &Bounds<P>,
) -> Result<Minimum<P>, NumericsError> {
    let mut parameters = bounds.project(start);
    let mut sums = sum_up(samples, &residual, &parameters);
    if !sums.rss.is_finite() {
        return Err(NumericsError::BadStart { value: sums.rss });
    }
    let mut damping = FIRST_DAMPING;
    let mut growth = 2.0;
    for iterations in 0..MAX_ITERATIONS {
        let trial = bounds.project(step(&parameters, &sums, damping, bounds));
        let promised = predicted_reduction(&parameters, &trial, &sums);
        let is_tiny = parameters
            .iter()
            .zip(&trial)
            .all(|(old, new)| (old - new).abs() <= STEP_TOLERANCE * old.abs());
        if promised <= REDUCTION_TOLERANCE * sums.rss || is_tiny {
            return Ok(Minimum { parameters, rss: sums.rss, iterations, converged: true });
        }
        let trial_sums = sum_up(samples, &residual, &trial);
        if trial_sums.rss < sums.rss {
            let gain = (sums.rss - trial_sums.rss) / promised;
            // Not `powi`, whose order of products, and so its last bit, is not specified.
            let x = 2.0 * gain - 1.0;
            damping *= (1.0 - x * x * x).max(SMALLEST_SHRINK);
            growth = 2.0;
            (parameters, sums) = (trial, trial_sums);
        } else {
            // Nielsen: each failure in a row raises the damping twice as much as the one before.
            damping *= growth;
            growth *= 2.0;
        }
    }
    Ok(Minimum { parameters, rss: sums.rss, iterations: MAX_ITERATIONS, converged: false })
}

fn sum_up<const P: usize>(
    samples: usize,
    residual: &impl Fn(usize, &[f64; P]) -> (f64, [f64; P]),
    parameters: &[f64; P],
) -> Sums<P> {
    let mut sums = Sums { rss: 0.0, gradient: [0.0; P], hessian: [[0.0; P]; P] };
    for i in 0..samples {
        let (r, slope) = residual(i, parameters);
        sums.rss += r * r;
        for j in 0..P {
            sums.gradient[j] += slope[j] * r;
            for k in 0..=j {
                sums.hessian[j][k] += slope[j] * slope[k];
            }
        }
    }
    for j in 0..P {
        for k in j + 1..P {
            sums.hessian[j][k] = sums.hessian[k][j];
        }
    }
    sums
}

/// θ + δ with (JᵀJ + μ diag JᵀJ) δ = −Jᵀr over the parameters that are free to move.
fn step<const P: usize>(
    parameters: &[f64; P],
    sums: &Sums<P>,
    damping: f64,
    bounds: &Bounds<P>,
) -> [f64; P] {
    let free: [bool; P] = core::array::from_fn(|j| {
        // A parameter on a bound is held while the cost falls only beyond it.
        let is_held = (parameters[j] <= bounds.lower[j] && sums.gradient[j] > 0.0)
            || (parameters[j] >= bounds.upper[j] && sums.gradient[j] < 0.0);
        sums.hessian[j][j] > 0.0 && !is_held
    });
    // One that is held has a row of the identity: the matrix stays regular, and its step is 0.
    let matrix: [[f64; P]; P] = core::array::from_fn(|j| {
        core::array::from_fn(|k| match (free[j] && free[k], j == k) {
            (true, true) => sums.hessian[j][j] * (1.0 + damping),
            (true, false) => sums.hessian[j][k],
            (false, same) => f64::from(u8::from(same)),
        })
    });
    let rhs: [f64; P] = core::array::from_fn(|j| if free[j] { -sums.gradient[j] } else { 0.0 });
    let delta = solve_symmetric(matrix, rhs, |_, _| false);
    core::array::from_fn(|j| parameters[j] + delta[j])
}

/// Fall of Σ r² that the linearised residuals promise: −2 δᵀJᵀr − δᵀJᵀJ δ.
fn predicted_reduction<const P: usize>(from: &[f64; P], to: &[f64; P], sums: &Sums<P>) -> f64 {
    let delta: [f64; P] = core::array::from_fn(|j| to[j] - from[j]);
    let terms = (0..P).map(|j| {
        let curvature: f64 = (0..P).map(|k| sums.hessian[j][k] * delta[k]).sum();
        -delta[j] * (2.0 * sums.gradient[j] + curvature)
    });
    terms.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_close<const P: usize>(found: &Minimum<P>, certified: [f64; P], rss: f64) {
        assert!(found.converged);
        for (b, b0) in found.parameters.iter().zip(certified) {
            assert!((b / b0 - 1.0).abs() < 1e-8, "{b} against {b0}");
        }
        assert!((found.rss / rss - 1.0).abs() < 1e-9, "{} against {rss}", found.rss);
    }

    const MISRA_Y: [f64; 14] = [
        10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47,
        81.78,
    ];
    const MISRA_X: [f64; 14] = [
        77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1,
        760.0,
    ];

    /// y = b₁ (1 − exp(−b₂ x)).
    fn misra(i: usize, b: &[f64; 2]) -> (f64, [f64; 2]) {
        let e = libm::exp(-b[1] * MISRA_X[i]);
        (b[0] * (1.0 - e) - MISRA_Y[i], [1.0 - e, b[0] * MISRA_X[i] * e])
    }

    /// NIST StRD, Misra1a: certified values, from the far start.
    #[test]
    fn misra1a_agrees_with_the_certified_values() {
        let found = least_squares(14, misra, [500.0, 1e-4], &Bounds::NONE).unwrap();
        check_close(&found, [2.3894212918E+02, 5.5015643181E-04], 1.2455138894E-01);
    }

    /// NIST StRD, DanWood: certified values of a power law.
    #[test]
    fn danwood_agrees_with_the_certified_values() {
        let y = [2.138, 3.421, 3.597, 4.340, 4.882, 5.660];
        let x = [1.309, 1.471, 1.490, 1.565, 1.611, 1.680];
        let power = |i: usize, b: &[f64; 2]| {
            let p = libm::pow(x[i], b[1]);
            (b[0] * p - y[i], [p, b[0] * p * libm::log(x[i])])
        };
        let found = least_squares(6, power, [1.0, 5.0], &Bounds::NONE).unwrap();
        check_close(&found, [7.6886226176E-01, 3.8604055871E+00], 4.3173084083E-03);
    }

    /// With b₂ held at its bound the problem is linear in b₁ and has a closed form.
    #[test]
    fn a_parameter_pushed_against_its_bound_stays_there_and_the_rest_is_optimal() {
        let bounds = Bounds { lower: [0.0, 6e-4], upper: [1e3, 1.0] };
        let found = least_squares(14, misra, [500.0, 1e-2], &bounds).unwrap();
        let shape = MISRA_X.map(|x| 1.0 - libm::exp(-6e-4 * x));
        let (sy, ss) =
            shape.iter().zip(MISRA_Y).fold((0.0, 0.0), |(a, b), (s, y)| (a + s * y, b + s * s));
        assert_eq!(found.parameters[1..], [6e-4]);
        assert!((found.parameters[0] / (sy / ss) - 1.0).abs() < 1e-8);
    }

    #[test]
    fn a_parameter_without_any_effect_stays_at_its_start() {
        let found = least_squares(
            3,
            |i, b: &[f64; 2]| (b[0] - i as f64, [1.0, 0.0]),
            [9.0, 4.0],
            &Bounds::NONE,
        )
        .unwrap();
        assert!((found.parameters[0] - 1.0).abs() < 1e-6);
        assert_eq!(found.parameters[1..], [4.0]);
    }

    #[test]
    fn a_start_without_a_finite_cost_is_an_error() {
        let found = least_squares(1, |_, b: &[f64; 1]| (1.0 / b[0], [1.0]), [0.0], &Bounds::NONE);
        assert_eq!(found, Err(NumericsError::BadStart { value: f64::INFINITY }));
    }
}
