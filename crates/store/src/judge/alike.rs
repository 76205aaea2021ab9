//! Ids that differ only by case: two folders on one system, the same folder on another, and most
//! likely one id that somebody typed in two ways. The program never makes one beside another; if
//! both exist, it is not known whose trials they contain.

use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::session_record::{MOST_RECORD, record_from};
use crate::{Entry, Files, Layout, SessionLog, StoreError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use zwidth_study::{ParticipantId, SessionId};

/// The remedy for ids that are alike.
const RENAME: &str = "use the id that is there, or one that differs by more than case";

/// Whether a session can be made under these ids.
///
/// # Errors
/// A participant, or a session of this participant, whose id differs only by case.
pub fn check_session_ids(
    files: &dyn Files,
    layout: &Layout,
    participant: &ParticipantId,
    session: &SessionId,
) -> Result<(), StoreError> {
    for path in files_below(files, &layout.sessions())? {
        let Some((other, other_session)) = perhaps_alike(files, &path, participant, session) else {
            continue;
        };
        let other = other.as_str();
        let other_session = other_session.as_str();
        if alike(other, participant.as_str()) {
            return Err(clash(&path, "participant", participant.as_str(), other));
        }
        if other == participant.as_str() && alike(other_session, session.as_str()) {
            return Err(clash(&path, "session", session.as_str(), other_session));
        }
    }
    Ok(())
}

/// Whether a study can be made under this layout's id.
///
/// # Errors
/// A study below the same root whose id differs from it only by case.
pub fn check_study_id(files: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
    let id = layout.study().as_str();
    let beside = files.list(&layout.root().join("raw"));
    // Where there is no raw/ yet, there is no other study.
    for (path, kind) in beside.unwrap_or_default() {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        if kind == Entry::Folder && alike(name, id) {
            return Err(clash(&layout.raw(), "study", id, name));
        }
    }
    Ok(())
}

/// The sessions whose ids are unlike all others, and the remaining ones, each with a finding.
pub(crate) fn apart(sessions: Vec<SessionLog>) -> (Vec<SessionLog>, Vec<(SessionLog, StoreError)>) {
    let mut participants: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut ids: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for SessionLog { record, .. } in &sessions {
        let (participant, session) = (record.participant.to_string(), record.session.to_string());
        ids.entry((participant.clone(), session.to_ascii_lowercase())).or_default().insert(session);
        participants.entry(participant.to_ascii_lowercase()).or_default().insert(participant);
    }
    let mut kept = Vec::new();
    let mut clashing = Vec::new();
    for log in sessions {
        let participant = log.record.participant.to_string();
        let session = log.record.session.as_str();
        let people = participants.get(&participant.to_ascii_lowercase());
        let error = match another(people, &participant) {
            Some(other) => Some(clash(&log.path, "participant", &participant, other)),
            None => another(ids.get(&(participant, session.to_ascii_lowercase())), session)
                .map(|other| clash(&log.path, "session", session, other)),
        };
        let Some(error) = error else {
            kept.push(log);
            continue;
        };
        let what = format!("{}: its trials are left out", error.what);
        let remedy = "find out whose trials they are, and import the sessions anew under one id";
        clashing.push((log, StoreError { what, remedy: remedy.to_owned(), ..error }));
    }
    (kept, clashing)
}

/// The first of some ids that is not this one.
fn another<'s>(ids: Option<&'s BTreeSet<String>>, id: &str) -> Option<&'s str> {
    ids?.iter().map(String::as_str).find(|other| *other != id)
}

fn alike(a: &str, b: &str) -> bool {
    a != b && a.eq_ignore_ascii_case(b)
}

fn clash(path: &Path, what: &str, id: &str, other: &str) -> StoreError {
    StoreError::new(path, format!("the {what} '{id}' differs from '{other}' only by case"), RENAME)
}

