//! The study with which a session continues: its own copy, whatever `study.toml` says by then.

use crate::AcquireError;
use crate::plan::Plan;
use zwidth_store::{Files, Layout, SessionLog, hex_blake3, session_study};
use zwidth_study::{
    Affects, Control, Event, ParticipantId, SessionId, Study, StudyChange, study_changes,
};

/// The study with which an existing session continues: its own copy. `None` for a session that is
/// to begin, and for one from before there were copies.
///
/// # Errors
/// A session that is not whole.
pub fn own_study(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Result<Option<Study>, AcquireError> {
    session_study(files, layout, participant, session).map_err(|finding| AcquireError::NotWhole {
        session: format!("{participant} {session}"),
        findings: vec![finding],
    })
}

/// The events for the log where `study.toml` differs from the session's own copy.
///
/// # Errors
/// A change of what is recorded that nobody has accepted; a session without a copy, of which nobody
/// knows what changed.
pub(crate) fn opening(plan: &Plan, log: &SessionLog) -> Result<Vec<Event>, AcquireError> {
    let hash = hex_blake3(&plan.study_toml);
    let Some(own) = log.study.as_deref() else {
        if hash == log.record.study_blake3 {
            return Ok(Vec::new());
        }
        return Err(AcquireError::refused(
            format!(
                "{}: study.toml has changed since the session began, and the session has no copy of it, so what changed \
                 is not known",
                log.path.display()
            ),
            "put study.toml back as it was, or begin a new session",
        ));
    };
    // The rate may be another by request, and was compared with the record's before this.
    let control = Control { rate_hz: plan.study.control.rate_hz, ..own.control };
    if plan.study != (Study { control, ..own.clone() }) {
        return Err(AcquireError::refused(
            "the session has to go on with its own copy of study.toml, and was given another",
            "this is a defect of zwidth, please report it",
        ));
    }
    if log.studies().any(|accepted| accepted == hash) {
        return Ok(Vec::new());
    }
    let text = String::from_utf8_lossy(&plan.study_toml);
    let present = Study::from_toml(&text).map_err(|errors| {
        let first = errors.first().map_or_else(String::new, |e| format!("study.toml: {e}"));
        AcquireError::refused(first, "mend it")
    })?;
    let changes = study_changes(own, &present);
    let (matter, rest): (Vec<_>, Vec<_>) =
        changes.iter().partition(|c| c.affects == Affects::Recording);
    let words = |changes: &[&StudyChange]| {
        changes.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    if !matter.is_empty() && !plan.accept_study_change {
        return Err(AcquireError::refused(
            format!(
                "{}: study.toml has changed since the session began: {}",
                log.path.display(),
                words(&matter)
            ),
            "put it back, or go on by the session's own copy of it with --accept-study-change",
        ));
    }
    let text = match (matter.is_empty(), rest.is_empty()) {
        (true, true) => {
            "study.toml differs from the session's copy in comments or form alone".to_owned()
        }
        (true, false) => {
            format!("study.toml has changed in nothing that is recorded: {}", words(&rest))
        }
        (false, _) => format!(
            "study.toml has changed, and the session goes on by its own copy: {}",
            words(&matter)
        ),
    };
    let accepted = (!matter.is_empty()).then_some(Event::StudyAccepted { study_blake3: hash });
    let note = Event::Note { trial: None, text };
    // Noted once, however often the session is gone on with.
    let note = (!log.events.contains(&note)).then_some(note);
    Ok(accepted.into_iter().chain(note).collect())
}
