//! A questionnaire without recordings in sentences.

use crate::answers::{Median, median};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::AnswerTally;
use zwidth_study::{Mode, Setup, counted};

/// The most questions with a sentence of their own: those whose medians lie farthest apart.
const NAMED: usize = 3;

/// What the answers show in a study without recorded trials, environment by environment: how many
/// there are, then the questions in which the modes' medians are farthest apart. Descriptive: no
/// sentence says that a difference was shown.
pub fn survey(study: &Setup, tally: &[AnswerTally]) -> Vec<Finding> {
    let mut findings = Vec::new();
    for environment in &study.environments {
        let mut answered = Vec::new();
        for question in &study.questions {
            let medians = study.modes.iter().filter_map(|mode| {
                let median = median(tally, environment, mode, question)?;
                Some((mode, median.turned_back(question)))
            });
            let medians: Medians = medians.collect();
            if !medians.is_empty() {
                answered.push((question, medians));
            }
        }
        let all = answered.iter().flat_map(|(_, medians)| medians);
        let answers: usize = all.clone().map(|(_, median)| median.answers).sum();
        // Not their sum, which would count a person once per question.
        let Some(people) = all.map(|(_, median)| median.participants).max() else { continue };
        let text = format!(
            "{}: {} to {} by {}.",
            environment.label,
            counted(answers, "answers"),
            counted(answered.len(), "questions"),
            counted(people, "participants")
        );
        findings.push(Finding::new(text, Shown::Answers));
        // stable: questions that are equally far apart stay in the study's order
        answered.sort_by(|a, b| spread(&b.1).total_cmp(&spread(&a.1)));
        let apart = answered.iter().filter(|(_, medians)| spread(medians) > 0.0).take(NAMED);
        findings.extend(apart.map(|(question, medians)| {
            let list: Vec<String> = medians
                .iter()
                .map(|(mode, median)| format!("{} with {}", median.words(), mode.label))
                .collect();
            let text = format!(
                "{}, “{}”: the median answer was {}.",
                environment.label,
                question.text,
                list.join(", ")
            );
            Finding::new(text, Shown::Answers)
        }));
    }
    findings
}

/// The medians of the modes that have answers.
type Medians<'a> = Vec<(&'a Mode, Median)>;

/// How far apart the modes' medians lie, in points.
fn spread(medians: &Medians) -> f64 {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let (low, high) = medians
        .iter()
        .map(|(_, median)| (median.low.get() + median.high.get()) / 2.0)
        .fold(start, |(low, high), v| (low.min(v), high.max(v)));
    high - low
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answers::testing::tallied;

    #[test]
    fn a_survey_is_told_by_its_size_and_by_where_the_modes_lie_apart() {
        let study = Setup::of(&zwidth_testing::study());
        let question = study.questions[0].clone();
        let mut turned = study.clone();
        turned.questions[0].reversed = true;
        let of = |mode, people: usize, median| AnswerTally {
            participants: people,
            n: people,
            ..tallied("spring", mode, question.id.as_str(), median)
        };
        let tally = [of("active", 20, 4), of("passive", 19, 2)];
        let texts = |study: &Setup| -> Vec<String> {
            survey(study, &tally).into_iter().map(|f| f.text.to_string()).collect()
        };
        let found = texts(&study);
        assert_eq!(found.len(), 2, "{found:?}");
        assert_eq!(found[0], "Spring: 39 answers to 1 question by 20 participants.");
        assert!(
            found[1].ends_with(
                "the median answer was 4 (agree) with Active, 2 (disagree) with Passive."
            ),
            "{found:?}"
        );
        let turned_back = &texts(&turned)[1];
        assert!(
            turned_back.ends_with("was 2 (disagree) with Active, 4 (agree) with Passive."),
            "{turned_back}"
        );
    }
}
