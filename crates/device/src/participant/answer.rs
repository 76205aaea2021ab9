//! The answer to the question of a trial: a written rule over what was felt, with a bias and noise.
//!
//! Qualities go from 0 (nothing like it) to 1 (just like it); the answer is
//! 1 + (points − 1) · (quality + (bias + noise) / 4), rounded, and held to the scale: the place on
//! it.
//!
//! | environment | quality |
//! |---|---|
//! | spring | line · (0.3 + 0.7 · returned) · (1 − (discrepancy − 0.6 N) / 4 N) |
//! | constant force | (0.3 + 0.7 · returned) · (1 − (discrepancy − 0.6 N) / 4 N) |
//! | wall | hardness |
//! | spring and wall | √(spring's quality · hardness), hardness = 1 − (degrees past the wall) / 5°, 0 if not reached |
//! | free, or nothing rendered | 1 − greatest force / 2 N |
//!
//! line = (R² − 0.5) / 0.4 of force over angle while going in; each term held to 0…1. The weights
//! were chosen so that the modes rank as in thesis Fig. 30; they were not measured.
//!
//! An answer to the question which mode it was does not depend on what was felt: each mode and "do
//! not know" are equally likely, so the blinding index of simulated answers is 0 except for chance.

use super::draw::{Draw, Purpose};
use super::{Felt, Person};
use zwidth_study::{AnswerScale, Scene};

/// R² at which force over angle no longer seems a line at all.
const NO_LINE: f64 = 0.5;
/// R² from which on it is one.
const LINE: f64 = 0.9;
/// What is left of a spring that does not come back.
const ONE_WAY: f64 = 0.3;
/// Mean difference of both ways that is taken for the lever's own, N, and what more of it makes a
/// spring no spring.
const OWN_N: f64 = 0.6;
const NO_SPRING_N: f64 = 4.0;
/// How far a wall may be passed until it is none, rad: 5°.
const NO_WALL_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Greatest force at which free space is not free, N.
const NOT_FREE_N: f64 = 2.0;
/// Standard deviation of an answer's noise, points of a five-point scale.
const NOISE: f64 = 0.4;

/// How much what was felt is like what the environment should be, 0…1.
fn quality(felt: &Felt, scene: &Scene) -> f64 {
    match scene {
        Scene::None | Scene::Free => part(1.0 - felt.greatest_n() / NOT_FREE_N),
        Scene::Spring(_) => spring(felt),
        Scene::Force { .. } => both_ways(felt, 1.0),
        Scene::Wall { wall_rad } => hardness(felt, *wall_rad),
        Scene::SpringWall { wall_rad, .. } => (spring(felt) * hardness(felt, *wall_rad)).sqrt(),
    }
}

fn hardness(felt: &Felt, wall_rad: f64) -> f64 {
    let past_rad = felt.past_rad(wall_rad);
    if past_rad < 0.0 { 0.0 } else { part(1.0 - past_rad / NO_WALL_RAD) }
}

fn spring(felt: &Felt) -> f64 {
    both_ways(felt, part((felt.linearity() - NO_LINE) / (LINE - NO_LINE)))
}

/// How much it came back with the force that it had going in, of something that was so much like it going in.
fn both_ways(felt: &Felt, inward: f64) -> f64 {
    let back = ONE_WAY + (1.0 - ONE_WAY) * part(felt.returned());
    inward * back * part(1.0 - (felt.discrepancy_n() - OWN_N).max(0.0) / NO_SPRING_N)
}

fn part(x: f64) -> f64 {
    x.clamp(0.0, 1.0)
}

impl Person {
    /// The answer after a trial, on a scale.
    pub(crate) fn answer(&self, trial: u32, felt: &Felt, scene: &Scene, on: &AnswerScale) -> i16 {
        let points = f64::from(on.points());
        if on.is_nominal() {
            let place = Draw::new(self.seed, Purpose::Guess, u64::from(trial)).unit() * points;
            return on.answer_at(1 + place as u8);
        }
        // Bias and noise are in points of five.
        let stretch = (points - 1.0) / 4.0;
        let noise = NOISE * Draw::new(self.seed, Purpose::Answer, u64::from(trial)).moderate();
        let meant =
            1.0 + (points - 1.0) * quality(felt, scene) + stretch * self.bias + stretch * noise;
        on.answer_at(meant.round().clamp(1.0, points) as u8)
    }
}

