//! The chunks of an XDF file, one after the other; damaged ones are skipped.

/// First bytes of a file.
pub(super) const MAGIC: &[u8] = b"XDF:";
/// The content of a boundary: from it on a reader that lost its way goes on.
pub(super) const BOUNDARY: [u8; 16] = [
    0x43, 0xa5, 0x46, 0xdc, 0xcb, 0xf5, 0x41, 0x0f, 0xb3, 0x0e, 0xd5, 0x46, 0x73, 0x83, 0xcb, 0xe4,
];

/// The kind of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tag {
    FileHeader,
    StreamHeader,
    Samples,
    ClockOffset,
    Boundary,
    StreamFooter,
}

impl Tag {
    fn of(number: u16) -> Option<Self> {
        use Tag::{Boundary, ClockOffset, FileHeader, Samples, StreamFooter, StreamHeader};
        let all = [FileHeader, StreamHeader, Samples, ClockOffset, Boundary, StreamFooter];
        all.get(usize::from(number).checked_sub(1)?).copied()
    }
}

/// A chunk, or as much of it as is there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk<'a> {
    pub(super) tag: Tag,
    /// The number of its stream; 0 where it is of the whole file.
    pub(super) stream: u32,
    pub(super) content: &'a [u8],
}

/// Bytes from the front on; `None` where too few are left.
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl<'a> Bytes<'a> {
    pub(super) fn take(&mut self, n: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n)?;
        self.0 = rest;
        Some(taken)
    }

    pub(super) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub(super) fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    /// A number of one, four or eight bytes, with their count before it.
    pub(super) fn length(&mut self) -> Option<u64> {
        match self.take(1)? {
            [1] => self.take(1).map(|byte| u64::from(byte[0])),
            [4] => self.array().map(|four| u64::from(u32::from_le_bytes(four))),
            [8] => self.array().map(u64::from_le_bytes),
            _ => None,
        }
    }
}

/// Bytes that cannot be read.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Lost {
    /// Stretches of them, and bytes in all.
    pub(super) stretches: usize,
    pub(super) bytes: usize,
    /// The place of the first stretch, from 0.
    pub(super) first: usize,
    /// Whether the last one reaches the end of the file.
    pub(super) at_end: bool,
}

/// Gives every chunk to `visit`, which says whether its content is sound; what cannot be read.
///
/// A chunk is read up to the next boundary at most, and each byte once: its claims cost nothing.
pub(super) fn walk<'a>(bytes: &'a [u8], visit: &mut dyn FnMut(Chunk<'a>) -> bool) -> Lost {
    let mut at = MAGIC.len();
    let mut lost = Lost::default();
    let mut boundary = next_boundary(bytes, at);
    while at < bytes.len() {
        // Searched once per boundary, not per chunk: a file without any is gone through once.
        if boundary < at {
            boundary = next_boundary(bytes, at);
        }
        let head = head(bytes, at);
        let end = head.map_or(at, |head| head.end);
        let is_boundary = head.is_some_and(|head| head.tag == Tag::Boundary);
        // A boundary's own chunk ends behind its content.
        let limit = if is_boundary { bytes.len() } else { boundary.min(bytes.len()) };
        let is_sound = head.is_some_and(|Head { tag, stream, from, end }| {
            let content = bytes.get(from.min(limit)..end.min(limit)).unwrap_or_default();
            let is_whole = end <= limit && from <= end;
            visit(Chunk { tag, stream, content }) && is_whole
        });
        if is_sound {
            at = end;
            continue;
        }
        let from = at;
        at = boundary.saturating_add(BOUNDARY.len()).min(bytes.len());
        if lost.stretches == 0 {
            lost.first = from;
        }
        lost.stretches += 1;
        lost.bytes += at - from;
        lost.at_end = at == bytes.len();
    }
    lost
}

/// The place of the next boundary's content; past the end if there is none.
fn next_boundary(bytes: &[u8], from: usize) -> usize {
    let place = bytes[from..].windows(BOUNDARY.len()).position(|window| window == BOUNDARY);
    place.map_or(usize::MAX, |place| from + place)
}

/// The head of a chunk, before its content.
#[derive(Debug, Clone, Copy)]
struct Head {
    tag: Tag,
    stream: u32,
    /// Where the content begins, and where the chunk says that it ends.
    from: usize,
    end: usize,
}

fn head(bytes: &[u8], at: usize) -> Option<Head> {
    let mut rest = Bytes(bytes.get(at..)?);
    let length = usize::try_from(rest.length()?).ok()?;
    let end = (bytes.len() - rest.0.len()).checked_add(length)?;
    let tag = Tag::of(u16::from_le_bytes(rest.array()?))?;
    let stream = match tag {
        Tag::FileHeader | Tag::Boundary => 0,
        // The others begin with the number of their stream.
        Tag::StreamHeader | Tag::Samples | Tag::ClockOffset | Tag::StreamFooter => {
            u32::from_le_bytes(rest.array()?)
        }
    };
    Some(Head { tag, stream, from: bytes.len() - rest.0.len(), end })
}
