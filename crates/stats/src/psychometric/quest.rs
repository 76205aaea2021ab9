//! QUEST+: the next level is the one whose answer is expected to tell most.
//!
//! Watson (2017), J. Vision 17(3):10. Thresholds, scales and λ lie on a grid, on which every answer multiplies the
//! posterior (uniform at first) by the share of such answers. The level of least expected entropy follows, which is that
//! of the largest information between answer and curve,
//!
//! h(Σ p ψ) − Σ p h(ψ), h(ψ) = −ψ ln ψ − (1 − ψ) ln(1 − ψ),
//!
//! with p the posterior. Levels that tell equally much within 1e-12 are decided for the lowest one. All sums are plain
//! loops and all logarithms libm's, so the levels of a plan and its answers are the same on any machine.

use super::curve::{Asks, Curve, Sigmoid};
use super::marginal::{Marginal, marginal};
use super::{LevelAnswers, PARTS, by_level};
use crate::error::{StatsError, all_finite, check_level};
use std::sync::Arc;

/// Information, in nats, within which levels are equal; also the share within which masses are.
const EQUAL: f64 = 1e-12;
/// Posterior mass on an end of an axis from which the truth may lie beyond it, if the prior had less there.
const EDGE: f64 = 0.05;
/// Levels times curves, up to which a step takes less than a millisecond: twice as many take 1.3 ms to 1.7 ms, which is
/// the time that memory takes to be read.
const MOST_SHARES: usize = 500_000;

/// The plan of a session with QUEST+.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What is asked; γ is λ or ½. Yes and no has no γ on this grid.
    pub asks: Asks,
    /// The shape of F.
    pub sigmoid: Sigmoid,
    /// Levels that can be shown, rising, in the unit of the stimulus.
    pub levels: Vec<f64>,
    /// Thresholds, rising, in the unit of the stimulus.
    pub thresholds: Vec<f64>,
    /// σ, rising, in the unit of the stimulus; 1/β of Weibull's.
    pub scales: Vec<f64>,
    /// λ, rising.
    pub lapses: Vec<f64>,
}

/// QUEST+ after some answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// The level of each answered trial.
    pub levels: Vec<f64>,
    /// The next level.
    pub next: f64,
    /// Posterior mean of the threshold.
    pub threshold: f64,
    /// Posterior mean of σ.
    pub scale: f64,
    /// Posterior mean of λ.
    pub lapse: f64,
    /// Entropy of the posterior, in nats.
    pub entropy: f64,
    /// Whether one of the ends of the thresholds or scales has more than a twentieth of the posterior, and more than the
    /// prior gave it: the truth may lie beyond the grid, and the means are then pulled inwards.
    pub is_at_edge: bool,
}

/// The levels of a session by its plan and the answers so far: "more" or "right" are true.
///
/// # Errors
/// As [`Quest::new`] and [`Quest::answer`].
pub fn track(plan: &Plan, answers: &[bool]) -> Result<Track, StatsError> {
    let mut quest = Quest::new(plan)?;
    for is_positive in answers {
        quest.answer(quest.place, *is_positive)?;
    }
    Ok(quest.track())
}

/// QUEST+ answer by answer. What follows from the plan alone is computed once, and shared by clones.
#[derive(Debug, Clone, PartialEq)]
pub struct Quest {
    grid: Arc<Grid>,
    posterior: Vec<f64>,
    levels: Vec<f64>,
    /// The place of the next level among those of the plan.
    place: usize,
}

/// What follows from a plan alone.
#[derive(Debug, PartialEq)]
struct Grid {
    plan: Plan,
    cells: Vec<Cell>,
    /// By level: the shares of positive and of other answers in each cell.
    shares: Vec<Vec<[f64; 2]>>,
    /// By level: the entropy of these shares.
    entropies: Vec<Vec<f64>>,
}

