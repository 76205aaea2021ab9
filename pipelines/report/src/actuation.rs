//! Which actuator of a mode acts on which way.

use crate::Planned;
use zwidth_study::{Calibration, Mode};

/// Motor or brake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Actuator {
    Motor,
    Brake,
}

impl Actuator {
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Motor => "motor",
            Self::Brake => "brake",
        }
    }
}

/// What acts while compressing and while decompressing, with its highest voltage, V: a mode of both
/// has the brake on the way in and the motor on the way back (thesis §2.2).
pub(crate) fn acting(mode: &Mode) -> [Option<(Actuator, f64)>; 2] {
    let motor = mode.motor_max_v.map(|v| (Actuator::Motor, v));
    let brake = mode.brake_max_v.map(|v| (Actuator::Brake, v));
    [brake.or(motor), motor.or(brake)]
}

/// The force of an actuator at a voltage, N.
pub(crate) fn force_n(calibration: &Calibration, (actuator, voltage_v): (Actuator, f64)) -> f64 {
    match actuator {
        Actuator::Motor => calibration.motor.force_n(voltage_v),
        Actuator::Brake => calibration.brake.force_n(voltage_v),
    }
}

/// The study's first mode with a motor alone: the thesis' active one.
pub(crate) fn active(study: &Planned) -> Option<&Mode> {
    study.modes.iter().find(|m| m.motor_max_v.is_some() && m.brake_max_v.is_none())
}

/// The study's first mode with a brake alone: the thesis' passive one.
pub(crate) fn passive(study: &Planned) -> Option<&Mode> {
    study.modes.iter().find(|m| m.brake_max_v.is_some() && m.motor_max_v.is_none())
}

/// The study's first mode with both.
pub(crate) fn hybrid(study: &Planned) -> Option<&Mode> {
    study.modes.iter().find(|m| m.brake_max_v.is_some() && m.motor_max_v.is_some())
}
