//! Small dense systems: matrices whose size is set when they are made, stored row by row, and the
//! solvers of the workspace, in plain loops of a fixed order.
//!
//! There is one implementation of each method. Systems of symmetric positive definite matrices go
//! by Cholesky's triangle ([`Matrix::cholesky`]) or, with a size known to the compiler and unknowns
//! that may have to be left out, by elimination ([`solve_symmetric`]); inverses of matrices of a
//! fixed size by Gauss and Jordan ([`crate::expm::Matrix::inverse_by`]); fits with many rows by
//! reflections ([`crate::lsq`]). They are not one method because each rounds differently, and
//! results of each are stored and compared to the last bit.

use core::ops::{Index, IndexMut};

/// Off-diagonal entries below this share of the largest diagonal one end Jacobi's rotations.
const ROTATED: f64 = 1e-15;
/// More sweeps than any symmetric matrix of this size takes (it takes six to ten).
const MAX_SWEEPS: usize = 60;
/// If less than this share of a diagonal entry remains, the rest is rounding: the matrix is
/// singular.
pub const SINGULAR: f64 = 1e-14;

/// A matrix of `rows` × `cols` numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    data: Vec<f64>,
}

impl Index<(usize, usize)> for Matrix {
    type Output = f64;
    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.data[i * self.cols + j]
    }
}

impl IndexMut<(usize, usize)> for Matrix {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.data[i * self.cols + j]
    }
}

