//! Answers compared: one row per question, environment and contrast.
//!
//! Answers on a scale of up to eleven points are ordinal: no means. The effect is P(A > B) + ½
//! P(A = B) over each participant's pairs of repeats, averaged over participants; the test is that
//! of the cumulative-link mixed model with participant and participant × mode, the odds ratio for
//! one person beside. On a longer scale answers are a quantity: the effect is the same, the test
//! that of the mean difference (`quantity`).

use crate::CompareError;
use crate::quantity::{self, Difference, Score};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{AnswerDifference, AnswerTest, GivenAnswer, PersonSuperiority};
use zwidth_stats::clmm::{ModeComparison, ModeStudy, OddsRatio, compare_modes};
use zwidth_stats::superiority::{Repeats, Superiority, superiority};
use zwidth_stats::{Tested, Unestimable, holm};
use zwidth_study::{
    AnswerValue, Contrast, EnvironmentId, ModeId, ParticipantId, Question, SessionId,
};
use zwidth_tables::Table;

/// The key of the bootstrap's random numbers.
const SEED: u64 = 1;

/// The parameters of a comparison of answers.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnswerParameters {
    /// The environments, in the study's order.
    pub environments: Vec<EnvironmentId>,
    /// The modes, in the study's order.
    pub modes: Vec<ModeId>,
    /// The questions, in the study's order.
    pub questions: Vec<Question>,
    /// The contrasts.
    pub contrasts: Vec<Contrast>,
    /// Level of every interval, as a fraction.
    pub level: f64,
}

/// The answers compared.
#[derive(Debug, Clone, PartialEq)]
pub struct AnswersCompared {
    /// One row per question, environment and contrast.
    pub contrasts: Vec<AnswerDifference>,
    /// The same for each participant.
    pub participants: Vec<PersonSuperiority>,
}

/// The answers to one question in one environment, by the places of their names.
#[derive(Debug, Clone, PartialEq, Default)]
struct Answers {
    participant: Vec<usize>,
    session: Vec<usize>,
    mode: Vec<usize>,
    /// As scored.
    value: Vec<AnswerValue>,
}

/// The answers by question and environment.
type ByQuestion<'p> = BTreeMap<(&'p str, &'p str), Answers>;

struct Row<'a> {
    question: &'a Question,
    environment: &'a EnvironmentId,
    contrast: &'a Contrast,
    answers: usize,
    /// The participants who answered in either mode, as `effect` has their shares.
    people: Vec<usize>,
    effect: Result<Superiority, Unestimable>,
    model: Result<Model, Unestimable>,
    /// The difference of means on a scale of many points, tested or not.
    difference: Option<f64>,
    p_adjusted: Option<f64>,
    /// The p value of "no mode differs from another", and whether a bootstrap gave it.
    any: Option<(f64, bool)>,
}

/// The test of a contrast of answers.
#[derive(Debug, Clone, PartialEq)]
enum Model {
    /// The odds of a higher answer, on a scale of few points.
    Odds(OddsRatio),
    /// The difference of means, on one of many.
    Means(Tested),
}

impl Model {
    fn p_value(&self) -> f64 {
        match self {
            Self::Odds(ratio) => ratio.test.f.p_value,
            Self::Means(tested) => tested.p_value,
        }
    }
}

