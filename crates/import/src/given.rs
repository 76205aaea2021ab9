//! The answers of a questionnaire, cell by cell: as numbers of their scales, with the time that
//! each took.

use super::context::Context;
use super::errors::Errors;
use super::identity::{Identity, answer};
use super::mapping::{Missing, Questionnaire};
use super::recording::Recording;
use super::report::FileReport;
use super::spelling::{find, plain};
use super::unit::Unit;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::StoreError;
use zwidth_study::{AnswerScale, AnswerValue, QuestionId};

/// No answer takes longer, s: a day.
const LONGEST_S: f64 = 86_400.0;

/// An answer as a table has it, and what it took, ms, where that was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Answer {
    pub(super) value: AnswerValue,
    pub(super) time_ms: Option<u32>,
}

/// A trial without samples, and what was answered.
pub(super) struct Answered {
    pub(super) identity: Identity,
    pub(super) answers: Vec<(QuestionId, Answer)>,
}

/// Where an answer stands: its row, its column, the key of the object in that cell if it is JSON, and the
/// column of the time that it took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) row: usize,
    pub(super) answer: usize,
    pub(super) key: Option<&'a str>,
    pub(super) time: Option<usize>,
}

/// The answer to a question; `None` where the cell is empty and the mapping leaves such cells out.
pub(super) fn read_answer(
    context: &Context,
    questionnaire: &Questionnaire,
    recording: &Recording,
    question: &QuestionId,
    place: Place,
) -> Result<Option<Answer>, Errors> {
    let Place { row, answer: column, key, time } = place;
    let remedy = "mend the cell; leave empty ones out with missing = \"drop\" in [file], and name words in \
                  [questions.translate]";
    let wrong = |what: String| recording.cell_error(column, row, &what, remedy);
    let raw = recording.table.columns[column].cell(row);
    let cell = raw.to_string();
    let decimal_comma = recording.has_decimal_comma(column, row);
    let (cell, is_empty) = match key {
        Some(key) if !cell.trim().is_empty() => {
            let text = value_of(&cell, key).map_err(wrong)?;
            let is_empty = text.is_none();
            (text.unwrap_or_default(), is_empty)
        }
        _ => (cell, recording.number(column, row) == Ok(None)),
    };
    let word = find(&questionnaire.translate, cell.trim());
    // A word of the scale comes first: "NA" may be an answer.
    if recording.form_of(column).missing == Missing::Drop && word.is_none() && is_empty {
        return Ok(None);
    }
    let scale = context.study.question(question).map(|q| q.scale.clone()).unwrap_or_default();
    let value = match (word, questionnaire.lowest) {
        (Some(value), _) => answer(&value.to_string(), false, &scale),
        (None, Some(lowest)) => answer_from(lowest, &cell, &scale),
        // JSON writes a dot.
        (None, None) => answer(&cell, decimal_comma && key.is_none(), &scale),
    };
    let value = value.map_err(wrong)?;
    let time_ms = match time {
        Some(time) => read_time(questionnaire.time_unit, recording, time, row)?,
        None => None,
    };
    Ok(Some(Answer { value, time_ms }))
}

/// Tells how many answers lie in the middle of a line, where a slider that nobody touched stays: jsPsych and others write
/// it as an answer.
pub(super) fn tell_middles<'a>(
    context: &Context,
    report: &mut FileReport,
    answers: impl Iterator<Item = &'a (QuestionId, Answer)>,
) {
    let mut middles: BTreeMap<&QuestionId, (f64, usize)> = BTreeMap::new();
    for (id, answer) in answers {
        let scale = context.study.question(id).map(|question| &question.scale);
        let Some(scale) = scale.filter(|scale| scale.is_line()) else { continue };
        let length = f64::from(scale.points() - 1) * f64::from(scale.step());
        let middle = f64::from(scale.lowest()) + length / 2.0;
        if answer.value.get().to_bits() == middle.to_bits() {
            middles.entry(id).or_insert((middle, 0)).1 += 1;
        }
    }
    report.told.extend(middles.into_iter().map(|(id, (middle, n))| {
        format!("{n} answers to '{id}' are {middle}, the middle, where a slider that nobody touched stays")
    }));
}

/// The value under a key of the JSON object in a cell; `None` if there is none.
fn value_of(cell: &str, key: &str) -> Result<Option<String>, String> {
    let object: serde_json::Map<String, serde_json::Value> = serde_json::from_str(cell)
        .map_err(|why| format!("'{cell}' is not a JSON object: {why}"))?;
    match object.get(key) {
        None => {
            let keys: Vec<&str> = object.keys().map(String::as_str).collect();
            Err(format!("the object has no key '{key}': it has {}", keys.join(", ")))
        }
        Some(serde_json::Value::Null) => Ok(None),
        Some(serde_json::Value::String(text)) => Ok(Some(text.clone()).filter(|t| !t.is_empty())),
        Some(value) => Ok(Some(value.to_string())),
    }
}

/// The answer of a number that counts the places of the scale from `lowest` on; on a line also between
/// them.
fn answer_from(lowest: i64, text: &str, scale: &AnswerScale) -> Result<AnswerValue, String> {
    let above = plain(text).parse::<f64>().ok().map(|number| number - lowest as f64);
    let answer = above.and_then(|above| {
        AnswerValue::new(f64::from(scale.lowest()) + above * f64::from(scale.step())).ok()
    });
    answer.filter(|answer| scale.has(*answer)).ok_or_else(|| {
        let number = if scale.is_line() { "a number" } else { "a whole number" };
        let highest = lowest + i64::from(scale.points()) - 1;
        format!(
            "the answer '{text}' must be {number} from {lowest} to {highest} (lowest = {lowest})"
        )
    })
}

/// The time that an answer took, ms; `None` if the cell is empty.
pub(super) fn read_time(
    unit: Option<&Unit>,
    recording: &Recording,
    column: usize,
    row: usize,
) -> Result<Option<u32>, StoreError> {
    let time_ms = recording.number(column, row).and_then(|time| {
        let Some(time) = time else { return Ok(None) };
        let time_s = time * unit.map_or(1.0, |unit| unit.to_si);
        // A day of milliseconds is far from the highest number.
        if (0.0..=LONGEST_S).contains(&time_s) {
            return Ok(Some((time_s * 1e3).round() as u32));
        }
        Err(format!("an answer cannot take {time_s} s: from 0 to {LONGEST_S}"))
    });
    time_ms.map_err(|what| {
        recording.cell_error(column, row, &what, "mend the cell, or check time_unit")
    })
}

/// The answers read from a table.
pub(super) struct Read {
    pub(super) trials: Vec<Answered>,
    pub(super) report: FileReport,
    /// The columns of its answers, counted from 1.
    pub(super) columns: BTreeSet<usize>,
    /// Answers that are missing.
    pub(super) empty: usize,
}
