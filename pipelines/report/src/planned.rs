//! What the report takes from a study besides results: what was planned.

use serde::Serialize;
use zwidth_study::{Control, Coordinate, Device, Environment, Masses, Mode, Study};

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
    /// What is rendered.
    pub environments: Vec<Environment>,
    /// How it is rendered.
    pub modes: Vec<Mode>,
}

impl Planned {
    /// What this study plans.
    pub fn of(study: &Study) -> Self {
        Self {
            device: study.device.clone(),
            coordinate: study.coordinate,
            control: study.control,
            masses: study.masses,
            environments: study.environments.clone(),
            modes: study.modes.clone(),
        }
    }
}
