//! From answers to the table of counts.

use crate::counts::Counts;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{AnswerTally, Row};
use zwidth_store::Answer;
use zwidth_study::{
    AnswerScale, AnswerValue, Condition, EnvironmentId, ModeId, ParticipantId, Question,
    QuestionId, Study,
};
use zwidth_tables::{Column, Table, TableError};

/// Why answers could not be tallied.
#[derive(Debug, thiserror::Error)]
pub enum LikertError {
    /// An answer off the scale.
    #[error(
        "{participant} {session} trial {trial}: the answer {value} to '{question}' is not on its scale, {range}"
    )]
    OffScale {
        /// Who.
        participant: String,
        /// Session.
        session: String,
        /// Trial.
        trial: u32,
        /// Question.
        question: QuestionId,
        /// The answer.
        value: AnswerValue,
        /// The answers there are.
        range: String,
    },
    /// An answer to a question, or after a condition, that the study does not have.
    #[error(
        "{what} '{id}' of trial {trial} is not in study.toml: add it there, or mend the answer"
    )]
    Unknown {
        /// `question`, `environment` or `mode`.
        what: &'static str,
        /// Its id.
        id: String,
        /// Trial.
        trial: u32,
    },
    /// An answer to the question which mode it was that was not offered.
    #[error(
        "{participant}: the answer {value} to the question which mode it was is not one of those offered, \
         0 to {choices}"
    )]
    NoMode {
        /// Who.
        participant: ParticipantId,
        /// The answer.
        value: AnswerValue,
        /// How many modes there were to choose from.
        choices: u8,
    },
    /// A number that cannot be.
    #[error(transparent)]
    Stats(#[from] zwidth_stats::StatsError),
    /// The table was refused.
    #[error(transparent)]
    Table(#[from] TableError),
}

type ByQuestion = BTreeMap<(Condition, QuestionId), Counts>;

/// The possible questions, and the environments that ask them, in the order of the study file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Scheme {
    /// The environments.
    pub environments: Vec<EnvironmentId>,
    /// The modes.
    pub modes: Vec<ModeId>,
    /// The questions.
    pub questions: Vec<Question>,
}

impl Scheme {
    /// The scheme of a study.
    pub fn of(study: &Study) -> Self {
        Self {
            environments: study.environments.iter().map(|e| e.id.clone()).collect(),
            modes: study.modes.iter().map(|m| m.id.clone()).collect(),
            questions: study.questions.clone(),
        }
    }

    /// The scales of ratings in use, each once.
    pub(crate) fn scales(&self) -> Vec<AnswerScale> {
        let ratings = self.questions.iter().filter(|q| q.is_rating());
        let scales: BTreeSet<AnswerScale> = ratings.map(|q| q.scale.clone()).collect();
        scales.into_iter().collect()
    }

    /// A column of answers: whole numbers, or for all questions floats if one is a line, whose answers
    /// may have decimals.
    pub(crate) fn answer_column(&self, column: Column) -> Column {
        let Column { mut field, mut values } = column;
        if !self.questions.iter().any(|question| question.scale.is_line()) {
            values = values.in_whole_numbers();
        }
        field.kind = values.kind();
        Column { field, values }
    }

    /// Whether an answer rates what was felt, so that the tally must count it, or refuse it if the
    /// study does not have its question.
    pub fn rates(&self, answer: &Answer) -> bool {
        let question = self.questions.iter().find(|q| q.id == answer.question);
        question.is_none_or(Question::is_rating)
    }

    /// The question which mode it was, if it is asked.
    pub(crate) fn guess(&self) -> Option<&Question> {
        self.questions.iter().find(|q| q.asks_mode())
    }
}

