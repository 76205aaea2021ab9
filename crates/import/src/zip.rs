//! ZIP archives, stored or deflated: what `numpy.savez` writes, and workbooks.
//!
//! Source of the format: PKWARE, APPNOTE.TXT 6.3.10. Entries are read by the central directory at
//! the end of the file; a claim in it never exceeds the bytes that are there.

use super::limits::{MOST_COLUMNS, MOST_NAME, MOST_UNPACKED};
use flate2::Crc;
use flate2::read::DeflateDecoder;
use std::io::Read as _;

/// First bytes of the directory's end, of an entry of the directory, and of an entry.
const END: &[u8] = b"PK\x05\x06";
const ENTRY: &[u8] = b"PK\x01\x02";
const LOCAL: &[u8] = b"PK\x03\x04";
/// Their lengths, without what varies.
const END_LENGTH: usize = 22;
const ENTRY_LENGTH: usize = 46;
const LOCAL_LENGTH: usize = 30;
/// The end has a remark behind it of at most so many bytes.
const MOST_REMARK: usize = 1 << 16;
/// The flag of an entry that a password locks.
const LOCKED: u16 = 1;
/// How an entry is packed: as it is, or deflated.
const STORED: u16 = 0;
const DEFLATED: u16 = 8;

/// An entry of the directory.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    method: u16,
    crc: u32,
    packed: usize,
    size: usize,
    at: usize,
}

/// The number of two or four bytes at a place.
fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..at.checked_add(2)?)?.try_into().ok().map(u16::from_le_bytes)
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let four: [u8; 4] = bytes.get(at..at.checked_add(4)?)?.try_into().ok()?;
    usize::try_from(u32::from_le_bytes(four)).ok()
}

const CUT: &str = "its directory is cut off or damaged";

/// The entries of an archive, in the order of its directory.
pub(super) fn entries(bytes: &[u8]) -> Result<Vec<Entry>, String> {
    let from = bytes.len().saturating_sub(END_LENGTH + MOST_REMARK);
    let tail = &bytes[from..];
    // The last one counts: packed content may have the same bytes by chance.
    let end = (0..=tail.len().saturating_sub(END_LENGTH)).rev();
    let end = end.into_iter().find(|at| tail[*at..].starts_with(END));
    let end = from + end.ok_or("it is not an archive, or was cut off: it has no directory")?;
    let count = usize::from(u16_at(bytes, end + 10).ok_or(CUT)?);
    let mut at = u32_at(bytes, end + 16).ok_or(CUT)?;
    if count > MOST_COLUMNS {
        return Err(format!("it has {count} parts, and at most {MOST_COLUMNS} are read"));
    }
    let mut entries = Vec::new();
    for _ in 0..count {
        let (entry, next) = entry(bytes, at).ok_or(CUT)??;
        entries.push(entry);
        at = next;
    }
    Ok(entries)
}

/// The entry of the directory at a place, and where the next one stands.
fn entry(bytes: &[u8], at: usize) -> Option<Result<(Entry, usize), String>> {
    let head =
        bytes.get(at..at.checked_add(ENTRY_LENGTH)?).filter(|head| head.starts_with(ENTRY))?;
    let [name, extra, remark] = [28, 30, 32].map(|at| u16_at(head, at).map(usize::from));
    let name = name?;
    let extra = extra?;
    let remark = remark?;
    let name_at = at + ENTRY_LENGTH;
    if name > MOST_NAME {
        return Some(Err(format!("a name has {name} bytes, and at most {MOST_NAME} are read")));
    }
    let name_bytes = bytes.get(name_at..name_at + name)?;
    let name = String::from_utf8_lossy(name_bytes).into_owned();
    if u16_at(head, 8)? & LOCKED != 0 {
        return Some(Err(format!("'{name}' is locked by a password")));
    }
    let crc = u32::from_le_bytes(head.get(16..20)?.try_into().ok()?);
    let entry = Entry {
        name,
        method: u16_at(head, 10)?,
        crc,
        packed: u32_at(head, 20)?,
        size: u32_at(head, 24)?,
        at: u32_at(head, 42)?,
    };
    Some(Ok((entry, name_at + name_bytes.len() + extra + remark)))
}

/// The content of an entry; `unpacked` counts the bytes of all that were unpacked.
pub(super) fn unpack(bytes: &[u8], entry: &Entry, unpacked: &mut u64) -> Result<Vec<u8>, String> {
    let name = &entry.name;
    let damaged = || format!("'{name}' is cut off or damaged");
    let data = packed(bytes, entry).ok_or_else(damaged)?;
    let room = MOST_UNPACKED.saturating_sub(*unpacked);
    let mut content = Vec::new();
    // One more than there is room for: whether there is more than that does not matter.
    let read = match entry.method {
        STORED => data.take(room + 1).read_to_end(&mut content),
        DEFLATED => DeflateDecoder::new(data).take(room + 1).read_to_end(&mut content),
        other => {
            return Err(format!(
                "'{name}' is packed by method {other}, and only stored and deflated ones are read"
            ));
        }
    };
    read.map_err(|_| damaged())?;
    *unpacked += content.len() as u64;
    if *unpacked > MOST_UNPACKED {
        return Err(format!("its parts that are read unpack to more than {MOST_UNPACKED} bytes"));
    }
    let mut crc = Crc::new();
    crc.update(&content);
    if content.len() == entry.size && crc.sum() == entry.crc { Ok(content) } else { Err(damaged()) }
}

/// The packed bytes of an entry, behind a head of its own.
fn packed<'a>(bytes: &'a [u8], entry: &Entry) -> Option<&'a [u8]> {
    let head = bytes.get(entry.at..entry.at.checked_add(LOCAL_LENGTH)?);
    let head = head.filter(|head| head.starts_with(LOCAL))?;
    let varies = usize::from(u16_at(head, 26)?) + usize::from(u16_at(head, 28)?);
    let from = entry.at.checked_add(LOCAL_LENGTH + varies)?;
    bytes.get(from..from.checked_add(entry.packed)?)
}
