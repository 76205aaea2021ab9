//! Firmata 2.5: messages of one to three bytes, and longer ones between 0xF0 and 0xF7.
//!
//! Source: github.com/firmata/protocol, `protocol.md` (version 2.5.1) and `i2c.md`. A byte from
//! 0x80 on begins a message or ends a long one; all other bytes are below 0x80. So a reader that
//! begins in the middle, or on a noisy wire, is right again at the next message. There is no
//! checksum: a byte that turned into another one below 0x80 is believed.

mod board;
pub(crate) mod host;
mod link;
mod settings;
mod sysex;

pub(crate) use board::Uno;
pub use host::Pins;
pub use settings::{AngleAt, Firmata};
pub use sysex::{I2cReply, I2cRequest, Mode, Pin, string, unstring};

/// Longest message between 0xF0 and 0xF7, bytes: what 128 pins with thirteen modes each can do.
pub const MOST_SYSEX: usize = 4096;

const START_SYSEX: u8 = 0xF0;
const END_SYSEX: u8 = 0xF7;
const PIN_MODE: u8 = 0xF4;
const DIGITAL_PIN: u8 = 0xF5;
const VERSION: u8 = 0xF9;
const RESET: u8 = 0xFF;

/// The first bytes of messages between 0xF0 and 0xF7 that are known here.
pub mod id {
    /// Which analog channel is which pin?
    pub const ANALOG_MAPPING_QUERY: u8 = 0x69;
    /// A byte for each pin: its channel, or 127.
    pub const ANALOG_MAPPING: u8 = 0x6A;
    /// What can the pins do?
    pub const CAPABILITY_QUERY: u8 = 0x6B;
    /// The modes of each pin with their bits, and a 127 behind each.
    pub const CAPABILITIES: u8 = 0x6C;
    /// In which mode is a pin?
    pub const PIN_STATE_QUERY: u8 = 0x6D;
    /// Pin, mode, and what was written to it.
    pub const PIN_STATE: u8 = 0x6E;
    /// A value for any pin, of any length.
    pub const EXTENDED_ANALOG: u8 = 0x6F;
    /// A text, two bytes for each of its own.
    pub const STRING: u8 = 0x71;
    /// To a device at the I²C bus.
    pub const I2C_REQUEST: u8 = 0x76;
    /// What it answered.
    pub const I2C_REPLY: u8 = 0x77;
    /// Begins the I²C bus.
    pub const I2C_CONFIG: u8 = 0x78;
    /// Name and version of the firmware: without any, the question for it.
    pub const FIRMWARE: u8 = 0x79;
    /// Time between two analog readings, ms.
    pub const SAMPLING_INTERVAL: u8 = 0x7A;
}

/// What the two ends tell each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Message<'a> {
    /// An analog value: of a channel that is read, or for a pin that is written to.
    Analog {
        /// Channel or pin, 0–15.
        channel: u8,
        /// 14 bits.
        value: u16,
    },
    /// Eight digital pins.
    Digital {
        /// Which eight, 0–15.
        port: u8,
        /// A bit each.
        pins: u8,
    },
    /// Whether an analog channel is to be told.
    ReportAnalog {
        /// Channel, 0–15.
        channel: u8,
        /// Whether.
        on: bool,
    },
    /// Whether eight digital pins are to be told.
    ReportDigital {
        /// Which eight, 0–15.
        port: u8,
        /// Whether.
        on: bool,
    },
    /// What a pin is to be.
    PinMode {
        /// 0–127.
        pin: u8,
        /// A [`Mode`], or one that is not known here.
        mode: u8,
    },
    /// A digital pin that is written to.
    DigitalPin {
        /// 0–127.
        pin: u8,
        /// High.
        on: bool,
    },
    /// Which version of the protocol? The host asks.
    VersionQuery,
    /// This one: the board says.
    Version {
        /// 2.
        major: u8,
        /// 5 or more.
        minor: u8,
    },
    /// Begin anew.
    Reset,
    /// A longer message, up to [`MOST_SYSEX`] bytes.
    Sysex {
        /// One of [`id`].
        id: u8,
        /// What it carries, bytes below 0x80.
        data: &'a [u8],
    },
}

/// The lower seven bits, and the next seven.
pub fn two(value: u16) -> [u8; 2] {
    [(value & 0x7F) as u8, (value >> 7 & 0x7F) as u8]
}

/// The value of two bytes of seven bits.
pub fn joined(low: u8, high: u8) -> u16 {
    u16::from(low & 0x7F) | u16::from(high & 0x7F) << 7
}

