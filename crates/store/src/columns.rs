//! The signals of a trial one by one: in memory, or read when they are looked at. What looks at two
//! signals of a long recording never has the others in memory.

use crate::{Samples, Signal};
use std::borrow::Cow;

/// Samples from which on a trial is checked column by column, so that no more than two are in
/// memory.
pub(crate) const LONG: usize = 1 << 20;

/// The signals of a trial.
pub trait Columns {
    /// The values of `signal`, where the recording has it.
    fn column(&self, signal: Signal) -> Option<Cow<'_, [f64]>>;

    /// Whether the recording has `signal`.
    fn has(&self, signal: Signal) -> bool;
}

impl Columns for Samples {
    fn column(&self, signal: Signal) -> Option<Cow<'_, [f64]>> {
        self.get(signal).map(Cow::Borrowed)
    }

    fn has(&self, signal: Signal) -> bool {
        self.get(signal).is_some()
    }
}
