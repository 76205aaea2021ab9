//! What a run would find now: for each job why it would be made again. Nothing is made.

use crate::change::{Change, How, changes};
use crate::hashes::Hashes;
use crate::plan::{levels, with_needs};
use crate::record::Record;
use crate::{Job, Records};
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;

/// Whether a run would make a job again.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Again {
    /// Nothing that it depends on differs.
    No,
    /// It would.
    Yes,
    /// Only if an input that is made again first comes out with another content.
    IfInputsDiffer,
}

/// A job as a run would find it now.
pub struct State<'j, 'a> {
    /// The job.
    pub job: &'j Job<'a>,
    /// Everything that differs from the record of its last success.
    pub changes: Vec<Change>,
}

impl State<'_, '_> {
    /// Whether a run would make the job again.
    pub fn again(&self) -> Again {
        let waits = |c: &Change| matches!(c, Change::Input(file) if file.how == How::ToBeMade);
        match self.changes.as_slice() {
            [] => Again::No,
            all if all.iter().all(waits) => Again::IfInputsDiffer,
            _ => Again::Yes,
        }
    }
}

/// The chosen jobs, and those whose outputs they need, however far back, as a run would find them: those that others
/// need first.
pub fn states<'j, 'a>(
    jobs: &'j [Job<'a>],
    root: &Path,
    records: &Records,
    chosen: impl Fn(&Job) -> bool,
) -> Vec<State<'j, 'a>> {
    let wanted = with_needs(jobs, chosen);
    let hashes = Hashes::default();
    let mut states = Vec::new();
    for level in levels(jobs) {
        let work: Vec<&Job> = level.into_iter().filter(|i| wanted[*i]).map(|i| &jobs[i]).collect();
        let state = |job: &&'j Job<'a>| {
            let now = Record::now(job, root, &hashes);
            State { job, changes: changes(records.get(&job.name), &now) }
        };
        let found: Vec<State> = work.par_iter().map(state).collect();
        for state in found.iter().filter(|s| !s.changes.is_empty()) {
            hashes.forget(&state.job.outputs);
        }
        states.extend(found);
    }
    states
}
