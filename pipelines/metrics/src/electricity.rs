//! The electrical energy of a trial.

use crate::Parameters;
use crate::signals::Signals;
use serde::Serialize;
use zwidth_study::Resistances;

/// What a trial takes from its supply, at most: no current is recorded, so the energy is bounded by
/// voltages and resistances.
///
/// A winding with resistance R at voltage U has the current (U − e) / R, e the voltage that its
/// motion makes. At rest U² / R is its power exactly; driven along it takes less. Driven against
/// its force, as a spring is pressed, it takes more, by |U e| / R, which is the mechanical power
/// F L |θ̇| of the force F that U stands for at rest. So E ≤ ∫ (U_m² / R_m + U_b² / R_b + [U_m ≠ 0]
/// |F_cmd| L |θ̇|) dt over the recording, voltages held from sample to sample. What drivers and
/// computers take is not in it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ElectricalEnergy {
    /// The bound, J. Null where an actuator that the mode uses has no resistance in study.toml or
    /// no voltage recorded, and for a motor without commanded force, angle or lever length.
    pub bound_j: Option<f64>,
    /// ∫|F_cmd| dt over that bound, N·s/J: how much force an energy buys, at least. Null where
    /// nothing was commanded.
    pub force_per_power_n_per_w: Option<f64>,
}

pub(crate) fn electrical_energy(signals: &Signals, parameters: &Parameters) -> ElectricalEnergy {
    let Resistances { motor_ohm, brake_ohm } = parameters.resistances;
    let heat = |used: bool, voltage: Option<&[f64]>, ohm: Option<f64>| match used {
        false => Some(0.0),
        true => voltage.zip(ohm).map(|(v, ohm)| held(signals.t, |i| v[i] * v[i] / ohm)),
    };
    let motor_j = heat(parameters.uses_motor, signals.voltage_motor, motor_ohm);
    let brake_j = heat(parameters.uses_brake, signals.voltage_brake, brake_ohm);
    let driven_j = if parameters.uses_motor { driven_j(signals) } else { Some(0.0) };
    let bound_j = motor_j.zip(brake_j).zip(driven_j).map(|((m, b), d)| m + b + d);
    let bound_j = bound_j.filter(|_| parameters.uses_motor || parameters.uses_brake);
    let commanded = signals.force_cmd.map(|f| held(signals.t, |i| f[i].abs()));
    let share = commanded.zip(bound_j).filter(|(force, energy)| *force > 0.0 && *energy > 0.0);
    ElectricalEnergy {
        bound_j,
        force_per_power_n_per_w: share.map(|(force, energy)| force / energy),
    }
}

/// Σ of a power that is held from each sample to the next, times that time.
fn held(t: &[f64], power: impl Fn(usize) -> f64) -> f64 {
    t.windows(2).enumerate().map(|(i, t)| power(i) * (t[1] - t[0])).sum()
}

/// ∫ |F_cmd| L |dθ| while the motor is on.
fn driven_j(signals: &Signals) -> Option<f64> {
    let (voltage, force) = (signals.voltage_motor?, signals.force_cmd?);
    let (theta, lever_m) = (signals.theta?, signals.lever_m?);
    let on = |i: &usize| voltage[*i] != 0.0;
    let step = |i: usize| force[i].abs() * lever_m * (theta[i + 1] - theta[i]).abs();
    Some((0..theta.len().saturating_sub(1)).filter(on).map(step).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{LEVER_M, REST_RAD, in_spring, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::{Signal, Trial};

    /// 2 s there and back over 1 rad, and a second of rest; motor at 10 V and 2.6 N throughout, brake
    /// at 4 V for the half of it.
    fn driven() -> Trial {
        let points = stroke(1.0, 2.0);
        let mut made = trial(&points, |_, _| 1.0);
        let of = |f: &dyn Fn(f64) -> f64| points.iter().map(|p| f(p.0)).collect::<Vec<f64>>();
        made.samples.set(Signal::VoltageMotor, of(&|_| 10.0));
        made.samples.set(Signal::VoltageBrake, of(&|t| if t < 1.5 { 4.0 } else { 0.0 }));
        made.samples.set(Signal::ForceCmd, of(&|_| -2.6));
        made
    }

    fn with(motor_ohm: Option<f64>, brake_ohm: Option<f64>) -> Parameters {
        let resistances = Resistances { motor_ohm, brake_ohm };
        let parameters = in_spring(4.0, REST_RAD);
        Parameters { resistances, uses_motor: true, uses_brake: true, ..parameters }
    }

    #[test]
    fn the_bound_is_the_heat_at_rest_and_the_work_of_the_motor() {
        let found = trial_metrics(&driven(), &with(Some(20.0), Some(8.0))).unwrap().electricity;
        let expect = 100.0 / 20.0 * 3.0 + 16.0 / 8.0 * 1.5 + 2.6 * LEVER_M * 2.0;
        let bound = found.bound_j.unwrap();
        assert!((bound - expect).abs() < 1e-6, "{bound} instead of {expect}");
        let share = found.force_per_power_n_per_w.unwrap();
        assert!((share - 2.6 * 3.0 / expect).abs() < 1e-6, "{share}");
    }

    #[test]
    fn an_actuator_in_use_whose_resistance_is_not_known_leaves_no_bound() {
        let of = |parameters: &Parameters| {
            trial_metrics(&driven(), parameters).unwrap().electricity.bound_j
        };
        assert_eq!(of(&with(Some(20.0), None)), None);
        assert_eq!(of(&with(None, Some(8.0))), None);
        let motor_alone = Parameters { uses_brake: false, ..with(Some(20.0), None) };
        assert!(of(&motor_alone).is_some());
        let none =
            Parameters { uses_motor: false, uses_brake: false, ..with(Some(1.0), Some(1.0)) };
        assert_eq!(of(&none), None);
    }

    #[test]
    fn a_motor_whose_command_was_not_recorded_has_no_bound() {
        let mut made = driven();
        let mut samples = zwidth_store::Samples::default();
        for signal in Signal::all().filter(|s| *s != Signal::ForceCmd) {
            if let Some(values) = made.samples.get(signal) {
                samples.set(signal, values.to_vec());
            }
        }
        made.samples = samples;
        let found = trial_metrics(&made, &with(Some(20.0), Some(8.0))).unwrap().electricity;
        assert_eq!(found, ElectricalEnergy::default());
    }
}
