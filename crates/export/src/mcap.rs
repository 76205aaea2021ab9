//! MCAP (version 0 of its specification, `mcap.dev/spec`): a file for each trial, its samples as JSON
//! messages with a JSON schema, in chunks with indexes.
//!
//! A message's time is the sample's, in nanoseconds; the exact one is in the message, as `t_s`. Of a trial
//! that begins before 0, its beginning is 0.

use crate::contents::Contents;
use crate::folder::Folder;
use crate::samples::{about, number, recorded};
use crate::{ExportError, ExportedTrial};
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use zwidth_store::{Samples, Signal};

const MAGIC: [u8; 8] = [0x89, b'M', b'C', b'A', b'P', b'0', b'\r', b'\n'];
/// Bytes of messages in a chunk, about: a trial of some seconds has several, so that a reader can begin in its midst.
const CHUNK: usize = 1 << 16;
const CHANNEL: u16 = 1;
const SCHEMA: u16 = 1;

/// The records that are written, by their opcodes.
mod opcode {
    pub(super) const HEADER: u8 = 0x01;
    pub(super) const FOOTER: u8 = 0x02;
    pub(super) const SCHEMA: u8 = 0x03;
    pub(super) const CHANNEL: u8 = 0x04;
    pub(super) const MESSAGE: u8 = 0x05;
    pub(super) const CHUNK: u8 = 0x06;
    pub(super) const MESSAGE_INDEX: u8 = 0x07;
    pub(super) const CHUNK_INDEX: u8 = 0x08;
    pub(super) const STATISTICS: u8 = 0x0b;
    pub(super) const METADATA: u8 = 0x0c;
    pub(super) const METADATA_INDEX: u8 = 0x0d;
    pub(super) const SUMMARY_OFFSET: u8 = 0x0e;
    pub(super) const DATA_END: u8 = 0x0f;
}

pub(crate) fn write(
    folder: &mut Folder,
    contents: &Contents,
    software: &str,
) -> Result<(), ExportError> {
    for trial in &contents.trials {
        let path = format!("mcap/{}.mcap", trial.told());
        folder.write(&path, "samples of a trial, as MCAP", |out| {
            let samples = trial.read()?.samples;
            let mut file = Stream { out, length: 0, hasher: crc32fast::Hasher::new() };
            Ok(write_trial(&mut file, trial, &samples, contents, software)?)
        })?;
    }
    Ok(())
}

/// A file as it grows: its length, and the checksum of what was written since that was last asked for.
struct Stream<'o> {
    out: &'o mut (dyn Write + Send),
    length: u64,
    hasher: crc32fast::Hasher,
}

impl Stream<'_> {
    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.length += bytes.len() as u64;
        self.hasher.update(bytes);
        Ok(())
    }

    fn record(&mut self, code: u8, content: &[u8]) -> io::Result<()> {
        self.put(&record(code, content))
    }

    fn checksum(&mut self) -> u32 {
        std::mem::take(&mut self.hasher).finalize()
    }
}

/// A chunk that was written.
struct Chunk {
    /// Times of its first and its last message, ns.
    times: [u64; 2],
    begin: u64,
    length: u64,
    index_begin: u64,
    index_length: u64,
    size: u64,
}

fn write_trial(
    file: &mut Stream,
    trial: &ExportedTrial,
    samples: &Samples,
    contents: &Contents,
    software: &str,
) -> io::Result<()> {
    let columns: Vec<_> = recorded(samples, contents).collect();
    let times = nanoseconds(samples.get(Signal::Time).unwrap_or_default());
    file.put(&MAGIC)?;
    file.record(opcode::HEADER, &[text(""), text(software)].concat())?;
    let schema = schema_record(&columns);
    let channel = channel_record(trial);
    let mut chunks = Vec::new();
    let mut row = 0;
    while row < samples.len() {
        let first = row;
        let mut records = Vec::new();
        if first == 0 {
            records.extend(record(opcode::SCHEMA, &schema));
            records.extend(record(opcode::CHANNEL, &channel));
        }
        let mut index = Vec::new();
        while row < samples.len() && records.len() < CHUNK {
            index.extend(times[row].to_le_bytes());
            index.extend((records.len() as u64).to_le_bytes());
            let sequence = u32::try_from(row).unwrap_or(u32::MAX);
            let mut message = CHANNEL.to_le_bytes().to_vec();
            message.extend(sequence.to_le_bytes());
            message.extend(times[row].to_le_bytes());
            message.extend(times[row].to_le_bytes());
            message.extend(sample(&columns, row).into_bytes());
            records.extend(record(opcode::MESSAGE, &message));
            row += 1;
        }
        chunks.push(write_chunk(file, [times[first], times[row - 1]], &records, &index)?);
    }
    let metadata_begin = file.length;
    let said = about(trial).into_iter().map(|(key, value)| (key.to_owned(), value));
    file.record(opcode::METADATA, &[text("trial"), map(said)].concat())?;
    let metadata_length = file.length - metadata_begin;
    let data_crc = file.checksum();
    file.record(opcode::DATA_END, &data_crc.to_le_bytes())?;

    // The footer's checksum is of the summary and of the footer before it.
    file.checksum();
    let summary_begin = file.length;
    let chunk_indexes: Vec<Vec<u8>> = chunks.iter().map(chunk_index).collect();
    let place = [metadata_begin.to_le_bytes(), metadata_length.to_le_bytes()].concat();
    let mut offsets = Vec::new();
    for (code, records) in [
        (opcode::SCHEMA, vec![schema]),
        (opcode::CHANNEL, vec![channel]),
        (opcode::STATISTICS, vec![statistics(&times, chunks.len())]),
        (opcode::CHUNK_INDEX, chunk_indexes),
        (opcode::METADATA_INDEX, vec![[place, text("trial")].concat()]),
    ] {
        let begin = file.length;
        records.iter().try_for_each(|content| file.record(code, content))?;
        let place = [begin.to_le_bytes(), (file.length - begin).to_le_bytes()].concat();
        offsets.push([vec![code], place].concat());
    }
    let offsets_begin = file.length;
    offsets.iter().try_for_each(|offset| file.record(opcode::SUMMARY_OFFSET, offset))?;
    file.put(&[opcode::FOOTER])?;
    file.put(&20_u64.to_le_bytes())?;
    file.put(&summary_begin.to_le_bytes())?;
    file.put(&offsets_begin.to_le_bytes())?;
    let summary_crc = file.checksum();
    file.put(&summary_crc.to_le_bytes())?;
    file.put(&MAGIC)
}

