//! The host's end of lines of text.

use super::{Field, Lines, Templates, Text, Values};
use crate::Drive;
use crate::check::within;
use crate::rate::stream_rate_hz;
use crate::talk::{Facts, Heard, Plan, Talk};
use zwidth_device::DeviceError;
use zwidth_study::Voltages;

/// The host's end.
pub(crate) struct Host {
    sketch: Text,
    templates: Templates,
    lines: Lines,
    /// A whole line was heard.
    heard: bool,
    /// Lines of another form.
    damaged: u64,
}

impl Host {
    /// For a board as the settings describe it.
    ///
    /// # Errors
    /// A template that is none; a rate that the line does not carry.
    pub(crate) fn new(sketch: &Text, baud: u32) -> Result<Self, DeviceError> {
        let templates = sketch.templates()?;
        let line = templates.line.longest();
        let command = templates.command.longest();
        let most_hz = stream_rate_hz(baud, line, command);
        within("lines", sketch.rate_hz, most_hz, baud, "baud")?;
        let lines = Lines::from_anywhere();
        Ok(Self { sketch: sketch.clone(), templates, lines, heard: false, damaged: 0 })
    }
}

/// The numbers of a line as a reading; none whose count is beyond a turn.
fn reading(values: &Values, counts_per_turn: u16) -> Option<Heard> {
    let counts = u16::try_from(values.get(Field::Counts)?).ok()?;
    let ticks = values.get(Field::Micros).or_else(|| values.get(Field::Millis));
    let ticks = ticks.and_then(|ticks| u32::try_from(ticks).ok());
    let force = values.get(Field::Hx711).and_then(|force| i32::try_from(force).ok());
    (counts < counts_per_turn).then_some(Heard::Reading { ticks, counts, force })
}

impl Talk for Host {
    fn plan(&self) -> Plan {
        let full = Voltages { motor_v: self.sketch.motor_max_v, brake_v: self.sketch.brake_max_v };
        let tick_s = if self.templates.line.has(Field::Micros) { 1e-6 } else { 1e-3 };
        let shows_moments = self.templates.mark.is_some();
        Plan { rate_hz: self.sketch.rate_hz, full, tick_s, shows_moments }
    }

    fn begin_anew(&mut self) {
        (self.lines, self.heard) = (Lines::from_anywhere(), false);
    }

    /// It prints unasked.
    fn hello(&mut self, _: &mut Vec<u8>) {}

    fn facts(&self) -> Option<Result<Facts, DeviceError>> {
        let counts_per_turn = self.sketch.counts_per_turn;
        let name = format!("sketch that prints {}", self.sketch.line.trim_ascii());
        self.heard.then_some(Ok(Facts { name, counts_per_turn, simulated: false }))
    }

    fn begin(&mut self, out: &mut Vec<u8>) {
        self.write(Drive::default(), out);
    }

    fn push(&mut self, byte: u8) -> Option<Heard> {
        let line = self.lines.push(byte)?;
        let values = self.templates.line.read(line);
        let heard = values.and_then(|values| reading(&values, self.sketch.counts_per_turn));
        self.heard |= heard.is_some();
        self.damaged += u64::from(heard.is_none());
        heard
    }

    fn write(&mut self, drive: Drive, out: &mut Vec<u8>) {
        let [motor, brake] = drive.steps(self.sketch.pwm_full, self.sketch.pwm_full);
        let values = Values::default().with(Field::MotorPwm, motor).with(Field::BrakePwm, brake);
        self.templates.command.write(&values, out);
    }

    fn mark(&mut self, code: u8, number: u16, out: &mut Vec<u8>) {
        let Some(mark) = &self.templates.mark else { return };
        mark.write(&Values::default().with(Field::Code, code).with(Field::Number, number), out);
    }

    fn damaged(&self) -> u64 {
        self.lines.damaged() + self.damaged
    }
}
