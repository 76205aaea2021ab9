//! The records of an MCAP file, one after the other, those within chunks too.

use super::super::limits::{MOST_COLUMNS, MOST_UNPACKED};
use flate2::Crc;
use std::collections::BTreeMap;
use std::io::Read as _;

/// A file of more than [`MOST_UNPACKED`] unpacks to at most so many times its bytes.
const MOST_PACKED: u64 = 8;

/// What a file begins with, and ends with if its recorder was not killed.
pub(super) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

/// The kinds of records that are read.
mod kind {
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const DATA_END: u8 = 0x0F;
}

/// What describes the messages of channels.
#[derive(Debug, Clone, Default)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    pub(super) text: String,
}

#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub(super) schema: u16,
    pub(super) topic: String,
    pub(super) encoding: String,
}

/// One message, and when it was logged and published, ns.
pub(super) struct Message<'a> {
    pub(super) channel: u16,
    pub(super) log_time: u64,
    pub(super) publish_time: u64,
    pub(super) data: &'a [u8],
}

/// Schemas and channels by their numbers.
#[derive(Debug, Default)]
pub(super) struct Known {
    pub(super) schemas: BTreeMap<u16, Schema>,
    pub(super) channels: BTreeMap<u16, Channel>,
}

/// Reads what stands in a record.
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl<'a> Reader<'a> {
    fn take(&mut self, size: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(size)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.number().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.number().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.number().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.take(length)?).into_owned())
    }
}

/// Gives every message, in the order of the file, with the schemas and channels before it. Returns what of the file could
/// not be read, in words.
///
/// # Errors
/// That of `each`, or what nothing can be made of.
pub(super) fn walk(
    bytes: &[u8],
    known: &mut Known,
    each: &mut dyn FnMut(&Known, Message) -> Result<(), String>,
) -> Result<Option<String>, String> {
    let mut rest = Reader(bytes.get(MAGIC.len()..).unwrap_or_default());
    // As much as chunks of numbers are packed; each of them is unpacked by itself.
    let mut room = MOST_UNPACKED.max(MOST_PACKED * bytes.len() as u64);
    let mut lost = None;
    loop {
        let before = rest.0.len();
        let record = rest.take(1).zip(rest.u64());
        let record = record
            .and_then(|(kind, length)| Some((kind[0], rest.take(usize::try_from(length).ok()?)?)));
        let Some((kind, content)) = record else {
            // A recorder that was killed leaves half a record, and no footer.
            let what = format!("the file is cut off: its last {before} bytes hold no whole record");
            return Ok(if before == 0 { lost } else { Some(what) });
        };
        match kind {
            kind::CHUNK => {
                let at = bytes.len() - before;
                let records = chunk(content, &mut room)?;
                let Some(records) = records else {
                    lost = Some(format!("the chunk at byte {} is damaged", at + 1));
                    continue;
                };
                let mut within = Reader(&records);
                while let Some((kind, content)) =
                    within.take(1).zip(within.u64()).and_then(|(kind, length)| {
                        Some((kind[0], within.take(usize::try_from(length).ok()?)?))
                    })
                {
                    if record_of(kind, content, known, each)?.is_none() {
                        lost = Some(format!("a record in the chunk at byte {} is damaged", at + 1));
                    }
                }
            }
            // What follows says again where everything is.
            kind::DATA_END | kind::FOOTER => return Ok(lost),
            kind => {
                if record_of(kind, content, known, each)?.is_none() {
                    lost = Some("a record is damaged".to_owned());
                }
            }
        }
    }
}

/// Keeps a schema or a channel, and gives a message; nothing if the record is damaged.
fn record_of(
    kind: u8,
    content: &[u8],
    known: &mut Known,
    each: &mut dyn FnMut(&Known, Message) -> Result<(), String>,
) -> Result<Option<()>, String> {
    let mut reader = Reader(content);
    match kind {
        kind::SCHEMA => {
            let schema =
                (|| Some((reader.u16()?, reader.text()?, reader.text()?, reader.text()?)))();
            let Some((id, name, encoding, text)) = schema else { return Ok(None) };
            // The summary has them all again.
            known.schemas.entry(id).or_insert(Schema { name, encoding, text });
        }
        kind::CHANNEL => {
            let channel =
                (|| Some((reader.u16()?, reader.u16()?, reader.text()?, reader.text()?)))();
            let Some((id, schema, topic, encoding)) = channel else { return Ok(None) };
            known.channels.entry(id).or_insert(Channel { schema, topic, encoding });
        }
        kind::MESSAGE => {
            let head = (|| Some((reader.u16()?, reader.u32()?, reader.u64()?, reader.u64()?)))();
            let Some((channel, _, log_time, publish_time)) = head else { return Ok(None) };
            each(known, Message { channel, log_time, publish_time, data: reader.0 })?;
        }
        _ => {}
    }
    if known.schemas.len().max(known.channels.len()) > MOST_COLUMNS {
        return Err(format!("it has more than {MOST_COLUMNS} topics"));
    }
    Ok(Some(()))
}

/// The records of a chunk; nothing if it is damaged.
///
/// # Errors
/// It is packed as nothing here reads, or unpacks to too much.
fn chunk(content: &[u8], room: &mut u64) -> Result<Option<Vec<u8>>, String> {
    let mut reader = Reader(content);
    let head = (|| {
        let _times = (reader.u64()?, reader.u64()?);
        Some((reader.u64()?, reader.u32()?, reader.text()?, reader.u64()?))
    })();
    let Some((size, sum, packing, length)) = head else { return Ok(None) };
    let Some(packed) = usize::try_from(length).ok().and_then(|length| reader.take(length)) else {
        return Ok(None);
    };
    // What it claims never decides how much memory is taken: the reader stops there.
    *room = match room.checked_sub(size) {
        Some(room) if size <= MOST_UNPACKED => room,
        _ => {
            return Err(format!(
                "it unpacks to more than {MOST_UNPACKED} bytes in a chunk, or {MOST_PACKED} times its own; record to several files"
            ));
        }
    };
    let mut records = Vec::new();
    let read = match packing.as_str() {
        "" => packed.take(size).read_to_end(&mut records),
        "zstd" => zstd::stream::read::Decoder::with_buffer(packed)
            .and_then(|decoder| decoder.take(size).read_to_end(&mut records)),
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed).take(size).read_to_end(&mut records),
        other => return Err(format!("its chunks are packed by '{other}', which is not read here")),
    };
    let mut crc = Crc::new();
    crc.update(&records);
    // A sum of 0 is one that was not computed.
    let is_sound = read.is_ok() && records.len() as u64 == size && (sum == 0 || sum == crc.sum());
    Ok(is_sound.then_some(records))
}
