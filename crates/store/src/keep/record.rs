//! A trial becomes a file: it is written as a whole, its place is made durable, and the session's
//! log reports it as recorded.

use crate::disk::atomic::{folder_of, sync_file};
use crate::disk::hash::{blake3_of, hex_blake3};
use crate::form::frame::Protocol;
use crate::form::read::read_whole_trial;
use crate::keep::open_log::OpenLog;
use crate::{Entered, Files, Layout, Signal, Storage, StoreError, Trial, trial_bytes, write_new};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, TrialForm};

/// A trial that ended, to be made a file.
pub(crate) struct Ended<'a> {
    pub(crate) trial: &'a Trial,
    pub(crate) protocol: &'a Protocol,
    /// The time that the answer took, ms, if it was measured.
    pub(crate) answer_time_ms: Option<u32>,
}

impl Ended<'_> {
    /// Does what [`record_trial`] says, with its session's log.
    pub(crate) fn record(
        &self,
        files: &dyn Files,
        layout: &Layout,
        log: &mut OpenLog,
        entered: Entered<'_>,
    ) -> Result<PathBuf, StoreError> {
        let m = &self.trial.meta;
        let form = &self.protocol.form;
        let path = layout.trial(&m.participant, &m.session, m.trial);
        let blake3 = if files.kind(&path).is_some() {
            check_same(files, &path, self.trial, form)?;
            blake3_of(files, &path)?
        } else {
            let bytes = trial_bytes(self.trial, form, &path)?;
            write_new(files, &path, &bytes)?;
            // Its journal is removed only if the file can be read back.
            let blake3 = hex_blake3(&bytes);
            if blake3_of(files, &path)? != blake3 {
                let what = "the file reads otherwise than it was written";
                let remedy = "check the disk; the trial's journal is kept, so move this file elsewhere and run `zwidth recover`";
                return Err(StoreError::new(&path, what, remedy));
            }
            blake3
        };
        // Before the log speaks of it: the name of the file must not go in a power cut.
        settle(files, layout, &path)?;
        let contents = log.contents(files)?;
        let recorded = contents.recorded.get(&m.trial).map(|hash| *hash == blake3);
        // The answer that was given before the file was finished becomes an event.
        let answer = self.protocol.question.clone().zip(m.likert);
        let answer = answer
            .filter(|(question, _)| !contents.answered.contains(&(m.trial, question.clone())));
        if recorded == Some(false) {
            let what =
                format!("trial {} was recorded already, in a file with another hash", m.trial);
            let remedy = "restore the session's files from a copy";
            return Err(StoreError::new(&log.path, what, remedy));
        }
        let mut events = Vec::new();
        if recorded.is_none() {
            events.push(Event::Recorded { trial: m.trial, blake3 });
        }
        events.extend(answer.map(|(question, value)| Event::Answer {
            trial: m.trial,
            question,
            value: value.into(),
            time_ms: self.answer_time_ms,
        }));
        if events.is_empty() {
            sync_file(files, &log.path).map_err(|e| StoreError::io(&log.path, "sync", &e))?;
        } else {
            log.append(files, entered, &events)?;
        }
        settle(files, layout, &log.path)?;
        Ok(path)
    }
}

/// Checks that the file at `path` holds `trial`.
#[allow(clippy::cast_possible_truncation)]
fn check_same(
    files: &dyn Files,
    path: &Path,
    trial: &Trial,
    form: &TrialForm,
) -> Result<(), StoreError> {
    let mut stored = trial.clone();
    // A form without a column for the answer leaves it to the log.
    stored.meta.likert = trial.meta.likert.filter(|_| form.likert);
    // Some columns come back from a file narrower.
    for signal in Signal::all().filter(|s| s.column().storage == Storage::F32) {
        if let Some(values) = trial.samples.get(signal) {
            stored.samples.set(signal, values.iter().map(|v| f64::from(*v as f32)).collect());
        }
    }
    if read_whole_trial(files, path)? == stored {
        return Ok(());
    }
    let what = format!("there is another trial {} already", trial.meta.trial);
    let remedy = "finished files never change; find out which of the two is the right one";
    Err(StoreError::new(path, what, remedy))
}

/// Syncs every folder from a file up to the root: a process that was killed may have left names
/// unsynced.
fn settle(files: &dyn Files, layout: &Layout, path: &Path) -> Result<(), StoreError> {
    let below_root =
        folder_of(path).ancestors().take_while(|folder| folder.starts_with(layout.root()));
    let folders = below_root.filter(|folder| *folder != Path::new(""));
    for folder in folders {
        files.sync_folder(folder).map_err(|e| StoreError::io(folder, "sync the folder", &e))?;
    }
    Ok(())
}
