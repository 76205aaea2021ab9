//! The profile of a parameter: how the error changes if the parameter is held at another value and
//! the others are fitted again.

use crate::Parameter;
use crate::estimate::{Spread, inverse};
use crate::fit::{Block, Problem};
use zwidth_numerics::nonlinear::Minimum;
use zwidth_results::PlantProfile;

/// The curve is drawn to `REACH` standard errors to either side, `STEPS` points per standard error.
const REACH: i32 = 3;
const STEPS: i32 = 2;
/// Where the curve meets a level is found to this share of the level.
const TOLERANCE: f64 = 1e-4;
/// More secants than it takes: the curve's root is nearly a straight line, or bends one way.
const MAX_SECANTS: usize = 20;

/// A refit is done when what a step still promises is below this share of the growth of Σ r², or of
/// Σ r² itself.
const CLOSE: f64 = 1e-6;
const ROUNDING: f64 = 1e-14;
/// More such steps than it takes near the fit.
const MAX_STEPS: usize = 10;

/// The profile of one parameter around a minimum.
///
/// Errors within a trial are alike, so the growth of Σ r² is not a likelihood ratio as it stands;
/// scaled by (A⁻¹)_jj / V, where V is the parameter's variance whatever the errors are, it is one
/// to first order (Rotnitzky & Jewell 1990, Biometrika 77:485): in a linear model ((value −
/// fit)/std_error)².
pub(crate) struct Curve<'p, 'd, const P: usize> {
    problem: &'p Problem<'d, P>,
    minimum: &'p Minimum<P>,
    j: usize,
    std_error: f64,
    /// Slopes at the minimum, and the inverse of JᵀJ over the other parameters.
    slopes: &'p [Vec<[f64; P]>],
    others: [[f64; P]; P],
    /// (A⁻¹)_jj / V.
    scale: f64,
    /// By how much the others move when this one moves by 1, to first order.
    along: [f64; P],
}

impl<'p, 'd, const P: usize> Curve<'p, 'd, P> {
    /// `None` where the parameter is not determined, or without any error at all.
    pub(crate) fn new(
        problem: &'p Problem<'d, P>,
        minimum: &'p Minimum<P>,
        all: &Block<P>,
        slopes: &'p [Vec<[f64; P]>],
        free: &[bool; P],
        j: usize,
        spread: Spread,
    ) -> Option<Self> {
        let mut rest = *free;
        rest[j] = false;
        let others = inverse(&all.curvature, &rest)?;
        let inverse = inverse(&all.curvature, free)?;
        let scale = inverse[j][j] / (spread.std_error * spread.std_error);
        let along = core::array::from_fn(|k| inverse[k][j] / inverse[j][j]);
        let std_error = spread.std_error;
        scale.is_finite().then_some(Self {
            problem,
            minimum,
            j,
            std_error,
            slopes,
            others,
            scale,
            along,
        })
    }

    /// The likelihood ratio's curve, by rising value, within the bounds.
    pub(crate) fn points(&self) -> Vec<PlantProfile> {
        let mut values: Vec<f64> = (-REACH * STEPS..=REACH * STEPS)
            .map(|step| {
                self.inside(self.fitted() + f64::from(step) / f64::from(STEPS) * self.std_error)
            })
            .collect();
        // Steps beyond a bound all end on it.
        values.dedup();
        values.into_iter().filter_map(|value| self.at(value)).collect()
    }

    /// The values to either side at which the likelihood ratio is `critical`², or the bounds
    /// before.
    pub(crate) fn interval(&self, critical: f64) -> Option<(f64, f64)> {
        Some((self.crossing(critical, -1.0)?, self.crossing(critical, 1.0)?))
    }

    /// The value at which the root of the curve meets the level on one side, or the bound before.
    fn crossing(&self, critical: f64, side: f64) -> Option<f64> {
        let Parameter { lower, upper, .. } = self.problem.parameters[self.j];
        let bound = if side < 0.0 { lower } else { upper };
        let furthest = (bound - self.fitted()).abs();
        // The root, because it is nearly straight where the ratio is nearly a parabola.
        let distance = meet(critical, critical * self.std_error, furthest, |distance| {
            let value = self.inside(self.fitted() + side * distance);
            Some(self.at(value)?.likelihood_ratio.sqrt())
        })?;
        Some(self.inside(self.fitted() + side * distance))
    }

