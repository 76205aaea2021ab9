//! Student's t: two-sided p-values and critical values.
//!
//! Written on `libm` rather than taken from a distribution library, because those call the
//! platform's own `ln` and `exp`, whose last bits differ between machines, and intervals are
//! stored. The tests hold it against such a library and against SciPy.

use crate::error::{StatsError, check_level};

/// From here on the series for ln Γ(a + ½) − ln Γ(a) is exact to rounding, and free of the
/// cancellation that the difference of two large logarithms suffers.
const SERIES_FROM: f64 = 20.0;
/// Keeps a denominator of the continued fraction away from 0 (Lentz's method).
const TINY: f64 = 1e-300;
/// Relative change at which the continued fraction has settled.
const SETTLED: f64 = 1e-16;
/// More terms than the continued fraction takes for ten billion degrees of freedom.
const MAX_TERMS: usize = 200_000;

/// P(|T| ≥ |t|) for `df` degrees of freedom: the regularised incomplete beta function I_x(df/2, ½)
/// at x = df / (df + t²) (DLMF §8.17). `df` need not be whole.
///
/// # Errors
/// `df` not positive, `t` not a number.
pub fn two_sided_p(t: f64, df: f64) -> Result<f64, StatsError> {
    if !(df > 0.0 && df.is_finite()) {
        return Err(StatsError::DegreesOfFreedom { df });
    }
    if t.is_nan() {
        return Err(StatsError::NonFinite { index: 0, value: t });
    }
    Ok(tails(t, df))
}

/// The t with P(|T| < t) = `level`: 1.96 for level 0.95 and many degrees of freedom.
///
/// Found by bisection down to neighbouring numbers.
///
/// # Errors
/// `level` outside (0, 1), `df` not positive.
pub fn critical_value(level: f64, df: f64) -> Result<f64, StatsError> {
    check_level(level)?;
    if !(df > 0.0 && df.is_finite()) {
        return Err(StatsError::DegreesOfFreedom { df });
    }
    let alpha = 1.0 - level;
    let mut high = 1.0;
    while tails(high, df) > alpha {
        high *= 2.0;
    }
    let mut low = 0.0;
    loop {
        let middle = low + (high - low) / 2.0;
        if middle <= low || middle >= high {
            return Ok(high);
        }
        if tails(middle, df) > alpha {
            low = middle;
        } else {
            high = middle;
        }
    }
}

fn tails(t: f64, df: f64) -> f64 {
    let (a, b) = (df / 2.0, 0.5);
    let ratio = t * t / df;
    if ratio.is_infinite() {
        return 0.0;
    }
    let (x, y) = (1.0 / (1.0 + ratio), ratio / (1.0 + ratio));
    if y <= 0.0 {
        return 1.0;
    }
    // x^a y^b / B(a, b), with x^a = (1 + t²/df)^-a kept exact for many degrees of freedom
    let front = libm::exp(-a * libm::log1p(ratio) + b * libm::log(y) - ln_beta_half(a));
    if x < (a + 1.0) / (a + b + 2.0) {
        front * beta_fraction(x, a, b) / a
    } else {
        1.0 - front * beta_fraction(y, b, a) / b
    }
}

/// ln B(a, ½) = ½ ln π − (ln Γ(a + ½) − ln Γ(a)).
fn ln_beta_half(a: f64) -> f64 {
    let half_ln_pi = libm::log(core::f64::consts::PI) / 2.0;
    if a < SERIES_FROM {
        return half_ln_pi - (libm::lgamma(a + 0.5) - libm::lgamma(a));
    }
    // Tricomi & Erdélyi (1951), Pacific J. Math. 1: the logarithm of their series for Γ(a + ½) /
    // Γ(a)
    let u = 1.0 / (a * a);
    let series = (-1.0 / 8.0 + u * (1.0 / 192.0 + u * (-1.0 / 640.0 + u * (17.0 / 14336.0)))) / a;
    half_ln_pi - (0.5 * libm::log(a) + series)
}

/// The continued fraction of the incomplete beta function (DLMF 8.17.22), by the modified Lentz
/// method.
fn beta_fraction(x: f64, a: f64, b: f64) -> f64 {
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let mut c = 1.0;
    let mut d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for m in (1..MAX_TERMS).map(|m| m as f64) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut factor = 1.0;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            factor = c * d;
            value *= factor;
        }
        if (factor - 1.0).abs() <= SETTLED {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use statrs::distribution::{ContinuousCDF, StudentsT};

    /// SciPy 1.x: `scipy.stats.t.ppf(0.975, df)`, and 0.9995 for the second.
    #[test]
    fn critical_values_are_those_of_scipy() {
        let cases = [
            (1.0, 12.706204736174694, 636.6192487687897),
            (2.0, 4.302652729749462, 31.599054576445365),
            (5.0, 2.5705818356363146, 6.868826625881276),
            (5.5, 2.501858617589239, 6.35081750008378),
            (34.0, 2.0322445093177186, 3.600715797386448),
            (6552.0, 1.9603261185562506, 3.2920123420624923),
        ];
        for (df, t95, t999) in cases {
            assert!((critical_value(0.95, df).unwrap() / t95 - 1.0).abs() < 2e-12, "df {df}");
            assert!((critical_value(0.999, df).unwrap() / t999 - 1.0).abs() < 2e-12, "df {df}");
        }
    }

    #[test]
    fn p_values_agree_with_an_independent_library() {
        for df in [1.0, 2.0, 3.7, 10.0, 39.0, 41.0, 250.0, 10_000.0] {
            let other = StudentsT::new(0.0, 1.0, df).unwrap();
            for t in [0.1, 0.5, 1.0, 1.7, 2.5, 6.0, 40.0] {
                let (ours, theirs) = (two_sided_p(-t, df).unwrap(), 2.0 * other.cdf(-t));
                assert!(
                    (ours - theirs).abs() < 1e-11 + 1e-9 * theirs,
                    "t {t} df {df}: {ours} {theirs}"
                );
            }
        }
    }

    #[test]
    fn one_degree_of_freedom_is_the_cauchy_distribution() {
        for t in [0.3, 1.0, 12.0] {
            let p = 1.0 - 2.0 / core::f64::consts::PI * libm::atan(t);
            assert!((two_sided_p(t, 1.0).unwrap() - p).abs() < 1e-14);
        }
    }

    #[test]
    fn many_degrees_of_freedom_are_the_normal_distribution() {
        let normal_975 = 1.959963984540054; // scipy.stats.norm.ppf(0.975)
        assert!((critical_value(0.95, 1e8).unwrap() - normal_975).abs() < 1e-7);
    }

    #[test]
    fn requests_without_an_answer_are_refused() {
        assert_eq!(critical_value(1.0, 5.0), Err(StatsError::Level { level: 1.0 }));
        assert_eq!(critical_value(0.95, 0.0), Err(StatsError::DegreesOfFreedom { df: 0.0 }));
        assert_eq!((two_sided_p(0.0, 3.0), two_sided_p(f64::INFINITY, 3.0)), (Ok(1.0), Ok(0.0)));
        assert!(two_sided_p(f64::NAN, 3.0).is_err());
    }
}
