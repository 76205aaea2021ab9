//! The instrument: read a sample, write two voltages.

use crate::{DeviceError, Judged};
use zwidth_study::{AnswerScale, Channel, Environment, Extra, Moment, Source, Voltages};

/// What a device is and can do.
#[derive(Debug, Clone, PartialEq)]
pub struct Capabilities {
    /// What it is called, with its version: kept with every trial.
    pub name: String,
    /// Rate at which it can be read, Hz.
    pub rate_hz: f64,
    /// Rate at which its force sensor gives new values, Hz.
    pub force_rate_hz: f64,
    /// Counts of the angle sensor in one turn of the shaft; none if the device gives angles.
    pub counts_per_turn: Option<u32>,
    /// Turns of the shaft in one turn of the lever.
    pub shaft_per_lever: f64,
    /// Highest motor voltage, V.
    pub motor_max_v: f64,
    /// Highest brake voltage, V.
    pub brake_max_v: f64,
    /// Without a write for this long the device itself goes to 0 V, s; none if it has no watchdog.
    pub watchdog_s: Option<f64>,
    /// Whether it can show a trial's moments on an output of its own ([`Device::mark`]).
    pub shows_moments: bool,
    /// What its data is: measured or simulated.
    pub source: Source,
    /// Further values of every reading, recorded if the study asks for them.
    pub channels: Vec<Channel>,
}

/// The angle, as the sensor has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Angle {
    /// Counts within one turn of the shaft.
    Counts(u16),
    /// The lever's angle, rad.
    Lever(f64),
}

/// The values read at one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// When the device took it, by its own clock, s.
    pub t_device_s: Option<f64>,
    /// The angle.
    pub angle: Angle,
    /// Age of the angle, s: 0 for one that was taken on request. A loop that outruns its sensor
    /// sees it grow, and safety sees a sensor that has stopped.
    pub angle_age_s: f64,
    /// User force at the lever's end, N; above 0 pushes into the object (+θ).
    pub force_n: f64,
    /// Age of the force value, s.
    pub force_age_s: Option<f64>,
    /// The values of its own channels, in the order of [`Capabilities::channels`].
    pub extra: Extra,
}

impl Reading {
    /// The angle sensor's own count, if it has one.
    pub fn raw(&self) -> Option<u16> {
        match self.angle {
            Angle::Counts(raw) => Some(raw),
            Angle::Lever(_) => None,
        }
    }
}

/// What a device may know of the trial that begins: never the mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cue<'a> {
    /// Number of the trial within the session, from 1.
    pub trial: u32,
    /// The environment, which the participant knows too.
    pub environment: &'a Environment,
    /// Longest the trial may take, s.
    pub limit_s: f64,
}

/// A device. Times are the host's clock, s.
pub trait Device: Send {
    /// What it is and can do.
    fn capabilities(&self) -> &Capabilities;

    /// The reading with the lever held against its lower stop, both actuators off. Which turn of
    /// the shaft this is, no sensor knows at power-up: nothing else may come before it.
    ///
    /// # Errors
    /// A device that is lost, or a lever that is not at the stop.
    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError>;

    /// What it sees at `now_s`.
    ///
    /// # Errors
    /// A device that is lost.
    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError>;

    /// Commands two voltages from `now_s` on, until the next write.
    ///
    /// # Errors
    /// A device that is lost.
    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError>;

    /// A trial begins at `now_s`. Only a device with a participant of its own, or a recording to
    /// play, cares.
    fn begin(&mut self, _now_s: f64, _cue: &Cue<'_>) {}

    /// Shows a moment of a trial on an output of its own, as soon as it can. One that cannot does
    /// nothing; a marker that does not arrive harms nothing.
    fn mark(&mut self, _moment: Moment) {}

    /// The answer of a device's own participant to the question of the trial that has ended, on
    /// that question's scale.
    fn answer(&mut self, _on: &AnswerScale) -> Option<i16> {
        None
    }

    /// The answer of a device's own participant to a presentation of a task.
    fn judge(&mut self, _judged: &Judged) -> Option<i16> {
        None
    }
}