#[cfg(test)]
mod tests {
    use super::super::felt::tests::walk;
    use super::super::intent::tests::SPRING;
    use super::*;
    use std::f64::consts::FRAC_PI_4;

    const FIVE: &AnswerScale = &AnswerScale::FivePoint;
    const WALL: Scene = Scene::SpringWall { spring: SPRING, wall_rad: 0.464 };

    fn ideal(theta: f64) -> f64 {
        4.0 * (theta + FRAC_PI_4)
    }

    #[test]
    fn an_ideal_spring_is_one_and_one_that_stays_is_not() {
        let scene = Scene::Spring(SPRING);
        assert!(quality(&walk(0.5, false, ideal, ideal), &scene) > 0.99);
        assert!(quality(&walk(0.5, true, ideal, |_| 0.0), &scene) < 0.31);
        let half = quality(&walk(0.5, false, ideal, |theta| 0.5 * ideal(theta)), &scene);
        assert!((0.6..0.9).contains(&half), "{half}");
    }

    #[test]
    fn a_constant_force_is_one_that_comes_back_whatever_its_slope() {
        let scene = Scene::Force { force_n: 2.0 };
        assert!(quality(&walk(0.5, false, |_| 2.0, |_| 2.0), &scene) > 0.99);
        assert!(quality(&walk(0.5, false, |_| 4.0, |_| 1.0), &scene) < 0.5);
        assert!(quality(&walk(0.5, true, |_| 2.0, |_| 2.0), &scene) < 0.31);
    }

    #[test]
    fn a_wall_is_hard_only_if_it_is_reached_and_not_passed() {
        assert!(quality(&walk(0.4641, false, ideal, ideal), &WALL) > 0.99);
        for top_rad in [0.44, 0.62] {
            assert!(quality(&walk(top_rad, false, ideal, ideal), &WALL) < 1e-12);
        }
        let soft = quality(&walk(0.464 + 0.05, false, ideal, ideal), &WALL);
        assert!((0.6..0.8).contains(&soft), "{soft}");
    }

    #[test]
    fn answers_scatter_about_the_quality_and_stay_on_the_scale() {
        let felt = walk(0.5, false, ideal, |theta| 0.5 * ideal(theta));
        let scene = Scene::Spring(SPRING);
        let answers: Vec<i16> =
            (1..200).map(|trial| Person::typical(3).answer(trial, &felt, &scene, FIVE)).collect();
        assert!(answers.iter().all(|a| FIVE.has(*a)));
        let mean = answers.iter().map(|a| f64::from(*a)).sum::<f64>() / answers.len() as f64;
        assert!((mean - 1.0 - 4.0 * quality(&felt, &scene)).abs() < 0.2, "{mean}");
        assert!(answers.iter().any(|a| *a != answers[0]));
    }

    /// Four standard deviations of a share of 1/4 of 4,000 are 0.027.
    #[test]
    fn asked_for_the_mode_each_answer_is_as_likely_whatever_was_felt() {
        let modes = AnswerScale::Modes(["a", "b", "c"].map(str::to_owned).to_vec());
        let guess = |felt: &Felt, trial| Person::typical(3).answer(trial, felt, &WALL, &modes);
        let [near, far] = [0.3, 0.5].map(|top_rad| walk(top_rad, false, ideal, ideal));
        let guesses: Vec<i16> = (1..=4000).map(|trial| guess(&near, trial)).collect();
        for answer in modes.answers() {
            let share = guesses.iter().filter(|guess| **guess == answer).count() as f64 / 4000.0;
            assert!((share - 0.25).abs() < 0.027, "{answer}: {share}");
        }
        assert!((1..=50).all(|trial| guess(&far, trial) == guesses[trial as usize - 1]));
    }
}
