//! How an intent is carried out: forward, let go, and back with the lever.
//!
//! The intent is made before the trial and does not know the mode; the course depends on what the
//! hand does and feels. Positions are those of the hand's aim along the arc, from where it waits,
//! in m.
//!
//! ```text
//! forward   x = A · least jerk(t) + ∫ g L (θ_goal − θ) dt   the second part, within τ, once the plan is over
//! turn      where the lever would come to rest at the goal's angle, F reaches its force, or the latest
//!           turn is due
//! let go    x' = −F c / T  within τ, F the force at the turn, c the hand's compliance; hardly faster
//!           than the lever was meant to go in
//! back      least jerk to 0 from where it is, a reaction time after the lever came back or the force went
//! ```
//!
//! So the hand lets go of its force first, as the thesis' participant did (§4.3). It goes back with
//! the lever once the lever moves, or alone if the lever stays.

use super::{Intent, Person};
use zwidth_dynamics::{Aim, DrivenState};

/// How quickly an aim turns, τ, s: assumed. Where it will come to rest by that is predicted, as
/// people predict their own movements (Wolpert, Ghahramani & Jordan 1995, Science 269:1880).
const TURN_S: f64 = 0.07;
/// What drags at lever and hand while they move and is gone when they rest, N s/rad: by eye, so
/// that the lever comes to rest where it was predicted.
const DRAG_NS_PER_RAD: f64 = 0.2;
/// How quickly the aim follows an angle that is not reached yet, g, 1/s: by eye, slow enough not to
/// swing with a reaction time of 0.18 s (a delayed integrator is stable up to π/2 over its delay).
const CORRECT_PER_S: f64 = 4.0;
/// How far the lever comes back before it is felt to, rad: 2.5°, the just noticeable difference of
/// a finger joint (Tan et al. 1994), taken for the lever.
const FELT_RAD: f64 = 2.5 * std::f64::consts::PI / 180.0;
/// Below this the force counts as gone, N.
const GONE_N: f64 = 0.2;

/// Where a movement stands.
#[derive(Debug, Clone, Copy)]
enum Phase {
    Forward { extra_m: f64, rate_m_s: f64, at_s: f64 },
    LetGo { from: From, slack_m_s: f64, highest_rad: f64, felt_s: Option<f64> },
    Back { from: From },
}

/// Where a phase began.
#[derive(Debug, Clone, Copy)]
struct From {
    at_s: f64,
    position_m: f64,
    velocity_m_s: f64,
}

/// An intent as it is carried out.
#[derive(Debug, Clone)]
pub(crate) struct Course {
    intent: Intent,
    base_m: f64,
    phase: Phase,
}

impl Course {
    /// Before it begins, with the hand that far along the arc.
    pub(crate) fn new(intent: Intent, base_m: f64) -> Self {
        Self { intent, base_m, phase: Phase::Forward { extra_m: 0.0, rate_m_s: 0.0, at_s: 0.0 } }
    }

    /// What was meant.
    #[cfg(test)]
    pub(crate) fn intent(&self) -> &Intent {
        &self.intent
    }

    /// Where the hand means to be, and how fast, `t_s` after the trial's start.
    pub(crate) fn aim(&self, t_s: f64) -> Aim {
        let [position_m, velocity_m_s] = match self.phase {
            Phase::Forward { extra_m, rate_m_s, at_s } => {
                let [position_m, velocity_m_s] = self.intent.forward(t_s);
                [position_m + extra_m + rate_m_s * (t_s - at_s), velocity_m_s + rate_m_s]
            }
            Phase::LetGo { from, slack_m_s, .. } => let_go(from, slack_m_s, t_s - from.at_s),
            Phase::Back { from } => back(from, self.intent.back_s, t_s - from.at_s),
        };
        if position_m > 0.0 { Aim { position_m, velocity_m_s } } else { Aim::default() }
    }

    /// One step: goes on, turns, or goes back, by what is felt at `t_s` after the trial's start.
    pub(crate) fn step(&mut self, person: &Person, lever_m: f64, t_s: f64, state: &DrivenState) {
        match &mut self.phase {
            Phase::Forward { extra_m, rate_m_s, at_s } => {
                let since_s = t_s - *at_s;
                *extra_m += *rate_m_s * since_s;
                *at_s = t_s;
                if t_s >= self.intent.onset_s + self.intent.forward_s {
                    let short_rad = (self.intent.goal.angle_rad - state.theta_rad).max(0.0);
                    let wanted_m_s = CORRECT_PER_S * lever_m * short_rad;
                    // At most the whole way to the wanted rate, however long the step was.
                    *rate_m_s += (wanted_m_s - *rate_m_s) * (since_s / TURN_S).min(1.0);
                }
                self.turn(person, lever_m, t_s, state);
            }
            Phase::LetGo { highest_rad, felt_s, .. } => {
                *highest_rad = highest_rad.max(state.theta_rad);
                let is_back = *highest_rad - state.theta_rad > FELT_RAD;
                if felt_s.is_none() && (is_back || state.contact_n < GONE_N) {
                    *felt_s = Some(t_s);
                }
                if felt_s.is_some_and(|felt_s| t_s >= felt_s + person.reaction_s) {
                    self.phase = Phase::Back { from: self.here(t_s) };
                }
            }
            Phase::Back { .. } => {}
        }
    }

