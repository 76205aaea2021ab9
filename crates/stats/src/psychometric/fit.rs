//! The curve of one person's answers: maximum likelihood with λ within bounds, profile intervals, and a verdict.
//!
//! λ is free within an interval ([0, 0.06] by default): fixed at 0 it makes JNDs of people who lapse in a twentieth of
//! trials 28 % too large, and their intervals hold the truth in 58 % (Wichmann & Hill 2001, Perception & Psychophysics
//! 63:1293; `docs/statistics-tried.md` has ours). Intervals hold all thresholds (JNDs) whose profiled log-likelihood is
//! within ½ φ c of the largest. People's attention changes from block to block, so that answers scatter more than
//! binomial ones: φ = max(1, X²/(K − P)) with Pearson's X² of K levels and P free parameters (McCullagh & Nelder 1989, 4.5):
//! threshold, JND, λ where it is not fixed, γ of yes and no. c is from χ² with one degree of freedom where φ = 1, else from
//! F(1, K − P). Only for constant stimuli at five levels or more: answers of
//! adaptive methods lie too thinly on theirs, and φ = 1.

use super::curve::{Asks, Curve, Sigmoid};
use super::likelihood::{Held, Likelihood, Maximum, log_share};
use super::{LevelAnswers, by_level};
use crate::error::{StatsError, check_level};
use crate::profile;
use crate::reference::normal_critical;
use crate::student_t::critical_value;

/// Bounds of λ where nobody gives others.
pub const LAPSE: [f64; 2] = [0.0, 0.06];
/// The fewest levels and answers that a curve is fitted to.
pub const FEWEST_LEVELS: usize = 3;
/// See [`FEWEST_LEVELS`].
pub const FEWEST_ANSWERS: u64 = 30;
/// The fewest levels that tell how much more than binomially answers scatter.
const LEVELS_FOR_SCATTER: usize = 5;
/// A slope is there where the log-likelihood of a curve exceeds that of one share for all levels by half of this: the
/// 95 % point of χ² with one degree of freedom.
const SLOPE: f64 = 3.841_458_82;
/// An end of an interval is looked for up to so many ranges of the levels, and JNDs by a factor of e to this. A JND of so
/// many ranges is none.
const FARTHEST: f64 = 10.0;

/// What is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// What was asked.
    pub asks: Asks,
    /// The shape of F.
    pub sigmoid: Sigmoid,
    /// The least and the largest λ; twice the same number fixes it.
    pub lapse: [f64; 2],
    /// Whether levels were constant stimuli, chosen before the first answer.
    pub is_constant: bool,
}

/// Whether there is a threshold and a JND.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There are.
    Estimated,
    /// The threshold lies beyond the levels.
    Outside(Side),
    /// The curve rises from F = ¼ to F = ¾ within less than the gap between levels that holds its threshold, so that they
    /// do not tell how steep it is: the JND is below half of this gap. A JND below the gap itself would be a stricter
    /// limit, and leave out people whose answers tell their JND: 21 N/m with an interval from 13 to 32, at levels 30 N/m
    /// apart.
    Steep,
    /// The share falls with the level.
    Falling,
    /// The share does not change with the level beyond chance, or so slowly that the JND is above ten times the range
    /// of the levels. Also who says yes to most of nothing, so that no threshold is left to find.
    Flat,
    /// Fewer than three levels, or than 30 answers.
    TooFew,
}

/// On which side of the levels a threshold lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// Below the lowest.
    Below,
    /// Above the highest.
    Above,
}

/// An estimate with the ends of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profiled {
    /// The estimate.
    pub estimate: f64,
    /// The lower end; `None` where the likelihood does not fall that far, so that the interval has no lower end.
    pub ci_low: Option<f64>,
    /// The upper end, or `None`.
    pub ci_high: Option<f64>,
}

