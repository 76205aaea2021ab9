//! What a host must be told of a rig: no board can know it.

use crate::rate::{LOOKS_PER_READING, line_rate_hz};
use crate::text::{Field, Template, TemplateError};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zwidth_device::{Capabilities, DeviceError};
use zwidth_study::Source;

/// Which way the angle sensor counts while the lever is pushed into the object (+θ).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Turning {
    /// Up.
    #[default]
    Up,
    /// Down.
    Down,
}

/// What host and board speak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Link {
    /// Frames of our own.
    #[default]
    Framed,
    /// Firmata 2.5.
    Firmata,
    /// Lines of text.
    Text,
}

/// What stands in `rig.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The serial port, as the system calls it.
    pub port: Option<PathBuf>,
    /// What is spoken there.
    #[serde(default)]
    pub link: Link,
    /// Bits a second on the wire, unless it is what the link is usually at.
    pub baud: Option<u32>,
    /// Force of one count of the load cell, N; below 0 where a push into the object counts down.
    pub newtons_per_count: f64,
    /// What the load cell counts without a force.
    #[serde(default)]
    pub zero_counts: f64,
    /// Turns of the angle sensor's shaft in one turn of the lever.
    #[serde(default = "prototype_turns")]
    pub shaft_per_lever: f64,
    /// Which way the angle sensor counts.
    #[serde(default)]
    pub turning: Turning,
    /// What comes is simulated, though the board does not say so.
    #[serde(default)]
    pub simulated: bool,
    /// Of a board that speaks Firmata.
    pub firmata: Option<Firmata>,
    /// Of a board that prints lines.
    pub text: Option<Text>,
    /// Of a load cell at a port of its own.
    pub hx711: Option<Hx711>,
}

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
    /// Readings a second, of which the board knows those that are whole milliseconds apart.
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

/// A board that prints lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Text {
    /// Lines a second.
    pub rate_hz: f64,
    /// What stands in a line, as `"{t_ms},{counts},{hx711}"`.
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
    /// Its templates.
    ///
    /// # Errors
    /// What is wrong with which of them.
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

fn named(key: &str, parsed: Result<Template, TemplateError>) -> Result<Template, DeviceError> {
    parsed.map_err(|e| unable(format!("{key}: {e}"), "correct it in rig.toml (docs/rig.md)"))
}

/// A load cell at a port of its own: an HX711 whose counts a sketch prints, one in a line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hx711 {
    /// The serial port, as the system calls it.
    pub port: PathBuf,
    /// Bits a second on the wire.
    #[serde(default = "usual_hx711_baud")]
    pub baud: u32,
    /// What stands in a line.
    #[serde(default = "usual_hx711_line")]
    pub line: String,
    /// Values a second: 10 or 80, by its pin RATE (HX711 data sheet, "Output Data Rate").
    #[serde(default = "usual_hx711_rate")]
    pub rate_hz: f64,
}

impl Hx711 {
    /// The template of its lines.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn template(&self) -> Result<Template, DeviceError> {
        let may = [Field::Hx711, Field::Millis, Field::Micros, Field::Any];
        named("hx711.line", Template::parse(&self.line, &may, &[Field::Hx711]))
    }
}

fn prototype_turns() -> f64 {
    zwidth_device::SHAFT_PER_LEVER
}

/// What pyFirmata2's authors state for analog readings over USB.
fn usual_firmata_rate() -> f64 {
    100.0
}

/// Steps of `analogWrite` on an Arduino.
fn usual_pwm() -> u16 {
    255
}

fn usual_hx711_baud() -> u32 {
    115_200
}

fn usual_hx711_line() -> String {
    "{hx711}".to_owned()
}

fn usual_hx711_rate() -> f64 {
    80.0
}

impl Settings {
    /// Bits a second on the wire: for frames enough for 1 kHz, and what an Arduino's clock divides
    /// without an error; for Firmata what its sketches begin with.
    pub fn baud(&self) -> u32 {
        self.baud.unwrap_or(match self.link {
            Link::Framed => 500_000,
            Link::Firmata => 57_600,
            Link::Text => 115_200,
        })
    }

    /// Readings a second of a link that streams; none of one that is asked.
    pub fn stream_hz(&self) -> Option<f64> {
        match self.link {
            Link::Framed => None,
            Link::Firmata => self.firmata.as_ref().map(|firmata| firmata.rate_hz),
            Link::Text => self.text.as_ref().map(|text| text.rate_hz),
        }
    }

