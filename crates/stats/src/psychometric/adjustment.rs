//! Adjustment: the person sets the level until it feels equal to the standard, several times.
//!
//! Settings are drawn from the psychometric function of "which was more" as from a distribution: its median is the PSE, and
//! half of them lie within one JND of it (the probable error; Gescheider 1997, *Psychophysics: The Fundamentals*, 3rd ed.,
//! chapter 3). Of normal settings PSE = mean and JND = 0.6745 SD.

use super::PARTS;
use super::curve::NORMAL_QUARTILE;
use crate::error::{StatsError, all_finite};
use crate::interval::{self, Estimate};
use crate::reference::chi_square_quantile;
use crate::tested::Unestimable;

/// What the settings of one person tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adjusted {
    /// The PSE with its t interval, in the unit of the stimulus.
    pub threshold: Estimate,
    /// The JND, in the unit of the stimulus; 0 of settings that are all equal.
    pub jnd: f64,
    /// Its interval, that of the standard deviation of normal settings: (n − 1) s²/σ² is χ² with n − 1 degrees of freedom.
    pub jnd_interval: [f64; 2],
    /// Standard error of ln JND, 1/√(2 (n − 1)).
    pub ln_jnd_error: f64,
}

/// PSE and JND of `settings`, the interval at `confidence`.
///
/// # Errors
/// Fewer than two settings, one that is not finite, `confidence` outside (0, 1).
pub fn adjustment(settings: &[f64], confidence: f64) -> Result<Adjusted, Unestimable> {
    let mean = interval::mean(settings, confidence)?;
    match (mean.interval, mean.sd) {
        (Some(threshold), Some(sd)) => {
            let jnd = NORMAL_QUARTILE * sd;
            let df = threshold.df;
            let tail = (1.0 - confidence) / 2.0;
            let most = chi_square_quantile(1.0 - tail, df)?;
            let least = chi_square_quantile(tail, df)?;
            let jnd_interval = [most, least].map(|end| jnd * (df / end).sqrt());
            Ok(Adjusted { threshold, jnd, jnd_interval, ln_jnd_error: (0.5 / df).sqrt() })
        }
        _ => Err(Unestimable::TooFew { units: "settings", found: settings.len(), needed: 2 }),
    }
}

/// How levels are set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// The level at which every other setting starts, from the first on, and that of those between.
    pub starts: [f64; 2],
    /// From a level to the next, in the unit of the stimulus.
    pub step: f64,
    /// The lowest and the highest level.
    pub bounds: [f64; 2],
    /// Settings, each of which ends with a level that is right.
    pub settings: usize,
}

/// What a person wants of a level that was presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wish {
    /// A higher one.
    More,
    /// A lower one.
    Less,
    /// It is right: the setting ends.
    Right,
}

/// A wish, and the level that was presented before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wished {
    /// The level, in the unit of the stimulus.
    pub level: f64,
    /// What the person wants of it.
    pub wish: Wish,
}

/// The settings after some wishes.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// The next level; `None` after the last setting.
    pub next: Option<f64>,
    /// The levels that were right.
    pub levels: Vec<f64>,
    /// Whether one of them is a bound, or more was asked for than a bound allows: what is right may lie beyond.
    pub is_at_bound: bool,
}

