//! The host's end of Firmata: it asks what the pins can do, sets them up, and receives the angle.
//!
//! The angle is what an analog channel reads, or the register RAW ANGLE of an AS5600 (ams data
//! sheet v1-06, Fig. 21: address 0x36, registers 0x0C and 0x0D, 12 bits). Both come at each
//! sampling interval, which is whole milliseconds (`protocol.md`, "Sampling Interval").

use super::{
    AngleAt, End, Firmata, I2cReply, I2cRequest, Message, Mode, Parser, Pin, id, string, two,
};
use crate::Drive;
use crate::check::within;
use crate::rate::stream_rate_hz;
use crate::talk::{Facts, Heard, Plan, Talk};
use zwidth_device::DeviceError;
use zwidth_study::Voltages;

/// The AS5600: its address, its register of the angle, and counts in a turn.
pub(crate) const AS5600: u8 = 0x36;
pub(crate) const RAW_ANGLE: u8 = 0x0C;
const AS5600_COUNTS: u16 = 4096;
/// Bytes of its angle as a message: seven bytes as pairs of seven bits but for the frame and the
/// id.
const I2C_BYTES: usize = 11;
/// Bytes of an analog value.
const ANALOG_BYTES: usize = 3;
/// Pins up to here are written to by short messages.
const LAST_SHORT: u8 = 15;
/// Analog channels are below.
const ANALOG_CHANNELS: u8 = 16;
/// Of an analog value in a message.
const MOST_BITS: u8 = 14;
/// How a board's firmware begins its name where what it sends is simulated.
pub(crate) const SIMULATED: &str = "zwidth simulated";

/// A Firmata board: its name, and what its pins can do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pins {
    /// Its firmware, with its version.
    pub name: String,
    /// Analog channels with their bits.
    pub analog: Vec<(u8, u8)>,
    /// Pins that give pulses.
    pub pulses: Vec<u8>,
    /// Whether it has an I²C bus.
    pub i2c: bool,
}

/// The host's end.
pub(crate) struct Host {
    parser: Parser,
    pins: Firmata,
    interval_ms: u16,
    version: Option<[u8; 2]>,
    name: Twice<String>,
    capabilities: Twice<Vec<Pin>>,
    /// The analog channel of each pin.
    channels: Twice<Vec<u8>>,
    /// Questions for the version that were not answered yet.
    version_queries: u32,
    /// The motor was commanded towards +θ last.
    forwards: bool,
}

/// A board's answer to a question. Firmata has no checksum, so each question is asked twice, and an
/// answer is sure once it came twice in a row.
#[derive(Debug, Default)]
struct Twice<T> {
    answer: Option<T>,
    sure: bool,
}

impl<T: PartialEq> Twice<T> {
    fn hear(&mut self, answer: T) {
        self.sure |= self.answer.as_ref() == Some(&answer);
        self.answer = Some(answer);
    }

    fn sure(&self) -> Option<&T> {
        self.answer.as_ref().filter(|_| self.sure)
    }
}

impl Host {
    /// For a board as the settings describe it.
    ///
    /// # Errors
    /// A rate that the line does not carry, or the firmware does not know.
    pub(crate) fn new(pins: &Firmata, baud: u32) -> Result<Self, DeviceError> {
        let reading = if pins.angle == AngleAt::I2c { I2C_BYTES } else { ANALOG_BYTES };
        let most_hz = stream_rate_hz(baud, reading, command_bytes(pins));
        within("readings", pins.rate_hz, most_hz, baud, "baud")?;
        // Less a trifle: a quotient that rounding put above a whole number is that number.
        let interval_ms = (1e3 / pins.rate_hz - 1e-9).ceil();
        if pins.rate_hz > 1e3 || interval_ms > f64::from(u16::MAX >> 2) {
            let allowed =
                "between 0.07 and 1000, which is how short and long a sampling interval can be";
            let name = "firmata.rate_hz";
            let value = pins.rate_hz;
            return Err(DeviceError::Parameter { name, value, allowed });
        }
        Ok(Self {
            parser: Parser::new(End::Board),
            pins: pins.clone(),
            interval_ms: interval_ms as u16,
            version: None,
            name: Twice::default(),
            capabilities: Twice::default(),
            channels: Twice::default(),
            version_queries: 0,
            forwards: true,
        })
    }

    /// The board's name and pins, once its answers are sure.
    pub(crate) fn described(&self) -> Option<Pins> {
        let name = self.name.sure()?;
        let channels = self.channels.sure()?;
        self.capabilities.sure()?;
        let analog = (0..).zip(channels).filter(|(_, channel)| **channel < ANALOG_CHANNELS);
        Some(Pins {
            name: name.clone(),
            analog: analog
                .filter_map(|(pin, channel)| Some((*channel, self.able(pin, Mode::Analog)?)))
                .collect(),
            pulses: self.able_pins(Mode::Pwm).collect(),
            i2c: self.able_pins(Mode::I2c).next().is_some(),
        })
    }

