//! Functionals of the augmented state.

use crate::affine;

/// Longest augmented state: θ, θ̇, x2, ẋ2, motor, brake, force and rate, a term's input and rate,
/// one.
pub(crate) const MOST: usize = 11;

/// A linear functional of the augmented state; only the first `n` entries of a layout are used.
pub(crate) type Row<T = f64> = affine::Row<MOST, T>;

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
