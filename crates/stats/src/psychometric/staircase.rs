//! Staircases: the next level follows from the answers before it, and the threshold is a mean of reversals.
//!
//! A staircase with n up and m down goes up after n wrong answers in a row, and down after m right ones (Levitt 1971,
//! J. Acoust. Soc. Am. 49:467). In `1up2down` n is 1. It settles where steps up and down balance. With equal steps it
//! does so slowly, and elsewhere than tables say (García-Pérez 1998, Vision Research 38:1861); with down/up of
//! [`DOWN_OVER_UP`] it settles near [`target`]. The weighted staircase (Kaernbach 1991, Perception & Psychophysics 49:227)
//! has one answer each way, and steps of the ratio that makes any share its target ([`weighted`]).

use super::{AnsweredLevel, PARTS};
use crate::error::{StatsError, all_finite};
use zwidth_numerics::roots;

/// The ratio of steps down and up of one up, and 1 to 4 down, by García-Pérez (1998).
pub const DOWN_OVER_UP: [f64; 4] = [0.2845, 0.5488, 0.7393, 0.8415];
/// Shares are found to this.
const RESOLUTION: f64 = 1e-14;

/// What steps are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Numbers in the unit of the stimulus, added; the threshold is an arithmetic mean.
    Linear,
    /// ln of factors; the threshold is a geometric mean.
    Logarithmic,
}

/// The plan of a staircase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Staircase {
    /// Wrong answers in a row before a step up.
    pub up_after: usize,
    /// Right answers in a row before a step down.
    pub down_after: usize,
    /// What `up` and `down` are.
    pub scale: Scale,
    /// The step up: in the unit of the stimulus, or ln of the factor.
    pub up: f64,
    /// The step down, as `up`.
    pub down: f64,
    /// The first level, in the unit of the stimulus; a multiple of 1e-6.
    pub start: f64,
    /// The lowest and the highest level; multiples of 1e-6.
    pub bounds: [f64; 2],
    /// Reversals after which it ends.
    pub reversals: usize,
    /// Trials after which it ends without so many reversals: a person who is always right has none.
    pub most_trials: usize,
    /// Reversals, the last ones, of which the threshold is the mean.
    pub of_last: usize,
}

/// A staircase after some answers.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// The level of each answered trial, in the unit of the stimulus.
    pub levels: Vec<f64>,
    /// The next level; `None` when it has ended.
    pub next: Option<f64>,
    /// The levels at which it turned.
    pub reversals: Vec<f64>,
    /// The mean of the last reversals, when it has ended by reversals; not by its trials.
    pub threshold: Option<f64>,
    /// Whether the level after the last answer, or one of the last reversals, is a bound: the threshold may lie beyond.
    pub is_at_bound: bool,
}

/// The levels of a staircase by its plan and the answers so far, right or wrong; answers after its end are refused, so
/// that a record of another plan is noticed. A step that a bound cuts short counts as one in its direction.
///
/// # Errors
/// A plan without answers, steps, reversals or trials, levels beyond its bounds or no multiples of 1e-6, levels not above
/// 0 on a logarithmic scale, more answers than it takes.
pub fn track(plan: &Staircase, answers: &[bool]) -> Result<Track, StatsError> {
    check(plan)?;
    walk(plan, answers.iter().map(|is_right| (None, *is_right)))
}

/// The same by the levels at which the answers were given. A step goes on from the level that was presented: from another
/// one than the staircase asked for where a device gave the nearest that it can, or where an answer before it does not
/// count any more.
///
/// # Errors
/// As [`track`], levels that are not finite.
pub fn track_presented(plan: &Staircase, answers: &[AnsweredLevel]) -> Result<Track, StatsError> {
    check(plan)?;
    let levels: Vec<f64> = answers.iter().map(|answer| answer.level).collect();
    all_finite(&levels)?;
    walk(plan, answers.iter().map(|answer| (Some(answer.level), answer.is_positive)))
}

