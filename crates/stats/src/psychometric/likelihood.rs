//! The likelihood of answers under a curve, with the best γ and λ of any location and scale.
//!
//! Of a given F the share ψ = γ (1 − F) + (1 − λ) F is linear in γ and λ, so the log-likelihood is concave in them, and
//! their best values within their bounds are where a falling slope crosses zero, or a bound. The slope of the
//! likelihood over location and scale is then that of these values alone (the envelope theorem).

use super::curve::{Asks, Curve, Shares, Sigmoid};
use super::{LevelAnswers, smallest_step};
use zwidth_numerics::minimise::{Minimum, minimise};
use zwidth_numerics::roots;

/// The largest γ of yes and no.
const MOST_GUESSES: f64 = 0.5;
/// γ and λ are found to this.
const RESOLUTION: f64 = 1e-13;
/// Slope of the mean log-likelihood of a trial, over ranges of levels and ln σ, that counts as none.
const FLAT: f64 = 1e-11;
/// Scales that a search starts from: so many times the smallest step, up to so many times the range.
const NARROWEST_START: f64 = 0.03;
const WIDEST_START: f64 = 10.0;
/// The smallest and the largest ln σ that a held JND is started from.
const LN_SCALES: [f64; 2] = [-40.0, 4.0];
/// Starts along an axis, and how many of the best are followed.
const STARTS: usize = 17;
const FOLLOWED: usize = 6;

/// Answers, and the family of curves that they are described by.
pub(super) struct Likelihood<'a> {
    pub(super) answers: &'a [LevelAnswers],
    pub(super) asks: Asks,
    pub(super) sigmoid: Sigmoid,
    /// The least and the largest λ.
    pub(super) lapse: [f64; 2],
    /// Whether the share falls with the level: F and 1 − F change places.
    pub(super) falls: bool,
}

/// Where a curve lies: the coordinate of its threshold, and ln σ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    pub(super) threshold: f64,
    pub(super) ln_scale: f64,
}

/// The best γ and λ of a shape.
#[derive(Debug, Clone, Copy)]
pub(super) struct Best {
    pub(super) log_likelihood: f64,
    /// Slopes of the log-likelihood over the threshold and ln σ.
    slopes: [f64; 2],
    pub(super) guess: f64,
    pub(super) lapse: f64,
}

/// The shape of the largest likelihood, with its γ and λ.
#[derive(Debug, Clone, Copy)]
pub(super) struct Maximum {
    pub(super) shape: Shape,
    pub(super) best: Best,
}

/// What a profile holds.
#[derive(Debug, Clone, Copy)]
pub(super) enum Held {
    /// The coordinate of the threshold.
    Threshold(f64),
    /// ln JND.
    LnJnd(f64),
}

/// k ln ψ + (n − k) ln(1 − ψ), where an answer that nobody gave costs nothing. −∞ of an impossible answer.
pub(super) fn log_share(answer: &LevelAnswers, share: f64, rest: f64) -> f64 {
    let (k, n) = (answer.positive as f64, answer.trials as f64);
    let yes = if answer.positive > 0 { k * libm::log(share) } else { 0.0 };
    let no = if answer.positive < answer.trials { (n - k) * libm::log(rest) } else { 0.0 };
    yes + no
}

