//! Scores of several answers, trial by trial, and how far the answers of each hang together.

use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Reliability, TrialScore};
use zwidth_stats::reliability::{LEAST_FOR_OMEGA, alpha, omega};
use zwidth_store::Answer;
use zwidth_study::{
    AnswerValue, Condition, EnvironmentId, ModeId, ParticipantId, Question, QuestionId, Score,
    SessionId, Source, Study,
};

/// What scores are made of.
#[derive(Debug, Clone, Serialize)]
pub struct Scoring {
    /// The scores.
    pub scores: Vec<Score>,
    /// The questions.
    pub questions: Vec<Question>,
    /// Level of intervals, as a fraction.
    pub level: f64,
}

impl Scoring {
    /// The scores of a study.
    pub fn of(study: &Study) -> Self {
        let (scores, questions) = (study.scores.clone(), study.questions.clone());
        Self { scores, questions, level: study.compare.level }
    }

    /// The questions whose answers enter a score.
    pub fn taken(&self) -> BTreeSet<QuestionId> {
        let scores = self.scores.iter();
        scores.flat_map(|score| [score.questions.clone(), score.weighing()].concat()).collect()
    }

    /// Whether an answer is one about a pair, which people give once in a session.
    pub fn weighs_session(&self, answer: &Answer) -> bool {
        self.question(&answer.question).is_some_and(Question::is_pair)
    }

    fn question(&self, id: &QuestionId) -> Option<&Question> {
        self.questions.iter().find(|question| question.id == *id)
    }
}

/// A trial, and what was answered after it.
type Trial<'a> = (&'a ParticipantId, &'a SessionId, u32);

/// The answers after each trial.
type Given<'a> = BTreeMap<Trial<'a>, BTreeMap<&'a QuestionId, AnswerValue>>;

/// A trial with answers: which repeat of its condition it is, and where it is from.
#[derive(Debug, Clone, Serialize)]
pub struct AnsweredTrial {
    /// Who.
    pub participant: ParticipantId,
    /// Which session.
    pub session: SessionId,
    /// Its number in the session.
    pub trial: u32,
    /// The repeat.
    pub repeat: u32,
    /// Where it is from.
    pub source: Source,
}

/// Every score of every trial after which one of its questions was answered, in the order of scores, then of
/// people, sessions and trials. An answer that its scale does not have counts as none. Weights that were given once
/// in a session stand for each of its trials; so do its pairs where they followed a trial that does not count, and these
/// are `left_out`, those to one question of a trial in the order in which they were given.
pub fn scores(
    answers: &[Answer],
    left_out: &[Answer],
    answered: &[AnsweredTrial],
    scoring: &Scoring,
) -> Vec<TrialScore> {
    let known: BTreeMap<Trial, &AnsweredTrial> =
        answered.iter().map(|own| ((&own.participant, &own.session, own.trial), own)).collect();
    let mut all = Given::new();
    // What counts comes last, and takes the place of what does not.
    for answer in left_out.iter().chain(answers).filter(|answer| scoring.weighs_session(answer)) {
        let trial = (&answer.participant, &answer.session, answer.trial);
        all.entry(trial).or_default().insert(&answer.question, answer.value);
    }
    let mut trials: BTreeMap<Trial, (&Condition, BTreeMap<&QuestionId, AnswerValue>)> =
        BTreeMap::new();
    for answer in answers {
        let trial = (&answer.participant, &answer.session, answer.trial);
        let (_, given) =
            trials.entry(trial).or_insert_with(|| (&answer.condition, BTreeMap::new()));
        given.insert(&answer.question, answer.value);
    }
    let mut rows = Vec::new();
    for score in &scoring.scores {
        let weighing = score.weighing();
        for (trial, (condition, given)) in &trials {
            let Some(known) = known.get(trial) else { continue };
            let answers = score.questions.iter().map(|id| {
                let question = scoring.question(id)?;
                if !question.scale.has(*given.get(id)?) {
                    return None;
                }
                let turned = question.scale.score(*given.get(id)?, question.reversed);
                Some((&question.scale, turned))
            });
            let answers: Vec<_> = answers.collect();
            // Asked once for a session, weights stand after one of its trials alone.
            let once = |id: &QuestionId| {
                let mut all = trials.range((trial.0, trial.1, 0)..=(trial.0, trial.1, u32::MAX));
                let mut own = all.by_ref().filter_map(|(_, (_, given))| given.get(id).copied());
                let first = own.next()?;
                own.next().is_none().then_some(first)
            };
            let has_own = weighing.iter().any(|id| given.contains_key(id));
            let counts = |own: &Trial| trials.contains_key(own);
            let pairs = score.pairs.as_ref();
            let of_session = pairs.and_then(|_| pairs_of_session(&all, trial, &weighing, counts));
            let weight = |id| {
                let weight = match of_session {
                    _ if has_own => given.get(id).copied(),
                    Some(whole) => whole.get(id).copied(),
                    None => once(id),
                };
                let question = scoring.question(id);
                weight.filter(|weight| question.is_none_or(|own| own.scale.has(*weight)))
            };
            let weights: Vec<_> = weighing.iter().map(weight).collect();
            let answered = answers.iter().flatten().count();
            if answered == 0 {
                continue;
            }
            let value = score.of(&answers, &weights);
            rows.push(TrialScore {
                score: score.id.clone(),
                participant: known.participant.clone(),
                session: known.session.clone(),
                trial: known.trial,
                repeat: known.repeat,
                source: known.source,
                environment: condition.environment.clone(),
                mode: condition.mode.clone(),
                answered,
                questions: score.questions.len(),
                value: value.as_ref().ok().copied(),
                remark: value.err().map(Into::into),
            });
        }
    }
    rows
}

