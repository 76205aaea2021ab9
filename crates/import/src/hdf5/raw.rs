//! The bytes of an HDF5 file, and the messages of its objects' headers, as far as the library does
//! not read them.
//!
//! Source: HDF5 File Format Specification 3.0, II.A (superblock), IV.A (headers).

use super::super::limits::MOST_NAME;
use super::super::table::little;
use std::collections::BTreeSet;
use std::ops::Range;

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
const CONTINUATION: u16 = 0x10;

/// A message of an object's header.
pub(super) struct Message {
    pub(super) kind: u16,
    /// Where its content begins.
    pub(super) from: usize,
    /// In a header of the second version: the bytes whose checksum stands behind them.
    pub(super) summed: Option<Range<usize>>,
}

/// The bytes of a file, and how its addresses and lengths are written.
pub(super) struct Raw<'a> {
    pub(super) bytes: &'a [u8],
    /// Where its superblock stands, from which addresses are counted.
    pub(super) base: usize,
    pub(super) address_size: usize,
    pub(super) length_size: usize,
}

impl<'a> Raw<'a> {
    /// A file, and where the header of its root group stands.
    pub(super) fn open(bytes: &'a [u8]) -> Option<(Self, usize)> {
        // At the beginning, or behind a block of the user's: 512 bytes, or a power of two of them.
        let places = std::iter::successors(Some(512_usize), |place| place.checked_mul(2));
        let base = std::iter::once(0)
            .chain(places.take_while(|place| *place < bytes.len()))
            .find(|place| bytes[*place..].starts_with(SIGNATURE))?;
        let version = *bytes.get(base + 8)?;
        let (sizes, root) = match version {
            0 => (13, 24),
            1 => (13, 28),
            2 | 3 => (9, 12),
            _ => return None,
        };
        let address_size = usize::from(*bytes.get(base + sizes)?);
        let length_size = usize::from(*bytes.get(base + sizes + 1)?);
        if !(1..=8).contains(&address_size) || !(1..=8).contains(&length_size) {
            return None;
        }
        let raw = Self { bytes, base, address_size, length_size };
        // Behind other addresses: those of the file's parts, in old files also that of the root's name.
        let before = if version < 2 { 5 } else { 3 };
        let root = raw.address(base + root + before * address_size)?;
        Some((raw, root))
    }

    pub(super) fn number(&self, at: usize, size: usize) -> Option<usize> {
        little(self.bytes, at, size)
    }

    /// An address, as a place in the bytes; nothing if it is past their end.
    pub(super) fn address(&self, at: usize) -> Option<usize> {
        let place = self.number(at, self.address_size)?.checked_add(self.base);
        place.filter(|place| *place < self.bytes.len())
    }

    pub(super) fn has(&self, at: usize, signature: &[u8]) -> bool {
        self.bytes.get(at..).is_some_and(|bytes| bytes.starts_with(signature))
    }

    /// The text up to a zero.
    pub(super) fn text(&self, at: usize) -> Option<String> {
        let bytes = self.bytes.get(at..)?;
        let bytes = &bytes[..bytes.len().min(MOST_NAME + 1)];
        let end = bytes.iter().position(|byte| *byte == 0)?;
        Some(String::from_utf8_lossy(&bytes[..end]).into_owned())
    }

    /// The messages of an object's header and of the blocks in which it goes on, as far as they can be read.
    /// `seen` has the places of those that were gone through: each byte is looked at once, whatever leads to it.
    pub(super) fn messages(&self, header: usize, seen: &mut BTreeSet<usize>) -> Vec<Message> {
        let mut all = Vec::new();
        if seen.insert(header) {
            let _: Option<()> = self.add_messages(header, seen, &mut all);
        }
        all
    }

    fn add_messages(
        &self,
        at: usize,
        seen: &mut BTreeSet<usize>,
        all: &mut Vec<Message>,
    ) -> Option<()> {
        let is_new = self.has(at, b"OHDR");
        // Of a header of the second version, whether messages have the order of their creation too.
        let mut ordered = 0;
        let mut blocks = Vec::new();
        if is_new {
            let flags = self.number(at + 5, 1)?;
            let times = if flags & 0x20 != 0 { 16 } else { 0 };
            let attributes = if flags & 0x10 != 0 { 4 } else { 0 };
            ordered = if flags & 0x04 != 0 { 2 } else { 0 };
            let size_at = at + 6 + times + attributes;
            let size_size = 1 << (flags & 3);
            let from = size_at + size_size;
            let size = self.number(size_at, size_size)?;
            blocks.push((at, from..from.checked_add(size)?));
        } else if self.number(at, 1)? == 1 {
            // Twelve bytes of head, padded to a multiple of eight.
            let size = self.number(at + 8, 4)?;
            blocks.push((at, at + 16..(at + 16).checked_add(size)?));
        }
        let head = if is_new { 4 + ordered } else { 8 };
        while let Some((begin, block)) = blocks.pop() {
            let mut at = block.start;
            while at.checked_add(head)? <= block.end {
                let (kind, size) = match is_new {
                    true => (self.number(at, 1)?, self.number(at + 1, 2)?),
                    false => (self.number(at, 2)?, self.number(at + 2, 2)?),
                };
                let from = at + head;
                let kind = u16::try_from(kind).ok()?;
                at = from + size;
                all.push(Message { kind, from, summed: is_new.then_some(begin..block.end) });
                if kind == CONTINUATION {
                    let place = self.address(from)?;
                    let length = self.number(from + self.address_size, self.length_size)?;
                    let end = place.checked_add(length)?;
                    // Between its signature and its checksum.
                    let around = if is_new { 4 } else { 0 };
                    if seen.insert(place) {
                        blocks.push((place, place + around..end.saturating_sub(around)));
                    }
                }
            }
        }
        Some(())
    }
}
