//! Small square matrices.
//!
//! A matrix is *split* after `D` entries if its later rows are zero in the first `D` columns: what
//! is left of the state after these entries moves by itself, as an input does. Products of split
//! matrices are split, and their zeros need not be multiplied. Any matrix is split after all its
//! entries (`D = N`).

/// A square matrix, stored by columns, so that a product with a vector runs over whole columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrix<const N: usize> {
    /// `columns[j][i]` is the entry in row `i`, column `j`.
    pub columns: [[f64; N]; N],
}

impl<const N: usize> Matrix<N> {
    /// All entries zero.
    pub const ZERO: Self = Self { columns: [[0.0; N]; N] };

    /// The identity.
    pub fn identity() -> Self {
        Self::from_fn(|i, j| if i == j { 1.0 } else { 0.0 })
    }

    /// The matrix whose entry in row `i`, column `j` is `entry(i, j)`.
    pub fn from_fn(entry: impl Fn(usize, usize) -> f64) -> Self {
        Self { columns: std::array::from_fn(|j| std::array::from_fn(|i| entry(i, j))) }
    }

    /// Entry in row `i`, column `j`.
    #[inline]
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.columns[j][i]
    }

    /// `A v`.
    #[inline]
    pub fn apply(&self, v: &[f64; N]) -> [f64; N] {
        self.apply_split::<N>(v)
    }

    /// `A v` for a matrix split after `D`.
    #[inline]
    pub fn apply_split<const D: usize>(&self, v: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        self.add_split::<D>(&mut out, v, N);
        out
    }

    /// The same for a vector that is 0 after its first `D` entries.
    #[inline]
    pub fn apply_head<const D: usize>(&self, v: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        for (column, &x) in self.columns[..D].iter().zip(v).rev() {
            for (o, &c) in out[..D].iter_mut().zip(column) {
                *o += c * x;
            }
        }
        out
    }

    /// `A v` for a vector that ends in 1 and a matrix whose last row is zero but for its last
    /// entry: the form an affine map has in augmented coordinates. The matrix is split after `D`.
    #[inline]
    pub fn apply_affine<const D: usize>(&self, v: &[f64; N]) -> [f64; N] {
        let mut out = self.columns[N - 1];
        self.add_split::<D>(&mut out, v, N - 1);
        out
    }

    /// The same for a vector that ends in 0, the change of one that ends in 1.
    #[inline]
    pub fn apply_change<const D: usize>(&self, v: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        self.add_split::<D>(&mut out, v, N - 1);
        out
    }

    /// Adds to the first `entries` of `out` what as many entries of `v` contribute, for a matrix
    /// split after `D`.
    #[inline(always)]
    fn add_split<const D: usize>(&self, out: &mut [f64; N], v: &[f64; N], entries: usize) {
        // The tail first: it waits for nothing in the head, which changes faster.
        for (j, (column, &x)) in self.columns[..entries].iter().zip(v).enumerate().rev() {
            let rows = match j {
                _ if j < D => D,
                _ if j + 1 < N && D < N => N - 1,
                _ => N,
            };
            for (o, &c) in out[..rows.min(entries)].iter_mut().zip(column) {
                *o += c * x;
            }
        }
    }

    /// `A B`.
    pub fn product(&self, other: &Self) -> Self {
        self.product_split::<N>(other)
    }

    /// `A B` of two matrices split after `D`.
    #[inline]
    pub fn product_split<const D: usize>(&self, other: &Self) -> Self {
        let mut out = Self::ZERO;
        for (j, (sum, column)) in out.columns.iter_mut().zip(&other.columns).enumerate() {
            let entries = if j < D {
                D
            } else if j + 1 < N {
                N - usize::from(D < N)
            } else {
                N
            };
            self.add_split::<D>(sum, column, entries);
        }
        out
    }

    /// `A + x 1`.
    #[inline]
    pub fn shifted(mut self, x: f64) -> Self {
        for (i, column) in self.columns.iter_mut().enumerate() {
            column[i] += x;
        }
        self
    }

    /// `Aᵀ W A`, the form `W` seen from before the map `A`.
    pub fn congruence(&self, form: &Self) -> Self {
        let right = form.product(self);
        Self::from_fn(|i, j| dot(&self.columns[i], &right.columns[j]))
    }

    /// Each entry mapped.
    #[inline]
    pub fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = *self;
        out.columns.as_flattened_mut().iter_mut().for_each(|x| *x = f(*x));
        out
    }

    /// Each pair of entries joined.
    #[inline]
    pub fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = *self;
        for (x, y) in out.columns.as_flattened_mut().iter_mut().zip(other.columns.as_flattened()) {
            *x = f(*x, *y);
        }
        out
    }

    /// `vᵀ A v`.
    #[inline]
    pub fn quadratic(&self, v: &[f64; N]) -> f64 {
        dot(v, &self.apply(v))
    }

    /// The inverse by Gauss–Jordan elimination with row pivoting; `None` if the matrix is singular.
    pub fn inverse(&self) -> Option<Self> {
        self.inverse_by(|rows, k| {
            // In this order a NaN is the largest: it becomes the pivot, and is refused.
            let pivot = (k..N).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs()))?;
            let head = rows[pivot][k];
            (head.is_finite() && head != 0.0).then_some(pivot)
        })
    }

    /// The inverse by Gauss–Jordan elimination (Golub & Van Loan, *Matrix Computations*, 4th ed.,
    /// §3.4); `pivot` chooses, from the remaining rows, the one by which column `k` is divided: row
    /// `k` or a later one. `None` if it finds none.
    pub fn inverse_by(
        &self,
        pivot: impl Fn(&[[f64; N]; N], usize) -> Option<usize>,
    ) -> Option<Self> {
        let mut rows: [[f64; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| self.at(i, j)));
        let mut inverse: [[f64; N]; N] =
            std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        for k in 0..N {
            let chosen = pivot(&rows, k)?;
            rows.swap(k, chosen);
            inverse.swap(k, chosen);
            let head = rows[k][k];
            for j in 0..N {
                rows[k][j] /= head;
                inverse[k][j] /= head;
            }
            let unit = rows[k];
            let image = inverse[k];
            for i in (0..N).filter(|&i| i != k) {
                let factor = rows[i][k];
                for j in 0..N {
                    rows[i][j] -= factor * unit[j];
                    inverse[i][j] -= factor * image[j];
                }
            }
        }
        Some(Self::from_fn(|i, j| inverse[i][j]))
    }

    /// `Aᵀ`.
    pub(crate) fn transposed(&self) -> Self {
        Self::from_fn(|i, j| self.at(j, i))
    }

    /// `A + B`.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        self.zip(other, |a, b| a + b)
    }

    /// True if every entry is finite.
    pub(crate) fn is_finite(&self) -> bool {
        self.columns.iter().flatten().all(|x| x.is_finite())
    }

    /// Largest absolute entry; NaN if any entry is.
    pub(crate) fn largest(&self) -> f64 {
        self.columns
            .iter()
            .flatten()
            .fold(0.0, |m: f64, x| if m.is_nan() || x.is_nan() { f64::NAN } else { m.max(x.abs()) })
    }
}

/// `a · b`.
#[inline]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