impl Message<'_> {
    /// Writes its bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        match *self {
            Self::Analog { channel, value } => {
                let [low, high] = two(value);
                out.extend([0xE0 | channel & 0x0F, low, high]);
            }
            Self::Digital { port, pins } => {
                let [low, high] = two(pins.into());
                out.extend([0x90 | port & 0x0F, low, high]);
            }
            Self::ReportAnalog { channel, on } => out.extend([0xC0 | channel & 0x0F, on.into()]),
            Self::ReportDigital { port, on } => out.extend([0xD0 | port & 0x0F, on.into()]),
            Self::PinMode { pin, mode } => out.extend([PIN_MODE, pin & 0x7F, mode & 0x7F]),
            Self::DigitalPin { pin, on } => out.extend([DIGITAL_PIN, pin & 0x7F, on.into()]),
            Self::VersionQuery => out.push(VERSION),
            Self::Version { major, minor } => out.extend([VERSION, major & 0x7F, minor & 0x7F]),
            Self::Reset => out.push(RESET),
            Self::Sysex { id, data } => {
                out.extend([START_SYSEX, id & 0x7F]);
                out.extend(data.iter().take(MOST_SYSEX - 1).map(|byte| byte & 0x7F));
                out.push(END_SYSEX);
            }
        }
    }
}

/// Which end sends it: the same byte requests the version and reports it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The host.
    Host,
    /// The board.
    Board,
}

/// Takes bytes as they come, in whatever pieces, and gives messages. Its memory is bounded.
#[derive(Debug, Clone)]
pub struct Parser {
    sender: End,
    /// The message that has begun, and its bytes so far; none within what is dropped.
    command: Option<u8>,
    bytes: Vec<u8>,
    /// The message that was handed out last is still in `bytes`.
    handed_out: bool,
    /// Messages that were cut off or not known, and runs of bytes that belong to none.
    damaged: u64,
    /// What comes belongs to no message.
    astray: bool,
}

impl Parser {
    /// A parser of what this end sends.
    pub fn new(sender: End) -> Self {
        let bytes = Vec::with_capacity(64);
        Self { sender, command: None, bytes, handed_out: false, damaged: 0, astray: false }
    }

    /// Takes one byte; the message that it ends.
    pub fn push(&mut self, byte: u8) -> Option<Message<'_>> {
        if std::mem::take(&mut self.handed_out) {
            self.bytes.clear();
        }
        if byte < 0x80 { self.take(byte) } else { self.begin(byte) }
    }

    /// Pieces that were no message, so far.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// A byte below 0x80.
    fn take(&mut self, byte: u8) -> Option<Message<'_>> {
        let Some(command) = self.command else {
            self.stray();
            return None;
        };
        // Dropped once it is too long, so that the memory stays bounded.
        if command == START_SYSEX && self.bytes.len() == MOST_SYSEX {
            self.command = None;
            self.bytes.clear();
            self.stray();
            return None;
        }
        self.bytes.push(byte);
        if command == START_SYSEX || self.bytes.len() < length(command) {
            return None;
        }
        (self.command, self.handed_out) = (None, true);
        short(command, &self.bytes)
    }

    /// A byte from 0x80 on: what had begun before is cut off.
    fn begin(&mut self, byte: u8) -> Option<Message<'_>> {
        let before = self.command.take();
        self.astray = false;
        if byte == END_SYSEX {
            self.handed_out = before == Some(START_SYSEX) && !self.bytes.is_empty();
            if !self.handed_out {
                self.bytes.clear();
                self.damaged += 1;
                return None;
            }
            let (id, data) = self.bytes.split_first()?;
            return Some(Message::Sysex { id: *id, data });
        }
        self.damaged += u64::from(before.is_some());
        self.bytes.clear();
        match byte {
            // The host's question is this byte alone; a board's answer has two more.
            VERSION if self.sender == End::Host => return Some(Message::VersionQuery),
            RESET => return Some(Message::Reset),
            _ if byte == START_SYSEX || length(byte) > 0 => self.command = Some(byte),
            _ => self.stray(),
        }
        None
    }

    /// Counts a run of bytes that belong to no message once.
    fn stray(&mut self) {
        self.damaged += u64::from(!self.astray);
        self.astray = true;
    }
}

/// Bytes behind a message's first; 0 of one that is not known, or has none.
fn length(command: u8) -> usize {
    match command {
        0x90..=0x9F | 0xE0..=0xEF | PIN_MODE | DIGITAL_PIN | VERSION => 2,
        0xC0..=0xDF => 1,
        _ => 0,
    }
}

/// A message of up to three bytes.
fn short(command: u8, bytes: &[u8]) -> Option<Message<'static>> {
    let first = *bytes.first()?;
    let second = bytes.get(1).copied().unwrap_or_default();
    let channel = command & 0x0F;
    Some(match command {
        0x90..=0x9F => Message::Digital { port: channel, pins: joined(first, second) as u8 },
        0xE0..=0xEF => Message::Analog { channel, value: joined(first, second) },
        0xC0..=0xCF => Message::ReportAnalog { channel, on: first != 0 },
        0xD0..=0xDF => Message::ReportDigital { port: channel, on: first != 0 },
        PIN_MODE => Message::PinMode { pin: first, mode: second },
        DIGITAL_PIN => Message::DigitalPin { pin: first, on: second != 0 },
        VERSION => Message::Version { major: first, minor: second },
        _ => return None,
    })
}

#[cfg(test)]
mod tests;
