//! Student's t: two-sided p-values and critical values, by the distributions of statrs.
//!
//! Critical values are found by a search on its distribution function, because its own inverse
//! (0.19) starts from a clamped guess: it is wrong for less than one degree of freedom and for
//! levels next to 0 or 1, and from some thousand degrees on it stops early or never. For many
//! degrees of freedom its logarithms cancel, and the normal distribution with its corrections is
//! exact to rounding.

use crate::error::{StatsError, check_level};
use crate::rounded::rounded;
use statrs::distribution::{ContinuousCDF, Normal, StudentsT};
use std::cell::Cell;

/// From here on the corrections of the normal distribution leave less than 1e-13 of a critical
/// value.
const MANY: f64 = 1000.0;

/// P(|T| ≥ |t|) for `df` degrees of freedom, to nine significant digits (to 1e-16 `df` beyond 10⁵
/// degrees). `df` need not be whole.
///
/// # Errors
/// `df` not positive, `t` not a number.
pub fn two_sided_p(t: f64, df: f64) -> Result<f64, StatsError> {
    if t.is_nan() {
        return Err(StatsError::NonFinite { index: 0, value: t });
    }
    Ok(rounded(tails(t.abs(), &distribution(df)?)))
}

/// The t with P(|T| < t) = `level`, to nine significant digits: 1.95996398 for level 0.95 and many
/// degrees of freedom.
///
/// # Errors
/// `level` outside (0, 1), `df` not positive.
pub fn critical_value(level: f64, df: f64) -> Result<f64, StatsError> {
    /// Values that are kept.
    const MOST: usize = 4;
    #[derive(Clone, Copy)]
    struct Kept {
        level: f64,
        df: f64,
        value: f64,
    }
    /// NaN equals nothing, so that it is never taken for a request.
    const EMPTY: Kept = Kept { level: f64::NAN, df: f64::NAN, value: f64::NAN };
    thread_local! {
        // The search takes fifty values of the distribution, and all intervals of a trial but a few
        // ask for the same.
        static KEPT: Cell<[Kept; MOST]> = const { Cell::new([EMPTY; MOST]) };
    }
    let mut kept = KEPT.get();
    if let Some(at) = kept.iter().position(|kept| (kept.level, kept.df) == (level, df)) {
        // The one used last goes to the front, the one that was not used longest is dropped.
        kept[..=at].rotate_right(1);
        KEPT.set(kept);
        return Ok(kept[0].value);
    }
    check_level(level)?;
    let distribution = distribution(df)?;
    let value =
        rounded(if df < MANY { searched(level, &distribution) } else { corrected(level, df) });
    kept.rotate_right(1);
    kept[0] = Kept { level, df, value };
    KEPT.set(kept);
    Ok(value)
}

fn distribution(df: f64) -> Result<StudentsT, StatsError> {
    let distribution = StudentsT::new(0.0, 1.0, df).ok().filter(|_| df.is_finite());
    distribution.ok_or(StatsError::DegreesOfFreedom { df })
}

/// P(|T| ≥ t) for t ≥ 0, not rounded.
fn tails(t: f64, distribution: &StudentsT) -> f64 {
    2.0 * distribution.sf(t)
}

/// Shares of a critical value that are rounded away ([`rounded`] keeps nine digits).
const ROUNDED_AWAY: f64 = 1e-13;

/// The critical value between two numbers that come together: by the straight line between what the
/// tails are there, an end that stays twice counting half (the Illinois rule; Dowell & Jarratt 1971,
/// BIT 11:168).
fn searched(level: f64, distribution: &StudentsT) -> f64 {
    let alpha = 1.0 - level;
    let over = |t: f64| tails(t, distribution) - alpha;
    let mut low = 0.0;
    let mut at_low = level; // at 0 the tails are 1, and 1 − alpha is the level
    let mut high = 1.0;
    let mut at_high = over(1.0);
    while at_high > 0.0 {
        (low, at_low) = (high, at_high);
        high *= 2.0;
        at_high = over(high);
    }
    // Which end moved last, and every fourth step to the middle, so that both always come together.
    let mut moved_low = None;
    for step in 1.. {
        if high - low <= ROUNDED_AWAY * high {
            break;
        }
        let line = high - at_high * (high - low) / (at_high - at_low);
        let is_within = line > low && line < high && step % 4 > 0;
        let next = if is_within { line } else { low + (high - low) / 2.0 };
        if next <= low || next >= high {
            break;
        }
        let at_next = over(next);
        let moves_low = at_next > 0.0;
        let stays = moved_low.replace(moves_low) == Some(moves_low);
        let share = if stays { 0.5 } else { 1.0 };
        if moves_low {
            (low, at_low, at_high) = (next, at_next, at_high * share);
        } else {
            (high, at_high, at_low) = (next, at_next, at_low * share);
        }
    }
    high
}

