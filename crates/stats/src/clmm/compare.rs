//! The modes of a study compared by their answers on a scale.

use super::fit::{fit, highest, settled};
use super::likelihood::Integral;
use super::model::{Model, Terms};
use super::profile::{End, ProfileInterval, bound_at_limit, profile_interval};
use super::ratio::{RatioTest, referred, test_columns};
use super::resample::{Bootstrap, bootstrap};
use crate::answers::{Answers, Column, DIRECTION_ROUNDING};
use crate::error::check_level;
use crate::student_t::critical_value;
use crate::tested::{Unestimable, at_least};
use std::collections::BTreeSet;

/// Below this many participants no approximation is relied on: a bootstrap decides.
const FEW: usize = 8;
/// From this many participants on Laplace's approximation does.
const MANY: usize = 100;
/// Studies that the bootstrap draws: p is a multiple of a thousandth.
const RESAMPLES: usize = 999;
/// Where the coefficient of a separated mode is held, in logits: what the likelihood still lacks of
/// its limit is a rounding error, e^−40 for each answer.
const LIMIT: f64 = 40.0;

/// The answers of one environment's trials, one row each; all slices are of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeStudy<'a> {
    /// The answers, from 1 to `points`.
    pub answers: &'a [u8],
    /// Points of the scale.
    pub points: u8,
    /// The participant of each answer: any numbers that tell participants apart.
    pub participants: &'a [usize],
    /// The mode of each answer: numbers that are indices of names.
    pub modes: &'a [usize],
    /// The participant's session of each answer.
    pub sessions: &'a [usize],
    /// The names of the modes, for messages; a mode without a name is given by its number.
    pub mode_names: &'a [&'a str],
}

impl ModeStudy<'_> {
    fn mode_name(&self, mode: usize) -> String {
        self.mode_names.get(mode).map_or_else(|| format!("mode {mode}"), |name| (*name).to_owned())
    }
}

/// How answers in one mode compare with those in another, for one person.
#[derive(Debug, Clone, PartialEq)]
pub struct OddsRatio {
    /// Odds of a higher answer in the mode over those in the other, for one person. No average over
    /// people: that is smaller the more they differ. `None` where the answers separate the two, so
    /// that it is 0 or infinite.
    pub estimate: Option<f64>,
    /// Its profile interval; open on the side of a ratio without an end.
    pub interval: ProfileInterval,
    /// The likelihood-ratio test of "the ratio is one".
    pub test: RatioTest,
}

impl OddsRatio {
    /// In words, why there is no estimate, or no end of the interval.
    pub fn remark(&self) -> Option<String> {
        let remark = self.interval.remark();
        match (self.estimate, remark) {
            (None, Some(remark)) => Some(format!(
                "the answers separate the two modes, so there is no odds ratio; {remark}"
            )),
            (_, remark) => remark,
        }
    }
}

/// Modes compared by a cumulative-link model with participant and participant × mode (participant
/// alone where nobody answered twice in a mode), and sessions as fixed effects.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeComparison {
    /// The maximum of the log-likelihood, or the limit that it nears where modes are separated.
    pub log_likelihood: f64,
    /// SD of the participants' effects, on the scale of the logits.
    pub sd_participant: f64,
    /// How the effects of people were integrated out.
    pub integral: Integral,
    /// Participants.
    pub participants: usize,
    /// The test of "no mode differs from another".
    pub test: RatioTest,
    /// The bootstrap of that test, for fewer than 8 participants.
    pub bootstrap: Option<Bootstrap>,
    /// One per requested pair.
    pub odds_ratios: Vec<Result<OddsRatio, Unestimable>>,
}

impl ModeComparison {
    /// The p value of "no mode differs from another" that decides: the bootstrap's where there is
    /// one, else that of the F distribution.
    pub fn p_value(&self) -> f64 {
        self.bootstrap.map_or(self.test.f.p_value, |bootstrap| bootstrap.p_value)
    }
}

