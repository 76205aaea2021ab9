//! Frames: how messages are written on the wire.
//!
//! A frame is `kind ‖ sequence ‖ payload ‖ CRC-32`, by consistent overhead byte stuffing (Cheshire
//! & Baker, IEEE/ACM Trans. Netw. 7 (1999) 159–172) without a 0 in it, and a 0 after it. Bytes
//! between two zeros that are not a whole frame are dropped and counted, so a reader that begins in
//! the middle, or on a noisy wire, is right again at the next 0. Numbers are little-endian.

/// Longest payload of a message, bytes.
pub const MOST_PAYLOAD: usize = 64;
/// Kind, sequence, and the CRC-32 behind the payload (IEEE 802.3, as zlib has it), bytes.
const AROUND: usize = 1 + 2 + 4;
/// Longest frame on the wire: one byte of stuffing in each 254, and the 0.
pub const MOST_WIRE: usize = MOST_PAYLOAD + AROUND + 2;

/// A message as bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    /// What it is.
    pub kind: u8,
    /// Counts the frames of one end, from 0 on and round.
    pub sequence: u16,
    payload: [u8; MOST_PAYLOAD],
    length: usize,
}

impl Frame {
    /// A frame; of a payload that is longer than [`MOST_PAYLOAD`] the rest is cut off.
    pub fn new(kind: u8, sequence: u16, payload: &[u8]) -> Self {
        let length = payload.len().min(MOST_PAYLOAD);
        let mut frame = Self { kind, sequence, payload: [0; MOST_PAYLOAD], length };
        frame.payload[..length].copy_from_slice(&payload[..length]);
        frame
    }

    /// What it carries.
    pub fn payload(&self) -> &[u8] {
        &self.payload[..self.length]
    }

    /// The bytes that go on the wire, the closing 0 among them, and how many they are.
    pub fn encode(&self) -> ([u8; MOST_WIRE], usize) {
        let mut plain = [0; MOST_PAYLOAD + AROUND];
        plain[0] = self.kind;
        plain[1..3].copy_from_slice(&self.sequence.to_le_bytes());
        let end = 3 + self.length;
        plain[3..end].copy_from_slice(self.payload());
        let check = crc32fast::hash(&plain[..end]);
        plain[end..end + 4].copy_from_slice(&check.to_le_bytes());
        let mut wire = [0; MOST_WIRE];
        // The wire is long enough for the longest frame.
        let length = cobs::try_encode(&plain[..end + 4], &mut wire).unwrap_or(0);
        (wire, length + 1)
    }

    /// Decodes what stood between two zeros.
    fn decode(stuffed: &mut [u8]) -> Option<Self> {
        let length = cobs::decode_in_place(stuffed).ok()?;
        let (head, check) = stuffed[..length].split_last_chunk::<4>()?;
        if crc32fast::hash(head) != u32::from_le_bytes(*check) {
            return None;
        }
        let (kind, rest) = head.split_first()?;
        let (sequence, payload) = rest.split_first_chunk::<2>()?;
        Some(Self::new(*kind, u16::from_le_bytes(*sequence), payload))
    }
}

/// Takes bytes as they come, in whatever pieces, and gives frames. Its memory is bounded.
#[derive(Debug, Clone)]
pub struct Frames {
    bytes: [u8; MOST_WIRE],
    length: usize,
    /// What comes until the next 0 is too long for a frame.
    overlong: bool,
    /// Pieces between two zeros that were no frame.
    damaged: u64,
}

impl Default for Frames {
    fn default() -> Self {
        Self { bytes: [0; MOST_WIRE], length: 0, overlong: false, damaged: 0 }
    }
}

impl Frames {
    /// Takes one byte; the frame that it closes.
    pub fn push(&mut self, byte: u8) -> Option<Frame> {
        if byte != 0 {
            match self.bytes.get_mut(self.length) {
                Some(place) => (*place, self.length) = (byte, self.length + 1),
                None => self.overlong = true,
            }
            return None;
        }
        let length = self.length;
        let overlong = self.overlong;
        (self.length, self.overlong) = (0, false);
        let frame = if overlong { None } else { Frame::decode(&mut self.bytes[..length]) };
        // Two zeros in a row have nothing between them.
        self.damaged += u64::from(frame.is_none() && length > 0);
        frame
    }

    /// Forgets what came since the last 0: another line begins.
    pub fn begin_anew(&mut self) {
        (self.length, self.overlong) = (0, false);
    }

    /// Pieces between two zeros that were no frame, so far.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn wire(frames: &[Frame]) -> Vec<u8> {
        let mut wire = Vec::new();
        for frame in frames {
            let (bytes, length) = frame.encode();
            wire.extend(&bytes[..length]);
        }
        wire
    }

    fn read(bytes: &[u8]) -> Vec<Frame> {
        let mut frames = Frames::default();
        bytes.iter().filter_map(|byte| frames.push(*byte)).collect()
    }

    #[test]
    fn a_frame_has_the_bytes_that_the_page_of_the_protocol_says() {
        // Made apart from this, by Python's zlib.crc32 and a COBS of its own (docs/rig.md).
        let wire_of = |frame: Frame| wire(&[frame]);
        let poll = Frame::new(0x03, 0x0102, &[]);
        assert_eq!(wire_of(poll), hex("080302015f3536b800"));
        let seen = hex("6c20000000080000bb1f0000a00f0000000000200000");
        assert_eq!(
            wire_of(Frame::new(0x82, 1, &seen)),
            hex("038201036c20010102080103bb1f0103a00f0101010102200105b0720b3900")
        );
    }

    fn hex(digits: &str) -> Vec<u8> {
        let pairs = digits.as_bytes().chunks(2);
        pairs.map(|p| u8::from_str_radix(std::str::from_utf8(p).unwrap(), 16).unwrap()).collect()
    }

    proptest! {
        #[test]
        fn what_is_sent_arrives_however_it_is_split_and_whatever_came_before(
            payloads in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..=MOST_PAYLOAD), 1..8),
            noise in prop::collection::vec(any::<u8>(), 0..300),
        ) {
            let sent: Vec<Frame> =
                payloads.iter().zip(0..).map(|(p, i)| Frame::new(7, i, p)).collect();
            let clean = wire(&sent);
            prop_assert_eq!(read(&clean), sent.clone());
            let mut dirty = noise;
            dirty.push(0);
            let before = read(&dirty).len();
            dirty.extend(&clean);
            prop_assert_eq!(&read(&dirty)[before..], &sent[..]);
        }

        #[test]
        fn a_flipped_bit_never_makes_another_frame(
            payload in prop::collection::vec(any::<u8>(), 0..=MOST_PAYLOAD),
            at in any::<prop::sample::Index>(),
            bit in 0..8_u32,
        ) {
            let sent = Frame::new(9, 300, &payload);
            let mut bytes = wire(&[sent]);
            let place = at.index(bytes.len());
            bytes[place] ^= 1 << bit;
            bytes.push(0);
            prop_assert!(read(&bytes).iter().all(|frame| *frame == sent));
        }
    }

    #[test]
    fn what_is_no_frame_is_counted_and_takes_no_more_memory() {
        let mut frames = Frames::default();
        for _ in 0..10_000 {
            assert_eq!(frames.push(1), None);
        }
        assert_eq!((frames.push(0), frames.damaged()), (None, 1));
        assert_eq!((frames.push(0), frames.damaged()), (None, 1));
    }
}
