//! What a host must be told about a rig, because no board can know it.

use crate::board::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use crate::check::{positive, require, unable, within};
use crate::framed::frame::Frames;
use crate::framed::wording::Wording;
use crate::process::{HostLines, STEP_N};
use crate::rate::{LOOKS_PER_READING, line_rate_hz};
use crate::streams::Streams;
use crate::talk::Talk;
use crate::text::{Field, Template, named};
use crate::{AngleAt, Firmata, Process, Text};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
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
    /// Lines of JSON, of a program.
    Process,
}

impl Link {
    /// Whether the host asks for each reading, of a board that has a watchdog.
    pub fn is_asked(self) -> bool {
        matches!(self, Self::Framed | Self::Process)
    }
}

/// The links as boards in software and soaks try them, by the words of their chores.
pub const LINKS: [(&str, Link, AngleAt); 5] = [
    ("framed", Link::Framed, AngleAt::I2c),
    ("firmata", Link::Firmata, AngleAt::Analog(0)),
    ("firmata-i2c", Link::Firmata, AngleAt::I2c),
    ("text", Link::Text, AngleAt::I2c),
    ("process", Link::Process, AngleAt::I2c),
];

/// The content of `rig.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The serial port, as the system calls it.
    pub port: Option<PathBuf>,
    /// The protocol.
    #[serde(default)]
    pub link: Link,
    /// Bits per second on the wire, unless it is the link's usual number.
    pub baud: Option<u32>,
    /// Force of one count of the load cell, N; below 0 where a push into the object counts down. A
    /// program gives newtons itself.
    #[serde(default)]
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
    /// A calibration older than this many days is warned of.
    #[serde(default = "usual_calibration_days")]
    pub calibration_days: f64,
    /// What of the actuators gets warm.
    #[serde(default)]
    pub heat: Windings,
    /// For a board that speaks Firmata.
    pub firmata: Option<Firmata>,
    /// Of a board that prints lines.
    pub text: Option<Text>,
    /// A program that is the device.
    pub process: Option<Process>,
    /// Of a load cell at a port of its own.
    pub hx711: Option<Hx711>,
}

/// The windings of motor and brake: how warm sweeps make them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Windings {
    /// Resistance of the motor's winding, Ω.
    pub motor_ohm: f64,
    /// Mass of its copper, kg.
    pub motor_kg: f64,
    /// Resistance of the brake's winding, Ω.
    pub brake_ohm: f64,
    /// Mass of its copper, kg.
    pub brake_kg: f64,
    /// Time constant with which either cools, s.
    pub cooling_s: f64,
}

