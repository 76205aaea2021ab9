//! The modes of a study compared by their answers on a scale.

use super::fit::{Fit, fit};
use super::likelihood::Integral;
use super::model::{Model, Ratings, Terms};
use super::profile::{ProfileInterval, profile_interval};
use super::ratio::{RatioTest, test_columns};
use super::resample::{Bootstrap, bootstrap};
use crate::answers::Column;
use crate::error::check_level;
use crate::tested::Unestimable;
use std::collections::BTreeSet;

/// Below this many participants no approximation is relied on: a bootstrap decides.
const FEW: usize = 8;
/// From this many participants on Laplace's approximation does.
const MANY: usize = 100;
/// Studies that the bootstrap draws: p is a multiple of a thousandth.
const RESAMPLES: usize = 999;

/// The answers of one environment's trials, one row each; all slices are of one length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeStudy<'a> {
    /// The answers, from 1 to `points`.
    pub answers: &'a [u8],
    /// Points of the scale.
    pub points: u8,
    /// Who answered: any numbers that tell participants apart.
    pub participants: &'a [usize],
    /// In which mode: numbers that are indices of names.
    pub modes: &'a [usize],
    /// In which session of the participant.
    pub sessions: &'a [usize],
}

/// How answers in the reference mode compare with those in another, for one person.
#[derive(Debug, Clone, PartialEq)]
pub struct OddsRatio {
    /// The other mode.
    pub mode: usize,
    /// Odds of a higher answer in the reference mode over those in the other, for one person. No
    /// average over people: that is smaller the more they differ.
    pub estimate: f64,
    /// Its profile interval.
    pub interval: ProfileInterval,
    /// The likelihood-ratio test of "the ratio is one".
    pub test: RatioTest,
}

/// Modes compared by a cumulative-link model with participant and participant × mode (participant
/// alone where nobody answered twice in a mode), and sessions as fixed effects.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeComparison {
    /// The fitted model. Its columns: one per mode but the reference, one per session but the
    /// first.
    pub fit: Fit,
    /// How the effects of people were integrated out.
    pub integral: Integral,
    /// Participants.
    pub participants: usize,
    /// The test of "no mode differs from another".
    pub test: RatioTest,
    /// The bootstrap of that test, for fewer than 8 participants.
    pub bootstrap: Option<Bootstrap>,
    /// One per mode but the reference, in the order of their numbers.
    pub odds_ratios: Vec<OddsRatio>,
}

impl ModeComparison {
    /// The p value of "no mode differs from another" that decides: the bootstrap's where there is
    /// one, else that of the F distribution.
    pub fn p_value(&self) -> f64 {
        self.bootstrap.map_or(self.test.f.p_value, |bootstrap| bootstrap.p_value)
    }
}

/// Compares `reference` with each other mode, with intervals at confidence `level`; `seed` is the
/// key of the bootstrap.
///
/// # Errors
/// Fewer than two modes or participants, and all reasons of [`Model::new`] and [`fit`] why there is
/// no estimate; `level` outside (0, 1).
pub fn compare_modes(
    study: &ModeStudy,
    reference: usize,
    level: f64,
    seed: u64,
) -> Result<ModeComparison, Unestimable> {
    check_level(level)?;
    let modes: Vec<usize> = levels(study.modes).into_iter().filter(|&m| m != reference).collect();
    if !study.modes.contains(&reference) {
        let units = "answers in the reference mode";
        return Err(Unestimable::TooFew { units, found: 0, needed: 1 });
    }
    if modes.is_empty() {
        return Err(Unestimable::TooFew { units: "modes", found: 1, needed: 2 });
    }
    let mut columns = indicators("mode", study.modes, &modes);
    let sessions: Vec<usize> = levels(study.sessions).into_iter().skip(1).collect();
    columns.extend(indicators("session", study.sessions, &sessions));
    let ratings = Ratings {
        answers: study.answers,
        points: study.points,
        columns: &columns,
        participants: study.participants,
        modes: study.modes,
    };
    let model = Model::new(&ratings, terms(study))?;
    let participants = model.participants();
    let integral = match participants {
        MANY.. => Integral::Laplace,
        _ => Integral::Quadrature,
    };
    let fit = fit(&model, integral)?;
    let effects: Vec<usize> = (0..modes.len()).collect();
    let test = test_columns(&model, integral, &fit, &effects, model.mode_df())?;
    let few = participants < FEW;
    let drawn = few.then(|| bootstrap(&model, Integral::Laplace, &effects, RESAMPLES, seed));
    let ratio =
        |(column, &mode): (usize, &usize)| odds_ratio(&model, integral, &fit, column, mode, level);
    Ok(ModeComparison {
        integral,
        participants,
        test,
        bootstrap: drawn.transpose()?,
        odds_ratios: modes.iter().enumerate().map(ratio).collect::<Result<_, _>>()?,
        fit,
    })
}

/// Participant and participant × mode; participant alone where nobody answered twice in a mode, so
/// that nothing tells a participant's own effect of a mode from the scatter of answers.
fn terms(study: &ModeStudy) -> Terms {
    let cells: BTreeSet<_> = study.participants.iter().zip(study.modes).collect();
    if cells.len() < study.answers.len() { Terms::ParticipantAndMode } else { Terms::Participant }
}

/// The column says what the other mode adds to the reference: the ratio is turned round.
fn odds_ratio(
    model: &Model,
    integral: Integral,
    fit: &Fit,
    column: usize,
    mode: usize,
    level: f64,
) -> Result<OddsRatio, Unestimable> {
    let df = model.mode_df();
    Ok(OddsRatio {
        mode,
        estimate: libm::exp(-fit.coefficients[column]),
        interval: profile_interval(model, integral, fit, column, level, df)?.of_turned_odds(),
        test: test_columns(model, integral, fit, &[column], df)?,
    })
}

fn levels(labels: &[usize]) -> Vec<usize> {
    labels.iter().copied().collect::<BTreeSet<_>>().into_iter().collect()
}

/// A column per level: 1 where the label is the level.
fn indicators(name: &str, labels: &[usize], levels: &[usize]) -> Vec<Column> {
    let column = |level: &usize| Column {
        name: format!("{name} {level}"),
        values: labels.iter().map(|label| f64::from(u8::from(label == level))).collect(),
    };
    levels.iter().map(column).collect()
}