/// Compares the modes of each pair, with intervals at confidence `level`; `seed` is the key of the
/// bootstrap.
///
/// A mode whose answers lie beyond all others' has no finite coefficient. It is then held where
/// the likelihood has reached its limit, so that all other estimates, and the likelihood ratios,
/// are those of the limit (Rockafellar's recession direction, as in `separation`).
///
/// # Errors
/// Fewer than two modes or participants, and all reasons of [`Model::new`] and [`fit`] why there is
/// no estimate of anything; `level` outside (0, 1).
pub fn compare_modes(
    study: &ModeStudy,
    pairs: &[[usize; 2]],
    level: f64,
    seed: u64,
) -> Result<ModeComparison, Unestimable> {
    // The searches take long, and the level is needed after them.
    check_level(level)?;
    let modes = levels(study.modes);
    at_least("modes", modes.len(), 2)?;
    let model = &coded(study, study.modes, [modes[0], modes[1]])?;
    let participants = model.participants();
    let integral = match participants {
        MANY.. => Integral::Laplace,
        _ => Integral::Quadrature,
    };
    let (_, peak) = settled(model, integral)?;
    // `coded` puts the columns of modes before those of sessions.
    let effects: Vec<usize> = (0..modes.len() - 1).collect();
    let (_, without) = highest(&model.without(&effects), integral)?;
    let test =
        compared(peak.log_likelihood, without.log_likelihood, effects.len(), model.mode_df())?;
    // Answers that the bootstrap draws need not be separated: all coefficients are free.
    let free = model.with(model.answers.clone());
    let bootstrap = (participants < FEW)
        .then(|| bootstrap(&free, Integral::Laplace, &effects, RESAMPLES, seed))
        .transpose()?;
    Ok(ModeComparison {
        log_likelihood: peak.log_likelihood,
        // The search lets SDs have any sign.
        sd_participant: peak.coordinates[peak.coordinates.len() - 2].abs(),
        integral,
        participants,
        test,
        bootstrap,
        odds_ratios: pairs.iter().map(|pair| odds_ratio(study, *pair, integral, level)).collect(),
    })
}

/// The odds ratio of the first mode of a pair over the second.
fn odds_ratio(
    study: &ModeStudy,
    pair: [usize; 2],
    integral: Integral,
    level: f64,
) -> Result<OddsRatio, Unestimable> {
    if let Some(mode) = pair.iter().find(|mode| !study.modes.contains(mode)) {
        return Err(Unestimable::Confounded { what: study.mode_name(*mode) });
    }
    let model = coded(study, study.modes, pair)?;
    let df = model.mode_df();
    let column = 0; // `coded` puts the pair's own column first
    let Some(held) = model.held[column] else {
        let fit = fit(&model, integral)?;
        // The column says what the second mode adds to the first: the ratio is turned round.
        return Ok(OddsRatio {
            estimate: Some(libm::exp(-fit.coefficients[column])),
            interval: profile_interval(&model, integral, &fit, column, level, df)?.of_turned_odds(),
            test: test_columns(&model, integral, &fit, &[column], df)?,
        });
    };
    let (_, peak) = settled(&model, integral)?;
    let end = bound_at_limit(&model, integral, &peak, column, critical_value(level, df)?);
    let [low, high] = if held > 0.0 { [end, End::Open] } else { [End::Open, end] };
    // The two modes as one, the others as they are.
    let merged = study.modes.iter().map(|mode| if *mode == pair[1] { pair[0] } else { *mode });
    let merged: Vec<usize> = merged.collect();
    let other = levels(&merged).into_iter().find(|mode| *mode != pair[0]);
    let alike = match other {
        Some(other) => coded(study, &merged, [pair[0], other])?,
        None => model.without(&[column]),
    };
    let (_, alike) = settled(&alike, integral)?;
    Ok(OddsRatio {
        estimate: None,
        interval: ProfileInterval { low, high }.of_turned_odds(),
        test: compared(peak.log_likelihood, alike.log_likelihood, 1, df)?,
    })
}

