//! A trial's samples as the metrics see them: columns of one length, and the places of the
//! movement's phases.
//!
//! A column is requested when it is needed and released afterwards, and no metric needs more than
//! three at a time. The columns of a long trial are read from its file on request.

use crate::{MetricsError, Parameters};
use std::sync::Arc;
use zwidth_numerics::activity::{Activity, activity};
use zwidth_numerics::phases::{Phases, phases};
use zwidth_numerics::updates::{Updates, updates};
use zwidth_store::{Columns, Signal, Values};
use zwidth_study::Analysis;

/// `flags`: the brake is on.
const BRAKE_ON: u16 = 128;
/// `flags`: the motor is on.
const MOTOR_ON: u16 = 256;

/// The samples of a trial. All columns are equally long, and have at least one sample.
pub(crate) struct Signals<'a> {
    columns: &'a dyn Columns,
    /// The user's force at each sample between its sensor's own updates, and these updates, where
    /// their age is recorded.
    force_updates: Option<(Arc<Vec<f64>>, Updates)>,
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
    pub(crate) fn of(
        columns: &'a dyn Columns,
        parameters: &Parameters,
    ) -> Result<Self, MetricsError> {
        let motion = Self::of_motion(columns, parameters)?;
        let actuators = [(Signal::VoltageBrake, BRAKE_ON), (Signal::VoltageMotor, MOTOR_ON)];
        let [brake_on, motor_on] = actuators.map(|(voltage, bit)| {
            let voltage = columns.column(voltage);
            let flags = columns.column(Signal::StateBits);
            on(voltage.as_deref(), flags.as_deref(), bit)
        });
        Ok(Self { brake_on, motor_on, ..motion })
    }

    /// The same without saying when an actuator is on.
    pub(crate) fn of_motion(
        columns: &'a dyn Columns,
        parameters: &Parameters,
    ) -> Result<Self, MetricsError> {
        let expected = columns.rows();
        if expected == 0 {
            return Err(MetricsError::NoTime);
        }
        if let Some((column, found)) = columns.ragged() {
            return Err(MetricsError::Ragged { column, expected, found });
        }
        let force_updates = force_updates(columns);
        let Analysis { onset_rad_s, offset_rad_s, .. } = parameters.analysis;
        let theta_dot = columns.column(Signal::ThetaDot);
        let active = theta_dot.as_ref().and_then(|v| activity(v, onset_rad_s, offset_rad_s));
        let phases = match (columns.column(Signal::Theta), theta_dot, active) {
            (Some(theta), Some(_), Some(a)) => {
                Some(phases(&theta, a.onset, a.end.unwrap_or(expected - 1)))
            }
            // Without a velocity the whole recording stands in for the movement.
            (Some(theta), None, _) => Some(phases(&theta, 0, expected - 1)),
            _ => None,
        };
        Ok(Self {
            columns,
            force_updates,
            brake_on: None,
            motor_on: None,
            lever_m: parameters.lever_m,
            activity: active,
            phases,
        })
    }

    /// A signal as recorded.
    pub(crate) fn column(&self, signal: Signal) -> Option<Values<'a>> {
        self.columns.column(signal)
    }

    /// Whether a signal was recorded.
    pub(crate) fn has(&self, signal: Signal) -> bool {
        self.columns.has(signal)
    }

    /// A channel of the study's own.
    pub(crate) fn channel(&self, name: &str) -> Option<Values<'a>> {
        self.columns.channel(name)
    }

    pub(crate) fn t(&self) -> Result<Values<'a>, MetricsError> {
        self.column(Signal::Time).ok_or(MetricsError::NoTime)
    }

    pub(crate) fn theta(&self) -> Option<Values<'a>> {
        self.column(Signal::Theta)
    }

    pub(crate) fn theta_dot(&self) -> Option<Values<'a>> {
        self.column(Signal::ThetaDot)
    }

    /// The user's force at each sample: as recorded, or between its sensor's own updates where their
    /// age is recorded.
    pub(crate) fn force(&self) -> Option<Values<'a>> {
        match &self.force_updates {
            Some((force, _)) => Some(Values::Read(force.clone())),
            None => self.column(Signal::ForceEx),
        }
    }

    /// The force at its sensor's own updates, where their age is recorded.
    pub(crate) fn force_updates(&self) -> Option<&Updates> {
        self.force_updates.as_ref().map(|(_, updates)| updates)
    }

    /// θ, F and the phases, where all three are there.
    pub(crate) fn force_over_angle(&self) -> Option<(Values<'a>, Values<'a>, Phases)> {
        Some((self.theta()?, self.force()?, self.phases?))
    }

    /// Gives back the columns that nobody holds.
    pub(crate) fn forget(&self) {
        self.columns.forget();
    }
}

fn force_updates(columns: &dyn Columns) -> Option<(Arc<Vec<f64>>, Updates)> {
    if !columns.has(Signal::ForceAge) {
        return None;
    }
    let t = columns.column(Signal::Time)?;
    let recorded = columns.column(Signal::ForceEx)?;
    let age = columns.column(Signal::ForceAge)?;
    let updates = updates(&t, &recorded, &age);
    Some((Arc::new(updates.at(&t)), updates))
}

/// An actuator is on where its flag is set or its commanded voltage is not 0.
fn on(voltage: Option<&[f64]>, flags: Option<&[f64]>, bit: u16) -> Option<Vec<bool>> {
    let is_powered = |i: usize| voltage.is_some_and(|volts| volts[i].abs() > 0.0);
    // whole numbers of 16 bits: the store has checked
    let is_flagged = |i: usize| flags.is_some_and(|f| f[i] as i32 & i32::from(bit) != 0);
    let samples = 0..voltage.or(flags)?.len();
    Some(samples.map(|i| is_powered(i) || is_flagged(i)).collect())
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
