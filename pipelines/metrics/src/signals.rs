//! A trial's samples as the metrics see them: slices of one length, and where the movement's phases
//! lie.

use crate::{MetricsError, Parameters};
use std::borrow::Cow;
use zwidth_numerics::activity::{Activity, activity};
use zwidth_numerics::phases::{Phases, phases};
use zwidth_numerics::updates::{Updates, updates};
use zwidth_store::{Signal, Trial};
use zwidth_study::{Analysis, CURRENT_BRAKE, CURRENT_MOTOR, REFERENCE};

/// `flags`: the brake is on.
const BRAKE_ON: u16 = 128;
/// `flags`: the motor is on.
const MOTOR_ON: u16 = 256;

/// The samples of a trial. All slices are as long as `t`, which has at least one sample.
pub(crate) struct Signals<'a> {
    pub(crate) t: &'a [f64],
    pub(crate) theta: Option<&'a [f64]>,
    pub(crate) theta_dot: Option<&'a [f64]>,
    /// The user's force at each sample: as recorded, or between its sensor's own updates where
    /// their age is recorded.
    pub(crate) force: Option<Cow<'a, [f64]>>,
    /// The force at its sensor's own updates, where their age is recorded.
    pub(crate) force_updates: Option<Updates>,
    pub(crate) force_cmd: Option<&'a [f64]>,
    /// Commanded voltages, V.
    pub(crate) voltage_motor: Option<&'a [f64]>,
    pub(crate) voltage_brake: Option<&'a [f64]>,
    /// Currents in the windings, A, where a study records them.
    pub(crate) current_motor: Option<&'a [f64]>,
    pub(crate) current_brake: Option<&'a [f64]>,
    /// Set-point of the angle, rad, where a study records it.
    pub(crate) reference: Option<&'a [f64]>,
    /// Which samples have the brake on; `None` where the recording does not say.
    pub(crate) brake_on: Option<Vec<bool>>,
    /// Which samples have the motor on.
    pub(crate) motor_on: Option<Vec<bool>>,
    pub(crate) lever_m: Option<f64>,
    /// When the lever moves; `None` without θ̇ or without movement.
    pub(crate) activity: Option<Activity>,
    /// `None` without θ, or where θ̇ shows no movement.
    pub(crate) phases: Option<Phases>,
}

impl<'a> Signals<'a> {
    pub(crate) fn of(trial: &'a Trial, parameters: &Parameters) -> Result<Self, MetricsError> {
        let t = trial
            .samples
            .get(Signal::Time)
            .filter(|t| !t.is_empty())
            .ok_or(MetricsError::NoTime)?;
        let column = |signal: Signal| match trial.samples.get(signal) {
            Some(values) if values.len() != t.len() => {
                let (expected, found) = (t.len(), values.len());
                Err(MetricsError::Ragged { column: signal.name(), expected, found })
            }
            values => Ok(values),
        };
        let theta = column(Signal::Theta)?;
        let theta_dot = column(Signal::ThetaDot)?;
        let Analysis { onset_rad_s, offset_rad_s, .. } = parameters.analysis;
        let active = theta_dot.and_then(|v| activity(v, onset_rad_s, offset_rad_s));
        let phases = match (theta, theta_dot, active) {
            (Some(theta), Some(_), Some(a)) => {
                Some(phases(theta, a.onset, a.end.unwrap_or(t.len() - 1)))
            }
            (Some(theta), None, _) => Some(phases(theta, 0, t.len() - 1)),
            _ => None,
        };
        let recorded = column(Signal::ForceEx)?;
        let force_updates =
            recorded.zip(column(Signal::ForceAge)?).map(|(f, age)| updates(t, f, age));
        let force = match &force_updates {
            Some(updates) => Some(Cow::Owned(updates.at(t))),
            None => recorded.map(Cow::Borrowed),
        };
        let flags = column(Signal::StateBits)?;
        let voltage_motor = column(Signal::VoltageMotor)?;
        let voltage_brake = column(Signal::VoltageBrake)?;
        Ok(Self {
            t,
            theta,
            theta_dot,
            force,
            force_updates,
            force_cmd: column(Signal::ForceCmd)?,
            voltage_motor,
            voltage_brake,
            current_motor: channel(trial, CURRENT_MOTOR, t.len())?,
            current_brake: channel(trial, CURRENT_BRAKE, t.len())?,
            reference: channel(trial, REFERENCE, t.len())?,
            brake_on: on(voltage_brake, flags, BRAKE_ON),
            motor_on: on(voltage_motor, flags, MOTOR_ON),
            lever_m: parameters.lever_m,
            activity: active,
            phases,
        })
    }

    /// θ, F and the phases, where all three are there.
    pub(crate) fn force_over_angle(&self) -> Option<(&'a [f64], &[f64], Phases)> {
        Some((self.theta?, self.force.as_deref()?, self.phases?))
    }
}

/// A channel of the study's own, where the recording has it.
fn channel<'a>(
    trial: &'a Trial,
    name: &'static str,
    expected: usize,
) -> Result<Option<&'a [f64]>, MetricsError> {
    let found = trial.samples.channels().find(|(id, _)| id.as_str() == name);
    match found.map(|(_, values)| values) {
        Some(values) if values.len() != expected => {
            Err(MetricsError::Ragged { column: name, expected, found: values.len() })
        }
        values => Ok(values),
    }
}

/// An actuator is on where its flag is set or its commanded voltage is not 0.
fn on(voltage: Option<&[f64]>, flags: Option<&[f64]>, bit: u16) -> Option<Vec<bool>> {
    // whole numbers of 16 bits: the store has checked
    let flagged = |i: usize| flags.is_some_and(|flags| flags[i] as u16 & bit != 0);
    let powered = |i: usize| voltage.is_some_and(|v| v[i].abs() > 0.0);
    let samples = voltage.or(flags)?.len();
    Some((0..samples).map(|i| flagged(i) || powered(i)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_actuator_is_on_by_its_flag_or_its_voltage_and_unknown_without_both() {
        let (volts, flags) = ([0.0, 2.0, 0.0, -1.0], [128.0, 256.0, 256.0 + 1.0, 0.0]);
        assert_eq!(on(Some(&volts), Some(&flags), BRAKE_ON), Some(vec![true, true, false, true]));
        assert_eq!(on(None, Some(&flags), MOTOR_ON), Some(vec![false, true, true, false]));
        assert_eq!(on(Some(&volts), None, MOTOR_ON), Some(vec![false, true, false, true]));
        assert_eq!(on(None, None, MOTOR_ON), None);
    }
}
