//! A session is set up before its first trial: its copy of `study.toml`, its record, and the first
//! line of its log, which holds the record's hash. Later all three are compared with each other,
//! with the trials' footers, and with the present `study.toml`.

use crate::disk::regular::text;
use crate::form::entry::MOST_STUDY;
use crate::memo::Memo;
use crate::{Files, Layout, SessionLog, StoreError, TrialEntry, hex_blake3};
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;
use zwidth_study::{Affects, Event, SessionRecord, Study, study_changes};

pub(crate) const RESTORE: &str = "restore the session's files from a copy, or exclude its trials";

/// Whether the record is the one that was laid down, by the log.
///
/// # Errors
/// It is another: nobody knows then what was recorded with what.
pub(crate) fn check_record(path: &Path, bytes: &[u8], events: &[Event]) -> Result<(), StoreError> {
    let hash = hex_blake3(bytes);
    let laid = events.iter().find_map(|event| match event {
        Event::LaidDown { record_blake3 } => Some(record_blake3),
        _ => None,
    });
    match laid {
        Some(laid) if *laid != hash => {
            let what = "the record is not the one that the session began with, by its log";
            Err(StoreError::new(path, what, RESTORE))
        }
        _ => Ok(()),
    }
}

/// The study as it was when the session was laid down; nothing for a session without a copy.
///
/// # Errors
/// A copy that cannot be read, or that is not the one whose hash the record has.
pub(crate) fn read_copy(
    files: &dyn Files,
    layout: &Layout,
    record: &SessionRecord,
) -> Result<Option<Arc<Study>>, StoreError> {
    thread_local! {
        // Most sessions of a study have the same.
        static LAST: RefCell<Memo<String, Arc<Study>>> = const { RefCell::new(Memo::new()) };
    }
    let path = layout.study_copy(&record.participant, &record.session);
    if files.kind(&path).is_none() {
        return Ok(None);
    }
    let text = text(files, &path, MOST_STUDY)?;
    is_copy(&path, text.as_bytes(), record)?;
    let hash = &record.study_blake3;
    if let Some(study) = LAST.with_borrow(|last| last.get(|kept| kept == hash)) {
        return Ok(Some(study));
    }
    let study = Arc::new(Study::from_toml(&text).map_err(|errors| {
        let what = errors.first().map_or_else(String::new, ToString::to_string);
        StoreError::new(&path, what, RESTORE)
    })?);
    LAST.with_borrow_mut(|last| last.keep(hash.clone(), study.clone()));
    Ok(Some(study))
}

/// Whether these bytes are the `study.toml` of a record.
///
/// # Errors
/// They have not the hash in it.
pub(crate) fn is_copy(path: &Path, bytes: &[u8], record: &SessionRecord) -> Result<(), StoreError> {
    if hex_blake3(bytes) == record.study_blake3 {
        return Ok(());
    }
    let what = "it is not the study.toml that the session began with, by the hash in its record";
    Err(StoreError::new(path, what, RESTORE))
}

/// The first contradiction between a trial's footer and its session's record, in words.
pub(crate) fn contradiction(trial: &TrialEntry, log: &SessionLog) -> Option<String> {
    let record = &log.record;
    let meta = &trial.meta;
    // A trial that was done again, or sealed, stands in the session's trials as they are known now.
    let planned = log.record.trials.iter().find(|t| t.trial == meta.trial);
    let repeats = planned.map(|t| (meta.repeat.to_string(), t.repeat.to_string()));
    let seed = record.seed.map(|seed| seed.to_string());
    let place = planned.and_then(|t| t.task.as_ref());
    let presented = meta.presented.as_ref().zip(place);
    let intervals =
        presented.map(|(own, place)| (own.interval.to_string(), place.interval.to_string()));
    // A level that the record plans; others stand in the log.
    let levels = presented.and_then(|(own, place)| {
        let task = log.study.as_ref()?.task(&place.task)?;
        let planned = place.presented(task, place.level?).level?;
        Some((own.level?.value().to_string(), planned.value().to_string()))
    });
    let [calibration, device, own_seed, study] =
        ["calibration_blake3", "device", "seed", "study_blake3"]
            .map(|key| trial.said.file.get(key).map(String::as_str));
    // What one of the two does not say contradicts nothing.
    let both_say = [
        ("source", Some((meta.source.as_str(), record.source.as_str()))),
        ("environment", planned.map(|t| (meta.environment.as_str(), t.environment.as_str()))),
        ("mode", planned.map(|t| (meta.mode.as_str(), t.mode.as_str()))),
        ("kind", planned.map(|t| (meta.kind.as_str(), t.kind.as_str()))),
        ("repeat", repeats.as_ref().map(|(own, planned)| (own.as_str(), planned.as_str()))),
        ("task", presented.map(|(own, place)| (own.task.as_str(), place.task.as_str()))),
        ("interval", intervals.as_ref().map(|(own, planned)| (own.as_str(), planned.as_str()))),
        ("level", levels.as_ref().map(|(own, planned)| (own.as_str(), planned.as_str()))),
        ("calibration", calibration.zip(record.calibration_blake3.as_deref())),
        ("device", device.zip(record.device.as_deref())),
        ("seed", own_seed.zip(seed.as_deref())),
    ];
    for (what, pair) in both_say {
        if let Some((footer, record)) = pair.filter(|(footer, record)| footer != record) {
            return Some(format!(
                "its {what} is '{footer}' and '{record}' in its session's record"
            ));
        }
    }
    let accepted = log.studies().any(|hash| study.is_none_or(|study| study == hash));
    (!accepted).then(|| "it was recorded with a study.toml that its session never had".to_owned())
}

/// What changed in `study.toml` since a session was laid down and matters to it, in words, accepted
/// or not; nothing if nothing does. `hash` is the present file's.
pub(crate) fn matters(log: &SessionLog, study: &Study, hash: &str) -> Option<String> {
    if log.record.study_blake3 == hash {
        return None;
    }
    let Some(then) = &log.study else {
        return Some("what changed is not known, because the session has no copy of it".to_owned());
    };
    let mut changes = study_changes(then, study);
    changes.retain(|change| change.affects == Affects::Recording);
    let words: Vec<String> = changes.iter().map(ToString::to_string).collect();
    (!words.is_empty()).then(|| words.join("; "))
}

/// What changed in `study.toml` since a session was laid down and may matter to it: a warning,
/// until an event accepts the present one. `hash` is the present file's.
pub(crate) fn study_warning(
    layout: &Layout,
    log: &SessionLog,
    study: &Study,
    hash: &str,
) -> Option<StoreError> {
    if log.studies().any(|accepted| accepted == hash) {
        return None;
    }
    let changes = matters(log, study, hash)?;
    let SessionRecord { participant, session, .. } = &log.record;
    let what = format!("study.toml has changed since {participant} {session} began: {changes}");
    let copy = layout.study_copy(participant, session);
    let as_it_was = match &log.study {
        None => String::new(),
        Some(_) => format!(" (as it was, it is {})", layout.shown(&copy).display()),
    };
    let study = layout.study();
    let accept =
        format!("zwidth recover {study} --accept-study-change -p {participant} -s {session}");
    let remedy = format!("put it back{as_it_was}, or accept it with `{accept}`");
    Some(StoreError::new(&log.path, what, remedy))
}

#[cfg(test)]
mod tests;
