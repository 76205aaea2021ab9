//! What a participant is like: lasting properties are drawn once, those of the day once per
//! session.

use super::draw::{Draw, Purpose};
use serde::{Deserialize, Serialize};
use zwidth_dynamics::{Hand, Tissue, table3};

/// K, B and M of hand and finger: range over participants, assumed. Default 290 N/m, 3 N s/m, 0.08
/// kg (`docs/twin.md`).
pub const HAND_RANGES: [[f64; 2]; 3] = [[100.0, 600.0], [1.0, 8.0], [0.03, 0.2]];

/// How a number is spread over people and days.
#[derive(Debug, Clone, Copy)]
struct Spread {
    /// Of all people.
    mean: f64,
    /// Standard deviation of what lasts, over people.
    sd: f64,
    /// Correlation of two days of the same people (ICC): σ²/(σ² + σ_day²).
    days: f64,
}

/// When it begins to move, s. Mean assumed; the others from Wells et al. 2014 (J. Sports Sci. Med.
/// 13:145, visual reaction time of 42 people on days apart): ICC 0.84, and SEM 0.033 s, of which
/// √(0.84 · 0.033² / 0.16) is what lasts.
const ONSET_S: Spread = Spread { mean: 0.3, sd: 0.076, days: 0.84 };
/// How long movements take, as a share of the usual. SD assumed; between days as Little et al. 2015
/// (J. NeuroEng. Rehab. 12:78, Table 3, right arm, a week apart): 0.76 for movement time, 0.83 for
/// the greatest speed.
const PACE: Spread = Spread { mean: 1.0, sd: 0.08, days: 0.8 };
/// Angle at which it turns back, rad. Mean: 32°, where the thesis' participant turned with motor
/// and hybrid (§5.3.1.3); SD assumed, 1.7°; between days as the pace.
const REACH_RAD: Spread = Spread { mean: 32.0 * DEGREE_RAD, sd: 1.7 * DEGREE_RAD, days: PACE.days };
/// How much higher it answers than others, points of five. SD assumed; between days what the kappas
/// of rating scales asked twice, 6 to 24 days apart, are: 0.50 to 0.64 (Tourangeau et al. 2019,
/// Tob. Control 28:663, Table 7).
const BIAS: Spread = Spread { mean: 0.0, sd: 0.35, days: 0.6 };

const DEGREE_RAD: f64 = std::f64::consts::PI / 180.0;

/// Usual durations, s, of a pace of 1: forward, waiting for the goal, letting go, and back.
const FORWARD_S: f64 = 1.35;
const WAIT_S: f64 = 0.2;
const LET_GO_S: f64 = 0.5;
const BACK_S: f64 = 1.1;

/// A participant in a session. Numbers without a source are assumed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// What its trials are drawn from: another in each session.
    pub seed: u64,
    /// How many trials it went through in earlier sessions.
    pub practised: u32,
    /// Impedance of hand and finger.
    pub hand: Hand,
    /// How long it waits before it moves, s.
    pub onset_s: f64,
    /// How long the forward movement takes, s.
    pub forward_s: f64,
    /// How long it goes on after that while the goal is not reached, s.
    pub wait_s: f64,
    /// In how much time it lets go of its force before it turns back, s.
    pub let_go_s: f64,
    /// How long the backward movement takes, s.
    pub back_s: f64,
    /// The angle at which it means to turn back, rad; less where there is less room.
    pub reach_rad: f64,
    /// How hard it presses on a wall, above what brings it there, N.
    pub press_n: f64,
    /// Force above which it gives way, N.
    pub comfort_n: f64,
    /// Reaction time, s.
    pub reaction_s: f64,
    /// Standard deviation of its durations from repeat to repeat, as a share.
    pub spread: f64,
    /// How much higher than others it answers, points of a five-point scale.
    pub bias: f64,
    /// Share of trials that it gives up on the way.
    pub gives_up: f64,
    /// Share of questions that it leaves open.
    pub is_silent: f64,
}

impl Person {
    /// Someone with the default hand and the middle of every range.
    pub fn typical(seed: u64) -> Self {
        Self {
            seed,
            practised: 0,
            hand: hand([290.0, 3.0, 0.08]),
            onset_s: ONSET_S.mean,
            forward_s: FORWARD_S,
            wait_s: WAIT_S,
            let_go_s: LET_GO_S,
            back_s: BACK_S,
            reach_rad: REACH_RAD.mean,
            press_n: 1.6,
            comfort_n: 8.0,
            reaction_s: 0.15,
            spread: 0.05,
            bias: BIAS.mean,
            gives_up: 0.0,
            is_silent: 0.0,
        }
    }

    /// What lasts of the participant of a seed.
    pub fn draw(seed: u64) -> Self {
        let mut draw = Draw::new(seed, Purpose::Person, 0);
        let hand = hand(HAND_RANGES.map(|range| draw.scaled(range)));
        // The order of the draws is fixed: another one would make other people of the same seeds.
        let [onset_s, pace, reach_rad, bias] = [ONSET_S, PACE, REACH_RAD, BIAS]
            .map(|spread| spread.mean + spread.sd * draw.moderate());
        let lasting = Self { hand, onset_s, reach_rad, bias, ..Self::typical(seed) }.at(pace);
        Self {
            press_n: draw.between([1.4, 1.9]),
            comfort_n: draw.between([7.5, 8.5]),
            reaction_s: draw.between([0.12, 0.18]),
            spread: draw.between([0.03, 0.06]),
            ..lasting
        }
    }