impl Row<'_> {
    fn odds(&self) -> Option<&OddsRatio> {
        match &self.model {
            Ok(Model::Odds(ratio)) => Some(ratio),
            _ => None,
        }
    }

    fn means(&self) -> Option<&Tested> {
        match &self.model {
            Ok(Model::Means(tested)) => Some(tested),
            _ => None,
        }
    }

    /// The row by its names; with `is_any_long` it tells its model, because others have another.
    fn named(&self, is_any_long: bool) -> AnswerDifference {
        let effect = self.effect.as_ref().ok();
        let interval = effect.and_then(|effect| effect.interval.clone().ok());
        let model = match self.question.scale.is_ordinal() {
            true => "cumulative logit".to_owned(),
            false => format!("means, as for a metric ({} points)", self.question.scale.points()),
        };
        AnswerDifference {
            question: self.question.id.clone(),
            environment: self.environment.clone(),
            contrast: self.contrast.clone(),
            n: effect.map(|effect| effect.shares.iter().flatten().count()),
            answers: self.answers,
            superiority: effect.map(|effect| effect.probability),
            superiority_ci_low: interval.map(|ends| ends.0),
            superiority_ci_high: interval.map(|ends| ends.1),
            odds_ratio: self.odds().and_then(|ratio| ratio.estimate),
            odds_ratio_ci_low: self.odds().and_then(|ratio| ratio.interval.low.value()),
            odds_ratio_ci_high: self.odds().and_then(|ratio| ratio.interval.high.value()),
            p_value: self.model.as_ref().ok().map(Model::p_value),
            p_adjusted: self.p_adjusted,
            p_any: self.any.map(|(p, _)| p),
            test_any: self.any.map(|(_, is_bootstrap)| match is_bootstrap {
                true => AnswerTest::Bootstrap,
                false => AnswerTest::F,
            }),
            remark: match &self.model {
                Ok(Model::Odds(ratio)) => ratio.remark().map(Into::into),
                Ok(Model::Means(_)) => None,
                Err(why) => Some(why.to_string().into()),
            },
            model: is_any_long.then_some(model),
            difference: self.difference,
            difference_ci_low: self.means().map(|means| means.ci_low),
            difference_ci_high: self.means().map(|means| means.ci_high),
        }
    }

    /// The effects of those who answered in both modes.
    fn people(&self, names: &[ParticipantId]) -> Vec<PersonSuperiority> {
        let shares = self.effect.as_ref().map(|effect| effect.shares.as_slice());
        let everybody = self.people.iter().zip(shares.unwrap_or_default());
        let both = everybody.filter_map(|(who, share)| {
            Some(PersonSuperiority {
                question: self.question.id.clone(),
                environment: self.environment.clone(),
                contrast: self.contrast.clone(),
                participant: names[*who].clone(),
                superiority: (*share)?,
            })
        });
        both.collect()
    }
}

/// Compares the modes by the answers.
///
/// # Errors
/// A level outside (0, 1).
pub fn compare_answers(
    answers: &[GivenAnswer],
    parameters: &AnswerParameters,
) -> Result<AnswersCompared, CompareError> {
    let (names, by_condition) = by_question(answers, parameters);
    let mut rows = Vec::new();
    for question in &parameters.questions {
        let first = rows.len();
        for environment in &parameters.environments {
            let key = (question.id.as_str(), environment.as_str());
            if let Some(answers) = by_condition.get(&key) {
                rows.extend(of_environment(question, environment, answers, parameters));
            }
        }
        // The tests of one question are one family.
        let tested: Vec<&mut Row> =
            rows[first..].iter_mut().filter(|row| row.model.is_ok()).collect();
        let p: Vec<f64> =
            tested.iter().filter_map(|row| row.model.as_ref().ok().map(Model::p_value)).collect();
        for (row, p) in tested.into_iter().zip(holm::adjusted(&p)?) {
            row.p_adjusted = Some(p);
        }
    }
    let is_any_long = rows.iter().any(|row| !row.question.scale.is_ordinal());
    Ok(AnswersCompared {
        contrasts: rows.iter().map(|row| row.named(is_any_long)).collect(),
        participants: rows.iter().flat_map(|row| row.people(&names)).collect(),
    })
}

/// The scored answers by question and environment, and the names of the participants.
fn by_question<'p>(
    answers: &[GivenAnswer],
    parameters: &'p AnswerParameters,
) -> (Vec<ParticipantId>, ByQuestion<'p>) {
    let people: BTreeSet<&ParticipantId> = answers.iter().map(|row| &row.participant).collect();
    let people: BTreeMap<&ParticipantId, usize> = people.into_iter().zip(0..).collect();
    let sessions: BTreeSet<&SessionId> = answers.iter().map(|row| &row.session).collect();
    let sessions: BTreeMap<&SessionId, usize> = sessions.into_iter().zip(0..).collect();
    let mut by_question: BTreeMap<_, Answers> = BTreeMap::new();
    for row in answers {
        let question = parameters.questions.iter().find(|question| question.id == row.question);
        let environment = parameters.environments.iter().find(|id| **id == row.environment);
        let mode = parameters.modes.iter().position(|id| *id == row.mode);
        let (Some(question), Some(environment), Some(mode)) = (question, environment, mode) else {
            continue;
        };
        let scored = question.scale.score(row.answer, question.reversed);
        // The model takes places on the scale, and an answer off it has none.
        if !question.scale.has(scored) {
            continue;
        }
        let own = by_question.entry((question.id.as_str(), environment.as_str())).or_default();
        own.participant.push(people[&row.participant]);
        own.session.push(sessions[&row.session]);
        own.mode.push(mode);
        own.value.push(scored);
    }
    (people.into_keys().cloned().collect(), by_question)
}

