//! The sweeps, compared with the log that has the hash of each.

use crate::form::change_list::pending;
use crate::form::events::read_events_to;
use crate::form::sweep::read_sweep_from;
use crate::{Entry, Files, Layout, StoreError, SweepEntry};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_study::Event;

/// The hash of each sweep that the log calls recorded, by its file.
pub(crate) fn logged(
    files: &dyn Files,
    layout: &Layout,
) -> Result<BTreeMap<PathBuf, String>, StoreError> {
    let mut logged = BTreeMap::new();
    let log = layout.sweep_events();
    for event in read_events_to(files, &log, pending(files, layout).get(&log).copied())? {
        if let Event::SweepRecorded { actuator, sweep, blake3 } = event {
            logged.insert(layout.sweep(&actuator, sweep), blake3);
        }
    }
    Ok(logged)
}

/// The sweeps that are, by the log, the ones that were recorded; and what does not fit.
pub(crate) fn logged_sweeps(
    files: &dyn Files,
    layout: &Layout,
    sweeps: Vec<SweepEntry>,
) -> (Vec<SweepEntry>, Vec<StoreError>) {
    let logged = match logged(files, layout) {
        Ok(logged) => logged,
        Err(error) => return (Vec::new(), vec![error]),
    };
    let mut problems = Vec::new();
    for path in logged.keys().filter(|path| files.kind(path) != Some(Entry::File)) {
        let what = "the log knows the sweep, but its file is missing";
        problems.push(StoreError::new(path, what, "restore the file from a copy"));
    }
    let mut kept = Vec::new();
    for sweep in sweeps {
        match logged.get(&sweep.path) {
            Some(hash) if *hash == sweep.blake3 => kept.push(sweep),
            // How the file came to differ: damage, where that can be seen.
            Some(_) => problems.push(read_sweep_from(files, &sweep.path).err().unwrap_or_else(|| {
                let what = "the file is not the one that was recorded: its hash differs from the log of the sweeps";
                StoreError::new(&sweep.path, what, "restore the file from a copy")
            })),
            None => {
                let what = "the log of the sweeps does not mention it: left out";
                let remedy = format!("run `zwidth recover {}` to take it in", layout.study());
                problems.push(StoreError::new(&sweep.path, what, remedy));
            }
        }
    }
    (kept, problems)
}
