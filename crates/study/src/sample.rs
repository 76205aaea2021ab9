//! One row of a trial, as the control loop makes it and the store keeps it.

/// Commanded voltages.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Voltages {
    /// Motor, V.
    pub motor_v: f64,
    /// Brake, V.
    pub brake_v: f64,
}

impl Voltages {
    /// Both actuators off.
    pub const OFF: Self = Self { motor_v: 0.0, brake_v: 0.0 };
}

/// The most channels of its own that a study has, and that a device gives.
pub const MOST_CHANNELS: usize = 8;

/// The values of a device's own channels, in its order.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Extra {
    values: [f64; MOST_CHANNELS],
    n: u8,
}

impl Extra {
    /// These values; those behind the [`MOST_CHANNELS`]th are dropped.
    pub fn new(values: &[f64]) -> Self {
        let mut extra = Self::default();
        for (place, value) in extra.values.iter_mut().zip(values) {
            *place = *value;
            extra.n += 1;
        }
        extra
    }

    /// The values.
    pub fn values(&self) -> &[f64] {
        // `n` is never more; the bound shows that the slice cannot panic.
        &self.values[..usize::from(self.n).min(MOST_CHANNELS)]
    }
}

/// Status bits of a sample: the column `state_bits`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Flags(pub u16);

impl Flags {
    // Recordings hold these numbers: a bit never changes its meaning.
    /// The demanded force is above what the actuator in charge can give.
    pub const SATURATED: Self = Self(1);
    /// The force value is older than two of its own periods.
    pub const STALE_FORCE: Self = Self(2);
    /// The angle sensor gave no new value.
    pub const STALE_ANGLE: Self = Self(4);
    /// Samples are missing before this one.
    pub const DROPOUT: Self = Self(8);
    /// A voltage was clamped.
    pub const CLIPPED: Self = Self(16);
    /// The lever is past the wall.
    pub const PAST_WALL: Self = Self(32);
    /// The lever is outside the work space.
    pub const OUTSIDE: Self = Self(64);
    /// The brake is on.
    pub const BRAKE_ON: Self = Self(128);
    /// The motor is on.
    pub const MOTOR_ON: Self = Self(256);

    /// These bits with those of `other` where `condition` holds.
    #[must_use]
    pub fn with(self, other: Self, condition: bool) -> Self {
        if condition { Self(self.0 | other.0) } else { self }
    }

    /// Whether every bit of `other` is set.
    pub fn has(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One sample of a trial (`docs/data.md`, "A trial file"); SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time since the trial's start, host's clock, s.
    pub t_s: f64,
    /// The device's own clock, s, if it has one.
    pub t_device_s: Option<f64>,
    /// Lever angle, rad.
    pub theta_rad: f64,
    /// Lever velocity as the controller used it, rad/s.
    pub theta_dot_rad_s: f64,
    /// User force, N; above 0 pushes into the object.
    pub force_ex_n: f64,
    /// Voltages commanded after this sample was read.
    pub voltages: Voltages,
    /// Age of the force value, s, where known.
    pub force_age_s: Option<f64>,
    /// The angle sensor's own count, if it has one.
    pub theta_raw: Option<u16>,
    /// Feedback force that the voltages stand for, by the calibration in force, N.
    pub force_cmd_n: f64,
    /// Status bits.
    pub flags: Flags,
    /// The device's channels.
    pub extra: Extra,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_set_where_their_condition_holds() {
        let flags = Flags::default().with(Flags::PAST_WALL, true).with(Flags::BRAKE_ON, false);
        assert!(flags.has(Flags::PAST_WALL) && !flags.has(Flags::BRAKE_ON));
        assert_eq!(flags.0, 32);
    }
}