/// The settings by their plan and the wishes so far; those after the last setting are refused. Each step goes on from the
/// level that was presented.
///
/// # Errors
/// A plan without settings or a step, starts beyond the bounds, numbers that are not finite, more wishes than it takes.
pub fn settings(plan: &Plan, wishes: &[Wished]) -> Result<Settings, StatsError> {
    let Plan { starts, step, bounds: [lowest, highest], settings } = *plan;
    all_finite(&[starts[0], starts[1], step, lowest, highest])?;
    let is_within = |level: f64| lowest <= level && level <= highest;
    if settings == 0 || step <= 0.0 || lowest >= highest || !starts.into_iter().all(is_within) {
        return Err(StatsError::Adjustment);
    }
    let mut found = Settings { next: Some(starts[0]), levels: Vec::new(), is_at_bound: false };
    for (index, Wished { level, wish }) in wishes.iter().enumerate() {
        if !level.is_finite() {
            return Err(StatsError::NonFinite { index, value: *level });
        }
        if found.next.is_none() {
            return Err(StatsError::Adjustment);
        }
        let next = match wish {
            Wish::More => level + step,
            Wish::Less => level - step,
            Wish::Right => {
                found.levels.push(*level);
                found.is_at_bound |= *level <= lowest || *level >= highest;
                let is_over = found.levels.len() == settings;
                found.next = (!is_over).then(|| starts[found.levels.len() % 2]);
                continue;
            }
        };
        // The nearest whole number of parts, so that a record of it is exact.
        let next = (next * PARTS).round() / PARTS;
        found.is_at_bound |= !is_within(next);
        found.next = Some(next.clamp(lowest, highest));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_goes_by_steps_until_it_is_right_and_starts_alternate() {
        let plan = Plan { starts: [2.0, 6.0], step: 0.3, bounds: [1.0, 6.5], settings: 3 };
        let mut wishes: Vec<Wished> = Vec::new();
        let mut shown = Vec::new();
        for wish in [Wish::More, Wish::More, Wish::Less, Wish::Right, Wish::Less, Wish::Right] {
            let level = settings(&plan, &wishes).unwrap().next.unwrap();
            shown.push(level);
            wishes.push(Wished { level, wish });
        }
        assert_eq!(shown, [2.0, 2.3, 2.6, 2.3, 6.0, 5.7]);
        let found = settings(&plan, &wishes).unwrap();
        assert_eq!(
            (found.next, found.levels, found.is_at_bound),
            (Some(2.0), vec![2.3, 5.7], false)
        );
        wishes.push(Wished { level: 2.0, wish: Wish::Right });
        assert_eq!(settings(&plan, &wishes).unwrap().next, None);
        wishes.push(Wished { level: 2.0, wish: Wish::Right });
        assert_eq!(settings(&plan, &wishes), Err(StatsError::Adjustment));
    }

    #[test]
    fn a_bound_holds_the_level_and_is_told() {
        let plan = Plan { starts: [2.0, 6.0], step: 0.3, bounds: [1.9, 6.5], settings: 3 };
        let found = settings(&plan, &[Wished { level: 2.0, wish: Wish::Less }]).unwrap();
        assert_eq!((found.next, found.is_at_bound), (Some(1.9), true));
        for broken in [
            Plan { settings: 0, ..plan },
            Plan { step: 0.0, ..plan },
            Plan { starts: [1.0, 6.0], ..plan },
            Plan { bounds: [6.5, 1.9], ..plan },
        ] {
            assert_eq!(settings(&broken, &[]), Err(StatsError::Adjustment));
        }
        assert!(settings(&Plan { step: f64::NAN, ..plan }, &[]).is_err());
        assert!(settings(&plan, &[Wished { level: f64::NAN, wish: Wish::More }]).is_err());
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-9 * expected, "{found} instead of {expected}");
    }

    /// SciPy: `np.mean`, `np.std(ddof=1) * norm.ppf(0.75)`, `t.interval(0.95, 5, mean, sem)`.
    #[test]
    fn settings_have_the_numbers_of_scipy() {
        let found = adjustment(&[305.0, 290.0, 310.0, 298.0, 301.0, 294.0], 0.95).unwrap();
        near(found.threshold.estimate, 299.666_666_666_666_7);
        near(found.threshold.ci_low, 292.021_856_360_853_63);
        near(found.threshold.ci_high, 307.311_476_972_479_74);
        near(found.jnd, 4.913_446_806_490_53);
        // `found.jnd * np.sqrt(5 / chi2.ppf([0.975, 0.025], 5))`.
        near(found.jnd_interval[0], 3.067_012_815_285_231_4);
        near(found.jnd_interval[1], 12.050_788_369_586_632);
        near(found.ln_jnd_error, libm::sqrt(0.1));
    }

    #[test]
    fn one_setting_and_what_is_no_number_are_refused() {
        let words = |settings: &[f64]| adjustment(settings, 0.95).unwrap_err().to_string();
        assert_eq!(words(&[300.0]), "1 setting, 2 are needed");
        assert!(words(&[300.0, f64::NAN]).contains("value 1 is NaN"));
        assert!(adjustment(&[300.0, 310.0], 95.0).is_err());
    }
}
