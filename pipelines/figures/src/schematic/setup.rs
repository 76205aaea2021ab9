//! What the schematics of the device say about a study's plan.

use crate::words::{Words, plain};
use zwidth_study::Setup;
use zwidth_tables::{number, with_unit};

pub(super) fn words(setup: &Setup) -> Words {
    Words::new(setup.coordinate)
}

/// What is known of the motor: voltage, mass, resistance.
pub(super) fn motor(setup: &Setup) -> Vec<String> {
    let kg = setup.masses.map(|masses| masses.motor_kg);
    actuator("motor", [setup.motor_max_v(), kg, setup.resistances.motor_ohm])
}

/// What is known of the brake, likewise.
pub(super) fn brake(setup: &Setup) -> Vec<String> {
    let kg = setup.masses.map(|masses| masses.brake_kg);
    actuator("brake", [setup.brake_max_v(), kg, setup.resistances.brake_ohm])
}

/// What is known of the force sensor.
pub(super) fn force_sensor(setup: &Setup) -> Vec<String> {
    let rate = setup.device.force_rate_hz.map(|hz| format!("{} values/s", number(hz, None)));
    [Some("force sensor".to_owned()), rate].into_iter().flatten().collect()
}

/// The device's name, as text.
pub(super) fn name(setup: &Setup) -> String {
    if setup.device.name.is_empty() { "Device".to_owned() } else { plain(&setup.device.name) }
}

fn actuator(what: &str, [max_v, kg, ohm]: [Option<f64>; 3]) -> Vec<String> {
    let volts = max_v.map(|v| format!("up to {}", with_unit(&number(v, None), "V")));
    let grams = kg.map(|kg| with_unit(&number(kg * 1e3, None), "g"));
    let ohms = ohm.map(|ohm| with_unit(&number(ohm, None), "Ω"));
    let rest: Vec<String> = grams.into_iter().chain(ohms).collect();
    let rest = Some(rest.join(", ")).filter(|rest| !rest.is_empty());
    [Some(what.to_owned()), volts, rest].into_iter().flatten().collect()
}
