//! The signals of a trial one by one: in memory, or read when they are looked at. What looks at two
//! signals of a long recording never has the others in memory.

use crate::{Samples, Signal};
use std::ops::Deref;
use std::sync::Arc;

/// Samples from which on a trial is checked column by column, so that no more than two are in
/// memory.
pub(crate) const LONG: usize = 1 << 20;

/// The values of a signal.
#[derive(Debug, Clone)]
pub enum Values<'a> {
    /// In a trial in memory.
    Held(&'a [f64]),
    /// Read from a file, and forgotten when nobody looks at them any more.
    Read(Arc<Vec<f64>>),
}

impl Deref for Values<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            Self::Held(values) => values,
            Self::Read(values) => values,
        }
    }
}

/// The signals of a trial.
pub trait Columns {
    /// The values of `signal`, where the recording has it.
    fn column(&self, signal: Signal) -> Option<Values<'_>>;

    /// Whether the recording has `signal`.
    fn has(&self, signal: Signal) -> bool;
}

impl Columns for Samples {
    fn column(&self, signal: Signal) -> Option<Values<'_>> {
        self.get(signal).map(Values::Held)
    }

    fn has(&self, signal: Signal) -> bool {
        self.get(signal).is_some()
    }
}