impl Quest {
    /// Before the first answer.
    ///
    /// # Errors
    /// An empty axis, one that does not rise or is not finite, scales that are not above 0, λ outside [0, ½), levels below
    /// 0 or thresholds not above it for Weibull's sigmoid, yes and no, more than 500,000 levels times curves.
    pub fn new(plan: &Plan) -> Result<Self, StatsError> {
        check(plan)?;
        let cells = cells(plan);
        let shares: Vec<Vec<[f64; 2]>> = plan
            .levels
            .iter()
            .map(|level| cells.iter().map(|cell| cell.curve(plan).shares(*level)).collect())
            .collect();
        let entropies =
            shares.iter().map(|row| row.iter().map(|shares| entropy(*shares)).collect()).collect();
        let grid = Arc::new(Grid { plan: plan.clone(), cells, shares, entropies });
        let mut quest = Self { grid, posterior: Vec::new(), levels: Vec::new(), place: 0 };
        quest.restart();
        Ok(quest)
    }

    /// Forgets every answer.
    pub fn restart(&mut self) {
        self.levels.clear();
        let n = self.grid.cells.len();
        self.posterior = vec![1.0 / n as f64; n];
        self.place = most_telling(&self.posterior, &self.grid.shares, &self.grid.entropies);
    }

    /// The next level, in the unit of the stimulus.
    pub fn next_level(&self) -> f64 {
        self.grid.plan.levels[self.place]
    }

    /// The place of a level among those of the plan; `None` for one that is not of it.
    pub fn place_of(&self, level: f64) -> Option<usize> {
        self.grid.plan.levels.iter().position(|own| (own - level).abs() * PARTS < 0.5)
    }

    /// Takes an answer to the level at that place: another one than the next where an answer before it does not count any
    /// more.
    ///
    /// # Errors
    /// A place that the plan does not have, an answer that no curve of the grid makes possible.
    pub fn answer(&mut self, place: usize, is_positive: bool) -> Result<(), StatsError> {
        let shares = self.grid.shares.get(place).ok_or(StatsError::QuestGrid)?;
        for (mass, [share, rest]) in self.posterior.iter_mut().zip(shares) {
            *mass *= if is_positive { share } else { rest };
        }
        let whole: f64 = self.posterior.iter().sum();
        if whole <= 0.0 {
            return Err(StatsError::Impossible { trial: self.levels.len() });
        }
        self.posterior.iter_mut().for_each(|mass| *mass /= whole);
        self.levels.push(self.grid.plan.levels[place]);
        self.place = most_telling(&self.posterior, &self.grid.shares, &self.grid.entropies);
        Ok(())
    }

    /// What the answers tell so far.
    pub fn track(&self) -> Track {
        let Means { threshold, scale, lapse, is_at_edge } =
            means(&self.grid.plan, &self.grid.cells, &self.posterior);
        Track {
            levels: self.levels.clone(),
            next: self.next_level(),
            threshold,
            scale,
            lapse,
            entropy: self.posterior.iter().map(|mass| information(*mass)).sum(),
            is_at_edge,
        }
    }
}

/// What answers tell on the grid of a plan, whichever way their levels were chosen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posterior {
    /// The threshold, in the unit of the stimulus.
    pub threshold: Marginal,
    /// Its posterior standard deviation.
    pub threshold_sd: f64,
    /// Posterior mean of σ.
    pub scale: f64,
    /// The JND, in the unit of the stimulus.
    pub jnd: Marginal,
    /// Posterior standard deviation of ln JND.
    pub ln_jnd_sd: f64,
    /// Posterior mean of λ.
    pub lapse: f64,
    /// As [`Track::is_at_edge`].
    pub is_at_edge: bool,
}

impl Posterior {
    /// The curve of the posterior means.
    pub fn curve(&self, plan: &Plan) -> Curve {
        let Self { threshold, scale, lapse, .. } = *self;
        Cell { threshold: threshold.mean, scale, lapse }.curve(plan)
    }
}

