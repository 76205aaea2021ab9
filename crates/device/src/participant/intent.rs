//! What the hand means to do in a trial: forward to a goal, and back.

use super::Person;
use super::draw::{Draw, Purpose};
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
    /// How long the trial may take, s.
    pub limit_s: f64,
}

/// Where a movement is to turn back: as soon as either is reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Goal {
    /// Angle of the lever, rad.
    pub angle_rad: f64,
    /// Force of the finger, N: how hard it means to press on what does not give way.
    pub force_n: f64,
}

/// A forward movement of least jerk to a goal, and how it is to come back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intent {
    /// When it begins, s after the trial's start.
    pub onset_s: f64,
    /// How long it goes forward, s.
    pub forward_s: f64,
    /// How long it goes on after that while the goal is not reached, s.
    pub wait_s: f64,
    /// In how much time it lets go of its force before it turns back, s.
    pub let_go_s: f64,
    /// How long it goes back, s.
    pub back_s: f64,
    /// How far along the lever's arc the hand means to go, m: further than the lever, by what the
    /// force at the goal will press the hand back.
    pub amplitude_m: f64,
    /// How far the lever is to go, rad.
    pub travel_rad: f64,
    /// Where it turns.
    pub goal: Goal,
}

/// A participant leaves room at the far end, rad: 5°.
const ROOM_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// Least compression anybody means to reach, rad of lever: 60°, well into a spring.
const LEAST_TRAVEL_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// Standard deviation of the meant angle from repeat to repeat, rad: 1°.
const REACH_SD_RAD: f64 = std::f64::consts::PI / 180.0;
/// How far past a wall everybody means to go who is to feel one, rad: 4°.
const PRESS_RAD: f64 = 4.0 * std::f64::consts::PI / 180.0;
/// Standard deviation of how hard it means to press, from repeat to repeat, as a share.
const PRESS_SD: f64 = 0.15;
/// How much slower the very first trial of all is, and how much more it varies, as shares.
const FIRST_SLOWER: f64 = 0.1;
const FIRST_VARIES: f64 = 0.5;
/// Trials after which half of that is learned.
const HALF_LEARNED: f64 = 6.0;
/// What a participant leaves of a trial's time, s.
const SPARE_S: f64 = 0.3;
/// How fast it lets go at most, as a share of the lever's mean speed on the way in.
const SLACK_MOST: f64 = 1.5;
/// How far a trial goes that somebody gives up, as a share of what was meant.
const GIVEN_UP: f64 = 0.35;

impl Intent {
    pub(crate) fn draw(person: &Person, trial: u32, task: &Task) -> Self {
        let mut draw = Draw::new(person.seed, Purpose::Intent, u64::from(trial));
        let before = f64::from(person.practised) + f64::from(trial.saturating_sub(1));
        let new = libm::exp2(-before / HALF_LEARNED);
        let spread = 1.0 + FIRST_VARIES * new;
        let mut vary = |usual: f64| usual * (1.0 + person.spread * spread * draw.moderate());
        let slower = 1.0 + FIRST_SLOWER * new;
        let intent = Self {
            onset_s: vary(person.onset_s),
            forward_s: vary(person.forward_s) * slower,
            wait_s: vary(person.wait_s),
            let_go_s: vary(person.let_go_s),
            back_s: vary(person.back_s) * slower,
            amplitude_m: 0.0,
            travel_rad: 0.0,
            goal: goal(person, task, [spread * draw.moderate(), spread * draw.moderate()]),
        };
        let angle_rad = intent.goal.angle_rad;
        // Without waiting: after its share of the way the hand would else go on to the goal.
        let (share, wait_s) =
            if person.gives_up(trial) { (GIVEN_UP, 0.0) } else { (1.0, intent.wait_s) };
        let intent = Self { wait_s, ..intent };
        Self {
            amplitude_m: share * amplitude_m(person, task, angle_rad),
            travel_rad: angle_rad - task.start_rad,
            ..intent.within(task.limit_s - SPARE_S)
        }
    }