/// The critical value from that of the normal distribution, corrected by powers of 1/df (Abramowitz
/// & Stegun 1964, 26.7.5).
fn corrected(level: f64, df: f64) -> f64 {
    let z = -Normal::standard().inverse_cdf((1.0 - level) / 2.0);
    let s = z * z;
    let corrections = [
        z * (s + 1.0) / 4.0,
        z * ((5.0 * s + 16.0) * s + 3.0) / 96.0,
        z * (((3.0 * s + 19.0) * s + 17.0) * s - 15.0) / 384.0,
        z * ((((79.0 * s + 776.0) * s + 1482.0) * s - 1920.0) * s - 945.0) / 92_160.0,
    ];
    z + corrections.iter().rev().fold(0.0, |sum, correction| (sum + correction) / df)
}

#[cfg(test)]
mod tests {
    use super::*;

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
            for (level, expect) in [(0.95, t95), (0.999, t999)] {
                let distribution = distribution(df).unwrap();
                let exact =
                    if df < MANY { searched(level, &distribution) } else { corrected(level, df) };
                assert!((exact / expect - 1.0).abs() < 2e-12, "level {level}, df {df}");
                assert_eq!(
                    critical_value(level, df),
                    Ok(rounded(expect)),
                    "level {level}, df {df}"
                );
            }
        }
    }

    #[test]
    fn both_ways_to_a_critical_value_agree_where_they_meet() {
        for level in [0.5, 0.9, 0.95, 0.999, 0.999_999] {
            for df in [999.0, 1000.0, 1500.0] {
                let (searched, corrected) =
                    (searched(level, &distribution(df).unwrap()), corrected(level, df));
                assert!((searched / corrected - 1.0).abs() < 2e-12, "level {level}, df {df}");
            }
        }
    }

    #[test]
    fn one_degree_of_freedom_is_the_cauchy_distribution() {
        for t in [0.3, 1.0, 12.0] {
            let p = 1.0 - 2.0 / core::f64::consts::PI * libm::atan(t);
            assert!((tails(t, &distribution(1.0).unwrap()) - p).abs() < 1e-14);
            assert_eq!(
                (two_sided_p(t, 1.0), two_sided_p(-t, 1.0)),
                (Ok(rounded(p)), Ok(rounded(p)))
            );
        }
    }

    /// mpmath 1.3, 30 digits: `betainc(df/2, 1/2, 0, df/(df + t**2), regularized=True)`.
    #[test]
    fn p_values_are_those_of_arithmetic_with_thirty_digits() {
        const T: [f64; 4] = [0.1, 1.7, 6.0, 40.0];
        let cases = [
            (
                1.0,
                [0.9365489651388929, 0.3385060546606653, 0.1051369134225069, 0.01591217982405163],
            ),
            (
                3.7,
                [
                    0.9255252674701902,
                    0.1701246324928596,
                    0.004964571300739029,
                    5.138624982141498e-6,
                ],
            ),
            (
                41.0,
                [
                    0.9208317092224062,
                    0.09670636782000923,
                    4.32661581037801e-7,
                    1.780242905025896e-34,
                ],
            ),
            (
                250.0,
                [
                    0.9204244692958168,
                    0.09037462132103607,
                    6.887649707353068e-9,
                    1.201787832658829e-110,
                ],
            ),
            (10_000.0, [0.9203463300310749, 0.08916202272770505, 2.041618472922615e-9, 0.0]),
        ];
        for (df, expect) in cases {
            for (t, expect) in T.into_iter().zip(expect) {
                let found = tails(t, &distribution(df).unwrap());
                assert!(
                    (found - expect).abs() <= 1e-10 * expect + 1e-300,
                    "t {t} df {df}: {found}"
                );
                assert_eq!(two_sided_p(-t, df).ok(), Some(rounded(found)));
            }
        }
    }

    #[test]
    fn the_p_value_of_a_critical_value_is_what_its_level_leaves() {
        for df in [0.5, 1.0, 3.7, 10.0, 41.0, 250.0, 999.0, 1001.0, 10_000.0] {
            for level in [0.1, 0.5, 0.95, 0.999, 0.999_999] {
                let p = two_sided_p(critical_value(level, df).unwrap(), df).unwrap();
                // nine digits of t leave eight of p, times the slope of ln p
                assert!((p / (1.0 - level) - 1.0).abs() < 2e-7, "level {level}, df {df}: {p}");
            }
        }
    }

    #[test]
    fn many_degrees_of_freedom_are_the_normal_distribution() {
        let normal_975 = 1.959963984540054; // scipy.stats.norm.ppf(0.975)
        assert!((critical_value(0.95, 1e8).unwrap() - normal_975).abs() < 5e-8);
        assert_eq!(critical_value(0.95, 1e15), Ok(rounded(normal_975)));
    }

    #[test]
    fn requests_without_an_answer_are_refused() {
        assert_eq!(critical_value(1.0, 5.0), Err(StatsError::Level { level: 1.0 }));
        assert_eq!(critical_value(0.95, 0.0), Err(StatsError::DegreesOfFreedom { df: 0.0 }));
        assert!(
            critical_value(0.95, f64::INFINITY).is_err() && two_sided_p(1.0, f64::NAN).is_err()
        );
        assert_eq!((two_sided_p(0.0, 3.0), two_sided_p(f64::INFINITY, 3.0)), (Ok(1.0), Ok(0.0)));
        assert!(two_sided_p(f64::NAN, 3.0).is_err());
    }
}