/// The counts, in the order of the study file: for each environment and mode first one row per
/// question, then one row per group. Answers to the question which mode it was, and weights of scores,
/// are in no row.
///
/// # Errors
/// An answer off the scale; a question, environment or mode that the study does not have.
pub fn tally(answers: &[Answer], scheme: &Scheme) -> Result<Vec<AnswerTally>, LikertError> {
    let counts = count(answers, scheme)?;
    let mut rows = Vec::new();
    for environment in &scheme.environments {
        for mode in &scheme.modes {
            let condition = Condition { environment: environment.clone(), mode: mode.clone() };
            let questions = questions(&counts, &condition, scheme);
            for (question, counts) in &questions {
                rows.push(AnswerTally {
                    question: Some(question.id.clone()),
                    group: question.group.clone(),
                    pooled: false,
                    reversed: Some(question.reversed),
                    ..row(&condition, counts)
                });
            }
            for (group, counts) in pooled(&questions) {
                rows.push(AnswerTally {
                    group: Some(group.to_owned()),
                    ..row(&condition, &counts)
                });
            }
        }
    }
    Ok(rows)
}

/// The row of a group's answers, without its name.
fn row(condition: &Condition, counts: &Counts) -> AnswerTally {
    let is_ordinal = counts.scale().is_ordinal();
    let medians = counts.medians();
    // A scale has either counts or quartiles and a mean: a mean of ranks would mean nothing.
    let point = |point: u8| counts.of_point(point).filter(|_| is_ordinal);
    let sum = |value: Option<f64>| value.filter(|_| !is_ordinal);
    AnswerTally {
        environment: condition.environment.clone(),
        mode: condition.mode.clone(),
        question: None,
        group: None,
        pooled: true,
        reversed: None,
        participants: counts.participants.len(),
        n: counts.n(),
        count_1: point(1),
        count_2: point(2),
        count_3: point(3),
        count_4: point(4),
        count_5: point(5),
        count_6: point(6),
        count_7: point(7),
        count_8: point(8),
        count_9: point(9),
        count_10: point(10),
        count_11: point(11),
        median_low: medians.map(|(low, _)| low),
        median_high: medians.map(|(_, high)| high),
        lowest: sum(counts.quantile(0.0)),
        quartile_1: sum(counts.quantile(0.25)),
        quartile_3: sum(counts.quantile(0.75)),
        highest: sum(counts.quantile(1.0)),
        mean: sum(counts.mean()),
        sd: sum(counts.sd()),
    }
}

/// The table of counts. It has a column `count_1`, `count_2`, … for each point of the longest scale
/// that is counted by points, from the lowest answer to the highest (as scored; null beyond the last
/// point of the row's own scale, and on one that is longer). `median_low` and `median_high` are
/// floats where a question is a line. Where a question has more than
/// [`AnswerScale::MOST_CATEGORIES`] points there are also `lowest`, `quartile_1`, `quartile_3`,
/// `highest`, `mean` and `sd` of its answers.
///
/// # Errors
/// A number that is not finite.
pub fn tally_table(rows: &[AnswerTally], scheme: &Scheme) -> Result<Table, TableError> {
    let scales = scheme.scales();
    let ordinal: Vec<&AnswerScale> = scales.iter().filter(|scale| scale.is_ordinal()).collect();
    let points = ordinal.iter().map(|scale| scale.points()).max().unwrap_or_default();
    let mut columns = Vec::new();
    for mut column in AnswerTally::columns(rows) {
        let name = column.field.name.clone();
        let point = (1..).zip(AnswerTally::COUNTS).find(|(_, own)| *own == name);
        match point {
            // No scale of the study is so long: a column of nulls alone would only take room.
            Some((point, _)) if point > points => continue,
            Some((point, _)) => column.field.description = about_point(&ordinal, point).into(),
            None if AnswerTally::MEDIANS.contains(&&*name) => column = scheme.answer_column(column),
            None if AnswerTally::SUMS.contains(&&*name) && ordinal.len() == scales.len() => {
                continue;
            }
            None if name == AnswerTally::REVERSED => {
                column.field.description = format!(
                    "whether agreement speaks against, so that a counts as {}; null where pooled",
                    turned(&scales)
                )
                .into();
            }
            None => {}
        }
        columns.push(column);
    }
    let names: Vec<String> = scales.iter().map(AnswerScale::name).collect();
    let caption = format!(
        "{} on the {} (reversed questions scored {})",
        AnswerTally::TITLE,
        names.join(" and the "),
        turned(&scales)
    );
    let table = Table::new(AnswerTally::NAME, &caption, columns)?;
    Ok(if scales.iter().all(AnswerScale::is_ordinal) {
        table
    } else {
        table.with_note(format!(
            "On a scale of more than {} points answers are a quantity: quartiles and mean stand in the place of \
             counts.",
            AnswerScale::MOST_CATEGORIES
        ))
    })
}