    /// The same on the day of a session, whose seed this is, after so many trials in earlier
    /// sessions. What was learned there stays, as it does over a week (Little et al. 2015: no
    /// learning between the second session and the third) and after few trials (Huberdeau, Haith &
    /// Krakauer 2015, J. Neurophysiol. 114:969).
    pub fn in_session(self, seed: u64, practised: u32) -> Self {
        let mut draw = Draw::new(seed, Purpose::Day, 0);
        let [onset_s, pace, reach_rad, bias] = [ONSET_S, PACE, REACH_RAD, BIAS].map(|spread| {
            // Standard deviation from day to day of one person: ICC = σ²/(σ² + σ_day²).
            let day_sd = spread.sd * ((1.0 - spread.days) / spread.days).sqrt();
            day_sd * draw.moderate()
        });
        let today = Self {
            seed,
            practised,
            onset_s: self.onset_s + onset_s,
            reach_rad: self.reach_rad + reach_rad,
            bias: self.bias + bias,
            ..self
        };
        today.at(1.0 + pace)
    }

    /// The same person, who does not always follow instructions: one trial in 25 is abandoned, one
    /// question in 30 stays open (assumed).
    pub fn untidy(self) -> Self {
        Self { gives_up: 1.0 / 25.0, is_silent: 1.0 / 30.0, ..self }
    }

    /// The same with movements that take so many times as long.
    fn at(self, pace: f64) -> Self {
        let Self { forward_s, let_go_s, back_s, .. } = self;
        Self {
            forward_s: pace * forward_s,
            let_go_s: pace * let_go_s,
            back_s: pace * back_s,
            ..self
        }
    }

    /// How far the hand is pressed back by a newton, tissue and impedance in series, m/N.
    pub(crate) fn compliance_m_per_n(&self) -> f64 {
        1.0 / self.hand.stiffness_n_per_m + 1.0 / self.hand.tissue.stiffness_n_per_m
    }

    /// Whether it gives a trial up on the way.
    pub(crate) fn gives_up(&self, trial: u32) -> bool {
        Draw::new(self.seed, Purpose::GivingUp, u64::from(trial)).unit() < self.gives_up
    }

    /// Whether it leaves the question of a trial open.
    pub(crate) fn is_silent(&self, trial: u32) -> bool {
        Draw::new(self.seed, Purpose::Silence, u64::from(trial)).unit() < self.is_silent
    }
}

/// A hand of K, B and M with the fingertip of Table 3.
fn hand([stiffness_n_per_m, damping_ns_per_m, mass_kg]: [f64; 3]) -> Hand {
    let tissue = Tissue {
        stiffness_n_per_m: table3::FINGER_STIFFNESS_N_PER_M,
        damping_ns_per_m: table3::FINGER_DAMPING_NS_PER_M,
    };
    Hand { mass_kg, stiffness_n_per_m, damping_ns_per_m, tissue }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn participants_differ_and_stay_within_what_hands_can() {
        let people: Vec<Person> = (0..200).map(Person::draw).collect();
        let stiffness: Vec<f64> = people.iter().map(|p| p.hand.stiffness_n_per_m).collect();
        assert!(stiffness.iter().any(|k| *k < 150.0) && stiffness.iter().any(|k| *k > 450.0));
        assert!(stiffness.iter().all(|k| (100.0..=600.0).contains(k)));
    }

    #[test]
    fn tissue_and_impedance_give_way_in_series() {
        let expected = 1.0 / 290.0 + 1.0 / 584.6;
        assert!((Person::typical(1).compliance_m_per_n() - expected).abs() < 1e-15);
    }

    type Number = fn(&Person) -> f64;

    /// Pearson's correlation of a number on two days of many people.
    fn between_days(number: Number) -> f64 {
        let pairs: Vec<[f64; 2]> = (0..4000)
            .map(|seed| [1, 2].map(|day| number(&Person::draw(seed).in_session(2 * seed + day, 0))))
            .collect();
        let n = pairs.len() as f64;
        let mean = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / n);
        let sum = |i: usize, j: usize| -> f64 {
            pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum()
        };
        sum(0, 1) / (sum(0, 0) * sum(1, 1)).sqrt()
    }

    #[test]
    fn two_days_of_a_person_are_as_alike_as_the_source_says_and_no_more() {
        let expected: [(Number, f64); 4] = [
            (|person| person.onset_s, 0.84),
            (|person| person.forward_s, 0.8),
            (|person| person.reach_rad, 0.8),
            (|person| person.bias, 0.6),
        ];
        for (number, icc) in expected {
            let found = between_days(number);
            assert!((found - icc).abs() < 0.03, "{found} instead of {icc}");
        }
    }

    #[test]
    fn the_hand_lasts_and_trials_are_drawn_anew() {
        let person = Person::draw(7);
        let [first, second] = [1, 2].map(|day| person.in_session(day, 36));
        assert_eq!((first.hand, first.press_n), (second.hand, second.press_n));
        assert!(first.seed != second.seed && second.practised == 36);
    }

    #[test]
    fn nobody_gives_up_or_is_silent_but_the_untidy() {
        let count = |person: &Person| {
            let trials = || 1..2000;
            [
                trials().filter(|trial| person.gives_up(*trial)).count(),
                trials().filter(|trial| person.is_silent(*trial)).count(),
            ]
        };
        assert_eq!(count(&Person::draw(3)), [0, 0]);
        let [given_up, silent] = count(&Person::draw(3).untidy());
        assert!((50..110).contains(&given_up) && (40..95).contains(&silent), "{given_up} {silent}");
    }
}
