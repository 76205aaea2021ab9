//! Several functionals of the state at once.

use zwidth_numerics::expm::Matrix;

/// `G` functionals of a state of `N` entries, stored by columns like a matrix.
#[derive(Debug, Clone)]
pub(crate) struct Functionals<const N: usize, const G: usize>([[f64; G]; N]);

impl<const N: usize, const G: usize> Functionals<N, G> {
    pub(crate) const ZERO: Self = Self([[0.0; G]; N]);

    /// Each entry mapped.
    pub(crate) fn map(&self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(|column| column.map(&f)))
    }

    /// Each pair of entries joined.
    pub(crate) fn zip(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|j| std::array::from_fn(|i| f(self.0[j][i], other.0[j][i]))))
    }

    pub(crate) fn from_rows(rows: &[[f64; N]; G]) -> Self {
        Self(std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j])))
    }

    pub(crate) fn row(&self, i: usize) -> [f64; N] {
        std::array::from_fn(|j| self.0[j][i])
    }

    /// The functionals of `map z`, as functionals of `z`.
    pub(crate) fn after(&self, map: &Matrix<N>) -> Self {
        Self(std::array::from_fn(|j| self.add([0.0; G], &map.columns[j], N)))
    }

    /// Values at a state, whose last entry is 1.
    #[inline]
    pub(crate) fn apply(&self, z: &[f64; N]) -> [f64; G] {
        self.add(self.0[N - 1], z, N - 1)
    }

    /// Values at a rate of change, whose last entry is 0.
    #[inline]
    pub(crate) fn apply_to_rate(&self, rate: &[f64; N]) -> [f64; G] {
        self.add([0.0; G], rate, N - 1)
    }

    /// Adds what the first `entries` of a vector contribute.
    #[inline]
    pub(crate) fn add(&self, mut sum: [f64; G], v: &[f64; N], entries: usize) -> [f64; G] {
        for (column, &x) in self.0[..entries].iter().zip(v) {
            for (o, &w) in sum.iter_mut().zip(column) {
                *o += w * x;
            }
        }
        sum
    }
}

/// How far the guards can sag below their chord over a span, per |ż| at its start.
///
/// With ż(t) = exp(A t) ż(0) and an envelope E of the flows, |g''(t)| = |w A ż(t)| ≤ |w A| E
/// |ż(0)|, and a curve sags at most max|g''| span²/8 below its chord.
#[derive(Debug, Clone)]
pub(crate) struct Sag<const N: usize, const G: usize>(pub(crate) Functionals<N, G>);

impl<const N: usize, const G: usize> Sag<N, G> {
    /// `bend` is |w A| of each guard.
    pub(crate) fn new(bend: &Functionals<N, G>, envelope: &Matrix<N>, span: f64) -> Self {
        /// Of the chord bound h²/8.
        const CHORD: f64 = 0.125;
        let bound = bend.after(envelope);
        Self(bound.map(|x| x * CHORD * span * span))
    }

    /// For each guard, whether it may fall below zero between two points; true if in doubt or not a
    /// number.
    #[inline]
    pub(crate) fn doubtful(
        &self,
        rate: &[f64; N],
        before: &[f64; G],
        after: &[f64; G],
    ) -> [bool; G] {
        let sag = self.0.apply_to_rate(&rate.map(f64::abs));
        let safe: [bool; G] = std::array::from_fn(|i| before[i].min(after[i]) >= sag[i]);
        safe.map(|safe| !safe)
    }

    /// True if no guard can fall below zero between two points; false if in doubt or not a number.
    #[inline]
    pub(crate) fn safe(&self, rate: &[f64; N], before: &[f64; G], after: &[f64; G]) -> bool {
        let sag = self.0.apply_to_rate(&rate.map(f64::abs));
        let mut safe = true;
        for i in 0..G {
            safe &= before[i].min(after[i]) >= sag[i];
        }
        safe
    }
}
