//! The minimum of a smooth function of a handful of parameters, by the BFGS quasi-Newton method
//! with analytic gradients.
//!
//! Nocedal & Wright (2006), *Numerical Optimization*, 2nd ed.: the update of the inverse Hessian is
//! their equation 6.17, its first scale 6.20. A step satisfies the weak Wolfe conditions, found by
//! doubling and bisection (Lewis & Overton 2013, Math. Program. 141:135). Where rounding makes the
//! function flat, its slope decides instead (the approximate Wolfe condition of Hager & Zhang 2005,
//! SIAM J. Optim. 16:170), so a minimum is found to nearly all digits, not only to half of them.

use crate::dense::dot;
use crate::error::NumericsError;

/// Share of the first slope's promise that a step has to keep (Armijo).
const KEPT_PROMISE: f64 = 1e-4;
/// Share of the first slope that may be left after a step (curvature).
const SLOPE_LEFT: f64 = 0.9;
/// Rise of the function, as a share of its size, that rounding may have caused (Hager & Zhang take
/// 1e-6): below it the slope decides.
const ROUNDING: f64 = 1e-10;
/// Points tried along one line: more than doubling or halving needs to cross all magnitudes met.
const MAX_TRIALS: usize = 80;
/// More steps than a handful of parameters with a sensible start take.
const MAX_ITERATIONS: usize = 500;
/// Length of the first step, before anything is known of the curvature.
const FIRST_STEP: f64 = 1.0;

/// Why a minimisation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// No component of the gradient exceeds what was asked.
    Flat,
    /// No step lowers the function: its rounding errors are reached, or it is not smooth.
    Stuck,
    /// The iterations were used up.
    Exhausted,
}

/// Where a minimisation ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The lowest point found.
    pub point: Vec<f64>,
    /// The function there.
    pub value: f64,
    /// Its gradient there: how far from flat the point is.
    pub gradient: Vec<f64>,
    /// Steps taken.
    pub iterations: usize,
    /// Why it ended.
    pub ended: Ended,
}

impl Minimum {
    /// Largest component of the gradient that is left, without its sign; 0 without parameters.
    pub fn slope(&self) -> f64 {
        largest(&self.gradient)
    }
}