impl Default for Windings {
    /// The prototype's: 30.4 Ω as in docs/twin.md; copper is assumed to be 15 % of the motor's 88 g
    /// and 30 % of the brake's 27 g (thesis App. A), the brake's resistance and the time constant
    /// are assumed.
    fn default() -> Self {
        Self {
            motor_ohm: 30.4,
            motor_kg: 0.0132,
            brake_ohm: 24.0,
            brake_kg: 0.0081,
            cooling_s: 60.0,
        }
    }
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
    /// The form of a line.
    #[serde(default = "usual_hx711_line")]
    pub line: String,
    /// Values per second: 10 or 80, by its pin RATE (HX711 data sheet, "Output Data Rate").
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

fn usual_calibration_days() -> f64 {
    90.0
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
    /// The settings for a board in software with this device behind it: `angle` is where Firmata
    /// has it, `rate_hz` the readings per second of a link that streams, and `cell` the port of the
    /// load cell if it has its own.
    pub fn of_board(
        link: Link,
        angle: AngleAt,
        rate_hz: f64,
        can: &Capabilities,
        cell: &Path,
    ) -> Self {
        Self {
            port: None,
            link,
            baud: None,
            newtons_per_count: if link == Link::Process { 0.0 } else { NEWTONS_PER_COUNT },
            zero_counts: if link == Link::Process { 0.0 } else { ZERO_COUNTS },
            shaft_per_lever: can.shaft_per_lever,
            turning: Turning::Up,
            // Only lines of text need it: any other board says so itself.
            simulated: link == Link::Text,
            calibration_days: usual_calibration_days(),
            heat: Windings::default(),
            firmata: (link == Link::Firmata).then(|| Firmata::usual(rate_hz, angle, can)),
            text: (link == Link::Text).then(|| Text::usual(rate_hz, can)),
            // In software there is nothing to start.
            process: (link == Link::Process).then(|| Process {
                command: vec!["board in software".to_owned()],
                ..Process::default()
            }),
            hx711: (link == Link::Firmata).then(|| Hx711 {
                port: cell.to_owned(),
                baud: usual_hx711_baud(),
                line: usual_hx711_line(),
                rate_hz: can.force_rate_hz,
            }),
        }
    }

    /// Bits per second on the wire: for frames, enough for 1 kHz, and divided by an Arduino's clock
    /// without an error; for Firmata, the default of its sketches.
    pub fn baud(&self) -> u32 {
        self.baud.unwrap_or(match self.link {
            Link::Framed => 500_000,
            Link::Firmata => 57_600,
            Link::Text => 115_200,
            // A pipe is never what limits a program.
            Link::Process => 100_000_000,
        })
    }

    /// How the messages of a link that is asked are written.
    pub(crate) fn asks(&self) -> Box<dyn Wording> {
        match self.link {
            Link::Process => Box::new(HostLines::new()),
            _ => Box::new(Frames::default()),
        }
    }

    /// The program that is the device, where one is.
    ///
    /// # Errors
    /// No such table.
    pub fn program(&self) -> Result<Option<&Process>, DeviceError> {
        if self.link != Link::Process {
            return Ok(None);
        }
        self.process.as_ref().map(Some).ok_or_else(|| {
            unable(
                "link is \"process\", and there is no table [process]".to_owned(),
                "write it, with command = [\"python3\", \"lever.py\"]",
            )
        })
    }

    /// Force of one count as the host has it, N, and the count without a force.
    pub(crate) fn scale(&self) -> (f64, f64) {
        match self.link {
            Link::Process => (STEP_N, 0.0),
            _ => (self.newtons_per_count, self.zero_counts),
        }
    }

    /// The table of a link that streams; none of one that is asked.
    ///
    /// # Errors
    /// No such table.
    pub(crate) fn streams(&self) -> Result<Option<&dyn Streams>, DeviceError> {
        let (name, table) = match self.link {
            Link::Framed | Link::Process => return Ok(None),
            Link::Firmata => ("firmata", table_of(&self.firmata)),
            Link::Text => ("text", table_of(&self.text)),
        };
        table.map(Some).ok_or_else(|| {
            let remedy = format!("write it, or take link = \"{name}\" out");
            unable(format!("link is \"{name}\", and there is no table [{name}]"), &remedy)
        })
    }

    /// The host's end of a link that streams.
    ///
    /// # Errors
    /// No table of the link, or one that makes no sense.
    pub(crate) fn host(&self) -> Result<Option<Box<dyn Talk>>, DeviceError> {
        self.streams()?.map(|streams| streams.host(self.baud())).transpose()
    }

    /// Checks that they make sense.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self) -> Result<(), DeviceError> {
        if let Some(program) = self.program()? {
            return self.check_program(program);
        }
        let force_n = self.newtons_per_count;
        let is_force = force_n.is_finite() && force_n != 0.0;
        require(is_force, "newtons_per_count", force_n, "finite and not 0")?;
        require(self.zero_counts.is_finite(), "zero_counts", self.zero_counts, "finite")?;
        positive("shaft_per_lever", self.shaft_per_lever)?;
        require(self.baud != Some(0), "baud", 0.0, "above 0")?;
        for (name, value) in [
            ("calibration_days", self.calibration_days),
            ("heat.motor_ohm", self.heat.motor_ohm),
            ("heat.motor_kg", self.heat.motor_kg),
            ("heat.brake_ohm", self.heat.brake_ohm),
            ("heat.brake_kg", self.heat.brake_kg),
            ("heat.cooling_s", self.heat.cooling_s),
        ] {
            positive(name, value)?;
        }
        // A load cell at a port of its own brings the force, whatever the board prints.
        let streams = self.streams()?.filter(|_| self.hx711.is_none());
        if !streams.map_or(Ok(true), Streams::brings_force)? {
            return Err(unable(
                "nothing says where the force comes from".to_owned(),
                "write the table [hx711] with its port, or print {hx711} in the lines",
            ));
        }
        let tables = [table_of(&self.firmata), table_of(&self.text)];
        tables.into_iter().flatten().try_for_each(Streams::check)?;
        let Some(cell) = &self.hx711 else { return Ok(()) };
        positive("hx711.rate_hz", cell.rate_hz)?;
        positive("hx711.baud", cell.baud.into())?;
        let most_hz = line_rate_hz(cell.baud, cell.template()?.longest());
        within("the load cell's lines", cell.rate_hz, most_hz, cell.baud, "hx711.baud")
    }

    /// Keys of a board would do nothing for a program.
    fn check_program(&self, program: &Process) -> Result<(), DeviceError> {
        program.check()?;
        let given = [
            ("newtons_per_count", self.newtons_per_count != 0.0),
            ("zero_counts", self.zero_counts != 0.0),
            ("port", self.port.is_some()),
            ("baud", self.baud.is_some()),
            ("[hx711]", self.hx711.is_some()),
        ];
        if let Some((key, _)) = given.into_iter().find(|(_, given)| *given) {
            return Err(unable(
                format!("{key} is of a board, and link is \"process\""),
                "take it out: a program has no port, and gives newtons itself",
            ));
        }
        positive("shaft_per_lever", self.shaft_per_lever)
    }

    /// Whether a loop of this rate takes every reading of a link that streams.
    ///
    /// # Errors
    /// A loop that is too slow for it, with the rate that it needs.
    pub fn check_loop(&self, rate_hz: f64) -> Result<(), DeviceError> {
        let Some(stream_hz) = self.streams()?.map(Streams::rate_hz) else { return Ok(()) };
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

    /// The capabilities of a board that has not said who it is yet.
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

fn table_of<T: Streams>(table: &Option<T>) -> Option<&dyn Streams> {
    table.as_ref().map(|table| table as &dyn Streams)
}
