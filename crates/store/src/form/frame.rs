//! The form of a journal: a line that names it, then frames, each with its length and a digest.
//!
//! ```text
//! journal = "zwidth journal 2\n" frame*
//! frame   = length of the payload (u32) · kind (u8) · payload · digest (32 bytes)
//! kind    = 1 header: JSON of what is known of the trial and of what its file will say of itself
//!           2 rows · 3 end (empty) · 4 answer: the answer (u8)
//!           5 rows with channels: how many (u8), then the rows, each followed by its channels (f64)
//!           6 answer: a number that is no u8, or one with the time that it took: i16, ms (u32; the highest: not measured)
//! row     = which of the optional values are there (u8: 1 device time, 2 force age, 4 count) · t_s · t_device_s ·
//!           theta_rad · theta_dot_rad_s · force_ex_n · motor_v · brake_v · force_age_s · force_cmd_n (f64) ·
//!           theta_raw · flags (u16)
//! digest  = BLAKE3(digest of the frame before · length · kind · payload)
//! ```
//!
//! Numbers are little-endian. A frame counts only if its digest holds. After damage, the digest
//! that is stored before a frame replaces the computed digest, so a lost part does not hide the
//! parts after it.

use crate::disk::SECTOR;
use crate::{TrialFile, from_json};
use serde::{Deserialize, Serialize};
use zwidth_study::{
    Channel, Extra, Flags, Given, MOST_CHANNELS, QuestionId, Sample, TrialForm, TrialMeta, Voltages,
};

/// The first bytes of every journal.
pub(crate) const MAGIC: &[u8] = b"zwidth journal 2\n";
/// Bytes of a digest.
const DIGEST: usize = 32;
/// Bytes before a frame's payload: its length and its kind.
const HEAD: usize = 5;
/// Longest payload, bytes: a batch is a tenth of a second, which at the fastest loop (100 kHz) is
/// 770 kB.
const MOST_PAYLOAD: usize = 1 << 20;
/// Flipped bits in a digest that still leave no doubt what it is a digest of.
const FLIPPED: u32 = 8;
/// Bits of a byte.
const BITS: usize = 8;
/// A search for whole frames hashes at most so many times the journal's bytes.
const MOST_SEARCHED: usize = 16;
/// Bytes that are hashed at most to find one flipped bit: a second's work.
const MOST_TRIED: usize = 1 << 30;
/// Bytes of a row: the bits, nine floats, two counts.
const ROW: usize = 1 + 9 * 8 + 2 * 2;
/// Bytes of an answer with the time that it took.
const TIMED_ANSWER: usize = 2 + 4;
/// Stands for a time that was not measured.
const NO_TIME: u32 = u32::MAX;
/// Bytes of a channel's value.
const VALUE: usize = 8;
/// Rows of a frame, whatever they hold.
pub(crate) const MOST_ROWS: usize = (MOST_PAYLOAD - 1) / (ROW + VALUE * MOST_CHANNELS);

/// A piece of a journal.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Frame {
    Header(Header),
    Rows(Vec<Sample>),
    End,
    Answer(Given),
}

/// The facts about a trial when it begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Header {
    pub(crate) meta: TrialMeta,
    pub(crate) file: TrialFile,
    pub(crate) protocol: Protocol,
}

/// The contents that the session's `study.toml` demands of a trial's file and log.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Protocol {
    /// Which columns the file has.
    pub form: TrialForm,
    /// The question after the trial.
    pub question: Option<QuestionId>,
    /// The device's channels, in the order in which a sample has them.
    pub given: Vec<Channel>,
}

/// The digest that a frame's own follows: that of the frame before, if there is one.
pub(crate) type Chain = [u8; DIGEST];