    fn able(&self, pin: u8, mode: Mode) -> Option<u8> {
        self.capabilities.sure()?.get(usize::from(pin))?.bits(mode)
    }

    /// The pins that have a mode.
    fn able_pins(&self, mode: Mode) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(move |pin| self.able(*pin, mode).is_some())
    }

    /// The bits of a pin that must have a mode; if it has not, the error names those that have.
    fn need(&self, pin: u8, mode: Mode) -> Result<u8, DeviceError> {
        self.able(pin, mode).ok_or_else(|| {
            let able: Vec<String> = self.able_pins(mode).map(|pin| pin.to_string()).collect();
            self.unable(
                format!("its pin {pin} cannot be {mode:?}"),
                format!("choose one of those that can ({}) in rig.toml", able.join(", ")),
            )
        })
    }

    fn pin_of(&self, channel: u8) -> Option<u8> {
        let pin = self.channels.sure()?.iter().position(|mapped| *mapped == channel)?;
        u8::try_from(pin).ok()
    }

    fn counts_per_turn(&self) -> Result<u16, DeviceError> {
        match self.pins.angle {
            AngleAt::I2c if self.able_pins(Mode::I2c).next().is_some() => Ok(AS5600_COUNTS),
            AngleAt::I2c => {
                let remedy = "connect the sensor's analog output and name its channel in rig.toml";
                Err(self.unable("it has no I2C bus".to_owned(), remedy.to_owned()))
            }
            AngleAt::Analog(channel) => {
                let pin = self.pin_of(channel).ok_or_else(|| {
                    let channels = self.channels.sure().into_iter().flatten();
                    let analog = channels.filter(|channel| **channel < ANALOG_CHANNELS);
                    let names: Vec<String> = analog.map(|channel| format!("A{channel}")).collect();
                    let remedy = format!("choose one of {} in rig.toml", names.join(", "));
                    self.unable(format!("it has no analog channel A{channel}"), remedy)
                })?;
                // A board may claim any number of bits; a shift by more than 14 is no count.
                Ok(1 << self.need(pin, Mode::Analog)?.clamp(1, MOST_BITS))
            }
        }
    }

    /// The facts of a board with this firmware, if it can do what the settings ask of it.
    fn checked_facts(&self, name: &str) -> Result<Facts, DeviceError> {
        if self.version.is_some_and(|[major, _]| major != 2) {
            let what = "it speaks another version of Firmata than 2".to_owned();
            return Err(self.unable(what, "put StandardFirmata 2.5 on it".to_owned()));
        }
        self.need(self.pins.motor_pwm, Mode::Pwm)?;
        self.need(self.pins.brake_pwm, Mode::Pwm)?;
        self.need(self.pins.motor_direction, Mode::Output)?;
        Ok(Facts {
            name: format!("Firmata board with {name}"),
            counts_per_turn: self.counts_per_turn()?,
            simulated: name.starts_with(SIMULATED),
        })
    }

    fn unable(&self, what: String, remedy: String) -> DeviceError {
        let device = self.name.sure().cloned().unwrap_or_else(|| "Firmata board".to_owned());
        DeviceError::Unable { device, what, remedy }
    }

    /// Full scale of a pin's pulses.
    fn full(&self, pin: u8) -> u16 {
        (1 << self.able(pin, Mode::Pwm).unwrap_or(8).clamp(1, MOST_BITS)) - 1
    }
}

/// Bytes of a command for both voltages at its longest, with a change of direction.
fn command_bytes(pins: &Firmata) -> usize {
    let [motor, brake] =
        [pins.motor_pwm, pins.brake_pwm].map(|pin| if pin <= LAST_SHORT { 3 } else { 6 });
    2 * motor + 3 + brake
}

pub(super) fn sysex(id: u8, data: &[u8], out: &mut Vec<u8>) {
    Message::Sysex { id, data }.write(out);
}

/// Writes a value to a pin of pulses.
fn pulses(pin: u8, value: u16, out: &mut Vec<u8>) {
    if pin <= LAST_SHORT {
        return Message::Analog { channel: pin, value }.write(out);
    }
    let [low, high] = two(value);
    sysex(id::EXTENDED_ANALOG, &[pin, low, high], out);
}

impl Talk for Host {
    fn plan(&self) -> Plan {
        let full = Voltages { motor_v: self.pins.motor_max_v, brake_v: self.pins.brake_max_v };
        let rate_hz = 1e3 / f64::from(self.interval_ms);
        // StandardFirmata does nothing with the text that our markers are.
        Plan { rate_hz, full, tick_s: 0.0, shows_moments: false }
    }

