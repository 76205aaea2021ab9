//! ZIP archives, stored or deflated: what `numpy.savez` writes, and workbooks.
//!
//! Source of the format: PKWARE, APPNOTE.TXT 6.3.10. Entries are read by the central directory at
//! the end of the file; a claim in it never exceeds the bytes that are there.

use super::limits::{MOST_COLUMNS, MOST_NAME, MOST_UNPACKED};
use super::table::little;
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
const LOCKED: usize = 1;
/// How an entry is packed: as it is, or deflated.
const STORED: usize = 0;
const DEFLATED: usize = 8;

/// An entry of the directory.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    method: usize,
    crc: usize,
    packed: usize,
    size: usize,
    at: usize,
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
    let count = little(bytes, end + 10, 2).ok_or(CUT)?;
    let mut at = little(bytes, end + 16, 4).ok_or(CUT)?;
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
    let name = little(head, 28, 2)?;
    let extra = little(head, 30, 2)?;
    let remark = little(head, 32, 2)?;
    let name_at = at + ENTRY_LENGTH;
    if name > MOST_NAME {
        return Some(Err(format!("a name has {name} bytes, and at most {MOST_NAME} are read")));
    }
    let name_bytes = bytes.get(name_at..name_at + name)?;
    let name = String::from_utf8_lossy(name_bytes).into_owned();
    if little(head, 8, 2)? & LOCKED != 0 {
        return Some(Err(format!("'{name}' is locked by a password")));
    }
    let entry = Entry {
        name,
        method: little(head, 10, 2)?,
        crc: little(head, 16, 4)?,
        packed: little(head, 20, 4)?,
        size: little(head, 24, 4)?,
        at: little(head, 42, 4)?,
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
    let is_whole = content.len() == entry.size && crc.sum() as usize == entry.crc;
    if is_whole { Ok(content) } else { Err(damaged()) }
}

/// The packed bytes of an entry, behind a head of its own.
fn packed<'a>(bytes: &'a [u8], entry: &Entry) -> Option<&'a [u8]> {
    let head = bytes.get(entry.at..entry.at.checked_add(LOCAL_LENGTH)?);
    let head = head.filter(|head| head.starts_with(LOCAL))?;
    let varies = little(head, 26, 2)? + little(head, 28, 2)?;
    let from = entry.at.checked_add(LOCAL_LENGTH + varies)?;
    bytes.get(from..from.checked_add(entry.packed)?)
}