/// A frame as bytes, and the chain after it.
pub(crate) fn encode(frame: &Frame, chain: Chain) -> Result<(Vec<u8>, Chain), serde_json::Error> {
    let (kind, payload) = match frame {
        Frame::Header(header) => (1, serde_json::to_vec(header)?),
        Frame::Rows(rows) => rows_payload(rows),
        Frame::End => (3, Vec::new()),
        Frame::Answer(Given { value, time_ms }) => match (u8::try_from(*value), time_ms) {
            // The older form, where it is enough: older versions read no other.
            (Ok(value), None) => (4, vec![value]),
            _ => {
                let time_ms = time_ms.unwrap_or(NO_TIME).to_le_bytes();
                (6, [&value.to_le_bytes()[..], &time_ms].concat())
            }
        },
    };
    // The journal splits what is longer than `MOST_PAYLOAD`.
    let length = u32::try_from(payload.len()).unwrap_or(u32::MAX);
    let mut bytes = length.to_le_bytes().to_vec();
    bytes.push(kind);
    bytes.extend_from_slice(&payload);
    let chain = digest(chain, &bytes);
    bytes.extend_from_slice(&chain);
    Ok((bytes, chain))
}

/// The contents of a journal's bytes.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Decoded {
    /// Every frame that is whole, or could be mended, in order.
    pub(crate) frames: Vec<Frame>,
    /// Frames whose damage could be mended: what they hold is what was written, by their digest.
    pub(crate) mended: usize,
    /// Bytes, not at the end, of which nothing could be made.
    pub(crate) damaged: usize,
    /// Bytes at the end that are one unfinished append.
    pub(crate) unfinished: usize,
}

/// The frames in `bytes` (what follows [`MAGIC`]). Behind damage it goes on with the next whole
/// frame.
pub(crate) fn decode(bytes: &[u8]) -> Decoded {
    let mut decoded = Decoded::default();
    let mut at = 0;
    let mut chain = Chain::default();
    let mut search = Search::new(bytes);
    while at < bytes.len() {
        if let Some(Whole { frame, length, chain: next, exact }) = first(&bytes[at..], chain) {
            decoded.frames.push(frame);
            decoded.mended += usize::from(!exact);
            (at, chain) = (at + length, next);
            continue;
        }
        let next = search.whole_from(at + 1);
        let span = &bytes[at..next.unwrap_or(bytes.len())];
        if let Some((frame, true_chain)) = mend(span, chain) {
            decoded.frames.push(frame);
            (decoded.mended, chain) = (decoded.mended + 1, true_chain);
        } else if next.is_none() && is_unfinished(span, MAGIC.len() + at) {
            decoded.unfinished = span.len();
        } else {
            decoded.damaged += span.len();
            // The frame after it follows the digest that stands there.
            chain = span.last_chunk().copied().unwrap_or_default();
        }
        at += span.len();
    }
    decoded
}

/// A frame at the beginning of some bytes.
struct Whole {
    frame: Frame,
    /// Its bytes.
    length: usize,
    /// The chain after it.
    chain: Chain,
    /// Whether its digest is undamaged too.
    exact: bool,
}

/// The frame that `bytes` begin with, if it is whole. A few flipped bits in the digest alone do no
/// harm.
fn first(bytes: &[u8], chain: Chain) -> Option<Whole> {
    let end = HEAD + payload_length(bytes)?;
    let (body, rest) = bytes.split_at_checked(end)?;
    let stored: &Chain = rest.first_chunk()?;
    let (frame, expected) = verified(body, stored, chain)?;
    Some(Whole { frame, length: end + DIGEST, chain: expected, exact: *stored == expected })
}

/// The frame with this body and its true digest, if the stored digest is that but for a few bits.
fn verified(body: &[u8], stored: &Chain, chain: Chain) -> Option<(Frame, Chain)> {
    let expected = digest(chain, body);
    // From the digest of another body it would differ in some hundred bits.
    let differ: u32 = stored.iter().zip(&expected).map(|(a, b)| (a ^ b).count_ones()).sum();
    let frame = (differ <= FLIPPED).then(|| parse(body[HEAD - 1], &body[HEAD..]))??;
    Some((frame, expected))
}

