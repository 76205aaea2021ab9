//! Means and estimates with Student-t intervals.

use crate::error::{StatsError, all_finite, check_level};
use crate::student_t::critical_value;
use zwidth_numerics::moments::Moments;

/// The mean of n independent values, with its error. Units as the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mean {
    /// Number of values.
    pub n: usize,
    /// Arithmetic mean; `None` without values.
    pub estimate: Option<f64>,
    /// Sample standard deviation (divisor n − 1); `None` for fewer than two values.
    pub sd: Option<f64>,
    /// t interval of the mean, df = n − 1; `None` for fewer than two values.
    pub interval: Option<Estimate>,
}

/// An estimate with its standard error and a t interval. Units as the estimated quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The estimate.
    pub estimate: f64,
    /// Its standard error.
    pub std_error: f64,
    /// Lower end of the interval.
    pub ci_low: f64,
    /// Upper end of the interval.
    pub ci_high: f64,
    /// Degrees of freedom of the t distribution used.
    pub df: f64,
}

/// estimate ± t(level, df) · std_error.
///
/// # Errors
/// `level` outside (0, 1), `df` not positive, an estimate or standard error that is not finite.
pub fn t_interval(
    estimate: f64,
    std_error: f64,
    df: f64,
    level: f64,
) -> Result<Estimate, StatsError> {
    all_finite(&[estimate, std_error])?;
    let half = critical_value(level, df)? * std_error;
    Ok(Estimate { estimate, std_error, ci_low: estimate - half, ci_high: estimate + half, df })
}

/// Mean, standard deviation and t interval of `values` at confidence `level` (such as 0.95).
///
/// # Errors
/// A value that is not finite, `level` outside (0, 1).
pub fn mean(values: &[f64], level: f64) -> Result<Mean, StatsError> {
    all_finite(values)?;
    check_level(level)?;
    let n = values.len();
    if n == 0 {
        return Ok(Mean { n, estimate: None, sd: None, interval: None });
    }
    let moments = Moments::of(values);
    let interval = moments
        .sd()
        .map(|sd| t_interval(moments.mean, sd / (n as f64).sqrt(), (n - 1) as f64, level))
        .transpose()?;
    Ok(Mean { n, estimate: Some(moments.mean), sd: moments.sd(), interval })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SciPy: `np.mean(v) ∓ t * st.sem(v)`, t = `st.t.ppf(0.975, 5)` to nine digits.
    #[test]
    fn the_mean_of_six_repeats_has_the_interval_of_scipy() {
        let mean = mean(&[4.1, 3.9, 4.4, 4.0, 4.6, 4.3], 0.95).unwrap();
        let interval = mean.interval.unwrap();
        let found = [
            mean.estimate.unwrap(),
            mean.sd.unwrap(),
            interval.std_error,
            interval.ci_low,
            interval.ci_high,
        ];
        let scipy = [
            4.216666666666667,
            0.26394443859772204,
            0.10775486583496409,
            3.9396739653796717,
            4.493659367953662,
        ];
        for (found, scipy) in found.iter().zip(scipy) {
            assert!((found - scipy).abs() < 1e-12, "{found} {scipy}");
        }
        assert_eq!((mean.n, interval.df), (6, 5.0));
    }

    #[test]
    fn one_value_has_a_mean_and_no_interval_and_none_has_neither() {
        assert_eq!(
            mean(&[2.5], 0.95).unwrap(),
            Mean { n: 1, estimate: Some(2.5), sd: None, interval: None }
        );
        assert_eq!(
            mean(&[], 0.95).unwrap(),
            Mean { n: 0, estimate: None, sd: None, interval: None }
        );
    }

    #[test]
    fn nan_and_a_level_of_95_are_refused() {
        assert!(matches!(
            mean(&[1.0, f64::NAN], 0.95),
            Err(StatsError::NonFinite { index: 1, .. })
        ));
        assert_eq!(mean(&[1.0, 2.0], 95.0), Err(StatsError::Level { level: 95.0 }));
    }
}
