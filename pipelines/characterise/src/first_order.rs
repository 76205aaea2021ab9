//! The straight line of the thesis, with textbook intervals.

use crate::curve::CurveAt;
use crate::error::CharacteriseError;
use crate::samples::{Samples, Sweep};
use zwidth_numerics::lsq;
use zwidth_stats::interval::{Estimate, t_interval};
use zwidth_stats::student_t::critical_value;

/// y = intercept + slope · x by ordinary least squares over all samples of all sweeps.
///
/// Its intervals take samples as independent, as the thesis does. Samples of a recording are not:
/// the bootstrap intervals of [`crate::Candidate`] are the ones to trust.
#[derive(Debug, Clone, PartialEq)]
pub struct FirstOrder {
    /// Response per command.
    pub slope: Estimate,
    /// Response at command 0.
    pub intercept: Estimate,
    /// R².
    pub r2: Option<f64>,
    /// Residual standard deviation √(rss / (n − 2)), unit of the response.
    pub residual_sd: f64,
    /// t of the confidence level of intervals and bands, df = n − 2.
    pub critical: f64,
    /// (XᵀX)⁻¹ for (intercept, slope).
    pub xtx_inverse: [[f64; 2]; 2],
}

/// Fits the first-order characteristic at confidence `level`.
///
/// # Errors
/// As [`crate::characterise`].
pub fn first_order(sweeps: &[Sweep], level: f64) -> Result<FirstOrder, CharacteriseError> {
    let samples = Samples::new(sweeps)?;
    let fit = lsq::fit(&[&vec![1.0; samples.len()], &samples.command], &samples.response)?;
    let se = fit.std_errors();
    let df = fit.df as f64;
    let v = &fit.xtx_inverse;
    Ok(FirstOrder {
        intercept: t_interval(fit.coefficients[0], se[0], df, level)?,
        slope: t_interval(fit.coefficients[1], se[1], df, level)?,
        r2: fit.r2,
        residual_sd: fit.residual_variance().sqrt(),
        critical: critical_value(level, df)?,
        xtx_inverse: [[v[0][0], v[0][1]], [v[1][0], v[1][1]]],
    })
}

impl FirstOrder {
    /// The line on `grid` with the band of its mean, ± t s √(x'(XᵀX)⁻¹x), and that of a single new
    /// response, ± t s √(1 + x'(XᵀX)⁻¹x) (Draper & Smith 1998, *Applied Regression Analysis*,
    /// §3.1).
    pub fn curve(&self, grid: &[f64]) -> Vec<CurveAt> {
        let half = self.critical * self.residual_sd;
        let [[v00, v01], [v10, v11]] = self.xtx_inverse;
        let at = |&x: &f64| {
            let fit = self.intercept.estimate + self.slope.estimate * x;
            let leverage = v00 + x * (v01 + v10 + x * v11);
            let mean = half * leverage.sqrt();
            let new = half * (1.0 + leverage).sqrt();
            CurveAt { command: x, fit, mean: [fit - mean, fit + mean], new: [fit - new, fit + new] }
        };
        grid.iter().map(at).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// statsmodels: `OLS(y, add_constant(x)).fit()`, `conf_int()`, `get_prediction([1,
    /// 3.5]).summary_frame()`. The ends of intervals are moved by the share by which its t of
    /// 2.570581835636314 differs from its nine digits.
    #[test]
    fn intervals_and_bands_are_those_of_statsmodels() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let y = [0.1, 0.9, 2.3, 2.8, 4.4, 4.9, 6.2];
        let fit = first_order(&[Sweep { command: &x, response: &y }], 0.95).unwrap();
        let at = fit.curve(&[3.5])[0];
        let found = [
            fit.intercept.estimate,
            fit.intercept.ci_low,
            fit.intercept.ci_high,
            fit.slope.estimate,
            fit.slope.ci_low,
            fit.slope.ci_high,
            fit.r2.unwrap(),
            at.fit,
            at.mean[0],
            at.mean[1],
            at.new[0],
            at.new[1],
        ];
        for (found, expected) in found.iter().zip(STATSMODELS) {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
    const STATSMODELS: [f64; 12] = [
        0.04285714285714182,
        -0.3882229858910867,
        0.47393727160537036,
        1.0142857142857147,
        0.894725598282995,
        1.1338458302884344,
        0.9895956026698076,
        3.5928571428571434,
        3.346377649411987,
        3.8393366363023,
        2.9138862022644503,
        4.2718280834498366,
    ];
}
