//! What the schematics of the device take from a study.

use crate::words::{Words, plain};
use serde::Serialize;
use zwidth_study::{
    ActuatorKind, Control, Coordinate, Device, Environment, Masses, Mode, Resistances, Study,
};
use zwidth_tables::{number, with_unit};

/// The device, its actuators and its control, as planned.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Setup {
    /// The device.
    pub device: Device,
    /// What the coordinate is called.
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
}

impl Setup {
    /// That of a study.
    pub fn of(study: &Study) -> Self {
        Self {
            device: study.device.clone(),
            coordinate: study.coordinate,
            control: study.control,
            masses: study.masses,
            resistances: study.resistances,
            environments: study.environments.clone(),
            modes: study.modes.clone(),
        }
    }

    pub(crate) fn words(&self) -> Words {
        Words::new(self.coordinate)
    }

    /// The work space of a lever, rad; none of a slide, or where it is not known.
    pub(crate) fn stops_rad(&self) -> Option<[f64; 2]> {
        let stops = [self.device.theta_min_rad?, self.device.theta_max_rad?];
        (self.coordinate == Coordinate::Rotational).then_some(stops)
    }

    /// Highest voltage of any mode, V.
    pub(crate) fn motor_max_v(&self) -> Option<f64> {
        self.modes.iter().filter_map(|mode| mode.motor_max_v).reduce(f64::max)
    }

    /// Highest voltage of any mode, V.
    pub(crate) fn brake_max_v(&self) -> Option<f64> {
        self.modes.iter().filter_map(|mode| mode.brake_max_v).reduce(f64::max)
    }

    /// What is known of the motor: voltage, mass, resistance.
    pub(crate) fn motor(&self) -> Vec<String> {
        let kg = self.masses.map(|masses| masses.motor_kg);
        actuator("motor", [self.motor_max_v(), kg, self.resistances.motor_ohm])
    }

    /// What is known of the brake, likewise.
    pub(crate) fn brake(&self) -> Vec<String> {
        let kg = self.masses.map(|masses| masses.brake_kg);
        actuator("brake", [self.brake_max_v(), kg, self.resistances.brake_ohm])
    }

    /// What is known of the force sensor.
    pub(crate) fn force_sensor(&self) -> Vec<String> {
        let rate = self.device.force_rate_hz.map(|hz| format!("{} values/s", number(hz, None)));
        [Some("force sensor".to_owned()), rate].into_iter().flatten().collect()
    }

    /// Whether a mode uses an actuator.
    pub(crate) fn uses(&self, drive: ActuatorKind) -> bool {
        self.modes.iter().any(|mode| mode.has(drive))
    }

    /// The device's name, as text.
    pub(crate) fn name(&self) -> String {
        if self.device.name.is_empty() { "Device".to_owned() } else { plain(&self.device.name) }
    }
}

fn actuator(what: &str, [max_v, kg, ohm]: [Option<f64>; 3]) -> Vec<String> {
    let value = |value: f64, unit| with_unit(&number(value, None), unit);
    let volts = max_v.map(|v| format!("up to {}", value(v, "V")));
    let rest = [kg.map(|kg| value(kg * 1e3, "g")), ohm.map(|ohm| value(ohm, "Ω"))];
    let rest: Vec<String> = rest.into_iter().flatten().collect();
    let rest = Some(rest.join(", ")).filter(|rest| !rest.is_empty());
    [Some(what.to_owned()), volts, rest].into_iter().flatten().collect()
}
