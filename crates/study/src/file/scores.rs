//! The checks of `[[scores]]` of a `study.toml`.

use super::check::Check;
use crate::{OwnMetric, Question, Score, ScoreKind};
use std::collections::BTreeSet;

/// No study has more scores.
const MOST_SCORES: usize = 32;
/// Questions of the TLX, and of the System Usability Scale.
const TLX: usize = 6;
const SUS: usize = 10;

/// Whether answers to a question can say how often something was chosen.
fn is_weight(question: &Question) -> bool {
    question.scale.lowest() == 0 && question.scale.step() == 1 && !question.reversed
}

impl Check<'_> {
    /// Scores of questions that there are, on scales that can be added.
    pub(super) fn scores(
        &mut self,
        scores: &[Score],
        questions: &[Question],
        metrics: &[OwnMetric],
    ) {
        self.unique("scores", scores.iter().map(|score| score.id.as_str()));
        if scores.len() > MOST_SCORES {
            let n = scores.len();
            let problem = format!("the list has {n} entries; at most {MOST_SCORES} are allowed");
            self.error("scores", problem);
        }
        for (i, score) in scores.iter().enumerate() {
            self.score(&format!("scores[{i}]"), score, questions, metrics);
        }
    }

    fn score(&mut self, key: &str, score: &Score, questions: &[Question], metrics: &[OwnMetric]) {
        match score.metric() {
            Err(why) => self.error(&format!("{key}.id"), why.to_string()),
            Ok(metric) if metrics.iter().any(|own| own.id == metric) => {
                let problem = format!("[[metrics]] has '{metric}', too; choose another id");
                self.error(&format!("{key}.id"), problem);
            }
            Ok(_) => {}
        }
        if let Some(label) = &score.label {
            self.line(&format!("{key}.label"), label);
        }
        let is_weighted = score.kind == ScoreKind::NasaTlx;
        let mut seen = BTreeSet::new();
        let mut found = Vec::new();
        let lists = [("questions", &score.questions), ("weights", &score.weights)];
        for (list, ids) in lists {
            for (i, id) in ids.iter().enumerate() {
                let question = questions.iter().find(|question| question.id == *id);
                let problem = match question {
                    None => format!("there is no question '{id}'; add it under [[questions]]"),
                    Some(_) if !seen.insert(id) => format!("'{id}' stands twice; leave one out"),
                    Some(question) if !question.is_rating() => {
                        format!("'{id}' asks for the mode, which is no number; leave it out")
                    }
                    Some(question) if list == "weights" && is_weighted && !is_weight(question) => {
                        format!(
                            "'{id}' must count from 0 in steps of 1, and not be reversed: it says how often another one was chosen"
                        )
                    }
                    Some(question) => {
                        if list == "questions" {
                            found.push(question);
                        }
                        continue;
                    }
                };
                self.error(&format!("{key}.{list}[{i}]"), problem);
            }
        }
        // What follows speaks of all of them.
        if found.len() < score.questions.len() {
            return;
        }
        let n = score.questions.len();
        let list = format!("{key}.questions");
        let number = match score.kind {
            ScoreKind::NasaTlx | ScoreKind::NasaTlxRaw => Some(TLX),
            ScoreKind::Sus => Some(SUS),
            ScoreKind::Mean | ScoreKind::Sum => None,
        };
        match number {
            Some(number) if n != number => {
                self.error(
                    &list,
                    format!("has {n} questions; a {} has {number}", score.kind.as_str()),
                );
            }
            None if n < 2 => {
                self.error(&list, format!("has {n} questions; at least 2 make a score"))
            }
            _ => {}
        }
        match score.kind {
            ScoreKind::Sus => self.sus(&list, &found),
            ScoreKind::Mean | ScoreKind::Sum => {
                let first = found.first().map(|question| &question.scale);
                if let Some(other) = found.iter().find(|own| Some(&own.scale) != first) {
                    let problem = format!(
                        "'{}' has another scale than the first; a {} takes one scale for all",
                        other.id,
                        score.kind.as_str()
                    );
                    self.error(&list, problem);
                }
            }
            ScoreKind::NasaTlx | ScoreKind::NasaTlxRaw => {}
        }
        if is_weighted != (score.weights.len() == n) || (!is_weighted && !score.weights.is_empty())
        {
            let problem = match is_weighted {
                true => format!(
                    "has {} questions; name {n}, whose answers say how often each of the others was chosen, or use \
                     nasa_tlx_raw",
                    score.weights.len()
                ),
                false => "only nasa_tlx has weights; leave them out".to_owned(),
            };
            self.error(&format!("{key}.weights"), problem);
        }
        if let Some(share) = score.min_answered {
            let problem = match score.kind {
                ScoreKind::Mean if share > 0.0 && share <= 1.0 => return,
                ScoreKind::Mean => format!("{share} must be a share above 0, up to 1, such as 0.8"),
                _ => "only a mean can leave answers out; leave it out".to_owned(),
            };
            self.error(&format!("{key}.min_answered"), problem);
        }
    }

    /// Ten questions of five points, every second one the other way round.
    fn sus(&mut self, list: &str, questions: &[&Question]) {
        for (i, question) in questions.iter().enumerate() {
            let id = &question.id;
            let must_turn = i % 2 == 1;
            let problem = if question.scale.points() != 5 {
                format!("'{id}' has {} points; those of a sus have 5", question.scale.points())
            } else if question.reversed != must_turn {
                let place = i + 1;
                let must = if must_turn { "needs reversed = true" } else { "must not be reversed" };
                format!("'{id}' is question {place} of the sus and {must}")
            } else {
                continue;
            };
            self.error(&format!("{list}[{i}]"), problem);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, text};
    use crate::{Better, Study, StudyError};

    /// The template's study with so many questions `q1`, `q2`, … and a score.
    fn with(number: usize, keys: &str) -> Result<Study, Vec<StudyError>> {
        let question = |i: usize| {
            let reversed = if i.is_multiple_of(2) { "reversed = true\n" } else { "" };
            // From 0 on: answers can be weights, where they are not the other way round.
            let weights = if i > 10 { "from = 0\npoints = 6\n" } else { reversed };
            format!("[[questions]]\nid = \"q{i}\"\ntext = \"Question {i}\"\n{weights}")
        };
        let questions: String = (1..=number).map(question).collect();
        let id = if keys.contains("id =") { "" } else { "id = \"load\"\n" };
        Study::from_toml(&format!("{}\n{questions}[[scores]]\n{id}{keys}\n", text()))
    }

    fn list(of: std::ops::RangeInclusive<usize>) -> String {
        of.map(|i| format!("\"q{i}\"")).collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn a_score_survives_a_round_trip_and_knows_which_values_are_better() {
        let sus = with(10, &format!("kind = \"sus\"\nquestions = [{}]", list(1..=10))).unwrap();
        check_round_trip(&sus);
        let [score] = &sus.scores[..] else { panic!("{:?}", sus.scores) };
        assert_eq!(score.metric().unwrap().as_str(), "score_load");
        assert_eq!(score.better(), Better::Higher);
        assert_eq!(score.in_words(), "load (System Usability Scale)");
        let tlx = format!(
            "kind = \"nasa_tlx\"\nquestions = [{}]\nweights = [{}]\nlabel = \"Workload\"",
            list(1..=6),
            list(11..=16)
        );
        let tlx = with(16, &tlx).unwrap();
        check_round_trip(&tlx);
        assert_eq!(tlx.scores[0].better(), Better::Lower);
        let mean = format!("kind = \"mean\"\nquestions = [{}]\nmin_answered = 0.8", list(1..=5));
        check_round_trip(&with(5, &mean).unwrap());
    }

    #[test]
    fn what_cannot_be_a_score_is_one_error_with_key_and_remedy() {
        for (number, keys, key, words) in [
            (
                2,
                "kind = \"mean\"\nquestions = [\"q1\", \"q9\"]",
                "scores[0].questions[1]",
                "no question 'q9'",
            ),
            (
                2,
                "kind = \"mean\"\nquestions = [\"q1\", \"q1\"]",
                "scores[0].questions[1]",
                "stands twice",
            ),
            (1, "kind = \"sum\"\nquestions = [\"q1\"]", "scores[0].questions", "at least 2"),
            (
                3,
                "kind = \"sus\"\nquestions = [\"q1\", \"q2\", \"q3\"]",
                "scores[0].questions",
                "a sus has 10",
            ),
            (
                2,
                "kind = \"sum\"\nquestions = [\"q1\", \"q2\"]\nmin_answered = 0.5",
                "scores[0].min_answered",
                "only a mean",
            ),
            (
                2,
                "kind = \"mean\"\nquestions = [\"q1\", \"q2\"]\nmin_answered = 8.0",
                "scores[0].min_answered",
                "8 must be a share",
            ),
            (
                3,
                "kind = \"mean\"\nquestions = [\"q1\", \"q2\"]\nweights = [\"q3\"]",
                "scores[0].weights",
                "only nasa_tlx",
            ),
            (2, "kind = \"median\"\nquestions = [\"q1\", \"q2\"]", "kind", "unknown variant"),
        ] {
            check_refused(with(number, keys), key, words);
        }
        let six = format!("kind = \"nasa_tlx\"\nquestions = [{}]", list(1..=6));
        check_refused(with(6, &six), "scores[0].weights", "nasa_tlx_raw");
        let turned = format!("kind = \"sus\"\nquestions = [\"q2\", \"q1\", {}]", list(3..=10));
        let errors = with(10, &turned).unwrap_err();
        assert_eq!(errors.len(), 2, "{errors:?}");
        assert!(errors[0].to_string().contains("must not be reversed"), "{errors:?}");
    }
}