/// Each answer with the level that was presented, where that is known; else it is the one that was asked for.
fn walk(
    plan: &Staircase,
    answers: impl ExactSizeIterator<Item = (Option<f64>, bool)>,
) -> Result<Track, StatsError> {
    let [lowest, highest] = plan.bounds;
    // Not rounded, so that rounding does not add up over steps.
    let mut place = plan.start;
    let all = answers.len();
    let mut levels = Vec::with_capacity(all);
    let mut reversals = Vec::new();
    let mut in_a_row = 0;
    let mut last_answer = None;
    let mut last_step_is_up = None;
    for (presented, is_right) in answers {
        if reversals.len() == plan.reversals || levels.len() == plan.most_trials {
            return Err(StatsError::StaircaseEnded { trials: levels.len(), answers: all });
        }
        if let Some(level) =
            presented.filter(|level| shown(*level).total_cmp(&shown(place)).is_ne())
        {
            place = level;
        }
        levels.push(shown(place));
        in_a_row = if last_answer == Some(is_right) { in_a_row + 1 } else { 1 };
        last_answer = Some(is_right);
        if in_a_row < if is_right { plan.down_after } else { plan.up_after } {
            continue;
        }
        in_a_row = 0;
        if last_step_is_up == Some(is_right) {
            reversals.push(shown(place));
        }
        last_step_is_up = Some(!is_right);
        let step = if is_right { -plan.down } else { plan.up };
        let next = match plan.scale {
            Scale::Linear => place + step,
            Scale::Logarithmic => place * libm::exp(step),
        };
        place = next.clamp(lowest, highest);
    }
    let has_reversals = reversals.len() == plan.reversals;
    let has_ended = has_reversals || levels.len() == plan.most_trials;
    let last = &reversals[reversals.len().saturating_sub(plan.of_last)..];
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / last.len() as f64;
    let threshold = has_reversals.then(|| match plan.scale {
        Scale::Linear => mean(&mut last.iter().copied()),
        Scale::Logarithmic => libm::exp(mean(&mut last.iter().map(|level| libm::log(*level)))),
    });
    let is_bound = |level: f64| level <= lowest || level >= highest;
    let is_at_bound = is_bound(place) || last.iter().any(|level| is_bound(*level));
    let next = (!has_ended).then(|| shown(place));
    Ok(Track { levels, next, threshold, is_at_bound, reversals })
}

/// The level that stands for a place: the nearest whole number of parts, so that a record of it is exact.
fn shown(place: f64) -> f64 {
    (place * PARTS).round() / PARTS
}

fn check(plan: &Staircase) -> Result<(), StatsError> {
    let Staircase { up, down, start, bounds: [lowest, highest], .. } = *plan;
    all_finite(&[up, down, start, lowest, highest])?;
    let counts = [plan.up_after, plan.down_after, plan.reversals, plan.most_trials, plan.of_last];
    let has_numbers = counts.iter().all(|count| *count > 0) && up > 0.0 && down > 0.0;
    let is_positive = plan.scale == Scale::Linear || lowest > 0.0;
    let is_within = lowest <= start && start <= highest && lowest < highest;
    let are_shown = [start, lowest, highest].iter().all(|at| shown(*at).total_cmp(at).is_eq());
    if has_numbers && is_positive && is_within && are_shown && plan.of_last <= plan.reversals {
        Ok(())
    } else {
        Err(StatsError::Staircase)
    }
}

/// The share of right answers at which steps up and down balance: P(down) down = P(up) up, where P(down) is the chance
/// that `down_after` right answers in a row come before `up_after` wrong ones (Feller 1968, *An Introduction to
/// Probability Theory*, XIII.8). With one up it is (1/(1 + down/up))^(1/m): García-Pérez' 77.85, 80.35, 83.15 and 85.84 %
/// of 1 to 4 down. Real staircases settle within 1 % of it.
///
/// # Errors
/// No answers, steps that are not positive numbers.
pub fn target(up_after: usize, down_after: usize, down_over_up: f64) -> Result<f64, StatsError> {
    all_finite(&[down_over_up])?;
    if up_after == 0 || down_after == 0 || down_over_up <= 0.0 {
        return Err(StatsError::Staircase);
    }
    let [n, m] = [up_after, down_after].map(|count| count as f64);
    let balance = |p: f64| {
        let q = 1.0 - p;
        let right = libm::pow(p, m - 1.0);
        let wrong = libm::pow(q, n - 1.0);
        let both = right + wrong - right * wrong;
        let down = right * (1.0 - libm::pow(q, n)) / both;
        down * down_over_up - (1.0 - down)
    };
    Ok(roots::bracketed(balance, 0.0, 1.0, RESOLUTION))
}

