//! Questionnaire tables → trials without samples, and answers as events. This module reads wide
//! tables, with one row per trial; `long` reads the others.

use super::added::ExistingAnswers;
use super::batch::Batch;
use super::context::{Context, Converted, EMPTY};
use super::errors::{Errors, all, append};
use super::given::{Answered, Place, Read, read_answer, tell_middles};
use super::identity::{Identity, Named, identity, number_trials, tell_labels};
use super::limits::Budget;
use super::mapping::{AnswerForm, Missing, Questionnaire, RowTrial, Who};
use super::recording::Recording;
use super::report::{FileReport, RowsDropped};
use super::shape::{AnswerFrom, JsonKey};
use super::table::{Cell, ColumnRef};
use super::{long, once};
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_store::StoreError;
use zwidth_study::{Event, Question, QuestionId};

/// What is one trial of each row: its labels, and of each question the column of its answers and that of
/// the times that they took.
struct Wide<'a> {
    who: &'a Who,
    questions: Vec<WideQuestion>,
}

/// A question with the places of its answers, and of the times that they took.
pub(super) struct WideQuestion {
    pub(super) id: QuestionId,
    pub(super) from: AnswerFrom,
    pub(super) time: Option<ColumnRef>,
}

/// Reads every file, numbers the trials over all of them, and turns the answers into events. In an
/// existing session its trials are answered.
pub(super) fn likert(
    context: &Context,
    questionnaire: &Questionnaire,
    files: &[PathBuf],
) -> Result<Batch, Errors> {
    let budget = Budget::default();
    let wide = match &questionnaire.form {
        AnswerForm::Wide(trials) => all(trials.iter().map(|trial| {
            let questions = wide_questions(context, trial)?;
            Ok::<_, StoreError>(Wide { who: &trial.who, questions })
        }))?,
        AnswerForm::Long(..) => Vec::new(),
    };
    let answer_columns = wide.iter().flat_map(|w| &w.questions).map(|q| q.from.column());
    let columns = questionnaire.columns().into_iter().chain(answer_columns).collect();
    let take = context.take(columns, &budget);
    let converted = context.convert(files, &take, |recording| match &questionnaire.form {
        AnswerForm::Wide(_) => convert(context, questionnaire, &wide, &budget, recording),
        AnswerForm::Long(long) => long::convert(context, questionnaire, long, &budget, recording),
    })?;
    if matches!(questionnaire.form, AnswerForm::Long(..)) {
        let trials: Vec<&[Answered]> =
            converted.iter().map(|c| c.parsed.trials.as_slice()).collect();
        long::apart(&trials)?;
    }
    let rows: Vec<(&Converted<Read>, &Answered)> = converted
        .iter()
        .flat_map(|file| file.parsed.trials.iter().map(move |row| (file, row)))
        .collect();
    let identities: Vec<Identity> = rows.iter().map(|(_, row)| row.identity.clone()).collect();
    let mut batch = Batch::default();
    let mut existing = match rows.iter().any(|(_, row)| has_session(context, row)) {
        true => Some(ExistingAnswers::load(context, &identities)?),
        false => None,
    };
    for file in &converted {
        batch.files.push(file_report(context, file, &identities, existing.as_mut())?);
    }
    batch.added = existing.map(|existing| existing.events).unwrap_or_default();
    let mut new = rows;
    new.retain(|(_, row)| !has_session(context, row));
    let identities: Vec<Identity> = new.iter().map(|(_, row)| row.identity.clone()).collect();
    let planned = number_trials(context, &identities, false)?;
    once::answers(context, new.iter().map(|(file, _)| *file), |read| &read.columns)?;
    let events = new.iter().zip(&planned).map(|((_, row), number)| {
        let events = row.answers.iter().map(|(question, answer)| Event::Answer {
            trial: number.trial,
            question: question.clone(),
            value: answer.value,
            time_ms: answer.time_ms,
        });
        events.collect::<Vec<Event>>()
    });
    let mut events: Vec<Vec<Event>> = events.collect();
    // The first trial of a session in a table says in its log what of the table could not be read.
    let mut noted = BTreeSet::new();
    for ((file, Answered { identity, .. }), events) in new.iter().zip(&mut events) {
        let is_first = noted.insert((&file.path, &identity.participant, &identity.session));
        let lost = file.parsed.report.lost.as_deref().filter(|_| is_first);
        events.extend(lost.map(loss));
    }
    let sources: Vec<&str> = new.iter().map(|(file, _)| file.blake3.as_str()).collect();
    let columns: BTreeSet<usize> =
        new.iter().flat_map(|(file, _)| &file.parsed.columns).copied().collect();
    batch.answer_columns = columns.into_iter().collect();
    batch.add_sessions(context, &identities, &planned, events, &sources)?;
    Ok(batch)
}

