//! A board that speaks Firmata as StandardFirmata 2.5 does, with the pins of an Arduino Uno. Its
//! analog input may have a resolution other than the Uno's 10 bits.
//!
//! Source: github.com/firmata/arduino, StandardFirmata.ino: 19 ms between samples until it receives
//! another interval; a channel is reported at once when its reporting is switched on; up to eight
//! readings of the I²C bus at each interval.

use super::host::{AS5600, RAW_ANGLE, SIMULATED, sysex};
use super::{
    AngleAt, End, Firmata, I2cReply, I2cRequest, Message, Mode, Parser, Pin, id, joined, string,
    two, unstring,
};
use crate::Drive;
use crate::board::{Behind, Speech, counts};
use zwidth_device::{DeviceError, Reading};

const PINS: u8 = 20;
/// The first analog channel's pin.
const A0: u8 = 14;
const PWM_PINS: [u8; 6] = [3, 5, 6, 9, 10, 11];
const I2C_PINS: [u8; 2] = [18, 19];
const SENSOR_BITS: u8 = 12;
const PWM_BITS: u8 = 8;
const PWM_FULL: u16 = 255;
const INTERVAL_MS: u16 = 19;
const MOST_READS: usize = 8;
/// The AS5600's register STATUS, and its bit "magnet was detected" (data sheet, Fig. 23).
const STATUS: u8 = 0x0B;
const MAGNET: u8 = 0x20;
const PROTOCOL: (u8, u8) = (2, 5);

/// What its device is to do.
enum Act {
    /// These voltages.
    Write(Drive),
    /// A marker.
    Mark(u8, u16),
    /// A reading, for this.
    Read(What),
}

/// What a reading is for.
enum What {
    /// An analog channel.
    Channel(u8),
    /// Bytes of a device at the I²C bus.
    I2c(I2cRequest),
}

pub(crate) struct Uno {
    at: Firmata,
    /// Bits of the analog input.
    bits: u8,
    parser: Parser,
    /// Mode, and what was written to it.
    pins: [(u8, u16); PINS as usize],
    /// Channels that are reported, a bit each.
    reported: u16,
    reads: Vec<I2cRequest>,
    interval_ms: u16,
    /// It has just begun and says who it is.
    begins: bool,
}

impl Uno {
    pub(crate) fn new(at: Firmata, bits: u8) -> Self {
        Self {
            at,
            bits,
            parser: Parser::new(End::Host),
            pins: std::array::from_fn(|pin| {
                let mode = if pin < usize::from(A0) { Mode::Output } else { Mode::Analog };
                (mode as u8, 0)
            }),
            reported: 0,
            reads: Vec::new(),
            interval_ms: INTERVAL_MS,
            begins: true,
        }
    }

    /// Takes a byte; returns what its device is to do then.
    fn hear(&mut self, byte: u8, out: &mut Vec<u8>) -> Option<Act> {
        match self.parser.push(byte)? {
            Message::Analog { channel, value } => self.set(channel, value),
            Message::Digital { port, pins } => {
                let mut act = None;
                for bit in 0..8 {
                    // The voltages of the last one take in all pins that were set before it.
                    act = self.output(8 * port + bit, (pins >> bit & 1).into()).or(act);
                }
                act
            }
            Message::DigitalPin { pin, on } => self.output(pin, on.into()),
            Message::PinMode { pin, mode } => self.mode(pin, mode),
            Message::ReportAnalog { channel, on } => {
                let bit = 1 << channel;
                self.reported = if on { self.reported | bit } else { self.reported & !bit };
                on.then_some(Act::Read(What::Channel(channel)))
            }
            Message::VersionQuery => {
                version(out);
                None
            }
            Message::Reset => {
                let at = self.at.clone();
                *self = Self { begins: false, ..Self::new(at, self.bits) };
                Some(Act::Write(Drive::default()))
            }
            Message::Sysex { id, data } => {
                // A copy, because the parser that holds the bytes goes on.
                let data = data.to_vec();
                self.longer(id, &data, out)
            }
            Message::ReportDigital { .. } | Message::Version { .. } => None,
        }
    }

