//! The difference of two groups' means whose variances differ, also over several strata.

use crate::error::{StatsError, check_level};
use crate::student_t::{critical_value, two_sided_p};
use crate::tested::{at_least, not_constant};
use crate::{Tested, Unestimable};

/// Size, mean and sample standard deviation of a group.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Group {
    /// Number of values.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Their standard deviation (divisor n − 1).
    pub sd: f64,
}

/// The mean over strata of mean(a) − mean(b), each stratum with the same weight 1/S:
///
/// d = Σ (āₛ − b̄ₛ) / S, SE² = Σ (s²ₐₛ/nₐₛ + s²_bₛ/n_bₛ) / S², and the degrees of freedom of
/// Satterthwaite, SE⁴ / Σ vᵢ²/(nᵢ − 1) with vᵢ the groups' shares of SE².
///
/// One stratum gives Welch's test. Welch, B. L. (1947), Biometrika 34:28–35; Satterthwaite, F. E.
/// (1946), Biometrics Bulletin 2:110–114. Units as the values.
///
/// # Errors
/// No stratum, a group of fewer than two values, groups without any scatter; `level` outside
/// (0, 1).
pub fn difference(strata: &[[Group; 2]], level: f64) -> Result<Tested, Unestimable> {
    // Without strata `combined` refuses: the weight is only to be finite.
    let weight = 1.0 / strata.len().max(1) as f64;
    let terms: Vec<_> = strata.iter().flat_map(|[a, b]| [(weight, *a), (-weight, *b)]).collect();
    combined(&terms, REPEATS, level)
}

/// The mean over strata of their means, each with the same weight, as [`difference`] has it. Its
/// test is against a mean of zero.
///
/// # Errors
/// As those of [`difference`].
pub fn mean(strata: &[Group], level: f64) -> Result<Tested, Unestimable> {
    let weight = 1.0 / strata.len().max(1) as f64;
    combined(&strata.iter().map(|group| (weight, *group)).collect::<Vec<_>>(), REPEATS, level)
}

/// How errors call the values of a group that is a person's condition.
const REPEATS: &str = "repeats of a condition";

/// Σ wᵢ x̄ᵢ of independent groups of `units`.
pub(crate) fn combined(
    terms: &[(f64, Group)],
    units: &'static str,
    level: f64,
) -> Result<Tested, Unestimable> {
    check_level(level)?;
    let fewest = terms.iter().map(|(_, group)| group.n).min().unwrap_or(0);
    at_least(units, fewest, 2)?;
    let estimate: f64 = terms.iter().map(|(weight, group)| weight * group.mean).sum();
    let shares: Vec<f64> = terms
        .iter()
        .map(|(weight, group)| weight * weight * group.sd * group.sd / group.n as f64)
        .collect();
    let variance: f64 = shares.iter().sum();
    not_constant(units, variance <= 0.0)?;
    let groups = shares.iter().zip(terms);
    let spent = groups.map(|(share, (_, group))| share * share / (group.n - 1) as f64);
    let df = variance * variance / spent.sum::<f64>();
    Ok(tested(estimate, variance.sqrt(), df, level)?)
}

/// An estimate with its standard error against zero, by Student's t.
pub(crate) fn tested(
    estimate: f64,
    std_error: f64,
    df: f64,
    level: f64,
) -> Result<Tested, StatsError> {
    let statistic = estimate / std_error;
    let half = critical_value(level, df)? * std_error;
    Ok(Tested {
        estimate,
        std_error,
        ci_low: estimate - half,
        ci_high: estimate + half,
        statistic,
        df,
        p_value: two_sided_p(statistic, df)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_numerics::moments::Moments;

    fn group(values: &[f64]) -> Group {
        let found = Moments::of(values);
        Group { n: values.len(), mean: found.mean, sd: found.sd().unwrap_or(0.0) }
    }

    const A: [f64; 6] = [4.1, 3.9, 4.4, 4.0, 4.6, 4.3];
    const B: [f64; 5] = [3.2, 4.8, 2.9, 3.9, 3.1];

    /// R: `t.test(c(4.1, 3.9, 4.4, 4.0, 4.6, 4.3), c(3.2, 4.8, 2.9, 3.9, 3.1))`.
    #[test]
    fn one_stratum_is_the_test_of_welch_as_r_gives_it() {
        let found = difference(&[[group(&A), group(&B)]], 0.95).unwrap();
        for (found, r) in [
            (found.statistic, 1.745_694_131_092_764),
            (found.df, 4.766_853_551_172_622),
            (found.p_value, 0.144_164_751_657_646),
            (found.ci_low, -0.314_803_233_366_953),
            (found.ci_high, 1.588_136_566_700_286),
        ] {
            assert!((found - r).abs() < 2e-8 * r.abs(), "{found} {r}");
        }
    }

    #[test]
    fn two_equal_strata_have_the_same_estimate_and_half_the_variance() {
        let one = difference(&[[group(&A), group(&B)]], 0.95).unwrap();
        let two = difference(&[[group(&A), group(&B)]; 2], 0.95).unwrap();
        assert!((one.estimate - two.estimate).abs() < 1e-15);
        assert!((one.std_error / two.std_error - 2_f64.sqrt()).abs() < 1e-12);
        assert!((two.df - 2.0 * one.df).abs() < 1e-9);
    }

    #[test]
    fn the_mean_of_one_stratum_is_that_of_student() {
        let found = mean(&[group(&A)], 0.95).unwrap();
        let student = crate::interval::mean(&A, 0.95).unwrap().interval.unwrap();
        assert!((found.ci_low - student.ci_low).abs() < 1e-12);
        assert!((found.ci_high - student.ci_high).abs() < 1e-12 && (found.df - 5.0).abs() < 1e-9);
    }

    #[test]
    fn a_single_repeat_and_repeats_that_are_all_alike_have_no_test() {
        let alone = difference(&[[group(&A), group(&B[..1])]], 0.95).unwrap_err();
        assert_eq!(alone.to_string(), "1 repeat of a condition, 2 are needed");
        let alike = difference(&[[group(&[1.0, 1.0]), group(&[2.0, 2.0])]], 0.95).unwrap_err();
        assert_eq!(alike, Unestimable::Constant { units: "repeats of a condition" });
        assert!(difference(&[], 0.95).is_err());
    }
}
