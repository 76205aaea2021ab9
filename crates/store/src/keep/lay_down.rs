//! A session is set up before its first trial: its copy of `study.toml`, its record, and the first
//! line of its log, which holds the record's hash.

use crate::form::head::head_of;
use crate::judge::alike::check_session_ids;
use crate::judge::laid::RESTORE;
use crate::judge::whole::has_samples;
use crate::{Files, Layout, StoreError, append_events, hex_blake3, replace, write_new};
use std::path::Path;
use zwidth_study::{Event, SessionRecord};

/// Sets a session up. `study_toml` is the text of the `study.toml` in force. The steps of an
/// earlier attempt that was killed are repeated.
///
/// # Errors
/// A record of the session that already exists; ids that differ only by case from those of another;
/// a write that failed.
pub fn lay_down(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
    record: &SessionRecord,
    study_toml: &[u8],
) -> Result<(), StoreError> {
    // Copy, record, log: each names the one before it, so that a kill leaves none that names what
    // is not there.
    check_session_ids(files, layout, &record.participant, &record.session)?;
    let path = layout.session(&record.participant, &record.session);
    let json = record_bytes(&path, record)?;
    if files.kind(&path).is_none() {
        // Without a record no session names the copy: it is what a kill left.
        replace(files, &layout.study_copy(&record.participant, &record.session), study_toml)?;
    }
    let log = layout.events(&record.participant, &record.session);
    if files.kind(&path).is_none()
        && (files.kind(&log).is_some() || files.kind(&head_of(&log)).is_some())
    {
        let what = "there is a log of the session already, and its record is missing";
        return Err(StoreError::new(&log, what, RESTORE));
    }
    write_new(files, &path, &json)?;
    append_events(files, &log, utc, &[laid_down(&json)])
}

/// The bytes of a record's file.
///
/// # Errors
/// A value that JSON cannot hold.
pub fn record_bytes(path: &Path, record: &SessionRecord) -> Result<Vec<u8>, StoreError> {
    record.to_json().map(String::into_bytes).map_err(|e| StoreError::defect(path, &e))
}

/// The event that says that a session was set up with this record.
pub fn laid_down(record: &[u8]) -> Event {
    Event::LaidDown { record_blake3: hex_blake3(record) }
}

/// Writes the first line of a log that a kill kept from being written: the record stands alone
/// then.
pub(crate) fn mend_laid_down(
    files: &dyn Files,
    layout: &Layout,
    record: &SessionRecord,
    bytes: &[u8],
    utc: &str,
) -> Result<bool, StoreError> {
    let SessionRecord { participant, session, .. } = record;
    let log = layout.events(participant, session);
    // Nothing is recorded before the first line of the log: with a trial beside it the record does
    // not stand alone, but has lost its log. The trials of an import come first.
    let alone = files.kind(&log).is_none()
        && files.kind(&head_of(&log)).is_none()
        && (record.source.is_imported() || !has_samples(files, layout, participant, session));
    if alone {
        append_events(files, &log, utc, &[laid_down(bytes)])?;
    }
    Ok(alone)
}
