//! The table `[firmata]` of `rig.toml`.

use serde::{Deserialize, Serialize};
use zwidth_device::Capabilities;

/// Where a Firmata board's angle sensor is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum AngleAt {
    /// At an analog channel, 0–15.
    Analog(u8),
    /// An AS5600 at the I²C bus.
    I2c,
}

impl TryFrom<String> for AngleAt {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        let channel = text.strip_prefix('A').and_then(|number| number.parse().ok());
        match channel.filter(|channel| *channel < 16) {
            Some(channel) => Ok(Self::Analog(channel)),
            None if text == "i2c" => Ok(Self::I2c),
            None => Err(format!(
                "'{text}' is not a place of an angle sensor: \"A0\" to \"A15\", or \"i2c\""
            )),
        }
    }
}

impl From<AngleAt> for String {
    fn from(at: AngleAt) -> Self {
        match at {
            AngleAt::Analog(channel) => format!("A{channel}"),
            AngleAt::I2c => "i2c".to_owned(),
        }
    }
}

/// A board that speaks Firmata: what is at which of its pins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Firmata {
    /// Readings per second; the board supports intervals of whole milliseconds.
    #[serde(default = "usual_firmata_rate")]
    pub rate_hz: f64,
    /// Where the angle sensor is.
    pub angle: AngleAt,
    /// The pin of the motor's pulses, and the one that is high while it pushes towards +θ.
    pub motor_pwm: u8,
    /// That one.
    pub motor_direction: u8,
    /// The direction's pin is low while the motor pushes towards +θ.
    #[serde(default)]
    pub motor_reversed: bool,
    /// The pin of the brake's pulses.
    pub brake_pwm: u8,
    /// The motor's voltage at full pulses, V.
    pub motor_max_v: f64,
    /// The brake's voltage at full pulses, V.
    pub brake_max_v: f64,
}

/// What pyFirmata2's authors state for analog readings over USB.
fn usual_firmata_rate() -> f64 {
    100.0
}

impl Firmata {
    /// The pins of a board in software.
    pub(crate) fn usual(rate_hz: f64, angle: AngleAt, can: &Capabilities) -> Self {
        Self {
            rate_hz,
            angle,
            motor_pwm: 5,
            motor_direction: 4,
            motor_reversed: false,
            brake_pwm: 6,
            motor_max_v: can.motor_max_v,
            brake_max_v: can.brake_max_v,
        }
    }
}
