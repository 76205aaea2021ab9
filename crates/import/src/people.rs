//! A table with a row for each participant → rows of the participants' file.

use super::context::Context;
use super::errors::{Errors, all};
use super::identity::id;
use super::limits::Budget;
use super::mapping::PeopleFrom;
use super::recording::Recording;
use super::report::{FileReport, Report};
use super::unit::{self, Unit};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use zwidth_store::{MOST_STUDY, StoreError, read_people, replace};
use zwidth_study::{Known, ParticipantId, People, PeopleForm, Person, PersonColumnId, PersonValue};

/// Adds the people of tables to the participants' file: all of them, or none. Who is there with the same row stays
/// as they are.
///
/// # Errors
/// Everything found wrong with the tables; somebody who is there already, and otherwise.
pub(super) fn import(
    context: &Context,
    form: &PeopleFrom,
    files: &[PathBuf],
) -> Result<Report, Errors> {
    let layout = context.layout;
    let existing = read_people(context.files, layout, context.study)
        .map_err(|errors| errors.into_iter().collect::<Errors>())?;
    let undeclared =
        form.columns.keys().find(|id| !context.study.people.iter().any(|own| own.id == **id));
    if let Some(id) = undeclared {
        let what = format!("[people.columns]: [[people]] of study.toml has no column '{id}'");
        return Err(StoreError::new(
            &context.mapping.path,
            what,
            "add it there, with levels or a unit",
        )
        .into());
    }
    let conversions = conversions(context, form)?;
    let budget = Budget::default();
    let take = context.take(form.columns().collect(), &budget);
    let tables =
        context.convert(files, &take, |recording| read(context, form, &conversions, recording))?;
    let mut new: BTreeMap<ParticipantId, Person> = BTreeMap::new();
    let mut reports = Vec::new();
    for table in tables {
        let (rows, mut report) = table.parsed;
        let (mut added, mut known) = (0, 0);
        for Row { row, who, person } in rows {
            let (earlier, which) = match new.get(&who) {
                Some(row) => (Some(row), "stands twice"),
                None => (existing.row(&who), "is in the participants' file already"),
            };
            match earlier {
                None => {
                    added += 1;
                    new.insert(who, person);
                }
                Some(earlier) if *earlier == person => known += 1,
                Some(earlier) => {
                    let what = format!(
                        "{who} {which}, and otherwise: {}; here {}",
                        in_words(earlier),
                        in_words(&person)
                    );
                    let error = StoreError::new(&table.path, what, "correct the one or the other");
                    return Err(error.row0(row).into());
                }
            }
        }
        report.made.push(format!("{added} participants"));
        if known > 0 {
            report.told.push(format!("{known} rows say what is known already"));
        }
        reports.push(report);
    }
    if !new.is_empty() {
        write(context, &new)?;
    }
    Ok(Report {
        study: layout.study().clone(),
        files: reports,
        trials: 0,
        sweeps: 0,
        sessions: 0,
        answers: 0,
        exclusions: 0,
        participants: new.len(),
        against_plan: Vec::new(),
    })
}

/// From the unit of a column to the study's.
struct Conversion {
    from: &'static Unit,
    to: &'static Unit,
    /// `age_years from months`.
    words: String,
}

/// The conversions of the columns in other units than the study's.
///
/// # Errors
/// A column of levels; a unit that is not known, in the mapping or in the study; one of another quantity.
fn conversions(
    context: &Context,
    form: &PeopleFrom,
) -> Result<BTreeMap<PersonColumnId, Conversion>, Errors> {
    let mut conversions = BTreeMap::new();
    for (id, text) in &form.units {
        let wrong = |what: String, remedy: String| {
            let what = format!("[people.units] {id}: {what}");
            Errors::from(StoreError::new(&context.mapping.path, what, &remedy))
        };
        let column = context.study.people.iter().find(|column| column.id == *id);
        let Some(Known::Number { unit: own }) = column.map(|column| &column.known) else {
            let what = "the column has levels, and no unit".to_owned();
            return Err(wrong(what, "leave it out".to_owned()));
        };
        if text.trim() == own.trim() {
            continue;
        }
        let Some(to) = unit::of_people(own) else {
            let what = format!(
                "'{text}' cannot become '{own}', the unit of [[people]] in study.toml, which is unknown"
            );
            let remedy =
                format!("convert the file, or use one of {} there", unit::choices_of_people(None));
            return Err(wrong(what, remedy));
        };
        let remedy = format!("use one of {}", unit::choices_of_people(Some(to.dimension)));
        let Some(from) = unit::of_people(text) else {
            return Err(wrong(format!("the unit '{text}' is unknown"), remedy));
        };
        if from.dimension != to.dimension {
            let what = format!(
                "the unit '{text}' cannot become '{own}', the unit of [[people]] in study.toml"
            );
            return Err(wrong(what, remedy));
        }
        conversions.insert(id.clone(), Conversion { from, to, words: format!("{id} from {text}") });
    }
    Ok(conversions)
}

