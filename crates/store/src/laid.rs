//! A session is laid down before its first trial: its copy of `study.toml`, its record, and the first line of its log,
//! which holds the record's hash. Later all three are held against each other, against the trials' footers, and against
//! the present `study.toml`.

use crate::alike::check_session_ids;
use crate::regular::text;
use crate::study::MOST_STUDY;
use crate::{
    Files, Layout, SessionLog, StoreError, TrialEntry, append_events, hex_blake3, replace, write_new,
};
use std::path::Path;
use zwidth_study::{Affects, Event, SessionRecord, Study, StudyChange, study_changes};

/// Lays a session down. `study_toml` is the text of the `study.toml` in force. What an earlier attempt that was killed
/// has done is done again.
///
/// # Errors
/// A record of the session that is there already; ids that differ only by case from those of another; a write that failed.
pub fn lay_down(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
    record: &SessionRecord,
    study_toml: &[u8],
) -> Result<(), StoreError> {
    check_session_ids(files, layout, &record.participant, &record.session)?;
    let path = layout.session(&record.participant, &record.session);
    let json = record_bytes(&path, record)?;
    if files.kind(&path).is_none() {
        // Without a record no session names the copy: it is what a kill left.
        replace(files, &layout.study_copy(&record.participant, &record.session), study_toml)?;
    }
    write_new(files, &path, &json)?;
    let log = layout.events(&record.participant, &record.session);
    append_events(files, &log, utc, &[laid_down(&json)])
}

/// The bytes of a record's file.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn record_bytes(path: &Path, record: &SessionRecord) -> Result<Vec<u8>, StoreError> {
    let text = record.to_json().map_err(|e| StoreError::new(path, e.to_string(), "please report this"))?;
    Ok(text.into_bytes())
}

/// The event that says that a session was laid down with this record.
pub fn laid_down(record: &[u8]) -> Event {
    Event::LaidDown { record_blake3: hex_blake3(record) }
}

/// Writes the first line of a log that a kill kept from being written: the record stands alone then.
pub(crate) fn mend_laid_down(
    files: &dyn Files,
    layout: &Layout,
    record: &SessionRecord,
    bytes: &[u8],
    utc: &str,
) -> Result<bool, StoreError> {
    let log = layout.events(&record.participant, &record.session);
    let alone = files.kind(&log).is_none() && files.kind(&crate::head::head_of(&log)).is_none();
    if alone {
        append_events(files, &log, utc, &[laid_down(bytes)])?;
    }
    Ok(alone)
}

const RESTORE: &str = "restore the session's files from a copy, or exclude its trials";

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
            let what = "the record is not the one that the session was laid down with, by its log";
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
) -> Result<Option<Study>, StoreError> {
    let path = layout.study_copy(&record.participant, &record.session);
    if files.kind(&path).is_none() {
        return Ok(None);
    }
    let text = text(files, &path, MOST_STUDY)?;
    if hex_blake3(text.as_bytes()) != record.study_blake3 {
        let what = "it is not the study.toml that the session was laid down with, by the hash in its record";
        return Err(StoreError::new(&path, what, RESTORE));
    }
    let first = |errors: Vec<zwidth_study::StudyError>| {
        let what = errors.first().map_or_else(String::new, ToString::to_string);
        StoreError::new(&path, what, RESTORE)
    };
    Study::from_toml(&text).map(Some).map_err(first)
}

/// What a trial's footer says of it that its session's record says otherwise.
pub(crate) fn contradiction(trial: &TrialEntry, log: &SessionLog) -> Option<String> {
    let (record, meta) = (&log.record, &trial.meta);
    let differs = |what: &str, footer: &str, record: &str| {
        (footer != record).then(|| format!("its {what} is '{footer}' and '{record}' in its session's record"))
    };
    let footer = |key: &str| trial.file.get(key).map(String::as_str);
    let both = |what: &str, key: &str, of_record: Option<&str>| differs(what, footer(key)?, of_record?);
    // A trial that was done again, or sealed, stands in the session's trials as they are known now.
    let planned = log.record.trials.iter().find(|t| t.trial == meta.trial);
    let of_plan = planned.and_then(|t| {
        differs("environment", meta.environment.as_str(), t.environment.as_str())
            .or_else(|| differs("mode", meta.mode.as_str(), t.mode.as_str()))
            .or_else(|| differs("kind", meta.kind.as_str(), t.kind.as_str()))
            .or_else(|| differs("repeat", &meta.repeat.to_string(), &t.repeat.to_string()))
    });
    let accepted = log.studies().any(|hash| footer("study_blake3").is_none_or(|of_trial| of_trial == hash));
    let seed = record.seed.map(|seed| seed.to_string());
    differs("source", meta.source.as_str(), record.source.as_str())
        .or(of_plan)
        .or_else(|| both("calibration", "calibration_blake3", record.calibration_blake3.as_deref()))
        .or_else(|| both("device", "device", record.device.as_deref()))
        .or_else(|| both("seed", "seed", seed.as_deref()))
        .or_else(|| {
            (!accepted)
                .then(|| "it was recorded under a study.toml that its session does not know".to_owned())
        })
}

/// What changed in `study.toml` since a session was laid down and may matter to it: a warning, until an event accepts
/// the present one. `hash` is the present file's.
pub(crate) fn study_warning(
    layout: &Layout,
    log: &SessionLog,
    study: &Study,
    hash: &str,
) -> Option<StoreError> {
    if log.studies().any(|known| known == hash) {
        return None;
    }
    let (participant, session) = (&log.record.participant, &log.record.session);
    let changes = match &log.study {
        None => "what changed is not known, because the session has no copy of it".to_owned(),
        Some(then) => {
            let matters = |change: &StudyChange| change.affects == Affects::Recording;
            let told: Vec<String> =
                study_changes(then, study).iter().filter(|c| matters(c)).map(ToString::to_string).collect();
            if told.is_empty() {
                return None;
            }
            told.join("; ")
        }
    };
    let what = format!("study.toml is another than when {participant} {session} was laid down: {changes}");
    let remedy = match &log.study {
        None => "put it back as it was, or say so where results are reported".to_owned(),
        Some(_) => {
            let copy = layout.study_copy(participant, session);
            format!("put it back; as it was, it is {}", layout.shown(&copy).display())
        }
    };
    Some(StoreError::new(&log.path, what, remedy))
}
