//! psignifit's estimate: the posterior of the curves on a grid.
//!
//! Schütt, Harmeling, Macke & Wichmann (2016), Vision Research 122:105, with the priors of psignifit 4. Of K levels over a
//! range r with the smallest step s:
//!
//! * threshold: even over the levels, falling by a cosine to 0 half a range beyond them;
//! * width, from F = 0.05 to F = 0.95: even from 2 s to r, falling by cosines to 0 at s and 3 r;
//! * λ, and γ of yes and no: Beta(1, 10) up to ½. Of "which was more" they are one number, which psignifit 4.3 gives its
//!   prior twice and we once;
//! * η, if answers may scatter more than binomial ones: Beta(1, 10); the share at a level is itself a Beta variable of
//!   variance η² ψ (1 − ψ).
//!
//! The grid is laid over all that the priors allow, then over what has mass, until it holds all of it on enough places of
//! each axis: many trials leave mass to a small part of what the priors allow. Means and ends of intervals are those
//! of the marginal posteriors (psignifit's ends lie half a cell lower). Weibull's sigmoid is taken in ln x, as psignifit
//! asks for it: its widths and ranges are those of ln x.

use super::curve::{Asks, Curve, Shares, Sigmoid};
use super::marginal::{Marginal, marginal};
use super::{LevelAnswers, by_level, smallest_step};
use crate::error::{StatsError, check_level};
use crate::tested::{Unestimable, at_least};
use core::f64::consts::PI;

/// Distances of z between F = 0.05 and F = 0.95: twice the normal quantile of 0.95, 2 ln 19, ln(ln 0.05/ln 0.95).
const NORMAL_WIDTH: f64 = 3.289_707_253_902_945;
const LOGISTIC_WIDTH: f64 = 5.888_877_958_332_880_5;
const WEIBULL_WIDTH: f64 = 4.067_383_949_407_112_5;
/// The second number of the Beta priors: their density falls with (1 − x) to this less one.
const RARITY: f64 = 10.0;
/// The largest λ and γ.
const MOST_LAPSES: f64 = 0.5;
/// η² below which answers count as binomial.
const NO_SCATTER: f64 = 1e-9;
/// Cells with less than this share of the highest are left out of the next grid.
const NO_MASS: f64 = 1e-6;
/// A grid is laid again while less than one in so many places of an axis has mass: cells as wide as half a standard
/// deviation then, of the finest grid.
const FEW: usize = 4;
/// More grids than a posterior needs: each is at least twice as fine as the one before, or lies half beside it.
const MOST_GRIDS: usize = 60;
/// The mode is found to this share of the last grid's cells.
const MODE: f64 = 1e-6;
/// More moves than a mode needs to be found from the highest cell.
const MOST_MOVES: usize = 1000;
/// Parameters: the coordinate of the threshold, the width, λ, γ and η.
const AXES: usize = 5;

/// What the posterior is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// What was asked.
    pub asks: Asks,
    /// The shape of F.
    pub sigmoid: Sigmoid,
    /// Whether answers may scatter more than binomial ones (η).
    pub is_overdispersed: bool,
}

/// The posterior of a person's curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posterior {
    /// The curve whose parameters are the means of their marginals.
    pub mean: Curve,
    /// The most probable curve (MAP).
    pub mode: Curve,
    /// The level at F = ½, in the unit of the stimulus.
    pub threshold: Marginal,
    /// The JND, in the unit of the stimulus.
    pub jnd: Marginal,
    /// λ.
    pub lapse: Marginal,
    /// Mean of η; 0 where answers are binomial.
    pub overdispersion: f64,
}