/// The posterior of answers at any levels, in any order, with intervals at `confidence`.
///
/// # Errors
/// Those of [`track`], levels that are not finite, more positive answers than trials, `confidence` outside (0, 1).
pub fn posterior(
    plan: &Plan,
    answers: &[LevelAnswers],
    confidence: f64,
) -> Result<Posterior, StatsError> {
    check(plan)?;
    check_level(confidence)?;
    let answers = by_level(answers)?;
    let cells = cells(plan);
    let mut posterior = vec![1.0 / cells.len() as f64; cells.len()];
    let mut trial = 0;
    for LevelAnswers { level, trials, positive } in answers {
        if plan.sigmoid == Sigmoid::Weibull && level < 0.0 {
            return Err(StatsError::BelowZero { level });
        }
        let shares: Vec<[f64; 2]> =
            cells.iter().map(|cell| cell.curve(plan).shares(level)).collect();
        for number in 0..trials {
            let answer = usize::from(number >= positive);
            for (mass, shares) in posterior.iter_mut().zip(&shares) {
                *mass *= shares[answer];
            }
            let whole: f64 = posterior.iter().sum();
            if whole <= 0.0 {
                return Err(StatsError::Impossible { trial });
            }
            posterior.iter_mut().for_each(|mass| *mass /= whole);
            trial += 1;
        }
    }
    let of = |read: &dyn Fn(&Cell) -> f64| {
        let values = cells.iter().zip(&posterior).map(|(cell, mass)| [read(cell), *mass]);
        let values: Vec<[f64; 2]> = values.collect();
        let mean: f64 = values.iter().map(|[value, mass]| value * mass).sum();
        let square: f64 = values.iter().map(|[value, mass]| mass * (value - mean).powi(2)).sum();
        (marginal(values, confidence), square.sqrt())
    };
    let (threshold, threshold_sd) = of(&|cell| cell.threshold);
    let jnd = |cell: &Cell| cell.curve(plan).jnd();
    let Means { scale, lapse, is_at_edge, .. } = means(plan, &cells, &posterior);
    Ok(Posterior {
        threshold,
        threshold_sd,
        scale,
        jnd: of(&jnd).0,
        ln_jnd_sd: of(&|cell| libm::log(jnd(cell))).1,
        lapse,
        is_at_edge,
    })
}

/// The curves of the grid.
fn cells(plan: &Plan) -> Vec<Cell> {
    let mut cells = Vec::new();
    for threshold in &plan.thresholds {
        for scale in &plan.scales {
            for lapse in &plan.lapses {
                cells.push(Cell { threshold: *threshold, scale: *scale, lapse: *lapse });
            }
        }
    }
    cells
}

/// The means of a posterior, and whether an end of its grid has much of it.
struct Means {
    threshold: f64,
    scale: f64,
    lapse: f64,
    is_at_edge: bool,
}

fn means(plan: &Plan, cells: &[Cell], posterior: &[f64]) -> Means {
    let mean = |read: fn(&Cell) -> f64| -> f64 {
        cells.iter().zip(posterior).map(|(cell, mass)| mass * read(cell)).sum()
    };
    let mass_at = |read: fn(&Cell) -> f64, value: f64| -> f64 {
        let with_value = |cell: &Cell| read(cell).total_cmp(&value).is_eq();
        let masses = cells.iter().zip(posterior).filter(|(cell, _)| with_value(cell));
        masses.map(|(_, mass)| mass).sum()
    };
    let is_at_end = |axis: &[f64], read: fn(&Cell) -> f64| match axis {
        [first, .., last] => {
            // A little more than the prior, which rounding may leave.
            let most = EDGE.max((1.0 + EQUAL) / axis.len() as f64);
            mass_at(read, *first) > most || mass_at(read, *last) > most
        }
        _ => false, // one value is known, and has no end
    };
    Means {
        threshold: mean(|cell| cell.threshold),
        scale: mean(|cell| cell.scale),
        lapse: mean(|cell| cell.lapse),
        is_at_edge: is_at_end(&plan.thresholds, |cell| cell.threshold)
            || is_at_end(&plan.scales, |cell| cell.scale),
    }
}

#[derive(Debug, Clone, PartialEq)]
struct Cell {
    threshold: f64,
    scale: f64,
    lapse: f64,
}

impl Cell {
    fn curve(&self, plan: &Plan) -> Curve {
        let sigmoid = plan.sigmoid;
        let location = sigmoid.coordinate(self.threshold) - self.scale * sigmoid.middle();
        let guess = if plan.asks == Asks::RightOrWrong { 0.5 } else { self.lapse };
        Curve { sigmoid, location, scale: self.scale, guess, lapse: self.lapse }
    }
}

