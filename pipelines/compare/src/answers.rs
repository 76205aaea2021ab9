//! Answers compared: one row per question, environment and contrast.
//!
//! Answers on a scale of up to eleven points are ordinal: no means. The effect is P(A > B) + ½
//! P(A = B) over each participant's pairs of repeats, averaged over participants; the test is that
//! of the cumulative-link mixed model with participant and participant × mode, the odds ratio for
//! one person beside. On a longer scale answers are a quantity: the effect is the same, the test
//! that of the mean difference (`quantity`).

use crate::CompareError;
use crate::quantity::{self, Difference, Score};
use crate::trials::{place, sorted};
use serde::Serialize;
use std::collections::BTreeMap;
use zwidth_results::{AnswerDifference, AnswerTest, GivenAnswer, PersonSuperiority};
use zwidth_stats::clmm::{ModeComparison, ModeStudy, compare_modes};
use zwidth_stats::superiority::{Repeats, Superiority, superiority};
use zwidth_stats::{Unestimable, holm};
use zwidth_study::{AnswerValue, Contrast, EnvironmentId, ModeId, ParticipantId, Question};
use zwidth_tables::{NoteKind, Table};

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
#[derive(Debug, Clone, PartialEq, Default)]
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

impl Answers {
    fn scores(&self) -> Vec<Score> {
        let scores = (0..self.value.len()).map(|row| Score {
            participant: self.participant[row],
            session: self.session[row],
            mode: self.mode[row],
            value: self.value[row].into(),
        });
        scores.collect()
    }
}

/// The answers by question and environment.
type ByQuestion<'p> = BTreeMap<(&'p str, &'p str), Answers>;

/// Compares the modes by the answers.
///
/// # Errors
/// A level outside (0, 1).
pub fn compare_answers(
    answers: &[GivenAnswer],
    parameters: &AnswerParameters,
) -> Result<AnswersCompared, CompareError> {
    let (names, by_condition) = by_question(answers, parameters);
    let mut compared = AnswersCompared::default();
    let mut is_any_long = false;
    for question in &parameters.questions {
        let first = compared.contrasts.len();
        for environment in &parameters.environments {
            let key = (question.id.as_str(), environment.as_str());
            if let Some(answers) = by_condition.get(&key) {
                compare_one(question, environment, answers, &names, parameters, &mut compared);
            }
        }
        // The tests of one question are one family.
        let family = &mut compared.contrasts[first..];
        is_any_long |= !family.is_empty() && !question.scale.is_ordinal();
        let p: Vec<f64> = family.iter().filter_map(|row| row.p_value).collect();
        let tested = family.iter_mut().filter(|row| row.p_value.is_some());
        for (row, p) in tested.zip(holm::adjusted(&p)?) {
            row.p_adjusted = Some(p);
        }
    }
    // A row tells its model only where others have another.
    if !is_any_long {
        compared.contrasts.iter_mut().for_each(|row| row.model = None);
    }
    Ok(compared)
}

/// The scored answers by question and environment, and the names of the participants.
fn by_question<'p>(
    answers: &[GivenAnswer],
    parameters: &'p AnswerParameters,
) -> (Vec<ParticipantId>, ByQuestion<'p>) {
    let people = sorted(answers.iter().map(|row| &row.participant));
    let sessions = sorted(answers.iter().map(|row| &row.session));
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
        own.participant.push(place(&people, &row.participant));
        own.session.push(place(&sessions, &row.session));
        own.mode.push(mode);
        own.value.push(scored);
    }
    (people, by_question)
}

