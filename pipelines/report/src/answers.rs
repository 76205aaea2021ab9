//! The answers to an environment's question: their median, and one mode's against another's.

use std::collections::BTreeMap;
use zwidth_study::{AnswerScale, AnswerValue, Environment, Mode, Question, QuestionId, Setup};
use zwidth_tables::{Table, TableError, number};

/// The median of a mode's answers.
pub(crate) struct Median {
    pub(crate) scale: AnswerScale,
    /// The two middle answers, as scored.
    pub(crate) low: AnswerValue,
    pub(crate) high: AnswerValue,
    pub(crate) answers: i64,
    pub(crate) participants: i64,
}

impl Median {
    /// The median of the answers as they were given: the tally turns those to a question that
    /// counts the other way round.
    pub(crate) fn turned_back(self, question: &Question) -> Self {
        let [low, high] =
            [self.low, self.high].map(|answer| self.scale.score(answer, question.reversed));
        match question.reversed {
            true => Self { low: high, high: low, ..self },
            false => self,
        }
    }

    /// `4 (agree)`, or `3 to 4` where the two middle answers differ. What has decimals is rounded.
    pub(crate) fn words(&self) -> String {
        let shown = |answer: AnswerValue| match answer.whole() {
            Some(whole) => whole.to_string(),
            None => number(answer.get(), None),
        };
        match self.low.whole() {
            _ if self.low != self.high => format!("{} to {}", shown(self.low), shown(self.high)),
            Some(whole) => self.scale.worded(whole),
            None => shown(self.low),
        }
    }
}

/// The environment's question, of which the statements speak: the first that is a rating.
pub(crate) fn question_of<'s>(study: &'s Setup, environment: &Environment) -> Option<&'s Question> {
    let rated = |id: &QuestionId| study.questions.iter().find(|q| q.id == *id && q.is_rating());
    environment.questions().find_map(rated)
}

/// The median answer to the environment's question in a mode, by the tally; `None` without a
/// question or an answer.
pub(crate) fn median(
    study: &Setup,
    tally: &Table,
    environment: &Environment,
    mode: &Mode,
) -> Result<Option<Median>, TableError> {
    let Some(question) = question_of(study, environment) else { return Ok(None) };
    median_of(study, tally, [environment.id.as_str(), mode.id.as_str()], &question.id)
}

/// The median answer to any question in an environment and a mode; `None` without an answer.
pub(crate) fn median_of(
    study: &Setup,
    tally: &Table,
    [environment, mode]: [&str; 2],
    question: &QuestionId,
) -> Result<Option<Median>, TableError> {
    let of = [environment, mode, question.as_str()];
    let Some(row) = rows(tally, of)?.into_iter().next() else { return Ok(None) };
    let [low, high] = ["median_low", "median_high"].map(|name| tally.numbers(name));
    let [low, high] = [low?[row], high?[row]].map(|n| AnswerValue::new(n?).ok());
    let [answers, participants] = ["n", "participants"].map(|name| tally.integers(name));
    let (Some(low), Some(high), Some(answers), Some(participants)) =
        (low, high, answers?[row], participants?[row])
    else {
        return Ok(None);
    };
    Ok(Some(Median { scale: study.scale(question), low, high, answers, participants }))
}

/// The answers to the environment's question in a mode as they count, by participant, of the long
/// table of answers.
pub(crate) fn scored(
    study: &Setup,
    answers: &Table,
    environment: &Environment,
    mode: &Mode,
) -> Result<BTreeMap<String, Vec<AnswerValue>>, TableError> {
    let mut people: BTreeMap<String, Vec<AnswerValue>> = BTreeMap::new();
    let Some(asked) = question_of(study, environment) else { return Ok(people) };
    let (who, given) = (answers.texts("participant")?, answers.numbers("answer")?);
    for row in rows(answers, [environment.id.as_str(), mode.id.as_str(), asked.id.as_str()])? {
        let answer = given[row].and_then(|answer| AnswerValue::new(answer).ok());
        let Some(answer) = answer.filter(|answer| asked.scale.has(*answer)) else { continue };
        let scored = asked.scale.score(answer, asked.reversed);
        people.entry(who[row].clone().unwrap_or_default()).or_default().push(scored);
    }
    Ok(people)
}

/// The rows of an environment, a mode and a question.
fn rows(table: &Table, of: [&str; 3]) -> Result<Vec<usize>, TableError> {
    let [environments, modes, questions] =
        ["environment", "mode", "question"].map(|name| table.texts(name));
    let columns = [environments?, modes?, questions?];
    let is = |row: &usize| columns.iter().zip(of).all(|(c, of)| c[*row].as_deref() == Some(of));
    Ok((0..table.height()).filter(is).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_statements_speak_of_the_first_question_that_is_a_rating() {
        let mut study = Setup::of(&zwidth_testing::study());
        let first = study.questions[0].id.clone();
        let mut environment = study.environments[0].clone();
        assert_eq!(environment.question.as_ref(), Some(&first));
        let guess = AnswerScale::Modes(study.modes.iter().map(|m| m.label.clone()).collect());
        study.questions.push(Question {
            id: "guess".parse().unwrap(),
            scale: guess,
            ..study.questions[0].clone()
        });
        environment.question = Some("guess".parse().unwrap());
        assert_eq!(question_of(&study, &environment), None);
        environment.further = vec![first.clone()];
        assert_eq!(question_of(&study, &environment).map(|q| &q.id), Some(&first));
    }

    #[test]
    fn a_median_between_two_answers_is_said_as_both() {
        let of = |low: &str, high: &str| {
            let [low, high] = [low, high].map(|answer| answer.parse().unwrap());
            Median { scale: AnswerScale::FivePoint, low, high, answers: 2, participants: 1 }.words()
        };
        assert_eq!([of("4", "4"), of("3", "4")], ["4 (agree)", "3 to 4"]);
        assert_eq!([of("47.273", "47.273"), of("47", "52.7271")], ["47.27", "47 to 52.73"]);
    }
}