/// Whether the study has the session of a row already.
fn has_session(context: &Context, row: &Answered) -> bool {
    let Identity { participant, session, .. } = &row.identity;
    context.files.kind(&context.layout.session(participant, session)).is_some()
}

/// The report on a file: which trials its rows make, and which existing ones they answer.
fn file_report(
    context: &Context,
    file: &Converted<Read>,
    all: &[Identity],
    mut existing: Option<&mut ExistingAnswers>,
) -> Result<FileReport, Errors> {
    let Read { trials, report, empty, .. } = &file.parsed;
    let (mut new, mut answered, mut answers) = (0, 0, 0);
    let mut unchanged = BTreeSet::new();
    let mut errors = Errors::default();
    let mut logs = BTreeSet::new();
    for row in trials {
        let Identity { participant, session, .. } = &row.identity;
        let existing = existing.as_mut().filter(|_| has_session(context, row));
        match existing.map(|existing| existing.answer(context, row)) {
            None => {
                new += 1;
                answers += row.answers.len();
            }
            Some(Ok(0)) => _ = unchanged.insert(format!("{participant} {session}")),
            Some(Ok(added)) => {
                answered += 1;
                answers += added;
                logs.insert(context.layout.events(participant, session));
            }
            Some(Err(error)) => errors.push(error),
        }
    }
    errors.none()?;
    if let (Some(existing), Some(lost)) = (existing, &report.lost) {
        for log in logs {
            existing.events.entry(log).or_default().push(loss(lost));
        }
    }
    let unchanged: Vec<String> = unchanged.into_iter().collect();
    if new + answered == 0 {
        return Ok(FileReport::there_already(&file.path, &unchanged.join(", ")));
    }
    let mut report = report.clone();
    tell_labels(&mut report, trials.iter().map(|row| &row.identity), all);
    tell_middles(context, &mut report, trials.iter().flat_map(|row| &row.answers));
    let empty = match empty {
        0 => String::new(),
        n => format!("; {n} empty answers left out"),
    };
    report.made.push(match answered {
        0 => format!("{new} trials without samples, {answers} answers{empty}"),
        n => format!("{new} trials without samples, {answers} answers, {n} trials that are there answered{empty}"),
    });
    if !unchanged.is_empty() {
        let sessions = unchanged.join(", ");
        report.told.push(format!("in the study already, and left out: {sessions}"));
    }
    Ok(report)
}

/// The note in a session's log about a table that could not be read whole.
pub(super) fn loss(lost: &str) -> Event {
    Event::Note { trial: None, text: format!("of the table of answers, {lost}") }
}

/// The columns of what is one trial of a row: as listed in the mapping, or those whose header is a
/// question's text.
pub(super) fn wide_questions(
    context: &Context,
    trial: &RowTrial,
) -> Result<Vec<WideQuestion>, StoreError> {
    let RowTrial { columns, times, .. } = trial;
    let study = context.study;
    let mapping = &context.mapping.path;
    let listed = columns.keys().map(|id| (id, "columns"));
    for (id, table) in listed.chain(times.keys().map(|id| (id, "times"))) {
        if study.question(id).is_none() {
            let what =
                format!("[questions.{table}] has '{id}', which is not a question of study.toml");
            let remedy = "add it to study.toml, or remove it from the mapping";
            return Err(StoreError::new(mapping, what, remedy));
        }
    }
    if !columns.is_empty() {
        let questions = columns.iter().map(|(id, from)| WideQuestion {
            id: id.clone(),
            from: from.clone(),
            time: times.get(id).cloned(),
        });
        return Ok(questions.collect());
    }
    if study.questions.is_empty() {
        let what = "study.toml has no questions";
        return Err(StoreError::new(mapping, what, "add [[questions]] to study.toml"));
    }
    // A text that two questions share does not say whose column it heads.
    let asked: Vec<&Question> =
        study.questions.iter().filter(|q| !q.is_pair() && !q.is_of_task()).collect();
    let mut questions = asked.iter().enumerate();
    let second = questions.find(|(i, q)| asked[..*i].iter().any(|p| p.text == q.text));
    if let Some((_, question)) = second {
        let what = format!("question '{}' of study.toml has the text of another one", question.id);
        return Err(StoreError::new(mapping, what, "list the columns in [questions.columns]"));
    }
    let questions = asked.iter().map(|q| {
        let from = AnswerFrom::Cell(ColumnRef::Name(q.text.trim().to_owned()));
        WideQuestion { id: q.id.clone(), from, time: times.get(&q.id).cloned() }
    });
    Ok(questions.collect())
}

