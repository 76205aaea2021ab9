//! The answers of a questionnaire, cell by cell: as numbers of their scales, with what each took.

use super::identity::{Identity, answer};
use super::mapping::{Missing, Questionnaire};
use super::recording::Recording;
use super::spelling::find;
use super::{Context, Errors};
use zwidth_store::StoreError;
use zwidth_study::{AnswerValue, QuestionId};

/// No answer takes longer, s: a day.
const LONGEST_S: f64 = 86_400.0;

/// An answer as a table has it, and what it took, ms, where that was measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Given {
    pub(super) value: AnswerValue,
    pub(super) time_ms: Option<u32>,
}

/// A trial without samples, and what was answered.
pub(super) struct Answered {
    pub(super) identity: Identity,
    pub(super) answers: Vec<(QuestionId, Given)>,
}

/// Where an answer stands: its row, its column, and the column of the time that it took.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) row: usize,
    pub(super) answer: usize,
    pub(super) time: Option<usize>,
}

/// The answer to a question; `None` where the cell is empty and the mapping leaves such cells out.
pub(super) fn read_given(
    context: &Context,
    asked: &Questionnaire,
    recording: &Recording,
    question: &QuestionId,
    place: Place,
) -> Result<Option<Given>, Errors> {
    let Place { row, answer: column, time } = place;
    let cell = recording.table.columns[column].cell(row);
    let text = cell.to_string();
    let word = find(&asked.translate, text.trim());
    // A word of the scale comes first: "NA" may be an answer.
    let is_missing = word.is_none() && recording.number(column, row) == Ok(None);
    if context.mapping.file.cells.missing == Missing::Drop && is_missing {
        return Ok(None);
    }
    let remedy = "mend the cell; leave empty ones out with missing = \"drop\" in [file], and name words in \
                  [questions.translate]";
    let scale = context.study.question(question).map(|q| q.scale.clone()).unwrap_or_default();
    let value = match word {
        Some(value) => answer(&value.to_string(), false, &scale),
        None => answer(&text, recording.has_decimal_comma(&cell), &scale),
    };
    let value = value.map_err(|what| recording.cell_error(column, row, &what, remedy))?;
    let time_ms = match time {
        Some(time) => read_time(asked, recording, time, row)?,
        None => None,
    };
    Ok(Some(Given { value, time_ms }))
}

/// What an answer took, ms; `None` where the cell is empty.
fn read_time(
    asked: &Questionnaire,
    recording: &Recording,
    column: usize,
    row: usize,
) -> Result<Option<u32>, StoreError> {
    let wrong = |what: String| {
        recording.cell_error(column, row, &what, "mend the cell, or check time_unit")
    };
    let Some(theirs) = recording.number(column, row).map_err(wrong)? else { return Ok(None) };
    let time_s = theirs * asked.time_unit.map_or(1.0, |unit| unit.to_si);
    // A day of milliseconds is far from the highest number.
    if (0.0..=LONGEST_S).contains(&time_s) {
        return Ok(Some((time_s * 1e3).round() as u32));
    }
    Err(wrong(format!("an answer cannot take {time_s} s: from 0 to {LONGEST_S}")))
}
