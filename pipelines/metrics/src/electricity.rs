//! The electrical energy of a trial.

use crate::Parameters;
use crate::signals::Signals;
use serde::Serialize;
use zwidth_store::Signal;
use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, Resistances};

/// The energy that a trial takes from its supply.
///
/// **Recorded**: E = ∫ (U_m I_m + U_b I_b) dt over the recording, U the commanded voltage, held
/// from sample to sample, I the current recorded beside it
/// ([`CURRENT_MOTOR`](zwidth_study::CURRENT_MOTOR),
/// [`CURRENT_BRAKE`](zwidth_study::CURRENT_BRAKE)), with straight lines between samples. U I > 0 is
/// taken from the supply, U I < 0 given back to it: a motor that is moved along its force faster
/// than its voltage alone would drive it. A current that follows its voltage within one sample is
/// taken to rise over that whole sample, which leaves out about ½ Σ (ΔU)² Δt / 2 R.
///
/// **At most**, where no current is recorded: a winding with resistance R at voltage U has the
/// current (U − e) / R, e the voltage that its motion makes, and takes U² / R − U e / R. U² / R
/// alone is a bound at rest and for a motor that is moved along its force, which takes less. It is
/// none for a motor that is moved against its force, as where a spring is pressed: that one
/// takes |U e| / R more, which is the mechanical power F L |θ̇| of the force F that U stands for at
/// rest. So E ≤ ∫ (U_m² / R_m + U_b² / R_b + [U_m ≠ 0]
/// |F_cmd| L |θ̇|) dt, voltages held from sample to sample, whatever the motion. It supposes that no
/// current flows at the beginning (an inductance then takes no more: the current is the voltage's
/// through a low-pass filter, and ∫ U I dt ≤ ∫ U² / R dt), that R is no less than study.toml says
/// (a warm winding has more), that the calibration's force is the motor's, and that one actuator is
/// commanded at a time, so that F_cmd is the motor's where it is on.
///
/// Neither includes the energy of drivers and computers.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct ElectricalEnergy {
    /// E, J, from recorded currents. Null where an actuator that the mode uses lacks its current or
    /// its voltage.
    pub taken_j: Option<f64>,
    /// The bound, J. Null where an actuator that the mode uses has no resistance in study.toml or
    /// no voltage recorded, and for a motor without commanded force, angle or lever length.
    pub bound_j: Option<f64>,
    /// ∫|F_cmd| dt over E, N·s/J: how much force an energy buys. Null where nothing was commanded,
    /// or no energy taken.
    pub force_per_power_recorded_n_per_w: Option<f64>,
    /// ∫|F_cmd| dt over the bound: at least so much.
    pub force_per_power_n_per_w: Option<f64>,
}

pub(crate) fn electrical_energy(signals: &Signals, parameters: &Parameters) -> ElectricalEnergy {
    if !(parameters.uses_motor || parameters.uses_brake) {
        return ElectricalEnergy::default();
    }
    let taken_j = taken_j(signals, parameters);
    let bound_j = bound_j(signals, parameters);
    let commanded = held(signals, Signal::ForceCmd, |f| f.abs());
    // A motor can give back more than it took: the share would have no meaning then.
    let [force_per_power_recorded_n_per_w, force_per_power_n_per_w] =
        [taken_j, bound_j].map(|energy_j| {
            let both =
                commanded.zip(energy_j).filter(|(force, energy)| *force > 0.0 && *energy > 0.0);
            both.map(|(force, energy)| force / energy)
        });
    ElectricalEnergy { taken_j, bound_j, force_per_power_recorded_n_per_w, force_per_power_n_per_w }
}

/// ∫ (U_m I_m + U_b I_b) dt.
fn taken_j(signals: &Signals, parameters: &Parameters) -> Option<f64> {
    let [motor_j, brake_j] = [
        (parameters.uses_motor, Signal::VoltageMotor, CURRENT_MOTOR),
        (parameters.uses_brake, Signal::VoltageBrake, CURRENT_BRAKE),
    ]
    .map(|(used, voltage, current)| {
        if !used {
            return Some(0.0);
        }
        let v = signals.column(voltage)?;
        let a = signals.channel(current)?;
        Some(over_time(&signals.t().ok()?, |i| v[i] * (a[i] + a[i + 1]) / 2.0))
    });
    Some(motor_j? + brake_j?)
}

/// ∫ (U_m² / R_m + U_b² / R_b + [U_m ≠ 0] |F_cmd| L |θ̇|) dt.
fn bound_j(signals: &Signals, parameters: &Parameters) -> Option<f64> {
    let Resistances { motor_ohm, brake_ohm } = parameters.resistances;
    let [motor_j, brake_j] = [
        (parameters.uses_motor, Signal::VoltageMotor, motor_ohm),
        (parameters.uses_brake, Signal::VoltageBrake, brake_ohm),
    ]
    .map(|(used, voltage, ohm)| {
        if !used {
            return Some(0.0);
        }
        ohm.and_then(|ohm| held(signals, voltage, |v| v * v / ohm))
    });
    let driven_j = if parameters.uses_motor { driven_j(signals)? } else { 0.0 };
    Some(motor_j? + brake_j? + driven_j)
}

/// Σ of a signal's `power`, which is held from each sample to the next, times that time; `None` where
/// the signal is not recorded.
fn held(signals: &Signals, signal: Signal, power: impl Fn(f64) -> f64) -> Option<f64> {
    let values = signals.column(signal)?;
    Some(over_time(&signals.t().ok()?, |i| power(values[i])))
}

/// Σ of what is held from each sample to the next, times that time.
fn over_time(t: &[f64], power: impl Fn(usize) -> f64) -> f64 {
    t.windows(2).enumerate().map(|(i, t)| power(i) * (t[1] - t[0])).sum()
}

