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

    pub(crate) fn from_rows(rows: &[[f64; N]; G]) -> Self {
        Self(std::array::from_fn(|j| std::array::from_fn(|i| rows[i][j])))
    }

    pub(crate) fn row(&self, i: usize) -> [f64; N] {
        std::array::from_fn(|j| self.0[j][i])
    }

    /// The functionals of `map z`, as functionals of rates of change `z`, whose last entry is 0; the
    /// map is split after `D`.
    pub(crate) fn after<const D: usize>(&self, map: &Matrix<N>) -> Self {
        let mut out = Self::ZERO;
        for (j, (sum, column)) in out.0.iter_mut().zip(&map.columns[..N - 1]).enumerate() {
            *sum = self.add(*sum, column, if j < D { D } else { N });
        }
        out
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

/// How far the guards can sag below their chord over a span, per |z̈| at its start.
///
/// With z̈(t) = exp(A t) z̈(0) and an envelope E of the flows, |g''(t)| = |w z̈(t)| ≤ |w| E |z̈(0)|,
/// and a curve sags at most max|g''| span²/8 below its chord. Where the fast part of a motion has
/// died out, z̈ is small though |A| |ż| is not.
#[derive(Debug, Clone)]
pub(crate) struct Sag<const N: usize, const G: usize> {
    /// |w| E.
    curvature: Functionals<N, G>,
    span: f64,
}

impl<const N: usize, const G: usize> Sag<N, G> {
    /// `sizes` is |w| of each guard; the envelope is split after `D`.
    pub(crate) fn new<const D: usize>(
        sizes: &Functionals<N, G>,
        envelope: &Matrix<N>,
        span: f64,
    ) -> Self {
        Self { curvature: sizes.after::<D>(envelope), span }
    }

    /// How far each guard can sag from a point on where the state has the second derivative `bend`.
    #[inline]
    pub(crate) fn most(&self, bend: &[f64; N]) -> [f64; G] {
        /// Of the chord bound h²/8.
        const CHORD: f64 = 0.125;
        let scale = CHORD * self.span * self.span;
        self.curvature.apply_to_rate(&bend.map(f64::abs)).map(|x| x * scale)
    }

    /// For each guard, whether it may fall below zero between two points; true if in doubt or not a
    /// number. `sag` is what [`Sag::most`] says at the first. Beyond the chord it looks at the
    /// `slope` of the guards at the first point, which changes by at most max|g''| span = 8
    /// sag/span: a guard that cannot turn before the second point is lowest at one of the two, and
    /// one that rises by more than max|g''| span²/2 = 4 sag along its tangent does not come back.
    #[inline]
    pub(crate) fn doubtful(
        &self,
        sag: &[f64; G],
        slope: &[f64; G],
        before: &[f64; G],
        after: &[f64; G],
    ) -> [bool; G] {
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

/// True if every guard is at both points above what it can sag; false if one is not a number.
#[inline]
pub(crate) fn all_above<const G: usize>(
    before: &[f64; G],
    after: &[f64; G],
    sag: &[f64; G],
) -> bool {
    // No early end: without branches the guards are compared several at a time.
    let mut safe = true;
    for i in 0..G {
        safe &= (before[i] >= sag[i]) & (after[i] >= sag[i]);
    }
    safe
}