fn convert(
    context: &Context,
    questionnaire: &Questionnaire,
    wide: &[Wide],
    budget: &Budget,
    recording: &Recording,
) -> Result<Read, Errors> {
    let labels = all(wide
        .iter()
        .map(|trial| all(trial.who.columns().into_iter().map(|column| recording.find(column)))))?;
    let places = all(wide.iter().map(|trial| {
        all(trial.questions.iter().map(|question| {
            let time = question.time.as_ref().map(|column| recording.find(column)).transpose()?;
            Ok::<_, StoreError>((recording.find(question.from.column())?, time))
        }))
    }))?;
    let columns: BTreeSet<usize> = places.iter().flatten().map(|(answer, _)| *answer).collect();
    let times = places.iter().flatten().filter_map(|(_, time)| *time);
    let used = labels.iter().flatten().chain(&columns).copied().chain(times);
    let used: BTreeSet<usize> = used.collect();
    let used: Vec<usize> = used.into_iter().collect();
    // Without what all conditions have in common nobody knows whose row it is.
    let shared = labels[0].iter().filter(|at| labels.iter().all(|places| places.contains(at)));
    let shared: Vec<usize> = shared.copied().collect();
    let mut rows = recording.rows(&context.mapping.file, &[], &shared)?;
    let headers = recording.leave_out_headers(&mut rows, &used);
    let drops = context.mapping.file.cells.missing == Missing::Drop;
    let before = rows.kept.len();
    if drops {
        // A program that writes its answers so has rows for its other screens too.
        let questions = wide.iter().zip(&places);
        let questions = questions.flat_map(|(trial, places)| trial.questions.iter().zip(places));
        let json = questions.filter(|(question, _)| matches!(question.from, AnswerFrom::Json(_)));
        let json: Vec<usize> = json.map(|(_, (answer, _))| *answer).collect();
        rows.kept.retain(|row| {
            json.iter().all(|at| match recording.table.columns[*at].cell(*row) {
                // The beginning is enough: an object that is damaged is an error further on.
                Cell::Text(text) => text.trim_start().starts_with('{'),
                Cell::Empty | Cell::Number(_) => false,
            })
        });
    }
    let others = before - rows.kept.len();
    // Counted before anything is made of them.
    budget.trials(&recording.path, rows.kept.len() * wide.len())?;
    let mut trials = Vec::new();
    let mut errors = Errors::default();
    let mut named = Named::default();
    let mut empty = 0;
    let mut absent = 0;
    for row in &rows.kept {
        for (trial, (labels, places)) in wide.iter().zip(labels.iter().zip(&places)) {
            // A person who did not do this condition.
            let is_absent =
                drops && labels.iter().any(|label| recording.is_without_label(*label, *row));
            if is_absent {
                absent += 1;
                continue;
            }
            let identity = identity(trial.who, recording, *row, context.study);
            let read = identity.map_err(Errors::from).and_then(|identity| {
                named.add(recording, *row, &identity)?;
                let answers = trial.questions.iter().zip(places).map(|(question, place)| {
                    let key = match &question.from {
                        AnswerFrom::Cell(_) => None,
                        AnswerFrom::Json(JsonKey { key, .. }) => Some(key.as_str()),
                    };
                    let (answer, time) = *place;
                    let place = Place { row: *row, answer, key, time };
                    let answer =
                        read_answer(context, questionnaire, recording, &question.id, place)?;
                    Ok::<_, Errors>(answer.map(|answer| (question.id.clone(), answer)))
                });
                Ok(Answered { identity, answers: all(answers)?.into_iter().flatten().collect() })
            });
            match read {
                Ok(read) => {
                    empty += trial.questions.len() - read.answers.len();
                    trials.push(read);
                }
                Err(wrong) => append(&mut errors, wrong),
            }
        }
    }
    errors.none()?;
    let mut report = context.file_report(recording, &rows, rows.kept.len(), &used)?;
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, EMPTY);
    report.add_headers(headers);
    if others > 0 {
        let why = "they hold no JSON object where the answers are".to_owned();
        report.rows_dropped.push(RowsDropped { rows: others, why });
    }
    report.converted.push(format!("answers, as given, of {} questions", wide[0].questions.len()));
    if absent > 0 {
        report.told.push(format!("{absent} conditions of rows have no label, and are left out"));
    }
    // The session's record counts them from 1.
    let columns = columns.into_iter().map(|place| place + 1).collect();
    Ok(Read { trials, report, columns, empty })
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
        let words = "the answer '' must be a whole number from 1 to 5 (line 2)";
        world.refuses(MAP, &file, words, Some(("Wall?", 1)));
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

    const TWO: &str = "
