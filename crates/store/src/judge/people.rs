//! The participants' file of a study: what is known of its people.

use crate::disk::regular::text;
use crate::form::entry::MOST_STUDY;
use crate::{Files, Layout, SessionLog, StoreError};
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_study::{
    Event, ParticipantId, People, PeopleForm, Person, PersonValue, SessionRecord, Study, counted,
};

/// The participants' files that there are: one, unless somebody has to choose.
fn there(files: &dyn Files, layout: &Layout) -> Vec<(PeopleForm, PathBuf)> {
    let forms = [PeopleForm::Toml, PeopleForm::Csv].into_iter();
    forms
        .map(|form| (form, layout.people(form)))
        .filter(|(_, path)| files.kind(path).is_some())
        .collect()
}

/// The rows of the participants' file; none without one, and none of a study that names no column of people.
///
/// # Errors
/// Two such files; one that cannot be read; one error per wrong cell.
pub fn read_people(
    files: &dyn Files,
    layout: &Layout,
    study: &Study,
) -> Result<People, Vec<StoreError>> {
    let found = there(files, layout);
    let (form, path) = match found.as_slice() {
        _ if study.people.is_empty() => return Ok(People::default()),
        [] => return Ok(People::default()),
        [(form, path)] => (*form, path),
        [_, (_, second), ..] => {
            let what = "there is participants.toml too, and nothing says which of them counts";
            return Err(vec![StoreError::new(second, what, "move one of them elsewhere")]);
        }
    };
    let text = text(files, path, MOST_STUDY).map_err(|e| vec![e])?;
    People::read(&text, form, &study.people).map_err(|errors| {
        let remedy = "columns are those that [[people]] of study.toml names";
        errors.iter().map(|e| StoreError::new(path, e.to_string(), remedy)).collect()
    })
}

/// What of the participants' file, and of those who took part, no comparison has in it.
pub(crate) fn people_findings(
    files: &dyn Files,
    layout: &Layout,
    study: &Study,
    people: &People,
    took_part: &BTreeSet<&ParticipantId>,
) -> Vec<StoreError> {
    let file = there(files, layout).into_iter().next().map(|(_, path)| path);
    if study.people.is_empty() {
        let what = "study.toml names no column of it, so nothing reads it";
        let finding = |path| StoreError::new(path, what, "name its columns there: [[people]]");
        return file.as_deref().map(finding).into_iter().collect();
    }
    let Some(groups) = &study.compare.groups else { return Vec::new() };
    let has_none = |who: &&&ParticipantId| people.level(who, &groups.column).is_none();
    let without: Vec<&str> = took_part.iter().filter(has_none).map(|who| who.as_str()).collect();
    let Some(first) = without.first() else { return Vec::new() };
    let what = match without.len() {
        1 => format!("{first} has no {}: no comparison of groups has their trials", groups.column),
        n => format!(
            "{} have no {}, the first is {first}: no comparison of groups has their trials",
            counted(n, "participants"),
            groups.column
        ),
    };
    let file = file.unwrap_or_else(|| layout.people(PeopleForm::Toml));
    vec![StoreError::new(&file, what, "write it there")]
}

/// What is known of a person now and was not when a session of theirs began.
#[derive(Debug, Default)]
pub struct PersonChanges {
    /// Another group, where groups are compared and nobody accepted it.
    pub group: Option<ChangedGroup>,
    /// A group where none was known when the session began, and its log has none yet: from that event on another is another
    /// group.
    pub filled_in: Option<ChangedGroup>,
    /// What else changed, in words.
    pub rest: Vec<String>,
}

/// The group of a person where a session began with another, or with none.
#[derive(Debug)]
pub struct ChangedGroup {
    /// The event that accepts it.
    pub accepted: Event,
    /// What changed, in words.
    pub words: String,
}

impl PersonChanges {
    /// Those since a session began. What was not known then and stands there by now is noted, not another group; a group is
    /// compared with the one that the log says was filled in. A session looked up the columns that its own copy of study.toml
    /// names; an imported one none.
    pub fn of(log: &SessionLog, people: &People, study: &Study) -> Self {
        let was = &log.record.person;
        let is = people.row(&log.record.participant);
        let own = log.study.as_ref().filter(|_| !log.record.source.is_imported());
        let looked_up = own.map_or(&[][..], |own| &own.people);
        let mut changes = Self::default();
        for column in &study.people {
            if !looked_up.iter().any(|own| own.id == column.id) {
                continue;
            }
            let [began, is] = [was.get(&column.id), is.and_then(|row| row.get(&column.id))];
            let filled_in = log.events.iter().find_map(|event| match event {
                Event::PersonAccepted { column: own, level: Some(level) } if *own == column.id => {
                    Some(PersonValue::Level(level.clone()))
                }
                _ => None,
            });
            let was = began.or(filled_in.as_ref());
            if began == is && was == is {
                continue;
            }
            // What was filled in and stayed is still said to be new.
            let [before, now] = [if was == is { began } else { was }, is]
                .map(|value| value.map_or_else(|| "not known".to_owned(), ToString::to_string));
            let words = format!("{} was {before} and is {now}", column.id);
            let is_compared =
                study.compare.groups.as_ref().is_some_and(|own| own.column == column.id);
            let level = match is {
                Some(PersonValue::Level(level)) => Some(level.clone()),
                _ => None,
            };
            let event = Event::PersonAccepted { column: column.id.clone(), level };
            let is_accepted = log.events.contains(&event);
            match was {
                Some(_) if is_compared && was != is && !is_accepted => {
                    changes.group = Some(ChangedGroup { accepted: event, words });
                }
                None if is_compared => {
                    changes.filled_in =
                        Some(ChangedGroup { accepted: event, words: words.clone() });
                    changes.rest.push(words);
                }
                _ => changes.rest.push(words),
            }
        }
        changes
    }
}

