//! Linear combinations of the coefficients, as both kinds of degrees of freedom use them.

use super::design::Design;
use crate::error::{StatsError, all_finite, same_length};
use crate::f_distribution::upper_p;
use crate::tested::{FTest, Tested, Unestimable};
use crate::welch::tested;

use zwidth_numerics::dense::{Matrix, dot};

/// A variance below this share of its parts is rounding: the contrasts say one thing twice.
const SAME_TWICE: f64 = 1e-10;

/// Contrasts L β: their estimates, and L in coordinates of Q.
pub(super) struct Contrasts {
    pub(super) estimates: Vec<f64>,
    pub(super) l: Matrix,
}

/// Contrasts of `weights` per coefficient.
pub(super) fn contrasts(
    design: &Design,
    coefficients: &[f64],
    weights: &[&[f64]],
) -> Result<Contrasts, StatsError> {
    let expected = coefficients.len();
    for row in weights {
        same_length("a contrast", expected, row.len())?;
        all_finite(row)?;
    }
    let rows = Matrix::from_fn(weights.len(), expected, |i, j| weights[i][j]);
    Ok(Contrasts {
        estimates: weights.iter().map(|row| dot(row, coefficients)).collect(),
        l: rows.times(&design.r_inverse),
    })
}

/// L M Lᵀ.
pub(super) fn sandwich(l: &Matrix, m: &Matrix) -> Matrix {
    l.times(&m.times(&l.transpose()))
}

/// Refuses contrasts of which one follows from the others.
pub(super) fn check_independent(variances: &Matrix) -> Result<(), Unestimable> {
    let diagonal = variances.diagonal();
    let dependent = Unestimable::Confounded { what: "the contrasts".to_owned() };
    if diagonal.iter().any(|v| v.is_nan() || *v <= 0.0) {
        return Err(dependent);
    }
    let scaled = Matrix::from_fn(variances.rows, variances.rows, |i, j| {
        variances[(i, j)] / (diagonal[i] * diagonal[j]).sqrt()
    });
    if scaled.eigen().0.iter().any(|v| *v < SAME_TWICE) { Err(dependent) } else { Ok(()) }
}

/// The t test of an estimate.
pub(super) fn t_test(
    estimate: f64,
    variance: f64,
    df: f64,
    level: f64,
) -> Result<Tested, Unestimable> {
    let std_error = variance.sqrt();
    all_finite(&[estimate, std_error])?;
    Ok(tested(estimate, std_error, df, level)?)
}

/// The F test of a statistic.
pub(super) fn f_test(statistic: f64, df_num: f64, df_den: f64) -> Result<FTest, Unestimable> {
    Ok(FTest { statistic, df_num, df_den, p_value: upper_p(statistic, df_num, df_den)? })
}