/// The pairs of a trial's session: all of them, as they were answered after its last trial that was followed by them, whether
/// or not it counts. There are none for the whole session if several trials that count have all of their own.
fn pairs_of_session<'g, 'a>(
    all: &'g Given<'a>,
    trial: &Trial<'a>,
    weighing: &[QuestionId],
    counts: impl Fn(&Trial<'a>) -> bool,
) -> Option<&'g BTreeMap<&'a QuestionId, AnswerValue>> {
    let session = all.range((trial.0, trial.1, 0)..=(trial.0, trial.1, u32::MAX));
    let is_whole = |given: &BTreeMap<_, _>| weighing.iter().all(|id| given.contains_key(id));
    let whole: Vec<_> = session.filter(|(_, given)| is_whole(given)).collect();
    let counting = whole.iter().filter(|(own, _)| counts(own)).count();
    whole.last().filter(|_| counting < 2).map(|(_, given)| *given)
}

/// Everybody's answers to each question.
type OfPeople<'a> = BTreeMap<&'a ParticipantId, BTreeMap<&'a QuestionId, Vec<f64>>>;

/// A score in a session and condition.
type Place<'a> = (usize, &'a EnvironmentId, &'a ModeId, &'a SessionId);

/// Cronbach's α of each score in every condition and session: of people's mean answers there, never of all
/// conditions as if they were people.
pub fn reliability(answers: &[Answer], scoring: &Scoring) -> Vec<Reliability> {
    let mut places: BTreeMap<Place, OfPeople> = BTreeMap::new();
    for answer in answers {
        let question = scoring.question(&answer.question);
        let Some(question) = question.filter(|own| own.scale.has(answer.value)) else { continue };
        for (i, score) in scoring.scores.iter().enumerate() {
            // One question hangs together with no other.
            if score.questions.len() < 2 || !score.questions.contains(&answer.question) {
                continue;
            }
            let Condition { environment, mode } = &answer.condition;
            let people = places.entry((i, environment, mode, &answer.session)).or_default();
            let own = people.entry(&answer.participant).or_default();
            let turned = question.scale.score(answer.value, question.reversed);
            let turned = score.item(&question.scale, turned);
            own.entry(&answer.question).or_default().push(turned);
        }
    }
    let rows = places.into_iter().map(|((i, environment, mode, session), people)| {
        let score = &scoring.scores[i];
        let whole = people.values().filter_map(|own| {
            let answers = score.questions.iter().map(|id| {
                let answers = own.get(id)?;
                Some(answers.iter().sum::<f64>() / answers.len() as f64)
            });
            answers.collect::<Option<Vec<f64>>>()
        });
        let whole: Vec<Vec<f64>> = whole.collect();
        let found = alpha(&whole, scoring.level);
        let alpha = found.as_ref().ok();
        let omega = (whole.len() >= LEAST_FOR_OMEGA).then(|| omega(&whole));
        let no_omega = omega.as_ref().and_then(|omega| omega.as_ref().err());
        let no_omega = no_omega.map(|why| format!("no ω: {why}"));
        Reliability {
            score: score.id.clone(),
            environment: environment.clone(),
            mode: mode.clone(),
            session: session.clone(),
            n: whole.len(),
            questions: score.questions.len(),
            alpha: alpha.map(|found| found.alpha),
            alpha_ci_low: alpha.map(|found| found.ends[0]),
            alpha_ci_high: alpha.map(|found| found.ends[1]),
            omega: omega.as_ref().and_then(|omega| omega.as_ref().ok()).copied(),
            remark: found.as_ref().err().map(ToString::to_string).or(no_omega).map(Into::into),
        }
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{AnswerScale, NumberScale, ScoreKind};

    /// Questions on a scale from 0 to 100, of which the second is the other way round.
    fn questions(ids: &[&str]) -> Vec<Question> {
        let scale = NumberScale { points: 21, from: 0, step: 5, labels: Vec::new() };
        let question = |(i, id): (usize, &&str)| Question {
            id: id.parse().unwrap(),
            text: String::new(),
            group: None,
            scale: AnswerScale::Numbers(scale.clone()),
            reversed: i == 1,
            label: None,
            is_weight: false,
        };
        ids.iter().enumerate().map(question).collect()
    }

    fn answer(who: &str, trial: u32, question: &str, value: i16) -> Answer {
        Answer {
            participant: who.parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial,
            condition: Condition {
                environment: "spring".parse().unwrap(),
                mode: "active".parse().unwrap(),
            },
            question: question.parse().unwrap(),
            value: value.into(),
            time_ms: None,
        }
    }

    fn answered(answers: &[Answer]) -> Vec<AnsweredTrial> {
        let trial = |answer: &Answer| AnsweredTrial {
            participant: answer.participant.clone(),
            session: answer.session.clone(),
            trial: answer.trial,
            repeat: answer.trial,
            source: Source::Imported,
        };
        answers.iter().map(trial).collect()
    }

    fn scoring(kind: ScoreKind, min_answered: Option<f64>) -> Scoring {
        let score = Score {
            id: "load".parse().unwrap(),
            kind,
            questions: ["a", "b", "c"].map(|id| id.parse().unwrap()).to_vec(),
            weights: Vec::new(),
            pairs: None,
            min_answered,
            label: None,
            better: None,
        };
        Scoring { scores: vec![score], questions: questions(&["a", "b", "c", "d"]), level: 0.95 }
    }

    #[test]
    fn a_score_turns_what_is_reversed_and_a_missing_answer_leaves_none() {
        let mut answers = vec![
            answer("P01", 1, "a", 20),
            answer("P01", 1, "b", 90),
            answer("P01", 1, "c", 30),
            answer("P01", 2, "a", 20),
            answer("P01", 2, "c", 40),
            answer("P02", 1, "d", 100),
        ];
        answers.reverse();
        let rows = scores(&answers, &[], &answered(&answers), &scoring(ScoreKind::Mean, None));
        let values: Vec<Option<f64>> = rows.iter().map(|row| row.value).collect();
        assert_eq!((values, rows[1].answered), (vec![Some(20.0), None], 2));
        let why = rows[1].remark.as_ref().unwrap().to_string();
        assert_eq!(why, "2 of 3 questions are answered, 3 are needed");
        let rows = scores(&answers, &[], &answered(&answers), &scoring(ScoreKind::Mean, Some(0.6)));
        assert_eq!(rows[1].value, Some(30.0));
        assert_eq!(
            scores(&answers, &[], &answered(&answers), &scoring(ScoreKind::Sum, None))[0].value,
            Some(60.0)
        );
    }

    #[test]
    fn weights_given_once_in_a_session_stand_for_each_of_its_trials() {
        let mut scoring = scoring(ScoreKind::NasaTlx, None);
        scoring.scores[0].weights = ["d", "e", "f"].map(|id| id.parse().unwrap()).to_vec();
        let mut answers = Vec::new();
        for trial in [1, 2] {
            for (question, value) in [("a", 20), ("b", 40), ("c", 10 * trial as i16)] {
                answers.push(answer("P01", trial, question, value));
            }
        }
        for (question, value) in [("d", 5), ("e", 4), ("f", 6)] {
            answers.push(answer("P01", 2, question, value));
        }
        let values = |answers: &[Answer]| -> Vec<Option<f64>> {
            scores(answers, &[], &answered(answers), &scoring).iter().map(|row| row.value).collect()
        };
        // The second question is turned: (5 · 20 + 4 · 60 + 6 · 10) / 15 and with 20 in the place of 10.
        let expected = [400.0 / 15.0, 460.0 / 15.0];
        for (found, expected) in values(&answers).iter().zip(expected) {
            assert!((found.unwrap() - expected).abs() < 1e-12);
        }
        // A trial with some weights of its own takes no others.
        answers.push(answer("P01", 1, "d", 5));
        assert_eq!(values(&answers)[0], None);
    }

    #[test]
    fn pairs_stand_for_the_session_even_if_the_trial_before_them_does_not_count() {
        let mut scoring = scoring(ScoreKind::NasaTlx, None);
        let ids = ["a", "b", "c", "d", "e", "f"];
        let score = &mut scoring.scores[0];
        score.questions = ids.map(|id| id.parse().unwrap()).to_vec();
        score.pairs = Some("Which?".to_owned());
        let weighing = score.weighing();
        scoring.questions = questions(&ids);
        scoring.questions[1].reversed = false;
        scoring.questions.extend(weighing.iter().map(|id| Question {
            id: id.clone(),
            scale: AnswerScale::Pair(["1", "2"].map(str::to_owned)),
            reversed: false,
            is_weight: true,
            ..questions(&["a"])[0].clone()
        }));
        let rated = |trial: u32| {
            let values = [10, 20, 30, 40, 50, 60].into_iter().zip(ids);
            values.map(move |(value, id)| answer("P01", trial, id, value))
        };
        let weighed = |trial: u32, chosen: i16, number: usize| -> Vec<Answer> {
            let own = weighing.iter().take(number);
            own.map(|id| answer("P01", trial, id.as_str(), chosen)).collect()
        };
        let found = |more: Vec<Answer>, left_out: &[Answer]| -> Vec<Option<f64>> {
            let answers: Vec<Answer> = [1, 2].into_iter().flat_map(rated).chain(more).collect();
            let rows = super::scores(&answers, left_out, &answered(&answers), &scoring);
            rows.iter().map(|row| row.value.map(f64::round)).collect()
        };
        // The second of each two, chosen 0 to 5 times: 700 / 15. The first: 350 / 15.
        let [second, first] = [Some(47.0), Some(23.0)];
        assert_eq!(found(Vec::new(), &weighed(3, 2, 15)), [second; 2]);
        // The latest that are whole.
        let twice = [weighed(3, 2, 15), weighed(4, 1, 15), weighed(5, 2, 14)].concat();
        assert_eq!(found(Vec::new(), &twice), [first; 2]);
        assert_eq!(found(weighed(2, 1, 15), &weighed(1, 2, 15)[..3]), [first; 2]);
        assert_eq!(found(Vec::new(), &weighed(3, 2, 14)), [None; 2]);
        // One pair by itself takes nothing from the other trials; whole ones of several trials are for each its own.
        let stray = [weighed(1, 2, 1), weighed(2, 1, 15)].concat();
        assert_eq!(found(stray.clone(), &[]), [None, first]);
        let third: Vec<Answer> = rated(3).collect();
        assert_eq!(found([stray, third.clone()].concat(), &[]), [None, first, first]);
        let each = [weighed(1, 2, 15), weighed(2, 1, 15), third].concat();
        assert_eq!(found(each, &[]), [second, first, None]);
    }

    #[test]
    fn reliability_is_of_people_in_a_condition() {
        let mut answers = Vec::new();
        for person in 0..5_i16 {
            for (trial, more) in [(1, 0), (2, 10)] {
                let who = format!("P{person:02}");
                for (question, own) in
                    [("a", 5 * person), ("b", 100 - 5 * person), ("c", 10 * (person % 3))]
                {
                    let turned = if question == "b" { -more } else { more };
                    answers.push(answer(&who, trial, question, own + turned));
                }
            }
        }
        let [row] = &reliability(&answers, &scoring(ScoreKind::Mean, None))[..] else { panic!() };
        assert_eq!((row.n, row.questions), (5, 3));
        // Variances 62.5, 62.5, 70 and 370 of the sums of (0, 0, 0), (5, 5, 10), (10, 10, 20), (15, 15, 0), (20, 20, 10).
        let expected = 1.5 * (1.0 - (62.5 + 62.5 + 70.0) / 370.0);
        assert!((row.alpha.unwrap() - expected).abs() < 1e-12, "{row:?}");
        assert!(row.alpha_ci_low < row.alpha && row.alpha < row.alpha_ci_high);
    }
}