/// A fitted curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fitted {
    /// The curve.
    pub curve: Curve,
    /// The level at F = ½, in the unit of the stimulus.
    pub threshold: Profiled,
    /// The JND, in the unit of the stimulus.
    pub jnd: Profiled,
    /// The standard error of the threshold, in the unit of the stimulus, φ included: half the length of its interval over
    /// the critical value that made it. `None` without both ends.
    pub threshold_error: Option<f64>,
    /// The standard error of ln JND, likewise.
    pub ln_jnd_error: Option<f64>,
    /// The log-likelihood, without binomial coefficients.
    pub log_likelihood: f64,
    /// Twice its distance from the largest that any shares have.
    pub deviance: f64,
    /// Pearson's X².
    pub pearson: f64,
    /// φ, by which the likelihood ratio was divided.
    pub dispersion: f64,
}

/// What the answers of one person tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Whether there is an estimate.
    pub verdict: Verdict,
    /// Levels that were answered.
    pub levels: usize,
    /// Trials that were answered.
    pub trials: u64,
    /// The curve, if the verdict is [`Verdict::Estimated`].
    pub fitted: Option<Fitted>,
}

impl Model {
    /// Checks the bounds of λ and the levels, and sorts the answers.
    pub(super) fn checked(
        &self,
        answers: &[LevelAnswers],
    ) -> Result<Vec<LevelAnswers>, StatsError> {
        let [least, most] = self.lapse;
        if !(0.0 <= least && least <= most && most < 0.5) {
            return Err(StatsError::Lapse { least, most });
        }
        let answers = by_level(answers)?;
        let lowest = answers.first().map_or(0.0, |answer| answer.level);
        if self.sigmoid == Sigmoid::Weibull && lowest < 0.0 {
            return Err(StatsError::BelowZero { level: lowest });
        }
        if self.asks == Asks::YesNo && answers.iter().all(|answer| answer.level != 0.0) {
            return Err(StatsError::NothingShown);
        }
        Ok(answers)
    }

    pub(super) fn likelihood<'a>(&self, answers: &'a [LevelAnswers]) -> Likelihood<'a> {
        let Self { asks, sigmoid, lapse, .. } = *self;
        Likelihood { answers, asks, sigmoid, lapse, falls: false }
    }

    /// How many numbers of a curve are free.
    fn parameters(&self) -> usize {
        let [least, most] = self.lapse;
        2 + usize::from(least < most) + usize::from(self.asks == Asks::YesNo)
    }

    /// The shares at F = ½ that γ and λ allow.
    fn half_shares(&self) -> [f64; 2] {
        let [least, most] = self.lapse;
        match self.asks {
            Asks::WhichWasMore => [0.5, 0.5],
            Asks::RightOrWrong => [(1.5 - most) / 2.0, (1.5 - least) / 2.0],
            Asks::YesNo => [(1.0 - most) / 2.0, (1.5 - least) / 2.0],
        }
    }

    /// The shares that γ and λ allow at any F.
    fn all_shares(&self) -> [f64; 2] {
        let least = self.lapse[0];
        match self.asks {
            Asks::WhichWasMore => [least, 1.0 - least],
            Asks::RightOrWrong => [0.5, 1.0 - least],
            Asks::YesNo => [0.0, 1.0 - least],
        }
    }
}

