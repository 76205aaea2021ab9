//! Sessions: their records and event logs, and what the events say about the trials.

use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::change_list::pending;
use crate::form::events::read_events_to;
use crate::form::read::read_trial_from;
use crate::form::session_record::{MOST_RECORD, RESTORE, record_from};
use crate::judge::alike::apart;
use crate::judge::calibrated::check_calibration;
use crate::judge::laid::{check_record, contradiction, read_copy};
use crate::judge::sealed::{SessionTrials, session_trials};
use crate::{Entry, Files, Layout, SessionLog, Signal, StoreError, TrialEntry};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::ffi::OsStr;
use std::path::PathBuf;
use zwidth_study::{Event, SessionRecord};

/// What could be read; what could not is told with the `problems`.
pub(crate) fn keep<T>(
    problems: &mut Vec<StoreError>,
    results: Vec<Result<T, StoreError>>,
) -> Vec<T> {
    // The list of a large study is long: it stays in its place.
    results.into_iter().filter_map(|result| result.map_err(|e| problems.push(e)).ok()).collect()
}

/// Every readable session, and the names (`<participant>_<session>`) of those that are not, or
/// whose ids another's are like.
pub(crate) fn read_sessions(
    files: &dyn Files,
    layout: &Layout,
    problems: &mut Vec<StoreError>,
) -> (Vec<SessionLog>, BTreeSet<String>) {
    let mut sessions = Vec::new();
    let mut unreadable = BTreeSet::new();
    let paths = files_below(files, &layout.sessions()).unwrap_or_else(|error| {
        problems.push(error);
        Vec::new()
    });
    let pending = pending(files, layout);
    // By logs too: one whose record is gone is a finding.
    let names = paths.iter().filter_map(|path| {
        let name = path.file_name()?.to_str()?;
        name.strip_suffix(".events.jsonl").or(name.strip_suffix(".json")).map(str::to_owned)
    });
    let names: BTreeSet<String> = names.collect();
    let read: Vec<_> = names
        .into_par_iter()
        .map(|name| {
            let mut problems = Vec::new();
            (read_session(files, layout, &name, &pending, &mut problems), problems, name)
        })
        .collect();
    for (session, findings, name) in read {
        problems.extend(findings);
        match session {
            Ok(session) => sessions.push(session),
            Err(problem) => {
                problems.push(problem);
                unreadable.insert(name);
            }
        }
    }
    let (sessions, clashing) = apart(sessions);
    for (session, finding) in clashing {
        unreadable.insert(name(&session));
        problems.push(finding);
    }
    (sessions, unreadable)
}

/// One session by the name of its files, `<participant>_<session>`. Lines of a change that was not
/// made are passed over: `pending` has how many bytes of a log are of before.
pub(crate) fn read_session(
    files: &dyn Files,
    layout: &Layout,
    name: &str,
    pending: &BTreeMap<PathBuf, usize>,
    problems: &mut Vec<StoreError>,
) -> Result<SessionLog, StoreError> {
    let path = layout.sessions().join(format!("{name}.json"));
    let text = text(files, &path, MOST_RECORD)?;
    let record = record_from(&path, &text)?;
    if path != layout.session(&record.participant, &record.session) {
        let what =
            format!("by its content it is the record of {} {}", record.participant, record.session);
        return Err(StoreError::new(&path, what, RESTORE));
    }
    let events_path = layout.events(&record.participant, &record.session);
    let events = read_events_to(files, &events_path, pending.get(&events_path).copied())?;
    check_record(&path, text.as_bytes(), &events)?;
    check_calibration(&path, &text)?;
    let study = read_copy(files, layout, &record)?;
    let SessionTrials { trials, seal, problems: unopened } =
        session_trials(&record, &events, &events_path);
    problems.extend(unopened);
    Ok(SessionLog { record, path, events, events_path, trials, seal, study })
}

/// Joins the events to the trials, and says what does not fit together.
///
/// A trial that no log calls recorded does not count: nobody knows whether it was superseded or
/// excluded. Those of `unreadable` sessions are not told again.
pub(crate) fn join(
    files: &dyn Files,
    layout: &Layout,
    trials: &mut [TrialEntry],
    sessions: &[SessionLog],
    unreadable: &BTreeSet<String>,
) -> Vec<StoreError> {
    let logs: BTreeMap<String, &SessionLog> = sessions.iter().map(|log| (name(log), log)).collect();
    let mut silent: BTreeMap<PathBuf, Vec<String>> = BTreeMap::new();
    let mut changed = Vec::new();
    for trial in trials {
        let m = &trial.meta;
        let name = format!("{}_{}", m.participant, m.session);
        let log = logs.get(&name).copied();
        let hash = log.and_then(|log| join_one(trial, &log.events));
        let Some((log, hash)) = log.zip(hash) else {
            if !unreadable.contains(&name) {
                let path = layout.events(&trial.meta.participant, &trial.meta.session);
                silent.entry(path).or_default().push(trial.meta.trial.to_string());
            }
            trial.excluded = Some("no event log that can be read mentions it".to_owned());
            continue;
        };
        if hash != trial.blake3 {
            // How the file came to differ: damage, where that can be seen.
            let damage = read_trial_from(files, &trial.path, Signal::all()).err();
            changed.push(damage.unwrap_or_else(|| {
                let what = "the file is not the one that was recorded: its hash differs from the session's log";
                let remedy = "restore the file from a copy, or exclude the trial";
                StoreError::new(&trial.path, what, remedy)
            }));
            trial.excluded = Some("the file is not the one that was recorded".to_owned());
        } else if let Some(what) = contradiction(trial, log) {
            trial.excluded = Some(what.clone());
            let remedy = "restore the session's record or the trial's file from a copy";
            changed.push(StoreError::new(&trial.path, format!("{what}: left out"), remedy));
        } else {
            changed.extend(open(layout, trial, log));
        }
    }
    let silent = silent.iter().map(|(path, trials)| {
        let words = if trials.len() == 1 { "trial" } else { "trials" };
        let what = format!("the log does not mention {words} {}: left out", trials.join(", "));
        StoreError::new(path, what, RESTORE)
    });
    let lost = sessions.par_iter().map(|log| lost(files, layout, &log.record, &log.events));
    let lost: Vec<Vec<StoreError>> = lost.collect();
    silent.chain(changed).chain(lost.into_iter().flatten()).collect()
}

