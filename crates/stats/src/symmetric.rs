//! Small symmetric positive definite systems, by Cholesky's decomposition.
//!
//! Its rows are lists, as information matrices and covariances of results are, and a triangle
//! exists for any pivots above zero: next to separation those are tiny without being rounding.
//! [`crate::matrix`], of the linear mixed models, calls a matrix singular where a pivot is 1e-14 of
//! its entry.

/// The lower triangle L of A = L Lᵀ, row by row; `None` where A is not positive definite.
pub(crate) fn cholesky(a: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
    let mut l: Vec<Vec<f64>> = Vec::with_capacity(a.len());
    for (i, row) in a.iter().enumerate() {
        let mut new = Vec::with_capacity(i + 1);
        for (j, &entry) in row[..i].iter().enumerate() {
            let known: f64 = new.iter().zip(&l[j][..j]).map(|(x, y)| x * y).sum();
            new.push((entry - known) / l[j][j]);
        }
        let pivot = row[i] - new.iter().map(|x| x * x).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return None;
        }
        new.push(pivot.sqrt());
        l.push(new);
    }
    Some(l)
}

/// Solves L Lᵀ x = b.
pub(crate) fn solve(l: &[Vec<f64>], b: &[f64]) -> Vec<f64> {
    let mut x = b.to_vec();
    for i in 0..x.len() {
        let known: f64 = (0..i).map(|j| l[i][j] * x[j]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    for i in (0..x.len()).rev() {
        let known: f64 = (i + 1..x.len()).map(|j| l[j][i] * x[j]).sum();
        x[i] = (x[i] - known) / l[i][i];
    }
    x
}

/// (L Lᵀ)⁻¹, row by row.
pub(crate) fn inverse(l: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let size = l.len();
    (0..size)
        .map(|i| {
            let unit: Vec<f64> = (0..size).map(|j| f64::from(u8::from(i == j))).collect();
            solve(l, &unit)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::matrix::dot;

    #[test]
    fn a_system_with_a_known_triangle_is_solved() {
        let a = vec![vec![4.0, 2.0, -2.0], vec![2.0, 10.0, 5.0], vec![-2.0, 5.0, 21.0]];
        let l = cholesky(&a).unwrap();
        assert_eq!(l, [vec![2.0], vec![1.0, 3.0], vec![-1.0, 2.0, 4.0]]);
        let x = solve(&l, &[0.0, 27.0, 71.0]);
        for (row, b) in a.iter().zip([0.0, 27.0, 71.0]) {
            assert!((dot(row, &x) - b).abs() < 1e-12);
        }
        for (i, row) in inverse(&l).iter().enumerate() {
            for (j, other) in a.iter().enumerate() {
                assert!((dot(row, other) - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_no_triangle() {
        assert_eq!(cholesky(&[vec![1.0, 2.0], vec![2.0, 4.0]]), None);
        assert_eq!(cholesky(&[vec![f64::NAN]]), None);
    }
}
