//! The table `[text]` of `rig.toml`.

use super::{Field, Template, TemplateError};
use crate::check::unable;
use serde::{Deserialize, Serialize};
use zwidth_device::{Capabilities, DeviceError};

/// A board that prints lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Lines per second.
    pub rate_hz: f64,
    /// The form of a line, such as `"{t_ms},{counts},{hx711}"`.
    pub line: String,
    /// The command for both voltages, as `"M{motor_pwm} B{brake_pwm}\n"`.
    pub command: String,
    /// The command for a marker, where the sketch takes one: `"K{code} {number}\n"`.
    pub mark: Option<String>,
    /// The number in a command that stands for the full voltage.
    #[serde(default = "usual_pwm")]
    pub pwm_full: u16,
    /// Counts of the angle sensor in a turn of the shaft.
    pub counts_per_turn: u16,
    /// The motor's voltage at the full number, V.
    pub motor_max_v: f64,
    /// The brake's voltage at the full number, V.
    pub brake_max_v: f64,
}

/// The templates of a board that prints lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Templates {
    /// Of its lines.
    pub line: Template,
    /// Of commands for both voltages.
    pub command: Template,
    /// Of markers.
    pub mark: Option<Template>,
}

impl Text {
    /// What a sketch in software prints.
    pub(crate) fn usual(rate_hz: f64, can: &Capabilities) -> Self {
        Self {
            rate_hz,
            line: "{t_us},{counts},{hx711}".to_owned(),
            command: "M{motor_pwm} B{brake_pwm}\n".to_owned(),
            mark: Some("K{code} {number}\n".to_owned()),
            pwm_full: usual_pwm(),
            counts_per_turn: can.counts_per_turn.map_or(0, |counts| counts as u16),
            motor_max_v: can.motor_max_v,
            brake_max_v: can.brake_max_v,
        }
    }

    /// Its templates.
    ///
    /// # Errors
    /// Which of them is wrong, and why.
    pub fn templates(&self) -> Result<Templates, DeviceError> {
        let seen = [Field::Millis, Field::Micros, Field::Counts, Field::Hx711, Field::Any];
        let drive = [Field::MotorPwm, Field::BrakePwm];
        let what = [Field::Code, Field::Number];
        let mark =
            self.mark.as_deref().map(|mark| named("mark", Template::parse(mark, &what, &what)));
        Ok(Templates {
            line: named("line", Template::parse(&self.line, &seen, &[Field::Counts]))?,
            command: named("command", Template::parse(&self.command, &drive, &drive))?,
            mark: mark.transpose()?,
        })
    }
}

pub(crate) fn named(
    key: &str,
    parsed: Result<Template, TemplateError>,
) -> Result<Template, DeviceError> {
    parsed.map_err(|e| unable(format!("{key}: {e}"), "correct it in rig.toml (docs/rig.md)"))
}

/// Steps of `analogWrite` on an Arduino.
fn usual_pwm() -> u16 {
    255
}
