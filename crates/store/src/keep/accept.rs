//! A `study.toml` that was changed after sessions were set up: an event accepts it, session by
//! session.

use crate::judge::laid::{matters, study_warning};
use crate::judge::people::{PersonChanges, alone, read_people};
use crate::judge::sessions::read_sessions;
use crate::judge::study::read_study_from;
use crate::{Files, Layout, StoreError, commit_events};
use std::path::Path;
use zwidth_study::{Event, ParticipantId, SessionId, SessionRecord};

/// Accepts the present `study.toml`, and the group that the participants' file says now, for every session to which a
/// change of them matters or that began without a group, or for `only` one; returns what was accepted, in words. The caller
/// holds the study's lock.
///
/// # Errors
/// A `study.toml` or the requested session that cannot be read; a write that failed.
pub fn accept_study(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
    only: Option<(&ParticipantId, &SessionId)>,
) -> Result<Vec<String>, Vec<StoreError>> {
    let (study, hash) = read_study_from(files, layout)?;
    let mut problems = Vec::new();
    let (mut sessions, _) = read_sessions(files, layout, &mut problems);
    if let Some((participant, session)) = only {
        sessions
            .retain(|log| (&log.record.participant, &log.record.session) == (participant, session));
        if sessions.is_empty() {
            let path = layout.session(participant, session);
            let of_it = problems
                .into_iter()
                .find(|problem| problem.path.with_extension("") == path.with_extension(""));
            return Err(vec![of_it.unwrap_or_else(|| {
                StoreError::new(&path, "there is no such session", "see `zwidth list`")
            })]);
        }
    }
    // A session that the disk did not give may need it too. What is damaged, `verify` tells.
    problems.retain(|problem| problem.by_system);
    if !problems.is_empty() {
        return Err(problems);
    }
    let people = read_people(files, layout, &study)?;
    let people = people.with_drawn(&study.people, sessions.iter().map(|log| &log.record));
    let mut events: Vec<(&Path, Vec<Event>)> = Vec::new();
    let mut accepted = Vec::new();
    for log in &sessions {
        let SessionRecord { participant, session, .. } = &log.record;
        let mut own = Vec::new();
        if study_warning(layout, log, &study, &hash).is_some() {
            own.push(Event::StudyAccepted { study_blake3: hash.clone() });
            let changes = matters(log, &study, &hash).unwrap_or_default();
            accepted.push(format!(
                "{participant} {session}: the changed study.toml is accepted: {changes}"
            ));
        }
        let PersonChanges { group, filled_in, .. } = PersonChanges::of(log, &people, &study);
        for (what, group) in [("another group", group), ("the group", filled_in)] {
            if let Some(group) = group {
                let words = group.words;
                accepted.push(format!("{participant} {session}: {what} is accepted: {words}"));
                own.push(group.accepted);
            }
        }
        if !own.is_empty() {
            events.push((&log.events_path, own));
        }
    }
    let logs: Vec<(&Path, &[Event])> =
        events.iter().map(|(path, events)| (*path, events.as_slice())).collect();
    commit_events(files, layout, utc, &logs).map_err(|error| vec![error])?;
    Ok(accepted)
}

