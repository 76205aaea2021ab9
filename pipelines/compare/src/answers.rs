//! Answers compared: one row per question, environment and contrast.
//!
//! Answers on a scale of up to eleven points are ordinal: no means. The effect is P(A > B) + ½
//! P(A = B) over each participant's pairs of repeats, averaged over participants; the test is that
//! of the cumulative-link mixed model with participant and participant × mode, the odds ratio for
//! one person beside. On a longer scale answers are a quantity: the effect is the same, the test
//! that of the mean difference (`quantity`).

use crate::cells::whole;
use crate::quantity::{self, Difference, Score};
use crate::{CompareError, columns};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_stats::clmm::{ModeComparison, ModeStudy, OddsRatio, compare_modes};
use zwidth_stats::superiority::{Repeats, Superiority, superiority};
use zwidth_stats::{Tested, Unestimable, holm};
use zwidth_study::{AnswerValue, Contrast, EnvironmentId, ModeId, Question};
use zwidth_tables::{Column, Table};

/// The key of the bootstrap's random numbers.
const SEED: u64 = 1;

/// What a comparison of answers depends on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnswerParameters {
    /// Whether any of the answers are simulated.
    pub simulated: bool,
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

/// The answers compared, as tables.
#[derive(Debug, Clone)]
pub struct AnswersCompared {
    /// One row per question, environment and contrast.
    pub contrasts: Table,
    /// The same for each participant.
    pub participants: Table,
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

/// By question and environment.
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

/// What a contrast of answers is tested by.
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

    /// Which model the contrast has, or would have.
    fn model_words(&self) -> String {
        match self.question.scale.is_ordinal() {
            true => "cumulative logit".to_owned(),
            false => format!("means, as for a metric ({} points)", self.question.scale.points()),
        }
    }
}

/// Compares the modes by the answers, which have one row each (`answers` of the stage `likert`).
///
/// # Errors
/// A table that lacks a column; a level outside (0, 1).
pub fn compare_answers(
    answers: &Table,
    parameters: &AnswerParameters,
) -> Result<AnswersCompared, CompareError> {
    let (names, by_condition) = by_question(answers, parameters)?;
    let mut rows = Vec::new();
    for question in &parameters.questions {
        let first = rows.len();
        for environment in &parameters.environments {
            let key = (question.id.as_str(), environment.as_str());
            if let Some(answers) = by_condition.get(&key) {
                rows.extend(of_environment(question, environment, answers, parameters));
            }
        }
        adjust(&mut rows[first..])?;
    }
    Ok(AnswersCompared {
        contrasts: as_table(&rows)?.with_mark(parameters.simulated),
        participants: of_participants(&rows, &names)?.with_mark(parameters.simulated),
    })
}

/// The scored answers by question and environment, and the names of the participants.
fn by_question<'p>(
    answers: &Table,
    parameters: &'p AnswerParameters,
) -> Result<(Vec<String>, ByQuestion<'p>), CompareError> {
    let texts = |name| answers.texts(name);
    let (participants, sessions) = (texts("participant")?, texts("session")?);
    let (environments, modes, questions) =
        (texts("environment")?, texts("mode")?, texts("question")?);
    let values = answers.numbers("answer")?;
    let places = |names: &[Option<String>]| -> BTreeMap<Option<String>, usize> {
        let names: BTreeSet<_> = names.iter().cloned().collect();
        names.into_iter().zip(0..).collect()
    };
    let (people, times) = (places(&participants), places(&sessions));
    let mut found: BTreeMap<_, Answers> = BTreeMap::new();
    for row in 0..answers.height() {
        let is = |id: &str, of: &[Option<String>]| of[row].as_deref() == Some(id);
        let question = parameters.questions.iter().find(|q| is(q.id.as_str(), &questions));
        let environment = parameters.environments.iter().find(|e| is(e.as_str(), &environments));
        let mode = parameters.modes.iter().position(|m| is(m.as_str(), &modes));
        let value = values[row].and_then(|value| AnswerValue::new(value).ok());
        let (Some(question), Some(environment), Some(mode), Some(value)) =
            (question, environment, mode, value)
        else {
            continue;
        };
        let scored = question.scale.score(value, question.reversed);
        if !question.scale.has(scored) {
            continue;
        }
        let of = found.entry((question.id.as_str(), environment.as_str())).or_default();
        of.participant.push(people[&participants[row]]);
        of.session.push(times[&sessions[row]]);
        of.mode.push(mode);
        of.value.push(scored);
    }
    Ok((people.into_keys().map(Option::unwrap_or_default).collect(), found))
}

