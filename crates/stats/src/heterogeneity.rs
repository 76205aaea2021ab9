//! The mean of people whose values are known with different errors: the two-level model.
//!
//! Person i has the value yᵢ with the known variance vᵢ, and people's true values scatter with the variance τ². The mean
//! weighs people by wᵢ = 1/(vᵢ + τ²). Of a PSE or a ln JND vᵢ is the square of the error that `psychometric::fit` gives:
//! half the length of the interval over the critical value that made it, which is 1.96 only where φ = 1.
//!
//! * τ² after Paule & Mandel (1982), J. Res. NBS 87:377: that of Σ wᵢ (yᵢ − ȳ_w)² = k − 1, or 0.
//! * The error after Hartung & Knapp (2001), Stat. Med. 20:3875: variance q/Σ wᵢ, q = Σ wᵢ (yᵢ − ȳ_w)²/(k − 1), and t with
//!   k − 1 degrees of freedom. q is 1 by construction where τ² > 0. Where τ² = 0 it may be below 1; then it stays so, as
//!   in metafor's `test = "knha"`: max(1, q) (`"adhoc"`) would find less than was promised.

use crate::error::{StatsError, all_finite, check_level, same_length};
use crate::interval::t_interval;
use crate::student_t::two_sided_p;
use crate::tested::{Tested, Unestimable, at_least, not_constant};
use zwidth_numerics::roots;

/// τ² is solution to this share of the people's variance.
const RESOLUTION: f64 = 1e-14;

/// The mean of people, and how far they scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TwoLevel {
    /// The weighted mean with its interval and the test against 0.
    pub mean: Tested,
    /// τ², the variance of people's true values, in the unit of the values squared.
    pub between: f64,
}

/// The mean of people's `values` with `variances` of their errors, at confidence `level`.
///
/// # Errors
/// Fewer than two people, unequal lengths, values that are not finite or all equal, variances that are not positive,
/// `level` outside (0, 1).
pub fn two_level(values: &[f64], variances: &[f64], level: f64) -> Result<TwoLevel, Unestimable> {
    check_level(level)?;
    same_length("variances", values.len(), variances.len())?;
    at_least("participants", values.len(), 2)?;
    all_finite(values)?;
    all_finite(variances)?;
    if let Some(index) = variances.iter().position(|variance| *variance <= 0.0) {
        return Err(StatsError::Variance { index, value: variances[index] }.into());
    }
    not_constant("values", values.iter().all(|value| value.total_cmp(&values[0]).is_eq()))?;
    let df = (values.len() - 1) as f64;
    let plain = values.iter().sum::<f64>() / values.len() as f64;
    let scatter = values.iter().map(|value| (value - plain).powi(2)).sum::<f64>() / df;
    // Residuals are smallest about the weighted mean, and weights at most 1/τ²: this is no lower than the solution.
    let between = if weighted(values, variances, 0.0).residual <= df {
        0.0
    } else {
        let over = |between: f64| weighted(values, variances, between).residual / df - 1.0;
        roots::bracketed(over, 0.0, scatter, RESOLUTION * scatter)
    };
    let solution = weighted(values, variances, between);
    let std_error = (solution.residual / df / solution.weight).sqrt();
    let interval = t_interval(solution.mean, std_error, df, level)?;
    let statistic = solution.mean / std_error;
    let mean = Tested {
        estimate: solution.mean,
        std_error,
        ci_low: interval.ci_low,
        ci_high: interval.ci_high,
        statistic,
        df,
        p_value: two_sided_p(statistic, df)?,
    };
    Ok(TwoLevel { mean, between })
}

struct Weighted {
    mean: f64,
    /// Σ wᵢ.
    weight: f64,
    /// Σ wᵢ (yᵢ − ȳ_w)².
    residual: f64,
}

fn weighted(values: &[f64], variances: &[f64], between: f64) -> Weighted {
    let weights: Vec<f64> = variances.iter().map(|variance| 1.0 / (variance + between)).collect();
    let weight: f64 = weights.iter().sum();
    let mean = values.iter().zip(&weights).map(|(y, w)| y * w).sum::<f64>() / weight;
    let squares = values.iter().zip(&weights).map(|(y, w)| w * (y - mean).powi(2));
    Weighted { mean, weight, residual: squares.sum() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() <= 2e-7 * expected.abs(), "{found} {expected}");
    }

    /// SciPy's `brentq` of the definition of τ², and with it statsmodels' `combine_effects` (`sd_eff_w_fe_hksj`).
    #[test]
    fn people_who_scatter_have_the_numbers_of_scipy_and_statsmodels() {
        let variances = [0.04, 0.2, 0.1, 0.3, 0.05];
        let found = two_level(&[0.5, 1.3, -0.2, 2.1, 0.9], &variances, 0.95).unwrap();
        near(found.between, 0.552_891_204_298_108_7);
        near(found.mean.estimate, 0.842_907_516_504_115_7);
        near(found.mean.std_error, 0.368_163_245_937_549);
        near(found.mean.ci_low, -0.179_277_525_592_923_5);
        near(found.mean.p_value, 0.083_903_843_159_446_7);
        // Their values lie nearer to each other than their errors let expect: q is 0.06, and stays so.
        let alike = two_level(&[0.5, 0.6, 0.55, 0.7, 0.4], &variances, 0.95).unwrap();
        assert!(alike.between.abs() < 1e-15);
        near(alike.mean.estimate, 0.494_736_842_105_263_1);
        near(alike.mean.std_error, 0.040_061_414_072_732_44);
    }

    /// Of people with the same error it is the t of their mean, whatever τ² is.
    #[test]
    fn people_with_equal_errors_have_the_t_of_their_mean() {
        let values = [0.3, 1.2, -0.4, 0.9, 0.5];
        let plain = crate::interval::mean(&values, 0.95).unwrap().interval.unwrap();
        for variance in [0.01, 5.0] {
            let found = two_level(&values, &[variance; 5], 0.95).unwrap();
            assert_eq!(found.between > 0.0, variance < 1.0);
            near(found.mean.std_error, plain.std_error);
            near(found.mean.ci_low, plain.ci_low);
        }
    }

    #[test]
    fn what_has_no_mean_is_refused() {
        let words = |values: &[f64], variances: &[f64]| {
            two_level(values, variances, 0.95).unwrap_err().to_string()
        };
        assert_eq!(words(&[1.0], &[1.0]), "1 participant, 2 are needed");
        assert!(words(&[1.0, 2.0], &[1.0, 0.0]).contains("variance 1 is 0"));
        assert!(words(&[1.0, 1.0], &[1.0, 1.0]).contains("equal"));
        assert!(two_level(&[1.0, 2.0], &[1.0], 0.95).is_err());
        assert!(two_level(&[1.0, f64::NAN], &[1.0, 1.0], 0.95).is_err());
    }
}
