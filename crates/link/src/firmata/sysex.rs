//! What the longer messages carry.

use super::{joined, two};

/// What a pin can be (protocol.md, "Supported Modes").
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Mode {
    /// Digital input.
    Input = 0,
    /// Digital output.
    Output = 1,
    /// Analog input.
    Analog = 2,
    /// Output by pulses of a width.
    Pwm = 3,
    /// Of the I²C bus.
    I2c = 6,
}

/// What a pin of a board can do: its modes and their bits.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Pin(pub(super) Vec<(u8, u8)>);

/// Ends a pin's modes.
const END_OF_PIN: u8 = 0x7F;
/// Pins that the protocol has numbers for.
const MOST_PINS: usize = 128;

impl Pin {
    /// One that can do this.
    pub fn new(modes: &[(Mode, u8)]) -> Self {
        Self(modes.iter().map(|(mode, bits)| (*mode as u8, *bits)).collect())
    }

    /// Bits of a mode; none for a mode that it does not have.
    pub fn bits(&self, mode: Mode) -> Option<u8> {
        self.0.iter().find(|(able, _)| *able == mode as u8).map(|(_, bits)| *bits)
    }

    /// Every pin of an answer to [`super::id::CAPABILITY_QUERY`]; of a broken one those before the
    /// break.
    pub fn read_all(data: &[u8]) -> Vec<Self> {
        let mut pins = Vec::new();
        let mut modes = Vec::new();
        let mut bytes = data.iter();
        while let Some(mode) = bytes.next().filter(|_| pins.len() < MOST_PINS) {
            if *mode == END_OF_PIN {
                pins.push(Self(std::mem::take(&mut modes)));
            } else if let Some(bits) = bytes.next() {
                modes.push((*mode, *bits));
            }
        }
        pins
    }

    /// That answer.
    pub fn write_all(pins: &[Self]) -> Vec<u8> {
        pins.iter()
            .flat_map(|pin| {
                let modes = pin.0.iter().flat_map(|(mode, bits)| [*mode, *bits]);
                modes.chain([END_OF_PIN]).collect::<Vec<u8>>()
            })
            .collect()
    }
}

/// What a host asks of a device at the I²C bus.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum I2cRequest {
    /// Bytes that it is sent.
    Write {
        /// Its address, 7 bits.
        address: u8,
        /// Those bytes.
        bytes: Vec<u8>,
    },
    /// What stands in it, once or at each sampling interval.
    Read {
        /// Its address, 7 bits.
        address: u8,
        /// The register to begin with; none: where it stands.
        register: Option<u8>,
        /// So many bytes.
        length: u8,
        /// At each sampling interval.
        again: bool,
    },
    /// No longer at each sampling interval.
    Stop {
        /// Its address, 7 bits.
        address: u8,
    },
}

/// Bits of an I²C request's second byte (i2c.md).
const TEN_BIT: u8 = 0x20;
const WAY: u8 = 0x18;
const READ_ONCE: u8 = 0x08;
const READ_AGAIN: u8 = 0x10;
const STOP: u8 = 0x18;

impl I2cRequest {
    /// From what a message carries; none of an address of ten bits, or of half a request.
    pub fn read(data: &[u8]) -> Option<Self> {
        let ([address, how], rest) = data.split_first_chunk::<2>()?;
        if how & TEN_BIT != 0 {
            return None;
        }
        let numbers = numbers(rest);
        let again = how & WAY == READ_AGAIN;
        match (how & WAY, numbers.as_slice()) {
            (0, _) => Some(Self::Write { address: *address, bytes: numbers }),
            (STOP, _) => Some(Self::Stop { address: *address }),
            (_, [register, length, ..]) => {
                let register = Some(*register);
                let length = *length;
                Some(Self::Read { address: *address, register, length, again })
            }
            (_, [length]) => {
                Some(Self::Read { address: *address, register: None, length: *length, again })
            }
            _ => None,
        }
    }

    /// What a message carries.
    pub fn data(&self) -> Vec<u8> {
        let (address, how, bytes) = match self {
            Self::Write { address, bytes } => (address, 0, bytes.clone()),
            Self::Stop { address } => (address, STOP, Vec::new()),
            Self::Read { address, register, length, again } => {
                let how = if *again { READ_AGAIN } else { READ_ONCE };
                (address, how, register.iter().copied().chain([*length]).collect())
            }
        };
        let pairs = bytes.into_iter().flat_map(|byte| two(u16::from(byte)));
        [address & 0x7F, how].into_iter().chain(pairs).collect()
    }
}

/// What a device at the I²C bus answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct I2cReply {
    /// Its address.
    pub address: u8,
    /// The register that it begins with.
    pub register: u8,
    /// What stood there.
    pub bytes: Vec<u8>,
}

impl I2cReply {
    /// From what a message carries.
    pub fn read(data: &[u8]) -> Option<Self> {
        let numbers = numbers(data);
        let ([address, register], bytes) = numbers.split_first_chunk::<2>()?;
        Some(Self { address: *address, register: *register, bytes: bytes.to_vec() })
    }

    /// What a message carries.
    pub fn data(&self) -> Vec<u8> {
        let bytes = [self.address, self.register].into_iter().chain(self.bytes.iter().copied());
        bytes.flat_map(|byte| two(u16::from(byte))).collect()
    }
}

/// A text as two bytes for each of its own.
pub fn string(text: &str) -> Vec<u8> {
    text.bytes().flat_map(|byte| two(u16::from(byte))).collect()
}

/// The text again.
pub fn unstring(data: &[u8]) -> String {
    String::from_utf8_lossy(&numbers(data)).into_owned()
}

/// Bytes that came as pairs of seven bits; one without its other is dropped.
fn numbers(data: &[u8]) -> Vec<u8> {
    data.chunks_exact(2).map(|pair| joined(pair[0], pair[1]) as u8).collect()
}
