//! The participants' file of a study: what is known of its people.

use crate::disk::regular::text;
use crate::form::entry::MOST_STUDY;
use crate::{Files, Layout, StoreError};
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_study::{ParticipantId, People, PeopleForm, Study, counted};

/// The participants' files that there are: one, unless somebody has to choose.
fn there(files: &dyn Files, layout: &Layout) -> Vec<(PeopleForm, PathBuf)> {
    let forms = [PeopleForm::Toml, PeopleForm::Csv].into_iter();
    forms
        .map(|form| (form, layout.people(form)))
        .filter(|(_, path)| files.kind(path).is_some())
        .collect()
}

/// The rows of the participants' file; none without one, and none of a study that names no column of people.
pub(crate) fn read_people(
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
