//! Outputs that no planned job makes any more: of jobs that are gone, of jobs that make less, of
//! interrupted runs.

use crate::provenance::origins;
use crate::record::Record;
use crate::{Job, Results};
use rayon::prelude::*;
use std::collections::HashSet;
use std::path::PathBuf;
use zwidth_store::{MOST_BYTES, StoreError};

/// The outputs of jobs.
pub(super) fn outputs(jobs: &[Job]) -> HashSet<&PathBuf> {
    jobs.par_iter().flat_map_iter(|job| &job.outputs).collect()
}

/// Tables with an origin of ours that no planned job makes and no record names: of a run that was cut
/// short before it saved its records. They are reported and stay: nobody knows what they were.
pub(super) fn orphans(planned: &HashSet<&PathBuf>, results: &Results) -> Vec<StoreError> {
    // A folder that cannot be listed is reported when something is written to it.
    let tables = results.tables().unwrap_or_default();
    let others: Vec<&PathBuf> = tables.iter().filter(|path| !planned.contains(path)).collect();
    let orphans = others.into_par_iter().filter_map(|path| {
        let bytes = results.read(path, MOST_BYTES).ok()??.ok()?;
        let what = "no job makes it any more, and no record says which one did";
        let is_ours = !origins(&bytes).is_empty();
        is_ours.then(|| StoreError::new(path, what, "an earlier run was cut short; remove it"))
    });
    orphans.collect()
}

/// Removes what a job made before and no planned job makes any more, and says what stayed
/// nevertheless.
pub(super) fn remove_unplanned(
    planned: &HashSet<&PathBuf>,
    record: &Record,
    results: &Results,
) -> Vec<StoreError> {
    let mut stayed = Vec::new();
    for (path, hash) in &record.outputs {
        // Every record was held against this when it was read.
        let Ok(path) = Results::named(results.layout(), path) else { continue };
        if !planned.contains(&path) {
            stayed.extend(results.remove_made(&path, hash).err());
        }
    }
    stayed
}
