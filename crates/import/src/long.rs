//! Long questionnaire tables, with one row per answer → trials without samples, each with its
//! answers.

use super::context::{Context, EMPTY};
use super::errors::{Errors, all, append};
use super::given::{Answer, Answered, Place, Read, read_answer};
use super::identity::{Identity, Named, identity};
use super::label::Label;
use super::limits::Budget;
use super::mapping::{LongForm, Questionnaire, Who};
use super::recording::Recording;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use zwidth_store::StoreError;
use zwidth_study::QuestionId;

/// The answers of a file, in the order in which each trial's first one stands. Rows with the same
/// labels are one trial, wherever they stand.
pub(super) fn convert(
    context: &Context,
    questionnaire: &Questionnaire,
    (who, form): &(Who, LongForm),
    budget: &Budget,
    recording: &Recording,
) -> Result<Read, Errors> {
    let labels = who.columns().into_iter().chain(form.question.column());
    let labels = all(labels.map(|column| recording.find(column)))?;
    let answer = recording.find(&form.answer)?;
    let time = form.time.as_ref().map(|column| recording.find(column)).transpose()?;
    let used = [labels.clone(), vec![answer], time.into_iter().collect()].concat();
    let mut rows = recording.rows(&context.mapping.file, &[], &labels)?;
    let headers = recording.leave_out_headers(&mut rows, &used);
    let mut trials: Vec<Answered> = Vec::new();
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut errors = Errors::default();
    let mut named = Named::default();
    let mut answers = 0;
    for row in &rows.kept {
        let place = Place { row: *row, answer, key: None, time };
        match read_row(context, who, questionnaire, &form.question, recording, place) {
            Ok((identity, Some((question, answer)))) => {
                if let Err(other) = named.add(recording, *row, &identity) {
                    errors.push(other);
                    continue;
                }
                let at = *places.entry(key(&identity)).or_insert_with(|| {
                    trials.push(Answered { identity, answers: Vec::new() });
                    trials.len() - 1
                });
                if trials[at].answers.iter().any(|(other, _)| *other == question) {
                    let what = format!("question '{question}' is answered twice after one trial");
                    let remedy = "tell the trials apart by a column: trial or repeat in [trial]; or leave a row out";
                    errors.push(recording.cell_error(place.answer, *row, &what, remedy));
                    continue;
                }
                trials[at].answers.push((question, answer));
                answers += 1;
            }
            Ok((_, None)) => {}
            Err(wrong) => append(&mut errors, wrong),
        }
    }
    errors.none()?;
    // Known only now: rows with the same labels are one trial.
    budget.trials(&recording.path, trials.len())?;
    let mut report = context.file_report(recording, &rows, rows.kept.len(), &used)?;
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, EMPTY);
    report.add_headers(headers);
    let timed = if time.is_some() { ", with the time that each took" } else { "" };
    report.converted.push(format!("answers, as given, one row each{timed}"));
    let columns = BTreeSet::from([answer + 1]);
    Ok(Read { trials, report, columns, empty: rows.kept.len() - answers })
}

type Row = (Identity, Option<(QuestionId, Answer)>);

/// Whose answer a row is, to what, and what it is; no answer where the cell is empty.
fn read_row(
    context: &Context,
    who: &Who,
    questionnaire: &Questionnaire,
    question: &Label,
    recording: &Recording,
    place: Place,
) -> Result<Row, Errors> {
    let identity = identity(who, recording, place.row, context.study)?;
    let question = question.value("question", recording, place.row, |text| {
        let id: QuestionId = super::identity::id(text)?;
        if context.study.question(&id).is_some() {
            return Ok(id);
        }
        let questions: Vec<&str> = context.study.questions.iter().map(|q| q.id.as_str()).collect();
        Err(format!("question '{id}' is not in study.toml, which has {}", questions.join(", ")))
    })?;
    let answer = read_answer(context, questionnaire, recording, &question, place)?;
    Ok((identity, answer.map(|answer| (question, answer))))
}

/// The key of a trial: rows with the same labels are one trial.
fn key(identity: &Identity) -> String {
    let Identity { participant, session, environment, mode, kind, repeat, trial, .. } = identity;
    // No id holds a blank.
    format!("{participant} {session} {environment} {mode} {} {repeat:?} {trial:?}", kind.as_str())
}

/// Checks that no two files have answers to one trial: they would count as two repeats.
pub(super) fn apart(files: &[&[Answered]]) -> Result<(), Errors> {
    let mut seen: BTreeMap<String, &Path> = BTreeMap::new();
    let twice = files.iter().flat_map(|trials| trials.iter()).filter_map(|answered| {
        let identity = &answered.identity;
        let first = seen.insert(key(identity), &identity.file)?;
        let what = format!(
            "{} {} {} {} is in {} too",
            identity.participant, identity.session, identity.environment, identity.mode, first.display()
        );
        let remedy = "put the answers to one trial into one file, or tell the trials apart by trial or repeat \
                      in [trial]";
        Some(StoreError::new(&identity.file, what, remedy))
    });
    twice.collect::<Errors>().none()
}