/// The length that a frame's head claims, where a frame of its kind can have it.
fn payload_length(head: &[u8]) -> Option<usize> {
    let length = u32::from_le_bytes(*head.first_chunk()?) as usize;
    let possible = match head.get(HEAD - 1)? {
        1 => length > 0,
        2 => length > 0 && length.is_multiple_of(ROW),
        5 => length > 1 && are_rows(length - 1, head.get(HEAD).copied().unwrap_or_default()),
        3 => length == 0,
        4 => length == 1,
        6 => length == TIMED_ANSWER,
        _ => false,
    };
    (possible && length <= MOST_PAYLOAD).then_some(length)
}

/// Finds whole frames behind damage. Each follows the digest that stands before it.
struct Search<'a> {
    bytes: &'a [u8],
    /// Bytes that may still be hashed: bytes made to look like frames at every place would take
    /// for ever.
    left: usize,
}

impl<'a> Search<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, left: bytes.len().saturating_mul(MOST_SEARCHED) + MOST_PAYLOAD }
    }

    /// Where the next whole frame begins, at `from` or behind it.
    fn whole_from(&mut self, from: usize) -> Option<usize> {
        for at in from.max(DIGEST)..self.bytes.len() {
            let (before, bytes) = self.bytes.split_at(at);
            let Some(length) = payload_length(bytes) else { continue };
            if bytes.len() < HEAD + length + DIGEST || self.left < length {
                continue;
            }
            self.left -= length;
            if before.last_chunk().is_some_and(|chain| first(bytes, *chain).is_some()) {
                return Some(at);
            }
        }
        None
    }
}

/// The frame that fills `span`, which is damaged: by its length or kind, which the span tells, or
/// by one bit of its payload, which is found by trying each. The digest proves the right one.
fn mend(span: &[u8], chain: Chain) -> Option<(Frame, Chain)> {
    let (body, stored) = span.split_at_checked(span.len().checked_sub(DIGEST)?)?;
    let length = body.len().checked_sub(HEAD).filter(|length| *length <= MOST_PAYLOAD)?;
    let stored: &Chain = stored.first_chunk()?;
    let as_long = [&u32::try_from(length).ok()?.to_le_bytes(), &body[HEAD - 1..]].concat();
    let mended = [1, 2, 3, 4, 5, 6].into_iter().find_map(|kind| {
        let body = [&as_long[..HEAD - 1], &[kind], &as_long[HEAD..]].concat();
        verified(&body, stored, chain)
    });
    // The search is quadratic: every bit costs a digest of the whole.
    let is_short = length.saturating_mul(length) * BITS <= MOST_TRIED;
    // Where the head is wrong as well, one flipped bit is not all; and zeros are no digest, but
    // what was never synced.
    if mended.is_some() || as_long != body || !is_short || *stored == Chain::default() {
        return mended;
    }
    let mut tried = as_long;
    (HEAD * BITS..tried.len() * BITS).find_map(|bit| {
        tried[bit / BITS] ^= 1 << (bit % BITS);
        let right = verified(&tried, stored, chain);
        tried[bit / BITS] ^= 1 << (bit % BITS);
        right
    })
}

fn parse(kind: u8, payload: &[u8]) -> Option<Frame> {
    match (kind, payload) {
        (1, json) => from_json(std::str::from_utf8(json).ok()?).ok().map(Frame::Header),
        (2, rows) if rows.len() % ROW == 0 => {
            Some(Frame::Rows(rows.chunks_exact(ROW).filter_map(row).collect()))
        }
        (5, [channels, rows @ ..]) => {
            let length = row_length(*channels).filter(|length| rows.len() % length == 0)?;
            Some(Frame::Rows(rows.chunks_exact(length).filter_map(row).collect()))
        }
        (3, []) => Some(Frame::End),
        (4, [value]) => Some(Frame::Answer(Given { value: i16::from(*value), time_ms: None })),
        (6, bytes) => {
            let (value, time_ms) = bytes.split_first_chunk::<2>()?;
            let time_ms = u32::from_le_bytes(time_ms.try_into().ok()?);
            let time_ms = Some(time_ms).filter(|time_ms| *time_ms != NO_TIME);
            Some(Frame::Answer(Given { value: i16::from_le_bytes(*value), time_ms }))
        }
        _ => None,
    }
}

