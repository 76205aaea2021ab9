//! Messages: what the two ends tell each other.

use super::frame::{Frame, MOST_PAYLOAD};
use crate::Drive;

/// The version of the protocol that this is.
pub const PROTOCOL: u8 = 1;

/// The sequence number of what a board says unasked: no question has it.
pub const UNASKED: u16 = 0;

/// What the host says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ToBoard {
    /// Who are you? A [`Description`] answers it.
    Hello,
    /// What do you see? A [`Seen`] answers it.
    Poll,
    /// These voltages, until the next ones or the watchdog.
    Write(Drive),
    /// Something happened that a marker line is to show: a code and a number.
    Mark {
        /// What, one of [`crate::mark`].
        code: u8,
        /// Which.
        number: u16,
    },
}

/// What a board says about itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Description {
    /// The protocol it speaks.
    pub protocol: u8,
    /// Shortest time between two readings, µs.
    pub period_us: u32,
    /// Time between two values of its force sensor, µs.
    pub force_period_us: u32,
    /// Counts of the angle sensor in a turn of the shaft.
    pub counts_per_turn: u16,
    /// The motor's full scale, mV.
    pub motor_mv: u32,
    /// The brake's full scale, mV.
    pub brake_mv: u32,
    /// Without a write for this long it goes to 0 V by itself, ms; 0 for never.
    pub watchdog_ms: u16,
    /// Whether what it sees is simulated: a board to try things on.
    pub simulated: bool,
    /// What it is called, with its version.
    pub name: String,
}

/// Longest name of a board, bytes.
pub const MOST_NAME: usize = MOST_PAYLOAD - 22;

/// What a board has seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seen {
    /// When, by its own clock, µs, round after 71.6 minutes.
    pub t_us: u32,
    /// The angle sensor's count.
    pub counts: u16,
    /// Age of that count, µs.
    pub angle_age_us: u16,
    /// The load cell's count.
    pub force: i32,
    /// Age of that count, µs.
    pub force_age_us: u32,
    /// [`status`].
    pub status: u16,
    /// The voltages that are really out.
    pub drive: Drive,
}

/// Bits of [`Seen::status`].
pub mod status {
    /// The angle sensor does not see its magnet.
    pub const NO_MAGNET: u16 = 1;
    /// The load cell is at the end of its range.
    pub const FORCE_SATURATED: u16 = 2;
    /// The watchdog took the voltages away.
    pub const WATCHDOG: u16 = 4;
}

/// What a board says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FromBoard {
    /// Who it is: asked for, or because it has just begun.
    Description(Description),
    /// What it has seen.
    Seen(Seen),
}

const HELLO: u8 = 0x01;
const POLL: u8 = 0x02;
const WRITE: u8 = 0x03;
const MARK: u8 = 0x04;
const DESCRIPTION: u8 = 0x81;
const SEEN: u8 = 0x82;

impl ToBoard {
    /// As a frame.
    pub fn frame(&self, sequence: u16) -> Frame {
        match self {
            Self::Hello => Frame::new(HELLO, sequence, &[PROTOCOL]),
            Self::Poll => Frame::new(POLL, sequence, &[]),
            Self::Write(drive) => Frame::new(WRITE, sequence, &drive.bytes()),
            Self::Mark { code, number } => {
                let [low, high] = number.to_le_bytes();
                Frame::new(MARK, sequence, &[*code, low, high])
            }
        }
    }

    /// From a frame; none of a kind or length that there is not.
    pub fn read(frame: &Frame) -> Option<Self> {
        let mut bytes = Bytes(frame.payload());
        let message = match frame.kind {
            HELLO => bytes.take().map(|[_]: [u8; 1]| Self::Hello),
            POLL => Some(Self::Poll),
            WRITE => Drive::read(&mut bytes).map(Self::Write),
            MARK => {
                let [code, low, high] = bytes.take()?;
                Some(Self::Mark { code, number: u16::from_le_bytes([low, high]) })
            }
            _ => None,
        };
        message.filter(|_| bytes.0.is_empty())
    }
}

impl FromBoard {
    /// As a frame. A name is cut off after [`MOST_NAME`] bytes.
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut payload = Vec::with_capacity(MOST_PAYLOAD);
        match self {
            Self::Description(board) => {
                payload.push(board.protocol);
                payload.extend(board.period_us.to_le_bytes());
                payload.extend(board.force_period_us.to_le_bytes());
                payload.extend(board.counts_per_turn.to_le_bytes());
                payload.extend(board.motor_mv.to_le_bytes());
                payload.extend(board.brake_mv.to_le_bytes());
                payload.extend(board.watchdog_ms.to_le_bytes());
                payload.push(u8::from(board.simulated));
                payload.extend(board.name.bytes().take(MOST_NAME));
                Frame::new(DESCRIPTION, sequence, &payload)
            }
            Self::Seen(seen) => {
                payload.extend(seen.t_us.to_le_bytes());
                payload.extend(seen.counts.to_le_bytes());
                payload.extend(seen.angle_age_us.to_le_bytes());
                payload.extend(seen.force.to_le_bytes());
                payload.extend(seen.force_age_us.to_le_bytes());
                payload.extend(seen.status.to_le_bytes());
                payload.extend(seen.drive.bytes());
                Frame::new(SEEN, sequence, &payload)
            }
        }
    }

    /// From a frame; none of a kind or length that there is not.
    pub fn read(frame: &Frame) -> Option<Self> {
        let mut bytes = Bytes(frame.payload());
        match frame.kind {
            DESCRIPTION => Description::read(&mut bytes).map(Self::Description),
            SEEN => Seen::read(&mut bytes).filter(|_| bytes.0.is_empty()).map(Self::Seen),
            _ => None,
        }
    }
}

