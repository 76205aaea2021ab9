//! A line between a free break and a free plateau: a dead zone, and an actuator that saturates.

use super::hinge::{self, Fit, Scale};
use crate::shape::{Point, Points, Quantity, Shape};
use zwidth_numerics::nonlinear::{Bounds, least_squares};
use zwidth_results::CurveSymbol;

/// Places at which the search for the plateau begins, evenly over the commands.
const COARSE: usize = 24;
/// The plateau is found when it is enclosed this closely, as a share of the commands' span.
const ENCLOSED: f64 = 1e-9;
/// 1/φ: each step of the golden section keeps this share of the bracket.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// y = a for x ≤ x0, y = a + b (x − x0) up to x1, y = a + b (x1 − x0) from there on.
#[derive(Debug, Clone, Copy)]
pub struct Saturation;

impl Shape for Saturation {
    fn formula(&self) -> &'static str {
        "y = a + b (min(max(x, x0), x1) - x0)"
    }

    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)] {
        &[
            (CurveSymbol::A, Quantity::Response),
            (CurveSymbol::B, Quantity::Slope),
            (CurveSymbol::X0, Quantity::Break),
            (CurveSymbol::X1, Quantity::Plateau),
        ]
    }

    /// For a fixed plateau x1 the curve is a hinge in min(x, x1), whose best break is known in
    /// closed form; what is left is a search along x1: the best of a coarse grid, then a golden
    /// section. Between break and plateau lie two commands at least. From `near` it is a few
    /// steps of Levenberg–Marquardt instead.
    fn fit(&self, points: &Points, near: Option<&[f64]>) -> Option<Vec<f64>> {
        let (lowest, _) = points.break_range()?;
        let n = points.levels.len();
        let levels = points.levels;
        if n < 4 || !points.can_determine(self.complexity()) {
            return None;
        }
        let first = levels[2];
        let last = levels[n - 1];
        if let Some(&[a, b, x0, x1]) = near {
            let bounds = Bounds {
                lower: [f64::NEG_INFINITY, f64::NEG_INFINITY, lowest, first],
                upper: [f64::INFINITY, f64::INFINITY, levels[n - 3], last],
            };

            let fit = least_squares(
                points.at.len(),
                |i, theta| residual(&points.at[i], theta),
                [a, b, x0, x1],
                &bounds,
            )
            .ok()?;
            return fit.converged.then(|| fit.parameters.to_vec());
        }
        let scale = Scale::of(points);
        let rss = |x1: f64| hinge_below(points, &scale, x1).map_or(f64::INFINITY, |fit| fit.rss);
        let step = (last - first) / COARSE as f64;
        let middle = lowest_of((1..=COARSE).map(|i| first + step * i as f64), rss)?;
        let left = (middle - step).max(first);
        let right = (middle + step).min(last);
        let x1 = golden_section(rss, left, right, ENCLOSED * scale.span);
        let best = hinge_below(points, &scale, x1)?;
        Some(vec![
            scale.response(best.a),
            best.b / scale.span,
            scale.command(best.x0).max(lowest),
            x1,
        ])
    }

    fn predict(&self, parameters: &[f64], command: f64) -> f64 {
        let &[a, b, x0, x1] = parameters else { return f64::NAN };
        a + b * (command.max(x0).min(x1) - x0).max(0.0)
    }
}

/// √w (a + b (clamp(x) − x0) − y) and its gradient by (a, b, x0, x1).
fn residual(p: &Point, &[a, b, x0, x1]: &[f64; 4]) -> (f64, [f64; 4]) {
    let root_w = p.weight.sqrt();
    let rise = (p.command.min(x1) - x0).max(0.0);
    let slope = root_w * if rise > 0.0 { b } else { 0.0 };
    let end = if p.command > x1 { slope } else { 0.0 };
    (root_w * (a + b * rise - p.response), [root_w, root_w * rise, -slope, end])
}