/// The times of messages, ns, from 0 on.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // A day has 10¹⁴ ns.
fn nanoseconds(t_s: &[f64]) -> Vec<u64> {
    let begin_s = t_s.first().copied().unwrap_or_default().min(0.0);
    t_s.iter().map(|t| ((t - begin_s) * 1e9).round() as u64).collect()
}

/// Adds a chunk and its index to a file.
fn write_chunk(
    file: &mut Stream,
    times: [u64; 2],
    records: &[u8],
    index: &[u8],
) -> io::Result<Chunk> {
    let size = records.len() as u64;
    let mut content = times.map(u64::to_le_bytes).concat();
    content.extend(size.to_le_bytes());
    content.extend(crc32fast::hash(records).to_le_bytes());
    content.extend(text(""));
    content.extend(size.to_le_bytes());
    content.extend(records);
    let begin = file.length;
    file.record(opcode::CHUNK, &content)?;
    let index_begin = file.length;
    file.record(opcode::MESSAGE_INDEX, &[CHANNEL.to_le_bytes().to_vec(), array(index)].concat())?;
    let index_length = file.length - index_begin;
    Ok(Chunk { times, begin, length: index_begin - begin, index_begin, index_length, size })
}

fn chunk_index(chunk: &Chunk) -> Vec<u8> {
    let mut content = chunk.times.map(u64::to_le_bytes).concat();
    content.extend(chunk.begin.to_le_bytes());
    content.extend(chunk.length.to_le_bytes());
    let place = [CHANNEL.to_le_bytes().to_vec(), chunk.index_begin.to_le_bytes().to_vec()];
    content.extend(array(&place.concat()));
    content.extend(chunk.index_length.to_le_bytes());
    content.extend(text(""));
    content.extend(chunk.size.to_le_bytes());
    content.extend(chunk.size.to_le_bytes());
    content
}

fn statistics(times: &[u64], chunks: usize) -> Vec<u8> {
    let messages = times.len() as u64;
    let ends = [times.first(), times.last()].map(|time| time.copied().unwrap_or_default());
    let mut content = messages.to_le_bytes().to_vec();
    content.extend(1_u16.to_le_bytes()); // schemas
    content.extend(1_u32.to_le_bytes()); // channels
    content.extend(0_u32.to_le_bytes()); // attachments
    content.extend(1_u32.to_le_bytes()); // metadata
    content.extend(u32::try_from(chunks).unwrap_or(u32::MAX).to_le_bytes());
    content.extend(ends.map(u64::to_le_bytes).concat());
    content
        .extend(array(&[CHANNEL.to_le_bytes().to_vec(), messages.to_le_bytes().to_vec()].concat()));
    content
}

/// The schema of a sample: an object of numbers, each with its unit.
fn schema_record(columns: &[(&str, &str, &[f64])]) -> Vec<u8> {
    let properties: Map<String, Value> = columns
        .iter()
        .map(|(name, unit, _)| {
            ((*name).to_owned(), json!({ "type": "number", "description": unit }))
        })
        .collect();
    let schema = json!({ "title": "sample", "type": "object", "properties": properties });
    let mut content = SCHEMA.to_le_bytes().to_vec();
    content.extend(text("sample"));
    content.extend(text("jsonschema"));
    content.extend(text(&schema.to_string()));
    content
}

fn channel_record(trial: &ExportedTrial) -> Vec<u8> {
    let mut content = CHANNEL.to_le_bytes().to_vec();
    content.extend(SCHEMA.to_le_bytes());
    content.extend(text("/sample"));
    content.extend(text("json"));
    let said = about(trial).into_iter().map(|(key, value)| (key.to_owned(), value));
    content.extend(map(said));
    content
}

/// A sample as a JSON object. Names of columns need no escapes, and no number is infinite or none.
fn sample(columns: &[(&str, &str, &[f64])], row: usize) -> String {
    let fields =
        columns.iter().map(|(name, _, values)| format!("\"{name}\":{}", number(values[row])));
    format!("{{{}}}", fields.collect::<Vec<_>>().join(","))
}

fn record(code: u8, content: &[u8]) -> Vec<u8> {
    [&[code], (content.len() as u64).to_le_bytes().as_slice(), content].concat()
}

/// A text behind its length.
fn text(text: &str) -> Vec<u8> {
    array(text.as_bytes())
}

/// Bytes behind their number.
fn array(bytes: &[u8]) -> Vec<u8> {
    // None is longer than a chunk's index, of far less than 4 GiB.
    let length = u32::try_from(bytes.len()).unwrap_or(u32::MAX);
    [&length.to_le_bytes(), bytes].concat()
}

fn map(entries: impl Iterator<Item = (String, String)>) -> Vec<u8> {
    let entries = entries.flat_map(|(key, value)| [text(&key), text(&value)].concat());
    array(&entries.collect::<Vec<u8>>())
}
