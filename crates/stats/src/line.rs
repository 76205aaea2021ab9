//! The slope of a straight line, over strata that each have their own level.

use crate::tested::{at_least, not_constant};
use crate::welch::tested;
use crate::{Tested, Unestimable, error::check_level};

/// The least-squares slope of y = level of the stratum + slope · x, over strata of points [x, y].
///
/// b = Σ (x − x̄ₛ)(y − ȳₛ) / Σ (x − x̄ₛ)²: the within-strata (fixed-effects) slope. `None` where no
/// stratum has two different x. Unit: that of y per unit of x.
pub fn slope(strata: &[Vec<[f64; 2]>]) -> Option<f64> {
    let [xx, xy, _] = within(strata);
    (xx > 0.0).then(|| xy / xx)
}

/// [`slope`] with its standard error and its test against zero: s² = RSS / (n − S − 1) over n
/// points in S strata, SE = s / √Σ (x − x̄ₛ)². Independent, equally scattered errors are assumed.
///
/// # Errors
/// Points that leave no degree of freedom; x that does not vary; points without any scatter around
/// the line; `level` outside (0, 1).
pub fn common_slope(strata: &[Vec<[f64; 2]>], level: f64) -> Result<Tested, Unestimable> {
    check_level(level)?;
    let points: usize = strata.iter().map(Vec::len).sum();
    // A level per stratum with points, and the slope.
    let used = strata.iter().filter(|stratum| !stratum.is_empty()).count() + 1;
    let [xx, xy, yy] = within(strata);
    at_least("trials", points, used + 1)?;
    not_constant("repeats", xx <= 0.0)?;
    let (slope, df) = (xy / xx, (points - used) as f64);
    let left = yy - slope * xy;
    // What rounding leaves of yy is no scatter.
    not_constant("distances from the line", left <= yy * points as f64 * f64::EPSILON)?;
    Ok(tested(slope, (left / df / xx).sqrt(), df, level)?)
}

/// Sums of squares and products around each stratum's means: xx, xy, yy.
fn within(strata: &[Vec<[f64; 2]>]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for stratum in strata {
        let n = stratum.len() as f64;
        let mean = [0, 1].map(|i| stratum.iter().map(|point| point[i]).sum::<f64>() / n);
        for point in stratum {
            let x = point[0] - mean[0];
            let y = point[1] - mean[1];
            sums = [sums[0] + x * x, sums[1] + x * y, sums[2] + y * y];
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    const FIRST: [[f64; 2]; 5] = [[1.0, 2.1], [2.0, 2.9], [3.0, 3.2], [4.0, 4.4], [5.0, 4.6]];
    const SECOND: [[f64; 2]; 4] = [[1.0, 5.3], [2.0, 5.4], [3.0, 6.6], [4.0, 6.9]];

    /// R: `summary(lm(y ~ x + factor(s)))` and `confint`.
    #[test]
    fn the_slope_over_two_strata_is_that_of_r() {
        let found = common_slope(&[FIRST.to_vec(), SECOND.to_vec()], 0.95).unwrap();
        for (found, r) in [
            (found.estimate, 0.633_333_333_333_333),
            (found.std_error, 0.067_109_639_424_628_9),
            (found.statistic, 9.437_293_044_088_43),
            (found.p_value, 8.050_689_229_498_99e-5),
            (found.ci_low, 0.469_121_961_299_143),
            (found.ci_high, 0.797_544_705_367_524),
        ] {
            assert!((found - r).abs() < 2e-8 * r.abs(), "{found} {r}");
        }
        assert!((found.df - 6.0).abs() < 1e-12);
    }

    #[test]
    fn levels_do_not_count_and_one_point_a_stratum_says_nothing() {
        let raised = FIRST.map(|[x, y]| [x, y + 100.0]);
        let slopes = [FIRST, raised].map(|stratum| slope(&[stratum.to_vec()]).unwrap());
        assert!((slopes[0] - slopes[1]).abs() < 1e-12);
        assert_eq!(slope(&[vec![[1.0, 2.0]], vec![[2.0, 3.0]]]), None);
        let one = common_slope(&[vec![[1.0, 2.0]], vec![[2.0, 3.0]]], 0.95).unwrap_err();
        assert_eq!(one, Unestimable::TooFew { units: "trials", found: 2, needed: 4 });
        let exact: Vec<_> = [1.0, 2.0, 3.0, 4.0].map(|x| [x, 2.0 * x]).to_vec();
        assert!(matches!(common_slope(&[exact], 0.95), Err(Unestimable::Constant { .. })));
    }
}
