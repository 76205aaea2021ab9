//! XDF, the format of LabStreamingLayer's recorder: streams of samples, each with its own clock.
//!
//! Source of the format: XDF 1.0 (github.com/sccn/xdf/wiki/Specifications). A damaged file is read
//! as far as possible, and losses are reported; `xdf` 0.1 skips a truncated chunk without a
//! message.

mod chunks;
mod clock;
mod header;
mod jitter;
mod samples;
#[cfg(test)]
pub(super) mod tests;

use super::limits::{MOST_COLUMNS, Take};
use super::spelling::shown;
use super::table::{Cells, Declared, Table, listed};
use arrow::array::Float64Array;
use chunks::{Bytes, Lost, MAGIC, Tag, walk};
use clock::Offset;
pub(super) use clock::{Synchronised, synchronise};
pub(super) use header::Header;
use header::sample_count;
use jitter::remove_jitter;
use samples::Samples;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::StoreError;

/// The times of an XDF stream that are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum XdfClock {
    /// The times of its samples as recorded, on the stream's own clock.
    Recorded,
    /// The first of them, and from there on by the rate that the stream names.
    Nominal,
    /// The times on the recorder's clock.
    #[default]
    Corrected,
}

const REMEDY: &str = "copy the file again, or record with LabRecorder";
/// The column of times, before those of the channels.
const TIME: &str = "time_s";
/// Comparisons of clocks that are read of a stream: LabRecorder makes one in five seconds, so that
/// these are of four days.
const MOST_OFFSETS: usize = 1 << 16;
/// How far a recording's length by its rate and by its times may lie apart, as a part of it and in s.
const MOST_OFF: f64 = 0.01;
const MOST_OFF_S: f64 = 0.1;

/// The parts of a stream that are read before its samples.
pub(super) struct Stream {
    header: Result<Header, String>,
    pub(super) offsets: Vec<Offset>,
    /// The samples that its footer counts.
    counted: Option<u64>,
    pub(super) has_samples: bool,
}

impl Stream {
    /// Its name; none where its header cannot be read.
    pub(super) fn name(&self) -> &str {
        self.header.as_ref().map_or("", |header| &header.name)
    }
}

/// The samples of a stream as they were recorded.
pub(super) struct Recorded<'a> {
    pub(super) header: &'a Header,
    /// On the stream's own clock, s.
    pub(super) times: Vec<f64>,
    /// Its channels that are taken.
    pub(super) cells: Vec<Cells>,
    /// What is to be told of it.
    pub(super) told: Vec<String>,
    /// What of it could not be read.
    pub(super) lost: Option<String>,
}

/// Reads a stream: its times, then its channels. `wanted` names it, by its name or its number.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    wanted: Option<&str>,
    clock: XdfClock,
    dejitter: bool,
    take: &Take,
) -> Result<Table, StoreError> {
    let streams = streams_of(path, bytes)?;
    let number = choose(path, &streams, wanted)?;
    let stream = &streams[&number];
    let Recorded { header, mut times, cells, told, lost } =
        recorded(path, bytes, number, stream, take)?;
    let mut table = Table { told, lost, ..Table::default() };
    match clock {
        XdfClock::Recorded => {
            table.told.push("times are on the stream's own clock, as recorded".to_owned());
        }
        XdfClock::Nominal => {
            let doubt = nominal_times(&mut times, header.rate_hz)
                .map_err(|what| StoreError::new(path, what, "choose another clock in [time]"))?;
            table.doubts.extend(doubt);
        }
        XdfClock::Corrected => {
            if stream.offsets.is_empty() {
                let what = "no clock offsets were recorded: times are on the stream's own clock";
                table.told.push(what.to_owned());
            }
            let interval_s = if header.rate_hz > 0.0 { 1.0 / header.rate_hz } else { 0.0 };
            let Synchronised { all_used, doubts } =
                synchronise(&mut times, &stream.offsets, interval_s);
            if !all_used {
                let what = "clock offsets of one and the same time are of no use: times are on the stream's own clock";
                table.told.push(what.to_owned());
            }
            table.doubts.extend(doubts);
        }
    }
    if dejitter && header.rate_hz > 0.0 && !header.may_drop {
        table.doubts.extend(remove_jitter(&mut times, header.rate_hz));
    }
    let named = header.channels.iter().map(|channel| channel.name.clone());
    for (i, channel) in header.channels.iter().enumerate().filter(|(_, one)| !one.unit.is_empty()) {
        table.units.insert(i + 1, Declared { unit: channel.unit.clone(), is_type: false });
    }
    // The format has times in s.
    table.units.insert(0, Declared { unit: "s".to_owned(), is_type: true });
    table.names = Some(std::iter::once(TIME.to_owned()).chain(named).collect());
    let time = if take.wants(0, Some(TIME)) {
        Cells::Numbers(Float64Array::from(times))
    } else {
        Cells::Unread
    };
    table.columns = std::iter::once(time).chain(cells).collect();
    Ok(table)
}

/// Every stream of a file, by its number, without its samples.
///
/// # Errors
/// It is no XDF file, or has too much of something.
pub(super) fn streams_of(path: &Path, bytes: &[u8]) -> Result<BTreeMap<u32, Stream>, StoreError> {
    if !bytes.starts_with(MAGIC) {
        let what = match bytes.starts_with(b"\x1f\x8b") {
            true => "not an XDF file: it is compressed with gzip (.xdfz)",
            false => "not an XDF file: it does not begin with 'XDF:'",
        };
        return Err(StoreError::new(path, what, "unpack it with gunzip, or set format in [file]"));
    }
    streams(bytes).map_err(|why| StoreError::new(path, why, REMEDY))
}