/// The contrasts of one question in one environment of which both modes were answered.
fn of_environment<'a>(
    question: &'a Question,
    environment: &'a EnvironmentId,
    answers: &Answers,
    parameters: &'a AnswerParameters,
) -> Vec<Row<'a>> {
    let place = |mode: &ModeId| parameters.modes.iter().position(|m| m == mode);
    let pairs = parameters.contrasts.iter().filter_map(|contrast| {
        let pair = [place(&contrast.mode)?, place(&contrast.against)?];
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
                let ratio = ratio.map_err(|why| name_modes(why, &parameters.modes));
                let any = (comparison.p_value(), comparison.bootstrap.is_some());
                (ratio.map(Model::Odds), None, Some(any))
            }
            Some(Err(why)) => (Err(why.clone()), None, None),
            None => {
                let Difference { estimate, tested } =
                    quantity::difference(&scores(answers), pair, parameters.level);
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

/// The answers as numbers.
fn scores(answers: &Answers) -> Vec<Score> {
    let rows = 0..answers.value.len();
    let score = |row: usize| Score {
        participant: answers.participant[row],
        session: answers.session[row],
        mode: answers.mode[row],
        value: answers.value[row].into(),
    };
    rows.map(score).collect()
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
    };
    let pairs: Vec<[usize; 2]> = pairs.iter().map(|(_, pair)| *pair).collect();
    let compared = compare_modes(&study, &pairs, parameters.level, SEED);
    compared.map_err(|why| name_modes(why, &parameters.modes))
}

/// The same reason with the modes' names in the place of their numbers.
fn name_modes(why: Unestimable, modes: &[ModeId]) -> Unestimable {
    let named = |what: String| {
        let numbered = modes.iter().enumerate().rev();
        numbered.fold(what, |what, (number, mode)| {
            what.replace(&format!("mode {number}"), mode.as_str())
        })
    };
    match why {
        Unestimable::Separated { what } => Unestimable::Separated { what: named(what) },
        Unestimable::Confounded { what } => Unestimable::Confounded { what: named(what) },
        other => other,
    }
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

/// The tests of one question are one family.
fn adjust(rows: &mut [Row]) -> Result<(), CompareError> {
    let p = |row: &Row| row.model.as_ref().ok().map(Model::p_value);
    let adjusted = holm::adjusted(&rows.iter().filter_map(p).collect::<Vec<_>>())?;
    for (row, p) in rows.iter_mut().filter(|row| row.model.is_ok()).zip(adjusted) {
        row.p_adjusted = Some(p);
    }
    Ok(())
}

fn as_table(rows: &[Row]) -> Result<Table, CompareError> {
    let texts = |name, description, of: fn(&Row) -> Option<String>| {
        Column::text(name, description, rows.iter().map(of))
    };
    let numbers = |name, description, of: fn(&Row) -> Option<f64>| {
        Column::float(name, "1", description, rows.iter().map(of))
    };
    let effect = |row: &Row| row.effect.as_ref().ok().cloned();
    let mut all = vec![
        texts("question", "the question", |row| Some(row.question.id.to_string())),
        texts("environment", "what was rendered", |row| Some(row.environment.to_string())),
        columns::contrasts(rows.iter().map(|row| row.contrast)),
        Column::integer(
            "n",
            "1",
            "participants with both modes",
            rows.iter().map(|row| {
                whole(effect(row)?.shares.iter().filter(|share| share.is_some()).count())
            }),
        ),
        Column::integer("answers", "1", "answers", rows.iter().map(|row| whole(row.answers))),
        Column::float(
            "superiority",
            "1",
            "P(A > B) + ½ P(A = B), mean over participants: ½ where neither is above the other",
            rows.iter().map(|row| Some(effect(row)?.probability)),
        ),
        Column::float(
            "superiority_ci_low",
            "1",
            "lower end of its interval over participants",
            rows.iter().map(|row| Some(effect(row)?.interval.ok()?.0)),
        ),
        Column::float(
            "superiority_ci_high",
            "1",
            "upper end of its interval over participants",
            rows.iter().map(|row| Some(effect(row)?.interval.ok()?.1)),
        ),
        numbers("odds_ratio", "odds of a higher answer, for one person", |row| {
            row.odds()?.estimate
        }),
        numbers(
            "odds_ratio_ci_low",
            "lower end of its profile interval; none: see remark",
            |row| row.odds()?.interval.low.value(),
        ),
        numbers("odds_ratio_ci_high", "upper end; none: see remark", |row| {
            row.odds()?.interval.high.value()
        }),
        numbers("p_value", "p value of an odds ratio of one (likelihood ratio over F)", |row| {
            Some(row.model.as_ref().ok()?.p_value())
        }),
        numbers("p_adjusted", "the same, adjusted over the question by Holm", |row| row.p_adjusted),
        numbers("p_any", "p value of no difference between any modes", |row| Some(row.any?.0)),
        texts("test_any", "how that was found", |row| {
            Some(if row.any?.1 { "bootstrap" } else { "F" }.to_owned())
        }),
        texts(
            "remark",
            "why there is no model or odds ratio, or an end of its interval is missing",
            |row| match &row.model {
                Ok(Model::Odds(ratio)) => ratio.remark(),
                Ok(Model::Means(_)) => None,
                Err(why) => Some(why.to_string()),
            },
        ),
    ];
    let is_long = |row: &Row| !row.question.scale.is_ordinal();
    if rows.iter().any(is_long) {
        all.extend([
            texts("model", "what the contrast is tested by", |row| Some(row.model_words())),
            numbers("difference", "mean difference, points of the scale", |row| row.difference),
            numbers("difference_ci_low", "lower end of its interval", |row| {
                Some(row.means()?.ci_low)
            }),
            numbers("difference_ci_high", "upper end of its interval", |row| {
                Some(row.means()?.ci_high)
            }),
        ]);
    }
    let title = "Answers compared: effects over participants, odds ratios for one person";
    let mut table = Table::new("answers_compared", title, all)?;
    if rows.iter().any(is_long) {
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

/// The participants' effects in one contrast, of those who answered in both modes.
fn shares<'r>(row: &'r Row<'r>) -> impl Iterator<Item = (&'r Row<'r>, usize, f64)> {
    let shares = row.effect.as_ref().map(|effect| effect.shares.as_slice()).unwrap_or_default();
    let everybody = row.people.iter().zip(shares);
    everybody.filter_map(move |(who, share)| Some((row, *who, (*share)?)))
}

/// Everybody's effect in each contrast.
fn of_participants(rows: &[Row], names: &[String]) -> Result<Table, CompareError> {
    let all: Vec<(&Row, usize, f64)> = rows.iter().flat_map(shares).collect();
    let texts = |name, description, of: fn(&Row) -> String| {
        Column::text(name, description, all.iter().map(|(row, ..)| Some(of(row))))
    };
    let columns = vec![
        texts("question", "the question", |row| row.question.id.to_string()),
        texts("environment", "what was rendered", |row| row.environment.to_string()),
        columns::contrasts(all.iter().map(|(row, ..)| row.contrast)),
        Column::text("participant", "who", all.iter().map(|(_, who, _)| Some(&*names[*who]))),
        Column::float(
            "superiority",
            "1",
            "P(A > B) + ½ P(A = B) over the pairs of this participant's answers",
            all.iter().map(|(_, _, share)| Some(*share)),
        ),
    ];
    let title = "Answers compared: each participant's effect";
    Ok(Table::new("answers_participants", title, columns)?)
}
