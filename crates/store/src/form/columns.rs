//! The signals of a trial one by one: in memory, or read when they are needed. Code that uses two
//! signals of a long recording never has the others in memory.

use crate::{Samples, Signal, StoreError, Trial};
use std::ops::Deref;
use std::sync::Arc;
use zwidth_numerics::series::ends;
use zwidth_study::TrialMeta;

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
    /// The number of samples.
    fn rows(&self) -> usize;

    /// The values of `signal`, where the recording has it.
    fn column(&self, signal: Signal) -> Option<Values<'_>>;

    /// Whether the recording has `signal`.
    fn has(&self, signal: Signal) -> bool;

    /// The values of a channel of the study's own, where the recording has it.
    fn channel(&self, name: &str) -> Option<Values<'_>>;

    /// How far apart the smallest and the largest value of `signal` lie, where the recording has it. A
    /// file may say it, and then its values are not read for it.
    fn reach(&self, signal: Signal) -> Option<f64> {
        let (low, high) = ends(&self.column(signal)?);
        Some(high - low)
    }

    /// Gives back the memory of what was looked at and nobody holds any more.
    fn forget(&self) {}

    /// What of the trial cannot be read, and so is not there for whoever looks at it: whatever was made
    /// without it is void. Signals that nobody looked at yet are read for this.
    fn failure(&self) -> Option<StoreError> {
        None
    }

    /// A column that is not as long as the trial's time, where that was not checked yet: its name and
    /// its length.
    fn ragged(&self) -> Option<(String, usize)> {
        None
    }
}

impl Columns for Samples {
    fn rows(&self) -> usize {
        self.get(Signal::Time).map_or(0, <[f64]>::len)
    }

    fn column(&self, signal: Signal) -> Option<Values<'_>> {
        self.get(signal).map(Values::Held)
    }

    fn has(&self, signal: Signal) -> bool {
        self.get(signal).is_some()
    }

    fn channel(&self, name: &str) -> Option<Values<'_>> {
        self.channels().find(|(id, _)| id.as_str() == name).map(|(_, values)| Values::Held(values))
    }

    fn ragged(&self) -> Option<(String, usize)> {
        let (name, _, values) = self.named().find(|(.., values)| values.len() != self.rows())?;
        Some((name.to_owned(), values.len()))
    }
}

/// A trial to be read, wherever its samples are.
#[derive(Clone, Copy)]
pub struct Recorded<'a> {
    /// The trial's metadata.
    pub meta: &'a TrialMeta,
    /// Its samples.
    pub columns: &'a dyn Columns,
}

impl<'a> From<&'a Trial> for Recorded<'a> {
    fn from(trial: &'a Trial) -> Self {
        Self { meta: &trial.meta, columns: &trial.samples }
    }
}
