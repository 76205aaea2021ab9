//! Linear functionals of the augmented state, as rows.

/// Longest augmented state: θ, θ̇, x2, ẋ2, motor, brake, force and rate, pull and rate, one.
pub(crate) const MOST: usize = 11;

/// `w · z`; only the first `n` entries of a layout are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row(pub(crate) [f64; MOST]);

impl Row {
    pub(crate) const ZERO: Row = Row([0.0; MOST]);

    /// The entry `i` of the state, `factor` times.
    pub(crate) fn entry(i: usize, factor: f64) -> Row {
        let mut row = Row::ZERO;
        row.0[i] = factor;
        row
    }

    pub(crate) fn plus(mut self, other: Row) -> Row {
        for (x, y) in self.0.iter_mut().zip(other.0) {
            *x += y;
        }
        self
    }

    pub(crate) fn times(mut self, factor: f64) -> Row {
        for x in &mut self.0 {
            *x *= factor;
        }
        self
    }

    pub(crate) fn minus(self, other: Row) -> Row {
        self.plus(other.times(-1.0))
    }

    /// The functional's value.
    #[inline]
    pub(crate) fn of(&self, z: &[f64]) -> f64 {
        self.0.iter().zip(z).map(|(w, x)| w * x).sum()
    }
}
