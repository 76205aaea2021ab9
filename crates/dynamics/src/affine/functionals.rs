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
pub(crate) struct Sag<const N: usize, const G: usize> {
    most: Functionals<N, G>,
    span: f64,
}

impl<const N: usize, const G: usize> Sag<N, G> {
    /// `bend` is |w A| of each guard.
    pub(crate) fn new(bend: &Functionals<N, G>, envelope: &Matrix<N>, span: f64) -> Self {
        /// Of the chord bound h²/8.
        const CHORD: f64 = 0.125;
        Self { most: bend.after(envelope).map(|x| x * CHORD * span * span), span }
    }

    /// The bound at a state's rate.
    pub(crate) fn most(&self) -> &Functionals<N, G> {
        &self.most
    }

    /// True if no guard can fall below zero between two points at most the span apart; false if in
    /// doubt or not a number.
    #[inline]
    pub(crate) fn safe(&self, rate: &[f64; N], before: &[f64; G], after: &[f64; G]) -> bool {
        all_above(before, after, &self.most.apply_to_rate(&rate.map(f64::abs)))
    }

    /// For each guard, whether it may fall below zero between two points; true if in doubt or not a
    /// number. Beyond the chord it looks at the `slope` of the guards at the first point, which
    /// changes by at most max|g''| span = 8 sag/span: a guard that cannot turn before the second
    /// point is lowest at one of the two, and one that rises by more than max|g''| span²/2 = 4 sag
    /// along its tangent does not come back.
    #[inline]
    pub(crate) fn doubtful(
        &self,
        rate: &[f64; N],
        slope: &[f64; G],
        before: &[f64; G],
        after: &[f64; G],
    ) -> [bool; G] {
        let sag = self.most.apply_to_rate(&rate.map(f64::abs));
        std::array::from_fn(|i| {
            let along = slope[i] * self.span;
            let lowest = before[i].min(after[i]);
            let above = lowest >= sag[i];
            let rises = before[i] >= 0.0 && along >= 4.0 * sag[i];
            let turns_not = lowest >= 0.0 && along.abs() >= 8.0 * sag[i];
            !(above || rises || turns_not)
        })
    }
}

/// True if every guard is at both points above what it can sag.
#[inline]
pub(crate) fn all_above<const G: usize>(
    before: &[f64; G],
    after: &[f64; G],
    sag: &[f64; G],
) -> bool {
    // No early end: without branches the guards are compared several at a time.
    let mut safe = true;
    for i in 0..G {
        safe &= before[i].min(after[i]) >= sag[i];
    }
    safe
}