    fn here(&self, at_s: f64) -> From {
        let Aim { position_m, velocity_m_s } = self.aim(at_s);
        From { at_s, position_m, velocity_m_s }
    }

    /// Turns where the goal is reached, or time is up.
    fn turn(&mut self, person: &Person, lever_m: f64, t_s: f64, state: &DrivenState) {
        let goal = self.intent.goal;
        let from = self.here(t_s);
        let slack_m_s = self.intent.slack_m_s(person, lever_m, state.contact_n);
        let at_rest_n = state.contact_n - DRAG_NS_PER_RAD * state.theta_dot_rad_s;
        // How far an aim still goes on when it turns: to where v of `let_go` is 0.
        let on_m_s = from.velocity_m_s.max(0.0);
        let back_m =
            if slack_m_s > 0.0 { slack_m_s * libm::log1p(on_m_s / slack_m_s) } else { 0.0 };
        let onward_m = TURN_S * (on_m_s - back_m);
        let rest_m =
            self.base_m + from.position_m + onward_m - person.compliance_m_per_n() * at_rest_n;
        let is_reached = rest_m >= lever_m * goal.angle_rad || state.contact_n >= goal.force_n;
        if t_s >= self.intent.latest_turn_s() || t_s > self.intent.onset_s && is_reached {
            let highest_rad = state.theta_rad;
            self.phase = Phase::LetGo { from, slack_m_s, highest_rad, felt_s: None };
        }
    }
}

/// Position and velocity that go over to −`slack_m_s` within τ: v = −u + (v₀ + u) e^(−t/τ).
fn let_go(from: From, slack_m_s: f64, t_s: f64) -> [f64; 2] {
    let decay = libm::exp(-t_s / TURN_S);
    let fast_m_s = from.velocity_m_s + slack_m_s;
    [
        from.position_m - slack_m_s * t_s + fast_m_s * TURN_S * (1.0 - decay),
        fast_m_s * decay - slack_m_s,
    ]
}

/// Position and velocity of a movement of least jerk to rest at 0 from where it is, with the
/// velocity that it has: x₀ (1 − 10 s³ + 15 s⁴ − 6 s⁵) + v₀ T (s − 6 s³ + 8 s⁴ − 3 s⁵), s = t/T.
fn back(from: From, duration_s: f64, t_s: f64) -> [f64; 2] {
    let s = (t_s / duration_s).clamp(0.0, 1.0);
    let x = from.position_m;
    let v = from.velocity_m_s * duration_s;
    let position_m = x * (1.0 - s * s * s * (10.0 + s * (6.0 * s - 15.0)))
        + v * s * (1.0 + s * s * (s * (8.0 - 3.0 * s) - 6.0));
    let rate_m = -30.0 * x * s * s * (1.0 - s) * (1.0 - s)
        + v * (1.0 + s * s * (s * (32.0 - 15.0 * s) - 18.0));
    [position_m, rate_m / duration_s]
}

#[cfg(test)]
mod tests {
    use super::super::Goal;
    use super::super::STEP_S;
    use super::super::intent::tests::{SPRING, task};
    use super::*;
    use zwidth_study::Scene;

    /// Where the hand of these tests waits, m.
    const BASE_M: f64 = -0.035;

    fn felt(theta_rad: f64, contact_n: f64) -> DrivenState {
        super::super::felt::tests::state(theta_rad, contact_n, 0.0)
    }

    fn intent() -> Intent {
        Intent::draw(&Person::typical(1), 5, &task(Scene::Spring(SPRING)))
    }

    /// Aims of a hand that feels the same until the intent would turn, and then something else.
    fn aims(before: DrivenState, after: DrivenState) -> Vec<Aim> {
        let (person, intent) = (Person::typical(1), intent());
        let mut course = Course::new(intent, BASE_M);
        (0..1600)
            .map(|i| {
                let t_s = STEP_S * f64::from(i);
                let state = if t_s <= intent.latest_turn_s() { before } else { after };
                course.step(&person, 0.045, t_s, &state);
                course.aim(t_s)
            })
            .collect()
    }

