//! Two modes felt by the same participants: the mean of their differences, and whether it is too
//! small to matter.
//!
//! One pair per participant: their mean in mode A, their mean in mode B. The differences have their
//! own variance, so nothing is assumed about the other modes; on balanced data this is the mixed
//! model whose participants differ freely in every mode.

use crate::error::{StatsError, all_finite};
use crate::interval::t_interval;
use crate::student_t::two_sided_p;
use crate::tested::not_constant;
use crate::welch::tested;
use crate::{Tested, Unestimable};
use zwidth_numerics::moments::Moments;

/// A difference below this share of its two terms is their rounding: it is no difference.
const ROUNDING: f64 = 1e-12;

/// A standard error below this many roundings of the mean says that the values are one value (the
/// rule of R's `t.test`).
pub(crate) const ROUNDINGS: f64 = 10.0;

/// The differences A − B of `pairs` [A, B], in their order. Unit as the values.
///
/// A difference that is only the rounding of the values (10⁻¹² of the largest of them) is exactly
/// zero, and differences that are one value up to that rounding are exactly one value: equal values
/// count as equal however they were computed.
pub fn differences(pairs: &[[f64; 2]]) -> Vec<f64> {
    let bound = rounding(pairs);
    let plain = pairs.iter().map(|[a, b]| a - b);
    let differences: Vec<f64> = plain.map(|d| if d.abs() <= bound { 0.0 } else { d }).collect();
    match differences.first() {
        Some(first) if differences.iter().all(|d| (d - first).abs() <= bound) => {
            vec![*first; differences.len()]
        }
        _ => differences,
    }
}

/// Whether a difference made of these values is only their rounding.
pub fn is_rounding(difference: f64, pairs: &[[f64; 2]]) -> bool {
    difference.abs() <= rounding(pairs)
}

/// The size of these values' rounding; 0 where one of them is not finite.
fn rounding(pairs: &[[f64; 2]]) -> f64 {
    let largest = pairs.iter().flatten().fold(0.0, |most: f64, value| most.max(value.abs()));
    if largest.is_finite() { ROUNDING * largest } else { 0.0 }
}

/// a − b, exactly zero where it is only rounding.
pub(crate) fn difference(a: f64, b: f64) -> f64 {
    let rounding = ROUNDING * a.abs().max(b.abs());
    if (a - b).abs() <= rounding { 0.0 } else { a - b }
}

/// The mean of participants' paired differences, with its interval at confidence `level` and its
/// test against zero: d̄, s / √n, t = d̄ / (s / √n) with n − 1 degrees of freedom (Student 1908,
/// Biometrika 6:1). Units as the differences.
///
/// # Errors
/// Fewer than two differences; differences that are all zero, or all equal; a value that is not
/// finite; `level` outside (0, 1).
pub fn mean_difference(differences: &[f64], level: f64) -> Result<Tested, Unestimable> {
    all_finite(differences)?;
    let n = differences.len();
    let moments = Moments::of(differences);
    let Some(sd) = moments.sd() else {
        return Err(Unestimable::TooFew { units: "participants", found: n, needed: 2 });
    };
    let largest = differences.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    if largest <= 0.0 {
        return Err(Unestimable::NoDifference);
    }
    // Differences that cancel leave the rounding of their sum.
    let mean = if moments.mean.abs() <= ROUNDING * largest { 0.0 } else { moments.mean };
    let std_error = sd / (n as f64).sqrt();
    not_constant("differences", std_error <= ROUNDINGS * f64::EPSILON * mean.abs())?;
    all_finite(&[mean, std_error])?;
    Ok(tested(mean, std_error, (n - 1) as f64, level)?)
}

/// The differences that are not zero: there must be one at least.
pub(crate) fn nonzero(differences: &[f64]) -> Result<Vec<f64>, Unestimable> {
    let nonzero: Vec<f64> = differences.iter().copied().filter(|d| d.abs() > 0.0).collect();
    let units = match (differences.is_empty(), nonzero.is_empty()) {
        (true, _) => "participants",
        (false, true) => "differences other than zero",
        (false, false) => return Ok(nonzero),
    };
    Err(Unestimable::TooFew { units, found: 0, needed: 1 })
}

/// Two one-sided tests of "the quantity lies beyond the bound": together they show that it is too
/// small to matter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Equivalence {
    /// The bound δ, set before the data: differences within ± δ do not matter. Unit as the
    /// quantity.
    pub bound: f64,
    /// p value of "the quantity is −δ or less".
    pub p_lower: f64,
    /// p value of "the quantity is δ or more".
    pub p_upper: f64,
    /// Lower end of the interval of level 1 − 2 alpha.
    pub ci_low: f64,
    /// Upper end of that interval; equivalence is shown where the interval lies within ± δ.
    pub ci_high: f64,
}

