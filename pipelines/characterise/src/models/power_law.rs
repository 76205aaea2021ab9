//! A power law above a free break, constant below it: a magnetic-particle brake.

use crate::shape::{Points, Quantity, Shape, weighted_line};
use zwidth_numerics::nonlinear::{Bounds, least_squares};
use zwidth_results::CurveSymbol;

/// Smallest exponent tried: below it the curve is a step at the break.
const MIN_EXPONENT: f64 = 0.2;
/// Largest exponent tried: above it only the last commands show anything.
const MAX_EXPONENT: f64 = 8.0;
/// Exponents at which the search starts.
const START_EXPONENTS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 3.0, 5.0];
/// Breaks at which the search starts, evenly spread from the lowest to the highest.
const START_BREAKS: usize = 8;
/// The search for a start looks at no more points than about this.
const START_POINTS: usize = 64;

/// y = a for x ≤ x0, y = a + b (x − x0)^p above, 0.2 ≤ p ≤ 8.
#[derive(Debug, Clone, Copy)]
pub struct PowerLaw;

impl Shape for PowerLaw {
    fn formula(&self) -> &'static str {
        "y = a + b max(x - x0, 0)^p"
    }

    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)] {
        &[
            (CurveSymbol::A, Quantity::Response),
            (CurveSymbol::B, Quantity::Gain),
            (CurveSymbol::X0, Quantity::Break),
            (CurveSymbol::P, Quantity::Exponent),
        ]
    }

    /// Levenberg–Marquardt from `near`, else from the best point of a coarse grid over break and
    /// exponent (a and b are linear there), with the break within the data and commands scaled
    /// to 0 … 1.
    fn fit(&self, points: &Points, near: Option<&[f64]>) -> Option<Vec<f64>> {
        let (lowest, highest) = points.break_range()?;
        if !points.can_determine(self.complexity()) {
            return None;
        }
        let span = points.levels[points.levels.len() - 1] - lowest;
        let scaled: Vec<Scaled> = points
            .at
            .iter()
            .map(|p| ((p.command - lowest) / span, p.response, p.weight.sqrt()))
            .collect();
        let last_break = (highest - lowest) / span;
        let bounds = Bounds {
            lower: [f64::NEG_INFINITY, f64::NEG_INFINITY, 0.0, MIN_EXPONENT],
            upper: [f64::INFINITY, f64::INFINITY, last_break, MAX_EXPONENT],
        };
        let start = match near {
            Some(&[a, b, x0, p]) => [a, b * libm::pow(span, p), (x0 - lowest) / span, p],
            _ => best_start(&scaled, last_break)?,
        };
        let fit =
            least_squares(scaled.len(), |i, theta| residual(scaled[i], theta), start, &bounds)
                .ok()?;
        let [a, b, x0, p] = fit.parameters;
        fit.converged.then(|| vec![a, b / libm::pow(span, p), lowest + span * x0, p])
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        let above = command - parameters[2];
        if above <= 0.0 {
            parameters[0]
        } else {
            parameters[0] + parameters[1] * libm::pow(above, parameters[3])
        }
    }
}

/// Scaled command, response, square root of the weight.
type Scaled = (f64, f64, f64);

/// √w (a + b u^p − y) and its gradient by (a, b, x0, p), u = x − x0.
fn residual((x, y, root_w): Scaled, &[a, b, x0, p]: &[f64; 4]) -> (f64, [f64; 4]) {
    let u = x - x0;
    if u <= 0.0 {
        return (root_w * (a - y), [root_w, 0.0, 0.0, 0.0]);
    }
    let ln_u = libm::log(u);
    let power = libm::exp(p * ln_u);
    let slope = b * power;
    (
        root_w * (a + slope - y),
        [root_w, root_w * power, -root_w * p * slope / u, root_w * slope * ln_u],
    )
}

/// The point (a, b, x0, p) of the coarse grid with the smallest sum of squares on a regular choice
/// of the points.
fn best_start(points: &[Scaled], last_break: f64) -> Option<[f64; 4]> {
    let every = points.len().div_ceil(START_POINTS);
    let few: Vec<Scaled> = points.iter().copied().step_by(every).collect();
    let mut best: Option<(f64, [f64; 4])> = None;
    for step in 0..START_BREAKS {
        let x0 = last_break * step as f64 / START_BREAKS as f64;
        for p in START_EXPONENTS {
            let powers: Vec<Scaled> = few
                .iter()
                .map(|&(x, y, root_w)| {
                    let power = if x > x0 { libm::pow(x - x0, p) } else { 0.0 };
                    (power, y, root_w * root_w)
                })
                .collect();
            // With break and exponent fixed, the curve is a line in the power.
            let Some((a, b)) = weighted_line(powers.iter().copied()) else { continue };
            let squares = powers.iter().map(|(u, y, w)| w * (a + b * u - y) * (a + b * u - y));
            let rss: f64 = squares.sum();
            if best.is_none_or(|(smallest, _)| rss < smallest) {
                best = Some((rss, [a, b, x0, p]));
            }
        }
    }
    best.map(|(_, start)| start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::check;

    #[test]
    fn a_power_law_is_recovered() {
        for break_at in [0.4, 3.517, 7.0] {
            for exponent in [1.3, 1.7, 3.0] {
                check::recovers(&PowerLaw, &[0.08, 0.9, break_at, exponent]);
                check::recovers(&PowerLaw, &[-5.0, -0.2, break_at, exponent]);
            }
        }
    }

    #[test]
    fn the_gradient_is_that_of_a_finite_difference() {
        let (sample, theta, h) = ((0.7, 2.0, 1.5), [0.3, 1.2, 0.25, 1.7], 1e-6);
        let (_, gradient) = residual(sample, &theta);
        for (j, slope) in gradient.iter().enumerate() {
            let (mut up, mut down) = (theta, theta);
            (up[j], down[j]) = (up[j] + h, down[j] - h);
            let difference = (residual(sample, &up).0 - residual(sample, &down).0) / (2.0 * h);
            assert!((difference - slope).abs() < 1e-8, "parameter {j}");
        }
    }

    #[test]
    fn a_parabola_from_the_first_command_puts_the_break_at_the_edge() {
        let x = check::ramp();
        let y: Vec<f64> = x.iter().map(|x| (x + 3.0) * (x + 3.0)).collect();
        let found = check::fit(&PowerLaw, &x, &y).unwrap();
        assert_eq!(found[2..3], [0.0]);
    }

    #[test]
    fn a_constant_response_gives_finite_parameters() {
        let x = check::ramp();
        let found = check::fit(&PowerLaw, &x, &vec![4.0; x.len()]).unwrap();
        assert!(found.iter().all(|p| p.is_finite()));
        assert!((PowerLaw.predict(&found, 5.0) - 4.0).abs() < 1e-9);
    }
}
