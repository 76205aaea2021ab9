//! The answers as a long table: one row per answer.

use crate::Scheme;
use zwidth_store::{Answer, LeftOutAnswer};
use zwidth_study::{AnswerScale, Question};
use zwidth_tables::{Column, Table, TableError};

/// Name of the column that says whether an answer counts.
pub const COUNTS: &str = "counts";

/// The answers as they were given (reversed questions too), one row each, by participant, session,
/// trial and question: those that count, and the others. Columns: `participant`, `session`, `trial`,
/// `environment`, `mode`, `question`, `answer` (floats where a question is a line), where one was
/// measured `answer_time_s`, `counts` and `why_not`.
///
/// # Errors
/// None that answers can cause.
pub fn long(
    counting: &[Answer],
    left_out: &[LeftOutAnswer],
    scheme: &Scheme,
) -> Result<Table, TableError> {
    let others = left_out.iter().map(|other| (&other.answer, Some(other.why_not.as_str())));
    let mut rows: Vec<(&Answer, Option<&str>)> =
        others.chain(counting.iter().map(|answer| (answer, None))).collect();
    // Of one question the answers stay in the order in which they were given: the last may count.
    rows.sort_by_key(|(a, _)| (&a.participant, &a.session, a.trial, &a.question));
    let (answers, why_not): (Vec<&Answer>, Vec<Option<&str>>) = rows.into_iter().unzip();
    let text = |name: &'static str, about: &'static str, of: fn(&Answer) -> &str| {
        Column::text(name, about, answers.iter().map(|&answer| Some(of(answer))))
    };
    let trials = answers.iter().map(|answer| Some(answer.trial.into()));
    let values = answers.iter().map(|answer| Some(answer.value));
    let mut answer = scheme.answer_column("answer", "", values);
    let scales = scheme.scales();
    let lowest = scales.iter().map(AnswerScale::lowest).min().unwrap_or_default();
    let highest = scales.iter().map(AnswerScale::highest).max().unwrap_or_default();
    let rated = (!scales.is_empty()).then(|| format!("{lowest}…{highest}"));
    let ranges: Vec<String> = rated.into_iter().chain(scheme.guess().map(guessed)).collect();
    answer.field.description = format!("the answer as given, {}", ranges.join("; ")).into();
    let mut columns = vec![
        text("participant", "who", |a| a.participant.as_str()),
        text("session", "in which session", |a| a.session.as_str()),
        Column::integer("trial", "1", "after which trial of the session", trials),
        text("environment", "what was rendered", |a| a.condition.environment.as_str()),
        text("mode", "how it was rendered; a code while the session is sealed", |a| {
            a.condition.mode.as_str()
        }),
        text("question", "the question", |a| a.question.as_str()),
        answer,
    ];
    if answers.iter().any(|answer| answer.time_ms.is_some()) {
        let times = answers.iter().map(|answer| answer.time_ms.map(|ms| f64::from(ms) / 1e3));
        let about = "from the question to its answer; null where it was not measured";
        columns.push(Column::float("answer_time_s", "s", about, times));
    }
    let counts = why_not.iter().map(|why_not| Some(why_not.is_none()));
    columns.push(Column::flag(COUNTS, "whether it enters any tally, mean or test", counts));
    columns.push(Column::text("why_not", "why it does not count; null if it does", why_not));
    let table = Table::new("answers", "Answers as given, one row per answer", columns)?;
    Ok(table
        .with_note("Every answer that was given. One that does not count is in no other table."))
}

/// The answers to the question which mode it was: `to guess 0 (do not know), 1 (Active), …`.
fn guessed(question: &Question) -> String {
    let Question { id, scale, .. } = question;
    let answers: Vec<String> = scale.answers().into_iter().map(|a| scale.worded(a)).collect();
    format!("to {id} {}", answers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::Condition;

    #[test]
    fn every_answer_is_a_row_with_its_question() {
        let answer = |question: &str, value: i16| Answer {
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial: 3,
            condition: Condition {
                environment: "spring".parse().unwrap(),
                mode: "hybrid".parse().unwrap(),
            },
            question: question.parse().unwrap(),
            value: value.into(),
            time_ms: None,
        };
        let study = zwidth_testing::study();
        let scheme = Scheme::of(&study);
        let table = long(&[answer("felt", 4), answer("liked", 2)], &[], &scheme).unwrap();
        assert!(table.notes()[0].starts_with("Every answer that was given."));
        assert_eq!(table.columns()[6].field.description, "the answer as given, 1…5");
        let questions = ["felt", "liked"].map(|q| Some(q.to_owned()));
        assert_eq!(table.texts("question").unwrap(), questions);
        assert_eq!(table.integers("answer").unwrap(), [Some(4), Some(2)]);
        assert_eq!(table.integers("trial").unwrap(), [Some(3), Some(3)]);
        assert!(table.column("answer_time_s").is_err());
        let timed = Answer { time_ms: Some(2500), ..answer("felt", 4) };
        let table = long(&[timed, answer("liked", 2)], &[], &scheme).unwrap();
        assert_eq!(table.floats("answer_time_s").unwrap(), [Some(2.5), None]);
        let why_not = "a later answer took its place".to_owned();
        let first = LeftOutAnswer { answer: answer("felt", 1), why_not: why_not.clone() };
        let table = long(&[answer("felt", 4), answer("liked", 2)], &[first], &scheme).unwrap();
        assert_eq!(table.integers("answer").unwrap(), [1, 4, 2].map(Some));
        assert_eq!(table.flags(COUNTS).unwrap(), [false, true, true].map(Some));
        assert_eq!(table.texts("why_not").unwrap(), [Some(why_not), None, None]);
    }
}
