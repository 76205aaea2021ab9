//! What the stage `ladder` finds: which terms of the model a scene needs, and whether the
//! recordings of a condition confirm that.

use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::{NoSuchText, texts, words, written};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{EnvironmentId, IdError, ModeId};

words! {
    /// A term that a model may have on top of a rigid lever, in the order in which they are added.
    LadderTerm {
        /// The lever's weight, m g r sin θ.
        Gravity = "gravity",
        /// The fingertip between the user's force and the lever.
        Finger = "finger",
        /// Dry and viscous friction of the drive train, the closed winding's damping with it.
        Friction = "friction",
        /// The motor's force follows its command through L_m/R.
        MotorLag = "motor_lag",
        /// The brake's level follows its command through an air gap.
        BrakeLag = "brake_lag",
        /// The controller acts once a period and holds its command.
        Sampling = "sampling",
        /// What the controller asks for acts later.
        Delay = "delay",
        /// Counted angle, filtered velocity, slow and noisy force.
        Sensors = "sensors",
    }
}

impl LadderTerm {
    /// Its name for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::MotorLag => "motor lag",
            Self::BrakeLag => "brake lag",
            other => other.as_str(),
        }
    }
}

/// A set of terms; those of a set are in a model, the others cost nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct TermSet(u8);

/// The text of a set without terms.
const RIGID: &str = "rigid";

impl TermSet {
    /// A rigid lever, its actuators and the law of the environment.
    pub const NONE: Self = Self(0);
    /// The fullest model.
    pub const ALL: Self = Self(u8::MAX);

    /// Number of all sets.
    pub const COUNT: usize = 1 << LadderTerm::ALL.len();

    /// The set with a number: bit i stands for the term i of [`LadderTerm::ALL`].
    pub fn of_number(number: usize) -> Self {
        Self(number as u8)
    }

    /// Its number.
    pub fn number(self) -> usize {
        usize::from(self.0)
    }

    /// Whether a term is in it.
    pub fn has(self, term: LadderTerm) -> bool {
        self.0 >> (term as u8) & 1 == 1
    }

    /// The set with a term.
    #[must_use]
    pub const fn with(self, term: LadderTerm) -> Self {
        Self(self.0 | 1 << (term as u8))
    }

    /// The set without a term.
    #[must_use]
    pub const fn without(self, term: LadderTerm) -> Self {
        Self(self.0 & !(1 << (term as u8)))
    }

    /// The terms that are in both sets.
    #[must_use]
    pub const fn both(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Whether every term of it is in another set.
    pub fn is_within(self, other: Self) -> bool {
        self.0 & !other.0 == 0
    }

    /// Its terms.
    pub fn terms(self) -> impl Iterator<Item = LadderTerm> {
        LadderTerm::ALL.iter().copied().filter(move |term| self.has(*term))
    }

    /// Number of its terms.
    pub fn len(self) -> usize {
        self.0.count_ones() as usize
    }

    /// Whether it has no term.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Its terms for people, `friction, motor lag`; `none` if it has no terms.
    pub fn titles(self) -> String {
        let titles: Vec<&str> = self.terms().map(LadderTerm::title).collect();
        if titles.is_empty() { "none".to_owned() } else { titles.join(", ") }
    }
}

/// `friction sampling`; `rigid` if it has no terms.
impl fmt::Display for TermSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let terms: Vec<&str> = self.terms().map(LadderTerm::as_str).collect();
        f.pad(if terms.is_empty() { RIGID.to_owned() } else { terms.join(" ") }.as_str())
    }
}

impl FromStr for TermSet {
    type Err = NoSuchText;

    fn from_str(text: &str) -> Result<Self, NoSuchText> {
        if text == RIGID {
            return Ok(Self::NONE);
        }
        let set = text.split(' ').try_fold(Self::NONE, |set, word| {
            LadderTerm::from_word(word).map(|term| set.with(term))
        });
        set.ok_or_else(|| NoSuchText(text.to_owned(), "set of terms of a ladder"))
    }
}

/// An environment in a mode, all sessions together: `spring hybrid`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct LadderCondition {
    /// What is rendered.
    pub environment: EnvironmentId,
    /// How it is rendered.
    pub mode: ModeId,
}

impl fmt::Display for LadderCondition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.environment, self.mode)
    }
}

impl FromStr for LadderCondition {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        // No id has a space.
        let (environment, mode) = text.split_once(' ').unwrap_or((text, ""));
        Ok(Self { environment: environment.parse()?, mode: mode.parse()? })
    }
}

/// What a model that is held against recordings is to the choice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TriedModel {
    /// The choice itself.
    Choice,
    /// The choice without one of its terms.
    Without(LadderTerm),
    /// The fullest model.
    Fullest,
}

