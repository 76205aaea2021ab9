//! Adjustment: the person sets the level until it feels equal to the standard, several times.
//!
//! Settings are drawn from the psychometric function of "which was more" as from a distribution: its median is the PSE, and
//! half of them lie within one JND of it (the probable error; Gescheider 1997, *Psychophysics: The Fundamentals*, 3rd ed.,
//! chapter 3). Of normal settings PSE = mean and JND = 0.6745 SD.

use super::curve::NORMAL_QUARTILE;
use crate::interval::{self, Estimate};
use crate::tested::Unestimable;

/// What the settings of one person tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adjusted {
    /// The PSE with its t interval, in the unit of the stimulus.
    pub threshold: Estimate,
    /// The JND, in the unit of the stimulus; 0 of settings that are all equal.
    pub jnd: f64,
}

/// PSE and JND of `settings`, the interval at `confidence`.
///
/// # Errors
/// Fewer than two settings, one that is not finite, `confidence` outside (0, 1).
pub fn adjustment(settings: &[f64], confidence: f64) -> Result<Adjusted, Unestimable> {
    let mean = interval::mean(settings, confidence)?;
    match (mean.interval, mean.sd) {
        (Some(threshold), Some(sd)) => Ok(Adjusted { threshold, jnd: NORMAL_QUARTILE * sd }),
        _ => Err(Unestimable::TooFew { units: "settings", found: settings.len(), needed: 2 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }

    #[test]
    fn one_setting_and_what_is_no_number_are_refused() {
        let words = |settings: &[f64]| adjustment(settings, 0.95).unwrap_err().to_string();
        assert_eq!(words(&[300.0]), "1 setting, 2 are needed");
        assert!(words(&[300.0, f64::NAN]).contains("value 1 is NaN"));
        assert!(adjustment(&[300.0, 310.0], 95.0).is_err());
    }
}