/// The ratio of steps down and up of a weighted staircase with this target: (1 − p)/p.
///
/// # Errors
/// A target outside (0, 1).
pub fn weighted(target: f64) -> Result<f64, StatsError> {
    if target > 0.0 && target < 1.0 {
        Ok((1.0 - target) / target)
    } else {
        Err(StatsError::Probability { index: 0, value: target })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bootstrap::{stream, uniform};
    use crate::psychometric::tests::scattered;

    fn forces(down_after: usize, ratio: f64) -> Staircase {
        let up = libm::log(1.25);
        Staircase {
            up_after: 1,
            down_after,
            scale: Scale::Logarithmic,
            up,
            down: up * ratio,
            start: 0.24,
            bounds: [0.01, 0.5],
            reversals: 12,
            most_trials: 120,
            of_last: 8,
        }
    }

    /// Answers of a person whose threshold is 0.08 N, by numbers that a formula gives.
    fn answered(plan: &Staircase) -> (Track, String) {
        let mut answers = Vec::new();
        loop {
            let track = track(plan, &answers).unwrap();
            let Some(level) = track.next else {
                let signs = answers.iter().map(|is_right| if *is_right { '1' } else { '0' });
                return (track, signs.collect());
            };
            let share = 0.5 + 0.48 * (1.0 - libm::exp(-(level / 0.08) * (level / 0.08)));
            answers.push(scattered([600, answers.len() as u64 + 1, 0, 0]) + 0.5 < share);
        }
    }

    /// The same staircases written in NumPy from the definitions.
    #[test]
    fn levels_and_thresholds_are_those_of_numpy() {
        let (two_down, answers) = answered(&forces(2, DOWN_OVER_UP[1]));
        assert_eq!(answers, "11111111111111111110111101101111011111110111111011");
        let reversals = [
            0.079717, 0.099647, 0.078, 0.0975, 0.086262, 0.107828, 0.084404, 0.105505, 0.073067,
            0.091333, 0.063252, 0.079065,
        ];
        for (found, expected) in two_down.reversals.iter().zip(reversals) {
            assert!((found - expected).abs() < 1.1e-6, "{found} {expected}");
        }
        assert!((two_down.threshold.unwrap() - 0.08515299).abs() < 1e-6, "{two_down:?}");
        assert_eq!((two_down.levels.len(), two_down.reversals.len()), (50, 12));
        let (weighted, answers) = answered(&forces(1, weighted(0.75).unwrap()));
        assert_eq!(answers, "11111111111111101110111001101111111111110101");
        assert!((weighted.threshold.unwrap() - 0.08393181).abs() < 1e-6, "{weighted:?}");
    }

    /// A device that gives whole hundredths: each step goes on from what it gave, and no error adds up.
    #[test]
    fn a_step_goes_on_from_the_level_that_was_presented() {
        let plan = Staircase {
            scale: Scale::Linear,
            up: 0.014,
            down: 0.014,
            down_after: 1,
            start: 0.2,
            ..forces(1, 1.0)
        };
        let answers = [true, true, false, true, false, false];
        let mut given: Vec<AnsweredLevel> = Vec::new();
        for is_positive in answers {
            let asked = track_presented(&plan, &given).unwrap().next.unwrap();
            given.push(AnsweredLevel { level: (asked * 100.0).round() / 100.0, is_positive });
        }
        let levels: Vec<f64> = given.iter().map(|answer| answer.level).collect();
        assert_eq!(levels, [0.2, 0.19, 0.18, 0.19, 0.18, 0.19]);
        let found = track_presented(&plan, &given).unwrap();
        assert_eq!((found.levels, found.reversals), (levels, vec![0.18, 0.19, 0.18]));
        assert_eq!(found.next, Some(0.204));
        // At the levels that were asked for it is the same as without them, to the bit.
        let asked = track(&plan, &answers).unwrap();
        let at = |(level, is_positive): (&f64, &bool)| AnsweredLevel {
            level: *level,
            is_positive: *is_positive,
        };
        let same: Vec<AnsweredLevel> = asked.levels.iter().zip(&answers).map(at).collect();
        assert_eq!(track_presented(&plan, &same).unwrap(), asked);
        assert!(
            track_presented(&plan, &[AnsweredLevel { level: f64::NAN, is_positive: true }])
                .is_err()
        );
    }

    /// García-Pérez (1998), table 1, and Levitt (1971) for equal steps.
    #[test]
    fn targets_are_those_of_the_literature() {
        for (m, share) in (1..).zip([77.85, 80.35, 83.15, 85.84]) {
            let found = target(1, m, DOWN_OVER_UP[m - 1]).unwrap();
            assert!((100.0 * found - share).abs() < 0.006, "{m}: {found}");
        }
        for (n, m, share) in [(1, 2, 70.71), (1, 3, 79.37), (2, 1, 29.29), (1, 1, 50.0)] {
            let found = target(n, m, 1.0).unwrap();
            assert!((100.0 * found - share).abs() < 0.006, "{n} {m}: {found}");
        }
        assert!((target(1, 1, weighted(0.75).unwrap()).unwrap() - 0.75).abs() < 1e-12);
        assert!(weighted(1.0).is_err() && target(0, 1, 1.0).is_err());
    }

    /// Two up, three down, with a chance that does not depend on the level: as many steps go each way as the balance says.
    #[test]
    fn at_its_target_a_staircase_goes_nowhere() {
        let plan = Staircase {
            up_after: 2,
            scale: Scale::Linear,
            start: 0.0,
            bounds: [-1e9, 1e9],
            reversals: usize::MAX,
            most_trials: usize::MAX,
            up: 1.0,
            down: 0.7,
            ..forces(3, 1.0)
        };
        let p = target(2, 3, 0.7).unwrap();
        let mut rng = stream(5, 0);
        let answers: Vec<bool> = (0..200_000).map(|_| uniform(&mut rng) < p).collect();
        let last = track(&plan, &answers).unwrap().next.unwrap();
        // A random walk of some 50,000 steps of about 1 has a standard deviation of about 200.
        assert!(last.abs() < 700.0, "{last}");
        let easier: Vec<bool> = (0..200_000).map(|_| uniform(&mut rng) < p + 0.02).collect();
        assert!(track(&plan, &easier).unwrap().next.unwrap() < -1000.0);
    }

    #[test]
    fn bounds_hold_and_impossible_plans_are_refused() {
        let plan = forces(2, 1.0);
        let low = track(&plan, &[true; 100]).unwrap();
        assert_eq!((low.next, low.threshold, low.is_at_bound), (Some(0.01), None, true));
        let high = track(&plan, &[false; 9]).unwrap();
        assert_eq!((high.next, high.reversals.len(), high.is_at_bound), (Some(0.5), 0, true));
        // Who is always right turns nowhere, and is done after the last trial.
        let always = track(&plan, &[true; 120]).unwrap();
        assert_eq!((always.next, always.threshold, always.is_at_bound), (None, None, true));
        let ended = StatsError::StaircaseEnded { trials: 120, answers: 121 };
        assert_eq!(track(&plan, &[true; 121]), Err(ended));
        // Who is held at a bound turns there, and has a threshold that says so.
        let mut answers: Vec<bool> = vec![true; 40];
        while track(&plan, &answers).unwrap().next.is_some() {
            answers.push(!answers.len().is_multiple_of(7));
        }
        let held = track(&plan, &answers).unwrap();
        assert!(held.is_at_bound && held.threshold.unwrap() < 0.0125, "{held:?}");
        assert!(!answered(&plan).0.is_at_bound);
        for broken in [
            Staircase { up: 0.0, ..plan },
            Staircase { down_after: 0, ..plan },
            Staircase { bounds: [-1.0, 0.5], ..plan },
            Staircase { start: 0.6, ..plan },
            Staircase { of_last: 13, ..plan },
            Staircase { most_trials: 0, ..plan },
            Staircase { start: 0.240_000_4, ..plan },
            Staircase { bounds: [1.0 / 300.0, 0.5], ..plan },
            Staircase { bounds: [0.01, 1.0 / 3.0], ..plan },
        ] {
            assert_eq!(track(&broken, &[]), Err(StatsError::Staircase));
        }
        let mut answers: Vec<bool> = Vec::new();
        while track(&plan, &answers).unwrap().next.is_some() {
            let is_right = answers.len() % 3 < 2;
            answers.push(is_right);
        }
        let trials = answers.len();
        answers.push(true);
        let ended = StatsError::StaircaseEnded { trials, answers: trials + 1 };
        assert_eq!(track(&plan, &answers), Err(ended));
    }
}