/// The posterior of the curve of these answers, with intervals at `confidence`.
///
/// # Errors
/// Fewer than two levels, a level that is not finite (or not above 0 for Weibull's sigmoid), more positive answers than
/// trials, yes and no without trials at level 0, `confidence` outside (0, 1).
pub fn posterior(
    answers: &[LevelAnswers],
    grid: &Grid,
    confidence: f64,
) -> Result<Posterior, Unestimable> {
    check_level(confidence)?;
    let answers = by_level(answers)?;
    at_least("levels", answers.len(), 2)?;
    if grid.sigmoid == Sigmoid::Weibull && answers[0].level <= 0.0 {
        return Err(StatsError::BelowZero { level: answers[0].level }.into());
    }
    if grid.asks == Asks::YesNo && answers.iter().all(|answer| answer.level != 0.0) {
        return Err(StatsError::NothingShown.into());
    }
    let coordinates: Vec<f64> =
        answers.iter().map(|answer| grid.sigmoid.coordinate(answer.level)).collect();
    let lowest = coordinates[0];
    let range = coordinates[coordinates.len() - 1] - lowest;
    let step = smallest_step(&coordinates);
    let problem =
        Problem { answers: &answers, coordinates: &coordinates, grid, lowest, range, step };
    let has_guess = grid.asks == Asks::YesNo;
    let bounds = [
        [lowest - range / 2.0, lowest + 1.5 * range],
        [step, 3.0 * range],
        [0.0, MOST_LAPSES],
        if has_guess { [0.0, MOST_LAPSES] } else { [0.5, 0.5] },
        if grid.is_overdispersed { [0.0, 1.0 - 1e-10] } else { [0.0, 0.0] },
    ];
    // As fine as a second of one processor allows.
    let fine = match (has_guess, grid.is_overdispersed) {
        (false, false) => [100, 100, 40, 1, 1],
        (true, false) => [50, 50, 20, 20, 1],
        (false, true) => [40, 40, 16, 1, 20],
        (true, true) => [25, 25, 10, 10, 12],
    };
    let coarse = [30, 40, 10, 10, 15];
    let coarse: [usize; AXES] = core::array::from_fn(|i| if fine[i] == 1 { 1 } else { coarse[i] });
    let first = problem.laid(core::array::from_fn(|i| axis(bounds[i], coarse[i])));
    let mut ranges = first.ranges_with_mass(&bounds);
    let mut last = problem.laid(core::array::from_fn(|i| axis(ranges[i], fine[i])));
    for _ in 0..MOST_GRIDS {
        if last.holds_the_mass(&bounds) {
            break;
        }
        ranges = last.ranges_with_mass(&bounds);
        last = problem.laid(core::array::from_fn(|i| axis(ranges[i], fine[i])));
    }
    let masses = last.masses();
    let points = || (0..masses.len()).map(|cell| last.point(cell));
    let marginal_of = |read: &dyn Fn(&[f64; AXES]) -> f64| {
        let values = points().zip(&masses).map(|(point, mass)| [read(&point), *mass]);
        marginal(values.collect(), confidence)
    };
    let means: [f64; AXES] = core::array::from_fn(|i| {
        let lowest = last.axes[i][0];
        let above: f64 =
            points().zip(&masses).map(|(point, mass)| (point[i] - lowest) * mass).sum();
        lowest + above
    });
    Ok(Posterior {
        mean: problem.curve(&means),
        mode: problem.curve(&problem.mode(&last)),
        threshold: marginal_of(&|point| grid.sigmoid.level(point[0])),
        jnd: marginal_of(&|point| problem.curve(point).jnd()),
        lapse: marginal_of(&|point| point[2]),
        overdispersion: means[4],
    })
}

/// So many places from one end to the other.
fn axis([from, to]: [f64; 2], places: usize) -> Vec<f64> {
    let last = (places - 1).max(1) as f64;
    (0..places).map(|i| from + (to - from) * i as f64 / last).collect()
}

struct Problem<'a> {
    answers: &'a [LevelAnswers],
    coordinates: &'a [f64],
    grid: &'a Grid,
    lowest: f64,
    range: f64,
    step: f64,
}

/// A grid with the logarithm of the posterior at each of its points, but for a constant.
struct Laid {
    axes: [Vec<f64>; AXES],
    logs: Vec<f64>,
}

impl Laid {
    /// The places along the axes of a cell: the last axis runs fastest.
    fn places(&self, mut cell: usize) -> [usize; AXES] {
        let mut places = [0; AXES];
        for (place, axis) in places.iter_mut().zip(&self.axes).rev() {
            *place = cell % axis.len();
            cell /= axis.len();
        }
        places
    }

    fn point(&self, cell: usize) -> [f64; AXES] {
        let places = self.places(cell);
        core::array::from_fn(|i| self.axes[i][places[i]])
    }

    fn highest(&self) -> (usize, f64) {
        let cells = self.logs.iter().copied().enumerate();
        cells.fold((0, f64::NEG_INFINITY), |best, cell| if cell.1 > best.1 { cell } else { best })
    }

