//! What the participant is doing: waiting, or in a trial.

use super::parameters::{STOPS_RAD, TwinParameters};
use crate::Cue;
use crate::participant::{Course, Felt, Intent, Person, Reaction, Task};
use zwidth_dynamics::{Aim, DrivenState};
use zwidth_study::{AnswerScale, Scene};

/// How far from the lever the hand waits, m.
pub(super) const WAITING_GAP_M: f64 = 5e-4;
/// How far below the upper stop the participant wants to stay, rad: 5°.
const MARGIN_RAD: f64 = 5.0 * std::f64::consts::PI / 180.0;

/// A trial from the participant's side.
#[derive(Debug, Clone)]
pub(super) struct Trial {
    /// Its number; 0 while waiting.
    number: u32,
    scene: Scene,
    pub(super) course: Course,
    begin_s: f64,
    /// When its time is up, s.
    pub(super) over_s: f64,
    /// Where the hand waits, m along the arc.
    base_m: f64,
    reaction: Reaction,
    pub(super) felt: Felt,
}

impl Trial {
    /// Between trials: the hand waits.
    pub(super) fn idle(person: &Person, parameters: &TwinParameters) -> Self {
        let intent = Intent::draw(person, 0, &task(parameters, Scene::None, f64::INFINITY));
        // It never begins.
        let intent = Intent { amplitude_m: 0.0, onset_s: f64::INFINITY, ..intent };
        let base_m = base_m(parameters);
        Self {
            number: 0,
            scene: Scene::None,
            course: Course::new(intent, base_m),
            begin_s: 0.0,
            over_s: f64::INFINITY,
            base_m,
            reaction: Reaction::new(person),
            felt: Felt::nothing(STOPS_RAD),
        }
    }

    /// A trial that begins at `now_s`.
    pub(super) fn begin(
        person: &Person,
        parameters: &TwinParameters,
        now_s: f64,
        cue: &Cue<'_>,
    ) -> Self {
        let scene = cue.environment.scene;
        let intent = Intent::draw(person, cue.trial, &task(parameters, scene, cue.limit_s));
        Self {
            number: cue.trial,
            scene,
            course: Course::new(intent, base_m(parameters)),
            begin_s: now_s,
            over_s: now_s + cue.limit_s,
            ..Self::idle(person, parameters)
        }
    }

    /// Where the hand means to be at a moment, giving way as decided at the last step.
    pub(super) fn aim(&self, t_s: f64, last_step_s: f64) -> Aim {
        let meant = self.course.aim(t_s - self.begin_s);
        let [retreat_m, rate_m_s] = self.reaction.retreat(t_s - last_step_s);
        Aim {
            // A retreat goes no further back than where the hand waits.
            position_m: self.base_m + (meant.position_m - retreat_m).max(0.0),
            velocity_m_s: meant.velocity_m_s - rate_m_s,
        }
    }

    /// One step of feeling and reacting.
    pub(super) fn step(&mut self, person: &Person, lever_m: f64, at_s: f64, state: &DrivenState) {
        self.course.step(person, lever_m, at_s - self.begin_s, state);
        self.reaction.step(person, state, lever_m, lever_m * (STOPS_RAD[1] - MARGIN_RAD));
        if at_s < self.over_s {
            self.felt.feel(state);
        }
    }

    /// The answer to its question, on its scale; none while waiting, or where it is left open.
    pub(super) fn answer(&self, person: &Person, on: &AnswerScale) -> Option<i16> {
        let answers = self.number > 0 && !person.is_silent(self.number);
        answers.then(|| person.answer(self.number, &self.felt, &self.scene, on))
    }
}

/// Where the hand waits, m along the arc.
fn base_m(parameters: &TwinParameters) -> f64 {
    parameters.lever_m * STOPS_RAD[0] - WAITING_GAP_M
}

/// What a participant knows of the device and the environment.
fn task(parameters: &TwinParameters, scene: Scene, limit_s: f64) -> Task {
    let [start_rad, end_rad] = STOPS_RAD;
    let resistance_n = parameters.friction_static_n * parameters.friction_kinetic_share;
    Task { scene, lever_m: parameters.lever_m, start_rad, end_rad, resistance_n, limit_s }
}
