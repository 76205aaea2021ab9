//! Order: which jobs can run now, and which jobs others need.

use crate::Job;
use rayon::prelude::*;
use std::collections::{BTreeSet, HashMap};
use std::ffi::OsStr;

/// Which job makes a file.
struct Makers<'j>(HashMap<&'j OsStr, usize>);

impl<'j> Makers<'j> {
    fn of(jobs: &'j [Job]) -> Self {
        let mut makers = HashMap::new();
        for (i, job) in jobs.iter().enumerate() {
            for output in &job.outputs {
                // Paths of one plan are written alike, and bytes are compared faster than names.
                makers.insert(output.as_os_str(), i);
            }
        }
        Self(makers)
    }

    /// The jobs whose outputs this one reads.
    fn needed_by(&self, jobs: &[Job], i: usize) -> BTreeSet<usize> {
        let inputs = jobs[i].inputs();
        let makers = inputs.iter().filter_map(|file| self.0.get(file.as_os_str()).copied());
        // A job that reads its own output would wait for itself for ever.
        makers.filter(|maker| *maker != i).collect()
    }
}

/// For each job that is wanted, the jobs whose outputs it reads; for the others none.
pub(crate) fn needs(jobs: &[Job], wanted: &[bool]) -> Vec<BTreeSet<usize>> {
    let makers = Makers::of(jobs);
    let needs = wanted.par_iter().enumerate().map(|(i, is_wanted)| match is_wanted {
        true => makers.needed_by(jobs, i),
        false => BTreeSet::new(),
    });
    needs.collect()
}

/// Groups of indices of jobs that are wanted: a group needs only outputs of earlier groups, and of
/// jobs that are not. Jobs that need each other in a circle come last, together (they fail when they
/// find an input missing).
pub(crate) fn levels(jobs: &[Job], wanted: &[bool]) -> Vec<Vec<usize>> {
    let needs = needs(jobs, wanted);
    let mut waiting: BTreeSet<usize> = (0..jobs.len()).filter(|i| wanted[*i]).collect();
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

/// The chosen jobs and every job whose outputs they need, however far back.
pub(crate) fn with_needs(jobs: &[Job], chosen: impl Fn(&Job) -> bool + Sync) -> Vec<bool> {
    let mut keep: Vec<bool> = jobs.par_iter().map(&chosen).collect();
    let makers = Makers::of(jobs);
    let mut added: Vec<usize> = (0..jobs.len()).filter(|i| keep[*i]).collect();
    while !added.is_empty() {
        let needed: Vec<_> = added.into_par_iter().map(|i| makers.needed_by(jobs, i)).collect();
        added = Vec::new();
        for i in needed.into_iter().flatten() {
            if !keep[i] {
                keep[i] = true;
                added.push(i);
            }
        }
    }
    keep
}
