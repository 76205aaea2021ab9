//! Linear least squares for few columns and many rows, by Householder reflections.
//!
//! Golub & Van Loan, *Matrix Computations*, 4th ed., §5.3.2. The QR route keeps the condition
//! number of X rather than squaring it, as the normal equations would: Longley's data keep ten
//! digits.

use crate::dense::{back_substitute, dot};
use crate::error::{NumericsError, all_finite, same_length};
use crate::moments::Moments;

/// A column whose part not explained by earlier columns is smaller than this share of its length
/// counts as dependent on them: a hundred times the rounding error of a sum over 10 000 rows.
const RANK_TOLERANCE: f64 = 1e-12;

/// The solution of min ‖y − X β‖₂ over n rows and p columns.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearFit {
    /// β, one per column, in the unit of `y` per unit of the column.
    pub coefficients: Vec<f64>,
    /// (XᵀX)⁻¹, p × p, row by row. Times the residual variance it is the covariance of β.
    pub xtx_inverse: Vec<Vec<f64>>,
    /// y − X β, one per row, in the unit of `y`.
    pub residuals: Vec<f64>,
    /// Residual sum of squares Σ (y − X β)², unit of `y` squared.
    pub rss: f64,
    /// Degrees of freedom n − p.
    pub df: usize,
    /// R² = 1 − rss / Σ (y − ȳ)²; `None` for a constant `y`. Meant for fits with a column of ones.
    pub r2: Option<f64>,
}

impl LinearFit {
    /// Residual variance s² = rss / (n − p), unit of `y` squared.
    pub fn residual_variance(&self) -> f64 {
        self.rss / self.df as f64
    }

    /// Standard errors √(s² (XᵀX)⁻¹ⱼⱼ), for independent errors of one variance. Samples of a
    /// recording are not independent: use a heteroscedasticity and autocorrelation consistent
    /// covariance there.
    pub fn std_errors(&self) -> Vec<f64> {
        let s2 = self.residual_variance();
        self.xtx_inverse.iter().enumerate().map(|(j, row)| (s2 * row[j]).sqrt()).collect()
    }
}

/// Fits y = X β by least squares; `columns` are the columns of X (a column of ones is an
/// intercept).
///
/// Cost 2 n p² operations; p is meant to be small (at most about 8).
///
/// # Errors
/// Unequal lengths, a NaN or infinity (with its row), no more rows than columns, linearly dependent
/// columns.
pub fn fit(columns: &[&[f64]], y: &[f64]) -> Result<LinearFit, NumericsError> {
    for (j, column) in columns.iter().enumerate() {
        same_length("a column", y.len(), column.len())?;
        all_finite(|| format!("column {j}"), column)?;
    }
    all_finite(|| "y".to_owned(), y)?;
    // Without a degree of freedom left there is no residual variance.
    if y.len() <= columns.len() {
        return Err(NumericsError::TooFewRows { rows: y.len(), parameters: columns.len() });
    }
    let mut q: Vec<Vec<f64>> = columns.iter().map(|c| c.to_vec()).collect();
    let mut qty = y.to_vec();
    let r = triangularise(&mut q, &mut qty)?;
    let r_inverse = invert_upper(&r);
    let coefficients: Vec<f64> = r_inverse.iter().map(|row| dot(row, &qty[..row.len()])).collect();
    let mut residuals = y.to_vec();
    for (column, b) in columns.iter().zip(&coefficients) {
        residuals.iter_mut().zip(*column).for_each(|(r, x)| *r -= b * x);
    }
    let rss = dot(&residuals, &residuals);
    let total = Moments::of(y).squares;
    // (XᵀX)⁻¹ = R⁻¹ R⁻ᵀ: XᵀX itself, with its squared condition number, is never formed.
    let xtx_inverse = r_inverse
        .iter()
        .map(|row| r_inverse.iter().map(|other| dot(row, other)).collect())
        .collect();
    Ok(LinearFit {
        xtx_inverse,
        coefficients,
        rss,
        df: y.len() - columns.len(),
        r2: (total > 0.0).then(|| 1.0 - rss / total),
        residuals,
    })
}

