//! Intervals for a linear fit to one recording, whose samples resemble their neighbours.

use crate::error::StatsError;
use crate::hac::newey_west;
use crate::interval::{Estimate, t_interval};
use zwidth_numerics::lsq::LinearFit;

/// The covariance looks back over one tenth of the recording: long against the time over which
/// residuals stay alike in free or guided motion of about one movement a second, short enough to
/// leave ten such stretches.
const SHARE_OF_RECORDING: usize = 10;

/// Degrees of freedom of the interval. With lags that grow with the recording the t statistic is
/// not normal (Kiefer & Vogelsang 2005, Econometric Theory 21:1130). Its two-sided critical values
/// for n/10 lags are 1.84, 2.23 and 3.06 at 90, 95 and 99 % (simulated: 60 000 records of 1 000
/// independent normal values); Student's t with 9 degrees of freedom has 1.83, 2.26 and 3.25.
const DF: f64 = 9.0;

/// The coefficients of a fit to one recording, with intervals.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordingFit {
    /// One a coefficient, in the order of the fit's columns and in their units.
    pub estimates: Vec<Estimate>,
    /// Lags of the covariance, in samples.
    pub lags: usize,
}

/// Estimates with standard errors and intervals at confidence `level` for a fit to evenly recorded
/// samples: [`newey_west`] with n / 10 lags, and t with 9 degrees of freedom.
///
/// Samples hundreds of times a second are not independent: what the model leaves out (friction, the
/// hand) changes slowly, so residuals resemble their neighbours and the usual standard errors are
/// several times too small. The interval speaks of this recording only, not of how another would
/// differ.
///
/// # Errors
/// Columns that are not those of the fit, `level` outside (0, 1).
pub fn recording_fit(
    columns: &[&[f64]],
    fit: &LinearFit,
    level: f64,
) -> Result<RecordingFit, StatsError> {
    let lags = fit.residuals.len() / SHARE_OF_RECORDING;
    let covariance = newey_west(columns, fit, lags)?;
    let mut estimates = Vec::with_capacity(fit.coefficients.len());
    for (j, b) in fit.coefficients.iter().enumerate() {
        // Rounding may leave the variance of an all but perfect fit below 0.
        estimates.push(t_interval(*b, covariance[j][j].max(0.0).sqrt(), DF, level)?);
    }
    Ok(RecordingFit { estimates, lags })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_numerics::lsq;

    /// A ramp with errors that come in runs of ten, made from whole numbers.
    fn data() -> (Vec<f64>, Vec<f64>) {
        let x: Vec<f64> = (0..200u32).map(f64::from).collect();
        let y = x.iter().zip(0u32..).map(|(x, i)| 2.0 * x + f64::from((i / 10) * 7 % 13)).collect();
        (x, y)
    }

    /// statsmodels 0.15: `OLS(y, X).fit(cov_type="HAC", cov_kwds={"maxlags": 20}).bse`; SciPy:
    /// `t.ppf(0.975, 9)`.
    #[test]
    fn standard_errors_are_those_of_statsmodels_with_a_tenth_of_the_recording_as_lags() {
        let (x, y) = data();
        let ones = vec![1.0; x.len()];
        let columns: [&[f64]; 2] = [&ones, &x];
        let fit = recording_fit(&columns, &lsq::fit(&columns, &y).unwrap(), 0.95).unwrap();
        assert_eq!(fit.lags, 20);
        let expect = [0.9359346337178767, 0.007449077216132867];
        for (found, expect) in fit.estimates.iter().zip(expect) {
            assert!((found.std_error / expect - 1.0).abs() < 1e-9, "{} {expect}", found.std_error);
            assert!((found.ci_high - found.estimate - 2.26215716 * expect).abs() < 1e-9);
        }
    }

    #[test]
    fn errors_that_come_in_runs_widen_the_interval() {
        let (x, y) = data();
        let ones = vec![1.0; x.len()];
        let columns: [&[f64]; 2] = [&ones, &x];
        let fit = lsq::fit(&columns, &y).unwrap();
        let independent = fit.std_errors()[1];
        let recorded = recording_fit(&columns, &fit, 0.95).unwrap().estimates[1].std_error;
        assert!(recorded > 1.5 * independent, "{recorded} {independent}");
    }
}