/// A row of a table, from 0, and what it says.
struct Row {
    row: usize,
    who: ParticipantId,
    person: Person,
}

fn in_words(person: &Person) -> String {
    let each: Vec<String> = person.iter().map(|(id, value)| format!("{id} {value}")).collect();
    if each.is_empty() { "nothing is known".to_owned() } else { each.join(", ") }
}

fn read(
    context: &Context,
    form: &PeopleFrom,
    conversions: &BTreeMap<PersonColumnId, Conversion>,
    recording: &Recording,
) -> Result<(Vec<Row>, FileReport), Errors> {
    let used = all(form.columns().map(|column| recording.find(column)))?;
    let rows = recording.rows(&context.mapping.file, &[], &[])?;
    let cells = &context.mapping.file.cells;
    let people = all(rows.kept.iter().map(|row| {
        let who: ParticipantId = form.participant.value("participant", recording, *row, id)?;
        let mut person = Person::new();
        for (id, label) in &form.columns {
            let missing = match label.column() {
                Some(column) => cells.is_missing(&recording.cell(column, *row)?),
                None => false,
            };
            // A missing cell is not known, and no level.
            if missing || label.word(recording, *row)?.is_empty() {
                continue;
            }
            let value = label.value(id.as_str(), recording, *row, |text| {
                value(context, id, text, conversions.get(id))
            })?;
            person.insert(id.clone(), value);
        }
        Ok::<_, Errors>(Row { row: *row, who, person })
    }))?;
    let mut report = context.file_report(recording, &rows, people.len(), &used)?;
    report.converted.extend(conversions.values().map(|conversion| conversion.words.clone()));
    Ok((people, report))
}

/// A cell, as the participants' file would hold it.
fn value(
    context: &Context,
    id: &PersonColumnId,
    text: &str,
    conversion: Option<&Conversion>,
) -> Result<PersonValue, String> {
    let number: Option<f64> = text.parse().ok();
    let Some((Conversion { from, to, .. }, number)) = conversion.zip(number) else {
        return People::value(id, text, &context.study.people);
    };
    // Twelve digits: a factor of a unit leaves its rounding in the last ones.
    let converted = format!("{:.11e}", number * from.to_si / to.to_si);
    let converted: f64 = converted.parse().unwrap_or(f64::NAN);
    // Years that are completed.
    let converted = if id.as_str() == People::AGE { converted.floor() } else { converted };
    People::value(id, &converted.to_string(), &context.study.people)
}

