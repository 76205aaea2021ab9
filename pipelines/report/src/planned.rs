//! What the report takes from a study besides results: what was planned.

use serde::Serialize;
use zwidth_study::{
    AnswerScale, Control, Coordinate, Device, Environment, Masses, Mode, Question, QuestionId,
    Resistances, Study,
};

/// What was planned, as far as the report speaks of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planned {
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

impl Planned {
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

    /// The scale of the question of that id.
    pub(crate) fn scale(&self, question: &QuestionId) -> AnswerScale {
        let found = self.questions.iter().find(|q| q.id == *question);
        found.map(|q| q.scale.clone()).unwrap_or_default()
    }
}