    /// Whether they make sense.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self) -> Result<(), DeviceError> {
        let bad = |name, value, allowed| Err(DeviceError::Parameter { name, value, allowed });
        if !(self.newtons_per_count.is_finite() && self.newtons_per_count != 0.0) {
            return bad("newtons_per_count", self.newtons_per_count, "finite and not 0");
        }
        if !self.zero_counts.is_finite() {
            return bad("zero_counts", self.zero_counts, "finite");
        }
        positive("shaft_per_lever", self.shaft_per_lever)?;
        if self.baud == Some(0) {
            return bad("baud", 0.0, "above 0");
        }
        self.check_table()?;
        if let Some(firmata) = &self.firmata {
            positive("firmata.rate_hz", firmata.rate_hz)?;
            not_below_0("firmata.motor_max_v", firmata.motor_max_v)?;
            not_below_0("firmata.brake_max_v", firmata.brake_max_v)?;
        }
        if let Some(text) = &self.text {
            positive("text.rate_hz", text.rate_hz)?;
            positive("text.pwm_full", text.pwm_full.into())?;
            not_below_0("text.motor_max_v", text.motor_max_v)?;
            not_below_0("text.brake_max_v", text.brake_max_v)?;
            if text.counts_per_turn < 2 {
                return bad("text.counts_per_turn", text.counts_per_turn.into(), "2 or more");
            }
            text.templates()?;
        }
        self.hx711.as_ref().map_or(Ok(()), check_hx711)
    }

    /// The link's own table, and where the force comes from.
    fn check_table(&self) -> Result<(), DeviceError> {
        let table = |name: &str| {
            let remedy = format!("write it, or take link = \"{name}\" out");
            unable(format!("link is \"{name}\", and there is no table [{name}]"), &remedy)
        };
        let force = match self.link {
            Link::Framed => true,
            Link::Firmata => {
                self.firmata.as_ref().ok_or_else(|| table("firmata"))?;
                false
            }
            Link::Text => {
                let text = self.text.as_ref().ok_or_else(|| table("text"))?;
                text.templates()?.line.has(Field::Hx711)
            }
        };
        if force || self.hx711.is_some() {
            return Ok(());
        }
        Err(unable(
            "nothing says where the force comes from".to_owned(),
            "write the table [hx711] with its port, or print {hx711} in the lines",
        ))
    }

    /// Whether a loop of this rate takes every reading of a link that streams.
    ///
    /// # Errors
    /// A loop that is too slow for it, with the rate that it needs.
    pub fn check_loop(&self, rate_hz: f64) -> Result<(), DeviceError> {
        let Some(stream_hz) = self.stream_hz() else { return Ok(()) };
        let needed_hz = LOOKS_PER_READING * stream_hz;
        if rate_hz >= needed_hz {
            return Ok(());
        }
        Err(unable(
            format!(
                "the loop reads {rate_hz} times per second, and the board sends {stream_hz} readings per second"
            ),
            &format!(
                "so that none is lost, raise rate_hz in study.toml to {needed_hz}, or lower the board's"
            ),
        ))
    }

    /// Of a board that has not said who it is yet.
    pub(crate) fn unknown(&self) -> Capabilities {
        Capabilities {
            name: "rig".to_owned(),
            rate_hz: 1.0,
            force_rate_hz: 1.0,
            counts_per_turn: None,
            shaft_per_lever: self.shaft_per_lever,
            motor_max_v: 0.0,
            brake_max_v: 0.0,
            watchdog_s: None,
            shows_moments: false,
            source: if self.simulated { Source::Twin } else { Source::Recorded },
            channels: Vec::new(),
        }
    }
}

fn check_hx711(cell: &Hx711) -> Result<(), DeviceError> {
    positive("hx711.rate_hz", cell.rate_hz)?;
    positive("hx711.baud", cell.baud.into())?;
    let most_hz = line_rate_hz(cell.baud, cell.template()?.longest());
    within("the load cell's lines", cell.rate_hz, most_hz, cell.baud, "hx711.baud")
}

/// Whether a rate is one that a line carries.
///
/// # Errors
/// Why not, and what it carries.
pub(crate) fn within(
    what: &str,
    rate_hz: f64,
    most_hz: f64,
    baud: u32,
    key: &str,
) -> Result<(), DeviceError> {
    if rate_hz <= most_hz {
        return Ok(());
    }
    let most = most_hz.floor();
    Err(unable(
        format!(
            "{what} come {rate_hz} times per second, and {baud} baud carry at most {most} of them"
        ),
        &format!("lower the rate, or raise {key} in rig.toml and on the board"),
    ))
}

fn positive(name: &'static str, value: f64) -> Result<(), DeviceError> {
    let allowed = "above 0 and finite";
    let fine = value.is_finite() && value > 0.0;
    if fine { Ok(()) } else { Err(DeviceError::Parameter { name, value, allowed }) }
}

fn not_below_0(name: &'static str, value: f64) -> Result<(), DeviceError> {
    let allowed = "0 or more, and finite";
    let fine = value.is_finite() && value >= 0.0;
    if fine { Ok(()) } else { Err(DeviceError::Parameter { name, value, allowed }) }
}

fn unable(what: String, remedy: &str) -> DeviceError {
    DeviceError::Unable { device: "rig.toml".to_owned(), what, remedy: remedy.to_owned() }
}
