//! Giving way: a participant who is pushed too hard, or sees the end of the work space, retreats, a
//! reaction time late.

use super::{Person, STEP_S};
use zwidth_dynamics::DrivenState;

/// Room for a reaction time of up to 0.25 s.
const MOST_STEPS: usize = 100;
/// How quickly it retreats from what is too much, 1/s: with the reaction time below, slow enough
/// not to swing (a delayed integrator is stable up to π/2 over its delay, 8.7/s at 0.18 s).
const RETREAT_PER_S: f64 = 5.0;
/// How quickly a retreat is forgotten, 1/s.
const FORGET_PER_S: f64 = 0.5;

/// What is felt on its way to the hand, and the retreat so far.
#[derive(Debug, Clone)]
pub(crate) struct Reaction {
    /// What was too much, as the distance that would relieve it, m; one entry a step.
    pending_m: [f64; MOST_STEPS],
    at: usize,
    delay_steps: usize,
    retreat_m: f64,
    rate_m_s: f64,
}

impl Reaction {
    /// At rest, with nothing on its way.
    pub(crate) fn new(person: &Person) -> Self {
        // Less than the ring is long, or the newest entry would be taken for the oldest.
        let delay_steps = ((person.reaction_s / STEP_S) as usize).clamp(1, MOST_STEPS - 1);
        Self { pending_m: [0.0; MOST_STEPS], at: 0, delay_steps, retreat_m: 0.0, rate_m_s: 0.0 }
    }

    /// One step: what is felt now goes in, what was felt a reaction time ago acts. `limit_m` is
    /// where along the arc the participant wants the lever's end to stay below.
    pub(crate) fn step(
        &mut self,
        person: &Person,
        state: &DrivenState,
        lever_m: f64,
        limit_m: f64,
    ) {
        self.retreat_m = (self.retreat_m + STEP_S * self.rate_m_s).max(0.0);
        let too_hard_m =
            (state.contact_n - person.comfort_n).max(0.0) * person.compliance_m_per_n();
        let too_far_m = (lever_m * state.theta_rad - limit_m).max(0.0);
        self.pending_m[self.at] = too_hard_m + too_far_m;
        self.at = (self.at + 1) % MOST_STEPS;
        // The entry of this step is now one behind `at`; the one that acts lies a delay before it.
        let felt_m = self.pending_m[(self.at + MOST_STEPS - 1 - self.delay_steps) % MOST_STEPS];
        self.rate_m_s = RETREAT_PER_S * felt_m - FORGET_PER_S * self.retreat_m;
    }

    /// How far the intent is drawn back, m, and how fast, m/s, some time after the last step.
    pub(crate) fn retreat(&self, since_step_s: f64) -> [f64; 2] {
        [self.retreat_m + self.rate_m_s * since_step_s, self.rate_m_s]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pushed(contact_n: f64) -> DrivenState {
        super::super::felt::tests::state(0.0, contact_n, 0.0)
    }

    /// Steps until the hand moves back.
    fn steps_to_retreat(person: &Person, contact_n: f64) -> Option<usize> {
        let mut reaction = Reaction::new(person);
        (0..400).find(|_| {
            reaction.step(person, &pushed(contact_n), 0.045, 0.03);
            reaction.retreat(0.0)[1] > 0.0
        })
    }

    #[test]
    fn a_comfortable_force_is_held() {
        let person = Person::typical(1);
        assert_eq!(steps_to_retreat(&person, 7.9), None);
    }

    #[test]
    fn more_is_yielded_to_a_reaction_time_later() {
        let person = Person { reaction_s: 0.15, ..Person::typical(1) };
        assert_eq!(steps_to_retreat(&person, 9.0), Some(60));
    }

    #[test]
    fn a_retreat_is_forgotten() {
        let person = Person::typical(1);
        let mut reaction = Reaction::new(&person);
        (0..200).for_each(|_| reaction.step(&person, &pushed(10.0), 0.045, 0.03));
        let far = reaction.retreat(0.0)[0];
        (0..4000).for_each(|_| reaction.step(&person, &pushed(0.0), 0.045, 0.03));
        assert!(far > 1e-3 && reaction.retreat(0.0)[0] < 0.05 * far);
    }
}
