//! Intervals for a linear fit to one recording, whose samples resemble their neighbours. For a line
//! or a mean the recording is not copied.

use crate::error::StatsError;
use crate::hac::{long_run_sum, newey_west};
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
    /// One per coefficient, in the order of the fit's columns and in their units.
    pub estimates: Vec<Estimate>,
    /// Lags of the covariance, in samples.
    pub lags: usize,
}

/// Estimates with standard errors and intervals at confidence `level` for a fit to evenly recorded
/// samples: [`newey_west`] with n / 10 lags, and t with 9 degrees of freedom.
///
/// Samples at hundreds of times per second are not independent: what the model leaves out
/// (friction, the hand) changes slowly, so residuals resemble their neighbours and the usual
/// standard errors are several times too small. The interval speaks of this recording only, not of
/// how another would differ.
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

/// A straight line through samples of one recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RecordingLine {
    /// Its value at the requested place, in the unit of y.
    pub value: Estimate,
    /// Its slope, in the unit of y per unit of x.
    pub slope: Estimate,
    /// Residual sum of squares, unit of y squared.
    pub rss: f64,
    /// R² = 1 − rss / Σ (y − ȳ)²; `None` for a constant y.
    pub r2: Option<f64>,
}

/// Deviations of x whose length is a smaller share of that of x are rounding
/// ([`zwidth_numerics::lsq`] has the same).
const RANK_TOLERANCE: f64 = 1e-12;

/// The line y = value + slope (x − `at`) by least squares through `n` samples, `sample(i)` = (x, y)
/// the i-th as recorded, with the intervals of [`recording_fit`]. `None` for fewer than three samples
/// and for samples of one x.
///
/// slope = Σ (x − x̄) (y − ȳ) / Σ (x − x̄)², the value ȳ + slope (at − x̄). Both are Σ wᵢ yᵢ, with
/// w = (x − x̄) / Σ (x − x̄)² and 1/n + (at − x̄) (x − x̄) / Σ (x − x̄)², so that with S as
/// [`newey_west`] has it, of the scores e and (x − x̄) e, their variances are S₁₁ / Σ² and
/// S₀₀ / n² + 2 (at − x̄) S₀₁ / n Σ + (at − x̄)² S₁₁ / Σ².
///
/// # Errors
/// A sample that is not a number, `level` outside (0, 1).
pub fn recording_line(
    n: usize,
    sample: impl Fn(usize) -> (f64, f64),
    at: f64,
    level: f64,
) -> Result<Option<RecordingLine>, StatsError> {
    check_samples(n, &sample)?;
    if n < 3 {
        return Ok(None);
    }
    let (x_mean, y_mean) = {
        let sums = (0..n).map(&sample).fold((0.0, 0.0), |sum, (x, y)| (sum.0 + x, sum.1 + y));
        (sums.0 / n as f64, sums.1 / n as f64)
    };
    let mut xx = 0.0;
    let mut xy = 0.0;
    let mut yy = 0.0;
    let mut whole = 0.0_f64; // about `at`, the size against which a spread of x is rounding
    // A second pass, about the means: Σ x² − n x̄² would lose the digits of a spread.
    for (x, y) in (0..n).map(&sample) {
        let dx = x - x_mean;
        let dy = y - y_mean;
        (xx, xy, yy) = (xx + dx * dx, xy + dx * dy, yy + dy * dy);
        whole += (x - at) * (x - at);
    }
    if xx.sqrt() <= RANK_TOLERANCE * whole.sqrt() {
        return Ok(None);
    }
    let slope = xy / xx;
    let deviation = |i: usize| {
        let (x, y) = sample(i);
        (x - x_mean, (y - y_mean) - slope * (x - x_mean))
    };
    let rss: f64 = (0..n).map(|i| deviation(i).1).map(|e| e * e).sum();
    let scores = |i: usize| {
        let (dx, e) = deviation(i);
        [e, dx * e]
    };
    let s = long_run_sum(n, scores, n / SHARE_OF_RECORDING);
    let of_mean = 1.0 / n as f64;
    let of_slope = (at - x_mean) / xx;
    let variance = of_mean * of_mean * s[0][0]
        + 2.0 * of_mean * of_slope * s[0][1]
        + of_slope * of_slope * s[1][1];
    let [value, slope] = [(y_mean + slope * (at - x_mean), variance), (slope, s[1][1] / (xx * xx))]
        // Rounding may leave the variance of an all but perfect fit below 0.
        .map(|(b, variance)| t_interval(b, variance.max(0.0).sqrt(), DF, level));
    Ok(Some(RecordingLine {
        value: value?,
        slope: slope?,
        rss,
        r2: (yy > 0.0).then(|| 1.0 - rss / yy),
    }))
}