impl TriedModel {
    /// The term of the choice that it lacks.
    pub fn lacks(self) -> Option<LadderTerm> {
        match self {
            Self::Without(term) => Some(term),
            Self::Choice | Self::Fullest => None,
        }
    }
}

/// How a model without a term is named, before the term.
const WITHOUT: &str = "without ";

impl fmt::Display for TriedModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Choice => f.pad("choice"),
            Self::Without(term) => write!(f, "{WITHOUT}{}", term.as_str()),
            Self::Fullest => f.pad("fullest"),
        }
    }
}

impl FromStr for TriedModel {
    type Err = NoSuchText;

    fn from_str(text: &str) -> Result<Self, NoSuchText> {
        let without = text.strip_prefix(WITHOUT).and_then(LadderTerm::from_word);
        let others = [Self::Choice, Self::Fullest].into_iter();
        let all = without.map(Self::Without).into_iter().chain(others);
        written(text, "model of a ladder", all)
    }
}

/// Whether recordings bear a choice out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BorneOut {
    /// Nothing that was tried predicts them better.
    Confirmed,
    /// The choice without a term does.
    BetterWithout(LadderTerm),
    /// The fullest model does.
    FullestIsBetter,
}

/// The words before a term without which the model is better.
const BETTER_WITHOUT: &str = "better without ";

impl fmt::Display for BorneOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Confirmed => f.pad("confirmed"),
            Self::BetterWithout(term) => write!(f, "{BETTER_WITHOUT}{}", term.title()),
            Self::FullestIsBetter => f.pad("the fullest is better"),
        }
    }
}

impl FromStr for BorneOut {
    type Err = NoSuchText;

    fn from_str(text: &str) -> Result<Self, NoSuchText> {
        let without = LadderTerm::ALL.iter().copied().map(Self::BetterWithout);
        let all = without.chain([Self::Confirmed, Self::FullestIsBetter]);
        written(text, "verdict of a ladder", all)
    }
}

texts!(TermSet, LadderCondition, TriedModel, BorneOut);