kind = \"likert\"
[trial]
participant = { column = \"who\" }
session = \"S01\"
environment = \"spring\"
[[condition]]
mode = { column = \"first\" }
columns = { felt_spring = \"s1\", felt_wall = \"w1\" }
[[condition]]
mode = { column = \"second\" }
columns = { felt_spring = \"s2\" }
";

    #[test]
    fn a_row_with_several_conditions_is_a_trial_of_each() {
        let world = world();
        let table = "who,first,s1,w1,second,s2\nA,active,1,2,passive,3\nB,passive,4,5,active,1\n";
        let report = world.import(TWO, &[world.file("a.csv", table)]).unwrap();
        assert_eq!((report.sessions, report.answers), (2, 6));
        let answers = world.load().answers;
        for (who, expect) in [
            ("A", ["active felt_spring 1", "active felt_wall 2", "passive felt_spring 3"]),
            ("B", ["passive felt_spring 4", "passive felt_wall 5", "active felt_spring 1"]),
        ] {
            let own = answers.iter().filter(|a| a.participant.as_str() == who);
            let own = own.map(|a| format!("{} {} {}", a.condition.mode, a.question, a.value));
            assert_eq!(own.collect::<Vec<_>>(), expect);
        }
        // Somebody who did one of them.
        let table = "who,first,s1,w1,second,s2\nC,active,1,2,,\n";
        let file = world.file("b.csv", table);
        world.refuses(TWO, &file, "there is no mode", Some(("second", 1)));
        let drop = TWO.replace("[trial]", "[file]\nmissing = \"drop\"\n[trial]");
        let report = world.import(&drop, &[file]).unwrap();
        assert_eq!((report.sessions, report.answers), (1, 2));
        assert!(report.to_string().contains("1 conditions of rows have no label"), "{report}");
    }

    #[test]
    fn other_columns_of_a_table_are_another_session_and_the_same_ones_are_not() {
        let world = world();
        let file =
            world.file("a.csv", "who,m1,s1,m2,s2\nA,active,1,passive,3\nB,passive,4,active,1\n");
        let map = |session: &str, n: u32| {
            let trial = "participant = { column = \"who\" }\nenvironment = \"spring\"";
            format!(
                "kind = \"likert\"\n[trial]\n{trial}\nsession = \"{session}\"\nmode = {{ column = \"m{n}\" }}\n\
                 [questions.columns]\nfelt_spring = \"s{n}\"\n"
            )
        };
        world.import(&map("S01", 1), std::slice::from_ref(&file)).unwrap();
        world.import(&map("S02", 2), std::slice::from_ref(&file)).unwrap();
        assert_eq!(world.load().answers.len(), 4);
        world.refuses(&map("S03", 2), &file, "imported before, as A S02", None);
    }

    #[test]
    fn another_questionnaire_of_a_session_answers_its_trials() {
        let world = world();
        let wall = format!("{MAP}[questions.columns]\nfelt_wall = \"Wall?\"\n");
        let spring = format!("{MAP}[questions.columns]\nfelt_spring = \"Spring?\"\n");
        let file = world.file("a.csv", TABLE);
        world.import(&wall, std::slice::from_ref(&file)).unwrap();
        // A line of it that cannot be read stands in the logs that it adds to.
        let damaged = world.file("c.csv", format!("{TABLE}x;1\n"));
        let careless = spring.replace("[file]", "[file]\nbad_lines = 1");
        let report = world.import(&careless, &[damaged]).unwrap();
        assert_eq!((report.sessions, report.answers), (0, 3));
        let noted = |e: &Event| matches!(e, Event::Note { text, .. } if text.contains("of the table of answers"));
        assert_eq!(world.events("P01", "S01").iter().filter(|e| noted(e)).count(), 1);
        assert!(report.to_string().contains("3 trials that are there answered"), "{report}");
        assert_eq!(world.load().answers.len(), 6);
        let before = world.written();
        let report = world.import(&spring, &[file]).unwrap().to_string();
        assert!(report.contains("in the study already, as P01 S01, P12 S01"), "{report}");
        let other = "trial 2 of P01 S01 has the answer 1 to 'felt_spring' already, and here 2";
        for (from, to, words) in [
            ("5;1", "5;2", other),
            ("active;2;", "passive;2;", "has no trial of spring, passive, trial 2"),
        ] {
            let file = world.file("b.csv", TABLE.replace(from, to));
            world.refuses(&spring, &file, words, None);
        }
        assert_eq!(world.written(), before);
    }

    #[test]
    fn a_table_that_grew_adds_its_new_people() {
        let world = world();
        world.import(MAP, &[world.file("a.csv", TABLE)]).unwrap();
        let file = world.file("a.csv", format!("{TABLE}x;13;active;1;4;4\n"));
        let report = world.import(MAP, &[file]).unwrap();
        assert_eq!((report.sessions, report.answers), (1, 2));
        assert!(report.to_string().contains("left out: P01 S01, P12 S01"), "{report}");
        assert_eq!(world.load().answers.len(), 8);
    }

    #[test]
    fn which_of_several_repeats_is_answered_must_be_said() {
        let world = world();
        let wall = format!("{MAP}[questions.columns]\nfelt_wall = \"Wall?\"\n");
        let table = "who;mode;order;Wall?;Spring?\n1;active;1;4;2\n1;active;2;5;1\n";
        let file = world.file("a.csv", table);
        world.import(&wall, std::slice::from_ref(&file)).unwrap();
        let spring = format!("{MAP}[questions.columns]\nfelt_spring = \"Spring?\"\n");
        let blind = spring.replace("trial = { column = \"order\" }\n", "");
        world.refuses(&blind, &file, "P01 S01 has 2 trials of spring, active", None);
        world.import(&spring, &[file]).unwrap();
        assert_eq!(world.load().answers.len(), 4);
    }

    #[test]
    fn answers_in_json_are_read_by_their_keys_and_counted_from_any_number() {
        let world = world();
        let map = format!(
            "{}[questions]\nlowest = 0\n[questions.columns]\nfelt_wall = {{ column = \"response\", key = \"Q0\" }}\n\
             felt_spring = {{ column = \"response\", key = \"Q1\" }}\n",
            MAP.replace("\";\"", "\",\"")
        );
        let table = "who,mode,order,response\n1,active,1,\"{\"\"Q0\"\":0,\"\"Q1\"\":\"\"4\"\"}\"\n";
        world.import(&map, &[world.file("a.csv", table)]).unwrap();
        let values: Vec<i16> =
            world.load().answers.iter().filter_map(|a| a.value.whole()).collect();
        assert_eq!(values, [5, 1]);
        let table = |cell: &str| format!("who,mode,order,response\n2,active,1,\"{cell}\"\n");
        let null = "{\"\"Q0\"\":null,\"\"Q1\"\":1}";
        for (cell, words) in [
            ("{\"\"Q0\"\":5,\"\"Q1\"\":1}", "the answer '5' must be a whole number from 0 to 4"),
            ("{\"\"Q0\"\":1}", "has no key 'Q1': it has Q0"),
            ("[1,2]", "is not a JSON object"),
            (null, "must be a whole number from 0 to 4"),
        ] {
            let file = world.file("b.csv", table(cell));
            world.refuses(&map, &file, words, Some(("response", 1)));
        }
        let drop = map.replace("[trial]", "missing = \"drop\"\n[trial]");
        assert_eq!(world.import(&drop, &[world.file("c.csv", table(null))]).unwrap().answers, 1);
    }

    #[test]
    fn bad_answers_and_tables_are_refused_with_column_and_row() {
        let world = world();
        let odd = format!("{MAP}[questions.columns]\nnothing = 5\n");
        let no_question = "'nothing', which is not a question of study.toml";
        let no_mode = "mode 'actve' is not in study.toml";
        for (map, from, to, words, at) in [
            (MAP, "1;4;2", "1;6;2", "the answer '6'", Some(("Wall?", 2))),
            (MAP, "1;4;2", "1;2.5;2", "the answer '2.5'", Some(("Wall?", 2))),
            (MAP, "1;4;2", "1;agree;2", "the answer 'agree'", Some(("Wall?", 2))),
            (MAP, "passive;1", "passive;2", "duplicate trial: trial 2 of P01 S01", None),
            (MAP, "Wall?", "Walls?", "column Wall?: the column is missing", None),
            (MAP, "x;12;", "x;Ann;", "'Ann' is not a whole number", Some(("who", 3))),
            (MAP, "x;12;active", "x;12;actve", no_mode, Some(("mode", 3))),
            (odd.as_str(), "x", "x", no_question, None),
        ] {
            assert!(TABLE.contains(from), "{from}");
            world.refuses(map, &world.file("a.csv", TABLE.replace(from, to)), words, at);
        }
    }
}
