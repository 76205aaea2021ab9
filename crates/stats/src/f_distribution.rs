//! Fisher's F: p values and quantiles, by the regularised incomplete beta function of statrs.
//!
//! P(F > f) = I_x(d₂/2, d₁/2) with x = d₂ / (d₂ + d₁ f) (Abramowitz & Stegun 1964, 26.6.2): the
//! upper tail itself, not one minus the lower tail, so small p values keep their digits.

use crate::error::{StatsError, check_level};
use crate::rounded::rounded;
use statrs::function::beta::checked_beta_reg;

/// P(F ≥ f) for `df_num` and `df_den` degrees of freedom, which need not be whole, to nine
/// significant digits. 1 for an f that is not positive.
///
/// # Errors
/// Degrees of freedom that are not positive and finite, `f` not a number.
pub fn upper_p(f: f64, df_num: f64, df_den: f64) -> Result<f64, StatsError> {
    if f.is_nan() {
        return Err(StatsError::NonFinite { index: 0, value: f });
    }
    check_df(df_num)?;
    check_df(df_den)?;
    Ok(rounded(tail(f, df_num, df_den)?))
}

/// The f with P(F < f) = `level`, to nine significant digits.
///
/// # Errors
/// `level` outside (0, 1), degrees of freedom that are not positive and finite.
pub fn quantile(level: f64, df_num: f64, df_den: f64) -> Result<f64, StatsError> {
    check_level(level)?;
    check_df(df_num)?;
    check_df(df_den)?;
    let mut high = 1.0;
    // For few degrees of freedom the quantile may lie beyond all numbers.
    while tail(high, df_num, df_den)? > 1.0 - level && high < f64::MAX / 2.0 {
        high *= 2.0;
    }
    let mut low = 0.0;
    loop {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return Ok(rounded(high));
        }
        if tail(middle, df_num, df_den)? > 1.0 - level {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// P(F > f), not rounded.
fn tail(f: f64, df_num: f64, df_den: f64) -> Result<f64, StatsError> {
    if f <= 0.0 {
        return Ok(1.0);
    }
    let x = df_den / (df_den + df_num * f);
    checked_beta_reg(df_den / 2.0, df_num / 2.0, x)
        .map_err(|_| StatsError::DegreesOfFreedom { df: df_den })
}

fn check_df(df: f64) -> Result<(), StatsError> {
    if df > 0.0 && df.is_finite() { Ok(()) } else { Err(StatsError::DegreesOfFreedom { df }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::student_t::two_sided_p;

    /// SciPy: `scipy.stats.f.sf(f, d1, d2)` and `f.ppf(0.975, d1, d2)`.
    #[test]
    fn tails_and_quantiles_are_those_of_scipy() {
        let cases = SCIPY;
        for (f, d1, d2, p, q) in cases {
            assert!((upper_p(f, d1, d2).unwrap() / p - 1.0).abs() < 2e-9, "{f} {d1} {d2}");
            assert!((quantile(0.975, d1, d2).unwrap() / q - 1.0).abs() < 2e-9, "{d1} {d2}");
        }
    }

    #[test]
    fn the_square_of_t_is_f_with_one_degree_of_freedom() {
        for (t, df) in [(0.4, 3.0), (2.5, 17.0), (6.0, 2.4)] {
            let (f, t) = (upper_p(t * t, 1.0, df).unwrap(), two_sided_p(t, df).unwrap());
            assert!((f / t - 1.0).abs() < 3e-9);
        }
    }

    #[test]
    fn what_has_no_answer_is_refused() {
        assert_eq!(upper_p(-1.0, 2.0, 3.0), Ok(1.0));
        assert!(upper_p(f64::NAN, 2.0, 3.0).is_err());
        assert!(upper_p(1.0, 0.0, 3.0).is_err() && upper_p(1.0, 2.0, f64::INFINITY).is_err());
        assert!(quantile(1.0, 2.0, 3.0).is_err());
    }
    const SCIPY: [(f64, f64, f64, f64, f64); 5] = [
        (0.3, 1.0, 1.0, 0.6809942799600229, 647.7890114778442),
        (4.2, 2.0, 10.0, 0.047414468316868755, 5.45639552591273),
        (20.57608, 2.0, 10.0, 0.0002855486512358809, 5.45639552591273),
        (3.62, 2.5, 7.7, 0.07182281154094108, 5.810692223856187),
        (60.0, 8.0, 180.0, 8.302398966893395e-47, 2.2630395805604353),
    ];
}