    /// The first and the last place with mass along each axis.
    fn places_with_mass(&self) -> [[usize; 2]; AXES] {
        let least = self.highest().1 + libm::log(NO_MASS);
        let mut ends = [[usize::MAX, 0]; AXES];
        for cell in (0..self.logs.len()).filter(|cell| self.logs[*cell] >= least) {
            for ([first, last], place) in ends.iter_mut().zip(self.places(cell)) {
                *first = (*first).min(place);
                *last = (*last).max(place);
            }
        }
        ends
    }

    /// Whether no end of an axis has mass, but where the prior ends, and enough of its places have.
    fn holds_the_mass(&self, bounds: &[[f64; 2]; AXES]) -> bool {
        let mut axes = self.axes.iter().zip(self.places_with_mass()).zip(bounds);
        axes.all(|((values, [first, last]), [from, to])| {
            let end = values.len() - 1;
            let is_inside = (first > 0 || values[0] <= *from) && (last < end || values[end] >= *to);
            end == 0 || is_inside && FEW * (last + 1 - first) >= values.len()
        })
    }

    /// Of each axis the part outside of which nothing has mass, and a cell more on either side; half of the axis more
    /// where its end has mass. Within the bounds.
    fn ranges_with_mass(&self, bounds: &[[f64; 2]; AXES]) -> [[f64; 2]; AXES] {
        let places = self.places_with_mass();
        core::array::from_fn(|i| {
            let [first, last] = places[i];
            let values = &self.axes[i];
            let end = values.len() - 1;
            let half = (values[end] - values[0]) / 2.0;
            let from = if first > 0 { values[first - 1] } else { values[0] - half };
            let to = if last < end { values[last + 1] } else { values[end] + half };
            [from.max(bounds[i][0]), to.min(bounds[i][1])]
        })
    }

    /// Shares of the posterior by the trapezoidal rule: cells at an end count half.
    fn masses(&self) -> Vec<f64> {
        let highest = self.highest().1;
        let masses = self.logs.iter().enumerate().map(|(cell, log)| {
            let places = self.places(cell);
            let mut mass = libm::exp(log - highest);
            for (place, axis) in places.iter().zip(&self.axes) {
                if axis.len() > 1 && (*place == 0 || *place == axis.len() - 1) {
                    mass *= 0.5;
                }
            }
            mass
        });
        let masses: Vec<f64> = masses.collect();
        let whole: f64 = masses.iter().sum();
        masses.into_iter().map(|mass| mass / whole).collect()
    }
}