/// Participant and session of a record whose file's name could be one of ids that are alike; the
/// others are not read.
fn perhaps_alike(
    files: &dyn Files,
    path: &Path,
    participant: &ParticipantId,
    session: &SessionId,
) -> Option<(ParticipantId, SessionId)> {
    let stem = path.file_name()?.to_str()?.strip_suffix(".json")?;
    let of_participant = format!("{participant}_");
    let whole = format!("{participant}_{session}");
    // By `get`: where this text ends, another's name may be in the middle of a letter.
    let start = stem.get(..of_participant.len()).unwrap_or_default();
    let of_another = alike(start, &of_participant);
    if !of_another && !alike(stem, &whole) {
        return None;
    }
    let record = record_from(path, &text(files, path, MOST_RECORD).ok()?).ok()?;
    Some((record.participant, record.session))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{UTC, folder_with_study, record, toml};
    use crate::{RealFiles, StudyData, lay_down, verify};
    use zwidth_study::SessionRecord;

    fn lay(layout: &Layout, participant: &str, session: &str) -> Result<(), StoreError> {
        let record = SessionRecord {
            participant: participant.parse().unwrap(),
            session: session.parse().unwrap(),
            ..record(layout, Vec::new())
        };
        lay_down(&RealFiles, layout, UTC, &record, &toml(layout))
    }

    #[test]
    fn no_session_is_laid_down_beside_one_whose_ids_differ_only_by_case() {
        let (_folder, layout) = folder_with_study();
        lay(&layout, "Q1", "Sa").unwrap();
        lay(&layout, "Q1_x", "Sa").unwrap();
        let before = std::fs::read_dir(layout.sessions()).unwrap().count();
        for (participant, session, words) in [
            ("q1", "Sb", "the participant 'q1' differs from 'Q1' only by case"),
            ("Q1_X", "Sb", "the participant 'Q1_X' differs from 'Q1_x' only by case"),
            ("Q1", "sA", "the session 'sA' differs from 'Sa' only by case"),
        ] {
            let error = lay(&layout, participant, session).unwrap_err();
            assert_eq!(error.what, words);
        }
        let after = std::fs::read_dir(layout.sessions()).unwrap().count();
        assert_eq!(after, before, "nothing was written");
        lay(&layout, "Q1", "Sb").unwrap();
        lay(&layout, "Q2", "sa").unwrap();
    }

    #[test]
    fn sessions_whose_ids_differ_only_by_case_are_findings_and_left_out() {
        let (_folder, layout) = folder_with_study();
        let count = || StudyData::load(&layout).unwrap().sessions.len();
        let before = count();
        lay(&layout, "Q1", "Sa").unwrap();
        lay(&layout, "Q2", "Sa").unwrap();
        // As another system would have made it.
        let other = Layout::new(layout.root().join("other").as_path(), layout.study().clone());
        std::fs::create_dir_all(other.raw()).unwrap();
        std::fs::copy(layout.study_toml(), other.study_toml()).unwrap();
        lay(&other, "q1", "Sb").unwrap();
        for entry in std::fs::read_dir(other.sessions()).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, layout.sessions().join(path.file_name().unwrap())).unwrap();
        }
        let findings = verify(&layout);
        assert_eq!(findings.len(), 2, "{findings:?}");
        let words = "only by case: its trials are left out";
        assert!(findings.iter().all(|f| f.what.contains(words)), "{findings:?}");
        assert_eq!(count(), before + 1, "Q2 counts as it did");
    }

    #[test]
    fn a_study_beside_one_of_the_same_letters_is_refused() {
        let (_folder, layout) = folder_with_study();
        check_study_id(&RealFiles, &layout).unwrap();
        let shout =
            Layout::new(layout.root(), layout.study().as_str().to_uppercase().parse().unwrap());
        let error = check_study_id(&RealFiles, &shout).unwrap_err();
        assert!(error.what.contains("only by case"), "{error}");
    }
}