/// The curve of a person's answers with intervals at `confidence` (such as 0.95), or the verdict why there is none.
///
/// In this order, likelihood ratios by χ² with one degree of freedom at 5 %:
///
/// 1. `TooFew`;
/// 2. `Falling` if a falling curve describes the answers better than one share for all levels, and than a rising one;
/// 3. if no rising curve does: `Outside` if that share differs from the one at F = ½, else `Flat`; of yes and no `Flat`
///    too if the share is above it, because who says yes to nothing has no threshold below it;
/// 4. `Flat` if the JND is above ten times the range of the levels, or has no end;
/// 5. `Outside` if the threshold is beyond the levels (below those of yes and no: `Flat`);
/// 6. `Steep` if 2 JND are less than the gap between the levels on either side of the threshold, or than the larger one
///    of both gaps where it lies on a level;
/// 7. `Estimated`.
///
/// # Errors
/// A level that is not finite, more positive answers than trials, bounds of λ outside [0, 0.5), levels below 0 for
/// Weibull's sigmoid, yes and no without trials at level 0, `confidence` outside (0, 1).
pub fn fit(answers: &[LevelAnswers], model: &Model, confidence: f64) -> Result<Fit, StatsError> {
    check_level(confidence)?;
    let answers = model.checked(answers)?;
    let levels: Vec<f64> = answers.iter().map(|answer| answer.level).collect();
    let trials = answers.iter().map(|answer| answer.trials).sum();
    let without = |verdict| Ok(Fit { verdict, levels: levels.len(), trials, fitted: None });
    if levels.len() < FEWEST_LEVELS || trials < FEWEST_ANSWERS {
        return without(Verdict::TooFew);
    }
    let rising = model.likelihood(&answers);
    let falling = Likelihood { falls: true, ..model.likelihood(&answers) };
    let positive: u64 = answers.iter().map(|answer| answer.positive).sum();
    let share = positive as f64 / trials as f64;
    let [lowest_share, highest_share] = model.all_shares();
    let level_share = share.clamp(lowest_share, highest_share);
    let all = LevelAnswers { level: 0.0, trials, positive };
    let constant = log_share(&all, level_share, 1.0 - level_share);
    let maximum = rising.maximum();
    let rises = maximum.map_or(f64::NEG_INFINITY, |found| found.best.log_likelihood);
    let falls = falling.maximum().map_or(f64::NEG_INFINITY, |found| found.best.log_likelihood);
    if falls > rises && 2.0 * (falls - constant) > SLOPE {
        return without(Verdict::Falling);
    }
    let below =
        if model.asks == Asks::YesNo { Verdict::Flat } else { Verdict::Outside(Side::Below) };
    let Some(maximum) = maximum.filter(|_| 2.0 * (rises - constant) > SLOPE) else {
        let [low, high] = model.half_shares();
        let half_share = share.clamp(low, high);
        let half = log_share(&all, half_share, 1.0 - half_share);
        let differs = 2.0 * (constant - half) > SLOPE;
        return without(match (differs, share > high) {
            (false, _) => Verdict::Flat,
            (true, true) => below,
            (true, false) => Verdict::Outside(Side::Above),
        });
    };
    let curve = rising.curve(maximum.shape, maximum.best);
    let threshold = curve.threshold();
    let jnd = curve.jnd();
    let lowest = levels[0];
    let highest = levels[levels.len() - 1];
    // Weibull's sigmoid can leave 0 at level 0 and not change any more: then its JND has no end.
    let has_numbers = threshold.is_finite() && jnd.is_finite();
    if !has_numbers || jnd > FARTHEST * (highest - lowest) {
        return without(Verdict::Flat);
    }
    if threshold < lowest {
        return without(below);
    }
    if threshold > highest {
        return without(Verdict::Outside(Side::Above));
    }
    if 2.0 * jnd < gap_around(threshold, &levels) {
        return without(Verdict::Steep);
    }
    let fitted = intervals(&rising, model, maximum, confidence)?;
    Ok(Fit { verdict: Verdict::Estimated, levels: levels.len(), trials, fitted: Some(fitted) })
}

/// The distance of the neighbouring levels that hold the threshold, the larger one where it lies on a level.
fn gap_around(threshold: f64, levels: &[f64]) -> f64 {
    let holding = levels.windows(2).filter(|pair| pair[0] <= threshold && threshold <= pair[1]);
    holding.map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
}