/// ∫ |F_cmd| L |dθ| while the motor is on.
fn driven_j(signals: &Signals) -> Option<f64> {
    let voltage = signals.column(Signal::VoltageMotor)?;
    let force = signals.column(Signal::ForceCmd)?;
    let theta = signals.theta()?;
    let lever_m = signals.lever_m?;
    let driven = (0..theta.len().saturating_sub(1)).filter(|i| voltage[*i] != 0.0);
    Some(driven.map(|i| force[i].abs() * lever_m * (theta[i + 1] - theta[i]).abs()).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{LEVER_M, REST_RAD, in_spring, only, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::{Signal, Trial};
    use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR};

    /// 2 s there and back over 1 rad, and a second of rest; motor at 10 V and 2.6 N throughout,
    /// brake at 4 V for the half of it.
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

    /// Samples every ms for 3 s; a voltage and a current, each by its time, and who is in use.
    fn recorded(uses: [bool; 2], channels: &[(&str, &dyn Fn(f64) -> f64)]) -> ElectricalEnergy {
        let mut made = driven();
        let t = made.samples.get(Signal::Time).unwrap().to_vec();
        for (name, of) in channels {
            made.samples.set_channel(name.parse().unwrap(), t.iter().map(|t| of(*t)).collect());
        }
        let [uses_motor, uses_brake] = uses;
        let parameters = Parameters { uses_motor, uses_brake, ..with(Some(20.0), Some(8.0)) };
        trial_metrics(&made, &parameters).unwrap().electricity
    }

    #[test]
    fn a_constant_voltage_and_current_take_their_product_for_the_time() {
        let motor: (&str, &dyn Fn(f64) -> f64) = (CURRENT_MOTOR, &|_| 0.4);
        let brake: (&str, &dyn Fn(f64) -> f64) = (CURRENT_BRAKE, &|_| 0.25);
        let found = recorded([true, true], &[motor, brake]);
        let expect = 10.0 * 0.4 * 3.0 + 4.0 * 0.25 * 1.5;
        assert!((found.taken_j.unwrap() - expect).abs() < 1e-9, "{found:?}");
        let share = found.force_per_power_recorded_n_per_w.unwrap();
        assert!((share - 2.6 * 3.0 / expect).abs() < 1e-9, "{found:?}");
        let bound = recorded([true, true], &[]).bound_j;
        assert!(bound.is_some() && found.bound_j == bound, "the bound stays what it was");
        let alone = recorded([true, false], &[motor]).taken_j.unwrap();
        assert!((alone - 12.0).abs() < 1e-9, "{alone}");
    }

    /// A winding of R and L at U from t = 0 on: I = U / R (1 − exp(−t R / L)), and ∫ U I dt = U² /
    /// R (T − τ (1 − exp(−T / τ))), τ = L / R. Straight lines between samples of h leave U² h² / 12
    /// R τ of it out, 8 µJ.
    #[test]
    fn a_winding_that_is_switched_on_takes_what_its_current_says_and_less_than_the_bound() {
        let (ohm, tau_s) = (20.0, 0.05);
        let current = move |t: f64| 10.0 / ohm * (1.0 - libm::exp(-t / tau_s));
        let found = recorded([true, false], &[(CURRENT_MOTOR, &current)]);
        let expect = 100.0 / ohm * (3.0 - tau_s * (1.0 - libm::exp(-3.0 / tau_s)));
        let taken = found.taken_j.unwrap();
        assert!((taken - expect).abs() < 1e-5, "{taken} instead of {expect}");
        assert!(taken < found.bound_j.unwrap());
    }

    /// At a constant voltage, moved against its force and then along it: the first takes U² / R and
    /// more, the second less, and fast enough it gives back.
    #[test]
    fn a_motor_takes_more_than_its_heat_at_rest_where_it_is_moved_against_its_force() {
        let back_emf = |e: f64| move |_: f64| (10.0 - e) / 20.0;
        let of =
            |e: f64| recorded([true, false], &[(CURRENT_MOTOR, &back_emf(e))]).taken_j.unwrap();
        let at_rest = 100.0 / 20.0 * 3.0;
        assert!((of(0.0) - at_rest).abs() < 1e-9);
        assert!(of(-2.0) > at_rest && of(2.0) < at_rest && of(12.0) < 0.0);
        let given = recorded([true, false], &[(CURRENT_MOTOR, &back_emf(12.0))]);
        assert_eq!(given.force_per_power_recorded_n_per_w, None, "no energy was taken");
    }

    #[test]
    fn without_the_current_of_every_actuator_in_use_no_energy_is_told() {
        let motor: (&str, &dyn Fn(f64) -> f64) = (CURRENT_MOTOR, &|_| 0.4);
        assert_eq!(recorded([true, true], &[motor]).taken_j, None);
        assert_eq!(recorded([false, true], &[motor]).taken_j, None);
        assert_eq!(recorded([true, true], &[]).taken_j, None);
        assert_eq!(recorded([false, false], &[motor]), ElectricalEnergy::default());
    }

    #[test]
    fn a_current_of_another_length_is_refused_by_its_name() {
        let mut made = driven();
        made.samples.set_channel(CURRENT_MOTOR.parse().unwrap(), vec![1.0]);
        let error = trial_metrics(&made, &with(None, None)).unwrap_err().to_string();
        assert!(error.contains("current_motor_a"), "{error}");
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
        let made = only(&driven(), Signal::all().filter(|s| *s != Signal::ForceCmd));
        let found = trial_metrics(&made, &with(Some(20.0), Some(8.0))).unwrap().electricity;
        assert_eq!(found, ElectricalEnergy::default());
    }
}
