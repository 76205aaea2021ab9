//! Which actuator of a mode acts on which way.

use zwidth_study::{ActuatorKind, Calibration, Mode, ModeLaw, Setup};

/// What acts while compressing and while decompressing, with its highest voltage, V: a mode of both
/// has the brake on the way in and the motor on the way back (thesis §2.2).
pub(crate) fn acting(mode: &Mode) -> [Option<(ActuatorKind, f64)>; 2] {
    mode.law().map_or([None; 2], |law| {
        law.drives().map(|drive| {
            let max_v = match drive {
                ActuatorKind::Motor => mode.motor_max_v,
                ActuatorKind::Brake => mode.brake_max_v,
            };
            max_v.map(|v| (drive, v))
        })
    })
}

/// The force of an actuator at a voltage, N.
pub(crate) fn force_n(
    calibration: &Calibration,
    (actuator, voltage_v): (ActuatorKind, f64),
) -> f64 {
    match actuator {
        ActuatorKind::Motor => calibration.motor.force_n(voltage_v),
        ActuatorKind::Brake => calibration.brake.force_n(voltage_v),
    }
}

/// The study's first mode with a motor alone: the thesis' active one.
pub(crate) fn active(study: &Setup) -> Option<&Mode> {
    with_law(study, ModeLaw::Active)
}

/// The study's first mode with a brake alone: the thesis' passive one.
pub(crate) fn passive(study: &Setup) -> Option<&Mode> {
    with_law(study, ModeLaw::Passive)
}

/// The study's first mode in which the motor takes over from the brake: the thesis' hybrid one.
pub(crate) fn hybrid(study: &Setup) -> Option<&Mode> {
    with_law(study, ModeLaw::Hybrid)
}

/// The study's first mode of that law.
pub(crate) fn with_law(study: &Setup, law: ModeLaw) -> Option<&Mode> {
    study.modes.iter().find(|mode| mode.law() == Some(law))
}