/// A point, the function and its gradient there.
#[derive(Clone)]
struct Place {
    point: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

/// Minimises `function`, which gives its value and its gradient, from `start` until no component of
/// the gradient exceeds `slope`.
///
/// A local minimum is found: the start decides which. A point where the value or a component of the
/// gradient is not finite counts as infinitely high, so a function may forbid a region by NaN.
///
/// # Errors
/// [`NumericsError::BadStart`] if `function` is not finite at `start`.
pub fn minimise(
    mut function: impl FnMut(&[f64]) -> (f64, Vec<f64>),
    start: &[f64],
    slope: f64,
) -> Result<Minimum, NumericsError> {
    let mut here = evaluate(&mut function, start.to_vec());
    if !is_finite(&here) {
        return Err(NumericsError::BadStart { value: here.value });
    }
    let mut inverse_hessian = None;
    let mut iterations = 0;
    let ended = loop {
        if largest(&here.gradient) <= slope {
            break Ended::Flat;
        }
        if iterations == MAX_ITERATIONS {
            break Ended::Exhausted;
        }
        let direction = downhill(inverse_hessian.as_deref(), &here.gradient);
        match step(&mut function, &here, &direction) {
            Some(next) => {
                inverse_hessian = update(inverse_hessian, &here, &next);
                here = next;
                iterations += 1;
            }
            // The collected curvature may be wrong: start once more from the steepest descent.
            None if inverse_hessian.is_some() => inverse_hessian = None,
            None => break Ended::Stuck,
        }
    };
    let Place { point, value, gradient } = here;
    Ok(Minimum { point, value, gradient, iterations, ended })
}

fn evaluate(function: &mut impl FnMut(&[f64]) -> (f64, Vec<f64>), point: Vec<f64>) -> Place {
    let (value, gradient) = function(&point);
    Place { point, value, gradient }
}

/// −H⁻¹ g; without knowledge of H the steepest descent, of a length that is safe.
fn downhill(inverse_hessian: Option<&[Vec<f64>]>, gradient: &[f64]) -> Vec<f64> {
    match inverse_hessian {
        Some(rows) => rows.iter().map(|row| -dot(row, gradient)).collect(),
        None => {
            let length = dot(gradient, gradient).sqrt();
            gradient.iter().map(|g| -g * (FIRST_STEP / length).min(1.0)).collect()
        }
    }
}

/// A place along `direction` that satisfies the Wolfe conditions; `None` if there is none to
/// rounding.
fn step(
    function: &mut impl FnMut(&[f64]) -> (f64, Vec<f64>),
    here: &Place,
    direction: &[f64],
) -> Option<Place> {
    let slope = dot(direction, &here.gradient);
    if slope.is_nan() || slope >= 0.0 {
        return None;
    }
    let mut low = 0.0;
    let mut high = f64::INFINITY;
    let mut length = 1.0;
    for _ in 0..MAX_TRIALS {
        let point: Vec<f64> =
            here.point.iter().zip(direction).map(|(x, d)| x + length * d).collect();
        if point == here.point {
            // The step is below the spacing of the numbers.
            return None;
        }
        let trial = evaluate(function, point);
        let trial_slope = dot(direction, &trial.gradient);
        let promise = here.value + KEPT_PROMISE * length * slope;
        // Where the function is flat to rounding its values cannot show a fall, but its slope can.
        let level = trial.value <= here.value + ROUNDING * here.value.abs()
            && trial_slope <= (2.0 * KEPT_PROMISE - 1.0) * slope;
        if !is_finite(&trial) || (trial.value > promise && !level) {
            high = length;
        } else if trial_slope < SLOPE_LEFT * slope {
            low = length;
        } else {
            return Some(trial);
        }
        length = if high.is_finite() { low + (high - low) / 2.0 } else { 2.0 * length };
    }
    None
}

/// H⁻¹ ← (I − ρ s yᵀ) H⁻¹ (I − ρ y sᵀ) + ρ s sᵀ, with s the step, y the change of the gradient
/// and ρ = 1 / yᵀs.
fn update(
    inverse_hessian: Option<Vec<Vec<f64>>>,
    here: &Place,
    next: &Place,
) -> Option<Vec<Vec<f64>>> {
    let s: Vec<f64> = next.point.iter().zip(&here.point).map(|(a, b)| a - b).collect();
    let y: Vec<f64> = next.gradient.iter().zip(&here.gradient).map(|(a, b)| a - b).collect();
    let curvature = dot(&s, &y);
    if curvature <= 0.0 {
        return inverse_hessian; // only rounding makes it so: the line search asks for more
    }
    let mut h = inverse_hessian.unwrap_or_else(|| {
        let scale = curvature / dot(&y, &y);
        let size = 0..s.len();
        let rows =
            size.clone().map(|j| size.clone().map(|k| if j == k { scale } else { 0.0 }).collect());
        rows.collect()
    });
    let hy: Vec<f64> = h.iter().map(|row| dot(row, &y)).collect();
    let along = (1.0 + dot(&y, &hy) / curvature) / curvature;
    for (j, row) in h.iter_mut().enumerate() {
        for (k, entry) in row.iter_mut().enumerate() {
            *entry += along * s[j] * s[k] - (hy[j] * s[k] + s[j] * hy[k]) / curvature;
        }
    }
    Some(h)
}

fn is_finite(place: &Place) -> bool {
    place.value.is_finite() && place.gradient.iter().all(|g| g.is_finite())
}

fn largest(gradient: &[f64]) -> f64 {
    gradient.iter().fold(0.0, |most, g| g.abs().max(most))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(found: &Minimum, point: &[f64], tolerance: f64) {
        assert_eq!(found.ended, Ended::Flat, "{found:?}");
        for (x, x0) in found.point.iter().zip(point) {
            assert!((x - x0).abs() <= tolerance, "{found:?} against {point:?}");
        }
    }

    /// (1 − x)² + 100 (y − x²)² is lowest at (1, 1).
    #[test]
    fn rosenbrocks_valley_is_followed_to_its_end() {
        let valley = |p: &[f64]| {
            let (x, y) = (p[0], p[1]);
            let (a, b) = (1.0 - x, y - x * x);
            (a * a + 100.0 * b * b, vec![-2.0 * a - 400.0 * x * b, 200.0 * b])
        };
        for start in [[-1.2, 1.0], [5.0, -7.0], [0.0, 100.0]] {
            let found = minimise(valley, &start, 1e-10).unwrap();
            check(&found, &[1.0, 1.0], 1e-10);
            assert!(found.iterations < 100 && found.slope() <= 1e-10);
        }
    }

    /// ½ xᵀ A x − bᵀ x with A of condition 10⁶ is lowest at A⁻¹ b.
    #[test]
    fn a_long_ellipse_of_six_parameters_is_solved() {
        let scale: Vec<f64> = (0..6).map(|j| libm::pow(10.0, f64::from(j))).collect();
        let bowl = |p: &[f64]| {
            let gradient: Vec<f64> = p.iter().zip(&scale).map(|(x, a)| a * x - 1.0).collect();
            let value = p.iter().zip(&scale).map(|(x, a)| a * x * x / 2.0 - x).sum();
            (value, gradient)
        };
        let lowest: Vec<f64> = scale.iter().map(|a| 1.0 / a).collect();
        check(&minimise(bowl, &[1.0; 6], 1e-9).unwrap(), &lowest, 1e-8);
    }

    /// −log of a normal likelihood in (μ, ln σ): mean and root of the mean square. The large
    /// constant hides the last digits of the value, not those of the slope.
    #[test]
    fn a_minimum_is_found_beyond_half_the_digits_of_the_function() {
        let (mean, variance, n) = (3.0, 4.0, 50.0);
        let deviance = |p: &[f64]| {
            let w = libm::exp(-2.0 * p[1]);
            let square = variance + (p[0] - mean) * (p[0] - mean);
            let value = 1e4 + n * p[1] + n * w * square / 2.0;
            (value, vec![n * w * (p[0] - mean), n - n * w * square])
        };
        let found = minimise(deviance, &[0.0, 0.0], 1e-9).unwrap();
        check(&found, &[mean, libm::log(2.0)], 1e-10);
    }

    /// x − ln x is lowest at 1, and does not exist where x ≤ 0.
    #[test]
    fn a_forbidden_region_is_left_out() {
        let found =
            minimise(|p| (p[0] - libm::log(p[0]), vec![1.0 - 1.0 / p[0]]), &[30.0], 1e-12).unwrap();
        check(&found, &[1.0], 1e-11);
        let refused = minimise(|p| (libm::log(p[0]), vec![1.0 / p[0]]), &[-1.0], 1e-9);
        assert!(matches!(refused, Err(NumericsError::BadStart { .. })));
    }

    #[test]
    fn a_function_without_end_is_said_to_have_none() {
        let found = minimise(|p| (p[0], vec![1.0]), &[0.0], 1e-9).unwrap();
        assert!(found.ended != Ended::Flat && found.slope() > 0.5);
        let kink = minimise(|p| (p[0].abs(), vec![p[0].signum()]), &[1.0], 1e-9).unwrap();
        assert_ne!(kink.ended, Ended::Flat);
        assert!(kink.value < 1e-6);
    }

    #[test]
    fn no_parameters_leave_nothing_to_search() {
        let found = minimise(|_| (7.0, Vec::new()), &[], 0.0).unwrap();
        assert_eq!((found.value, found.iterations, found.ended), (7.0, 0, Ended::Flat));
    }
}
