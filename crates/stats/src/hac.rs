//! Standard errors for fits to recordings, whose samples are neither independent nor of equal
//! variance.

use crate::error::{StatsError, same_length};
use zwidth_numerics::lsq::LinearFit;

/// Covariance of the coefficients of a linear fit that holds under autocorrelation and unequal
/// variance (Newey & West 1987, Econometrica 55:703): (XᵀX)⁻¹ S (XᵀX)⁻¹ with
/// S = Γ₀ + Σₗ (1 − l / (L + 1)) (Γₗ + Γₗᵀ), Γₗ = Σᵢ eᵢ eᵢ₋ₗ xᵢ xᵢ₋ₗᵀ, L = `lags`.
///
/// `columns` are those of the fit, in the order of recording; p × p, in the units of the
/// coefficients. There is no small-sample factor, as in statsmodels' `cov_type="HAC"`. `lags`
/// should span the time over which residuals stay correlated; 0 gives White's
/// heteroscedasticity-consistent covariance. Lags beyond the recording add nothing.
///
/// # Errors
/// Columns that are not those of the fit (number or length).
pub fn newey_west(
    columns: &[&[f64]],
    fit: &LinearFit,
    lags: usize,
) -> Result<Vec<Vec<f64>>, StatsError> {
    let rows = fit.residuals.len();
    same_length("the list of columns", fit.coefficients.len(), columns.len())?;
    columns.iter().try_for_each(|column| same_length("a column", rows, column.len()))?;
    let mut meat = vec![Vec::new(); columns.len()];
    for (a, entries) in columns.iter().zip(&mut meat) {
        for b in columns {
            // Two columns at a time, whose number is known when this is compiled.
            let scores = |row: usize| [a, b].map(|column| column[row] * fit.residuals[row]);
            entries.push(long_run_sum(rows, scores, lags)[0][1]);
        }
    }
    Ok(product(&product(&fit.xtx_inverse, &meat), &fit.xtx_inverse))
}

/// S of the scores of `rows` samples, as Σᵢ Wᵢ Wᵢᵀ / (L + 1), Wᵢ the sum of the scores from i − L
/// to i, those before and after the recording being 0: a pair of scores l apart is in L + 1 − l of
/// these windows, which is Bartlett's weight. As many sums as samples, whatever L; none of a
/// variance that is below 0; and no memory but for the sums.
pub(crate) fn long_run_sum<const N: usize>(
    rows: usize,
    score: impl Fn(usize) -> [f64; N],
    lags: usize,
) -> [[f64; N]; N] {
    // Σ of the scores up to the window's last sample, and up to the one before its first.
    let mut until = [0.0; N];
    let mut before = [0.0; N];
    let mut sums = [[0.0; N]; N];
    for i in 0..rows + lags {
        if i < rows {
            until.iter_mut().zip(score(i)).for_each(|(sum, score)| *sum += score);
        }
        if let Some(gone) = i.checked_sub(lags + 1) {
            before.iter_mut().zip(score(gone)).for_each(|(sum, score)| *sum += score);
        }
        let window: [f64; N] = std::array::from_fn(|a| until[a] - before[a]);
        for (a, row) in sums.iter_mut().enumerate() {
            row.iter_mut().zip(window).for_each(|(sum, other)| *sum += window[a] * other);
        }
    }
    let length = lags as f64 + 1.0;
    sums.map(|row| row.map(|sum| sum / length))
}

