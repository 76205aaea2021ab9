//! Reference distributions of a likelihood ratio, or of an estimate divided by its error: normal,
//! χ² and F, computed by statrs and rounded at once.

use crate::error::{StatsError, check_level};
use crate::rounded::rounded;
use crate::tested::Tested;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

/// A statistic that is referred to the χ² distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChiSquareTest {
    /// The statistic: of a likelihood ratio twice the gain of the log-likelihood.
    pub statistic: f64,
    /// Degrees of freedom: how many parameters the smaller model lacks.
    pub df: f64,
    /// P(χ² ≥ statistic).
    pub p_value: f64,
}

/// The test of `statistic` by χ² with `df` degrees of freedom.
pub(crate) fn chi_square(statistic: f64, df: f64) -> Result<ChiSquareTest, StatsError> {
    let distribution = ChiSquared::new(df).map_err(|_| StatsError::DegreesOfFreedom { df })?;
    Ok(ChiSquareTest { statistic, df, p_value: rounded(distribution.sf(statistic)) })
}

/// The χ² with P(χ²(df) ≤ χ²) = `share`.
pub(crate) fn chi_square_quantile(share: f64, df: f64) -> Result<f64, StatsError> {
    check_level(share)?;
    let distribution = ChiSquared::new(df).map_err(|_| StatsError::DegreesOfFreedom { df })?;
    Ok(rounded(distribution.inverse_cdf(share)))
}

/// P(F ≥ `f`) with `num` and `den` degrees of freedom.
pub(crate) fn f_tail(f: f64, num: f64, den: f64) -> Result<f64, StatsError> {
    let distribution = FisherSnedecor::new(num, den)
        .map_err(|_| StatsError::DegreesOfFreedom { df: num.min(den) })?;
    Ok(rounded(distribution.sf(f)))
}

/// The z with P(|Z| < z) = `level`.
pub(crate) fn normal_critical(level: f64) -> Result<f64, StatsError> {
    check_level(level)?;
    // By the lower tail: next to 1 the upper one has lost its digits.
    Ok(rounded(-Normal::standard().inverse_cdf((1.0 - level) / 2.0)))
}

/// P(|Z| ≥ |z|).
pub(crate) fn normal_two_sided(z: f64) -> f64 {
    // erfc, because 1 − erf has no digits left far out.
    libm::erfc(z.abs() / core::f64::consts::SQRT_2)
}

/// An estimate with its Wald test and interval: the normal distribution, `df` infinite.
pub(crate) fn normal_wald(estimate: f64, std_error: f64, level: f64) -> Result<Tested, StatsError> {
    let half = normal_critical(level)? * std_error;
    let statistic = estimate / std_error;
    Ok(Tested {
        estimate,
        std_error,
        ci_low: estimate - half,
        ci_high: estimate + half,
        statistic,
        df: f64::INFINITY,
        p_value: normal_two_sided(statistic),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::student_t::two_sided_p;

    /// R 4.2: `pchisq(x, df, lower.tail = FALSE)`, `pf(x, a, b, lower.tail = FALSE)`.
    #[test]
    fn tails_are_those_of_r() {
        for (x, df, p) in CHI_SQUARE {
            assert!((chi_square(x, df).unwrap().p_value / p - 1.0).abs() < 1e-8, "{x} {df}");
        }
        for (x, num, den, p) in F {
            assert!((f_tail(x, num, den).unwrap() / p - 1.0).abs() < 1e-8, "{x} {num} {den}");
        }
    }
    const CHI_SQUARE: [(f64, f64, f64); 3] = [
        (0.5, 1.0, 0.4795001221869535),
        (7.3, 2.0, 0.02599112877875535),
        (40.0, 5.0, 1.493367900050395e-07),
    ];
    const F: [(f64, f64, f64, f64); 3] = [
        (0.5, 2.0, 10.0, 0.6209213230591553),
        (4.1, 2.0, 22.0, 0.03066006819683425),
        (20.57608, 2.0, 10.0, 0.0002855486512358807),
    ];

    #[test]
    fn one_degree_of_freedom_is_the_square_of_a_normal_or_of_t() {
        for z in [0.1, 1.0, 2.5, 7.0] {
            let p = chi_square(z * z, 1.0).unwrap().p_value;
            assert!((p / normal_two_sided(-z) - 1.0).abs() < 1e-8, "{z}");
            let p = f_tail(z * z, 1.0, 22.0).unwrap();
            assert!((p / two_sided_p(z, 22.0).unwrap() - 1.0).abs() < 1e-8, "{z}");
        }
        assert!((normal_critical(0.95).unwrap() - 1.95996398).abs() < 1e-12);
    }

    #[test]
    fn no_degrees_of_freedom_are_refused() {
        assert!(chi_square(1.0, 0.0).is_err() && f_tail(1.0, 2.0, 0.0).is_err());
        assert!(normal_critical(95.0).is_err());
        assert!((chi_square(0.0, 2.0).unwrap().p_value - 1.0).abs() < 1e-15);
    }
}
