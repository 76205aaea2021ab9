//! The eight terms that a model may have on top of a rigid lever, and sets of them.

use serde::Serialize;
use zwidth_dynamics::ModelScene;

/// A term of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum LadderTerm {
    /// The lever's weight, m g r sin θ.
    Gravity,
    /// The fingertip between the user's force and the lever.
    Finger,
    /// Dry and viscous friction of the drive train, the closed winding's damping with it.
    Friction,
    /// The motor's force follows its command through L_m/R.
    MotorLag,
    /// The brake's level follows its command through an air gap.
    BrakeLag,
    /// The controller acts once a period and holds its command.
    Sampling,
    /// What the controller asks for acts later.
    Delay,
    /// Counted angle, filtered velocity, slow and noisy force.
    Sensors,
}

impl LadderTerm {
    /// Every term, in the order in which they are added.
    pub const ALL: [Self; 8] = [
        Self::Gravity,
        Self::Finger,
        Self::Friction,
        Self::MotorLag,
        Self::BrakeLag,
        Self::Sampling,
        Self::Delay,
        Self::Sensors,
    ];

    /// Its word in tables and files.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Finger => "finger",
            Self::Friction => "friction",
            Self::MotorLag => "motor_lag",
            Self::BrakeLag => "brake_lag",
            Self::Sampling => "sampling",
            Self::Delay => "delay",
            Self::Sensors => "sensors",
        }
    }

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

    /// The terms that a scene can have: a finger only if something is between hand and lever, a
    /// lag only of an actuator that its mode uses. A scene without the part cannot need the term.
    pub fn possible(scene: &ModelScene) -> Self {
        let by_motor = scene.mode.by_motor();
        let mut set = Self::ALL;
        if scene.finger.is_none() {
            set = set.without(LadderTerm::Finger);
        }
        if !by_motor.contains(&true) {
            set = set.without(LadderTerm::MotorLag);
        }
        if !by_motor.contains(&false) {
            set = set.without(LadderTerm::BrakeLag);
        }
        set
    }

    /// The terms whose numbers a scene gives, and those of the digital loop, which has the period
    /// that was asked for. The numbers of the others are the simulated device's.
    pub fn in_scene(scene: &ModelScene) -> Self {
        let has = |term: &LadderTerm| match term {
            LadderTerm::Gravity => scene.terms.iter().any(|term| term.name() == "gravity"),
            LadderTerm::Finger => scene.finger.is_some(),
            LadderTerm::Friction => scene.friction.is_some(),
            LadderTerm::MotorLag => scene.motor.lag_s.is_some(),
            LadderTerm::BrakeLag => scene.brake.lag_on_off_s.is_some(),
            LadderTerm::Sampling | LadderTerm::Delay | LadderTerm::Sensors => true,
        };
        LadderTerm::ALL.into_iter().filter(has).fold(Self::NONE, Self::with)
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
        LadderTerm::ALL.into_iter().filter(move |term| self.has(*term))
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

    /// Its words, `friction sampling`; `rigid` if it has no terms.
    pub fn words(self) -> String {
        let words: Vec<&str> = self.terms().map(LadderTerm::as_str).collect();
        if words.is_empty() { "rigid".to_owned() } else { words.join(" ") }
    }

    /// The set of words as [`TermSet::words`] writes them.
    pub fn of_words(words: &str) -> Option<Self> {
        if words == "rigid" {
            return Some(Self::NONE);
        }
        let term = |word: &str| LadderTerm::ALL.into_iter().find(|term| term.as_str() == word);
        words.split(' ').try_fold(Self::NONE, |set, word| term(word).map(|term| set.with(term)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_set_survives_its_number_and_its_words() {
        for number in 0..TermSet::COUNT {
            let set = TermSet::of_number(number);
            assert_eq!(set.number(), number);
            assert_eq!(TermSet::of_words(&set.words()), Some(set));
            assert_eq!(set.terms().count(), set.len());
        }
        assert_eq!(TermSet::of_words("friction magic"), None);
    }

    #[test]
    fn a_set_without_what_it_had_is_within_it() {
        let set = TermSet::NONE.with(LadderTerm::Delay).with(LadderTerm::Friction);
        let smaller = set.without(LadderTerm::Delay);
        assert!(smaller.is_within(set) && !set.is_within(smaller) && smaller.len() == 1);
    }
}