fn count(answers: &[Answer], scheme: &Scheme) -> Result<ByQuestion, LikertError> {
    let mut counts = ByQuestion::new();
    for answer in answers {
        let question = check(answer, scheme)?;
        // Which mode somebody guessed is a name: `blinding` counts those. Weights belong to scores.
        if !question.is_rating() {
            continue;
        }
        let scored = question.scale.score(answer.value, question.reversed);
        let key = (answer.condition.clone(), answer.question.clone());
        let counts = counts.entry(key).or_insert_with(|| Counts::on(&question.scale));
        counts.add(scored, &answer.participant);
    }
    Ok(counts)
}

/// The answer's question, if the answer and all it refers to are there.
fn check<'s>(answer: &Answer, scheme: &'s Scheme) -> Result<&'s Question, LikertError> {
    let unknown =
        |what, id: &str| LikertError::Unknown { what, id: id.to_owned(), trial: answer.trial };
    let Condition { environment, mode } = &answer.condition;
    if !scheme.environments.contains(environment) {
        return Err(unknown("environment", environment.as_str()));
    }
    if !scheme.modes.contains(mode) {
        return Err(unknown("mode", mode.as_str()));
    }
    let question = scheme.questions.iter().find(|q| q.id == answer.question);
    let question = question.ok_or_else(|| unknown("question", answer.question.as_str()))?;
    if !question.scale.has(answer.value) {
        return Err(LikertError::OffScale {
            participant: answer.participant.to_string(),
            session: answer.session.to_string(),
            trial: answer.trial,
            question: answer.question.clone(),
            value: answer.value,
            range: question.scale.range(),
        });
    }
    Ok(question)
}

/// The questions answered after `condition`, in the study's order.
fn questions<'s, 'c>(
    counts: &'c ByQuestion,
    condition: &Condition,
    scheme: &'s Scheme,
) -> Vec<(&'s Question, &'c Counts)> {
    scheme
        .questions
        .iter()
        .filter_map(|q| Some((q, counts.get(&(condition.clone(), q.id.clone()))?)))
        .collect()
}

/// The groups of the questions, in the order of their first one, each with its questions' answers
/// together.
fn pooled<'s>(questions: &[(&'s Question, &Counts)]) -> Vec<(&'s str, Counts)> {
    let mut groups: Vec<(&str, Counts)> = Vec::new();
    for (question, counts) in questions {
        let Some(group) = question.group.as_deref() else {
            continue;
        };
        let at = groups.iter().position(|(g, _)| *g == group).unwrap_or_else(|| {
            groups.push((group, Counts::on(&question.scale)));
            groups.len() - 1
        });
        groups[at].1.merge(counts);
    }
    groups
}

/// How a reversed answer a is turned round.
fn turned(scales: &[AnswerScale]) -> String {
    match scales {
        [only] => format!("{} - a", only.ends_together()),
        _ => "lowest + highest - a".to_owned(),
    }
}