/// The mean of `n` values of one recording, with the interval of [`recording_fit`]; `None` for fewer
/// than two.
///
/// # Errors
/// Those of [`recording_line`].
pub fn recording_mean(
    n: usize,
    value: impl Fn(usize) -> f64,
    level: f64,
) -> Result<Option<Estimate>, StatsError> {
    check_samples(n, |i| (0.0, value(i)))?;
    if n < 2 {
        return Ok(None);
    }
    let mean = (0..n).map(&value).sum::<f64>() / n as f64;
    let s = long_run_sum(n, |i| [value(i) - mean], n / SHARE_OF_RECORDING);
    Ok(Some(t_interval(mean, s[0][0].max(0.0).sqrt() / n as f64, DF, level)?))
}

/// Checks that all samples are finite, before any sum of them is NaN.
fn check_samples(n: usize, sample: impl Fn(usize) -> (f64, f64)) -> Result<(), StatsError> {
    for index in 0..n {
        let (x, y) = sample(index);
        if let Some(value) = [x, y].into_iter().find(|value| !value.is_finite()) {
            return Err(StatsError::NonFinite { index, value });
        }
    }
    Ok(())
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

    /// The line and the mean against the general fit, whose numbers are statsmodels'.
    #[test]
    fn a_line_and_a_mean_without_copies_are_those_of_the_general_fit() {
        let close = |found: Estimate, expect: Estimate| {
            assert!((found.estimate - expect.estimate).abs() < 1e-12, "{found:?} {expect:?}");
            assert!(
                (found.std_error / expect.std_error - 1.0).abs() < 1e-9,
                "{found:?} {expect:?}"
            );
            assert!((found.ci_low - expect.ci_low).abs() < 1e-9, "{found:?} {expect:?}");
        };
        let (x, y) = data();
        let ones = vec![1.0; x.len()];
        for at in [0.0, 50.0, 99.5, 1000.0] {
            let from: Vec<f64> = x.iter().map(|x| x - at).collect();
            let columns: [&[f64]; 2] = [&ones, &from];
            let fit = lsq::fit(&columns, &y).unwrap();
            let expect = recording_fit(&columns, &fit, 0.95).unwrap().estimates;
            let line = recording_line(x.len(), |i| (x[i], y[i]), at, 0.95).unwrap().unwrap();
            close(line.value, expect[0]);
            close(line.slope, expect[1]);
            assert!((line.rss / fit.rss - 1.0).abs() < 1e-12);
            assert!((line.r2.unwrap() - fit.r2.unwrap()).abs() < 1e-12);
        }
        let fit = lsq::fit(&[&ones], &y).unwrap();
        let expect = recording_fit(&[&ones], &fit, 0.9).unwrap().estimates[0];
        close(recording_mean(y.len(), |i| y[i], 0.9).unwrap().unwrap(), expect);
    }

    #[test]
    fn what_shows_no_line_and_no_mean_has_none_and_what_is_no_number_is_refused() {
        let line = |points: &[(f64, f64)]| recording_line(points.len(), |i| points[i], 0.0, 0.95);
        assert_eq!(line(&[(0.0, 1.0), (1.0, 2.0)]).unwrap(), None);
        assert_eq!(line(&[(0.5, 1.0); 40]).unwrap(), None);
        assert_eq!(recording_mean(1, |_| 1.0, 0.95).unwrap(), None);
        assert!(line(&[(0.0, 1.0), (f64::NAN, 2.0), (2.0, 3.0)]).is_err());
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
