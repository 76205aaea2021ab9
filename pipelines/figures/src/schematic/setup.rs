//! What the schematics of the device say about a study's plan.

use crate::words::{Words, plain};
use zwidth_study::Setup;
use zwidth_tables::{number, with_unit};

pub(super) fn words(of: &Setup) -> Words {
    Words::new(of.coordinate)
}

/// What is known of the motor: voltage, mass, resistance.
pub(super) fn motor(of: &Setup) -> Vec<String> {
    let kg = of.masses.map(|masses| masses.motor_kg);
    actuator("motor", [of.motor_max_v(), kg, of.resistances.motor_ohm])
}

/// What is known of the brake, likewise.
pub(super) fn brake(of: &Setup) -> Vec<String> {
    let kg = of.masses.map(|masses| masses.brake_kg);
    actuator("brake", [of.brake_max_v(), kg, of.resistances.brake_ohm])
}

/// What is known of the force sensor.
pub(super) fn force_sensor(of: &Setup) -> Vec<String> {
    let rate = of.device.force_rate_hz.map(|hz| format!("{} values/s", number(hz, None)));
    [Some("force sensor".to_owned()), rate].into_iter().flatten().collect()
}

/// The device's name, as text.
pub(super) fn name(of: &Setup) -> String {
    if of.device.name.is_empty() { "Device".to_owned() } else { plain(&of.device.name) }
}

fn actuator(what: &str, [max_v, kg, ohm]: [Option<f64>; 3]) -> Vec<String> {
    let value = |value: f64, unit| with_unit(&number(value, None), unit);
    let volts = max_v.map(|v| format!("up to {}", value(v, "V")));
    let rest = [kg.map(|kg| value(kg * 1e3, "g")), ohm.map(|ohm| value(ohm, "Ω"))];
    let rest: Vec<String> = rest.into_iter().flatten().collect();
    let rest = Some(rest.join(", ")).filter(|rest| !rest.is_empty());
    [Some(what.to_owned()), volts, rest].into_iter().flatten().collect()
}