impl Equivalence {
    /// The p value of both tests together: the larger of the two.
    pub fn p_value(&self) -> f64 {
        self.p_lower.max(self.p_upper)
    }
}

/// Tests whether the quantity behind `tested` lies within ± `bound`, at `alpha` per side
/// (Schuirmann 1987, J. Pharmacokinet. Biopharm. 15:657): t = (estimate ± δ) / std_error with the
/// degrees of freedom of `tested`. The interval has level 1 − 2 alpha: 90 % for 0.05.
///
/// # Errors
/// A bound that is not positive and finite; `alpha` outside (0, 0.5).
pub fn equivalence(tested: &Tested, bound: f64, alpha: f64) -> Result<Equivalence, StatsError> {
    if !(bound > 0.0 && bound.is_finite()) {
        return Err(StatsError::Bound { bound });
    }
    if !(alpha > 0.0 && alpha < 0.5) {
        return Err(StatsError::Alpha { alpha });
    }
    let Tested { estimate, std_error, df, .. } = *tested;
    let interval = t_interval(estimate, std_error, df, 1.0 - 2.0 * alpha)?;
    Ok(Equivalence {
        bound,
        p_lower: upper_tail((estimate + bound) / std_error, df)?,
        p_upper: upper_tail((bound - estimate) / std_error, df)?,
        ci_low: interval.ci_low,
        ci_high: interval.ci_high,
    })
}

/// P(T ≥ t).
fn upper_tail(t: f64, df: f64) -> Result<f64, StatsError> {
    // From the two-sided p, which keeps the digits of a small tail.
    let one_tail = two_sided_p(t, df)? / 2.0;
    Ok(if t > 0.0 { one_tail } else { 1.0 - one_tail })
}

/// The joint verdict of a test of difference and a test of equivalence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// There is a difference, and nothing says that it is too small to matter.
    Different,
    /// There is a difference, and it is too small to matter.
    DifferentBelowBound,
    /// No difference was found, and if there is one it is too small to matter.
    Equivalent,
    /// Neither was shown.
    Undecided,
}

impl Verdict {
    /// The verdict of two p values at `alpha`: that of "no difference" (adjusted where several
    /// claims are made) and that of [`equivalence`], if there is a bound. Each rejects its null
    /// hypothesis if it is below `alpha`.
    pub fn new(p_no_difference: f64, p_not_equivalent: Option<f64>, alpha: f64) -> Verdict {
        let equivalent = p_not_equivalent.is_some_and(|p| p < alpha);
        match (p_no_difference < alpha, equivalent) {
            (true, false) => Verdict::Different,
            (true, true) => Verdict::DifferentBelowBound,
            (false, true) => Verdict::Equivalent,
            (false, false) => Verdict::Undecided,
        }
    }

    /// The verdict in words.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Different => "different",
            Verdict::DifferentBelowBound => "different, within the bound",
            Verdict::Equivalent => "equivalent",
            Verdict::Undecided => "undecided",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIRS: [[f64; 2]; 6] =
        [[5.1, 4.6], [4.8, 4.9], [6.2, 5.1], [5.5, 5.2], [4.9, 4.1], [6.0, 5.6]];

    fn tested() -> Tested {
        mean_difference(&differences(&PAIRS), 0.95).unwrap()
    }

    fn near(found: f64, expected: f64) {
        // Critical values and p values have nine digits, an end of an interval one fewer.
        assert!((found - expected).abs() <= 2e-8 * expected.abs(), "{found} {expected}");
    }

    /// R 4.2: `t.test(a, b, paired = TRUE)`.
    #[test]
    fn the_paired_t_test_is_that_of_r() {
        let found = tested();
        near(found.estimate, 0.5);
        near(found.std_error, 0.1693123346560041);
        near(found.ci_low, 0.06476878798409927);
        near(found.ci_high, 0.935231212015901);
        near(found.statistic, 2.953122116093089);
        near(found.p_value, 0.031770457470854385);
        near(found.df, 5.0);
    }

    /// 0.1 is no sum of powers of two: the differences of these values scatter by their rounding.
    #[test]
    fn differences_that_are_all_rounding_are_none_and_have_no_t() {
        let rounded = [[0.1 + 0.2, 0.3], [1e-17, -3e-17], [0.7 + 0.1, 0.8]];
        assert_eq!(differences(&rounded), [0.0; 3]);
        let none = mean_difference(&differences(&rounded), 0.95);
        assert_eq!(none, Err(Unestimable::NoDifference));
    }

