//! A trial becomes a file: written as a whole, its place made durable, and called recorded in the
//! session's log.

use crate::atomic::{folder_of, sync_file};
use crate::events::read_events_from;
use crate::frame::Protocol;
use crate::hash::blake3_of;
use crate::read::read_whole_trial;
use crate::{
    Entered, Files, Layout, Samples, Signal, Storage, StoreError, Trial, append_events,
    trial_bytes, write_new,
};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, Schema, TrialForm, TrialMeta};

/// Writes a trial's file, the event that calls it recorded and, from schema 2 on, the event of the
/// answer to its question; gives the file's path. `utc` is the time of the events,
/// `answer_time_ms` what the answer took, where it was measured.
///
/// What a first attempt has done already is not done again: the file may be there with this very
/// trial in it, and the event may be there with the file's hash.
///
/// # Errors
/// Samples that break a promise of the schema; another trial under the same number; a log that
/// cannot be read; a write that failed.
pub fn record_trial<'a>(
    files: &dyn Files,
    layout: &Layout,
    entered: impl Into<Entered<'a>>,
    trial: &Trial,
    protocol: &Protocol,
    answer_time_ms: Option<u32>,
) -> Result<PathBuf, StoreError> {
    let (m, form) = (&trial.meta, &protocol.form);
    let path = layout.trial(&m.participant, &m.session, m.trial);
    if files.kind(&path).is_some() {
        is_this(files, &path, trial, form)?;
    } else {
        write_new(files, &path, &trial_bytes(trial, form, &path)?)?;
    }
    // Before the log speaks of it: the name of the file must not go in a power cut.
    settle(files, layout, &path)?;
    let log = layout.events(&m.participant, &m.session);
    let blake3 = blake3_of(files, &path)?;
    let known = read_events_from(files, &log)?;
    let mut events = Vec::new();
    if !is_recorded(&known, &log, m.trial, &blake3)? {
        events.push(Event::Recorded { trial: m.trial, blake3 });
    }
    events.extend(
        answer(trial, protocol, answer_time_ms).filter(|answer| !is_answered(&known, answer)),
    );
    if events.is_empty() {
        sync_file(files, &log).map_err(|e| StoreError::io(&log, "sync", &e))?;
    } else {
        append_events(files, &log, entered, &events)?;
    }
    settle(files, layout, &log)?;
    Ok(path)
}

/// The event of the answer that was given before the trial's file was finished. In schema 1 the
/// file alone has it.
fn answer(trial: &Trial, protocol: &Protocol, time_ms: Option<u32>) -> Option<Event> {
    let (question, value) = (protocol.question.clone()?, trial.meta.likert?);
    let is_event = protocol.form.schema > Schema::One;
    is_event.then_some(Event::Answer { trial: trial.meta.trial, question, value, time_ms })
}

/// Whether a log has an answer to the same question of the same trial.
fn is_answered(events: &[Event], answer: &Event) -> bool {
    let about = |event: &Event| match event {
        Event::Answer { trial, question, .. } => Some((*trial, question.clone())),
        _ => None,
    };
    events.iter().any(|event| about(event).is_some() && about(event) == about(answer))
}

/// Whether the file at `path` holds `trial`.
fn is_this(
    files: &dyn Files,
    path: &Path,
    trial: &Trial,
    form: &TrialForm,
) -> Result<(), StoreError> {
    let likert = trial.meta.likert.filter(|_| form.likert);
    let meta = TrialMeta { likert, ..trial.meta.clone() };
    let stored = Trial { meta, samples: as_stored(&trial.samples), ..trial.clone() };
    if read_whole_trial(files, path)? == stored {
        return Ok(());
    }
    let what = format!("there is another trial {} already", trial.meta.trial);
    Err(StoreError::new(
        path,
        what,
        "finished files never change; find out which of the two is the right one",
    ))
}

/// The samples as they come back from a file, where some columns are narrower.
#[allow(clippy::cast_possible_truncation)]
fn as_stored(samples: &Samples) -> Samples {
    let mut stored = samples.clone();
    for signal in Signal::all().filter(|s| s.column().storage == Storage::F32) {
        if let Some(values) = samples.get(signal) {
            stored.set(signal, values.iter().map(|v| f64::from(*v as f32)).collect());
        }
    }
    stored
}

/// Whether the log calls the trial recorded, with this hash.
fn is_recorded(events: &[Event], log: &Path, number: u32, hash: &str) -> Result<bool, StoreError> {
    let recorded = events.iter().find_map(|event| match event {
        Event::Recorded { trial, blake3 } if *trial == number => Some(blake3),
        _ => None,
    });
    match recorded {
        None => Ok(false),
        Some(recorded) if recorded == hash => Ok(true),
        Some(_) => {
            let what = format!("trial {number} was recorded already, in a file with another hash");
            Err(StoreError::new(log, what, "restore the session's files from a copy"))
        }
    }
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
