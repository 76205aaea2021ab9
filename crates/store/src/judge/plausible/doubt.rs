//! A finding about one trial's samples, and the questions that several checks share.

use crate::{Signal, StoreError};
use std::ops::Range;
use std::path::Path;
use zwidth_numerics::series::ends;

/// Fewest samples that show a habit.
pub(super) const LEAST_SAMPLES: usize = 50;

/// A finding before it has its file.
pub(super) struct Doubt {
    pub(super) signal: Signal,
    pub(super) row: Option<usize>,
    pub(super) what: String,
    pub(super) remedy: &'static str,
}

impl Doubt {
    pub(super) fn new(signal: Signal, what: String, remedy: &'static str) -> Self {
        Self { signal, row: None, what, remedy }
    }

    pub(super) fn at(self, path: &Path) -> StoreError {
        let error = StoreError::new(path, self.what, self.remedy).column(self.signal.name());
        match self.row {
            Some(row) => error.row0(row),
            None => error,
        }
    }
}

/// Largest less smallest value.
pub(super) fn range(values: &[f64]) -> f64 {
    let (low, high) = ends(values);
    (high - low).max(0.0)
}

/// The first of so many places at which something is so; soon told where it is so nowhere.
pub(super) fn first(places: Range<usize>, is_so: impl Fn(usize) -> bool) -> Option<usize> {
    const TOGETHER: usize = 64;
    let starts = places.clone().step_by(TOGETHER);
    let mut blocks = starts.map(|from| from..(from + TOGETHER).min(places.end));
    // Without a way out of a block, a processor looks at several places at once.
    let block = blocks.find(|block| block.clone().fold(false, |any, i| any | is_so(i)));
    block?.find(|i| is_so(*i))
}