impl Likelihood<'_> {
    /// Number of answers.
    pub(super) fn trials(&self) -> f64 {
        self.answers.iter().map(|answer| answer.trials as f64).sum()
    }

    /// Levels, as the sigmoid takes them, that are finite (ln 0 is not).
    pub(super) fn coordinates(&self) -> Vec<f64> {
        let all = self.answers.iter().map(|answer| self.sigmoid.coordinate(answer.level));
        all.filter(|coordinate| coordinate.is_finite()).collect()
    }

    /// The curve of a shape.
    pub(super) fn curve(&self, shape: Shape, best: Best) -> Curve {
        let scale = libm::exp(shape.ln_scale);
        let location = shape.threshold - scale * self.sigmoid.middle();
        Curve { sigmoid: self.sigmoid, location, scale, guess: best.guess, lapse: best.lapse }
    }

    fn shares(&self, z: f64) -> Shares {
        let shares = self.sigmoid.shares(z);
        if self.falls {
            Shares { below: shares.above, above: shares.below, density: -shares.density }
        } else {
            shares
        }
    }

    /// The log-likelihood (without binomial coefficients) at a shape, γ and λ at their best. Not finite where an
    /// answer is impossible.
    pub(super) fn at(&self, shape: Shape) -> Best {
        let scale = libm::exp(shape.ln_scale);
        let middle = self.sigmoid.middle();
        let z = self.answers.iter().map(|answer| {
            (self.sigmoid.coordinate(answer.level) - shape.threshold) / scale + middle
        });
        let z: Vec<f64> = z.collect();
        let shares: Vec<Shares> = z.iter().map(|z| self.shares(*z)).collect();
        let [guess, lapse] = self.best_ends(&shares);
        let mut best = Best { log_likelihood: 0.0, slopes: [0.0; 2], guess, lapse };
        for ((answer, shares), z) in self.answers.iter().zip(&shares).zip(&z) {
            let [share, rest] = shares.answers(guess, lapse);
            best.log_likelihood += log_share(answer, share, rest);
            // At a level of 0 z is −∞ and does not move.
            if shares.density != 0.0 {
                let pull = pull(answer, share, rest) * (1.0 - guess - lapse) * shares.density;
                best.slopes[0] -= pull / scale;
                best.slopes[1] -= pull * (z - middle);
            }
        }
        best
    }

    /// The best [γ, λ] of shares F.
    fn best_ends(&self, shares: &[Shares]) -> [f64; 2] {
        let [least, most] = self.lapse;
        // The slope of the log-likelihood along a direction of (γ, λ).
        let slope = |ends: [f64; 2], along: [f64; 2]| -> f64 {
            let pulls = self.answers.iter().zip(shares).map(|(answer, shares)| {
                let [share, rest] = shares.answers(ends[0], ends[1]);
                let moves = along[0] * shares.above - along[1] * shares.below;
                if moves == 0.0 { 0.0 } else { pull(answer, share, rest) * moves }
            });
            pulls.sum()
        };
        match self.asks {
            Asks::WhichWasMore => {
                let lapse = crossing(|lapse| slope([lapse, lapse], [1.0, 1.0]), least, most);
                [lapse, lapse]
            }
            Asks::RightOrWrong => {
                [0.5, crossing(|lapse| slope([0.5, lapse], [0.0, 1.0]), least, most)]
            }
            Asks::YesNo => {
                let lapse =
                    |guess: f64| crossing(|lapse| slope([guess, lapse], [0.0, 1.0]), least, most);
                let of_guess = |guess: f64| slope([guess, lapse(guess)], [1.0, 0.0]);
                let guess = crossing(of_guess, 0.0, MOST_GUESSES);
                [guess, lapse(guess)]
            }
        }
    }

    /// The shape of the largest likelihood; `None` where no curve makes the answers possible.
    pub(super) fn maximum(&self) -> Option<Maximum> {
        let axes = self.axes();
        let mut starts = Vec::with_capacity(STARTS * STARTS);
        for threshold in &axes.thresholds {
            for ln_scale in &axes.ln_scales {
                starts.push(vec![(threshold - axes.from) / axes.range, *ln_scale]);
            }
        }
        let shape = |point: &[f64]| Shape {
            threshold: axes.from + axes.range * point[0],
            ln_scale: point[1],
        };
        let minimum = self.search(starts, |point| {
            let best = self.at(shape(point));
            (best.log_likelihood, vec![best.slopes[0] * axes.range, best.slopes[1]])
        })?;
        let shape = shape(&minimum.point);
        Some(Maximum { shape, best: self.at(shape) })
    }

    /// The largest log-likelihood of shapes that have what is held; −∞ where there is none. `near` is a shape that the
    /// search starts from too.
    pub(super) fn profile(&self, held: Held, near: Shape) -> f64 {
        let axes = self.axes();
        // The shape at a place along what is free, and how fast its threshold moves there.
        let is_weibull = self.sigmoid == Sigmoid::Weibull;
        let by_scale = matches!(held, Held::Threshold(_)) || is_weibull;
        let shape = |place: f64| match held {
            Held::Threshold(threshold) => (Shape { threshold, ln_scale: place }, [0.0, 1.0]),
            Held::LnJnd(ln_jnd) if is_weibull => {
                // The JND is a share of the threshold that grows with the scale.
                let scale = libm::exp(place);
                let (share, slope) = self.sigmoid.jnd_and_slope(scale);
                let threshold = ln_jnd - libm::log(share);
                (Shape { threshold, ln_scale: place }, [-slope * scale / share, 1.0])
            }
            Held::LnJnd(ln_jnd) => {
                let ln_scale = ln_jnd - libm::log(self.sigmoid.jnd_and_slope(1.0).0);
                (Shape { threshold: axes.from + axes.range * place, ln_scale }, [axes.range, 0.0])
            }
        };
        let mut starts: Vec<Vec<f64>> = if by_scale {
            axes.ln_scales.iter().map(|ln_scale| vec![*ln_scale]).collect()
        } else {
            let places = axes.thresholds.iter();
            places.map(|threshold| vec![(threshold - axes.from) / axes.range]).collect()
        };
        if let (Held::LnJnd(ln_jnd), true) = (held, is_weibull) {
            // Of a small JND few scales leave the threshold among the levels: those of the other starts lie too far apart.
            for threshold in &axes.thresholds {
                let over = |ln_scale: f64| {
                    let share = self.sigmoid.jnd_and_slope(libm::exp(ln_scale)).0;
                    libm::log(share) + threshold - ln_jnd
                };
                starts.push(vec![roots::bracketed(over, LN_SCALES[0], LN_SCALES[1], RESOLUTION)]);
            }
        }
        let near = if by_scale { near.ln_scale } else { (near.threshold - axes.from) / axes.range };
        starts.push(vec![near]);
        let minimum = self.search(starts, |point| {
            let (shape, along) = shape(point[0]);
            let best = self.at(shape);
            (best.log_likelihood, vec![best.slopes[0] * along[0] + best.slopes[1] * along[1]])
        });
        minimum.map_or(f64::NEG_INFINITY, |minimum| -minimum.value * self.trials())
    }

    /// The best of searches from the most likely of the starts, by the mean log-likelihood of a trial.
    fn search(
        &self,
        starts: Vec<Vec<f64>>,
        log_likelihood: impl Fn(&[f64]) -> (f64, Vec<f64>),
    ) -> Option<Minimum> {
        let trials = self.trials();
        let cost = |point: &[f64]| {
            let (value, slopes) = log_likelihood(point);
            (-value / trials, slopes.iter().map(|slope| -slope / trials).collect())
        };
        let mut starts: Vec<(f64, Vec<f64>)> = starts
            .into_iter()
            .map(|start| (log_likelihood(&start).0, start))
            .filter(|(value, _)| value.is_finite())
            .collect();
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        let followed = starts.iter().take(FOLLOWED);
        let minima = followed.filter_map(|(_, start)| minimise(cost, start, FLAT).ok());
        minima.min_by(|a, b| a.value.total_cmp(&b.value))
    }

    /// Where searches start.
    fn axes(&self) -> Axes {
        let coordinates = self.coordinates();
        let from = coordinates.first().copied().unwrap_or(0.0);
        let range = coordinates.last().map_or(0.0, |last| last - from);
        // One level: any measure serves, for its answers tell no scale.
        let range = if range > 0.0 { range } else { 1.0 };
        let step = smallest_step(&coordinates).min(range);
        let [narrow, wide] = [NARROWEST_START * step, WIDEST_START * range].map(libm::log);
        let share = |i: usize| i as f64 / (STARTS - 1) as f64;
        Axes {
            from,
            range,
            // From half a range below the lowest level to half a range above the highest.
            thresholds: (0..STARTS).map(|i| from + range * (2.0 * share(i) - 0.5)).collect(),
            ln_scales: (0..STARTS).map(|i| narrow + (wide - narrow) * share(i)).collect(),
        }
    }
}

struct Axes {
    from: f64,
    range: f64,
    thresholds: Vec<f64>,
    ln_scales: Vec<f64>,
}

/// The slope of the log-likelihood of a level's answers over ψ.
fn pull(answer: &LevelAnswers, share: f64, rest: f64) -> f64 {
    let yes = if answer.positive > 0 { answer.positive as f64 / share } else { 0.0 };
    let no = answer.trials - answer.positive;
    yes - if no > 0 { no as f64 / rest } else { 0.0 }
}

/// Where a falling slope crosses zero between two bounds, or the bound on its side.
fn crossing(slope: impl Fn(f64) -> f64, least: f64, most: f64) -> f64 {
    // At a bound of 0 a slope may be without end: between −1 and 1 the secants lead to the crossing.
    let bounded = |at: f64| {
        let slope = slope(at);
        if slope.is_infinite() { slope.signum() } else { slope / (1.0 + slope.abs()) }
    };
    if most <= least || bounded(least) <= 0.0 {
        return least;
    }
    if bounded(most) >= 0.0 {
        return most;
    }
    roots::bracketed(bounded, least, most, RESOLUTION).clamp(least, most)
}
