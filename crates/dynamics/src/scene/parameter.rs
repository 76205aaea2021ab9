//! A number of a part of a scene: its name, its size, and what it may be.

use crate::error::{Result, finite, not_negative, positive};

/// A number of a term, or of another part of a scene.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    pub(super) name: &'static str,
    pub(super) value: f64,
    pub(super) usual: f64,
    pub(super) check: fn(&str, f64) -> Result<()>,
}

impl Parameter {
    /// A number that may be anything finite: name of its field, value, and a size it usually has.
    pub fn any(name: &'static str, value: f64, usual: f64) -> Self {
        Self { name, value, usual, check: |name, value| finite(name, value) }
    }

    /// The same for one that is not below zero.
    pub(crate) fn not_negative(name: &'static str, value: f64, usual: f64) -> Self {
        Self { name, value, usual, check: |name, value| not_negative(name, value) }
    }

    /// The same for one that is above zero.
    pub(super) fn positive(name: &'static str, value: f64, usual: f64) -> Self {
        Self { name, value, usual, check: |name, value| positive(name, value) }
    }

    /// Refuses it, by its name, if it makes no sense.
    pub(super) fn checked(&self) -> Result<()> {
        (self.check)(self.name, self.value)
    }
}