/// Overwrites the columns with Householder vectors and `y` with Qᵀy; returns the upper triangle R.
fn triangularise(columns: &mut [Vec<f64>], y: &mut [f64]) -> Result<Vec<Vec<f64>>, NumericsError> {
    let p = columns.len();
    let mut r = vec![vec![0.0; p]; p];
    for j in 0..p {
        let (done, rest) = columns.split_at_mut(j + 1);
        let column = &mut done[j];
        // Reflections keep lengths: this is still the length of the column as it was given.
        let whole = dot(column, column).sqrt();
        let tail = dot(&column[j..], &column[j..]).sqrt();
        if tail <= RANK_TOLERANCE * whole {
            return Err(NumericsError::RankDeficient { column: j });
        }
        for (i, row) in r.iter_mut().enumerate().take(j) {
            row[j] = column[i];
        }
        // Of the two signs the one with which nothing cancels in the next line.
        r[j][j] = if column[j] > 0.0 { -tail } else { tail };
        column[j] -= r[j][j];
        let v = &column[j..];
        let v_norm2 = dot(v, v);
        rest.iter_mut().for_each(|other| reflect(v, v_norm2, &mut other[j..]));
        reflect(v, v_norm2, &mut y[j..]);
    }
    Ok(r)
}

/// x ← (I − 2 v vᵀ / ‖v‖²) x.
fn reflect(v: &[f64], v_norm2: f64, x: &mut [f64]) {
    let scale = 2.0 * dot(v, x) / v_norm2;
    x.iter_mut().zip(v).for_each(|(x, v)| *x -= scale * v);
}