impl Problem<'_> {
    fn curve(&self, point: &[f64; AXES]) -> Curve {
        let [threshold, width, lapse, guess, _] = *point;
        let sigmoid = self.grid.sigmoid;
        let scale = width / width_of_scale_one(sigmoid);
        let location = threshold - scale * sigmoid.middle();
        let guess = if self.grid.asks == Asks::WhichWasMore { lapse } else { guess };
        Curve { sigmoid, location, scale, guess, lapse }
    }

    fn laid(&self, axes: [Vec<f64>; AXES]) -> Laid {
        let mut logs = Vec::with_capacity(axes.iter().map(Vec::len).product());
        for threshold in &axes[0] {
            for width in &axes[1] {
                let shares = self.shares(*threshold, *width);
                for lapse in &axes[2] {
                    for guess in &axes[3] {
                        for scatter in &axes[4] {
                            let point = [*threshold, *width, *lapse, *guess, *scatter];
                            logs.push(self.log_posterior(&point, &shares));
                        }
                    }
                }
            }
        }
        Laid { axes, logs }
    }

    fn shares(&self, threshold: f64, width: f64) -> Vec<Shares> {
        let curve = self.curve(&[threshold, width, 0.0, 0.0, 0.0]);
        let z = self.coordinates.iter().map(|at| (at - curve.location) / curve.scale);
        z.map(|z| self.grid.sigmoid.shares(z)).collect()
    }

    /// ln(likelihood · prior), but for a constant.
    fn log_posterior(&self, point: &[f64; AXES], shares: &[Shares]) -> f64 {
        let [threshold, width, lapse, _, scatter] = *point;
        let Curve { guess, .. } = self.curve(point);
        let mut log = self.log_prior(threshold, width) + beta(lapse) + beta(scatter);
        if self.grid.asks == Asks::YesNo {
            log += beta(guess);
        }
        let variance = scatter * scatter;
        let counts = 1.0 / variance - 1.0;
        for (answer, shares) in self.answers.iter().zip(shares) {
            let [share, rest] = shares.answers(guess, lapse);
            for (count, chance) in
                [(answer.positive, share), (answer.trials - answer.positive, rest)]
            {
                if count == 0 {
                    continue;
                }
                let count = count as f64;
                log += if variance <= NO_SCATTER {
                    count * libm::log(chance)
                } else {
                    libm::lgamma(count + chance * counts) - libm::lgamma(chance * counts)
                };
            }
            if variance > NO_SCATTER {
                log += libm::lgamma(counts) - libm::lgamma(answer.trials as f64 + counts);
            }
        }
        log
    }

    fn log_prior(&self, threshold: f64, width: f64) -> f64 {
        let Self { lowest, range, step, .. } = *self;
        let beyond = (lowest - threshold).max(threshold - lowest - range).max(0.0);
        let of_threshold = if beyond <= range / 2.0 {
            (1.0 + libm::cos(2.0 * PI * beyond / range)) / 2.0
        } else {
            0.0
        };
        let of_width = if width < step || width > 3.0 * range {
            0.0
        } else if width < 2.0 * step {
            (1.0 - libm::cos(PI * (width - step) / step)) / 2.0
        } else if width > range {
            (1.0 + libm::cos(PI / 2.0 * (width - range) / range)) / 2.0
        } else {
            1.0
        };
        libm::log(of_threshold) + libm::log(of_width)
    }

    /// The highest point of the posterior: from the highest of the grid to the highest within two steps along all axes,
    /// and with half the steps where there is none.
    fn mode(&self, laid: &Laid) -> [f64; AXES] {
        let (cell, mut height) = laid.highest();
        let mut point = laid.point(cell);
        let mut steps: [f64; AXES] = core::array::from_fn(|i| match laid.axes[i].as_slice() {
            [first, second, ..] => second - first,
            _ => 0.0,
        });
        let limits = [
            [f64::NEG_INFINITY, f64::INFINITY],
            [0.0, f64::INFINITY],
            [0.0, MOST_LAPSES],
            [0.0, MOST_LAPSES],
            [0.0, 1.0 - 1e-10],
        ];
        let smallest = MODE * steps[0];
        for _ in 0..MOST_MOVES {
            let around = self.laid(core::array::from_fn(|i| {
                let [least, most] = limits[i];
                let places = if steps[i] > 0.0 { 5 } else { 1 };
                let reach = 2.0 * steps[i];
                let axis = axis([point[i] - reach, point[i] + reach], places);
                axis.into_iter().map(|value| value.clamp(least, most)).collect()
            }));
            let (cell, highest) = around.highest();
            if highest > height {
                point = around.point(cell);
                height = highest;
            } else {
                steps.iter_mut().for_each(|step| *step /= 2.0);
            }
            if steps[0] < smallest {
                break;
            }
        }
        point
    }
}

fn width_of_scale_one(sigmoid: Sigmoid) -> f64 {
    match sigmoid {
        Sigmoid::Norm => NORMAL_WIDTH,
        Sigmoid::Logistic => LOGISTIC_WIDTH,
        Sigmoid::Weibull => WEIBULL_WIDTH,
    }
}

