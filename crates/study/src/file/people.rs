//! `[[people]]` of a `study.toml`, and the participants' file that has these columns.

use super::check::Check;
use crate::people::{Known, People, PeopleForm, Person, PersonColumn, PersonValue};
use crate::{
    GroupContrast, GroupsCompared, LevelId, OverTrials, ParticipantId, PersonColumnId, StudyError,
    locate,
};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// No participants' file has more columns.
const MOST_COLUMNS: usize = 16;
/// A column has two levels at least: one is no difference; and no more than so many.
const LEVELS: std::ops::RangeInclusive<usize> = 2..=12;
/// The first column of a participants' file in CSV.
const PARTICIPANT: &str = "participant";
/// Words that name people, or lead to them.
const PERSONAL: [&str; 11] = [
    "name",
    "names",
    "surname",
    "firstname",
    "lastname",
    "email",
    "mail",
    "phone",
    "address",
    "initials",
    "dob",
];

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PersonColumnTable {
    pub(super) id: PersonColumnId,
    levels: Option<Vec<LevelId>>,
    unit: Option<String>,
    assigned: Option<bool>,
}

impl PersonColumnTable {
    pub(super) fn of(column: &PersonColumn) -> Self {
        let id = column.id.clone();
        match &column.known {
            Known::Level { levels, assigned } => Self {
                id,
                levels: Some(levels.clone()),
                unit: None,
                assigned: assigned.then_some(true),
            },
            Known::Number { unit } => {
                Self { id, levels: None, unit: Some(unit.clone()), assigned: None }
            }
        }
    }
}

impl Check<'_> {
    /// The columns of the participants' file.
    pub(super) fn people(&mut self, tables: Vec<PersonColumnTable>) -> Vec<PersonColumn> {
        self.unique("people", tables.iter().map(|table| table.id.as_str()));
        if tables.len() > MOST_COLUMNS {
            let n = tables.len();
            let problem = format!("the list has {n} entries; at most {MOST_COLUMNS} are allowed");
            self.error("people", problem);
        }
        let columns = tables.into_iter().enumerate();
        columns.map(|(i, table)| self.person_column(&format!("people[{i}]"), table)).collect()
    }

    fn person_column(&mut self, key: &str, table: PersonColumnTable) -> PersonColumn {
        let id = table.id;
        if is_personal(id.as_str()) {
            self.error(&format!("{key}.id"), personal(id.as_str()));
        }
        let known = match (table.levels, table.unit) {
            (Some(levels), None) => {
                self.levels(&format!("{key}.levels"), &levels);
                Known::Level { levels, assigned: table.assigned.unwrap_or(false) }
            }
            (None, Some(unit)) => {
                self.line(&format!("{key}.unit"), &unit);
                if unit.trim().is_empty() {
                    let problem = "is empty; a unit of a pure number is \"1\"";
                    self.error(&format!("{key}.unit"), problem);
                }
                if table.assigned.is_some() {
                    let problem = "is not used for a number; leave it out";
                    self.error(&format!("{key}.assigned"), problem);
                }
                Known::Number { unit }
            }
            (levels, _) => {
                let which = if levels.is_some() {
                    "levels and a unit"
                } else {
                    "neither levels nor a unit"
                };
                let problem = format!(
                    "has {which}; give levels = [\"novice\", \"expert\"], or the unit of a number"
                );
                self.error(key, problem);
                Known::Number { unit: String::new() }
            }
        };
        PersonColumn { id, known }
    }

    pub(super) fn levels(&mut self, key: &str, levels: &[LevelId]) {
        let n = levels.len();
        if !LEVELS.contains(&n) {
            let [least, most] = [LEVELS.start(), LEVELS.end()];
            self.error(key, format!("the list has {n} levels; {least} to {most} are allowed"));
        }
        let mut seen = BTreeSet::new();
        for (i, level) in levels.iter().enumerate() {
            // One spelled in two ways is nearly always one.
            if !seen.insert(level.as_str().to_ascii_lowercase()) {
                let problem =
                    format!("'{level}' stands twice; levels must differ, and by more than case");
                self.error(&format!("{key}[{i}]"), problem);
            }
        }
    }

    /// `compare.groups` and `compare.group_contrasts`.
    pub(super) fn groups(
        &mut self,
        column: Option<PersonColumnId>,
        pairs: Option<Vec<[LevelId; 2]>>,
        people: &[PersonColumn],
    ) -> Option<GroupsCompared> {
        let Some(column) = column else {
            if pairs.is_some() {
                let problem = "is not used without compare.groups, the column of people; add it";
                self.error("compare.group_contrasts", problem);
            }
            return None;
        };
        let found = people.iter().find(|own| own.id == column);
        let Some(Known::Level { levels, assigned }) = found.map(|own| &own.known) else {
            let problem = match found {
                Some(_) => format!("'{column}' is a number: name it in compare.covariates"),
                None => format!("[[people]] has no column '{column}'; add it with its levels"),
            };
            self.error("compare.groups", problem);
            return None;
        };
        let contrasts = match pairs {
            Some(pairs) => {
                if pairs.is_empty() {
                    let problem =
                        "the list is empty; leave it out for each later group against the first";
                    self.error("compare.group_contrasts", problem);
                }
                self.pairs("compare.group_contrasts", "group", &pairs, levels);
                pairs.into_iter().map(|[group, against]| GroupContrast { group, against }).collect()
            }
            None => default_contrasts(levels),
        };
        Some(GroupsCompared { column, levels: levels.clone(), assigned: *assigned, contrasts })
    }

    /// `compare.covariates`: what of trials everybody's line is over, and numbers of people.
    pub(super) fn covariates(
        &mut self,
        covariates: Vec<String>,
        people: &[PersonColumn],
    ) -> (Option<OverTrials>, Vec<PersonColumnId>) {
        let mut over = None;
        let mut of_people = Vec::new();
        for (i, id) in covariates.iter().enumerate() {
            let column = people.iter().find(|column| column.id.as_str() == id);
            let of_trials = OverTrials::from_word(id).filter(|_| column.is_none());
            if of_trials.is_some() && over.is_none() {
                over = of_trials;
                continue;
            }
            let problem = match column.map(|column| &column.known) {
                None if of_trials.is_some() => {
                    "a line is over 'trial' or over 'repeat', which is named once; leave one out"
                        .to_owned()
                }
                None => format!(
                    "[[people]] has no column '{id}'; add it with its unit, or name 'trial' or 'repeat'"
                ),
                Some(Known::Level { .. }) => {
                    format!("'{id}' has levels: name it in compare.groups")
                }
                Some(Known::Number { .. }) if covariates[..i].contains(id) => {
                    format!("'{id}' stands twice; leave one out")
                }
                Some(Known::Number { .. }) => {
                    of_people.extend(column.map(|column| column.id.clone()));
                    continue;
                }
            };
            self.error(&format!("compare.covariates[{i}]"), problem);
        }
        (over, of_people)
    }
}