/// The samples of the stream of that number.
///
/// # Errors
/// A header that cannot be read; more than is read of one file.
pub(super) fn recorded<'a>(
    path: &Path,
    bytes: &[u8],
    number: u32,
    stream: &'a Stream,
    take: &Take,
) -> Result<Recorded<'a>, StoreError> {
    let header = stream.header.as_ref().map_err(|why| {
        let what = format!("the header of stream {number} cannot be read: {why}");
        StoreError::new(path, what, REMEDY)
    })?;
    let mut samples = Samples::new(path, header, take);
    let lost = walk(bytes, &mut |chunk| {
        // Chunks of other streams are sound without being read.
        chunk.tag != Tag::Samples || chunk.stream != number || samples.add(header, chunk.content)
    });
    let damaged = damage(&lost);
    if let Some(error) = samples.over.take() {
        return Err(error);
    }
    let lost = samples.lost(stream.counted, damaged.is_some());
    let told = damaged.into_iter().chain(samples.notes(stream.counted)).collect();
    let times = std::mem::take(&mut samples.times);
    Ok(Recorded { header, times, cells: samples.cells().collect(), told, lost })
}

/// A note on bytes that hold no whole chunk.
fn damage(lost: &Lost) -> Option<String> {
    let Lost { stretches, bytes, first, at_end } = *lost;
    let from = first + 1;
    let place = match (stretches, at_end) {
        (0, _) => return None,
        (1, true) => format!("cut off or damaged: its last {bytes} bytes hold"),
        (1, false) => {
            format!("damaged: {bytes} bytes from byte {from} up to the next boundary hold")
        }
        (n, _) => format!("damaged in {n} places: {bytes} bytes, the first at byte {from}, hold"),
    };
    Some(format!("the file is {place} no whole chunk; their samples are read as far as they go"))
}

/// Every stream of the file, by its number.
fn streams(bytes: &[u8]) -> Result<BTreeMap<u32, Stream>, String> {
    let mut streams: BTreeMap<u32, Stream> = BTreeMap::new();
    let mut too_many = None;
    walk(bytes, &mut |chunk| {
        if chunk.tag == Tag::StreamHeader {
            let xml = String::from_utf8_lossy(chunk.content);
            let header = header::header(&xml);
            if streams.len() == MOST_COLUMNS {
                too_many = Some(format!("the file has more than {MOST_COLUMNS} streams"));
            } else {
                let new = Stream { header, offsets: Vec::new(), counted: None, has_samples: false };
                // The first header of a number counts.
                streams.entry(chunk.stream).or_insert(new);
            }
            return true;
        }
        let Some(stream) = streams.get_mut(&chunk.stream) else { return true };
        match chunk.tag {
            Tag::Samples => stream.has_samples = true,
            Tag::ClockOffset => {
                let mut content = Bytes(chunk.content);
                let Some(offset) = content.f64().zip(content.f64()) else { return false };
                if stream.offsets.len() == MOST_OFFSETS {
                    too_many = Some(format!("a stream has more than {MOST_OFFSETS} clock offsets"));
                } else {
                    stream.offsets.push(offset);
                }
            }
            Tag::StreamFooter => {
                stream.counted = sample_count(&String::from_utf8_lossy(chunk.content));
            }
            _ => {}
        }
        true
    });
    too_many.map_or(Ok(streams), Err)
}

/// The stream of that name or number; without one the only stream with samples.
pub(super) fn choose(
    path: &Path,
    streams: &BTreeMap<u32, Stream>,
    wanted: Option<&str>,
) -> Result<u32, StoreError> {
    let meant = streams.iter().filter(|(number, stream)| match wanted {
        Some(wanted) => stream.name() == wanted || number.to_string() == wanted,
        None => stream.has_samples,
    });
    let meant: Vec<u32> = meant.map(|(number, _)| *number).collect();
    if let [number] = meant[..] {
        return Ok(number);
    }
    let list = streams.iter().map(|(number, one)| format!("{number} '{}'", shown(one.name())));
    let list = listed(list);
    let n = meant.len();
    let what = match (wanted, n) {
        (_, _) if streams.is_empty() => "the file has no stream".to_owned(),
        (Some(wanted), 0) => {
            format!("there is no stream '{}'; the file has {list}", shown(wanted))
        }
        (Some(wanted), _) => {
            format!("{n} streams are called '{}'; the file has {list}", shown(wanted))
        }
        (None, 0) => format!("no stream has samples; the file has {list}"),
        (None, _) => format!("{n} streams have samples: {list}"),
    };
    let remedy = "set stream in [file] to a stream's name or number";
    Err(StoreError::new(path, what, if streams.is_empty() { REMEDY } else { remedy }))
}

/// Puts the samples at the rate that the stream names, from the first on; what that hides.
fn nominal_times(times: &mut [f64], rate_hz: f64) -> Result<Option<String>, String> {
    if rate_hz <= 0.0 {
        return Err("the stream names no rate, which clock = \"nominal\" asks for".to_owned());
    }
    // A single sample has no length to compare.
    let [first, .., last] = *times else { return Ok(None) };
    for (i, time) in times.iter_mut().enumerate() {
        *time = first + i as f64 / rate_hz;
    }
    let nominal_s = (times.len() - 1) as f64 / rate_hz;
    let recorded_s = last - first;
    let is_off = (recorded_s - nominal_s).abs() > MOST_OFF_S.max(MOST_OFF * nominal_s);
    Ok(is_off.then(|| {
        format!(
            "at {rate_hz} Hz its samples take {nominal_s:.2} s, and by their times {recorded_s:.2} s: samples are missing, or the \
             rate is another"
        )
    }))
}