/// The curve with its profile intervals and how well it describes the answers.
fn intervals(
    likelihood: &Likelihood,
    model: &Model,
    maximum: Maximum,
    confidence: f64,
) -> Result<Fitted, StatsError> {
    let Maximum { shape, best } = maximum;
    let curve = likelihood.curve(shape, best);
    let (deviance, pearson) = misfit(likelihood.answers, &curve);
    let levels = likelihood.answers.len();
    let left = levels as f64 - model.parameters() as f64;
    let mut dispersion = 1.0_f64;
    // More levels than parameters: there are four at most.
    if model.is_constant && levels >= LEVELS_FOR_SCATTER {
        dispersion = dispersion.max(pearson / left);
    }
    let critical = if dispersion > 1.0 {
        // The root of F(1, K − P) is t.
        critical_value(confidence, left)?
    } else {
        normal_critical(confidence)?
    };
    let fall = |held: Held| {
        let fallen = best.log_likelihood - likelihood.profile(held, shape);
        (2.0 * fallen.max(0.0) / dispersion).sqrt()
    };
    // Roughly a standard error: of the threshold in its coordinate, and of ln JND.
    let unit = 2.0 / likelihood.trials().sqrt();
    let scale = libm::exp(shape.ln_scale);
    let farthest = likelihood
        .coordinates()
        .into_iter()
        .fold(scale, |most, coordinate| most.max((coordinate - shape.threshold).abs()));
    // No profile has an error, so neither has an end.
    let end = |fall: &dyn Fn(f64) -> f64, farthest: f64| {
        profile::end(|distance| Ok(fall(distance)), critical, farthest).unwrap_or(None)
    };
    let threshold_end = |sign: f64| {
        let at = |distance: f64| shape.threshold + sign * distance * unit * scale;
        let distance =
            end(&|d| fall(Held::Threshold(at(d))), FARTHEST * farthest / (unit * scale))?;
        Some(likelihood.sigmoid.level(at(distance)))
    };
    let ln_jnd = libm::log(curve.jnd());
    let jnd_end = |sign: f64| {
        let at = |distance: f64| ln_jnd + sign * distance * unit;
        Some(libm::exp(at(end(&|d| fall(Held::LnJnd(at(d))), FARTHEST / unit)?)))
    };
    let [threshold, jnd] = [
        Profiled {
            estimate: curve.threshold(),
            ci_low: threshold_end(-1.0),
            ci_high: threshold_end(1.0),
        },
        Profiled { estimate: curve.jnd(), ci_low: jnd_end(-1.0), ci_high: jnd_end(1.0) },
    ];
    let error = |profiled: Profiled, read: fn(f64) -> f64| {
        Some((read(profiled.ci_high?) - read(profiled.ci_low?)) / 2.0 / critical)
    };
    Ok(Fitted {
        curve,
        threshold,
        jnd,
        threshold_error: error(threshold, |end| end),
        ln_jnd_error: error(jnd, libm::log),
        log_likelihood: best.log_likelihood,
        deviance,
        pearson,
        dispersion,
    })
}

/// The deviance 2 Σ (k ln(k/nψ) + (n − k) ln((n − k)/n(1 − ψ))) and Pearson's Σ (k − nψ)²/(nψ(1 − ψ)).
pub(super) fn misfit(answers: &[LevelAnswers], curve: &Curve) -> (f64, f64) {
    let (mut deviance, mut pearson) = (0.0, 0.0);
    for answer in answers {
        let [share, rest] = curve.shares(answer.level);
        let n = answer.trials as f64;
        let parts = [
            (answer.positive as f64, n * share),
            ((answer.trials - answer.positive) as f64, n * rest),
        ];
        for (count, expected) in parts {
            if count > 0.0 {
                deviance += 2.0 * count * libm::log(count / expected);
            }
        }
        let variance = n * share * rest;
        // A share of 0 or 1 is that of all answers there.
        if variance > 0.0 {
            pearson += (answer.positive as f64 - n * share).powi(2) / variance;
        }
    }
    // Of a curve through all shares rounding may leave less than nothing.
    (deviance.max(0.0), pearson)
}