    #[test]
    fn one_difference_computed_in_several_ways_is_one_value() {
        let pairs = [[100.1, 100.0], [200.1, 200.0], [300.1, 300.0]];
        assert!(pairs.iter().any(|[a, b]| a - b > 0.1) && pairs.iter().any(|[a, b]| a - b < 0.1));
        let found = mean_difference(&differences(&pairs), 0.95);
        assert_eq!(found, Err(Unestimable::Constant { units: "differences" }));
    }

    /// Closed form: the differences ±0.1 and ±0.3 have the mean 0, so t = 0 and p = 1.
    #[test]
    fn differences_that_cancel_have_a_t_of_zero() {
        let pairs = [[1.1, 1.0], [1.0, 1.1], [2.3, 2.0], [2.0, 2.3]];
        let found = mean_difference(&differences(&pairs), 0.95).unwrap();
        assert_eq!((found.estimate, found.statistic, found.p_value), (0.0, 0.0, 1.0));
        assert!(found.std_error > 0.1);
    }

    /// R 4.2: `t.test(d, mu = ∓delta, alternative = "greater" / "less")`, `conf.level = 0.9`.
    #[test]
    fn two_one_sided_tests_are_those_of_r() {
        let cases = [
            (0.3, 0.0026096645665138144, 0.8546881064567661),
            (0.9, 0.00021101816096505218, 0.03227531209015782),
            (1.5, 3.826348246936662e-05, 0.0009903607889556227),
        ];
        for (bound, lower, upper) in cases {
            let found = equivalence(&tested(), bound, 0.05).unwrap();
            near(found.p_lower, lower);
            near(found.p_upper, upper);
            near(found.p_value(), upper);
            near(found.ci_low, 0.15882745546620275);
            near(found.ci_high, 0.841172544533798);
        }
    }

    /// The two ways to decide are one: p below alpha, and the interval within the bounds.
    #[test]
    fn equivalence_is_shown_exactly_where_the_interval_lies_within_the_bounds() {
        for step in 1..200 {
            let bound = f64::from(step) * 0.01;
            let found = equivalence(&tested(), bound, 0.05).unwrap();
            let within = -bound < found.ci_low && found.ci_high < bound;
            assert_eq!(found.p_value() < 0.05, within, "{bound}");
        }
    }

    #[test]
    fn there_are_four_verdicts() {
        let cases = [
            (0.01, Some(0.2), Verdict::Different),
            (0.01, None, Verdict::Different),
            (0.01, Some(0.02), Verdict::DifferentBelowBound),
            (0.3, Some(0.02), Verdict::Equivalent),
            (0.3, Some(0.3), Verdict::Undecided),
            (0.3, None, Verdict::Undecided),
            (0.05, Some(0.05), Verdict::Undecided),
        ];
        for (difference, equivalent, verdict) in cases {
            assert_eq!(Verdict::new(difference, equivalent, 0.05), verdict);
        }
        assert_eq!(Verdict::DifferentBelowBound.words(), "different, within the bound");
    }

    #[test]
    fn equal_values_are_no_difference_however_they_were_computed() {
        let pairs = [[0.1 + 0.2, 0.3], [0.3, 0.1 + 0.2], [10.0, 10.0], [1.0, 1.0 + 1e-9]];
        let found = differences(&pairs);
        assert_eq!(found[..3], [0.0; 3]);
        assert!(found[3] < 0.0);
    }

    #[test]
    fn data_without_an_answer_say_why() {
        let words = |values: &[f64]| mean_difference(values, 0.95).unwrap_err().to_string();
        assert_eq!(words(&[]), "0 participants, 2 are needed");
        assert_eq!(words(&[1.0]), "1 participant, 2 are needed");
        let equal = Unestimable::Constant { units: "differences" };
        assert_eq!(mean_difference(&[0.0; 5], 0.95), Err(Unestimable::NoDifference));
        for constant in [&[0.1; 7][..], &[1e-300; 3], &[0.3, 0.1 + 0.2]] {
            assert_eq!(mean_difference(constant, 0.95), Err(equal.clone()));
        }
        assert!(mean_difference(&[0.0, 0.0, 1e-12], 0.95).is_ok());
    }

    #[test]
    fn requests_that_cannot_be_meant_are_refused() {
        let nan = mean_difference(&[1.0, f64::NAN], 0.95);
        assert!(matches!(nan, Err(Unestimable::Refused(StatsError::NonFinite { index: 1, .. }))));
        assert!(mean_difference(&[1.0, 2.0], 95.0).is_err());
        for bound in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(equivalence(&tested(), bound, 0.05), Err(StatsError::Bound { .. })));
        }
        assert_eq!(equivalence(&tested(), 1.0, 0.5), Err(StatsError::Alpha { alpha: 0.5 }));
    }
}
