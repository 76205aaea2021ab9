//! Whether a recording is plausible: the traces that a wrong unit, a lost sensor or a stopped clock
//! leaves in single columns.
//!
//! It is in the store because `verify`, import and a run ask the same question about the same
//! samples, and no other crate is below all three. Thresholds are far from what devices and hands
//! do, so that a finding is worth reading: a wrong unit is off by a factor of ten or more, and a
//! sensor that is read properly differs from sample to sample.

mod asked;
mod columns;
mod doubt;
mod relations;
mod space;
#[cfg(test)]
mod tests;

pub use asked::Asked;
pub use columns::{Plateau, plateau};

use crate::{Columns, StoreError};
use std::path::Path;

/// What the samples of a trial say against its units, signs, clock and sensors: one finding a
/// cause, with its remedy.
pub(crate) fn implausible(expected: &Asked, path: &Path, samples: &dyn Columns) -> Vec<StoreError> {
    let doubts =
        columns::doubts(expected, samples).into_iter().chain(relations::doubts(expected, samples));
    let doubts = doubts.chain(space::doubts(samples));
    doubts.map(|doubt| doubt.at(path)).collect()
}