/// The likelihood ratio of two models that differ by `columns`.
fn compared(larger: f64, smaller: f64, columns: usize, df: f64) -> Result<RatioTest, Unestimable> {
    Ok(referred(2.0 * (larger - smaller).max(0.0), columns as f64, df)?)
}

/// Codes `labels`, the modes or what stands for them, by columns of 0 and 1: what the second of
/// the pair adds to the first, then what the others add. Random effects are those of the modes.
/// The first column is held where the answers separate the two of the pair.
fn coded(study: &ModeStudy, labels: &[usize], pair: [usize; 2]) -> Result<Model, Unestimable> {
    let mut order = levels(labels);
    order.retain(|mode| !pair.contains(mode));
    let order: Vec<usize> = pair.into_iter().chain(order).collect();
    let sessions: Vec<usize> = levels(study.sessions).into_iter().skip(1).collect();
    let sessions = indicators(|session| format!("session {session}"), study.sessions, &sessions);
    let mut columns = indicators(|mode| study.mode_name(mode), labels, &order[1..]);
    columns.extend(sessions.iter().cloned());
    let answers = Answers::new(study.answers, study.points, &columns)?;
    let Some(direction) = answers.separated_along()? else {
        return Model::unscreened(study.participants, study.modes, answers, terms(study));
    };
    let (modes, rest) = direction.split_at(order.len() - 1);
    let largest = modes.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
    let rounding = DIRECTION_ROUNDING * largest;
    if largest <= 0.0 || rest.iter().any(|step| step.abs() > rounding) {
        return Err(Unestimable::Separated { what: answers.names(&direction) });
    }
    // Modes that go the same way stay where they are to each other. One of each such group is
    // held against the first mode, far away; the others are coded against that one.
    let steps: Vec<f64> = [0.0].iter().chain(modes).copied().collect();
    let mut leaders: Vec<(usize, f64)> = vec![(order[0], 0.0)];
    let mut columns = Vec::new();
    let mut held = Vec::new();
    for (mode, step) in order.iter().zip(&steps).skip(1) {
        if leaders.iter().any(|(_, other)| (other - step).abs() <= rounding) {
            columns.extend(indicators(|mode| study.mode_name(mode), labels, &[*mode]));
            held.push(None);
            continue;
        }
        leaders.push((*mode, *step));
        let group = order.iter().zip(&steps).filter(|(_, other)| (*other - step).abs() <= rounding);
        let group: Vec<usize> = group.map(|(mode, _)| *mode).collect();
        columns.push(Column {
            name: study.mode_name(*mode),
            values: labels.iter().map(|mode| f64::from(u8::from(group.contains(mode)))).collect(),
        });
        held.push(Some(*step));
    }
    // The direction says how the modes go to infinity, not how far: the nearest goes to the limit.
    let smallest = held.iter().flatten().fold(largest, |least, step| least.min(step.abs()));
    held.iter_mut().flatten().for_each(|step| *step *= LIMIT / smallest);
    held.resize(held.len() + sessions.len(), None);
    columns.extend(sessions);
    let answers = Answers { columns, ..answers };
    let mut model = Model::unscreened(study.participants, study.modes, answers, terms(study))?;
    model.held = held;
    Ok(model)
}

/// Participant and participant × mode; participant alone where nobody answered twice in a mode, so
/// that nothing tells a participant's own effect of a mode from the scatter of answers.
fn terms(study: &ModeStudy) -> Terms {
    let cells: BTreeSet<_> = study.participants.iter().zip(study.modes).collect();
    if cells.len() < study.answers.len() { Terms::ParticipantAndMode } else { Terms::Participant }
}

/// The different labels, rising.
fn levels(labels: &[usize]) -> Vec<usize> {
    labels.iter().copied().collect::<BTreeSet<_>>().into_iter().collect()
}

/// A column per level: 1 where the label is the level.
fn indicators(name: impl Fn(usize) -> String, labels: &[usize], levels: &[usize]) -> Vec<Column> {
    levels
        .iter()
        .map(|level| Column {
            name: name(*level),
            values: labels.iter().map(|label| f64::from(u8::from(label == level))).collect(),
        })
        .collect()
}
