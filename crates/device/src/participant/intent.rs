//! What the hand means to do in a trial: forward, a moment, and back.

use super::Person;
use super::draw::{Draw, Purpose};
use zwidth_dynamics::Aim;
use zwidth_study::Scene;

/// What a participant knows before a trial: the environment and the lever. Not the mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Task {
    /// What is rendered.
    pub scene: Scene,
    /// Lever length L, m.
    pub lever_m: f64,
    /// Where the lever starts, rad.
    pub start_rad: f64,
    /// Where the work space ends, rad.
    pub end_rad: f64,
    /// What the lever itself resists with when nothing is rendered, N: felt during
    /// familiarisation.
    pub resistance_n: f64,
}

/// A forward and a backward movement of least jerk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intent {
    /// When it begins, s after the trial's start.
    pub onset_s: f64,
    /// How long it goes forward, s.
    pub forward_s: f64,
    /// How long it stays, s.
    pub dwell_s: f64,
    /// How long it goes back, s.
    pub back_s: f64,
    /// How far along the lever's arc the hand means to go, m: further than the lever, by what the
    /// force will press the hand back.
    pub amplitude_m: f64,
}

/// A participant leaves room at the far end: a device weaker by this force would not carry the hand
/// into the stop, N.
const ROOM_N: f64 = 1.0;
/// Angle between the stop and where it wants to stay, rad: 3°.
const ROOM_RAD: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Least compression anybody means to reach, rad of lever: 60°, well into a spring.
const LEAST_TRAVEL_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// Standard deviation of the meant angle from repeat to repeat, rad: 1°.
const REACH_SD_RAD: f64 = std::f64::consts::PI / 180.0;
/// How far into a wall anybody means to press, rad of lever: 6°, and how much that varies, as a
/// share.
const PRESS_RAD: f64 = 6.0 * std::f64::consts::PI / 180.0;
const PRESS_SD: f64 = 0.15;
/// How much slower the very first trial is, and how much more it varies, as shares.
const FIRST_SLOWER: f64 = 0.1;
const FIRST_VARIES: f64 = 0.5;
/// Trials after which half of that is learned.
const HALF_LEARNED: f64 = 6.0;

impl Intent {
    pub(crate) fn draw(person: &Person, trial: u32, task: &Task) -> Self {
        let mut draw = Draw::new(person.seed, Purpose::Intent, u64::from(trial));
        let new = libm::exp2(-f64::from(trial.saturating_sub(1)) / HALF_LEARNED);
        let spread = 1.0 + FIRST_VARIES * new;
        let mut vary = |usual: f64| usual * (1.0 + person.spread * spread * draw.moderate());
        let slower = 1.0 + FIRST_SLOWER * new;
        Self {
            onset_s: vary(person.onset_s),
            forward_s: vary(person.forward_s) * slower,
            dwell_s: vary(person.dwell_s),
            back_s: vary(person.back_s) * slower,
            amplitude_m: plan(person, task, spread * draw.moderate()),
        }
    }

    /// When it is over, s after the trial's start.
    #[cfg(test)]
    pub(crate) fn end_s(&self) -> f64 {
        self.onset_s + self.forward_s + self.dwell_s + self.back_s
    }

    /// Where the hand means to be, from where it started, and how fast.
    pub(crate) fn aim(&self, t_s: f64) -> Aim {
        let there = least_jerk(t_s - self.onset_s, self.forward_s);
        let back = least_jerk(t_s - self.onset_s - self.forward_s - self.dwell_s, self.back_s);
        Aim {
            position_m: self.amplitude_m * (there[0] - back[0]),
            velocity_m_s: self.amplitude_m * (there[1] - back[1]),
        }
    }
}

/// How far the hand means to go, m: the lever's arc to the meant angle, and what the force expected
/// there presses the hand back. A wall is pressed into; without one, how far it goes depends on how
/// soft the hand is. `off` is how many standard deviations this repeat is off the usual.
fn plan(person: &Person, task: &Task, off: f64) -> f64 {
    let soft = person.compliance_m_per_n();
    let (angle_rad, press_m) = match task.scene.wall_rad() {
        Some(wall_rad) => {
            let usual_m = (soft * person.press_n).min(task.lever_m * PRESS_RAD);
            (wall_rad, usual_m * (1.0 + PRESS_SD * off))
        }
        None => (reach_rad(person, task) + REACH_SD_RAD * off, 0.0),
    };
    // Where it turns back the hand stands: what resists by velocity presses nothing.
    let scene_n = task.scene.law().map_or(0.0, |law| law.force_n(angle_rad, 0.0));
    task.lever_m * (angle_rad - task.start_rad) + soft * (scene_n + task.resistance_n) + press_m
}

