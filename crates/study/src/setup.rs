//! What a study plans, apart from its order and its analysis: the device, what is rendered on it
//! and how, and what is asked.

use crate::{
    ActuatorKind, AnswerScale, Control, Coordinate, Device, Environment, Masses, Mode, Question,
    QuestionId, Resistances, Study,
};
use serde::Serialize;

/// What was planned, as far as tables, pages and schematics show it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setup {
    /// The device.
    pub device: Device,
    /// What people read angles as.
    pub coordinate: Coordinate,
    /// Numbers of the control loop.
    pub control: Control,
    /// Actuator masses.
    pub masses: Option<Masses>,
    /// Resistances of the actuators' windings.
    pub resistances: Resistances,
    /// What is rendered.
    pub environments: Vec<Environment>,
    /// How it is rendered.
    pub modes: Vec<Mode>,
    /// What is asked.
    pub questions: Vec<Question>,
}

impl Setup {
    /// What this study plans.
    pub fn of(study: &Study) -> Self {
        Self {
            device: study.device.clone(),
            coordinate: study.coordinate,
            control: study.control,
            masses: study.masses,
            resistances: study.resistances,
            environments: study.environments.clone(),
            modes: study.modes.clone(),
            questions: study.questions.clone(),
        }
    }

    /// The same without its questions: what a drawing of the device depends on.
    #[must_use]
    pub fn without_questions(self) -> Self {
        Self { questions: Vec::new(), ..self }
    }

    /// The scale of the question of that id; the usual one of a question that is not asked.
    pub fn scale(&self, question: &QuestionId) -> AnswerScale {
        let question = self.questions.iter().find(|q| q.id == *question);
        question.map(|q| q.scale.clone()).unwrap_or_default()
    }

    /// The work space of a lever, rad; `None` for a slide, or if it is not known.
    pub fn stops_rad(&self) -> Option<[f64; 2]> {
        let stops = [self.device.theta_min_rad?, self.device.theta_max_rad?];
        (self.coordinate == Coordinate::Rotational).then_some(stops)
    }

    /// Highest voltage of the motor in any mode, V.
    pub fn motor_max_v(&self) -> Option<f64> {
        self.modes.iter().filter_map(|mode| mode.motor_max_v).reduce(f64::max)
    }

    /// Highest voltage of the brake in any mode, V.
    pub fn brake_max_v(&self) -> Option<f64> {
        self.modes.iter().filter_map(|mode| mode.brake_max_v).reduce(f64::max)
    }

    /// Whether a mode uses an actuator.
    pub fn uses(&self, drive: ActuatorKind) -> bool {
        self.modes.iter().any(|mode| mode.has(drive))
    }
}