/// The best hinge in min(x, `plateau`).
fn hinge_below(points: &Points, scale: &Scale, plateau: f64) -> Option<Fit> {
    let at: Vec<Point> =
        points.at.iter().map(|p| Point { command: p.command.min(plateau), ..*p }).collect();
    let below = points.levels.partition_point(|&level| level < plateau);
    hinge::best(&at, scale, points.levels[below.checked_sub(2)?])
}

/// The value with the smallest `cost`, the first of equals.
fn lowest_of(values: impl Iterator<Item = f64>, cost: impl Fn(f64) -> f64) -> Option<f64> {
    values.map(|x| (cost(x), x)).min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, x)| x)
}

/// A minimum of `cost` between `left` and `right`, the ends included (Kiefer 1953, Proc. Amer.
/// Math. Soc. 4:502).
fn golden_section(cost: impl Fn(f64) -> f64, left: f64, right: f64, width: f64) -> f64 {
    let mut low = left;
    let mut high = right;
    let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let mut costs = inner.map(&cost);
    while high - low > width {
        if costs[0] <= costs[1] {
            high = inner[1];
            inner = [high - GOLDEN * (high - low), inner[0]];
            costs = [cost(inner[0]), costs[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + GOLDEN * (high - low)];
            costs = [costs[1], cost(inner[1])];
        }
    }
    // The ends too, which the section approaches but never reaches.
    lowest_of([right, left, 0.5 * (low + high)].into_iter(), cost).unwrap_or(right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::check;

    #[test]
    fn break_and_plateau_are_recovered() {
        for (x0, x1) in [(1.0, 8.5), (3.517, 6.221), (0.0, 4.01)] {
            check::recovers(&Saturation, &[0.3, 1.7, x0, x1]);
            check::recovers(&Saturation, &[-40.0, -0.2, x0, x1]);
        }
    }

    #[test]
    fn a_line_breaks_at_its_first_command_and_saturates_at_its_last() {
        let x = check::ramp();
        let y: Vec<f64> = x.iter().map(|x| 2.0 + 0.5 * x).collect();
        let found = check::fit(&Saturation, &x, &y).unwrap();
        assert_eq!(found[2..], [0.0, 10.0]);
    }

    /// A start ten times farther off than resamples are.
    #[test]
    fn a_search_from_near_by_ends_where_the_search_from_nowhere_does() {
        let x = check::ramp();
        for seed in 1..20 {
            let y: Vec<f64> = (0..x.len())
                .map(|i| {
                    Saturation.predict(&[0.3, 1.7, 2.0, 7.5], x[i])
                        + f64::from(i as u32 * 7 * seed % 13) / 8.0
                })
                .collect();
            let rss = |p: &[f64]| check::rss(&Saturation, p, &x, &y);
            let best = rss(&check::fit(&Saturation, &x, &y).unwrap());
            let near =
                rss(&check::fit_near(&Saturation, &x, &y, Some(&[0.5, 1.5, 2.4, 7.0])).unwrap());
            assert!(near < best * (1.0 + 1e-3), "{near} {best}");
        }
    }

    /// Compared with every pair of a grid, each with its own regression.
    #[test]
    fn no_other_break_and_plateau_fit_a_scattered_curve_better() {
        let x = check::ramp();
        let scatter = |i: usize| f64::from(i as u32 * 7 % 13) / 8.0;
        let y: Vec<f64> = x
            .iter()
            .enumerate()
            .map(|(i, x)| 5.0 / (1.0 + libm::exp(5.0 - x)) + scatter(i))
            .collect();
        let found = check::rss(&Saturation, &check::fit(&Saturation, &x, &y).unwrap(), &x, &y);
        for (i, j) in (0..90).flat_map(|i| (i + 6..100).map(move |j| (i, j))) {
            let (x0, x1) = (f64::from(i) * 0.1, f64::from(j) * 0.1);
            let points = x.iter().zip(&y).map(|(x, y)| (x.clamp(x0, x1) - x0, *y, 1.0));
            let (a, b) = crate::shape::weighted_line(points).unwrap();
            let other = check::rss(&Saturation, &[a, b, x0, x1], &x, &y);
            assert!(found <= other * (1.0 + 1e-9), "{x0} … {x1} is better");
        }
    }
}