    fn begin_anew(&mut self) {
        self.parser = Parser::new(End::Board);
        (self.version, self.version_queries, self.forwards) = (None, 0, true);
        (self.name, self.capabilities, self.channels) =
            (Twice::default(), Twice::default(), Twice::default());
    }

    fn hello(&mut self, out: &mut Vec<u8>) {
        self.version_queries += 1;
        Message::VersionQuery.write(out);
        let questions = [id::FIRMWARE, id::CAPABILITY_QUERY, id::ANALOG_MAPPING_QUERY];
        // Twice each: see `Twice`.
        for question in [questions, questions].concat() {
            sysex(question, &[], out);
        }
    }

    fn facts(&self) -> Option<Result<Facts, DeviceError>> {
        let name = self.name.sure()?;
        let has_answered = self.version.is_some() && self.channels.sure().is_some();
        let is_sure = has_answered && self.capabilities.sure().is_some();
        is_sure.then(|| self.checked_facts(name))
    }

    fn begin(&mut self, out: &mut Vec<u8>) {
        let Firmata { motor_pwm, brake_pwm, motor_direction, .. } = self.pins;
        // A version from here on is one that a board says when it has begun.
        self.version_queries = 0;
        let modes =
            [(motor_pwm, Mode::Pwm), (brake_pwm, Mode::Pwm), (motor_direction, Mode::Output)];
        for (pin, mode) in modes {
            Message::PinMode { pin, mode: mode as u8 }.write(out);
        }
        self.write(Drive::default(), out);
        sysex(id::SAMPLING_INTERVAL, &two(self.interval_ms), out);
        match self.pins.angle {
            AngleAt::Analog(channel) => {
                let pin = self.pin_of(channel).unwrap_or_default();
                Message::PinMode { pin, mode: Mode::Analog as u8 }.write(out);
                Message::ReportAnalog { channel, on: true }.write(out);
            }
            AngleAt::I2c => {
                let address = AS5600;
                let register = Some(RAW_ANGLE);
                let read = I2cRequest::Read { address, register, length: 2, again: true };
                sysex(id::I2C_CONFIG, &[0, 0], out);
                // Each homing comes here again, and would add one more read to those before.
                sysex(id::I2C_REQUEST, &I2cRequest::Stop { address }.data(), out);
                sysex(id::I2C_REQUEST, &read.data(), out);
            }
        }
    }

    fn push(&mut self, byte: u8) -> Option<Heard> {
        let counts = match self.parser.push(byte)? {
            Message::Analog { channel, value } if self.pins.angle == AngleAt::Analog(channel) => {
                value
            }
            Message::Version { major, minor } => {
                self.version = Some([major, minor]);
                // A version more than was asked for: the board has begun anew.
                let is_unasked = self.version_queries == 0;
                self.version_queries = self.version_queries.saturating_sub(1);
                return is_unasked.then_some(Heard::Reset);
            }
            Message::Sysex { id: id::FIRMWARE, data } => {
                let ([major, minor], name) = data.split_first_chunk::<2>()?;
                self.name.hear(format!("{} {major}.{minor}", super::unstring(name)));
                return None;
            }
            Message::Sysex { id: id::CAPABILITIES, data } => {
                self.capabilities.hear(Pin::read_all(data));
                return None;
            }
            Message::Sysex { id: id::ANALOG_MAPPING, data } => {
                self.channels.hear(data.to_vec());
                return None;
            }
            Message::Sysex { id: id::I2C_REPLY, data } => {
                let reply = I2cReply::read(data)?;
                let [high, low] = *reply.bytes.as_array::<2>()?;
                let is_ours = (reply.address, reply.register) == (AS5600, RAW_ANGLE);
                if !is_ours || self.pins.angle != AngleAt::I2c {
                    return None;
                }
                u16::from_be_bytes([high, low]) & (AS5600_COUNTS - 1)
            }
            _ => return None,
        };
        Some(Heard::Reading { ticks: None, counts, force: None })
    }

    fn write(&mut self, drive: Drive, out: &mut Vec<u8>) {
        let Firmata { motor_pwm, motor_direction, motor_reversed, brake_pwm, .. } = self.pins;
        let [motor, brake] = drive.steps(self.full(motor_pwm), self.full(brake_pwm));
        let forwards = motor >= 0;
        // At 0 while the direction changes: what was meant for the one way never goes the other.
        if forwards != self.forwards {
            pulses(motor_pwm, 0, out);
            self.forwards = forwards;
        }
        Message::DigitalPin { pin: motor_direction, on: forwards != motor_reversed }.write(out);
        pulses(motor_pwm, motor.unsigned_abs() as u16, out);
        pulses(brake_pwm, brake.unsigned_abs() as u16, out);
    }

    fn mark(&mut self, code: u8, number: u16, out: &mut Vec<u8>) {
        sysex(id::STRING, &string(&format!("mark {code} {number}")), out);
    }

    fn damaged(&self) -> u64 {
        self.parser.damaged()
    }
}