/// As it stands in a frame.
impl Drive {
    fn bytes(self) -> [u8; 4] {
        let [a, b] = self.motor.to_le_bytes();
        let [c, d] = self.brake.to_le_bytes();
        [a, b, c, d]
    }

    fn read(bytes: &mut Bytes) -> Option<Self> {
        let [motor, brake] = [bytes.take()?, bytes.take()?].map(i16::from_le_bytes);
        Some(Self { motor, brake })
    }
}

impl Description {
    fn read(bytes: &mut Bytes) -> Option<Self> {
        let [protocol] = bytes.take()?;
        Some(Self {
            protocol,
            period_us: u32::from_le_bytes(bytes.take()?),
            force_period_us: u32::from_le_bytes(bytes.take()?),
            counts_per_turn: u16::from_le_bytes(bytes.take()?),
            motor_mv: u32::from_le_bytes(bytes.take()?),
            brake_mv: u32::from_le_bytes(bytes.take()?),
            watchdog_ms: u16::from_le_bytes(bytes.take()?),
            simulated: bytes.take()? != [0],
            name: String::from_utf8_lossy(bytes.0).into_owned(),
        })
    }
}

impl Seen {
    fn read(bytes: &mut Bytes) -> Option<Self> {
        Some(Self {
            t_us: u32::from_le_bytes(bytes.take()?),
            counts: u16::from_le_bytes(bytes.take()?),
            angle_age_us: u16::from_le_bytes(bytes.take()?),
            force: i32::from_le_bytes(bytes.take()?),
            force_age_us: u32::from_le_bytes(bytes.take()?),
            status: u16::from_le_bytes(bytes.take()?),
            drive: Drive::read(bytes)?,
        })
    }
}

/// Bytes that are taken from the front.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn seen() -> impl Strategy<Value = Seen> {
        (any::<(u32, u16, u16, i32, u32, u16)>(), any::<(i16, i16)>()).prop_map(
            |((t_us, counts, angle_age_us, force, force_age_us, status), (motor, brake))| Seen {
                t_us,
                counts,
                angle_age_us,
                force,
                force_age_us,
                status,
                drive: Drive { motor, brake },
            },
        )
    }

    proptest! {
        #[test]
        fn every_message_of_a_board_is_read_as_it_was_meant(
            seen in seen(),
            numbers in any::<(u8, u32, u32, u16, u32, u32, u16, bool)>(),
            name in "[a-zA-Z0-9 .]{0,41}",
        ) {
            let seen = FromBoard::Seen(seen);
            prop_assert_eq!(FromBoard::read(&seen.frame(4)), Some(seen));
            let (protocol, period_us, force_period_us, counts_per_turn, motor_mv, brake_mv, watchdog_ms, simulated) =
                numbers;
            let board = FromBoard::Description(Description {
                protocol,
                period_us,
                force_period_us,
                counts_per_turn,
                motor_mv,
                brake_mv,
                watchdog_ms,
                simulated,
                name,
            });
            prop_assert_eq!(FromBoard::read(&board.frame(4)), Some(board));
        }

        #[test]
        fn every_message_of_the_host_is_read_as_it_was_meant(
            motor in any::<i16>(), brake in any::<i16>(), code in any::<u8>(), number in any::<u16>(),
        ) {
            let drive = Drive { motor, brake };
            let all = [ToBoard::Hello, ToBoard::Poll, ToBoard::Write(drive), ToBoard::Mark { code, number }];
            for message in all {
                prop_assert_eq!(ToBoard::read(&message.frame(65_535)), Some(message));
            }
        }

        #[test]
        fn any_other_payload_is_no_message_and_no_fault(
            kind in any::<u8>(), payload in prop::collection::vec(any::<u8>(), 0..=MOST_PAYLOAD),
        ) {
            let frame = Frame::new(kind, 0, &payload);
            if let Some(message) = ToBoard::read(&frame) {
                prop_assert_eq!(message.frame(0).kind, kind);
            }
            if let Some(message) = FromBoard::read(&frame) {
                prop_assert_eq!(message.frame(0).kind, kind);
            }
        }
    }
}