/// What the count of a point counts, on the scales that have it.
fn about_point(scales: &[&AnswerScale], point: u8) -> String {
    let here = scales.iter().filter(|scale| point <= scale.points());
    let numbered = here.clone().all(|scale| scale.answer_at(point) == i16::from(point));
    let words: Vec<String> = here
        .filter_map(|scale| match numbered {
            true => scale.word(i16::from(point)).map(str::to_owned),
            false => Some(scale.worded(scale.answer_at(point))),
        })
        .collect();
    let which =
        if numbered { format!("answers {point}") } else { format!("answers at point {point}") };
    let colon = if words.is_empty() { "" } else { ": " };
    format!("{which} as scored{colon}{}", words.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::answer;

    /// The template's study with three questions: q1 and q2 (reversed) in a group, q3 alone.
    fn scheme() -> Scheme {
        let mut study = zwidth_testing::study();
        let question = |id: &str, group: Option<&str>, reversed| Question {
            id: QuestionId::new(id).unwrap(),
            text: String::new(),
            group: group.map(str::to_owned),
            scale: AnswerScale::FivePoint,
            reversed,
            label: None,
            is_weight: false,
        };
        study.questions = vec![
            question("q1", Some("ease"), false),
            question("q2", Some("ease"), true),
            question("q3", None, false),
        ];
        Scheme::of(&study)
    }

    /// The table of some answers.
    fn table_of(answers: &[Answer]) -> Table {
        tally_table(&tally(answers, &scheme()).unwrap(), &scheme()).unwrap()
    }

    fn texts(table: &Table, column: &str) -> Vec<String> {
        table.texts(column).unwrap().into_iter().map(Option::unwrap_or_default).collect()
    }

    fn numbers(table: &Table, column: &str) -> Vec<i64> {
        table.integers(column).unwrap().into_iter().map(Option::unwrap).collect()
    }

    #[test]
    fn questions_and_then_groups_are_counted_in_the_order_of_the_study() {
        let answers = [
            answer("P02", "hybrid", "q3", 1),
            answer("P01", "active", "q2", 1),
            answer("P01", "active", "q1", 4),
            answer("P02", "active", "q1", 2),
        ];
        let rows = tally(&answers, &scheme()).unwrap();
        let table = tally_table(&rows, &scheme()).unwrap();
        assert_eq!(table.to_rows::<AnswerTally>().unwrap(), rows);
        assert_eq!(texts(&table, "mode"), ["active", "active", "active", "hybrid"]);
        assert_eq!(texts(&table, "question"), ["q1", "q2", "", "q3"]);
        assert_eq!(texts(&table, "group"), ["ease", "ease", "ease", ""]);
        assert_eq!(
            table.flags("pooled").unwrap(),
            [Some(false), Some(false), Some(true), Some(false)]
        );
        assert_eq!(table.flags("reversed").unwrap(), [Some(false), Some(true), None, Some(false)]);
        assert_eq!(numbers(&table, "n"), [2, 1, 3, 1]);
        assert_eq!(numbers(&table, "participants"), [2, 1, 2, 1]);
        assert_eq!(numbers(&table, "count_1"), [0, 0, 0, 1]);
        assert_eq!(
            numbers(&table, "count_5"),
            [0, 1, 1, 0],
            "1 to a reversed question counts as 5"
        );
        assert_eq!(numbers(&table, "median_low"), [2, 5, 4, 1]);
        assert_eq!(numbers(&table, "median_high"), [4, 5, 4, 1]);
    }

    #[test]
    fn what_nobody_answered_has_no_row_and_is_not_zero() {
        assert!(tally(&[], &scheme()).unwrap().is_empty());
        let table = table_of(&[answer("P01", "passive", "q3", 3)]);
        assert_eq!((table.height(), numbers(&table, "count_3")), (1, vec![1]));
    }

    #[test]
    fn the_order_of_the_answers_does_not_matter() {
        let mut answers: Vec<_> = (1..=5_i16).map(|v| answer("P01", "active", "q1", v)).collect();
        let forward = tally(&answers, &scheme()).unwrap();
        answers.reverse();
        assert_eq!(tally(&answers, &scheme()).unwrap(), forward);
    }

    #[test]
    fn answers_that_cannot_be_are_refused_by_name() {
        for (answer, words) in [
            (answer("P01", "active", "q1", 0), "the answer 0 to 'q1'"),
            (answer("P01", "active", "q1", 6), "the answer 6 to 'q1'"),
            (answer("P01", "sealed-3", "q1", 3), "mode 'sealed-3' of trial 7"),
            (answer("P01", "active", "q9", 3), "question 'q9' of trial 7"),
        ] {
            let error = tally(&[answer], &scheme()).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
