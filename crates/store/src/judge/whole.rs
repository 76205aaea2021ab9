//! The consistency of one session: record, log, copy of `study.toml` and trials. A session may be
//! continued only if it is whole: trials added to a doubtful session would be doubtful too.

use crate::disk::hash::blake3_of;
use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::change_list::pending;
use crate::form::entries::read_trials;
use crate::form::entry::MOST_STUDY;
use crate::form::events::read_events_from;
use crate::form::head::head_of;
use crate::form::session_record::{MOST_RECORD, record_from};
use crate::judge::laid::{RESTORE, check_record, is_copy};
use crate::judge::sessions::{join, keep, lost, read_session as read_named};
use crate::{Files, Layout, SessionLog, StoreError, TrialEntry};
use std::collections::BTreeSet;
use std::sync::Arc;
use zwidth_study::{Event, ParticipantId, SessionId, SessionRecord, Study};

/// A session whose parts are all there and fit each other.
#[derive(Debug, Clone, PartialEq)]
pub struct WholeSession {
    /// Its record and its log.
    pub log: SessionLog,
    /// Its trials, by number.
    pub trials: Vec<TrialEntry>,
}

/// Reads one session with its trials; none if it does not exist yet.
///
/// # Errors
/// Every finding: a record, a log or a copy of `study.toml` that is gone or was changed; a trial
/// that is gone, was changed, or is not in the log.
pub fn read_session(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Result<Option<WholeSession>, Vec<StoreError>> {
    if files.kind(&layout.session(participant, session)).is_none() {
        let left = left_behind(files, layout, participant, session);
        return left.map_or(Ok(None), |finding| Err(vec![finding]));
    }
    let mut findings = Vec::new();
    let log =
        log_of(files, layout, participant, session, &mut findings).map_err(|error| vec![error])?;
    let folder = layout.trials_of(participant, session);
    let mut trials = keep(&mut findings, read_trials(files, None, layout, &folder));
    findings.extend(join(files, layout, &mut trials, std::slice::from_ref(&log), &BTreeSet::new()));
    if findings.is_empty() { Ok(Some(WholeSession { log, trials })) } else { Err(findings) }
}

/// Whether a session that was laid down still is what it was: its record, its log and its copy of
/// `study.toml` by their content, its trials by their names.
///
/// # Errors
/// The first finding.
pub(crate) fn check_session(
    files: &dyn Files,
    layout: &Layout,
    record: &SessionRecord,
) -> Result<(), StoreError> {
    let SessionRecord { participant, session, .. } = record;
    let path = layout.session(participant, session);
    let events = read_events_from(files, &layout.events(participant, session))?;
    if events.is_empty() && has_samples(files, layout, participant, session) {
        let what = "the session's log is missing, and trials of it are there";
        return Err(StoreError::new(&layout.events(participant, session), what, RESTORE));
    }
    let text = text(files, &path, MOST_RECORD)?;
    check_record(&path, text.as_bytes(), &events)?;
    if is_laid_down(&events) {
        let path = layout.study_copy(participant, session);
        if files.kind(&path).is_none() {
            return Err(no_copy(files, layout, record));
        }
        let bytes = files.read(&path, MOST_STUDY).map_err(|e| StoreError::io(&path, "read", &e))?;
        is_copy(&path, &bytes, record)?;
    } else if record_from(&path, &text)? != *record {
        let what = "the record was changed while the session ran";
        return Err(StoreError::new(&path, what, RESTORE));
    }
    lost(files, layout, record, &events).into_iter().next().map_or(Ok(()), Err)
}

/// The study with which a session was set up, as its copy says; none for a session that does not
/// exist yet, or that is older than such copies.
///
/// # Errors
/// A record, a log or a copy that is gone or was changed.
pub fn session_study(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Result<Option<Study>, StoreError> {
    if files.kind(&layout.session(participant, session)).is_none() {
        return left_behind(files, layout, participant, session).map_or(Ok(None), Err);
    }
    let log = log_of(files, layout, participant, session, &mut Vec::new())?;
    Ok(log.study.map(Arc::unwrap_or_clone))
}

/// The record and the log of a session that must be there.
fn log_of(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
    findings: &mut Vec<StoreError>,
) -> Result<SessionLog, StoreError> {
    let name = format!("{participant}_{session}");
    let log = read_named(files, layout, &name, &pending(files, layout), findings)?;
    if (&log.record.participant, &log.record.session) != (participant, session) {
        let what = format!(
            "it is the record of session {} of {}, whose files have the same names",
            log.record.session, log.record.participant
        );
        return Err(StoreError::new(&log.path, what, "choose other ids"));
    }
    if log.study.is_none() && is_laid_down(&log.events) {
        return Err(no_copy(files, layout, &log.record));
    }
    Ok(log)
}

/// Whether a log begins with its session's being laid down: for as long sessions have had a copy of
/// `study.toml`.
fn is_laid_down(events: &[Event]) -> bool {
    events.iter().any(|event| matches!(event, Event::LaidDown { .. }))
}

fn no_copy(files: &dyn Files, layout: &Layout, record: &SessionRecord) -> StoreError {
    let copy = layout.study_copy(&record.participant, &record.session);
    let now = blake3_of(files, &layout.study_toml());
    let remedy = if now.is_ok_and(|hash| hash == record.study_blake3) {
        "study.toml is what it was, so copy it to this name"
    } else {
        "restore it from a copy"
    };
    StoreError::new(&copy, "the session's copy of study.toml is missing", remedy)
}

/// What of a session without a record is there all the same. A copy of `study.toml` alone is what a
/// kill leaves before anything was laid down.
fn left_behind(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Option<StoreError> {
    let log = layout.events(participant, session);
    let left = if files.kind(&log).is_some() || files.kind(&head_of(&log)).is_some() {
        "its log is"
    } else if has_samples(files, layout, participant, session) {
        "trials of it are"
    } else {
        return None;
    };
    let what = format!("the session's record is missing, and {left} there");
    let remedy = "restore the session's files from a copy, or begin a session with another id";
    Some(StoreError::new(&layout.session(participant, session), what, remedy))
}

/// Whether there is a trial of a session, finished or not.
pub(crate) fn has_samples(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> bool {
    let trials = files_below(files, &layout.trials_of(participant, session));
    if trials.is_ok_and(|paths| !paths.is_empty()) {
        return true;
    }
    // No id has a dot.
    let journal = format!("{participant}_{session}.trial-");
    let names = files_below(files, &layout.journals()).unwrap_or_default();
    names
        .iter()
        .filter_map(|path| path.file_name())
        .any(|name| name.to_string_lossy().starts_with(&journal))
}