/// Inverse of an upper triangle, by back substitution on the unit vectors.
fn invert_upper(r: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let p = r.len();
    let mut inverse = vec![vec![0.0; p]; p];
    for k in 0..p {
        let mut column = vec![0.0; k + 1];
        column[k] = 1.0;
        back_substitute(|i, j| r[i][j], &mut column);
        for (row, x) in inverse.iter_mut().zip(column) {
            row[k] = x;
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_close(found: f64, certified: f64, relative: f64) {
        assert!((found / certified - 1.0).abs() < relative, "{found} against {certified}");
    }

    /// NIST StRD, Norris: certified values.
    #[test]
    fn norris_agrees_with_the_certified_values_to_ten_digits() {
        #[rustfmt::skip]
        let (y, x) = (
            [0.1, 338.8, 118.1, 888.0, 9.2, 228.1, 668.5, 998.5, 449.1, 778.9, 559.2, 0.3, 0.1, 778.1, 668.8, 339.3,
             448.9, 10.8, 557.7, 228.3, 998.0, 888.8, 119.6, 0.3, 0.6, 557.6, 339.3, 888.0, 998.5, 778.9, 10.2, 117.6,
             228.9, 668.4, 449.2, 0.2],
            [0.2, 337.4, 118.2, 884.6, 10.1, 226.5, 666.3, 996.3, 448.6, 777.0, 558.2, 0.4, 0.6, 775.5, 666.9, 338.0,
             447.5, 11.6, 556.0, 228.1, 995.8, 887.6, 120.2, 0.3, 0.3, 556.8, 339.1, 887.2, 999.0, 779.0, 11.1, 118.3,
             229.2, 669.1, 448.9, 0.5],
        );
        let fit = fit(&[&[1.0; 36], &x], &y).unwrap();
        check_close(fit.coefficients[0], -0.262323073774029, 1e-10);
        check_close(fit.coefficients[1], 1.00211681802045, 1e-10);
        check_close(fit.std_errors()[0], 0.232818234301152, 1e-10);
        check_close(fit.std_errors()[1], 0.429796848199937E-03, 1e-10);
        check_close(fit.r2.unwrap(), 0.999993745883712, 1e-10);
        check_close(fit.residual_variance().sqrt(), 0.884796396144373, 1e-10);
        assert_eq!(fit.df, 34);
    }

    /// NIST StRD, Longley: certified values of an ill-conditioned design (condition number 5e9).
    #[test]
    fn longley_agrees_with_the_certified_values_despite_collinearity() {
        let y = [
            60323.0, 61122.0, 60171.0, 61187.0, 63221.0, 63639.0, 64989.0, 63761.0, 66019.0,
            67857.0, 68169.0, 66513.0, 68655.0, 69564.0, 69331.0, 70551.0,
        ];
        let deflator = [
            83.0, 88.5, 88.2, 89.5, 96.2, 98.1, 99.0, 100.0, 101.2, 104.6, 108.4, 110.8, 112.6,
            114.2, 115.7, 116.9,
        ];
        let gnp = [
            234289.0, 259426.0, 258054.0, 284599.0, 328975.0, 346999.0, 365385.0, 363112.0,
            397469.0, 419180.0, 442769.0, 444546.0, 482704.0, 502601.0, 518173.0, 554894.0,
        ];
        let unemployed = [
            2356.0, 2325.0, 3682.0, 3351.0, 2099.0, 1932.0, 1870.0, 3578.0, 2904.0, 2822.0, 2936.0,
            4681.0, 3813.0, 3931.0, 4806.0, 4007.0,
        ];
        let forces = [
            1590.0, 1456.0, 1616.0, 1650.0, 3099.0, 3594.0, 3547.0, 3350.0, 3048.0, 2857.0, 2798.0,
            2637.0, 2552.0, 2514.0, 2572.0, 2827.0,
        ];
        let population = [
            107608.0, 108632.0, 109773.0, 110929.0, 112075.0, 113270.0, 115094.0, 116219.0,
            117388.0, 118734.0, 120445.0, 121950.0, 123366.0, 125368.0, 127852.0, 130081.0,
        ];
        let year: Vec<f64> = (1947..1963).map(f64::from).collect();
        let fit = fit(&[&[1.0; 16], &deflator, &gnp, &unemployed, &forces, &population, &year], &y)
            .unwrap();
        let certified = [
            (-3482258.63459582, 890420.383607373),
            (15.0618722713733, 84.9149257747669),
            (-0.358191792925910E-01, 0.334910077722432E-01),
            (-2.02022980381683, 0.488399681651699),
            (-1.03322686717359, 0.214274163161675),
            (-0.511041056535807E-01, 0.226073200069370),
            (1829.15146461355, 455.478499142212),
        ];
        for ((b, se), (b0, se0)) in fit.coefficients.iter().zip(fit.std_errors()).zip(certified) {
            check_close(*b, b0, 1e-9);
            check_close(se, se0, 1e-9);
        }
        check_close(fit.rss, 836424.055505915, 1e-9);
        check_close(fit.r2.unwrap(), 0.995479004577296, 1e-9);
    }

    #[test]
    fn the_inverse_of_xtx_is_exact_for_an_orthogonal_design() {
        let fit = fit(&[&[1.0; 4], &[-1.0, 1.0, -1.0, 1.0]], &[1.0, 3.0, 1.0, 3.0]).unwrap();
        for (found, expected) in fit.xtx_inverse.concat().iter().zip([0.25, 0.0, 0.0, 0.25]) {
            assert!((found - expected).abs() < 1e-15);
        }
        assert!(
            (fit.coefficients[0] - 2.0).abs() < 1e-14 && (fit.coefficients[1] - 1.0).abs() < 1e-14
        );
    }

    #[test]
    fn r2_of_a_constant_response_is_absent() {
        assert_eq!(fit(&[&[1.0; 3]], &[5.0; 3]).unwrap().r2, None);
    }

    #[test]
    fn bad_input_is_named() {
        let x = [1.0, 2.0, 3.0];
        let check =
            |columns: &[&[f64]], y: &[f64], error| assert_eq!(fit(columns, y).unwrap_err(), error);
        check(
            &[&x, &x],
            &x[..2],
            NumericsError::LengthMismatch { what: "a column", expected: 2, found: 3 },
        );
        check(&[&x, &x, &x], &x, NumericsError::TooFewRows { rows: 3, parameters: 3 });
        check(&[&x, &[2.0, 4.0, 6.0]], &x, NumericsError::RankDeficient { column: 1 });
        check(&[&[0.0; 3]], &x, NumericsError::RankDeficient { column: 0 });
        let nan = fit(&[&x, &[1.0, f64::NAN, 0.0]], &x).unwrap_err();
        assert!(matches!(nan, NumericsError::NonFinite { what, row: 1, .. } if what == "column 1"));
    }
}
