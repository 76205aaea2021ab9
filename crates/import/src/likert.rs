//! Questionnaire tables → trials without samples, and answers as events. Here: wide ones, a row a
//! trial; `long` has the others.

use super::batch::Batch;
use super::given::{Answered, Given, Place, read_given};
use super::identity::{Identity, Named, identity, number_trials, tell_labels};
use super::limits::{Budget, Take};
use super::mapping::{Asked, Questionnaire, Who};
use super::recording::Recording;
use super::report::FileReport;
use super::table::ColumnRef;
use super::{Context, Converted, EMPTY, Errors, all, long, once};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use zwidth_store::StoreError;
use zwidth_study::{Event, PlannedTrial, QuestionId, Study};

/// A question, the column of its answers, and that of the times that they took.
type WideColumn = (QuestionId, ColumnRef, Option<ColumnRef>);

/// Reads every file, numbers the trials over all of them, and turns the answers into events.
pub(super) fn likert(
    context: &Context,
    (who, asked): (&Who, &Questionnaire),
    files: &[PathBuf],
) -> Result<Batch, Errors> {
    let budget = Budget::default();
    let wide = match &asked.form {
        Asked::Wide { columns, times } => question_columns(columns, times, context)?,
        Asked::Long(_) => Vec::new(),
    };
    let columns = who.columns().into_iter().chain(asked.columns());
    let columns = columns.chain(wide.iter().map(|(_, answer, _)| answer)).collect();
    let take = Take { columns, pattern: None, budget: &budget };
    let converted = context.convert(files, &take, |recording| match &asked.form {
        Asked::Wide { .. } => convert(context, (who, asked), &wide, &budget, recording),
        Asked::Long(form) => long::convert(context, (who, asked, form), &budget, recording),
    })?;
    if matches!(asked.form, Asked::Long(_)) {
        let found: Vec<&[Answered]> = converted.iter().map(|c| c.made.0.as_slice()).collect();
        long::apart(&found)?;
    }
    let mut batch = Batch::default();
    let (mut rows, mut sources) = (Vec::new(), Vec::new());
    for Converted { blake3, made: (found, _), .. } in &converted {
        rows.extend(found);
        sources.resize(rows.len(), blake3.as_str());
    }
    let identities: Vec<Identity> = rows.iter().map(|r| r.identity.clone()).collect();
    for Converted { made: (found, report), .. } in &converted {
        let mut report = report.clone();
        let own: Vec<&Identity> = found.iter().map(|r| &r.identity).collect();
        tell_labels(&mut report, &own, &identities);
        batch.files.push(report);
    }
    let planned = number_trials(context, &identities, false)?;
    once::answers(context, &converted)?;
    let mut events: Vec<Vec<Event>> =
        rows.into_iter().zip(&planned).map(|(row, number)| events(row, number)).collect();
    note_losses(&converted, &mut events);
    batch.add_sessions(context, &identities, &planned, events, &sources)?;
    Ok(batch)
}

/// Has the log of each session say, with its first trial in the table, what of the table could not be
/// read.
fn note_losses(converted: &[Converted<(Vec<Answered>, FileReport)>], events: &mut [Vec<Event>]) {
    let mut events = events.iter_mut();
    for Converted { made: (found, report), .. } in converted {
        let mut told = BTreeSet::new();
        for (Answered { identity, .. }, events) in found.iter().zip(&mut events) {
            let is_first = told.insert((&identity.participant, &identity.session));
            let lost = report.lost.as_ref().filter(|_| is_first);
            events.extend(lost.map(|lost| Event::Note {
                trial: None,
                text: format!("of the table of answers, {lost}"),
            }));
        }
    }
}

/// The answers after a trial as events of it.
fn events(row: &Answered, PlannedTrial { trial, .. }: &PlannedTrial) -> Vec<Event> {
    let event = |(question, given): &(QuestionId, Given)| Event::Answer {
        trial: *trial,
        question: question.clone(),
        value: given.value,
        time_ms: given.time_ms,
    };
    row.answers.iter().map(event).collect()
}