/// ln of the density of Beta(1, 10), but for a constant.
fn beta(x: f64) -> f64 {
    (RARITY - 1.0) * libm::log1p(-x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psychometric::fit::Model;
    use crate::psychometric::tests::{MORE, fitted, person};

    const MORE_GRID: Grid =
        Grid { asks: Asks::WhichWasMore, sigmoid: Sigmoid::Norm, is_overdispersed: false };

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
    }

    /// A fine grid by the definition, in NumPy (its tolerance is 2e-3 of each number); psignifit 4.3's MAP is 285.354
    /// and a width of 132.966.
    #[test]
    fn the_posterior_is_that_of_a_fine_grid_in_numpy() {
        let found = posterior(&person(1, 0), &MORE_GRID, 0.95).unwrap();
        for (number, expected) in [
            (found.threshold.mean, 284.3708),
            (found.threshold.ci_low, 271.743),
            (found.threshold.ci_high, 296.799),
            (found.jnd.mean, 26.4694),
            (found.jnd.ci_low, 17.358),
            (found.jnd.ci_high, 36.909),
        ] {
            near(number, expected, 2e-3 * expected);
        }
        near(found.mode.threshold(), 285.354, 2e-3);
        near(found.mode.scale * NORMAL_WIDTH, 132.966, 2e-3);
        assert_eq!((found.mode.lapse, found.overdispersion), (0.0, 0.0));
        near(found.mean.threshold(), found.threshold.mean, 1e-9);
        near(found.mean.jnd(), found.jnd.mean, 1e-9);
    }

    /// Of these people the width lies between two steps and the range, and λ is 0.
    #[test]
    fn where_priors_are_even_the_mode_has_the_largest_likelihood() {
        for (p, mode) in [(3, 0), (6, 1), (7, 0), (8, 1)] {
            let answers = person(p, mode);
            let found = posterior(&answers, &MORE_GRID, 0.95).unwrap();
            let likely = fitted(&answers, &MORE);
            near(likely.curve.lapse, 0.0, 1e-15);
            near(found.mode.threshold(), likely.threshold.estimate, 1e-3);
            near(found.mode.jnd(), likely.jnd.estimate, 1e-3);
        }
    }

    /// η = 0 is one end of the axis; answers that scatter widen the interval.
    #[test]
    fn scattered_answers_have_a_wider_posterior() {
        let counts = [3, 1, 9, 4, 18, 12, 20];
        let scattered: Vec<LevelAnswers> = (1..)
            .zip(counts)
            .map(|(level, positive)| LevelAnswers { level: f64::from(level), trials: 20, positive })
            .collect();
        let width = |is_overdispersed| {
            let found =
                posterior(&scattered, &Grid { is_overdispersed, ..MORE_GRID }, 0.95).unwrap();
            assert_eq!(found.overdispersion > 0.1, is_overdispersed);
            found.threshold.ci_high - found.threshold.ci_low
        };
        assert!(width(true) > 1.3 * width(false));
    }

    /// Of very many trials the posterior is the likelihood, and both intervals are those of a normal distribution.
    #[test]
    fn millions_of_trials_have_the_interval_of_the_likelihood() {
        for trials in [10_000, 1_000_000] {
            let answers: Vec<LevelAnswers> = [0.03, 0.08, 0.22, 0.5, 0.77, 0.92, 0.97]
                .into_iter()
                .zip(0..)
                .map(|(share, place)| LevelAnswers {
                    level: f64::from(place),
                    trials,
                    positive: (share * trials as f64).round() as u64,
                })
                .collect();
            let found = posterior(&answers, &MORE_GRID, 0.95).unwrap();
            let likely = fitted(&answers, &Model { is_constant: false, ..MORE });
            for (found, likely) in [(found.threshold, likely.threshold), (found.jnd, likely.jnd)] {
                let [low, high] = [likely.ci_low.unwrap(), likely.ci_high.unwrap()];
                let room = 0.03 * (high - low);
                near(found.mean, likely.estimate, room);
                near(found.ci_low, low, room);
                near(found.ci_high, high, room);
            }
        }
    }

    #[test]
    fn yes_and_no_and_weibulls_sigmoid_have_a_posterior_too() {
        let answers: Vec<LevelAnswers> = [(0.0, 3), (1.0, 6), (2.0, 14), (3.0, 24), (4.0, 29)]
            .map(|(level, positive)| LevelAnswers { level, trials: 30, positive })
            .to_vec();
        let yes_no = Grid { asks: Asks::YesNo, ..MORE_GRID };
        let found = posterior(&answers, &yes_no, 0.95).unwrap();
        assert!((0.01..0.2).contains(&found.mode.guess), "{found:?}");
        assert!((1.5..2.8).contains(&found.threshold.mean));
        let refused = posterior(&answers[1..], &yes_no, 0.95).unwrap_err();
        assert_eq!(refused, StatsError::NothingShown.into());
        let weibull = Grid { sigmoid: Sigmoid::Weibull, ..MORE_GRID };
        let found = posterior(&answers[1..], &weibull, 0.95).unwrap();
        assert!((1.5..2.8).contains(&found.threshold.mean), "{found:?}");
        assert!(found.jnd.ci_low < found.mode.jnd() && found.mode.jnd() < found.jnd.ci_high);
        assert!(posterior(&answers, &weibull, 0.95).is_err());
        assert!(posterior(&answers[..1], &MORE_GRID, 0.95).is_err());
    }
}
