//! Linear functionals of a state, as rows.

use std::ops::{Add, Div, Mul, Sub};

/// What coefficients are made of: `f64`, or pairs of them where rounding must not touch the
/// coefficients.
pub(crate) trait Number:
    Copy + From<f64> + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<T> Number for T where
    T: Copy + From<f64> + Add<Output = T> + Sub<Output = T> + Mul<Output = T> + Div<Output = T>
{
}

/// `w · z`. Where the state is shorter than the row, what is left over is not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<const N: usize, T = f64>(pub(crate) [T; N]);

impl<const N: usize> Row<N> {
    pub(crate) const ZERO: Self = Row([0.0; N]);

    /// The functional's value at a state.
    #[inline]
    pub(crate) fn dot(&self, z: &[f64]) -> f64 {
        self.0.iter().zip(z).map(|(w, x)| w * x).sum()
    }

    /// The same coefficients as other numbers.
    pub(crate) fn lifted<T: Number>(self) -> Row<N, T> {
        Row(self.0.map(T::from))
    }
}

impl<const N: usize, T: Number> Row<N, T> {
    /// No entry.
    pub(crate) fn zero() -> Self {
        Row([T::from(0.0); N])
    }

    /// The entry `i` of the state, `factor` times.
    pub(crate) fn entry(i: usize, factor: T) -> Self {
        let mut row = Self::zero();
        row.0[i] = factor;
        row
    }

    pub(crate) fn plus(mut self, other: Self) -> Self {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x = *x + y;
        }
        self
    }

    pub(crate) fn minus(mut self, other: Self) -> Self {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x = *x - y;
        }
        self
    }

    pub(crate) fn times(mut self, factor: T) -> Self {
        for x in &mut self.0 {
            *x = *x * factor;
        }
        self
    }

    pub(crate) fn over(mut self, divisor: T) -> Self {
        for x in &mut self.0 {
            *x = *x / divisor;
        }
        self
    }
}