/// How far into an object without a wall: as far as the person likes, and leaves room.
fn reach_rad(person: &Person, task: &Task) -> f64 {
    let room_rad = task.end_rad - ROOM_RAD - ROOM_N * person.compliance_m_per_n() / task.lever_m;
    person.reach_rad.min(room_rad).max(task.start_rad + LEAST_TRAVEL_RAD)
}

/// Share of the way, and its rate (1/s), of a movement of least jerk: 10 s³ − 15 s⁴ + 6 s⁵ with s =
/// t/T (Flash & Hogan 1985).
fn least_jerk(t_s: f64, duration_s: f64) -> [f64; 2] {
    let s = (t_s / duration_s).clamp(0.0, 1.0);
    let share = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    let rate = 30.0 * s * s * (1.0 - s) * (1.0 - s) / duration_s;
    [share, rate]
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_4;
    use zwidth_study::Spring;

    pub(crate) const SPRING: Spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: -FRAC_PI_4 };

    pub(crate) fn task(scene: Scene) -> Task {
        Task { scene, lever_m: 0.045, start_rad: -FRAC_PI_4, end_rad: FRAC_PI_4, resistance_n: 0.1 }
    }

    #[test]
    fn least_jerk_starts_and_ends_at_rest_and_is_fastest_in_the_middle() {
        for (t, expected) in [(-1.0, [0.0, 0.0]), (5.0, [1.0, 0.0]), (1.0, [0.5, 1.875 / 2.0])] {
            let found = least_jerk(t, 2.0);
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-15), "{t}: {found:?}");
        }
        for i in 0..100 {
            let t = 0.02 * f64::from(i) + 0.01;
            let slope = (least_jerk(t + 1e-6, 2.0)[0] - least_jerk(t - 1e-6, 2.0)[0]) / 2e-6;
            assert!((slope - least_jerk(t, 2.0)[1]).abs() < 1e-8);
        }
    }

    #[test]
    fn the_hand_goes_forward_and_comes_back_to_where_it_was() {
        let intent = Intent::draw(&Person::typical(1), 1, &task(Scene::Spring(SPRING)));
        assert_eq!(intent.aim(0.0), Aim::default());
        assert_eq!(intent.aim(intent.end_s() + 1.0), Aim::default());
        let top = intent.aim(intent.onset_s + intent.forward_s + 0.5 * intent.dwell_s);
        assert_eq!(top, Aim { position_m: intent.amplitude_m, velocity_m_s: 0.0 });
    }

    #[test]
    fn it_is_over_within_the_time_limit_of_a_trial() {
        for seed in 0..300 {
            let person = Person::draw(seed);
            for trial in 1..40 {
                let end_s = Intent::draw(&person, trial, &task(Scene::Free)).end_s();
                assert!((2.0..3.9).contains(&end_s), "{end_s}");
            }
        }
    }

    #[test]
    fn a_plan_is_the_arc_and_what_the_force_presses_back() {
        let person = Person { reach_rad: 30.0_f64.to_radians(), ..Person::typical(1) };
        let travel = 75.0_f64.to_radians();
        let expected = 0.045 * travel + (4.0 * travel + 0.1) * (1.0 / 290.0 + 1.0 / 584.6);
        assert!((plan(&person, &task(Scene::Spring(SPRING)), 0.0) - expected).abs() < 1e-12);
        let free = 0.045 * travel + 0.1 * (1.0 / 290.0 + 1.0 / 584.6);
        assert!((plan(&person, &task(Scene::Free), 0.0) - free).abs() < 1e-12);
    }

    #[test]
    fn repeats_differ_and_later_ones_are_quicker_and_more_alike() {
        let durations = |trials: std::ops::Range<u32>| -> Vec<f64> {
            let of = |seed| {
                trials.clone().map(move |k| {
                    Intent::draw(&Person::typical(seed), k, &task(Scene::Free)).forward_s
                })
            };
            (0..200).flat_map(of).collect()
        };
        let stats = |x: &[f64]| {
            let mean = x.iter().sum::<f64>() / x.len() as f64;
            (mean, x.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / x.len() as f64)
        };
        let ((early, varied), (late, steady)) =
            (stats(&durations(1..6)), stats(&durations(31..36)));
        assert!(early > 1.04 * late && varied > 1.3 * steady && steady > 1e-4);
    }
}