    fn at(&self, value: f64) -> Option<PlantProfile> {
        let minimum = self.minimum;
        let away = value - self.fitted();
        // From where the others go to first order, which is where they end in a linear model.
        let start =
            self.within(core::array::from_fn(|k| minimum.parameters[k] + away * self.along[k]));
        let rss = match away == 0.0 {
            true => minimum.rss,
            false => self.refitted(start).or_else(|| self.problem.held(start, self.j, value))?,
        };
        let parameter = &self.problem.parameters[self.j];
        Some(PlantProfile {
            parameter: parameter.name,
            unit: parameter.unit.into(),
            value,
            relative_error: rss / minimum.rss,
            likelihood_ratio: ((rss - minimum.rss) * self.scale).max(0.0),
        })
    }

    /// The least Σ r² over the other parameters by Gauss–Newton steps with the slopes at the
    /// minimum, which spares new ones; `None` where they do not get there, as at a bound.
    fn refitted(&self, start: [f64; P]) -> Option<f64> {
        let mut at = start;
        for _ in 0..MAX_STEPS {
            let (rss, gradient) = self.problem.gradient(&at, self.slopes);
            let step: [f64; P] = core::array::from_fn(|k| {
                (0..P).map(|l| self.others[k][l] * gradient[l]).sum::<f64>()
            });
            let promised: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
            let least = (CLOSE * (rss - self.minimum.rss).abs()).max(ROUNDING * rss);
            if promised <= least {
                return Some(rss);
            }
            at = self.within(core::array::from_fn(|k| at[k] - step[k]));
        }
        None
    }

    fn fitted(&self) -> f64 {
        self.minimum.parameters[self.j]
    }

    fn within(&self, at: [f64; P]) -> [f64; P] {
        core::array::from_fn(|k| {
            at[k].clamp(self.problem.parameters[k].lower, self.problem.parameters[k].upper)
        })
    }

    fn inside(&self, value: f64) -> f64 {
        let parameter = &self.problem.parameters[self.j];
        value.clamp(parameter.lower, parameter.upper)
    }
}

/// The distance from the fit at which `root` meets the level, by secants through the last two
/// points, the first of which is the fit; `furthest` where it stays below up to there.
fn meet(level: f64, first: f64, furthest: f64, root: impl Fn(f64) -> Option<f64>) -> Option<f64> {
    let mut before = [0.0, 0.0];
    let mut distance = first;
    for _ in 0..MAX_SECANTS {
        let beyond = distance > furthest;
        let here = distance.min(furthest);
        let height = root(here)?;
        if (beyond && height <= level) || (height / level - 1.0).abs() <= TOLERANCE {
            return Some(here);
        }
        let secant = here + (level - height) * (here - before[0]) / (height - before[1]);
        // Where the curve does not rise between the two, as if it were straight from the fit on.
        let stretched = here * level / height;
        distance = if secant.is_finite() && secant > 0.0 { secant } else { stretched };
        before = [here, height];
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots that flatten out or steepen, where stretching from the fit alone takes dozens of
    /// steps.
    #[test]
    fn the_level_is_met_however_the_curve_bends() {
        for power in [0.2, 0.3, 0.5, 0.63, 1.0, 1.3, 2.0, 3.0] {
            let root = |distance: f64| Some(libm::pow(distance / 4.0, power) * 2.98);
            let met = meet(2.98, 2.98, 1e9, root).unwrap_or(f64::NAN);
            let off = root(met).unwrap() / 2.98 - 1.0;
            assert!(off.abs() <= TOLERANCE, "power {power}: {met}");
        }
    }

    #[test]
    fn a_curve_that_stays_below_the_level_ends_at_the_bound() {
        assert_eq!(meet(2.0, 2.0, 5.0, |distance| Some(distance / 10.0)), Some(5.0));
        assert_eq!(meet(2.0, 9.0, 5.0, Some), Some(2.0));
        assert_eq!(meet(2.0, 2.0, 5.0, |_| None), None);
    }
}