    /// A longer message.
    fn longer(&mut self, id: u8, data: &[u8], out: &mut Vec<u8>) -> Option<Act> {
        match (id, data) {
            (id::FIRMWARE, _) => firmware(out),
            (id::CAPABILITY_QUERY, _) => {
                sysex(id::CAPABILITIES, &Pin::write_all(&pins(self.bits)), out);
            }
            (id::ANALOG_MAPPING_QUERY, _) => {
                let channels: Vec<u8> = (0..PINS).map(|pin| channel(pin).unwrap_or(127)).collect();
                sysex(id::ANALOG_MAPPING, &channels, out);
            }
            (id::PIN_STATE_QUERY, [pin, ..]) => {
                let (mode, value) = *self.pins.get(usize::from(*pin))?;
                let [low, high] = two(value);
                sysex(id::PIN_STATE, &[*pin, mode, low, high], out);
            }
            (id::EXTENDED_ANALOG, [pin, low, rest @ ..]) => {
                let high = rest.first().copied().unwrap_or_default();
                return self.set(*pin, joined(*low, high));
            }
            (id::SAMPLING_INTERVAL, [low, high, ..]) => {
                // An interval of 0 would make a reading due at all times.
                self.interval_ms = joined(*low, *high).max(1);
            }
            (id::STRING, _) => return marker(&unstring(data)),
            (id::I2C_REQUEST, _) => match I2cRequest::read(data) {
                Some(read @ I2cRequest::Read { again: false, .. }) => {
                    return Some(Act::Read(What::I2c(read)));
                }
                Some(read @ I2cRequest::Read { .. }) if self.reads.len() < MOST_READS => {
                    self.reads.push(read);
                }
                Some(I2cRequest::Read { .. }) => {
                    sysex(id::STRING, &string("too many queries"), out);
                }
                Some(I2cRequest::Stop { address: stopped }) => self.reads.retain(
                    |read| !matches!(read, I2cRequest::Read { address, .. } if *address == stopped),
                ),
                Some(I2cRequest::Write { .. }) | None => {}
            },
            _ => {}
        }
        None
    }

    /// Reports a reading.
    fn tell(&self, what: &What, counts: u16, out: &mut Vec<u8>) {
        match what {
            What::Channel(channel) => {
                let is_ours = self.at.angle == AngleAt::Analog(*channel);
                // The sensor's 12 bits as this input sees them.
                let seen = u32::from(counts) << self.bits >> SENSOR_BITS;
                let value = if is_ours { seen as u16 } else { 0 };
                Message::Analog { channel: *channel, value }.write(out);
            }
            What::I2c(request) => {
                let I2cRequest::Read { address, register, length, .. } = request else { return };
                let register = register.unwrap_or_default();
                let bytes: Vec<u8> = if *address == AS5600 {
                    (0..*length).map(|i| as5600(register.wrapping_add(i), counts)).collect()
                } else {
                    // No other device is at the bus: nobody answers.
                    Vec::new()
                };
                if bytes.is_empty() {
                    sysex(id::STRING, &string("I2C: Too few bytes received"), out);
                }
                let reply = I2cReply { address: *address, register, bytes };
                sysex(id::I2C_REPLY, &reply.data(), out);
            }
        }
    }

    fn mode(&mut self, pin: u8, mode: u8) -> Option<Act> {
        *self.pins.get_mut(usize::from(pin))? = (mode, 0);
        self.written(pin)
    }

    /// A pin of pulses.
    fn set(&mut self, pin: u8, value: u16) -> Option<Act> {
        let (mode, held) = self.pins.get_mut(usize::from(pin))?;
        (*mode == Mode::Pwm as u8).then(|| *held = value.min(PWM_FULL))?;
        self.written(pin)
    }

    /// A digital pin.
    fn output(&mut self, pin: u8, value: u16) -> Option<Act> {
        let (mode, held) = self.pins.get_mut(usize::from(pin))?;
        (*mode == Mode::Output as u8).then(|| *held = value)?;
        self.written(pin)
    }