    /// The same, quicker where it would take longer; twice as quick at most.
    fn within(self, limit_s: f64) -> Self {
        let Self { onset_s, forward_s, wait_s, let_go_s, back_s, .. } = self;
        let usual_s = forward_s + wait_s + let_go_s + back_s;
        let share = ((limit_s - onset_s) / usual_s).clamp(0.5, 1.0);
        Self {
            forward_s: share * forward_s,
            wait_s: share * wait_s,
            let_go_s: share * let_go_s,
            back_s: share * back_s,
            ..self
        }
    }

    /// When it turns back at the latest, s after the trial's start.
    pub(crate) fn latest_turn_s(&self) -> f64 {
        self.onset_s + self.forward_s + self.wait_s
    }

    /// How fast it draws back to let go of a force, m/s: in its own time, but hardly faster than
    /// the lever was meant to go in.
    pub(crate) fn slack_m_s(&self, person: &Person, lever_m: f64, force_n: f64) -> f64 {
        let fastest_m_s = SLACK_MOST * lever_m * self.travel_rad / self.forward_s;
        (force_n * person.compliance_m_per_n() / self.let_go_s).min(fastest_m_s)
    }

    /// Where the hand means to be on its way forward, from where it started, m, and how fast, m/s.
    pub(crate) fn forward(&self, t_s: f64) -> [f64; 2] {
        least_jerk(t_s - self.onset_s, self.forward_s).map(|x| self.amplitude_m * x)
    }
}

/// Where a movement turns: the angle that the person likes, whatever is rendered, or the force that
/// presses on a wall, of which nobody stays short. `off`: how many standard deviations this repeat
/// is off the usual, in both.
fn goal(person: &Person, task: &Task, off: [f64; 2]) -> Goal {
    let room_rad = task.end_rad - ROOM_RAD;
    let wall_rad = task.scene.wall_rad();
    let usual_rad = person.reach_rad.max(task.start_rad + LEAST_TRAVEL_RAD);
    let angle_rad = usual_rad + REACH_SD_RAD * off[0];
    let angle_rad = wall_rad.map_or(angle_rad, |wall_rad| angle_rad.max(wall_rad + PRESS_RAD));
    let press_n = person.press_n * (1.0 + PRESS_SD * off[1]);
    let wall_n = wall_rad.map(|wall_rad| before_wall_n(&task.scene, wall_rad) + press_n);
    Goal { angle_rad: angle_rad.min(room_rad), force_n: wall_n.unwrap_or(person.comfort_n) }
}

/// How far the hand means to go, m: the lever's arc to the angle, and what the force expected there
/// presses the hand back (an internal model of the object; Shadmehr & Mussa-Ivaldi 1994). A wall
/// is left to stop it.
fn amplitude_m(person: &Person, task: &Task, angle_rad: f64) -> f64 {
    let at_goal_n = before_wall_n(&task.scene, angle_rad) + task.resistance_n;
    task.lever_m * (angle_rad - task.start_rad) + person.compliance_m_per_n() * at_goal_n
}

