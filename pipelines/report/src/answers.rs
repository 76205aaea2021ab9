//! The answers to an environment's question: their median, and the comparison of one mode with
//! another.

use std::collections::BTreeMap;
use zwidth_results::{AnswerTally, GivenAnswer};
use zwidth_study::{AnswerScale, AnswerValue, Environment, Mode, ParticipantId, Question, Setup};
use zwidth_tables::number;

/// The median of a mode's answers.
pub(crate) struct Median {
    pub(crate) scale: AnswerScale,
    /// The two middle answers, as scored.
    pub(crate) low: AnswerValue,
    pub(crate) high: AnswerValue,
    pub(crate) answers: usize,
    pub(crate) participants: usize,
}

impl Median {
    /// The median of the answers as participants gave them: the tally turns those to a question
    /// that counts the other way round.
    pub(crate) fn turned_back(self, question: &Question) -> Self {
        if !question.reversed {
            return self;
        }
        // On a scale that is turned the lower of two answers becomes the higher.
        let [high, low] = [self.low, self.high].map(|answer| self.scale.score(answer, true));
        Self { low, high, ..self }
    }

    /// `4 (agree)`, or `3 to 4` where the two middle answers differ. What has decimals is rounded.
    pub(crate) fn words(&self) -> String {
        match self.low.whole() {
            _ if self.low != self.high => format!("{} to {}", shown(self.low), shown(self.high)),
            Some(whole) => self.scale.worded(whole),
            None => shown(self.low),
        }
    }
}

fn shown(answer: AnswerValue) -> String {
    match answer.whole() {
        Some(whole) => whole.to_string(),
        None => number(answer.get(), None),
    }
}

/// The environment's question, of which the statements speak: the first that is a rating.
pub(crate) fn question_of<'s>(study: &'s Setup, environment: &Environment) -> Option<&'s Question> {
    environment
        .questions()
        .find_map(|id| study.questions.iter().find(|q| q.id == *id && q.is_rating()))
}

/// The median answer to a question in an environment and a mode, by the tally; `None` without an
/// answer.
pub(crate) fn median(
    tally: &[AnswerTally],
    environment: &Environment,
    mode: &Mode,
    question: &Question,
) -> Option<Median> {
    let row = tally.iter().find(|row| {
        row.environment == environment.id
            && row.mode == mode.id
            && row.question.as_ref() == Some(&question.id)
    })?;
    Some(Median {
        scale: question.scale.clone(),
        low: row.median_low?,
        high: row.median_high?,
        answers: row.n,
        participants: row.participants,
    })
}

/// The answers to the environment's question in a mode as they count, by participant.
pub(crate) fn scored<'a>(
    study: &Setup,
    answers: &'a [GivenAnswer],
    environment: &Environment,
    mode: &Mode,
) -> BTreeMap<&'a ParticipantId, Vec<AnswerValue>> {
    let mut people: BTreeMap<&ParticipantId, Vec<AnswerValue>> = BTreeMap::new();
    let Some(question) = question_of(study, environment) else { return people };
    for row in answers {
        // An answer that its scale does not have has no score.
        let counts = row.environment == environment.id
            && row.mode == mode.id
            && row.question == question.id
            && question.scale.has(row.answer);
        if counts {
            let scored = question.scale.score(row.answer, question.reversed);
            people.entry(&row.participant).or_default().push(scored);
        }
    }
    people
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;

    /// One answer of one person, which is the median.
    pub(crate) fn tallied(
        environment: &str,
        mode: &str,
        question: &str,
        median: i16,
    ) -> AnswerTally {
        AnswerTally {
            environment: environment.parse().unwrap(),
            mode: mode.parse().unwrap(),
            question: Some(question.parse().unwrap()),
            group: None,
            pooled: false,
            reversed: Some(false),
            participants: 1,
            n: 1,
            count_1: None,
            count_2: None,
            count_3: None,
            count_4: None,
            count_5: None,
            count_6: None,
            count_7: None,
            count_8: None,
            count_9: None,
            count_10: None,
            count_11: None,
            median_low: Some(median.into()),
            median_high: Some(median.into()),
            lowest: None,
            quartile_1: None,
            quartile_3: None,
            highest: None,
            mean: None,
            sd: None,
        }
    }
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