/// Each later level against the first one.
fn default_contrasts(levels: &[LevelId]) -> Vec<GroupContrast> {
    let Some((first, later)) = levels.split_first() else { return Vec::new() };
    let pairs = later.iter().map(|group| (group.clone(), first.clone()));
    pairs.map(|(group, against)| GroupContrast { group, against }).collect()
}

/// The pairs of groups that are not the default ones, as the file has them.
pub(super) fn chosen_contrasts(groups: &GroupsCompared) -> Option<Vec<[LevelId; 2]>> {
    let contrasts = &groups.contrasts;
    (*contrasts != default_contrasts(&groups.levels))
        .then(|| contrasts.iter().map(|c| [c.group.clone(), c.against.clone()]).collect())
}

fn is_personal(column: &str) -> bool {
    let column = column.to_ascii_lowercase();
    let mut words = column.split(|c: char| !c.is_ascii_alphanumeric());
    words.any(|word| PERSONAL.contains(&word) || word.starts_with("birth"))
}

fn personal(column: &str) -> String {
    format!(
        "'{column}' tells who somebody is: people are known by their codes alone; leave the column out, \
         or keep it in a list outside the study"
    )
}

impl People {
    /// Reads a participants' file. Every problem found is in the error, each with its line.
    ///
    /// # Errors
    /// A text that is not of this form; a column or a level that `columns` does not have; a text for a
    /// number, or a number that is none; a participant who stands twice.
    pub fn read(
        text: &str,
        form: PeopleForm,
        columns: &[PersonColumn],
    ) -> Result<Self, Vec<StudyError>> {
        // Some editors put a byte-order mark first.
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        match form {
            PeopleForm::Toml => from_toml(text, columns),
            PeopleForm::Csv => from_csv(text, columns),
        }
    }
}