fn digest(chain: Chain, body: &[u8]) -> Chain {
    *blake3::Hasher::new().update(&chain).update(body).finalize().as_bytes()
}

/// Bytes of a row with so many channels; `None` if no sample has as many.
fn row_length(channels: u8) -> Option<usize> {
    let channels = usize::from(channels);
    (1..=MOST_CHANNELS).contains(&channels).then_some(ROW + VALUE * channels)
}

/// Whether so many bytes can be rows with so many channels. No channel is what an append shows that
/// was not finished: with any number then.
fn are_rows(length: usize, channels: u8) -> bool {
    let mut possible = if channels == 0 { 1..=MOST_CHANNELS as u8 } else { channels..=channels };
    possible.any(|channels| row_length(channels).is_some_and(|row| length.is_multiple_of(row)))
}

/// Kind and payload of a frame of rows. All have as many channels as the first: a device gives its
/// own always.
fn rows_payload(rows: &[Sample]) -> (u8, Vec<u8>) {
    let channels = rows.first().map_or(0, |row| row.extra.values().len());
    if channels == 0 {
        return (2, rows.iter().flat_map(row_bytes).collect());
    }
    // At most `MOST_CHANNELS`.
    let mut payload = vec![u8::try_from(channels).unwrap_or(u8::MAX)];
    for row in rows {
        payload.extend(row_bytes(row));
        let values = row.extra.values().iter().copied().chain(std::iter::repeat(0.0));
        payload.extend(values.take(channels).flat_map(f64::to_le_bytes));
    }
    (5, payload)
}

fn row_bytes(s: &Sample) -> Vec<u8> {
    let bits = u8::from(s.t_device_s.is_some())
        | u8::from(s.force_age_s.is_some()) << 1
        | u8::from(s.theta_raw.is_some()) << 2;
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
    [s.theta_raw.unwrap_or(0), s.flags.0]
        .iter()
        .for_each(|v| bytes.extend_from_slice(&v.to_le_bytes()));
    bytes
}

fn row(bytes: &[u8]) -> Option<Sample> {
    let (bits, rest) = bytes.split_first()?;
    let (floats, rest) = rest.split_first_chunk::<{ 9 * 8 }>()?;
    let (counts, channels) = rest.split_first_chunk::<{ 2 * 2 }>()?;
    let floats: [[u8; 8]; 9] = floats.as_chunks::<8>().0.try_into().ok()?;
    let [t_s, t_device_s, theta_rad, theta_dot_rad_s, force_ex_n, ..] =
        floats.map(f64::from_le_bytes);
    let [.., motor_v, brake_v, force_age_s, force_cmd_n] = floats.map(f64::from_le_bytes);
    let counts: [[u8; 2]; 2] = counts.as_chunks::<2>().0.try_into().ok()?;
    let [theta_raw, flags] = counts.map(u16::from_le_bytes);
    let (channels, _) = channels.as_chunks::<VALUE>();
    let channels: Vec<f64> = channels.iter().map(|value| f64::from_le_bytes(*value)).collect();
    Some(Sample {
        t_s,
        t_device_s: (bits & 1 != 0).then_some(t_device_s),
        theta_rad,
        theta_dot_rad_s,
        force_ex_n,
        voltages: Voltages { motor_v, brake_v },
        force_age_s: (bits & 2 != 0).then_some(force_age_s),
        force_cmd_n,
        theta_raw: (bits & 4 != 0).then_some(theta_raw),
        flags: Flags(flags),
        extra: Extra::new(&channels),
    })
}