/// Adds rows to the participants' file behind those that it has; without one it is made.
fn write(context: &Context, new: &BTreeMap<ParticipantId, Person>) -> Result<(), Errors> {
    let [toml, csv] = [PeopleForm::Toml, PeopleForm::Csv].map(|form| context.layout.people(form));
    let is_toml = context.files.kind(&toml).is_some();
    let path = if is_toml { toml } else { csv };
    let mut text = match context.files.kind(&path) {
        None => {
            let columns = context.study.people.iter().map(|column| column.id.as_str());
            let header: Vec<&str> = std::iter::once("participant").chain(columns).collect();
            header.join(",")
        }
        Some(_) => {
            let bytes = context.files.read(&path, MOST_STUDY);
            let bytes = bytes.map_err(|e| StoreError::io(&path, "read", &e))?;
            // It was read as text before.
            String::from_utf8_lossy(&bytes).into_owned()
        }
    };
    if !text.ends_with('\n') {
        text.push('\n');
    }
    if is_toml {
        for (who, person) in new {
            let _ = writeln!(text, "\n[{who}]");
            for (id, value) in person {
                let _ = match value {
                    PersonValue::Level(level) => writeln!(text, "{id} = \"{level}\""),
                    PersonValue::Number(number) => writeln!(text, "{id} = {number:?}"),
                };
            }
        }
    } else {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
        let header =
            reader.headers().map_err(|e| StoreError::new(&path, e.to_string(), "mend the file"))?;
        let columns: Vec<String> = header.iter().skip(1).map(str::to_owned).collect();
        let lacks = new
            .values()
            .flat_map(Person::keys)
            .find(|id| !columns.iter().any(|own| own == id.as_str()));
        if let Some(id) = lacks {
            let what = format!("it has no column '{id}', which the table has");
            return Err(StoreError::new(
                &path,
                what,
                "add it to its first line, and a comma to each other",
            )
            .into());
        }
        for (who, person) in new {
            let cell = |column: &String| {
                let value = person.iter().find(|(id, _)| id.as_str() == column);
                value.map(|(_, value)| value.to_string()).unwrap_or_default()
            };
            let cells: Vec<String> =
                std::iter::once(who.to_string()).chain(columns.iter().map(cell)).collect();
            let _ = writeln!(text, "{}", cells.join(","));
        }
    }
    // Before it takes the place of the file: what cannot be read again is not written.
    if text.len() as u64 > MOST_STUDY {
        let what =
            format!("with them it would be larger than {MOST_STUDY} bytes, and is not read then");
        return Err(StoreError::new(&path, what, "import fewer people").into());
    }
    let form = if is_toml { PeopleForm::Toml } else { PeopleForm::Csv };
    if let Err(errors) = People::read(&text, form, &context.study.people) {
        let what = errors.first().map_or_else(String::new, ToString::to_string);
        let remedy = "mend how the file ends, so that rows can follow";
        return Err(StoreError::new(&path, format!("with them: {what}"), remedy).into());
    }
    replace(context.files, &path, text.as_bytes())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use zwidth_store::StudyData;
    use zwidth_study::{PeopleForm, template};

    const MAP: &str = "kind = \"participants\"\n[file]\nmissing_words = [\"?\"]\n[people]\n\
        participant = { column = \"subject\", prefix = \"P\", digits = 2 }\n[people.columns]\n\
        crew = { column = \"grp\", translate = { beginner = \"novice\", pro = \"expert\" } }\n\
        age_years = { column = \"age\" }\n";

    fn world() -> World {
        let columns = "\n[[people]]\nid = \"crew\"\nlevels = [\"novice\", \"expert\"]\n\
                       [[people]]\nid = \"age_years\"\nunit = \"years\"\n";
        World::with(&(template(&"demo".parse().unwrap()) + columns))
    }

    fn written(world: &World, form: PeopleForm) -> String {
        std::fs::read_to_string(world.layout.people(form)).unwrap()
    }

    #[test]
    fn a_table_of_people_becomes_the_participants_file_and_is_added_once() {
        let world = world();
        let table = world.file("a.csv", "subject,grp,age\n1,pro,27\n2,beginner,\n3,?,31\n");
        let report = world.import(MAP, std::slice::from_ref(&table)).unwrap();
        assert!(report.to_string().contains("3 participants"), "{report}");
        let first = "participant,crew,age_years\nP01,expert,27\nP02,novice,\nP03,,31\n";
        assert_eq!(written(&world, PeopleForm::Csv), first);
        assert_eq!(StudyData::load(&world.layout).unwrap().people.iter().count(), 3);
        // Again, with one more.
        let more = world.file("b.csv", "subject,grp,age\n3,?,31\n4,pro,40\n");
        let again = world.import(MAP, &[table, more]).unwrap();
        assert_eq!(again.participants, 1);
        assert!(again.to_string().contains("3 rows say what is known already"), "{again}");
        assert_eq!(written(&world, PeopleForm::Csv), format!("{first}P04,expert,40\n"));
    }

    /// Pounds and inches by their definitions: 154 lb are 69.85322498 kg, 70 in are 177.8 cm.
    #[test]
    fn numbers_in_other_units_become_those_of_the_study() {
        let study = template(&"demo".parse().unwrap())
            + "\n[[people]]\nid = \"age_years\"\nunit = \"years\"\n[[people]]\nid = \"height\"\nunit = \"cm\"\n\
               [[people]]\nid = \"mass\"\nunit = \"kg\"\n[[people]]\nid = \"games\"\nunit = \"per week\"\n\
               [[people]]\nid = \"crew\"\nlevels = [\"a\", \"b\"]\n";
        let world = World::with(&study);
        let map = |units: &str| {
            format!(
                "kind = \"participants\"\n[people]\nparticipant = {{ column = \"subject\" }}\n[people.columns]\n\
                 age_years = {{ column = \"age\" }}\nheight = {{ column = \"tall\" }}\nmass = {{ column = \"heavy\" }}\n\
                 games = {{ column = \"games\" }}\ncrew = {{ column = \"crew\" }}\n[people.units]\n{units}"
            )
        };
        let good =
            "age_years = \"months\"\nheight = \"inches\"\nmass = \"lb\"\ngames = \"per week\"\n";
        let table = world
            .file("a.csv", "subject,age,tall,heavy,games,crew\nP01,324,70,154,2,a\nP02,335,,,,\n");
        let report = world.import(&map(good), std::slice::from_ref(&table)).unwrap();
        assert!(report.to_string().contains("height from inches"), "{report}");
        let text = "participant,age_years,height,mass,games,crew\nP01,27,177.8,69.85322498,2,a\nP02,27,,,,\n";
        assert_eq!(written(&world, PeopleForm::Csv), text);
        // The same once more is what is there.
        assert_eq!(world.import(&map(good), std::slice::from_ref(&table)).unwrap().participants, 0);
        for (units, words) in [
            (
                "mass = \"talents\"",
                "mass: the unit 'talents' is unknown; use one of kg, g, lb, st, oz",
            ),
            (
                "height = \"lb\"",
                "height: the unit 'lb' cannot become 'cm', the unit of [[people]] in study.toml; use one of ft, m, cm",
            ),
            (
                "games = \"per day\"",
                "'per day' cannot become 'per week', the unit of [[people]] in study.toml, which is unknown",
            ),
            ("crew = \"m\"", "crew: the column has levels, and no unit"),
            ("hand = \"m\"", "people.units.hand"),
        ] {
            let errors = world.import(&map(units), std::slice::from_ref(&table)).unwrap_err();
            assert!(errors[0].to_string().contains(words), "{words}: {}", errors[0]);
        }
    }

    #[test]
    fn a_file_in_toml_keeps_what_it_has_and_gets_tables() {
        let world = world();
        let own = "# ours\n[P01]\ncrew = \"expert\"";
        std::fs::write(world.layout.people(PeopleForm::Toml), own).unwrap();
        let table = world.file("a.csv", "subject,grp,age\n1,pro,\n2,beginner,31\n");
        assert_eq!(world.import(MAP, &[table]).unwrap().participants, 1);
        let text = format!("{own}\n\n[P02]\nage_years = 31.0\ncrew = \"novice\"\n");
        assert_eq!(written(&world, PeopleForm::Toml), text);
        assert_eq!(StudyData::load(&world.layout).unwrap().people.iter().count(), 2);
    }

    #[test]
    fn a_wrong_row_leaves_the_file_as_it_was() {
        let world = world();
        let own = "participant,crew\nP01,expert\n";
        std::fs::write(world.layout.people(PeopleForm::Csv), own).unwrap();
        for (rows, words) in [
            (
                "9,pro,\n1,beginner,\n",
                "P01 is in the participants' file already, and otherwise: crew expert; here crew novice",
            ),
            ("2,pro,\n2,beginner,\n", "P02 stands twice, and otherwise"),
            ("2,amateur,\n", "'amateur' is not in the translation table"),
            ("2,pro,young\n", "'young' is not a number; give one in years"),
            ("2,pro,27.5\n", "whole years"),
            ("2,pro,inf\n", "inf is not a number"),
            (",pro,\n", "there is no participant"),
            ("2,pro,27\n", "it has no column 'age_years', which the table has"),
        ] {
            let table = world.file("a.csv", format!("subject,grp,age\n{rows}"));
            let errors = world.import(MAP, &[table]).unwrap_err();
            assert!(errors[0].to_string().contains(words), "{words}: {}", errors[0]);
            assert_eq!(written(&world, PeopleForm::Csv), own);
        }
        let map = MAP.replace("age_years =", "height_m =");
        let errors = world.import(&map, &[world.file("a.csv", "subject,grp,age\n")]).unwrap_err();
        assert!(errors[0].what.contains("has no column 'height_m'"), "{}", errors[0]);
    }

    #[test]
    fn what_could_not_be_read_again_is_not_written() {
        let world = world();
        let rows: String = (0..90_000).map(|n| format!("{n},pro,27\n")).collect();
        let table = world.file("many.csv", format!("subject,grp,age\n{rows}"));
        let map = MAP.replace("digits = 2", "digits = 30");
        let errors = world.import(&map, &[table]).unwrap_err();
        assert!(errors[0].what.contains("would be larger"), "{}", errors[0]);
        assert!(!world.layout.people(PeopleForm::Csv).exists());
    }
}
