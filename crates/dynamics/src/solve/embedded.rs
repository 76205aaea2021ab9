//! What an embedded one-step method is, for the loop of `adaptive`.

use zwidth_numerics::expm::Matrix;

use super::shorten;
use crate::system::THETA;
use crate::system::flow::Flow;

/// ż = A z + s sin θ inside a region.
pub(crate) struct Field<const N: usize> {
    pub(crate) a: Matrix<N>,
    pub(crate) sine: [f64; N],
    curved: bool,
}

impl<const N: usize> Field<N> {
    pub(crate) fn new(flow: &Flow) -> Self {
        let sine = shorten::<N>(&flow.sine);
        let curved = sine.iter().any(|&s| s != 0.0);
        Self { a: Matrix::from_fn(|i, j| flow.rows[i].0[j]), sine, curved }
    }

    #[inline]
    pub(crate) fn slope(&self, z: &[f64; N]) -> [f64; N] {
        let mut out = self.a.apply(z);
        if self.curved {
            let sine = libm::sin(z[THETA]);
            for (o, s) in out.iter_mut().zip(&self.sine) {
                *o += s * sine;
            }
        }
        out
    }

    /// ∂ż/∂z.
    pub(crate) fn jacobian(&self, z: &[f64; N]) -> Matrix<N> {
        let mut jacobian = self.a;
        let cosine = if self.curved { libm::cos(z[THETA]) } else { 0.0 };
        for (entry, s) in jacobian.columns[THETA].iter_mut().zip(&self.sine) {
            *entry += s * cosine;
        }
        jacobian
    }
}

/// A step that was tried.
pub(crate) struct Attempt<const N: usize> {
    /// State after the step.
    pub(crate) z: [f64; N],
    /// Estimated error of it.
    pub(crate) error: [f64; N],
    /// Dense output: z(t + s h) = Σ dense[k] sᵏ for s in [0, 1].
    pub(crate) dense: [[f64; N]; 5],
    /// Evaluations of the right-hand side.
    pub(crate) evaluations: u64,
    /// Factorisations.
    pub(crate) factorisations: u64,
}

/// An embedded one-step method.
pub(crate) trait Embedded<const N: usize> {
    /// Order of the error estimate plus one: the error falls with this power of the step.
    fn power(&self) -> f64;

    /// One step of `h` from `z`.
    fn attempt(&mut self, field: &Field<N>, z: &[f64; N], h: f64) -> Attempt<N>;
}

/// The dense output at a share of the step.
pub(crate) fn dense<const N: usize>(coefficients: &[[f64; N]; 5], share: f64) -> [f64; N] {
    let mut z = coefficients[4];
    for c in coefficients[..4].iter().rev() {
        for (x, y) in z.iter_mut().zip(c) {
            *x = *x * share + y;
        }
    }
    z
}
