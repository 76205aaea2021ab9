//! The answers as a long table: one row per answer.

use crate::Scheme;
use zwidth_store::Answer;
use zwidth_study::{AnswerScale, Question};
use zwidth_tables::{Column, Table, TableError};

/// The answers as they were given (reversed questions too), one row each, in their order. Columns:
/// `participant`, `session`, `trial`, `environment`, `mode`, `question`, `answer` (floats where a
/// question is a line), and where one was measured `answer_time_s`.
///
/// # Errors
/// None that answers can cause.
pub fn long(answers: &[Answer], scheme: &Scheme) -> Result<Table, TableError> {
    let text = |name: &'static str, about: &'static str, of: fn(&Answer) -> &str| {
        Column::text(name, about, answers.iter().map(|answer| Some(of(answer))))
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
        text("mode", "how it was rendered", |a| a.condition.mode.as_str()),
        text("question", "the question", |a| a.question.as_str()),
        answer,
    ];
    if answers.iter().any(|answer| answer.time_ms.is_some()) {
        let times = answers.iter().map(|answer| answer.time_ms.map(|ms| f64::from(ms) / 1e3));
        let about = "from the question to its answer; null where it was not measured";
        columns.push(Column::float("answer_time_s", "s", about, times));
    }
    let table = Table::new("answers", "Answers as given, one row per answer", columns)?;
    Ok(table.with_note(
        "Every answer that counts. Which trials do not count, and why, stands in trials.parquet.",
    ))
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
        let table = long(&[answer("felt", 4), answer("liked", 2)], &scheme).unwrap();
        assert!(table.notes()[0].starts_with("Every answer that counts."));
        assert_eq!(table.columns()[6].field.description, "the answer as given, 1…5");
        let questions = ["felt", "liked"].map(|q| Some(q.to_owned()));
        assert_eq!(table.texts("question").unwrap(), questions);
        assert_eq!(table.integers("answer").unwrap(), [Some(4), Some(2)]);
        assert_eq!(table.integers("trial").unwrap(), [Some(3), Some(3)]);
        assert!(table.column("answer_time_s").is_err());
        let timed = Answer { time_ms: Some(2500), ..answer("felt", 4) };
        let table = long(&[timed, answer("liked", 2)], &scheme).unwrap();
        assert_eq!(table.floats("answer_time_s").unwrap(), [Some(2.5), None]);
    }
}