/// What a reader of a study should know although it is not a finding: changes of `study.toml` that
/// were accepted, and what the participants' file says otherwise of people than when they took part.
pub fn study_notes(files: &dyn Files, layout: &Layout) -> Vec<String> {
    let Ok((study, hash)) = read_study_from(files, layout) else { return Vec::new() };
    let (sessions, _) = read_sessions(files, layout, &mut Vec::new());
    let accepted = sessions.iter().filter(|log| log.studies().any(|accepted| accepted == hash));
    let notes = accepted.filter_map(|log| {
        let SessionRecord { participant, session, .. } = &log.record;
        let changes = matters(log, &study, &hash)?;
        Some(format!(
            "study.toml has changed since {participant} {session} began, and was accepted: {changes}"
        ))
    });
    let people = read_people(files, layout, &study).unwrap_or_default();
    let people = people.with_drawn(&study.people, sessions.iter().map(|log| &log.record));
    let of_people = sessions.iter().filter_map(|log| {
        let SessionRecord { participant, session, .. } = &log.record;
        let PersonChanges { rest, .. } = PersonChanges::of(log, &people, &study);
        let changes = rest.join("; ");
        (!rest.is_empty()).then(|| {
            format!(
                "the participants' file has changed since {participant} {session} began: {changes}"
            )
        })
    });
    notes.chain(of_people).chain(alone(&study, &people)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{UTC, folder_with_study, meta, toml};
    use crate::{RealFiles, read_events, verify};
    use std::fs;

    /// Changes `study.toml` of the small study.
    fn change(layout: &Layout, from: &str, to: &str) {
        let text = String::from_utf8(toml(layout)).unwrap();
        assert!(text.contains(from), "{text}");
        fs::write(layout.study_toml(), text.replacen(from, to, 1)).unwrap();
    }

    #[test]
    fn an_event_accepts_a_changed_study_and_the_warning_is_a_note_from_then_on() {
        let (_folder, layout) = folder_with_study();
        change(&layout, "pause_s = 5.0", "pause_s = 4.0");
        let [finding] = verify(&layout).try_into().unwrap();
        let command = "`zwidth recover demo --accept-study-change -p P01 -s S01`";
        assert!(finding.remedy.contains(command), "{finding}");
        assert!(finding.remedy.contains("P01_S01.study.toml"), "{finding}");
        assert_eq!(study_notes(&RealFiles, &layout), Vec::<String>::new());
        let (participant, session) = (meta(1).participant, meta(1).session);
        let accept = |only| accept_study(&RealFiles, &layout, UTC, only).unwrap();
        let words =
            "P01 S01: the changed study.toml is accepted: design.pause_s was 5.0 and is 4.0";
        assert_eq!(accept(Some((&participant, &session))), [words]);
        assert_eq!(verify(&layout), []);
        let [note] = study_notes(&RealFiles, &layout).try_into().unwrap();
        assert!(note.contains("P01 S01"), "{note}");
        assert!(note.contains("design.pause_s was 5.0 and is 4.0"), "{note}");
        // Accepted once; another change asks again.
        assert_eq!(accept(None), Vec::<String>::new());
        change(&layout, "pause_s = 5.0", "pause_s = 3.0");
        assert_eq!((verify(&layout).len(), accept(None).len(), verify(&layout).len()), (1, 1, 0));
        let events = read_events(&layout.events(&participant, &session)).unwrap();
        assert_eq!(events.iter().filter(|e| matches!(e, Event::StudyAccepted { .. })).count(), 2);
    }

    #[test]
    fn a_change_that_affects_nothing_needs_no_event_and_an_unknown_session_gets_none() {
        let (_folder, layout) = folder_with_study();
        change(&layout, "label = \"Active\"", "label = \"Motor\"");
        assert_eq!((verify(&layout), study_notes(&RealFiles, &layout)), (vec![], vec![]));
        assert_eq!(accept_study(&RealFiles, &layout, UTC, None), Ok(vec![]));
        let (participant, session) = ("P09".parse().unwrap(), meta(1).session);
        let [error] = accept_study(&RealFiles, &layout, UTC, Some((&participant, &session)))
            .unwrap_err()
            .try_into()
            .unwrap();
        assert!(error.to_string().contains("no such session"), "{error}");
        fs::write(layout.session(&meta(1).participant, &session), "{").unwrap();
        let [error] =
            accept_study(&RealFiles, &layout, UTC, Some((&meta(1).participant, &session)))
                .unwrap_err()
                .try_into()
                .unwrap();
        assert!(error.to_string().contains("not a session record"), "{error}");
    }
}
