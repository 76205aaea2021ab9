//! How to run: which jobs, and where a run keeps the records of what was made from what.

use super::unplanned::{outputs, remove_unplanned};
use crate::hashes::{Hashes, HashesRead};
use crate::manifest::Manifest;
use crate::plan::with_needs;
use crate::shard::{ready, up_to_date};
use crate::{Job, Records, Results, Scripts, Shard};
use std::collections::BTreeSet;
use std::sync::Arc;
use zwidth_store::{Seen, StoreError};

/// How to run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Make everything again.
    pub fresh: bool,
    /// Say what would be made, and why; make nothing.
    pub dry_run: bool,
    /// Only jobs that are called so ([`Job::is_called`]), and what they need.
    pub only: Option<String>,
    /// Only the jobs of this shard that can be made now. The shard's manifest lists what they make;
    /// the records of the study stay as they are until it is merged.
    pub shard: Option<Shard>,
    /// Hashes of files that were read already.
    pub known: HashesRead,
    /// What files were when they were last read: those that are the same are not read again. A run
    /// that is not a shard's writes down what it has seen.
    pub seen: Arc<Seen>,
    /// Outputs say nothing of their making: their bytes are their content alone.
    pub without_origin: bool,
    /// Which programs of the study's own may be started.
    pub scripts: Scripts,
}

/// Which jobs a run checks, and makes if they need it.
///
/// # Errors
/// A link on the way to the study's records, which a shard needs.
pub fn wanted(jobs: &[Job], results: &Results, options: &Options) -> Result<Vec<bool>, StoreError> {
    let Some(shard) = options.shard else {
        return Ok(match &options.only {
            Some(name) => with_needs(jobs, |job| job.is_called(name)),
            None => vec![true; jobs.len()],
        });
    };
    let (records, _) = Records::read(results)?;
    let hashes = Hashes::seen(&options.known, options.seen.clone());
    let takes = |job: &Job| shard.takes(job);
    let up_to_date = up_to_date(jobs, takes, results.root(), &records, &hashes);
    let ready = ready(jobs, |job| shard.takes(job).then_some(shard), &up_to_date);
    Ok(ready.iter().map(Option::is_some).collect())
}

/// The records that a run begins with, and what is wrong with them. A shard adds those of its own
/// manifest, and keeps only those of the jobs that it checks: records of others may be outdated.
/// What it made for jobs that are gone is removed here, because its next manifest does not name it.
pub(super) fn records_before(
    jobs: &[Job],
    wanted: &[bool],
    results: &Results,
    options: &Options,
) -> Result<(Records, Vec<StoreError>), StoreError> {
    let (mut records, mut remarks) = Records::read(results)?;
    let Some(shard) = options.shard else { return Ok((records, remarks)) };
    match Manifest::read(results, shard)?.map(|existing| existing.manifest) {
        Some(Ok(manifest)) => {
            let all = outputs(jobs);
            let planned: BTreeSet<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
            for (name, record) in manifest.records.iter() {
                // What the study's own records name is the whole run's to remove.
                let is_gone = !planned.contains(name) && !records.0.contains_key(name);
                if is_gone && !options.dry_run {
                    remarks.extend(remove_unplanned(&all, &record, results));
                }
            }
            records.0.extend(manifest.records.0);
        }
        Some(Err(error)) => {
            let remedy = "you need not do anything; it is written anew";
            remarks.push(StoreError::new(&error.path, error.what, remedy));
        }
        None => {}
    }
    let own = jobs.iter().zip(wanted).filter(|(_, wanted)| **wanted);
    let own: BTreeSet<&str> = own.map(|(job, _)| job.name.as_str()).collect();
    records.0.retain(|name, _| own.contains(name.as_str()));
    Ok((records, remarks))
}

/// Saves the records of a run, the study's or the manifest of its shard, and returns them: those that
/// are in the study's own file need no memory from then on.
pub(super) fn save(
    records: &Records,
    results: &Results,
    options: &Options,
) -> Result<Records, StoreError> {
    let Some(shard) = options.shard else { return records.write(results) };
    Manifest::new(results.layout(), shard, records.clone()).write(results)?;
    Ok(records.clone())
}