    #[test]
    fn positions_change_by_their_velocities_and_nothing_jumps() {
        for after in [felt(0.3, 0.0), felt(0.55, 3.0)] {
            let aims = aims(felt(0.55, 4.0), after);
            for pair in aims.windows(2) {
                let mean = (pair[0].velocity_m_s + pair[1].velocity_m_s) / 2.0;
                let moved = pair[1].position_m - pair[0].position_m;
                assert!((moved - STEP_S * mean).abs() < 4e-5, "{pair:?}");
            }
        }
    }

    #[test]
    fn the_way_back_begins_as_the_hand_was_moving_and_ends_at_rest() {
        let from = From { at_s: 0.0, position_m: 0.08, velocity_m_s: -0.03 };
        let [x, v] = back(from, 1.2, 0.0);
        assert!((x - 0.08).abs() < 1e-15 && (v + 0.03).abs() < 1e-15);
        let end = back(from, 1.2, 1.2);
        assert!(end.iter().all(|x| x.abs() < 1e-15), "{end:?}");
        for i in 1..100 {
            let t = 0.012 * f64::from(i);
            let slope = (back(from, 1.2, t + 1e-6)[0] - back(from, 1.2, t - 1e-6)[0]) / 2e-6;
            assert!((slope - back(from, 1.2, t)[1]).abs() < 1e-8);
        }
    }

    /// The aim goes on by this, and the force presses the hand back by that: the lever will rest
    /// there.
    #[test]
    fn it_turns_where_the_lever_will_come_to_rest_at_the_goal() {
        let (person, intent) = (Person::typical(1), intent());
        let t_s = intent.onset_s + 0.6 * intent.forward_s;
        let turned = |angle_rad: f64, contact_n: f64| {
            let goal = Goal { angle_rad, ..intent.goal };
            let mut course = Course::new(Intent { goal, ..intent }, BASE_M);
            course.step(&person, 0.045, t_s, &felt(0.0, contact_n));
            matches!(course.phase, Phase::LetGo { .. })
        };
        let [position_m, velocity_m_s] = intent.forward(t_s);
        let slack_m_s = 3.0 * person.compliance_m_per_n() / intent.let_go_s;
        let stop_s = TURN_S * libm::log((velocity_m_s + slack_m_s) / slack_m_s);
        let from = From { at_s: 0.0, position_m, velocity_m_s };
        let [top_m, at_rest] = let_go(from, slack_m_s, stop_s);
        assert!(at_rest.abs() < 1e-15 && top_m > position_m);
        let rest_rad = (BASE_M + top_m - 3.0 * person.compliance_m_per_n()) / 0.045;
        assert!(turned(rest_rad - 1e-9, 3.0) && !turned(rest_rad + 1e-9, 3.0));
        assert!(turned(1.5, intent.goal.force_n) && !turned(1.5, intent.goal.force_n - 0.01));
    }

    /// Nothing moves and the force stays: the hand lets go of it in the time it takes itself.
    #[test]
    fn a_force_that_stays_is_let_go_at_its_own_pace() {
        let (person, intent) = (Person::typical(1), intent());
        let aims = aims(felt(0.4, 3.0), felt(0.4, 3.0));
        let at = |t_s: f64| aims[(t_s / STEP_S) as usize];
        let slack = 3.0 * person.compliance_m_per_n() / intent.let_go_s;
        let later = at(intent.latest_turn_s() + 0.5).velocity_m_s;
        assert!((later + slack).abs() < 1e-3 * slack, "{later} {slack}");
    }

    #[test]
    fn it_goes_back_a_reaction_time_after_the_lever_came_back_or_the_force_went() {
        let (person, intent) = (Person::typical(1), intent());
        for after in [felt(0.4 - 2.0 * FELT_RAD, 3.0), felt(0.4, 0.0)] {
            let mut course = Course::new(intent, BASE_M);
            let mut went_s = f64::NAN;
            for i in 0..1600 {
                let t_s = STEP_S * f64::from(i);
                let state = if t_s < 2.0 { felt(0.4, 5.0) } else { after };
                course.step(&person, 0.045, t_s, &state);
                if went_s.is_nan() && matches!(course.phase, Phase::Back { .. }) {
                    went_s = t_s;
                }
            }
            assert!((went_s - 2.0 - person.reaction_s).abs() <= STEP_S, "{went_s}");
        }
    }

    #[test]
    fn a_goal_that_is_not_reached_is_followed_for_a_while() {
        let intent = intent();
        let planned_s = intent.onset_s + intent.forward_s;
        let aims = aims(felt(intent.goal.angle_rad - 0.1, 6.5), felt(0.4, 5.0));
        let at = |t_s: f64| aims[(t_s / STEP_S) as usize].position_m;
        let more = at(intent.latest_turn_s() - STEP_S) - at(planned_s);
        let expected = CORRECT_PER_S * 0.045 * 0.1 * (intent.wait_s - TURN_S);
        assert!((more / expected - 1.0).abs() < 0.1, "{more} {expected}");
    }
}
