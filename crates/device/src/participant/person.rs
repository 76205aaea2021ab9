//! What a participant is like: drawn once, the same in every trial.

use super::draw::{Draw, Purpose};
use serde::{Deserialize, Serialize};
use zwidth_dynamics::{Hand, Tissue, table3};

/// K, B and M of hand and finger: range over participants. Default 290 N/m, 3 N s/m, 0.08 kg; K
/// from Gurari 2017, the rest assumed (`docs/twin.md`).
pub const HAND_RANGES: [[f64; 2]; 3] = [[100.0, 600.0], [1.0, 8.0], [0.03, 0.2]];

/// A participant. Every number but the hand's stiffness is assumed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Person {
    /// Where its numbers come from; trials draw from it too.
    pub seed: u64,
    /// Impedance of hand and finger.
    pub hand: Hand,
    /// How long it waits before it moves, s.
    pub onset_s: f64,
    /// How long the forward movement takes, s.
    pub forward_s: f64,
    /// How long it stays at the far end, s.
    pub dwell_s: f64,
    /// How long the backward movement takes, s.
    pub back_s: f64,
    /// How far it means to compress an object without a wall, rad; less if its hand is too soft to
    /// do that safely.
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
}

impl Person {
    /// Someone with the default hand and the middle of every range.
    pub fn typical(seed: u64) -> Self {
        let hand = hand([290.0, 3.0, 0.08]);
        Self {
            seed,
            hand,
            onset_s: 0.3,
            forward_s: 1.3,
            dwell_s: 0.1,
            back_s: 1.3,
            reach_rad: 31.0_f64.to_radians(),
            press_n: 1.6,
            comfort_n: 8.0,
            reaction_s: 0.15,
            spread: 0.05,
            bias: 0.0,
        }
    }

    /// The participant of a seed.
    pub fn draw(seed: u64) -> Self {
        let mut draw = Draw::new(seed, Purpose::Person, 0);
        let hand = hand(HAND_RANGES.map(|range| draw.scaled(range)));
        Self {
            seed,
            hand,
            onset_s: draw.between([0.2, 0.35]),
            forward_s: draw.between([1.15, 1.45]),
            dwell_s: draw.between([0.05, 0.15]),
            back_s: draw.between([1.15, 1.45]),
            reach_rad: draw.between([28.0, 34.0]).to_radians(),
            press_n: draw.between([1.4, 1.9]),
            comfort_n: draw.between([7.5, 8.5]),
            reaction_s: draw.between([0.12, 0.18]),
            spread: draw.between([0.03, 0.06]),
            bias: 0.3 * draw.moderate(),
        }
    }

    /// How far the hand is pressed back by a newton, tissue and impedance in series, m/N.
    pub(crate) fn compliance_m_per_n(&self) -> f64 {
        1.0 / self.hand.stiffness_n_per_m + 1.0 / self.hand.tissue.stiffness_n_per_m
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
}
