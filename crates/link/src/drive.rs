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
        let both = [(voltages.motor_v, full.motor_v), (voltages.brake_v, full.brake_v)];
        // A board that has no such actuator has a full scale of 0 V.
        let [motor, brake] = both.map(|(volts, full_v)| match full_v > 0.0 {
            true => (volts / full_v * f64::from(i16::MAX)) as i16,
            false => 0,
        });
        Self { motor, brake: brake.max(0) }
    }

    /// The voltages again.
    pub fn voltages(self, full: Voltages) -> Voltages {
        let [motor, brake] =
            [self.motor, self.brake].map(|part| f64::from(part) / f64::from(i16::MAX));
        Voltages { motor_v: motor * full.motor_v, brake_v: brake * full.brake_v }
    }

    /// As whole steps of outputs with this many steps each; none exceeds the command.
    pub fn steps(self, motor: u16, brake: u16) -> [i32; 2] {
        [(self.motor, motor), (self.brake, brake)]
            .map(|(part, full)| i32::from(part) * i32::from(full) / i32::from(i16::MAX))
    }

    /// From such steps, at least what they are: [`Drive::steps`] gives the same ones again.
    pub fn of_steps([motor, brake]: [i32; 2], motor_full: u16, brake_full: u16) -> Self {
        let [motor, brake] = [(motor, motor_full), (brake, brake_full)].map(|(steps, full)| {
            let full = i32::from(full).max(1);
            // Rounded up: `steps` rounds down, and would else give one step less.
            let up = (steps.abs().min(full) * i32::from(i16::MAX) + full - 1) / full;
            (up * steps.signum()) as i16
        });
        Self { motor, brake: brake.max(0) }
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
