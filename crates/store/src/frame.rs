//! The form of a journal: a line that names it, then frames, each with its length and a digest.
//!
//! ```text
//! journal = "zwidth journal 1\n" frame*
//! frame   = length of the payload (u32) · kind (u8) · payload · digest (32 bytes)
//! kind    = 1 header: JSON of what is known of the trial and of what its file will say of itself
//!           2 rows · 3 end (empty) · 4 answer: the answer 1…5 (u8)
//! row     = which of the optional values are there (u8: 1 device time, 2 force age, 4 count) · t_s · t_device_s ·
//!           theta_rad · theta_dot_rad_s · force_ex_n · motor_v · brake_v · force_age_s · force_cmd_n (f64) ·
//!           theta_raw · flags (u16)
//! digest  = BLAKE3(digest of the frame before · length · kind · payload)
//! ```
//!
//! Numbers are little-endian. A frame counts only whole, and only after all before it.

use crate::TrialFile;
use serde::{Deserialize, Serialize};
use zwidth_study::{Flags, Sample, TrialMeta, Voltages};

/// The first bytes of every journal.
pub(crate) const MAGIC: &[u8] = b"zwidth journal 1\n";
/// Bytes of a digest.
const DIGEST: usize = 32;
/// Bytes before a frame's payload: its length and its kind.
const HEAD: usize = 5;
/// Bytes of a row: the bits, nine floats, two counts.
const ROW: usize = 1 + 9 * 8 + 2 * 2;

/// A piece of a journal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Frame {
    Header(Header),
    Rows(Vec<Sample>),
    End,
    Answer(u8),
}

/// What is known of a trial when it begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Header {
    pub(crate) meta: TrialMeta,
    pub(crate) file: TrialFile,
}

/// The digest that a frame's own follows: the frame before's, or none.
pub(crate) type Chain = [u8; DIGEST];

/// A frame as bytes, and the chain after it.
pub(crate) fn encode(frame: &Frame, chain: Chain) -> Result<(Vec<u8>, Chain), serde_json::Error> {
    let (kind, payload) = match frame {
        Frame::Header(header) => (1, serde_json::to_vec(header)?),
        Frame::Rows(rows) => (2, rows.iter().flat_map(row_bytes).collect()),
        Frame::End => (3, Vec::new()),
        Frame::Answer(answer) => (4, vec![*answer]),
    };
    // No frame comes near the limit: a batch is a tenth of a second.
    let length = u32::try_from(payload.len()).unwrap_or(u32::MAX);
    let mut bytes = length.to_le_bytes().to_vec();
    bytes.push(kind);
    bytes.extend_from_slice(&payload);
    let chain = digest(chain, &bytes);
    bytes.extend_from_slice(&chain);
    Ok((bytes, chain))
}

/// The whole frames at the beginning of `bytes` (what follows [`MAGIC`]), and how many bytes they take.
pub(crate) fn decode(bytes: &[u8]) -> (Vec<Frame>, usize) {
    let (mut frames, mut at, mut chain) = (Vec::new(), 0, Chain::default());
    while let Some((frame, length, next)) = first(&bytes[at..], chain) {
        frames.push(frame);
        at += length;
        chain = next;
    }
    (frames, at)
}

/// The frame that `bytes` begin with, if it is whole; its length, and the chain after it.
fn first(bytes: &[u8], chain: Chain) -> Option<(Frame, usize, Chain)> {
    let length = u32::from_le_bytes(*bytes.first_chunk()?);
    let end = HEAD.checked_add(usize::try_from(length).ok()?)?;
    let body = bytes.get(..end)?;
    let expected = digest(chain, body);
    let found = bytes.get(end..end.checked_add(DIGEST)?)?;
    let frame = (found == expected).then(|| parse(body[HEAD - 1], &body[HEAD..]))??;
    Some((frame, end + DIGEST, expected))
}

fn parse(kind: u8, payload: &[u8]) -> Option<Frame> {
    match (kind, payload) {
        (1, json) => serde_json::from_slice(json).ok().map(Frame::Header),
        (2, rows) if rows.len() % ROW == 0 => {
            Some(Frame::Rows(rows.chunks_exact(ROW).filter_map(row).collect()))
        }
        (3, []) => Some(Frame::End),
        (4, [answer]) => Some(Frame::Answer(*answer)),
        _ => None,
    }
}

fn digest(chain: Chain, body: &[u8]) -> Chain {
    *blake3::Hasher::new().update(&chain).update(body).finalize().as_bytes()
}

