//! What an embedded one-step method is, for the loop of `adaptive`.

use zwidth_numerics::expm::Matrix;

use super::shorten;
use crate::system::flow::Flow;
use crate::system::{OMEGA, System, THETA};

/// ż = A z + c F(θ, θ̇) inside a region, with the terms' curved force F.
pub(crate) struct Field<'a, const N: usize> {
    pub(crate) a: Matrix<N>,
    curved: [f64; N],
    system: &'a System,
}

impl<'a, const N: usize> Field<'a, N> {
    pub(crate) fn new(system: &'a System, flow: &Flow) -> Self {
        let a = Matrix::from_fn(|i, j| flow.rows[i].0[j]);
        Self { a, curved: shorten(&flow.curved), system }
    }

    #[inline]
    pub(crate) fn slope(&self, z: &[f64; N]) -> [f64; N] {
        let mut out = self.a.apply(z);
        if let Some(curve) = self.system.curve(z) {
            for (o, c) in out.iter_mut().zip(&self.curved) {
                *o += c * curve.force_n;
            }
        }
        out
    }

    /// ∂ż/∂z.
    pub(crate) fn jacobian(&self, z: &[f64; N]) -> Matrix<N> {
        let mut jacobian = self.a;
        if let Some(curve) = self.system.curve(z) {
            for (i, c) in self.curved.iter().enumerate() {
                jacobian.columns[THETA][i] += c * curve.per_rad_n;
                jacobian.columns[OMEGA][i] += c * curve.per_rad_s_n;
            }
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