/// Why no trial of a session counts whose modes are sealed.
pub(crate) fn why_sealed(layout: &Layout, record: &SessionRecord) -> String {
    let SessionRecord { participant, session, .. } = record;
    let command = format!("zwidth unseal {} -p {participant} -s {session}", layout.study());
    format!("sealed: unseal with `{command}`")
}

/// Gives a trial of a sealed session its mode, or says how it gets one; what does not fit is an
/// error, and leaves it out.
fn open(layout: &Layout, trial: &mut TrialEntry, log: &SessionLog) -> Option<StoreError> {
    log.record.commitment.as_ref()?;
    let Some(seal) = &log.seal else {
        trial.sealed = Some(why_sealed(layout, &log.record));
        return None;
    };
    let planned = log.trials.iter().find(|t| t.trial == trial.meta.trial);
    match planned.filter(|_| trial.meta.mode == seal.code(trial.meta.trial)) {
        Some(planned) => {
            trial.meta.mode = planned.mode.clone();
            trial.meta.repeat = planned.repeat;
            None
        }
        None => {
            let what = format!(
                "the mode '{}' is not the code of this trial of the session",
                trial.meta.mode
            );
            trial.sealed = Some(what.clone());
            Some(StoreError::new(&trial.path, format!("{what}: left out"), RESTORE).column("mode"))
        }
    }
}

fn name(log: &SessionLog) -> String {
    format!("{}_{}", log.record.participant, log.record.session)
}

/// Why a trial does not count that did not meet the protocol.
pub(crate) fn unmet(what: &str) -> String {
    format!("the protocol was not met: {what}")
}

/// Joins a session's events to one of its trials; the hash with which it was recorded, if it was.
fn join_one(trial: &mut TrialEntry, events: &[Event]) -> Option<String> {
    let mut recorded = None;
    for event in events.iter().filter(|e| e.trial() == Some(trial.meta.trial)) {
        match event {
            Event::Recorded { blake3, .. } => recorded = Some(blake3.clone()),
            Event::Superseded { by, .. } => trial.superseded_by = Some(*by),
            Event::Excluded { reason, .. } => trial.excluded = Some(reason.clone()),
            Event::Unmet { what, .. } => {
                trial.excluded.get_or_insert_with(|| unmet(what));
                trial.is_unmet = true;
            }
            Event::Answer { .. }
            | Event::Level { .. }
            | Event::Note { .. }
            | Event::Marker { .. }
            | Event::Unsealed { .. }
            | Event::StudyAccepted { .. }
            | Event::PersonAccepted { .. }
            | Event::LaidDown { .. }
            | Event::SweepRecorded { .. }
            | Event::MetricGiven { .. }
            | Event::MetricWithdrawn { .. }
            | Event::StreamGiven { .. }
            | Event::StreamWithdrawn { .. } => {}
        }
    }
    recorded
}

/// Trials of a session, by its record or its log, that were not left out and whose files are gone.
pub(crate) fn lost(
    files: &dyn Files,
    layout: &Layout,
    record: &SessionRecord,
    events: &[Event],
) -> Vec<StoreError> {
    let recorded =
        events.iter().filter(|e| matches!(e, Event::Recorded { .. })).filter_map(Event::trial);
    // A session that is being recorded has trials still to come; an imported one was whole when it
    // was laid down.
    let imported = record.source.is_imported();
    let planned = record.trials.iter().filter(|t| imported && t.samples).map(|t| t.trial);
    let trials: BTreeSet<u32> = recorded.chain(planned).collect();
    // One list of the folder: to ask for each trial takes far longer.
    let folder = layout.trials_of(&record.participant, &record.session);
    let entries = if trials.is_empty() { None } else { files.list(&folder).ok() };
    let entries = entries.unwrap_or_default();
    let existing = entries.iter().filter(|(_, kind)| *kind == Entry::File);
    let existing: HashSet<&OsStr> = existing.filter_map(|(path, _)| path.file_name()).collect();
    let mut lost = Vec::new();
    for trial in trials {
        let path = layout.trial(&record.participant, &record.session, trial);
        if path.file_name().is_some_and(|name| existing.contains(name)) {
            continue;
        }
        let mut own = events.iter().filter(|event| event.trial() == Some(trial));
        let is_left_out = |event: &Event| {
            matches!(event, Event::Superseded { .. } | Event::Excluded { .. } | Event::Unmet { .. })
        };
        if !own.any(is_left_out) {
            let what = "the trial belongs to the session, but its file is missing";
            let remedy = "restore the file from a copy, or exclude the trial";
            lost.push(StoreError::new(&path, what, remedy));
        }
    }
    lost
}