fn from_toml(text: &str, columns: &[PersonColumn]) -> Result<People, Vec<StudyError>> {
    let tables: BTreeMap<ParticipantId, BTreeMap<String, toml::Value>> =
        toml::from_str(text).map_err(|e| vec![locate::toml_error(text, &e)])?;
    let mut check = Check::new(text);
    let mut people = BTreeMap::new();
    for (who, table) in tables {
        let mut person = Person::new();
        for (id, value) in table {
            let value = match value {
                toml::Value::String(text) => Ok(Cell::Text(text)),
                toml::Value::Integer(number) => Ok(Cell::Number(number as f64)),
                toml::Value::Float(number) => Ok(Cell::Number(number)),
                other => Err(format!("{} is neither a text nor a number", other.type_str())),
            };
            match value.and_then(|value| of_column(&id, value, columns)) {
                Ok((id, value)) => _ = person.insert(id, value),
                Err(problem) => check.error(&format!("{who}.{id}"), problem),
            }
        }
        people.insert(who, person);
    }
    if check.errors.is_empty() { Ok(People(people)) } else { Err(check.errors) }
}

impl People {
    /// What a text is in a column of that name.
    ///
    /// # Errors
    /// No such column, no such level, no number.
    pub fn value(
        id: &PersonColumnId,
        text: &str,
        columns: &[PersonColumn],
    ) -> Result<PersonValue, String> {
        let column = columns.iter().find(|column| column.id == *id);
        of_column(id.as_str(), cell_of(text, column), columns).map(|(_, value)| value)
    }
}

/// What a text is: a number where numbers stand.
fn cell_of(text: &str, column: Option<&PersonColumn>) -> Cell {
    match (column.map(|column| &column.known), text.parse()) {
        (Some(Known::Number { .. }), Ok(number)) => Cell::Number(number),
        _ => Cell::Text(text.to_owned()),
    }
}

fn from_csv(text: &str, columns: &[PersonColumn]) -> Result<People, Vec<StudyError>> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let unreadable = |error: csv::Error| {
        let line = error.position().map_or(1, |position| position.line() as usize);
        vec![StudyError { line, key: "(file)".to_owned(), problem: error.to_string() }]
    };
    let header = reader.headers().map_err(unreadable)?.clone();
    let mut errors = Vec::new();
    let mut refuse = |line: usize, key: &str, problem: String| {
        errors.push(StudyError { line, key: key.to_owned(), problem });
    };
    if header.get(0) != Some(PARTICIPANT) {
        let first = header.get(0).filter(|name| !name.is_empty()).unwrap_or("(file)");
        let problem = format!(
            "the first column is called {PARTICIPANT}, and columns are separated by commas"
        );
        refuse(1, first, problem);
    }
    for (i, id) in header.iter().enumerate().skip(1) {
        if header.iter().take(i).any(|before| before == id) {
            refuse(1, id, "stands twice; leave one of the columns out".to_owned());
        } else if !columns.iter().any(|column| column.id.as_str() == id) {
            refuse(1, id, no_column(id));
        }
    }
    let mut people = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let line = record.position().map_or(1, |position| position.line() as usize);
        let who = match record.get(0).unwrap_or_default().parse::<ParticipantId>() {
            Ok(who) => who,
            Err(error) => {
                refuse(line, PARTICIPANT, error.to_string());
                continue;
            }
        };
        let mut person = Person::new();
        for (id, text) in header.iter().zip(&record).skip(1).filter(|(_, text)| !text.is_empty()) {
            // What has no column is refused once, above.
            let Some(column) = columns.iter().find(|column| column.id.as_str() == id) else {
                continue;
            };
            match of_column(id, cell_of(text, Some(column)), columns) {
                Ok((id, value)) => _ = person.insert(id, value),
                Err(problem) => refuse(line, id, problem),
            }
        }
        if people.insert(who.clone(), person).is_some() {
            refuse(line, PARTICIPANT, format!("'{who}' stands twice; leave one of the lines out"));
        }
    }
    if errors.is_empty() { Ok(People(people)) } else { Err(errors) }
}

/// What a cell holds.
enum Cell {
    Text(String),
    Number(f64),
}

fn no_column(id: &str) -> String {
    if is_personal(id) {
        return personal(id);
    }
    format!("[[people]] of study.toml has no column '{id}'; add it there, with levels or a unit")
}

