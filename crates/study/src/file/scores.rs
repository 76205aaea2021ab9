//! The checks of `[[scores]]` of a `study.toml`.

use super::check::Check;
use crate::{AnswerScale, Environment, OwnMetric, Question, Score, ScoreKind};
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
                    Some(question) if question.asks_mode() => {
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
            // A mean of one is that answer as a metric, which factors and groups compare.
            None if n < 1 || (n < 2 && score.kind == ScoreKind::Sum) => {
                let remedy = "at least 2 make a sum; a mean takes one";
                self.error(&list, format!("has {n} questions; {remedy}"))
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
        if let Some(text) = &score.pairs {
            let at = format!("{key}.pairs");
            self.line(&at, text);
            if text.trim().is_empty() {
                self.error(&at, "is empty; write what is asked about each two of the questions");
            }
            if !score.weights.is_empty() {
                self.error(&at, "is not used beside weights; leave one of them out");
            }
            if !is_weighted {
                self.error(&at, "only nasa_tlx has weights; leave them out");
            }
        } else if is_weighted != (score.weights.len() == n)
            || (!is_weighted && !score.weights.is_empty())
        {
            let problem = match is_weighted {
                true => format!(
                    "has {} questions; name {n}, whose answers say how often each of the others was chosen, or have it asked \
                     with pairs = \"Which of the two …?\", or use nasa_tlx_raw",
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

    /// Marks the questions that are weights, and adds one about each pair of the questions of a score with `pairs`.
    pub(super) fn weigh(
        &mut self,
        scores: &[Score],
        environments: &[Environment],
        questions: &mut Vec<Question>,
    ) {
        let weights: BTreeSet<_> = scores.iter().flat_map(|score| &score.weights).collect();
        for question in questions.iter_mut() {
            question.is_weight = weights.contains(&question.id);
        }
        for (i, score) in scores.iter().enumerate() {
            let key = format!("scores[{i}].pairs");
            let Some(text) = &score.pairs else { continue };
            let mut labels = Vec::new();
            for id in &score.questions {
                let Some(question) = questions.iter().find(|question| question.id == *id) else {
                    // Told already, with the place in the list.
                    return;
                };
                let label = question.label.as_ref().unwrap_or(&question.text).clone();
                if labels.contains(&label) {
                    let problem = format!(
                        "cannot be told apart: two of the questions are called '{label}'; give each its own label"
                    );
                    self.error(&key, problem);
                    return;
                }
                labels.push(label);
            }
            self.pairs_are_asked(&key, score, environments);
            for places in score.pairs_of_places() {
                let id = match score.pair_id(places) {
                    Ok(id) => id,
                    Err(why) => {
                        let problem = format!("{why}; give the questions of the pair shorter ids");
                        self.error(&key, problem);
                        continue;
                    }
                };
                // Ids differ by more than case everywhere.
                if questions.iter().any(|own| own.id.as_str().eq_ignore_ascii_case(id.as_str())) {
                    let problem = format!(
                        "a question of the study has the id '{id}', which the pair would have; two scores cannot ask for the \
                         same pairs, and a question needs another id"
                    );
                    self.error(&key, problem);
                    continue;
                }
                questions.push(Question {
                    id,
                    text: text.clone(),
                    group: None,
                    scale: AnswerScale::Pair(places.map(|place| labels[place].clone())),
                    reversed: false,
                    label: None,
                    is_weight: true,
                });
            }
        }
    }

    /// Pairs follow a trial after which all of the score's questions are asked. A study of imports asks none of them.
    fn pairs_are_asked(&mut self, key: &str, score: &Score, environments: &[Environment]) {
        let asks = |environment: &Environment| {
            score
                .questions
                .iter()
                .filter(|id| environment.questions().any(|own| own == *id))
                .count()
        };
        let most = environments.iter().map(asks).max().unwrap_or_default();
        let all = score.questions.len();
        if (1..all).contains(&most) {
            let problem = format!(
                "is never asked: it follows trials after which all {all} questions are asked, and no environment asks more than \
                 {most} of them; name all {all} in questions = […] of an environment"
            );
            self.error(key, problem);
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
    use crate::{AnswerScale, Better, Study, StudyError};

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
        let one = with(1, "kind = \"mean\"\nquestions = [\"q1\"]").unwrap();
        check_round_trip(&one);
        assert_eq!(one.scores[0].in_words(), "load (one answer)");
    }

    /// A weighted TLX of `q1` to `q6` whose pairs are asked for.
    fn pairs() -> String {
        format!("kind = \"nasa_tlx\"\nquestions = [{}]\npairs = \"Which of the two?\"", list(1..=6))
    }

    #[test]
    fn a_score_with_pairs_adds_one_question_about_each_two_that_is_no_rating() {
        let study = with(7, &pairs()).unwrap();
        check_round_trip(&study);
        let added: Vec<_> = study.questions.iter().filter(|question| question.is_pair()).collect();
        let ids: Vec<&str> = added.iter().map(|question| question.id.as_str()).collect();
        let first = ["q1_or_q2", "q1_or_q3", "q1_or_q4", "q1_or_q5", "q1_or_q6", "q2_or_q3"];
        assert_eq!((ids.len(), &ids[..6]), (15, &first[..]));
        let [q1, q5] = [1, 5].map(|i| format!("Question {i}"));
        let scale = AnswerScale::Pair([q1, q5]);
        assert_eq!((&added[3].scale, added[3].text.as_str()), (&scale, "Which of the two?"));
        assert_eq!(scale.worded(2), "2 (Question 5)");
        assert!(added.iter().all(|question| !question.is_rating() && !question.asks_mode()));
        let called = text().replacen("[[questions]]", "[[questions]]\nlabel = \"Spring\"", 1);
        let called = Study::from_toml(&called).unwrap();
        check_round_trip(&called);
        assert_eq!(called.questions[0].label.as_deref(), Some("Spring"));
    }

    #[test]
    fn questions_that_are_weights_are_no_ratings() {
        let keys = format!(
            "kind = \"nasa_tlx\"\nquestions = [{}]\nweights = [{}]",
            list(1..=6),
            list(11..=16)
        );
        let study = with(16, &keys).unwrap();
        let rated = |id: &str| study.question(&id.parse().unwrap()).unwrap().is_rating();
        assert!(rated("q1") && rated("q7") && !rated("q11") && !rated("q16"));
    }

    #[test]
    fn a_pair_is_chosen_so_often_as_its_answers_say() {
        let study = with(6, &pairs()).unwrap();
        let score = &study.scores[0];
        let scale = AnswerScale::Numbers(crate::NumberScale {
            points: 101,
            from: 0,
            step: 1,
            labels: Vec::new(),
        });
        let items = [10, 20, 30, 40, 50, 60].map(|value: i16| Some((&scale, value.into())));
        // The later one of each two is chosen: 0, 1, 2, 3, 4 and 5 times.
        let mut chosen = vec![Some(crate::AnswerValue::from(2)); 15];
        let expected = f64::from(20 + 2 * 30 + 3 * 40 + 4 * 50 + 5 * 60) / 15.0;
        assert!((score.of(&items, &chosen).unwrap() - expected).abs() < 1e-12);
        // The first in the place of the sixth: 1, 1, 2, 3, 4, 4.
        chosen[4] = Some(1.into());
        let expected = f64::from(10 + 20 + 2 * 30 + 3 * 40 + 4 * 50 + 4 * 60) / 15.0;
        assert!((score.of(&items, &chosen).unwrap() - expected).abs() < 1e-12);
        chosen[14] = None;
        assert_eq!(score.of(&items, &chosen).unwrap_err(), "14 of 15 pairs are answered");
    }

    #[test]
    fn answers_to_pairs_mean_the_same_when_the_list_gets_another_order() {
        let turned = list(1..=6).rsplit(", ").collect::<Vec<_>>().join(", ");
        let turned = with(6, &pairs().replace(&list(1..=6), &turned)).unwrap();
        let study = with(6, &pairs()).unwrap();
        assert_eq!(turned.scores[0].questions[0].as_str(), "q6");
        // The same questions, of which each has the same two in the same order.
        assert_eq!(turned.questions, study.questions);
        let scale = &study.questions[study.questions.len() - 16].scale;
        let items = |order: [i16; 6]| order.map(|value| Some((scale, value.into())));
        let chosen: Vec<_> = (0..15_i16).map(|i| Some((1 + i % 2).into())).collect();
        let score = study.scores[0].of(&items([1, 2, 3, 4, 5, 1]), &chosen).unwrap();
        let again = turned.scores[0].of(&items([1, 5, 4, 3, 2, 1]), &chosen).unwrap();
        assert!((score - again).abs() < 1e-12, "{score} and {again}");
    }

    #[test]
    fn pairs_that_cannot_be_asked_are_refused_with_their_key() {
        let at = "scores[0].pairs";
        let own = pairs();
        check_refused(with(6, &own.replace("nasa_tlx", "nasa_tlx_raw")), at, "only nasa_tlx");
        check_refused(with(6, &own.replace("Which of the two?", " ")), at, "is empty");
        let both = format!("{own}\nweights = [{}]", list(11..=16));
        check_refused(with(16, &both), at, "beside weights");
        let twice = format!("{own}\n[[scores]]\nid = \"again\"\n{own}").replacen(
            "kind",
            "id = \"load\"\nkind",
            1,
        );
        let errors = with(6, &twice).unwrap_err();
        assert_eq!((errors.len(), errors[0].key.as_str()), (15, "scores[1].pairs"), "{errors:?}");
        assert!(errors[0].problem.contains("the id 'q1_or_q2'"), "{errors:?}");
        let asked = text().replacen("question = \"felt_spring\"", "question = \"q1_or_q2\"", 1);
        let questions: String = (1..=6)
            .map(|i| format!("[[questions]]\nid = \"q{i}\"\ntext = \"Question {i}\"\n"))
            .collect();
        let whole = |text: &str, questions: &str| {
            Study::from_toml(&format!("{text}\n{questions}[[scores]]\nid = \"load\"\n{own}\n"))
        };
        check_refused(whole(&asked, &questions), "environments[0].question", "is not the id");
        let some = text().replacen("question = \"felt_spring\"", "questions = [\"q1\", \"q2\"]", 1);
        check_refused(whole(&some, &questions), at, "no environment asks more than 2 of them");
        let each = format!("questions = [{}]", list(1..=6));
        let both = some.replacen("question = \"felt_wall\"", &each, 1);
        assert!(both.contains(&each), "the template lost a question");
        whole(&both, &questions).unwrap();
        let alike = questions.replace("Question 2", "Question 1");
        check_refused(whole(&text(), &alike), at, "two of the questions are called 'Question 1'");
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
