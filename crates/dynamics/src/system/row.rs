//! Linear functionals of the augmented state, as rows.

use std::ops::{Add, Div, Mul, Sub};

/// Longest augmented state: θ, θ̇, x2, ẋ2, motor, brake, force and rate, a term's input and rate,
/// one.
pub(crate) const MOST: usize = 11;

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

/// `w · z`; only the first `n` entries of a layout are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<T = f64>(pub(crate) [T; MOST]);

impl Row {
    pub(crate) const ZERO: Row = Row([0.0; MOST]);

    /// The functional's value.
    #[inline]
    pub(crate) fn of(&self, z: &[f64]) -> f64 {
        self.0.iter().zip(z).map(|(w, x)| w * x).sum()
    }

    /// The same coefficients as other numbers.
    pub(crate) fn lifted<T: Number>(self) -> Row<T> {
        Row(self.0.map(T::from))
    }
}

impl<T: Number> Row<T> {
    /// No entry.
    pub(crate) fn zero() -> Self {
        Row([T::from(0.0); MOST])
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

/// A functional of the state: `row · z`, and the terms' curved force `curved` times.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Functional {
    pub(crate) row: Row,
    pub(crate) curved: f64,
}

impl From<Row> for Functional {
    fn from(row: Row) -> Self {
        Self { row, curved: 0.0 }
    }
}
