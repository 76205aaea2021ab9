//! What every board receives, whatever its protocol: both voltages, and the moments of a trial.

use zwidth_study::{Moment, Voltages};

/// Both voltages as a board takes them: shares of the full scale, −32767 … 32767.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Drive {
    /// Of the motor.
    pub motor: i16,
    /// Of the brake; below 0 never.
    pub brake: i16,
}

impl Drive {
    /// Voltages as shares of the full scale, rounded towards 0: never more than the command.
    pub fn of(voltages: Voltages, full: Voltages) -> Self {
        let share = |volts: f64, full_v: f64| match full_v > 0.0 {
            true => (volts / full_v * f64::from(i16::MAX)) as i16,
            false => 0,
        };
        let brake = share(voltages.brake_v, full.brake_v).max(0);
        Self { motor: share(voltages.motor_v, full.motor_v), brake }
    }

    /// The voltages again.
    pub fn voltages(self, full: Voltages) -> Voltages {
        let share = |part: i16| f64::from(part) / f64::from(i16::MAX);
        Voltages {
            motor_v: share(self.motor) * full.motor_v,
            brake_v: share(self.brake) * full.brake_v,
        }
    }

    /// As whole steps of outputs with this many steps each; none exceeds the command.
    pub fn steps(self, motor: u16, brake: u16) -> [i32; 2] {
        let steps = |part: i16, full: u16| i32::from(part) * i32::from(full) / i32::from(i16::MAX);
        [steps(self.motor, motor), steps(self.brake, brake)]
    }

    /// From such steps, at least what they are: [`Drive::steps`] gives the same ones again.
    pub fn of_steps([motor, brake]: [i32; 2], motor_full: u16, brake_full: u16) -> Self {
        let part = |steps: i32, full: u16| {
            let full = i32::from(full).max(1);
            let up = (steps.abs().min(full) * i32::from(i16::MAX) + full - 1) / full;
            (up * steps.signum()) as i16
        };
        Self { motor: part(motor, motor_full), brake: part(brake, brake_full).max(0) }
    }
}

/// Codes of markers.
pub mod mark {
    use super::Moment;

    /// The environment of the trial that begins next, by its place in the study.
    pub const ENVIRONMENT: u8 = 1;
    /// A trial begins, by its number.
    pub const TRIAL: u8 = 2;
    /// The lever is to be at its lower stop.
    pub const HOMING: u8 = 3;
    /// A moment of the trial, to be shown on the board's marker pins: [`number`].
    pub const MOMENT: u8 = 4;

    /// The number of a moment: from 1, in a trial's order.
    pub fn number(moment: Moment) -> u16 {
        moment as u16 + 1
    }

    /// The moment of a number, if it is one.
    pub fn moment(number: u16) -> Option<Moment> {
        Moment::ALL.into_iter().find(|moment| self::number(*moment) == number)
    }
}
