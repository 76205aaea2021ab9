//! Small dense matrices, row by row: what mixed models ask for, in plain loops of a fixed order.

use core::ops::{Index, IndexMut};

/// Off-diagonal entries below this share of the largest diagonal one end Jacobi's rotations.
const ROTATED: f64 = 1e-15;
/// More sweeps than any symmetric matrix of this size takes (it takes six to ten).
const MAX_SWEEPS: usize = 60;
/// What is left of a diagonal entry below this share of itself is rounding: the matrix is singular.
const SINGULAR: f64 = 1e-14;

/// A matrix of `rows` × `cols` numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Matrix {
    pub(crate) rows: usize,
    pub(crate) cols: usize,
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
    pub(crate) fn zeros(rows: usize, cols: usize) -> Self {
        Self { rows, cols, data: vec![0.0; rows * cols] }
    }

    pub(crate) fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| if i == j { 1.0 } else { 0.0 })
    }

    pub(crate) fn from_fn(rows: usize, cols: usize, f: impl Fn(usize, usize) -> f64) -> Self {
        let mut data = Vec::with_capacity(rows * cols);
        for i in 0..rows {
            data.extend((0..cols).map(|j| f(i, j)));
        }
        Self { rows, cols, data }
    }

    pub(crate) fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.cols..(i + 1) * self.cols]
    }

    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.cols..(i + 1) * self.cols]
    }

    pub(crate) fn diagonal(&self) -> Vec<f64> {
        (0..self.rows).map(|i| self[(i, i)]).collect()
    }

    pub(crate) fn transpose(&self) -> Self {
        Self::from_fn(self.cols, self.rows, |i, j| self[(j, i)])
    }

    /// A B.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.rows, other.cols);
        for i in 0..self.rows {
            for (k, a) in self.row(i).iter().enumerate() {
                add_scaled(product.row_mut(i), *a, other.row(k));
            }
        }
        product
    }

    /// Aᵀ B.
    pub(crate) fn transposed_times(&self, other: &Self) -> Self {
        let mut product = Self::zeros(self.cols, other.cols);
        for k in 0..self.rows {
            for (i, a) in self.row(k).iter().enumerate() {
                add_scaled(product.row_mut(i), *a, other.row(k));
            }
        }
        product
    }

    /// A v.
    pub(crate) fn times_vector(&self, v: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|i| dot(self.row(i), v)).collect()
    }

    /// Aᵀ v.
    pub(crate) fn transposed_times_vector(&self, v: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.cols];
        v.iter().enumerate().for_each(|(i, v)| add_scaled(&mut product, *v, self.row(i)));
        product
    }

    /// A ← A + s B.
    pub(crate) fn add(&mut self, scale: f64, other: &Self) {
        add_scaled(&mut self.data, scale, &other.data);
    }

    /// A ← A + s v wᵀ.
    pub(crate) fn add_outer(&mut self, scale: f64, v: &[f64], w: &[f64]) {
        v.iter().enumerate().for_each(|(i, v)| add_scaled(self.row_mut(i), scale * v, w));
    }

    /// tr(Aᵀ B), the sum of the products entry by entry.
    pub(crate) fn dot(&self, other: &Self) -> f64 {
        dot(&self.data, &other.data)
    }

    /// vᵀ A w.
    pub(crate) fn form(&self, v: &[f64], w: &[f64]) -> f64 {
        v.iter().enumerate().map(|(i, v)| v * dot(self.row(i), w)).sum()
    }

    /// The lower triangle L with L Lᵀ = A, for a symmetric A; `None` if A is not positive definite
    /// to rounding.
    pub(crate) fn cholesky(&self) -> Option<Self> {
        let mut l = Self::zeros(self.rows, self.rows);
        for i in 0..self.rows {
            for j in 0..=i {
                let rest = self[(i, j)] - dot(&l.row(i)[..j], &l.row(j)[..j]);
                if i > j {
                    l[(i, j)] = rest / l[(j, j)];
                } else if rest > SINGULAR * self[(i, i)] {
                    l[(i, i)] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(l)
    }

    /// L⁻¹ of a lower triangle without zeros on its diagonal.
    pub(crate) fn lower_inverse(&self) -> Self {
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

    /// A⁻¹ and ln det A of a symmetric positive definite A; `None` if it is not.
    pub(crate) fn inverse_and_log_det(&self) -> Option<(Self, f64)> {
        let l = self.cholesky()?;
        let root = l.lower_inverse();
        let log_det = l.diagonal().iter().map(|d| 2.0 * libm::log(*d)).sum();
        Some((root.transposed_times(&root), log_det))
    }

    /// Eigenvalues, and the eigenvectors as rows in the same order, of a symmetric matrix, by
    /// Jacobi's rotations (Golub & Van Loan, *Matrix Computations*, 4th ed., §8.5).
    pub(crate) fn eigen(&self) -> (Vec<f64>, Self) {
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
        let (x, y) = (a[(k, p)], a[(k, q)]);
        (a[(k, p)], a[(k, q)]) = (c * x - s * y, s * x + c * y);
    }
    for m in [a, vectors] {
        for k in 0..m.cols {
            let (x, y) = (m[(p, k)], m[(q, k)]);
            (m[(p, k)], m[(q, k)]) = (c * x - s * y, s * x + c * y);
        }
    }
}

/// v ← v + s w.
pub(crate) fn add_scaled(v: &mut [f64], scale: f64, w: &[f64]) {
    v.iter_mut().zip(w).for_each(|(v, w)| *v += scale * w);
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
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
    fn products_agree_with_each_other() {
        let a = Matrix::from_fn(3, 2, |i, j| (1 + i * 2 + j) as f64);
        let b = Matrix::from_fn(3, 4, |i, j| (i as f64) - 0.5 * j as f64);
        assert_close(&a.transposed_times(&b), &a.transpose().times(&b));
        let v = [1.0, -2.0, 0.5];
        assert_eq!(a.transposed_times_vector(&v), a.transpose().times_vector(&v));
    }
}