/// Adds the contrasts of one question in one environment of which both modes were answered, and the
/// effects of those who answered in both.
fn compare_one(
    question: &Question,
    environment: &EnvironmentId,
    answers: &Answers,
    names: &[ParticipantId],
    parameters: &AnswerParameters,
    all: &mut AnswersCompared,
) {
    let pairs = parameters.contrasts.iter().filter_map(|contrast| {
        let mode = parameters.modes.iter().position(|m| *m == contrast.mode)?;
        let pair = [mode, parameters.modes.iter().position(|m| *m == contrast.against)?];
        pair.iter().all(|mode| answers.mode.contains(mode)).then_some((contrast, pair))
    });
    let pairs: Vec<(&Contrast, [usize; 2])> = pairs.collect();
    let ordinal = question.scale.is_ordinal() && !pairs.is_empty();
    let compared = ordinal.then(|| model(answers, question, &pairs, parameters));
    for (place, (contrast, pair)) in pairs.into_iter().enumerate() {
        let (people, effect) = effect(answers, pair, parameters.level);
        let effect = effect.ok();
        let shares = effect.iter().flat_map(|effect| &effect.shares);
        let both = people.iter().zip(shares).filter_map(|(who, share)| {
            Some(PersonSuperiority {
                question: question.id.clone(),
                environment: environment.clone(),
                contrast: contrast.clone(),
                participant: names[*who].clone(),
                superiority: (*share)?,
            })
        });
        all.participants.extend(both);
        let interval = effect.as_ref().and_then(|effect| effect.interval.as_ref().ok());
        let mut row = AnswerDifference {
            question: question.id.clone(),
            environment: environment.clone(),
            contrast: contrast.clone(),
            n: effect.as_ref().map(|effect| effect.shares.iter().flatten().count()),
            answers: answers.mode.iter().filter(|m| pair.contains(m)).count(),
            superiority: effect.as_ref().map(|effect| effect.probability),
            superiority_ci_low: interval.map(|ends| ends.0),
            superiority_ci_high: interval.map(|ends| ends.1),
            odds_ratio: None,
            odds_ratio_ci_low: None,
            odds_ratio_ci_high: None,
            p_value: None,
            p_adjusted: None,
            p_any: None,
            test_any: None,
            remark: None,
            model: Some("cumulative logit".to_owned()),
            difference: None,
            difference_ci_low: None,
            difference_ci_high: None,
        };
        match &compared {
            Some(Ok(comparison)) => {
                row.p_any = Some(comparison.p_value());
                let bootstrap = comparison.bootstrap.as_ref();
                row.test_any = Some(bootstrap.map_or(AnswerTest::F, |_| AnswerTest::Bootstrap));
                match &comparison.odds_ratios[place] {
                    Ok(ratio) => {
                        row.odds_ratio = ratio.estimate;
                        row.odds_ratio_ci_low = ratio.interval.low.value();
                        row.odds_ratio_ci_high = ratio.interval.high.value();
                        row.p_value = Some(ratio.test.f.p_value);
                        row.remark = ratio.remark().map(Into::into);
                    }
                    Err(why) => row.remark = Some(why.to_string().into()),
                }
            }
            Some(Err(why)) => row.remark = Some(why.to_string().into()),
            None => {
                let points = question.scale.points();
                row.model = Some(format!("means, as for a metric ({points} points)"));
                let Difference { estimate, tested } =
                    quantity::difference(&answers.scores(), pair, parameters.level);
                row.difference = estimate;
                match tested {
                    Ok(means) => {
                        row.p_value = Some(means.p_value);
                        row.difference_ci_low = Some(means.ci_low);
                        row.difference_ci_high = Some(means.ci_high);
                    }
                    Err(why) => row.remark = Some(why.to_string().into()),
                }
            }
        }
        all.contrasts.push(row);
    }
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
pub fn answers_table(
    rows: &[AnswerDifference],
    contrasts: &[Contrast],
) -> Result<Table, CompareError> {
    let mut table = Table::of_rows(rows)?;
    if contrasts.is_empty() {
        table = table.with_note_of(
            NoteKind::LeftOut,
            "No contrast of modes is asked for, as is the default with factors: single answers are not compared. \
             A score of kind \"mean\" of one question makes its answers a metric, which has effects of factors.",
        );
    }
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