rows! {
    /// A model of a scene: its terms, what it costs, and how far it is off the fullest one.
    LadderModel = "ladder.models", "models" {
        /// the scene
        scene: Arc<str>,
        /// the model's terms; rigid for none
        terms: TermSet,
        /// how many terms it has
        number_of_terms: usize,
        /// work of a run, mean over the points: products with a flow, n for an exponential of n entries, one a decision
        evaluations: f64,
        /// steps of a run, mean over the points
        steps: f64,
        /// products with a flow, mean over the points
        products: f64,
        /// exponentials made, mean over the points
        exponentials: f64,
        /// decisions of the controller, mean over the points
        decisions: f64,
        /// largest difference to the fullest model over what can be felt, over all judged quantities and points; null where the model does not run or lacks a number
        furthest_off: Option<f64>,
        /// the quantity that is furthest off
        furthest_quantity: Option<Arc<str>>,
        /// whether no quantity is off by more than can be felt at any point
        is_enough: bool,
        /// the cheapest of those that are enough
        is_chosen: bool,
    }

    /// What a term does to a quantity, and why it is kept or not.
    TermEffect = "ladder.effects", "what each term does" {
        /// the scene
        scene: Arc<str>,
        /// what is compared
        quantity: Arc<str>,
        /// whether a bound is known for it
        is_judged: bool,
        /// the term
        term: LadderTerm,
        /// share of the variance that switching terms makes which this one has a part in, S_T
        total_effect: Option<f64>,
        /// share that it makes alone, S
        first_order: Option<f64>,
        /// the term with which it interacts most
        strongest_partner: Option<LadderTerm>,
        /// share that the two make together and neither alone
        partner_second_order: Option<f64>,
        /// how far the fullest model without it is off, over what can be felt, at the worst point
        off_without: Option<f64>,
        /// the same of the model that decides: of a term that is kept the choice without it, of one that is left out the fullest model without it, or the choice
        deciding_off: Option<f64>,
        /// whether the choice has it
        is_kept: Option<bool>,
        /// why
        reason: Option<Sentence>,
    }

    /// What two terms do to a quantity together.
    TermPair = "ladder.interactions", "which terms work together" {
        /// the scene
        scene: Arc<str>,
        /// what is compared
        quantity: Arc<str>,
        /// one term
        term: LadderTerm,
        /// the other
        other_term: LadderTerm,
        /// share of the variance that the two make together and neither alone
        second_order: Option<f64>,
    }

    /// A model that was fitted to every second trial of a condition and judged on the others.
    HeldOutModel = "ladder", "Ladder: the model each condition needs, on trials it was not fitted to" {
        /// environment and mode
        condition: LadderCondition,
        /// the choice of the ladder, it without a term, or the fullest
        model: TriedModel,
        /// its terms; rigid for none
        terms: TermSet,
        /// how many trials there are; every second one is fitted
        trials: usize,
        /// fitted inertia over the simulated device's
        inertia_factor: f64,
        /// fitted dry friction over its
        dry_factor: f64,
        /// fitted viscous friction over its
        viscous_factor: f64,
        /// fitted lags of the brake over its
        brake_lag_factor: f64,
        /// fitted weight over the middle of its range
        weight_factor: f64,
        /// error of the angle on the trials it was fitted to; null where it does not run
        fitted_rmse_rad: Option<f64> = "rad",
        /// error of the angle on the others
        held_out_rmse_rad: Option<f64> = "rad",
        /// that over the angle that is just felt
        felt_share: Option<f64>,
    }

    /// The choice of a condition: how well it and the fullest model predict, the terms that are
    /// least and most missed, and whether the recordings bear it out.
    LadderChoice = "ladder", "Ladder: the model each condition needs, on trials it was not fitted to" {
        /// environment and mode
        condition: LadderCondition,
        /// the terms of the choice; rigid for none
        terms: TermSet,
        /// how many trials there are; every second one is fitted
        trials: usize,
        /// its error on the trials it was fitted to
        fitted_rmse_rad: Option<f64> = "rad",
        /// its error on the others
        held_out_rmse_rad: Option<f64> = "rad",
        /// that over the angle that is just felt
        felt_share: Option<f64>,
        /// the fullest model's error on them
        fullest_rmse_rad: Option<f64> = "rad",
        /// the term without which it predicts best
        least_missed: Option<LadderTerm>,
        /// its error without that
        least_missed_rmse_rad: Option<f64> = "rad",
        /// the term without which it predicts worst
        most_missed: Option<LadderTerm>,
        /// its error without that
        most_missed_rmse_rad: Option<f64> = "rad",
        /// whether they bear the choice out
        recordings: Option<BorneOut>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Row as _;

    #[test]
    fn every_set_survives_its_number_and_its_text() {
        for number in 0..TermSet::COUNT {
            let set = TermSet::of_number(number);
            assert_eq!(set.number(), number);
            assert_eq!(set.to_string().parse(), Ok(set));
            assert_eq!(set.terms().count(), set.len());
        }
        assert!("friction magic".parse::<TermSet>().is_err());
    }

    #[test]
    fn a_set_without_what_it_had_is_within_it() {
        let set = TermSet::NONE.with(LadderTerm::Delay).with(LadderTerm::Friction);
        let smaller = set.without(LadderTerm::Delay);
        assert!(smaller.is_within(set) && !set.is_within(smaller) && smaller.len() == 1);
    }

    #[test]
    fn what_is_held_against_recordings_and_what_they_say_survive_their_texts() {
        let terms = LadderTerm::ALL.iter().copied();
        for model in
            terms.clone().map(TriedModel::Without).chain([TriedModel::Choice, TriedModel::Fullest])
        {
            assert_eq!(model.to_string().parse(), Ok(model));
        }
        for verdict in terms
            .map(BorneOut::BetterWithout)
            .chain([BorneOut::Confirmed, BorneOut::FullestIsBetter])
        {
            assert_eq!(verdict.to_string().parse(), Ok(verdict));
        }
        assert_eq!(
            BorneOut::BetterWithout(LadderTerm::BrakeLag).to_string(),
            "better without brake lag"
        );
        assert!("without magic".parse::<TriedModel>().is_err());
        assert!("better without brake_lag".parse::<BorneOut>().is_err());
        assert!("spring".parse::<LadderCondition>().is_err());
    }

    #[test]
    fn a_choice_comes_back_from_its_columns() {
        let choice = LadderChoice {
            condition: "spring hybrid".parse().unwrap(),
            terms: TermSet::NONE.with(LadderTerm::MotorLag),
            trials: 6,
            fitted_rmse_rad: Some(0.01),
            held_out_rmse_rad: None,
            felt_share: None,
            fullest_rmse_rad: None,
            least_missed: Some(LadderTerm::MotorLag),
            least_missed_rmse_rad: None,
            most_missed: None,
            most_missed_rmse_rad: Some(0.5),
            recordings: Some(BorneOut::BetterWithout(LadderTerm::MotorLag)),
        };
        let rows = [choice];
        assert_eq!(LadderChoice::read(&LadderChoice::columns(&rows)).unwrap(), rows);
    }
}