impl Matrix {
    /// All entries zero.
    pub fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, data: vec![0.0; rows * cols] }
    }

    /// The identity.
    pub fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| if i == j { 1.0 } else { 0.0 })
    }

    /// The matrix whose entry in row `i`, column `j` is `f(i, j)`.
    pub fn from_fn(rows: usize, cols: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        let mut data = Vec::with_capacity(rows * cols);
        for i in 0..rows {
            data.extend((0..cols).map(|j| f(i, j)));
        }
        Self { rows, cols, data }
    }

    /// Row `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.cols..(i + 1) * self.cols]
    }

    /// Row `i`, to be changed.
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.cols..(i + 1) * self.cols]
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.rows).map(|i| self[(i, i)]).collect()
    }

    /// Aᵀ.
    pub fn transpose(&self) -> Self {
        Self::from_fn(self.cols, self.rows, |i, j| self[(j, i)])
    }

    /// A B.
    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.cols);
        for i in 0..self.rows {
            for (k, a) in self.row(i).iter().enumerate() {
                add_scaled(product.row_mut(i), *a, other.row(k));
            }
        }
        product
    }

    /// Aᵀ B.
    pub fn transposed_times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.cols, other.cols);
        for k in 0..self.rows {
            for (i, a) in self.row(k).iter().enumerate() {
                add_scaled(product.row_mut(i), *a, other.row(k));
            }
        }
        product
    }

    /// A v.
    pub fn times_vector(&self, v: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|i| dot(self.row(i), v)).collect()
    }

    /// Aᵀ v.
    pub fn transposed_times_vector(&self, v: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.cols];
        v.iter().enumerate().for_each(|(i, v)| add_scaled(&mut product, *v, self.row(i)));
        product
    }

    /// A ← A + s B.
    pub fn add(&mut self, scale: f64, other: &Self) {
        add_scaled(&mut self.data, scale, &other.data);
    }

    /// A ← A + s v wᵀ.
    pub fn add_outer(&mut self, scale: f64, v: &[f64], w: &[f64]) {
        v.iter().enumerate().for_each(|(i, v)| add_scaled(self.row_mut(i), scale * v, w));
    }

    /// tr(Aᵀ B), the sum of the products entry by entry.
    pub fn dot(&self, other: &Self) -> f64 {
        dot(&self.data, &other.data)
    }

    /// vᵀ A w.
    pub fn form(&self, v: &[f64], w: &[f64]) -> f64 {
        v.iter().enumerate().map(|(i, v)| v * dot(self.row(i), w)).sum()
    }

    /// The lower triangle L with L Lᵀ = A, of a symmetric A (Golub & Van Loan, *Matrix
    /// Computations*, 4th ed., §4.2). `None` if A is not positive definite: if the remainder of a
    /// diagonal entry is no more than `least_share` of it. With [`SINGULAR`] a matrix that is
    /// singular up to rounding is refused; with 0 any existing triangle counts, as next to
    /// separation, where the remainder is tiny without being rounding.
    pub fn cholesky(&self, least_share: f64) -> Option<Self> {
        let mut l = Self::zeros(self.rows, self.rows);
        for i in 0..self.rows {
            for j in 0..=i {
                let rest = self[(i, j)] - dot(&l.row(i)[..j], &l.row(j)[..j]);
                if i > j {
                    l[(i, j)] = rest / l[(j, j)];
                } else if rest > least_share * self[(i, i)] {
                    l[(i, i)] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(l)
    }

    /// Solves L Lᵀ x = b, this matrix being the lower triangle L.
    pub fn solve_by_triangle(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        for i in 0..x.len() {
            x[i] = (x[i] - dot(&self.row(i)[..i], &x[..i])) / self[(i, i)];
        }
        back_substitute(|i, j| self[(j, i)], &mut x);
        x
    }

    /// (L Lᵀ)⁻¹ row by row, this matrix being the lower triangle L: one system a row. By
    /// [`Matrix::lower_inverse`] its last digits are others; covariances of ordinal models are
    /// stored with those of this one.
    pub fn inverse_by_triangle(&self) -> Vec<Vec<f64>> {
        let identity = Self::identity(self.rows);
        (0..self.rows).map(|i| self.solve_by_triangle(identity.row(i))).collect()
    }

    /// L⁻¹ of a lower triangle without zeros on its diagonal.
    pub fn lower_inverse(&self) -> Self {
        let mut inverse = Self::zeros(self.rows, self.rows);
        for i in 0..self.rows {
            let (above, rest) = inverse.data.split_at_mut(i * self.rows);
            let row = &mut rest[..self.rows];
            for k in 0..i {
                add_scaled(&mut row[..=k], -self[(i, k)], &above[k * self.rows..][..=k]);
            }
            row[i] = 1.0;
            row[..=i].iter_mut().for_each(|entry| *entry /= self[(i, i)]);
        }
        inverse
    }

    /// A⁻¹ and ln det A of a symmetric A that is positive definite to rounding; `None` if it is not.
    pub fn inverse_and_log_det(&self) -> Option<(Self, f64)> {
        let l = self.cholesky(SINGULAR)?;
        let root = l.lower_inverse();
        let log_det = l.diagonal().iter().map(|d| 2.0 * libm::log(*d)).sum();
        Some((root.transposed_times(&root), log_det))
    }

    /// Eigenvalues, and the eigenvectors as rows in the same order, of a symmetric matrix, by
    /// Jacobi's rotations (Golub & Van Loan, *Matrix Computations*, 4th ed., §8.5).
    pub fn eigen(&self) -> (Vec<f64>, Self) {
        let mut a = self.clone();
        let mut vectors = Self::identity(self.rows);
        let scale = self.data.iter().fold(0.0_f64, |most, x| x.abs().max(most));
        for _ in 0..MAX_SWEEPS {
            let mut rotated = false;
            for p in 0..self.rows {
                for q in p + 1..self.rows {
                    if a[(p, q)].abs() > ROTATED * scale {
                        rotate(&mut a, &mut vectors, p, q);
                        rotated = true;
                    }
                }
            }
            if !rotated {
                break;
            }
        }
        (a.diagonal(), vectors)
    }
}

/// One rotation that makes entry (p, q) zero.
fn rotate(a: &mut Matrix, vectors: &mut Matrix, p: usize, q: usize) {
    let tau = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
    // The sign of 0 is 1: equal diagonal entries are turned by 45°.
    let t = tau.signum() / (tau.abs() + (1.0 + tau * tau).sqrt());
    let c = 1.0 / (1.0 + t * t).sqrt();
    let s = t * c;
    for k in 0..a.rows {
        let x = a[(k, p)];
        let y = a[(k, q)];
        (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
    }
    for m in [a, vectors] {
        for k in 0..m.cols {
            let x = m[(p, k)];
            let y = m[(q, k)];
            (m[(p, k)], m[(q, k)]) = (c * x - s * y, s * x + c * y);
        }
    }
}

/// Solves A x = b for a symmetric positive definite A by elimination without pivoting (Golub & Van
/// Loan, §4.1). Unknown `j` stays 0 if `is_left_out(j, pivot)` says so, given the remainder of its
/// diagonal entry: it is held, or the ones before it explain it wholly.
pub fn solve_symmetric<const P: usize>(
    mut a: [[f64; P]; P],
    mut b: [f64; P],
    is_left_out: impl Fn(usize, f64) -> bool,
) -> [f64; P] {
    for j in 0..P {
        if is_left_out(j, a[j][j]) {
            // Its row is that of the identity, and the row of no other needs it.
            a[j] = [0.0; P];
            a[j][j] = 1.0;
            b[j] = 0.0;
            continue;
        }
        let pivot_row = a[j];
        for i in j + 1..P {
            let share = a[i][j] / pivot_row[j];
            for k in j..P {
                a[i][k] -= share * pivot_row[k];
            }
            b[i] -= share * b[j];
        }
    }
    back_substitute(|i, j| a[i][j], &mut b);
    b
}

/// Solves U x = b for an upper triangle `u` without zeros on its diagonal, in the place of b, from
/// the last unknown on.
pub(crate) fn back_substitute(u: impl Fn(usize, usize) -> f64, x: &mut [f64]) {
    for i in (0..x.len()).rev() {
        let solved: f64 = (i + 1..x.len()).map(|j| u(i, j) * x[j]).sum();
        x[i] = (x[i] - solved) / u(i, i);
    }
}

/// v ← v + s w.
pub fn add_scaled(v: &mut [f64], scale: f64, w: &[f64]) {
    v.iter_mut().zip(w).for_each(|(v, w)| *v += scale * w);
}

/// a · b.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Hilbert-like matrix 1 / (i + j + 1) + δ: symmetric, positive definite.
    fn sample(size: usize) -> Matrix {
        Matrix::from_fn(size, size, |i, j| {
            1.0 / (i + j + 1) as f64 + if i == j { 1.0 } else { 0.0 }
        })
    }

    fn assert_close(a: &Matrix, b: &Matrix) {
        let largest = a.data.iter().zip(&b.data).fold(0.0_f64, |m, (a, b)| (a - b).abs().max(m));
        assert!(largest < 1e-13, "{a:?} {b:?}");
    }

    #[test]
    fn a_matrix_times_its_inverse_is_the_unit() {
        let a = sample(5);
        let (inverse, log_det) = a.inverse_and_log_det().unwrap();
        assert_close(&a.times(&inverse), &Matrix::identity(5));
        let (values, _) = a.eigen();
        let product: f64 = values.iter().product();
        assert!((libm::log(product) - log_det).abs() < 1e-13);
        assert!(Matrix::from_fn(2, 2, |_, _| 1.0).inverse_and_log_det().is_none());
    }

    #[test]
    fn eigenvectors_and_values_make_the_matrix_again() {
        let a = sample(6);
        let (values, vectors) = a.eigen();
        let scaled = Matrix::from_fn(6, 6, |i, j| values[i] * vectors[(i, j)]);
        assert_close(&vectors.transposed_times(&scaled), &a);
        assert_close(&vectors.times(&vectors.transpose()), &Matrix::identity(6));
    }

    #[test]
    fn a_system_with_a_known_triangle_is_solved() {
        let rows = [[4.0, 2.0, -2.0], [2.0, 10.0, 5.0], [-2.0, 5.0, 21.0]];
        let a = Matrix::from_fn(3, 3, |i, j| rows[i][j]);
        let l = a.cholesky(0.0).unwrap();
        let triangle = [[2.0, 0.0, 0.0], [1.0, 3.0, 0.0], [-1.0, 2.0, 4.0]];
        assert_eq!(l, Matrix::from_fn(3, 3, |i, j| triangle[i][j]));
        let b = [0.0, 27.0, 71.0];
        let eliminated = solve_symmetric(rows, b, |_, _| false);
        for x in [&l.solve_by_triangle(&b)[..], &eliminated] {
            for (row, b) in rows.iter().zip(b) {
                assert!((dot(row, x) - b).abs() < 1e-12);
            }
        }
        for (i, row) in l.inverse_by_triangle().iter().enumerate() {
            for (j, other) in rows.iter().enumerate() {
                assert!((dot(row, other) - f64::from(u8::from(i == j))).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_matrix_that_is_not_positive_definite_has_no_triangle() {
        assert_eq!(
            Matrix::from_fn(2, 2, |i, j| [[1.0, 2.0], [2.0, 4.0]][i][j]).cholesky(0.0),
            None
        );
        assert_eq!(Matrix::from_fn(1, 1, |_, _| f64::NAN).cholesky(0.0), None);
        let nearly = Matrix::from_fn(2, 2, |i, j| if i + j == 2 { 1.0 + 1e-15 } else { 1.0 });
        assert!(nearly.cholesky(0.0).is_some() && nearly.cholesky(SINGULAR).is_none());
    }

    #[test]
    fn an_unknown_that_is_left_out_is_0_and_the_others_are_those_of_the_system_without_it() {
        let a = [[4.0, 2.0, -2.0], [2.0, 10.0, 5.0], [-2.0, 5.0, 21.0]];
        let x = solve_symmetric(a, [6.0, 1.0, 4.0], |j, _| j == 1);
        let without = solve_symmetric([[4.0, -2.0], [-2.0, 21.0]], [6.0, 4.0], |_, _| false);
        assert_eq!(x[..], [without[0], 0.0, without[1]]);
    }

    #[test]
    fn products_agree_with_each_other() {
        let a = Matrix::from_fn(3, 2, |i, j| (1 + i * 2 + j) as f64);
        let b = Matrix::from_fn(3, 4, |i, j| (i as f64) - 0.5 * j as f64);
        assert_close(&a.transposed_times(&b), &a.transpose().times(&b));
        let v = [1.0, -2.0, 0.5];
        assert_eq!(a.transposed_times_vector(&v), a.transpose().times_vector(&v));
    }
}