    /// The voltages that its pins stand for, after one of them was written to.
    fn written(&self, pin: u8) -> Option<Act> {
        let Firmata { motor_pwm, motor_direction, motor_reversed, brake_pwm, .. } = self.at;
        if ![motor_pwm, motor_direction, brake_pwm].contains(&pin) {
            return None;
        }
        let [motor, direction, brake] = [motor_pwm, motor_direction, brake_pwm]
            .map(|pin| self.pins.get(usize::from(pin)).map_or(0, |(_, held)| i32::from(*held)));
        let forwards = (direction != 0) != motor_reversed;
        let motor = if forwards { motor } else { -motor };
        Some(Act::Write(Drive::of_steps([motor, brake], PWM_FULL, PWM_FULL)))
    }
}

impl Speech for Uno {
    fn reset(&mut self, _: f64) {
        *self = Self::new(self.at.clone(), self.bits);
    }

    fn take(
        &mut self,
        behind: &mut Behind,
        now_s: f64,
        bytes: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), DeviceError> {
        if std::mem::take(&mut self.begins) {
            version(out);
            firmware(out);
        }
        for byte in bytes {
            match self.hear(*byte, out) {
                Some(Act::Write(drive)) => behind.write(now_s, drive)?,
                Some(Act::Mark(code, number)) => behind.mark(now_s, code, number)?,
                Some(Act::Read(what)) => self.tell(&what, counts(&behind.read(now_s)?), out),
                None => {}
            }
        }
        Ok(())
    }

    fn period_s(&self) -> Option<f64> {
        Some(f64::from(self.interval_ms.max(1)) * 1e-3)
    }

    fn prints_force(&self) -> bool {
        false
    }

    fn print(&mut self, _: f64, reading: &Reading, out: &mut Vec<u8>) {
        let counts = counts(reading);
        for pin in 0..PINS {
            let analog = self.pins[usize::from(pin)].0 == Mode::Analog as u8;
            let Some(channel) = channel(pin).filter(|_| analog) else { continue };
            if self.reported >> channel & 1 == 1 {
                self.tell(&What::Channel(channel), counts, out);
            }
        }
        for read in &self.reads {
            self.tell(&What::I2c(read.clone()), counts, out);
        }
    }
}

fn channel(pin: u8) -> Option<u8> {
    pin.checked_sub(A0)
}

/// What its pins can do; the first two are its serial line's.
fn pins(analog_bits: u8) -> Vec<Pin> {
    let all = (0..PINS).map(|pin| {
        let modes = [
            (pin >= 2, Mode::Input, 1),
            (pin >= 2, Mode::Output, 1),
            (pin >= A0, Mode::Analog, analog_bits),
            (PWM_PINS.contains(&pin), Mode::Pwm, PWM_BITS),
            (I2C_PINS.contains(&pin), Mode::I2c, 1),
        ];
        let able = modes.iter().filter(|(able, _, _)| *able).map(|(_, mode, bits)| (*mode, *bits));
        Pin::new(&able.collect::<Vec<_>>())
    });
    all.collect()
}

fn version(out: &mut Vec<u8>) {
    Message::Version { major: PROTOCOL.0, minor: PROTOCOL.1 }.write(out);
}

fn firmware(out: &mut Vec<u8>) {
    let name = string(&format!("{SIMULATED} board"));
    let data = [&[PROTOCOL.0, PROTOCOL.1], name.as_slice()].concat();
    sysex(id::FIRMWARE, &data, out);
}

/// A byte of the AS5600: its angle's high byte first (data sheet, Fig. 21).
fn as5600(register: u8, counts: u16) -> u8 {
    let [high, low] = (counts & 0x0FFF).to_be_bytes();
    match register {
        STATUS => MAGNET,
        RAW_ANGLE => high,
        _ if register == RAW_ANGLE + 1 => low,
        _ => 0,
    }
}

/// `mark CODE NUMBER`, as our host says it.
fn marker(text: &str) -> Option<Act> {
    let (code, number) = text.strip_prefix("mark ")?.split_once(' ')?;
    Some(Act::Mark(code.parse().ok()?, number.parse().ok()?))
}