/// The force of a scene at an angle as if it had no wall, N. Where it turns back the hand stands:
/// what resists by velocity presses nothing.
fn before_wall_n(scene: &Scene, angle_rad: f64) -> f64 {
    scene.law().map_or(0.0, |law| law.force_n(angle_rad, 0.0))
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
        Task {
            scene,
            lever_m: 0.045,
            start_rad: -FRAC_PI_4,
            end_rad: FRAC_PI_4,
            resistance_n: 0.1,
            limit_s: 4.0,
        }
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
    fn the_hand_goes_forward_as_far_as_it_means_to() {
        let intent = Intent::draw(&Person::typical(1), 1, &task(Scene::Spring(SPRING)));
        let is = |t_s: f64, position_m: f64| {
            let [x, v] = intent.forward(t_s);
            (x - position_m).abs() < 1e-15 && v.abs() < 1e-15
        };
        assert!(is(0.0, 0.0) && is(intent.latest_turn_s(), intent.amplitude_m));
    }

    #[test]
    fn a_plan_is_the_arc_and_what_the_force_presses_back() {
        let person = Person::typical(1);
        let travel = 75.0_f64.to_radians();
        let at = travel - FRAC_PI_4;
        let soft = 1.0 / 290.0 + 1.0 / 584.6;
        let expected = 0.045 * travel + (4.0 * travel + 0.1) * soft;
        assert!((amplitude_m(&person, &task(Scene::Spring(SPRING)), at) - expected).abs() < 1e-12);
        let free = 0.045 * travel + 0.1 * soft;
        assert!((amplitude_m(&person, &task(Scene::Free), at) - free).abs() < 1e-12);
    }

    #[test]
    fn the_goal_is_an_angle_and_at_a_wall_a_force_too() {
        let person = Person { reach_rad: 0.55, press_n: 1.5, ..Person::typical(1) };
        let wall = Scene::SpringWall { spring: SPRING, wall_rad: 0.464 };
        let of = |scene| goal(&person, &task(scene), [0.0, 0.0]);
        let (free, walled) = (of(Scene::Free), of(wall));
        assert_eq!(free, Goal { angle_rad: 0.55, force_n: person.comfort_n });
        assert_eq!(of(Scene::Spring(SPRING)), free);
        assert!((walled.angle_rad - 0.55).abs() < 1e-12);
        assert!((walled.force_n - 4.0 * (0.464 + FRAC_PI_4) - 1.5).abs() < 1e-12);
        let short = Person { reach_rad: 0.4, ..person };
        let past = goal(&short, &task(wall), [0.0, 0.0]).angle_rad - 0.464;
        assert!((past - PRESS_RAD).abs() < 1e-12);
    }

    #[test]
    fn a_movement_is_meant_to_end_within_the_time_of_a_trial() {
        for seed in 0..300 {
            let person = Person::draw(seed).in_session(seed, 0);
            for trial in 1..40 {
                let meant = Intent::draw(&person, trial, &task(Scene::Free));
                let end_s = meant.latest_turn_s() + meant.let_go_s + meant.back_s;
                assert!((1.8..4.0 - SPARE_S + 1e-9).contains(&end_s), "{end_s}");
            }
        }
    }

    #[test]
    fn nobody_means_to_push_against_the_end_of_the_work_space() {
        let far = Person { reach_rad: 2.0, ..Person::typical(1) };
        let angle_rad =
            |trial| Intent::draw(&far, trial, &task(Scene::Spring(SPRING))).goal.angle_rad;
        assert!((1..200).all(|trial| angle_rad(trial) <= FRAC_PI_4 - ROOM_RAD));
    }

    /// Means and variances of how long it goes forward, over people of such trials.
    fn durations(practised: u32, trials: std::ops::Range<u32>) -> (f64, f64) {
        let of = |seed| {
            let person = Person { practised, ..Person::typical(seed) };
            trials.clone().map(move |k| Intent::draw(&person, k, &task(Scene::Free)).forward_s)
        };
        let x: Vec<f64> = (0..200).flat_map(of).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        (mean, x.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / x.len() as f64)
    }

    #[test]
    fn repeats_differ_and_later_ones_are_quicker_and_more_alike() {
        let ((early, varied), (late, steady)) = (durations(0, 1..6), durations(0, 31..36));
        assert!(early > 1.04 * late && varied > 1.3 * steady && steady > 1e-4);
    }

    #[test]
    fn what_was_learned_in_earlier_sessions_stays() {
        let ((first, _), (second, steady)) = (durations(0, 1..6), durations(36, 1..6));
        let (end, at_the_end) = durations(0, 37..42);
        assert!(first > 1.04 * second && (second / end - 1.0).abs() < 0.01);
        assert!((steady / at_the_end - 1.0).abs() < 0.3);
    }

    #[test]
    fn a_trial_that_is_given_up_goes_a_third_of_the_way() {
        let untidy = Person { gives_up: 0.5, ..Person::typical(1) };
        let of = |person: &Person, k| Intent::draw(person, k, &task(Scene::Free));
        let far = |person: &Person, k| of(person, k).amplitude_m;
        let waits = (1..100).filter(|k| of(&untidy, *k).wait_s > 0.0).count();
        let shares: Vec<f64> =
            (1..100).map(|k| far(&untidy, k) / far(&Person::typical(1), k)).collect();
        let given_up = shares.iter().filter(|share| (**share - GIVEN_UP).abs() < 1e-12).count();
        assert!((30..70).contains(&given_up), "{given_up}");
        assert_eq!(given_up + waits, shares.len());
        assert!(shares.iter().all(|s| (s - 1.0).abs() < 1e-12 || (s - GIVEN_UP).abs() < 1e-12));
    }
}