/// Who is the only one of whom that is known which is, as a note: somebody who knows them could find them by it.
pub(crate) fn alone(study: &Study, people: &People) -> Option<String> {
    let rows: Vec<(&ParticipantId, &Person)> =
        people.iter().filter(|(_, row)| !row.is_empty()).collect();
    let is_alone = |row: &&Person| rows.iter().filter(|(_, other)| other == row).count() == 1;
    let alone: Vec<&ParticipantId> =
        rows.iter().filter(|(_, row)| is_alone(row)).map(|(who, _)| *who).collect();
    let first = alone.first()?;
    let columns: Vec<&str> = study.people.iter().map(|column| column.id.as_str()).collect();
    let who = match alone.len() {
        1 => format!("{first} is the only one"),
        n => format!(
            "{n} of {}, the first is {first}, are the only ones",
            counted(rows.len(), "participants")
        ),
    };
    Some(format!(
        "{who} of whom just this is known ({}), here and in sessions/: somebody who knows them could find them by it",
        columns.join(", ")
    ))
}

/// The warning that somebody is compared in another group than they were in when a session began.
pub(crate) fn group_warning(
    layout: &Layout,
    log: &SessionLog,
    people: &People,
    study: &Study,
) -> Option<StoreError> {
    let ChangedGroup { words, .. } = PersonChanges::of(log, people, study).group?;
    let SessionRecord { participant, session, .. } = &log.record;
    let what = format!("{words}, by the participants' file, since {participant} {session} began");
    let accept = format!(
        "zwidth recover {} --accept-study-change -p {participant} -s {session}",
        layout.study()
    );
    let remedy = format!(
        "correct the file, or accept it with `{accept}`; a group that changes from session to session is a mode, no group"
    );
    Some(StoreError::new(&log.path, what, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{StudyData, verify};
    use std::fs;
    use zwidth_study::template;

    fn study(compare: &str) -> (tempfile::TempDir, Layout) {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "demo".parse().unwrap());
        fs::create_dir_all(layout.raw()).unwrap();
        let people = "[[people]]\nid = \"group\"\nlevels = [\"a\", \"b\"]\n";
        let text = format!("{}\n{compare}\n{people}", template(layout.study()));
        fs::write(layout.study_toml(), text).unwrap();
        (folder, layout)
    }

    #[test]
    fn a_study_has_the_people_of_its_file_and_none_without_one() {
        let (_folder, layout) = study("");
        assert_eq!(StudyData::load(&layout).unwrap().people, People::default());
        fs::write(layout.people(PeopleForm::Csv), "participant,group\nP01,b\n").unwrap();
        let data = StudyData::load(&layout).unwrap();
        let level = data.people.level(&"P01".parse().unwrap(), &"group".parse().unwrap());
        assert_eq!(level.unwrap().as_str(), "b");
        assert_eq!(verify(&layout), []);
    }

    #[test]
    fn a_wrong_file_and_two_of_them_are_refused_with_path_and_line() {
        let (_folder, layout) = study("");
        fs::write(layout.people(PeopleForm::Toml), "[P01]\ngroup = \"c\"\n").unwrap();
        let [error] = StudyData::load(&layout).unwrap_err().try_into().unwrap();
        assert_eq!(error.path, layout.people(PeopleForm::Toml));
        assert!(error.what.starts_with("line 2: P01.group: 'c' is no level"), "{error}");
        fs::write(layout.people(PeopleForm::Csv), "participant,group\n").unwrap();
        let [error] = StudyData::load(&layout).unwrap_err().try_into().unwrap();
        assert!(error.what.contains("there is participants.toml too"), "{error}");
    }

    #[test]
    fn who_is_alone_in_what_is_said_of_them_is_noted() {
        let (_folder, layout) = study("");
        let said = |rows: &str| {
            let text = format!("participant,group\n{rows}");
            fs::write(layout.people(PeopleForm::Csv), text).unwrap();
            crate::study_notes(&crate::RealFiles, &layout)
        };
        assert_eq!(said("P01,a\nP02,a\nP03,b\nP04,b\n"), Vec::<String>::new());
        assert_eq!(said("P01,a\nP02,a\nP03,\n"), Vec::<String>::new(), "nothing is said of P03");
        let [note] = said("P01,a\nP02,a\nP03,b\n").try_into().unwrap();
        assert!(
            note.starts_with("P03 is the only one of whom just this is known (group)"),
            "{note}"
        );
        let [note] = said("P01,a\nP03,b\n").try_into().unwrap();
        assert!(note.starts_with("2 of 2 participants, the first is P01, are"), "{note}");
    }

    #[test]
    fn a_file_whose_columns_no_study_names_is_told_and_not_read() {
        let (_folder, layout) = study("");
        let text = template(layout.study());
        fs::write(layout.study_toml(), text).unwrap();
        fs::write(layout.people(PeopleForm::Csv), "anything at all").unwrap();
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.what.contains("names no column of it"), "{finding}");
        assert_eq!(StudyData::load(&layout).unwrap().people, People::default());
    }
}
