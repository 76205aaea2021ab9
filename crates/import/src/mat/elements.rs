//! The elements of a MAT file of version 5, and the numbers in them.

use super::super::limits::MOST_NAME;
use super::super::table::{Number, NumberKind};
use super::mi;
use flate2::bufread::ZlibDecoder;
use libdeflater::Decompressor;
use std::io::Read as _;

/// Elements begin at multiples of this many bytes.
pub(super) const ALIGN: usize = 8;
/// Deflate makes at most 258 bytes of two bits: RFC 1951, 3.2.5.
const MOST_EXPANSION: usize = 1032;
/// Most bytes that a small element carries in its tag.
const SMALL: usize = 4;

/// The array type of a structure, and that of an object of a class (a table, a datetime).
pub(super) const STRUCT: u32 = 2;
pub(super) const OPAQUE: u32 = 17;

/// Flag of a complex array, in the array flags.
pub(super) const COMPLEX: u32 = 0x0800;

/// The values of a variable, not decoded yet.
pub(super) struct Numbers<'a> {
    written: Number,
    pub(super) data: &'a [u8],
}

/// Stands for the error of the budget, which takes its place.
pub(super) const TOO_MUCH: &str = "it has more values than are read";

/// The first bytes of a compressed element, at most `most`, which grow as they come.
pub(super) fn beginning(data: &[u8], most: u64) -> Option<Vec<u8>> {
    let mut plain = Vec::new();
    ZlibDecoder::new(data).take(most).read_to_end(&mut plain).ok()?;
    Some(plain)
}

/// A compressed element that is `size` bytes long, if it is and their checksum is right.
pub(super) fn unpack(data: &[u8], size: u64) -> Option<Vec<u8>> {
    let size = usize::try_from(size).ok()?;
    // No memory is taken for a size that cannot be true.
    if size / MOST_EXPANSION > data.len() {
        return None;
    }
    let mut plain = vec![0; size];
    let unpacked = Decompressor::new().zlib_decompress(data, &mut plain).ok()?;
    (unpacked == size).then_some(plain)
}

/// The elements of a stretch of bytes, one after the other.
pub(super) struct Elements<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) big: bool,
}

impl<'a> Elements<'a> {
    /// The element behind so many.
    pub(super) fn nth(&mut self, n: usize) -> Option<(u32, &'a [u8])> {
        for _ in 0..n {
            self.next()?;
        }
        self.next()
    }

    /// The next element's type and data; `None` where it is cut off.
    pub(super) fn next(&mut self) -> Option<(u32, &'a [u8])> {
        let first = word(self.bytes, self.big)?;
        // A small element has its length in the upper half of the word that holds its type.
        let small = (first >> 16) as usize;
        let kind = first & 0xffff;
        if small > 0 {
            let data = self.bytes.get(4..2 * SMALL)?.get(..small)?;
            self.bytes = &self.bytes[2 * SMALL..];
            return Some((kind, data));
        }
        let size = word(&self.bytes[4..], self.big)? as usize;
        let end = ALIGN.checked_add(size)?;
        let data = self.bytes.get(ALIGN..end)?;
        // Compressed elements follow each other without padding; the last one of all may lack it.
        let next = if first == mi::COMPRESSED { end } else { end.next_multiple_of(ALIGN) };
        self.bytes = self.bytes.get(next..).unwrap_or_default();
        Some((first, data))
    }
}

/// The word at the beginning.
pub(super) fn word(bytes: &[u8], big: bool) -> Option<u32> {
    let word = *bytes.first_chunk::<4>()?;
    Some(if big { u32::from_be_bytes(word) } else { u32::from_le_bytes(word) })
}

/// A name, cut to the longest that is read.
pub(super) fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes.get(..MOST_NAME).unwrap_or(bytes)).into_owned()
}

/// A whole number that counts something.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(super) fn whole(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0).then_some(value as usize)
}

/// MATLAB stores whole numbers in the smallest type that holds them.
impl<'a> Numbers<'a> {
    /// Those of an element; nothing if its type is none of numbers.
    pub(super) fn new(kind: u32, data: &'a [u8], big: bool) -> Option<Self> {
        let (kind, size) = match kind {
            mi::INT8 => (NumberKind::Signed, 1),
            mi::UINT8 => (NumberKind::Unsigned, 1),
            mi::INT16 => (NumberKind::Signed, 2),
            mi::UINT16 => (NumberKind::Unsigned, 2),
            mi::INT32 => (NumberKind::Signed, 4),
            mi::UINT32 => (NumberKind::Unsigned, 4),
            mi::SINGLE => (NumberKind::Float, 4),
            mi::DOUBLE => (NumberKind::Float, 8),
            mi::INT64 => (NumberKind::Signed, 8),
            mi::UINT64 => (NumberKind::Unsigned, 8),
            _ => return None,
        };
        Some(Self { written: Number { kind, size, big }, data })
    }

    /// The number of values.
    pub(super) fn count(&self) -> usize {
        self.data.len() / self.written.size
    }

    /// `n` values from the one at `from` on.
    pub(super) fn values(&self, from: usize, n: usize) -> Option<Vec<f64>> {
        let width = self.written.size;
        let data =
            self.data.get(from.checked_mul(width)?..from.checked_add(n)?.checked_mul(width)?)?;
        let mut values = Vec::with_capacity(n);
        self.written.read_each(data, |value| values.push(value));
        Some(values)
    }
}