/// A value of a column of that name.
fn of_column(
    id: &str,
    cell: Cell,
    columns: &[PersonColumn],
) -> Result<(PersonColumnId, PersonValue), String> {
    let column = columns.iter().find(|column| column.id.as_str() == id);
    let column = column.ok_or_else(|| no_column(id))?;
    let value = match (&column.known, cell) {
        (Known::Level { levels, .. }, Cell::Text(text)) => {
            let level = levels.iter().find(|level| level.as_str() == text).ok_or_else(|| {
                let levels: Vec<&str> = levels.iter().map(LevelId::as_str).collect();
                format!("'{text}' is no level of it; there are {}", levels.join(", "))
            })?;
            PersonValue::Level(level.clone())
        }
        (Known::Level { .. }, Cell::Number(number)) => {
            return Err(format!(
                "{number} is a number, and the column has levels; write one of them"
            ));
        }
        (Known::Number { unit }, Cell::Text(text)) => {
            return Err(format!("'{text}' is not a number; give one in {unit}, or leave it out"));
        }
        (Known::Number { unit }, Cell::Number(number)) if !number.is_finite() => {
            return Err(format!("{number} is not a number; give one in {unit}, or leave it out"));
        }
        (Known::Number { .. }, Cell::Number(number))
            if id == People::AGE && number.fract() != 0.0 =>
        {
            return Err(format!("{number} has decimals, which tell a birthday; give whole years"));
        }
        (Known::Number { .. }, Cell::Number(number)) => PersonValue::Number(number),
    };
    Ok((column.id.clone(), value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Study;
    use crate::tests::{check_refused, check_round_trip, text, with};

    const COLUMNS: &str = "[[people]]\nid = \"group\"\nlevels = [\"novice\", \"expert\"]\nassigned = true\n\
        [[people]]\nid = \"age_years\"\nunit = \"years\"\n";

    fn study(compare: &str) -> Result<Study, Vec<StudyError>> {
        with("[compare]", &format!("{compare}\n{COLUMNS}"))
    }

    fn read(text: &str, form: PeopleForm) -> Result<People, Vec<StudyError>> {
        People::read(text, form, &study("").unwrap().people)
    }

    #[test]
    fn a_study_names_columns_of_people_and_groups_that_it_compares() {
        let study = study("groups = \"group\"\ncovariates = [\"age_years\"]").unwrap();
        let groups = study.compare.groups.as_ref().unwrap();
        assert_eq!(groups.contrasts[0].to_string(), "expert − novice");
        assert_eq!(groups.contrasts[0].to_string().parse(), Ok(groups.contrasts[0].clone()));
        assert!(groups.assigned && groups.levels.len() == 2);
        check_round_trip(&study);
        let turned = "groups = \"group\"\ngroup_contrasts = [[\"novice\", \"expert\"]]";
        let turned = super::tests::study(turned).unwrap();
        assert_eq!(turned.compare.groups.as_ref().unwrap().contrasts[0].group.as_str(), "novice");
        check_round_trip(&turned);
    }

    #[test]
    fn a_line_over_trials_stands_among_the_covariates() {
        let study = study("groups = \"group\"\ncovariates = [\"age_years\", \"trial\"]").unwrap();
        assert_eq!(study.compare.over, Some(OverTrials::Trial));
        assert_eq!(study.compare.covariates.len(), 1);
        check_round_trip(&study);
    }

    #[test]
    fn columns_and_groups_that_cannot_be_meant_are_one_error_each() {
        for (compare, key, words) in [
            ("groups = \"crew\"", "compare.groups", "no column 'crew'"),
            ("groups = \"age_years\"", "compare.groups", "compare.covariates"),
            (
                "group_contrasts = [[\"a\", \"b\"]]",
                "compare.group_contrasts",
                "without compare.groups",
            ),
            (
                "groups = \"group\"\ngroup_contrasts = [[\"expert\", \"novic\"]]",
                "compare.group_contrasts[0]",
                "no group 'novic'; there are novice, expert",
            ),
            ("groups = \"group\"\ngroup_contrasts = []", "compare.group_contrasts", "is empty"),
            ("covariates = [\"group\"]", "compare.covariates[0]", "compare.groups"),
            ("covariates = [\"age\"]", "compare.covariates[0]", "no column 'age'"),
            ("covariates = [\"trial\", \"repeat\"]", "compare.covariates[1]", "named once"),
            (
                "covariates = [\"age_years\", \"age_years\"]",
                "compare.covariates[1]",
                "stands twice",
            ),
        ] {
            check_refused(study(compare), key, words);
        }
        for (column, key, words) in [
            ("id = \"last_name\"\nlevels = [\"a\", \"b\"]", "people[0].id", "who somebody is"),
            ("id = \"birth_date\"\nunit = \"s\"", "people[0].id", "who somebody is"),
            ("id = \"mode\"\nunit = \"s\"", "id", "a column of every trial file"),
            ("id = \"a\"", "people[0]", "neither levels nor a unit"),
            ("id = \"a\"\nlevels = [\"x\", \"y\"]\nunit = \"1\"", "people[0]", "levels and a unit"),
            ("id = \"a\"\nlevels = [\"x\"]", "people[0].levels", "has 1 levels; 2 to 12"),
            ("id = \"a\"\nlevels = [\"x\", \"X\"]", "people[0].levels[1]", "by more than case"),
            ("id = \"a\"\nunit = \" \"", "people[0].unit", "is empty"),
            ("id = \"a\"\nunit = \"1\"\nassigned = true", "people[0].assigned", "not used"),
        ] {
            check_refused(with("[[people]]", column), key, words);
        }
        let many: String =
            (0..17).map(|i| format!("[[people]]\nid = \"a{i}\"\nunit = \"1\"\n")).collect();
        check_refused(Study::from_toml(&(text() + &many)), "people", "at most 16");
    }

    #[test]
    fn both_forms_of_the_file_say_the_same_and_an_empty_cell_is_nothing() {
        let toml = "[P01]\ngroup = \"expert\"\nage_years = 27\n[P02]\nage_years = 31.0\n[P03]\n";
        let csv = "participant, group,age_years\nP01,expert,27\nP02,,31\nP03,,\n";
        let [toml, csv] = [(toml, PeopleForm::Toml), (csv, PeopleForm::Csv)]
            .map(|(text, form)| read(text, form).unwrap());
        assert_eq!(toml, csv);
        let [who, second] = ["P01", "P02"].map(|who| who.parse().unwrap());
        let [group, age] = ["group", "age_years"].map(|id| id.parse().unwrap());
        assert_eq!(toml.level(&who, &group).map(LevelId::as_str), Some("expert"));
        assert_eq!(toml.number(&second, &age), Some(31.0));
        assert_eq!((toml.level(&second, &group), toml.number(&who, &group)), (None, None));
        assert_eq!(toml.iter().count(), 3);
    }

    #[test]
    fn what_cannot_be_a_row_is_refused_with_its_line() {
        for (text, line, words) in [
            ("[P01]\ncrew = \"expert\"", 2, "no column 'crew'"),
            (
                "[P01]\ngroup = \"Expert\"",
                2,
                "'Expert' is no level of it; there are novice, expert",
            ),
            ("[P01]\ngroup = 1", 2, "1 is a number"),
            ("[P01]\n\nage_years = nan", 3, "NaN is not a number"),
            ("[P01]\nage_years = \"old\"", 2, "'old' is not a number; give one in years"),
            ("[P01]\nage_years = 27.4", 2, "whole years"),
            ("[P01]\nage_years = true", 2, "neither a text nor a number"),
            ("[P01]\nsurname = \"x\"", 2, "who somebody is"),
            ("[P01]\n[P01]", 2, "duplicate key"),
            ("[\"P 01\"]", 1, "not a valid participant id"),
            ("group = \"expert\"", 1, "invalid type"),
        ] {
            let errors = read(text, PeopleForm::Toml).unwrap_err();
            let found = &errors[0];
            assert!(errors.len() == 1 && found.line == line, "{text}: {errors:?}");
            assert!(found.problem.contains(words), "{found}");
        }
        for (text, line, words) in [
            ("participant,group\nP01,expert\nP01,novice\n", 3, "'P01' stands twice"),
            ("participant,group\nP01,beginner\n", 2, "'beginner' is no level"),
            ("participant,age_years\nP01,inf\n", 2, "inf is not a number"),
            ("participant,age_years\nP01,NaN\n", 2, "NaN is not a number"),
            ("participant,age_years\nP01,old\n", 2, "'old' is not a number"),
            ("participant,e-mail\nP01,x\n", 1, "who somebody is"),
            ("participant,group,group\nP01,expert,expert\n", 1, "stands twice"),
            ("who,group\nP01,expert\n", 1, "the first column is called participant"),
            ("participant;group\nP01;expert\n", 1, "separated by commas"),
            ("", 1, "the first column is called participant"),
            ("participant,group\nP01\n", 2, "found record with 1 fields"),
            ("participant,group\nP 1,expert\n", 2, "not a valid participant id"),
        ] {
            let errors = read(text, PeopleForm::Csv).unwrap_err();
            assert!(errors[0].line == line, "{text}: {errors:?}");
            assert!(errors[0].problem.contains(words), "{}", errors[0]);
        }
    }
}
