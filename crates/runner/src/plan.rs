//! Order: which jobs can run now, and which jobs others need.

use crate::Job;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

/// For each job, the jobs whose outputs it reads.
pub(crate) fn needs(jobs: &[Job]) -> Vec<BTreeSet<usize>> {
    // Paths of one plan are written alike, and their bytes are compared sooner than their names.
    let maker: HashMap<&OsStr, usize> = jobs
        .iter()
        .enumerate()
        .flat_map(|(i, job)| job.outputs.iter().map(move |output| (output.as_os_str(), i)))
        .collect();
    let numbered = jobs.par_iter().enumerate();
    numbered
        .map(|(i, job)| {
            let inputs = job.inputs();
            let makers = inputs.iter().filter_map(|file| maker.get(file.as_os_str()).copied());
            // A job that reads its own output would wait for itself for ever.
            makers.filter(|maker| *maker != i).collect()
        })
        .collect()
}

/// Groups of job indices: a group needs only outputs of earlier groups. Jobs that need each other
/// in a circle come last, together (they fail when they find an input missing).
pub(crate) fn levels(jobs: &[Job]) -> Vec<Vec<usize>> {
    let needs = needs(jobs);
    let mut waiting: BTreeSet<usize> = (0..jobs.len()).collect();
    let mut levels = Vec::new();
    while !waiting.is_empty() {
        let ready: Vec<usize> =
            waiting.iter().copied().filter(|i| needs[*i].is_disjoint(&waiting)).collect();
        let level = if ready.is_empty() { waiting.iter().copied().collect() } else { ready };
        level.iter().for_each(|i| _ = waiting.remove(i));
        levels.push(level);
    }
    levels
}

/// The chosen jobs and every job whose outputs they need, however far back, in the order given.
pub(crate) fn with_needs(jobs: &[Job], chosen: impl Fn(&Job) -> bool + Sync) -> Vec<bool> {
    let mut keep: Vec<bool> = jobs.par_iter().map(&chosen).collect();
    loop {
        let kept = jobs.iter().zip(&keep).filter(|(_, keep)| **keep);
        let needed: HashSet<OsString> =
            kept.flat_map(|(job, _)| job.inputs()).map(PathBuf::into_os_string).collect();
        let more: Vec<usize> = (0..jobs.len())
            .into_par_iter()
            .filter(|i| {
                !keep[*i] && jobs[*i].outputs.iter().any(|o| needed.contains(o.as_os_str()))
            })
            .collect();
        if more.is_empty() {
            return keep;
        }
        more.into_iter().for_each(|i| keep[i] = true);
    }
}

/// All jobs, or those that are called so ([`Job::is_called`]) and those whose
/// outputs they need.
pub(crate) fn named(jobs: &[Job], only: Option<&str>) -> Vec<bool> {
    let Some(name) = only else { return vec![true; jobs.len()] };
    with_needs(jobs, |job| job.is_called(name))
}