/// How a digest ends that was not synced, on a file system that shows zeros then; one in 65,536
/// others does.
const UNSYNCED: [u8; 2] = [0; 2];

/// Whether what follows the last whole frame, from this byte of the file on, is no more than one
/// unfinished append: a frame that passes the end of the file, or one that ends in zeros or lacks a
/// sector, which some file systems show where data were not synced. A length is believed only where
/// a frame can have it.
fn is_unfinished(rest: &[u8], at: usize) -> bool {
    let written = rest.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    if written < HEAD || lacks_sector(rest, at) {
        return rest.len() <= HEAD + MOST_PAYLOAD + DIGEST;
    }
    payload_length(rest).is_some_and(|length| {
        let end = HEAD + length + DIGEST;
        rest.len() < end || (rest.len() == end && rest.ends_with(&UNSYNCED))
    })
}

/// Whether a sector of bytes that begin here in their file was not written: no frame has as many
/// zeros, but for the few bytes of it that lie in its first or last sector.
fn lacks_sector(bytes: &[u8], at: usize) -> bool {
    let (first, rest) = bytes.split_at((at.next_multiple_of(SECTOR) - at).min(bytes.len()));
    let mut sectors = std::iter::once(first).chain(rest.chunks(SECTOR));
    sectors.any(|sector| !sector.is_empty() && sector.iter().all(|byte| *byte == 0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::{meta, rows};
    use rayon::prelude::*;

    fn frames() -> Vec<Frame> {
        let file = [("device".to_owned(), "none".to_owned())].into();
        let mut whole = rows(2, 3);
        whole[1].t_device_s = Some(-1.5);
        whole[2] =
            Sample { force_age_s: None, theta_raw: None, flags: Flags(u16::MAX), ..whole[2] };
        let header = Frame::Header(Header { meta: meta(2), file, protocol: Protocol::default() });
        let mut more = rows(5, 2);
        more[0].extra = Extra::new(&[0.25, -1e9]);
        more[1].extra = Extra::new(&[f64::MIN_POSITIVE, 0.0]);
        let rows = [rows(0, 2), whole, more].map(Frame::Rows);
        std::iter::once(header)
            .chain(rows)
            .chain([Frame::End, Frame::Answer(Given { value: 4, time_ms: None })])
            .collect()
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

    fn found(frames: &[Frame]) -> Decoded {
        Decoded { frames: frames.to_vec(), ..Decoded::default() }
    }

    #[test]
    fn frames_come_back_as_they_were_written() {
        let (bytes, _) = encoded(&frames());
        assert_eq!(decode(&bytes), found(&frames()));
    }

    #[test]
    fn cut_anywhere_every_whole_frame_is_there_and_the_rest_is_one_unfinished_append() {
        let (bytes, ends) = encoded(&frames());
        for cut in 0..bytes.len() {
            let whole = ends.iter().rposition(|end| *end <= cut).unwrap();
            let expect = |unfinished| Decoded { unfinished, ..found(&frames()[..whole]) };
            assert_eq!(decode(&bytes[..cut]), expect(cut - ends[whole]), "{cut}");
            // Where the length was written and the rest of the append was not, it may be zeros.
            let zeros = [&bytes[..cut], &vec![0; ends[whole + 1] - cut]].concat();
            let decoded = decode(&zeros);
            let but_for_a_bit_of_digest = Decoded { mended: 1, ..found(&frames()[..=whole]) };
            let expected = expect(ends[whole + 1] - ends[whole]);
            assert!(decoded == expected || decoded == but_for_a_bit_of_digest, "{cut}");
        }
    }

    #[test]
    fn no_flipped_bit_costs_a_frame() {
        let (bytes, _) = encoded(&frames());
        (0..bytes.len() * BITS).into_par_iter().for_each(|bit| {
            let mut bad = bytes.clone();
            bad[bit / BITS] ^= 1 << (bit % BITS);
            assert_eq!(decode(&bad), Decoded { mended: 1, ..found(&frames()) }, "bit {bit}");
        });
    }

    #[test]
    fn no_flipped_bit_costs_a_row_of_a_long_journal_either() {
        let batches = (0..100).map(|i| Frame::Rows(rows(2 * i, 2)));
        let all: Vec<Frame> = frames()[..1].iter().cloned().chain(batches).collect();
        let (bytes, _) = encoded(&all);
        (0..10_000_u32).into_par_iter().for_each(|i| {
            let drawn = u64::from_le_bytes(
                *blake3::hash(&i.to_le_bytes()).as_bytes().first_chunk().unwrap(),
            );
            let bit = drawn as usize % (bytes.len() * BITS);
            let mut bad = bytes.clone();
            bad[bit / BITS] ^= 1 << (bit % BITS);
            assert_eq!(decode(&bad), Decoded { mended: 1, ..found(&all) }, "bit {bit}");
        });
    }

    #[test]
    fn what_is_damaged_beyond_mending_hides_nothing_behind_it() {
        let (bytes, ends) = encoded(&frames());
        for from in 0..bytes.len() - 4 {
            let mut bad = bytes.clone();
            bad[from..from + 4].iter_mut().for_each(|byte| *byte ^= 0xa5);
            let decoded = decode(&bad);
            let hit = |i: usize| ends[i] < from + 4 && from < ends[i + 1];
            let spared = |i: &usize| !hit(*i);
            let whole: Vec<Frame> = (0..5).filter(spared).map(|i| frames()[i].clone()).collect();
            // A head alone can be mended; what was hit otherwise is gone, and nothing else is, but
            // for a frame whose digest is the one that was hit and the frame behind it,
            // which nothing vouches for.
            let kept = |frame: &Frame| decoded.frames.contains(frame);
            let lost = whole.iter().filter(|frame| !kept(frame)).count();
            let in_digest = (0..5).any(|i| hit(i) && from + 4 > ends[i + 1] - DIGEST);
            assert!(lost <= usize::from(in_digest), "{from}: {lost} lost");
            assert!(decoded.frames.iter().all(|frame| frames().contains(frame)), "{from}");
            assert_eq!(decoded.unfinished, 0, "{from}: damage is no unfinished append");
        }
    }

    #[test]
    fn a_length_that_no_frame_has_is_not_believed() {
        let (bytes, ends) = encoded(&frames());
        let mut bad = bytes.clone();
        bad[ends[1] + 3] = 0xff; // 4 GB of rows
        bad[ends[1] + 40] ^= 0xff; // beyond mending
        let decoded = decode(&bad);
        assert_eq!(decoded.frames, [&frames()[..1], &frames()[2..]].concat());
        assert_eq!(decoded.damaged, ends[2] - ends[1]);
        let last = [&bytes[..ends[4]], &[0xff; 4], &[2; 90]].concat();
        assert_eq!(decode(&last).damaged, 94, "at the end it is no unfinished append either");
    }

    #[test]
    fn bytes_that_look_like_frames_at_every_place_take_no_longer_than_others() {
        let looks = [&(77 * 10_000_u32).to_le_bytes()[..], &[2]].concat().repeat(400_000);
        let mut search = Search::new(&looks);
        assert_eq!(search.whole_from(1), None);
        assert!(search.left < MOST_PAYLOAD, "all that it may hash was hashed");
    }

    #[test]
    fn a_frame_that_is_missing_or_out_of_its_place_is_noticed() {
        let (bytes, ends) = encoded(&frames());
        let missing = [&bytes[..ends[1]], &bytes[ends[2]..]].concat();
        let decoded = decode(&missing);
        assert_eq!(decoded.frames, [&frames()[..1], &frames()[3..]].concat());
        // What followed the missing one has no digest before it.
        assert_eq!(decoded.damaged, ends[3] - ends[2]);
    }
}