/// The contrasts of one question in one environment of which both modes were answered.
fn of_environment<'a>(
    question: &'a Question,
    environment: &'a EnvironmentId,
    answers: &Answers,
    parameters: &'a AnswerParameters,
) -> Vec<Row<'a>> {
    let pairs = parameters.contrasts.iter().filter_map(|contrast| {
        let mode = parameters.modes.iter().position(|m| *m == contrast.mode)?;
        let pair = [mode, parameters.modes.iter().position(|m| *m == contrast.against)?];
        pair.iter().all(|mode| answers.mode.contains(mode)).then_some((contrast, pair))
    });
    let pairs: Vec<(&Contrast, [usize; 2])> = pairs.collect();
    let ordinal = question.scale.is_ordinal() && !pairs.is_empty();
    let compared = ordinal.then(|| model(answers, question, &pairs, parameters));
    let mut rows = Vec::new();
    for (row, (contrast, pair)) in pairs.into_iter().enumerate() {
        let (model, difference, any) = match &compared {
            Some(Ok(comparison)) => {
                let ratio = comparison.odds_ratios[row].clone();
                let any = (comparison.p_value(), comparison.bootstrap.is_some());
                (ratio.map(Model::Odds), None, Some(any))
            }
            Some(Err(why)) => (Err(why.clone()), None, None),
            None => {
                let scores = (0..answers.value.len()).map(|row| Score {
                    participant: answers.participant[row],
                    session: answers.session[row],
                    mode: answers.mode[row],
                    value: answers.value[row].into(),
                });
                let scores: Vec<Score> = scores.collect();
                let Difference { estimate, tested } =
                    quantity::difference(&scores, pair, parameters.level);
                (tested.map(Model::Means), estimate, None)
            }
        };
        let (people, effect) = effect(answers, pair, parameters.level);
        rows.push(Row {
            question,
            environment,
            contrast,
            answers: answers.mode.iter().filter(|m| pair.contains(m)).count(),
            people,
            effect,
            model,
            difference,
            p_adjusted: None,
            any,
        });
    }
    rows
}

fn model(
    answers: &Answers,
    question: &Question,
    pairs: &[(&Contrast, [usize; 2])],
    parameters: &AnswerParameters,
) -> Result<ModeComparison, Unestimable> {
    // Every answer to an ordinal question has its place. On a line it may have none, and there this
    // model is not asked for.
    let places: Vec<u8> = answers.value.iter().filter_map(|v| question.scale.place(*v)).collect();
    let study = ModeStudy {
        answers: &places,
        points: question.scale.points(),
        participants: &answers.participant,
        modes: &answers.mode,
        sessions: &answers.session,
        mode_names: &parameters.modes.iter().map(ModeId::as_str).collect::<Vec<_>>(),
    };
    let pairs: Vec<[usize; 2]> = pairs.iter().map(|(_, pair)| *pair).collect();
    compare_modes(&study, &pairs, parameters.level, SEED)
}

/// Everybody's answers in the two modes, compared pair by pair.
fn effect(
    answers: &Answers,
    modes: [usize; 2],
    level: f64,
) -> (Vec<usize>, Result<Superiority, Unestimable>) {
    let mut people: BTreeMap<usize, [Vec<AnswerValue>; 2]> = BTreeMap::new();
    for (row, participant) in answers.participant.iter().enumerate() {
        if let Some(side) = modes.iter().position(|mode| *mode == answers.mode[row]) {
            people.entry(*participant).or_default()[side].push(answers.value[row]);
        }
    }
    let repeats: Vec<Repeats<AnswerValue>> =
        people.values().map(|[a, b]| Repeats { a, b }).collect();
    let effect = superiority(&repeats, level);
    (people.into_keys().collect(), effect)
}

/// The answers compared as a table, with its notes.
///
/// # Errors
/// A number that is none.
pub fn answers_table(rows: &[AnswerDifference]) -> Result<Table, CompareError> {
    let mut table = Table::of_rows(rows)?;
    if rows.iter().any(|row| row.model.is_some()) {
        table = table.with_note(
            "On a scale of more than 11 points means are compared, as for a metric: the mean over participants \
             of their differences, sessions averaged with equal weight, by Student's t; p_value is that of a \
             difference of zero.",
        );
    }
    Ok(table.with_note(
        "n counts participants, never answers. Model: cumulative logit with participant and \
         participant × mode (participant alone where nobody answered twice in a mode), sessions \
         fixed; the likelihood ratio over F is a small-sample approximation, below 8 participants \
         a bootstrap (999) tests whether any mode differs. Adjusted over the contrasts of a question: \
         questions are not adjusted for each other.",
    ))
}
