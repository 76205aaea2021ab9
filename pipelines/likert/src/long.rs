//! The answers as a long table: one row per answer.

use crate::Scheme;
use zwidth_results::{GivenAnswer, Row};
use zwidth_store::{Answer, LeftOutAnswer};
use zwidth_study::{AnswerScale, Question};
use zwidth_tables::{Table, TableError};

/// The answers as they were given (reversed questions too), one row each, by participant, session,
/// trial and question: those that count, and the others with the reason.
pub fn long(counting: &[Answer], left_out: &[LeftOutAnswer]) -> Vec<GivenAnswer> {
    let others = left_out.iter().map(|other| (&other.answer, Some(&other.why_not)));
    let all = others.chain(counting.iter().map(|answer| (answer, None)));
    let rows = all.map(|(answer, why_not)| GivenAnswer {
        participant: answer.participant.clone(),
        session: answer.session.clone(),
        trial: answer.trial,
        environment: answer.condition.environment.clone(),
        mode: answer.condition.mode.clone(),
        question: answer.question.clone(),
        answer: answer.value,
        answer_time_s: answer.time_ms.map(|ms| f64::from(ms) / 1e3),
        counts: why_not.is_none(),
        why_not: why_not.cloned(),
    });
    let mut rows: Vec<GivenAnswer> = rows.collect();
    // Of one question the answers stay in the order in which they were given: the last may count.
    rows.sort_by_cached_key(|row| {
        (row.participant.clone(), row.session.clone(), row.trial, row.question.clone())
    });
    rows
}

/// The same as a table: answers are floats where a question is a line, and times are there where one
/// was measured.
///
/// # Errors
/// None that answers can cause.
pub fn long_table(rows: &[GivenAnswer], scheme: &Scheme) -> Result<Table, TableError> {
    let scales = scheme.scales();
    let lowest = scales.iter().map(AnswerScale::lowest).min().unwrap_or_default();
    let highest = scales.iter().map(AnswerScale::highest).max().unwrap_or_default();
    let rated = (!scales.is_empty()).then(|| format!("{lowest}…{highest}"));
    // The answers to the question which mode it was are names: `to guess 0 (do not know), 1 (Active), …`.
    let guessed = scheme.guess().map(|Question { id, scale, .. }| {
        let answers: Vec<String> = scale.answers().into_iter().map(|a| scale.worded(a)).collect();
        format!("to {id} {}", answers.join(", "))
    });
    let ranges: Vec<String> = rated.into_iter().chain(guessed).collect();
    let is_timed = rows.iter().any(|row| row.answer_time_s.is_some());
    let mut columns = GivenAnswer::columns(rows);
    columns.retain(|column| is_timed || column.field.name != GivenAnswer::TIME);
    for column in columns.iter_mut().filter(|column| column.field.name == GivenAnswer::ANSWER) {
        *column = scheme.answer_column(column.clone());
        let about = &mut column.field.description;
        *about = format!("{about}, {}", ranges.join("; ")).into();
    }
    let table = Table::new(GivenAnswer::NAME, GivenAnswer::TITLE, columns)?;
    Ok(table
        .with_note("Every answer that was given. One that does not count is in no other table."))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_answer_is_a_row_with_its_question() {
        let answer = |question, value: i16| crate::tests::answer("P01", "hybrid", question, value);
        let study = zwidth_testing::study();
        let scheme = Scheme::of(&study);
        let rows = long(&[answer("felt", 4), answer("liked", 2)], &[]);
        let table = long_table(&rows, &scheme).unwrap();
        assert_eq!(table.to_rows::<GivenAnswer>().unwrap(), rows);
        assert!(table.notes()[0].starts_with("Every answer that was given."));
        assert_eq!(table.columns()[6].field.description, "the answer as given, 1…5");
        let questions = ["felt", "liked"].map(|q| Some(q.to_owned()));
        assert_eq!(table.texts("question").unwrap(), questions);
        assert_eq!(table.integers("answer").unwrap(), [Some(4), Some(2)]);
        assert_eq!(table.integers("trial").unwrap(), [Some(7), Some(7)]);
        assert!(table.column("answer_time_s").is_err());
        let timed = Answer { time_ms: Some(2500), ..answer("felt", 4) };
        let table = long_table(&long(&[timed, answer("liked", 2)], &[]), &scheme).unwrap();
        assert_eq!(table.floats("answer_time_s").unwrap(), [Some(2.5), None]);
        let why_not = "a later answer took its place".to_owned();
        let first = LeftOutAnswer { answer: answer("felt", 1), why_not: why_not.clone() };
        let rows = long(&[answer("felt", 4), answer("liked", 2)], &[first]);
        let table = long_table(&rows, &scheme).unwrap();
        assert_eq!(table.integers("answer").unwrap(), [1, 4, 2].map(Some));
        assert_eq!(table.flags("counts").unwrap(), [false, true, true].map(Some));
        assert_eq!(table.texts("why_not").unwrap(), [Some(why_not), None, None]);
    }
}