/// The product of two square matrices.
fn product(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut product = Vec::with_capacity(a.len());
    for row in a {
        let entries =
            (0..b.len()).map(|k| row.iter().zip(b).map(|(x, other)| x * other[k]).sum::<f64>());
        product.push(entries.collect());
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_numerics::lsq;

    /// 24 rows made from whole numbers, so that another program has the same bits: an intercept, a
    /// ramp, a scrambled column, and errors of an AR(1) process with coefficient 0.7.
    fn design() -> (Vec<Vec<f64>>, Vec<f64>) {
        let rows = 0..24u32;
        let x: Vec<f64> = rows.clone().map(|i| f64::from(i) * 0.5).collect();
        let z: Vec<f64> = rows.clone().map(|i| f64::from(i * 7 % 11) / 11.0).collect();
        let mut u = 0.0;
        let y = rows.map(|i| {
            u = 0.7 * u + f64::from(i * i * 3 % 17) / 17.0 - 0.5;
            1.5 + 0.8 * x[i as usize] - 2.0 * z[i as usize] + u
        });
        let y = y.collect();
        (vec![vec![1.0; 24], x, z], y)
    }

    /// statsmodels: `OLS(y, X).fit(cov_type="HAC", cov_kwds={"maxlags": L}).cov_params()`, upper
    /// triangle.
    #[test]
    fn covariances_agree_with_statsmodels() {
        let statsmodels: [(usize, [f64; 6]); 4] = [
            (
                0,
                [
                    0.016374771043891904,
                    -0.0017240349426456162,
                    -0.01049990508339924,
                    0.0002821035616341792,
                    0.00033303167651565314,
                    0.025210331897950505,
                ],
            ),
            (
                1,
                [
                    0.022975022673867536,
                    -0.002741180818154846,
                    -0.009890030651085957,
                    0.00043768245591946164,
                    0.000687617941443158,
                    0.022036817106299785,
                ],
            ),
            (
                4,
                [
                    0.02298566412212511,
                    -0.002700548359541131,
                    -0.007567546374523853,
                    0.00038020983825328916,
                    0.0008841070039062771,
                    0.00935918816169004,
                ],
            ),
            (
                8,
                [
                    0.014681564569649723,
                    -0.001658012059621575,
                    -0.00649237859377203,
                    0.00021749201554788685,
                    0.0006679631340582704,
                    0.007823176922153712,
                ],
            ),
        ];
        let (columns, y) = design();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fit = lsq::fit(&columns, &y).unwrap();
        for (lags, expected) in statsmodels {
            let c = newey_west(&columns, &fit, lags).unwrap();
            let found = [c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]];
            for (found, expected) in found.iter().zip(expected) {
                assert!((found / expected - 1.0).abs() < 1e-10, "{lags} lags: {found} {expected}");
            }
            assert!((c[0][2] - c[2][0]).abs() < 1e-15);
        }
    }

    /// S lag by lag, as Newey & West write it.
    fn lag_by_lag(scores: &[Vec<f64>], lags: usize) -> Vec<Vec<f64>> {
        let gamma = |a: &[f64], b: &[f64], lag: usize| {
            a.iter().skip(lag).zip(b).map(|(a, b)| a * b).sum::<f64>()
        };
        let weight = |lag: usize| 1.0 - lag as f64 / (lags as f64 + 1.0);
        let entry = |a: &[f64], b: &[f64]| {
            let lagged = |lag| weight(lag) * (gamma(a, b, lag) + gamma(b, a, lag));
            gamma(a, b, 0) + (1..=lags).map(lagged).sum::<f64>()
        };
        scores.iter().map(|a| scores.iter().map(|b| entry(a, b)).collect()).collect()
    }

    #[test]
    fn sums_over_windows_are_the_sums_lag_by_lag_beyond_the_recording_too() {
        let (columns, y) = design();
        let scores = [columns[1].clone(), columns[2].clone(), y];
        for lags in [0, 1, 5, 23, 24, 100] {
            let score = |row: usize| [0, 1, 2].map(|column| scores[column][row]);
            let (found, expect) = (long_run_sum(24, score, lags), lag_by_lag(&scores, lags));
            for (found, expect) in found.iter().flatten().zip(expect.iter().flatten()) {
                assert!((found / expect - 1.0).abs() < 1e-12, "{lags} lags: {found} {expect}");
            }
        }
    }

    #[test]
    fn columns_of_another_fit_are_refused() {
        let (columns, y) = design();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        let fit = lsq::fit(&columns[..2], &y).unwrap();
        assert!(newey_west(&columns, &fit, 1).is_err());
        assert!(newey_west(&[&y[..5], &y[..5]], &fit, 1).is_err());
    }
}
