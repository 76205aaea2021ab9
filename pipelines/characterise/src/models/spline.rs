//! A smooth curve that only rises (or only falls), for laws that no other candidate describes.

use super::nonnegative::nonnegative;
use crate::shape::{Point, Points, Quantity, Shape};
use zwidth_results::CurveSymbol;

/// Knots: six equal pieces follow a dead zone, a bend and a plateau in one curve, and need no
/// choice of knots.
const KNOTS: usize = 7;

/// A monotone quadratic spline (the I-splines of Ramsay 1988, Statist. Sci. 3:425, of order 2): the
/// slope is s0 … s6 at seven knots spaced evenly from x0 to x1, the lowest and the highest command,
/// straight between them and constant beyond; y = a at x0. No slope has another sign than the rest.
#[derive(Debug, Clone, Copy)]
pub struct Spline;

impl Shape for Spline {
    fn formula(&self) -> &'static str {
        "y = a + integral of s from x0 to x"
    }

    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)] {
        &[
            (CurveSymbol::A, Quantity::Response),
            (CurveSymbol::X0, Quantity::Knot),
            (CurveSymbol::X1, Quantity::Knot),
            (CurveSymbol::S0, Quantity::Slope),
            (CurveSymbol::S1, Quantity::Slope),
            (CurveSymbol::S2, Quantity::Slope),
            (CurveSymbol::S3, Quantity::Slope),
            (CurveSymbol::S4, Quantity::Slope),
            (CurveSymbol::S5, Quantity::Slope),
            (CurveSymbol::S6, Quantity::Slope),
        ]
    }

    /// Least squares with slopes ≥ 0, once for the curve and once for its mirror image; the better
    /// one is taken.
    fn fit(&self, points: &Points, _near: Option<&[f64]>) -> Option<Vec<f64>> {
        let low = *points.levels.first()?;
        let high = *points.levels.last()?;
        if !points.can_determine(self.complexity()) {
            return None;
        }
        let sums = Sums::of(points.at, low, high);
        // Slopes of one sign: negative ones are those of the mirror image.
        let rising = nonnegative(&sums.gram, &sums.moment);
        let falling = nonnegative(&sums.gram, &sums.moment.map(|m| -m)).map(|s| -s);
        let slopes =
            if sums.explains(&rising) >= sums.explains(&falling) { rising } else { falling };
        let offset: f64 = slopes.iter().zip(&sums.mean_column).map(|(s, c)| s * c).sum();
        Some([sums.mean_response - offset, low, high].into_iter().chain(slopes).collect())
    }

    fn is_law(&self) -> bool {
        false
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        let a = parameters[0];
        let low = parameters[1];
        let high = parameters[2];
        let columns = columns(command, low, high);
        a + columns.iter().zip(&parameters[3..]).map(|(c, s)| c * s).sum::<f64>()
    }
}

/// The rise from `low` to `x` for a slope of 1 at each knot alone: the integral of its hat
/// function.
fn columns(x: f64, low: f64, high: f64) -> [f64; KNOTS] {
    let width = (high - low) / (KNOTS - 1) as f64;
    let u = (x - low) / width;
    core::array::from_fn(|j| width * (hat_integral(u - j as f64, j) - hat_integral(-(j as f64), j)))
}

/// ∫ of knot `j`'s hat from the middle knot's place to `v`, in knot widths; beyond the first and
/// last knot the hat stays 1.
fn hat_integral(v: f64, j: usize) -> f64 {
    let inner = v.clamp(-1.0, 1.0);
    let integral = inner - 0.5 * inner * inner.abs();
    match j {
        0 if v < 0.0 => v,
        last if last == KNOTS - 1 && v > 0.0 => v,
        _ => integral,
    }
}

/// Weighted sums of squares and products about the means.
struct Sums {
    gram: [[f64; KNOTS]; KNOTS],
    moment: [f64; KNOTS],
    mean_column: [f64; KNOTS],
    mean_response: f64,
}

impl Sums {
    fn of(at: &[Point], low: f64, high: f64) -> Self {
        let rows: Vec<[f64; KNOTS]> = at.iter().map(|p| columns(p.command, low, high)).collect();
        let weight: f64 = at.iter().map(|p| p.weight).sum();
        let mean_response = at.iter().map(|p| p.weight * p.response).sum::<f64>() / weight;
        let mean_column: [f64; KNOTS] = core::array::from_fn(|j| {
            at.iter().zip(&rows).map(|(p, row)| p.weight * row[j]).sum::<f64>() / weight
        });
        let mut sums =
            Self { gram: [[0.0; KNOTS]; KNOTS], moment: [0.0; KNOTS], mean_column, mean_response };
        for (p, row) in at.iter().zip(&rows) {
            let d: [f64; KNOTS] = core::array::from_fn(|j| row[j] - mean_column[j]);
            for j in 0..KNOTS {
                let weighted = p.weight * d[j];
                sums.moment[j] += weighted * (p.response - mean_response);
                (0..KNOTS).for_each(|k| sums.gram[j][k] += weighted * d[k]);
            }
        }
        sums
    }

    /// By how much these slopes lessen the sum of squares.
    fn explains(&self, slopes: &[f64; KNOTS]) -> f64 {
        let pulled: f64 = slopes.iter().zip(&self.moment).map(|(s, m)| s * m).sum();
        let rows = slopes.iter().zip(&self.gram);
        let bent = rows.map(|(s, row)| s * row.iter().zip(slopes).map(|(g, s)| g * s).sum::<f64>());
        2.0 * pulled - bent.sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::check;

    #[test]
    fn a_rising_and_a_falling_spline_are_recovered() {
        let slopes = [0.0, 0.2, 1.5, 0.7, 0.7, 0.1, 0.0];
        let truth = |a: f64, sign: f64| -> Vec<f64> {
            [a, 0.0, 10.0].into_iter().chain(slopes.map(|s| sign * s)).collect()
        };
        let command = check::ramp();
        for truth in [truth(0.4, 1.0), truth(-7.0, -1.0)] {
            let response: Vec<f64> = command.iter().map(|&x| Spline.predict(&truth, x)).collect();
            let found = check::fit(&Spline, &command, &response).unwrap();
            for (found, truth) in found.iter().zip(&truth) {
                assert!((found - truth).abs() < 1e-9, "{found} for {truth}");
            }
        }
    }

    /// Its derivative is straight between the knots' slopes, and the last slope goes on beyond.
    #[test]
    fn the_slope_is_that_of_the_knots() {
        let p = [1.0, 2.0, 14.0, 0.5, 1.5, 0.0, 3.0, 1.0, 2.0, 4.0];
        assert!((Spline.predict(&p, 2.0) - 1.0).abs() < 1e-14);
        for (x, slope) in
            [(2.0, 0.5), (3.0, 1.0), (4.0, 1.5), (7.5, 2.25), (14.0, 4.0), (15.0, 4.0), (1.0, 0.5)]
        {
            let h = 1e-6;
            let found = (Spline.predict(&p, x + h) - Spline.predict(&p, x - h)) / (2.0 * h);
            assert!((found - slope).abs() < 1e-5, "{found} at {x}");
        }
    }

    #[test]
    fn a_curve_that_wiggles_is_followed_without_a_fall() {
        let x = check::ramp();
        let y: Vec<f64> = x.iter().map(|x| x + 2.0 * libm::sin(2.0 * x)).collect();
        let found = check::fit(&Spline, &x, &y).unwrap();
        let curve: Vec<f64> = x.iter().map(|x| Spline.predict(&found, *x)).collect();
        assert!(curve.windows(2).all(|w| w[1] >= w[0] - 1e-12));
    }
}