/// The column of every question: as listed in the mapping, or the one whose header is its text.
fn question_columns(
    listed: &BTreeMap<QuestionId, ColumnRef>,
    times: &BTreeMap<QuestionId, ColumnRef>,
    context: &Context,
) -> Result<Vec<WideColumn>, StoreError> {
    let study = context.study;
    let error = |what: String, remedy: &str| StoreError::new(&context.mapping.path, what, remedy);
    if let Some(id) = listed.keys().find(|id| study.question(id).is_none()) {
        let what = format!("[questions.columns] has '{id}', which is not a question of study.toml");
        return Err(error(what, "add it to study.toml, or remove it from the mapping"));
    }
    if let Some(id) = times.keys().find(|id| study.question(id).is_none()) {
        let what = format!("[questions.times] has '{id}', which is not a question of study.toml");
        return Err(error(what, "add it to study.toml, or remove it from the mapping"));
    }
    let with_time = |id: &QuestionId, column| (id.clone(), column, times.get(id).cloned());
    if !listed.is_empty() {
        return Ok(listed.iter().map(|(id, column)| with_time(id, column.clone())).collect());
    }
    if study.questions.is_empty() {
        return Err(error(
            "study.toml has no questions".to_owned(),
            "add [[questions]] to study.toml",
        ));
    }
    if let Some(id) = repeated_text(study) {
        let what = format!("question '{id}' of study.toml has the text of another one");
        return Err(error(what, "list the columns in [questions.columns]"));
    }
    Ok(study
        .questions
        .iter()
        .map(|q| with_time(&q.id, ColumnRef::Name(q.text.trim().to_owned())))
        .collect())
}

fn repeated_text(study: &Study) -> Option<&QuestionId> {
    let mut questions = study.questions.iter().enumerate();
    let second = questions.find(|(i, q)| study.questions[..*i].iter().any(|p| p.text == q.text));
    second.map(|(_, q)| &q.id)
}

fn convert(
    context: &Context,
    (who, asked): (&Who, &Questionnaire),
    questions: &[WideColumn],
    budget: &Budget,
    recording: &Recording,
) -> Result<(Vec<Answered>, FileReport), Errors> {
    let labels = all(who.columns().into_iter().map(|c| recording.find(c)))?;
    let columns = all(questions.iter().map(|(_, column, _)| recording.find(column)))?;
    let times = all(questions
        .iter()
        .map(|(.., time)| time.as_ref().map(|column| recording.find(column)).transpose()))?;
    let used =
        [labels.clone(), columns.clone(), times.iter().copied().flatten().collect()].concat();
    let mut rows = recording.rows(&context.mapping.file, &[], &labels)?;
    let headers = recording.leave_out_headers(&mut rows, &used);
    budget.trials(&recording.path, rows.kept.len())?;
    let mut named = Named::default();
    let read = rows.kept.iter().map(|row| {
        let identity = identity(who, recording, *row, context.study)?;
        named.add(recording, *row, &identity)?;
        let places = columns.iter().zip(&times);
        let places = places.map(|(answer, time)| Place { row: *row, answer: *answer, time: *time });
        let answers = questions.iter().zip(places).map(|((id, ..), place)| {
            let given = read_given(context, asked, recording, id, place)?;
            Ok::<_, Errors>(given.map(|given| (id.clone(), given)))
        });
        Ok::<_, Errors>(Answered {
            identity,
            answers: all(answers)?.into_iter().flatten().collect(),
        })
    });
    let found: Vec<Answered> = all(read)?;
    let mut report = context.file_report(recording, (&rows, rows.kept.len()), &used)?;
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, EMPTY);
    report.add_headers(headers);
    let answers: usize = found.iter().map(|r| r.answers.len()).sum();
    report.converted.push(format!("answers, as given, of {} questions", questions.len()));
    let empty = match found.len() * questions.len() - answers {
        0 => String::new(),
        n => format!("; {n} empty answers left out"),
    };
    report.made.push(format!("{} trials without samples, {answers} answers{empty}", found.len()));
    Ok((found, report))
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use zwidth_study::{Event, StudyId, template};

    const MAP: &str = "