fn row_bytes(s: &Sample) -> Vec<u8> {
    let there = |bit: u8, is_there: bool| if is_there { bit } else { 0 };
    let bits = there(1, s.t_device_s.is_some())
        | there(2, s.force_age_s.is_some())
        | there(4, s.theta_raw.is_some());
    let floats = [
        s.t_s,
        s.t_device_s.unwrap_or(0.0),
        s.theta_rad,
        s.theta_dot_rad_s,
        s.force_ex_n,
        s.voltages.motor_v,
        s.voltages.brake_v,
        s.force_age_s.unwrap_or(0.0),
        s.force_cmd_n,
    ];
    let mut bytes = Vec::with_capacity(ROW);
    bytes.push(bits);
    floats.iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
    [s.theta_raw.unwrap_or(0), s.flags.0].iter().for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
    bytes
}

fn row(bytes: &[u8]) -> Option<Sample> {
    let (bits, rest) = bytes.split_first()?;
    let float = |i: usize| Some(f64::from_le_bytes(*rest.get(8 * i..)?.first_chunk()?));
    let count = |i: usize| Some(u16::from_le_bytes(*rest.get(9 * 8 + 2 * i..)?.first_chunk()?));
    let has = |bit: u8| bits & bit != 0;
    Some(Sample {
        t_s: float(0)?,
        t_device_s: float(1).filter(|_| has(1)),
        theta_rad: float(2)?,
        theta_dot_rad_s: float(3)?,
        force_ex_n: float(4)?,
        voltages: Voltages { motor_v: float(5)?, brake_v: float(6)? },
        force_age_s: float(7).filter(|_| has(2)),
        force_cmd_n: float(8)?,
        theta_raw: count(0).filter(|_| has(4)),
        flags: Flags(count(1)?),
    })
}

/// Whether what follows the last whole frame is no more than one unfinished append: a frame that reaches or passes
/// the end of the file, or one that ends in zeros, which some file systems show where data were not synced, and which
/// no digest is.
pub(crate) fn is_unfinished(rest: &[u8]) -> bool {
    let Some(length) = rest.first_chunk::<4>() else { return true };
    let end = HEAD + u32::from_le_bytes(*length) as usize + DIGEST;
    end >= rest.len() || rest.ends_with(&[0; DIGEST])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crashes::{meta, rows};

    fn frames() -> Vec<Frame> {
        let file = [("device".to_owned(), "none".to_owned())].into();
        let mut whole = rows(5, 3);
        whole[1].t_device_s = Some(-1.5);
        whole[2] = Sample { force_age_s: None, theta_raw: None, flags: Flags(u16::MAX), ..whole[2] };
        let header = Frame::Header(Header { meta: meta(2), file });
        vec![header, Frame::Rows(rows(0, 5)), Frame::Rows(whole), Frame::End, Frame::Answer(4)]
    }

    /// The frames as bytes, and where each ends.
    fn encoded(frames: &[Frame]) -> (Vec<u8>, Vec<usize>) {
        let (mut bytes, mut ends, mut chain) = (Vec::new(), vec![0], Chain::default());
        for frame in frames {
            let (more, next) = encode(frame, chain).unwrap();
            bytes.extend(more);
            ends.push(bytes.len());
            chain = next;
        }
        (bytes, ends)
    }

    #[test]
    fn frames_come_back_as_they_were_written() {
        let (bytes, _) = encoded(&frames());
        assert_eq!(decode(&bytes), (frames(), bytes.len()));
    }

    #[test]
    fn cut_anywhere_every_whole_frame_is_there_and_the_rest_is_one_unfinished_append() {
        let (bytes, ends) = encoded(&frames());
        for cut in 0..bytes.len() {
            let whole = ends.iter().rposition(|end| *end <= cut).unwrap();
            let (found, at) = decode(&bytes[..cut]);
            assert_eq!((found.as_slice(), at), (&frames()[..whole], ends[whole]), "{cut}");
            assert!(is_unfinished(&bytes[at..cut]), "{cut}");
            // Where the length was written and the rest of the append was not, it may be zeros.
            let zeros = [&bytes[..cut], &vec![0; ends[whole + 1] - cut]].concat();
            let (found, at) = decode(&zeros);
            assert_eq!((found.len(), at), (whole, ends[whole]), "{cut}");
            assert!(is_unfinished(&zeros[at..]), "{cut}");
        }
    }

    #[test]
    fn no_flipped_bit_makes_another_frame_of_a_frame() {
        let (bytes, ends) = encoded(&frames());
        for i in 0..bytes.len() {
            let mut bad = bytes.clone();
            bad[i] ^= 1 << (i % 8);
            let whole = ends.iter().rposition(|end| *end <= i).unwrap();
            assert_eq!(decode(&bad).0, frames()[..whole], "byte {i}");
        }
    }

    #[test]
    fn a_frame_that_is_missing_or_out_of_its_place_is_noticed() {
        let (bytes, ends) = encoded(&frames());
        let missing = [&bytes[..ends[1]], &bytes[ends[2]..]].concat();
        let (found, at) = decode(&missing);
        assert_eq!(found.len(), 1);
        assert!(!is_unfinished(&missing[at..]), "whole frames that do not follow are damage");
    }
}
