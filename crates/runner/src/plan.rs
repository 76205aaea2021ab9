//! Order and reasons: which jobs can run now, and why a job must be made again.

use crate::Job;
use crate::record::Record;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Groups of job indices: a group needs only outputs of earlier groups. Jobs that need each other in
/// a circle come last, together (they fail when they find an input missing).
pub(crate) fn levels(jobs: &[Job]) -> Vec<Vec<usize>> {
    let maker: BTreeMap<&PathBuf, usize> =
        jobs.iter().enumerate().flat_map(|(i, j)| j.outputs.iter().map(move |o| (o, i))).collect();
    let mut waiting: BTreeSet<usize> = (0..jobs.len()).collect();
    let mut levels = Vec::new();
    while !waiting.is_empty() {
        let is_ready = |i: &usize| {
            jobs[*i].inputs.iter().all(|f| maker.get(f).is_none_or(|m| !waiting.contains(m) || m == i))
        };
        let ready: Vec<usize> = waiting.iter().copied().filter(is_ready).collect();
        let level = if ready.is_empty() { waiting.iter().copied().collect() } else { ready };
        waiting.retain(|i| !level.contains(i));
        levels.push(level);
    }
    levels
}

/// The chosen jobs and every job whose outputs they need, however far back, in the order given.
pub(crate) fn with_needs(jobs: &[Job], chosen: impl Fn(&Job) -> bool) -> Vec<bool> {
    let mut keep: Vec<bool> = jobs.iter().map(chosen).collect();
    loop {
        let needed: BTreeSet<&PathBuf> =
            jobs.iter().zip(&keep).filter(|(_, k)| **k).flat_map(|(j, _)| &j.inputs).collect();
        let more: Vec<usize> = (0..jobs.len())
            .filter(|i| !keep[*i] && jobs[*i].outputs.iter().any(|o| needed.contains(o)))
            .collect();
        if more.is_empty() {
            return keep;
        }
        more.into_iter().for_each(|i| keep[i] = true);
    }
}

/// Why a job must be made again, in words; `None` if it need not be. `now` is the record as it would
/// be written now, with the outputs' present content.
pub(crate) fn reason(before: Option<&Record>, now: &Record) -> Option<String> {
    let Some(before) = before else { return Some("never made".to_owned()) };
    if before.version != now.version {
        return Some(format!("algorithm version {} is now {}", before.version, now.version));
    }
    if before.parameters != now.parameters || before.stage != now.stage {
        return Some("its parameters changed".to_owned());
    }
    difference("input", &before.inputs, &now.inputs)
        .or_else(|| difference("output", &before.outputs, &now.outputs))
}

fn difference(
    what: &str,
    before: &BTreeMap<String, String>,
    now: &BTreeMap<String, String>,
) -> Option<String> {
    let changed = now.iter().find(|(path, hash)| before.get(*path) != Some(hash));
    if let Some((path, hash)) = changed {
        let how = match (before.contains_key(path), hash.is_empty()) {
            (_, true) => "is missing",
            (false, _) => "is new",
            (true, _) => "changed",
        };
        return Some(format!("{what} {path} {how}"));
    }
    let gone = before.keys().find(|path| !now.contains_key(*path))?;
    Some(format!("{what} {gone} is no longer there"))
}
