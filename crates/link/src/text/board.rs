//! A sketch that prints lines and takes commands.

use super::{Field, Lines, Templates, Text, Values};
use crate::Drive;
use crate::board::{Behind, Speech, counts, force_counts};
use zwidth_device::{DeviceError, Reading};

pub(crate) struct Sketch {
    templates: Templates,
    lines: Lines,
    pwm_full: u16,
    period_s: f64,
    /// When it began, s: its clock counts from there.
    began_s: f64,
}

impl Sketch {
    pub(crate) fn new(text: &Text) -> Result<Self, DeviceError> {
        Ok(Self {
            templates: text.templates()?,
            lines: Lines::from_start(),
            pwm_full: text.pwm_full,
            period_s: 1.0 / text.rate_hz,
            began_s: 0.0,
        })
    }

    /// A line that is no command of its does nothing.
    fn hear(&mut self, byte: u8, behind: &mut Behind, now_s: f64) -> Result<(), DeviceError> {
        let Some(line) = self.lines.push(byte) else { return Ok(()) };
        if let Some(values) = self.templates.command.read(line) {
            let steps = [Field::MotorPwm, Field::BrakePwm]
                .map(|field| values.get(field).unwrap_or_default() as i32);
            return behind.write(now_s, Drive::of_steps(steps, self.pwm_full, self.pwm_full));
        }
        let mark = self.templates.mark.as_ref().and_then(|mark| mark.read(line));
        let Some(values) = mark else { return Ok(()) };
        let [code, number] =
            [Field::Code, Field::Number].map(|field| values.get(field).unwrap_or_default());
        behind.mark(now_s, code as u8, number as u16)
    }
}

impl Speech for Sketch {
    fn reset(&mut self, now_s: f64) {
        (self.lines, self.began_s) = (Lines::from_start(), now_s);
    }

    fn period_s(&self) -> Option<f64> {
        Some(self.period_s)
    }

    fn prints_force(&self) -> bool {
        self.templates.line.has(Field::Hx711)
    }

    fn take(
        &mut self,
        behind: &mut Behind,
        now_s: f64,
        bytes: &[u8],
        _: &mut Vec<u8>,
    ) -> Result<(), DeviceError> {
        bytes.iter().try_for_each(|byte| self.hear(*byte, behind, now_s))
    }

    fn print(&mut self, now_s: f64, reading: &Reading, out: &mut Vec<u8>) {
        let since_s = reading.t_device_s.unwrap_or(now_s) - self.began_s;
        // A clock of 32 bits, round after the last.
        let [millis, micros] =
            [1e3, 1e6].map(|per_s| i64::from(((since_s * per_s).round() as i64) as u32));
        let values = Values::default()
            .with(Field::Millis, millis)
            .with(Field::Micros, micros)
            .with(Field::Counts, counts(reading))
            .with(Field::Hx711, force_counts(reading).0);
        self.templates.line.write(&values, out);
    }
}