/// −p ln p, 0 at 0.
fn information(p: f64) -> f64 {
    if p > 0.0 { -p * libm::log(p) } else { 0.0 }
}

/// h(ψ) of an answer, by ψ and 1 − ψ.
fn entropy([share, rest]: [f64; 2]) -> f64 {
    information(share) + information(rest)
}

/// The place of the level whose answer tells most, the lowest of equal ones.
fn most_telling(posterior: &[f64], shares: &[Vec<[f64; 2]>], entropies: &[Vec<f64>]) -> usize {
    let mut best = 0;
    let mut most = f64::NEG_INFINITY;
    for (place, (shares, entropies)) in shares.iter().zip(entropies).enumerate() {
        let mut mean = [0.0; 2];
        let mut left = 0.0;
        for ((mass, [share, rest]), entropy) in posterior.iter().zip(shares).zip(entropies) {
            mean[0] += mass * share;
            mean[1] += mass * rest;
            left += mass * entropy;
        }
        let information = entropy(mean) - left;
        if information > most + EQUAL {
            best = place;
            most = information;
        }
    }
    best
}

fn check(plan: &Plan) -> Result<(), StatsError> {
    for axis in [&plan.levels, &plan.thresholds, &plan.scales, &plan.lapses] {
        all_finite(axis)?;
        if axis.is_empty() || axis.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(StatsError::QuestGrid);
        }
    }
    let Plan { levels, thresholds, scales, lapses, .. } = plan;
    let has_no_logarithm =
        plan.sigmoid == Sigmoid::Weibull && (levels[0] < 0.0 || thresholds[0] <= 0.0);
    let has_wrong_lapse = lapses.iter().any(|lapse| !(0.0..0.5).contains(lapse));
    if has_no_logarithm || scales[0] <= 0.0 || has_wrong_lapse || plan.asks == Asks::YesNo {
        return Err(StatsError::QuestGrid);
    }
    let cells = thresholds.len().saturating_mul(scales.len()).saturating_mul(lapses.len());
    if cells.saturating_mul(levels.len()) > MOST_SHARES {
        return Err(StatsError::QuestSize { cells, levels: levels.len(), most: MOST_SHARES });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::psychometric::tests::scattered;

    fn plan() -> Plan {
        Plan {
            asks: Asks::WhichWasMore,
            sigmoid: Sigmoid::Norm,
            levels: (0..19).map(|i| 210.0 + 10.0 * f64::from(i)).collect(),
            thresholds: (0..25).map(|i| 240.0 + 5.0 * f64::from(i)).collect(),
            scales: vec![10.0, 15.0, 20.0, 30.0, 40.0, 60.0, 80.0],
            lapses: vec![0.02],
        }
    }

    /// The package questplus 2023.1 and a version written in NumPy from the paper.
    #[test]
    fn forty_trials_are_those_of_questplus() {
        let levels = [
            300, 320, 290, 320, 290, 270, 260, 310, 320, 270, 320, 250, 250, 330, 240, 240, 330,
            240, 340, 240, 340, 240, 330, 240, 330, 240, 330, 340, 240, 340, 350, 350, 240, 350,
            360, 250, 360, 250, 350, 250,
        ];
        let mut answers = Vec::new();
        for (t, expected) in levels.into_iter().enumerate() {
            let level = track(&plan(), &answers).unwrap().next;
            assert!((level - f64::from(expected)).abs() < 1e-9, "trial {t}: {level}");
            let z = (level - 292.0) / 40.0;
            let share = 0.02 + 0.96 * 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
            answers.push(scattered([500, t as u64 + 1, 0, 0]) + 0.5 < share);
        }
        let found = track(&plan(), &answers).unwrap();
        assert!((found.threshold - 300.846638).abs() < 3e-4, "{found:?}");
        assert!((found.scale - 50.8100880).abs() < 5e-5, "{found:?}");
        assert!((found.entropy - 3.60291002).abs() < 4e-6, "{found:?}");
        assert_eq!(found.levels, levels.map(f64::from));
        assert!((found.lapse - 0.02).abs() < 1e-12);
        // σ = 80 has more of the posterior than its seventh of the prior, which alone is no sign.
        assert!(found.is_at_edge && !track(&plan(), &[]).unwrap().is_at_edge);
    }

    /// By the definition: the entropy of both posteriors that an answer can lead to, weighted by its chance.
    #[test]
    fn the_next_level_has_the_least_expected_entropy() {
        let plan = Plan {
            asks: Asks::RightOrWrong,
            sigmoid: Sigmoid::Weibull,
            levels: (1..15).map(f64::from).collect(),
            thresholds: vec![2.0, 4.0, 6.0, 8.0, 11.0],
            scales: vec![0.2, 0.5, 1.0],
            lapses: vec![0.0, 0.03],
        };
        let mut answers = Vec::new();
        for _ in 0..12 {
            let shown = track(&plan, &answers).unwrap();
            let mut cells: Vec<(Curve, f64)> = Vec::new();
            for threshold in &plan.thresholds {
                for scale in &plan.scales {
                    for lapse in &plan.lapses {
                        let cell = Cell { threshold: *threshold, scale: *scale, lapse: *lapse };
                        let curve = cell.curve(&plan);
                        let likelihood =
                            shown.levels.iter().zip(&answers).map(|(level, is_right)| {
                                let share = curve.share(*level);
                                if *is_right { share } else { 1.0 - share }
                            });
                        cells.push((curve, likelihood.product()));
                    }
                }
            }
            let expected = |level: f64| -> f64 {
                let of = |is_right: bool| {
                    let masses: Vec<f64> = cells
                        .iter()
                        .map(|(curve, mass)| {
                            let share = curve.share(level);
                            mass * if is_right { share } else { 1.0 - share }
                        })
                        .collect();
                    let whole: f64 = masses.iter().sum();
                    whole * masses.iter().map(|mass| information(mass / whole)).sum::<f64>()
                };
                of(true) + of(false)
            };
            let least = plan.levels.iter().map(|level| expected(*level)).fold(f64::MAX, f64::min);
            assert!(expected(shown.next) <= least * (1.0 + 1e-10), "{shown:?}");
            answers.push(answers.len() % 3 != 1);
        }
    }

    #[test]
    fn answer_by_answer_it_is_the_same_to_the_bit_and_starts_again_from_nothing() {
        let mut quest = Quest::new(&plan()).unwrap();
        let mut answers = Vec::new();
        for t in 0..12 {
            assert_eq!(quest.track(), track(&plan(), &answers).unwrap());
            let is_positive = t % 3 != 1;
            let place = quest.place_of(quest.next_level()).unwrap();
            quest.answer(place, is_positive).unwrap();
            answers.push(is_positive);
        }
        quest.restart();
        assert_eq!(quest.track(), track(&plan(), &[]).unwrap());
        // At another level than the next: the posterior is that of this level.
        let [low, high] = [210.0, 390.0].map(|level| quest.place_of(level).unwrap());
        quest.answer(low, false).unwrap();
        let told_little = quest.track().entropy;
        quest.restart();
        quest.answer(high, false).unwrap();
        assert!(quest.track().entropy < told_little && quest.track().levels == [390.0]);
        assert!(quest.place_of(211.0).is_none() && quest.answer(99, true).is_err());
    }

    #[test]
    fn equal_levels_are_decided_for_the_lowest() {
        // Around the only threshold everything is symmetrical, and 299 tells as much as 301.
        let plan =
            Plan { levels: vec![290.0, 299.0, 301.0, 310.0], thresholds: vec![300.0], ..plan() };
        let next = track(&plan, &[]).unwrap().next;
        assert!(next < 300.0, "{next}");
    }

    #[test]
    fn a_truth_beyond_the_grid_is_noticed_and_one_within_it_is_not() {
        let session = |truth: f64| {
            let mut answers = Vec::new();
            for t in 0..120_u64 {
                let level = track(&plan(), &answers).unwrap().next;
                let z = (level - truth) / 22.0;
                let share = 0.02 + 0.96 * 0.5 * libm::erfc(-z * core::f64::consts::FRAC_1_SQRT_2);
                answers.push(scattered([7, t, 3, 0]) + 0.5 < share);
            }
            track(&plan(), &answers).unwrap()
        };
        assert!(session(400.0).is_at_edge);
        let within = session(300.0);
        assert!(!within.is_at_edge && (within.threshold - 300.0).abs() < 12.0, "{within:?}");
    }

    #[test]
    fn impossible_grids_and_answers_are_refused() {
        for broken in [
            Plan { levels: vec![], ..plan() },
            Plan { thresholds: vec![2.0, 1.0], ..plan() },
            Plan { scales: vec![0.0, 1.0], ..plan() },
            Plan { lapses: vec![0.5], ..plan() },
            Plan { asks: Asks::YesNo, ..plan() },
            Plan { sigmoid: Sigmoid::Weibull, levels: vec![-1.0, 1.0], ..plan() },
            Plan { sigmoid: Sigmoid::Weibull, thresholds: vec![0.0, 1.0], ..plan() },
        ] {
            assert_eq!(track(&broken, &[]), Err(StatsError::QuestGrid));
        }
        assert!(track(&Plan { levels: vec![f64::NAN], ..plan() }, &[]).is_err());
        let many = |n: usize| (0..n).map(|i| i as f64).collect::<Vec<f64>>();
        let large =
            Plan { levels: many(1000), thresholds: many(1000), scales: vec![1.0, 2.0], ..plan() };
        let large = Plan { lapses: vec![0.0, 0.01, 0.02, 0.03, 0.04, 0.05], ..large };
        let refused = StatsError::QuestSize { cells: 12_000, levels: 1000, most: MOST_SHARES };
        assert_eq!(track(&large, &[]), Err(refused));
        // Without lapses both answers keep their chances far out: ψ rounds to 1 there, and 1 − ψ to no 0.
        let far = Plan {
            levels: vec![10.0],
            thresholds: vec![0.0, 2.0],
            scales: vec![1.0],
            lapses: vec![0.0],
            ..plan()
        };
        let missed = track(&far, &[false]).unwrap();
        assert!((missed.threshold - 2.0).abs() < 1e-6, "{missed:?}");
        let certain = Plan {
            levels: vec![0.0],
            thresholds: vec![100.0],
            scales: vec![1.0],
            lapses: vec![0.0],
            ..plan()
        };
        assert_eq!(track(&certain, &[false, true]), Err(StatsError::Impossible { trial: 1 }));
    }

    #[test]
    fn the_posterior_of_answers_is_that_of_their_track_in_any_order() {
        let plan = plan();
        let answers: Vec<bool> = (0..40).map(|trial| scattered([3, trial, 1, 0]) > 0.0).collect();
        let tracked = track(&plan, &answers).unwrap();
        let tallied: Vec<LevelAnswers> = tracked
            .levels
            .iter()
            .zip(&answers)
            .rev()
            .map(|(level, is_positive)| LevelAnswers {
                level: *level,
                trials: 1,
                positive: u64::from(*is_positive),
            })
            .collect();
        let found = posterior(&plan, &tallied, 0.95).unwrap();
        let pairs = [
            (found.threshold.mean, tracked.threshold),
            (found.scale, tracked.scale),
            (found.lapse, tracked.lapse),
        ];
        for (found, expected) in pairs {
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
        }
        assert_eq!(found.is_at_edge, tracked.is_at_edge);
        // Answers leave less doubt than there was before the first.
        let before = posterior(&plan, &[], 0.95).unwrap();
        assert!(found.threshold_sd < before.threshold_sd && found.threshold_sd > 0.0);
        assert!(found.ln_jnd_sd > 0.0);
        assert!((found.curve(&plan).threshold() - found.threshold.mean).abs() < 1e-9);
        // The interval holds the mean and, of a half, half of what the other holds.
        let half = posterior(&plan, &tallied, 0.5).unwrap();
        for (wide, narrow) in [(found.threshold, half.threshold), (found.jnd, half.jnd)] {
            let ends = [wide.ci_low, narrow.ci_low, wide.mean, narrow.ci_high, wide.ci_high];
            assert!(ends.is_sorted() && wide.ci_low < narrow.ci_low, "{ends:?}");
        }
        assert!(posterior(&plan, &tallied, 95.0).is_err());
    }
}
