//! The samples of the trial in progress, on their way to the journal.

use std::ops::ControlFlow;
use zwidth_store::{Journal, StoreError};
use zwidth_study::Sample;

/// Samples are kept back for so long, s, before they are written and synced together: half of the
/// 100 ms that a kill may take.
pub(crate) const BATCH_S: f64 = 0.05;

/// A journal, and the samples that it does not hold yet.
pub(crate) struct Tape {
    pub(crate) journal: Journal,
    waiting: Vec<Sample>,
    /// Why samples cannot be kept any more.
    pub(crate) error: Option<StoreError>,
}

impl Tape {
    pub(crate) fn new(journal: Journal, rate_hz: f64) -> Self {
        // Room for two batches: the tick of a simulated clock does not allocate either.
        let room = (2.0 * BATCH_S * rate_hz) as usize + 1;
        Self { journal, waiting: Vec::with_capacity(room), error: None }
    }

    /// Takes a sample; writes when a batch is full. Break: it could not be kept.
    pub(crate) fn add(&mut self, sample: &Sample) -> ControlFlow<()> {
        let first_s = self.waiting.first().map_or(sample.t_s, |first| first.t_s);
        self.waiting.push(*sample);
        if sample.t_s - first_s >= BATCH_S { self.write() } else { ControlFlow::Continue(()) }
    }

    /// Writes what waits.
    pub(crate) fn write(&mut self) -> ControlFlow<()> {
        if self.error.is_some() {
            return ControlFlow::Break(());
        }
        self.error = self.journal.append(&self.waiting).err();
        self.waiting.clear();
        if self.error.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}