kind = \"likert\"
[file]
delimiter = \";\"
[trial]
participant = { column = \"who\", prefix = \"P\", digits = 2 }
session = \"S01\"
environment = \"spring\"
mode = { column = \"mode\" }
trial = { column = \"order\" }
";

    /// The template with short texts: question `felt_spring` asks "Spring?", `felt_wall` asks
    /// "Wall?".
    fn world() -> World {
        let text = template(&StudyId::new("demo").unwrap());
        let short = text.lines().map(|line| match line {
            l if l.contains("such as a wall") => "text = \"Wall?\"",
            l if l.contains("a linear stiffness") => "text = \"Spring?\"",
            l => l,
        });
        World::with(&short.collect::<Vec<_>>().join("\n"))
    }

    const TABLE: &str = "Timestamp;who;mode;order;Wall?;Spring?\n\
        x;1;active;2;5;1\n\
        x;1;passive;1;4;2\n\
        x;12;active;1;3;3\n";

    #[test]
    fn every_row_becomes_a_trial_without_samples_and_answers_as_events() {
        let world = world();
        let report = world.import(MAP, &[world.file("a.csv", TABLE)]).unwrap();
        assert_eq!((report.trials, report.sessions, report.answers), (0, 2, 6));
        assert_eq!(report.files[0].columns_dropped[0].column, "Timestamp");
        let events = world.events("P01", "S01");
        let answer = |trial, question: &str, value: i16| Event::Answer {
            trial,
            question: question.parse().unwrap(),
            value: value.into(),
            time_ms: None,
        };
        assert_eq!(events[..2], [answer(1, "felt_spring", 2), answer(1, "felt_wall", 4)]);
        let data = world.load();
        assert!(data.sessions[0].record.trials.iter().all(|t| !t.samples));
        let answers = data.answers;
        assert_eq!(answers.len(), 6);
        assert_eq!(answers[5].participant.as_str(), "P12");
    }

    #[test]
    fn questions_may_be_listed_with_their_columns() {
        let world = world();
        let map = format!("{MAP}[questions.columns]\nfelt_wall = 5\n");
        assert_eq!(world.import(&map, &[world.file("a.csv", TABLE)]).unwrap().answers, 3);
    }

    #[test]
    fn an_empty_answer_is_refused_or_left_out_never_invented() {
        let world = world();
        let file = world.file("a.csv", TABLE.replace("5;1", ";1"));
        world.refuses(
            MAP,
            &file,
            "the answer '' must be a whole number from 1 to 5 (line 2)",
            Some(("Wall?", 1)),
        );
        let drop = MAP.replace("[trial]", "missing = \"drop\"\n[trial]");
        let report = world.import(&drop, &[file]).unwrap();
        assert_eq!(report.answers, 5);
        assert!(report.to_string().contains("5 answers; 1 empty answers left out"), "{report}");
    }

    #[test]
    fn an_answer_that_others_mark_as_missing_is_empty_and_a_word_of_the_scale_is_none() {
        let world = world();
        let drop = MAP.replace("[trial]", "missing = \"drop\"\n[trial]");
        let file = world.file("a.csv", TABLE.replace("5;1", "None;NA"));
        world.refuses(MAP, &file, "the answer 'None' must be a whole number", Some(("Wall?", 1)));
        let words = format!("{drop}[questions.translate]\nNA = 3\n");
        let report = world.import(&words, &[file]).unwrap();
        assert_eq!(report.answers, 5);
    }

    #[test]
    fn questions_with_the_quotes_of_windows_are_found_by_their_text() {
        let text = template(&StudyId::new("demo").unwrap());
        let line = text.lines().find(|line| line.contains("such as a wall")).unwrap();
        let world = World::with(&text.replace(line, "text = \"I can’t feel “it”\""));
        let map = MAP.replace("[file]\n", "[file]\nencoding = \"windows-1252\"\n");
        let map = format!("{map}[questions.columns]\nfelt_wall = \"I can’t feel “it”\"\n");
        let table = b"who;mode;order;I can\x92t feel \x93it\x94\n1;active;1;4\n";
        assert_eq!(world.import(&map, &[world.file("a.csv", table)]).unwrap().answers, 1);
    }

    #[test]
    fn a_word_of_a_scale_is_translated_in_any_of_its_spellings() {
        let world = world();
        let map = format!("{MAP}[questions.translate]\n1 = 5\n5 = 1\n");
        world.import(&map, &[world.file("a.csv", TABLE.replace("5;1", "5.0;1.0"))]).unwrap();
        let values = world.events("P01", "S01");
        let first = |event: &Event| match event {
            Event::Answer { trial: 2, value, .. } => value.whole(),
            _ => None,
        };
        assert_eq!(values.iter().filter_map(first).collect::<Vec<_>>(), [5, 1]);
    }

    #[test]
    fn rows_that_say_different_things_of_one_trial_are_refused_with_both() {
        let world = world();
        let check = |map: &str, text: &str, words: &str, row: usize| {
            let errors = world.import(map, &[world.file("a.csv", text)]).unwrap_err();
            let [error] = errors.as_slice() else { panic!("{errors:?}") };
            assert!(error.row == Some(row) && error.what.contains(words), "{error}");
        };
        let wide = "who;mode;order;Wall?;Spring?\n1;active;2;5;1\n1;passive;2;4;2\n";
        let words =
            "trial 2 of P01 S01 is spring, active in line 2, and spring, passive here (line 3)";
        check(MAP, wide, words, 2);
        let form = "[questions]\nquestion = { column = \"item\" }\nanswer = \"response\"\n";
        let long = format!("{MAP}repeat = {{ column = \"again\" }}\n{form}");
        let rows = "1;active;2;1;felt_wall;4\n1;active;2;2;felt_spring;4\n";
        let text = format!("who;mode;order;again;item;response\n{rows}");
        let words = "is spring, active, repeat 1 in line 2, and spring, active, repeat 2 here";
        check(&long, &text, words, 2);
    }

    #[test]
    fn bad_answers_and_tables_are_refused_with_column_and_row() {
        let world = world();
        let check = |map: &str, from: &str, to: &str, words: &str, at| {
            assert!(TABLE.contains(from), "{from}");
            world.refuses(map, &world.file("a.csv", TABLE.replace(from, to)), words, at);
        };
        check(MAP, "1;4;2", "1;6;2", "the answer '6'", Some(("Wall?", 2)));
        check(MAP, "1;4;2", "1;2.5;2", "the answer '2.5'", Some(("Wall?", 2)));
        check(MAP, "1;4;2", "1;agree;2", "the answer 'agree'", Some(("Wall?", 2)));
        check(MAP, "passive;1", "passive;2", "duplicate trial: trial 2 of P01 S01", None);
        check(MAP, "Wall?", "Walls?", "column Wall?: the column is missing", None);
        check(MAP, "x;12;", "x;Ann;", "'Ann' is not a whole number", Some(("who", 3)));
        check(
            MAP,
            "x;12;active",
            "x;12;actve",
            "mode 'actve' is not in study.toml",
            Some(("mode", 3)),
        );
        let odd = format!("{MAP}[questions.columns]\nnothing = 5\n");
        check(&odd, "x", "x", "'nothing', which is not a question of study.toml", None);
    }
}
