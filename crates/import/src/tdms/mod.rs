//! TDMS, LabVIEW's binary measurement files: channels in groups, written segment by segment.
//!
//! Source of the format: National Instruments, "TDMS File Format Internal Structure" (2024). The index file
//! beside one (`.tdms_index`) is never read: it may be older than the file.

mod scale;
mod segments;
#[cfg(test)]
pub(super) mod tests;

use super::limits::{MOST_TEXT, Take, check_columns, check_name, check_rows};
use super::spelling::shown;
use super::table::{Cells, Declared, Number, Table, listed};
use arrow::array::{Float64Builder, LargeStringBuilder};
use scale::Scales;
use segments::{INCREMENT, Kind, OFFSET, Object, Property, Reader, START, Stretch};
use std::path::Path;
use zwidth_store::StoreError;

const REMEDY: &str = "copy the file again, or write its numbers as CSV (UTF-8) in LabVIEW";
/// The column of times, before those of the channels.
const TIME: &str = "time_s";
/// What converts a file that is not read; `tests/interop/foreign.py` tries it.
const CONVERT: &str = "convert it: python -c \"import sys, nptdms; \
     nptdms.TdmsFile.read(sys.argv[1])[sys.argv[2]].as_dataframe(time_index=True).to_csv(sys.argv[3])\" IN.tdms GROUP OUT.csv";

/// When the values of a channel were, by its properties.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Timing {
    increment: f64,
    /// The time of its first value; 0 where none is named.
    offset: f64,
    /// When that was, ns since 1904.
    start: Option<i128>,
}

/// Reads the channels of a group by name, or, of a file with several groups of which none is named, those of all by
/// `group/channel`. Their time comes first, if the channels that are taken have one in common.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    group: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let unreadable =
        |why: &str| StoreError::new(path, format!("not a readable TDMS file: {why}"), REMEDY);
    if !bytes.starts_with(segments::TAG) {
        return Err(unreadable("it does not begin with 'TDSm'"));
    }
    let segments = segments::read(bytes).map_err(|why| match why.as_str() {
        segments::DAQMX => StoreError::new(path, why, CONVERT),
        why => unreadable(why),
    })?;
    let objects = &segments.objects;
    let channels = objects.iter().filter(|object| object.path.len() == 2 && object.kind.is_some());
    let mut groups: Vec<&str> = Vec::new();
    for channel in channels.clone() {
        if !groups.contains(&channel.path[0].as_str()) {
            groups.push(&channel.path[0]);
        }
    }
    if groups.is_empty() {
        let lost = segments.lost.as_ref().map(|lost| format!(": {lost}")).unwrap_or_default();
        return Err(unreadable(&format!("no channel has values{lost}")));
    }
    if let Some(group) = group.filter(|group| !groups.contains(group)) {
        let list = listed(groups.iter().map(|group| format!("'{}'", shown(group))));
        let what =
            format!("there is no group '{}' with channels; the file has {list}", shown(group));
        let remedy = "set group in [file] to a group of the file";
        return Err(StoreError::new(path, what, remedy));
    }
    let by_path = group.is_none() && groups.len() > 1;
    let channels: Vec<&Object> =
        channels.filter(|channel| group.is_none_or(|group| channel.path[0] == group)).collect();
    check_columns(path, channels.len() + 1)?;

    let mut table = Table { names: Some(vec![TIME.to_owned()]), ..Table::default() };
    table.columns.push(Cells::Unread);
    table.lost = segments.lost;
    let mut timed: Vec<(&Object, Result<Timing, String>)> = Vec::new();
    for (i, channel) in channels.iter().enumerate() {
        let name = if by_path { channel.path.join("/") } else { channel.path[1].clone() };
        check_name(path, &name)?;
        if let Some(Property::Text(unit)) = channel.properties.get("unit_string") {
            let declared = Declared { unit: unit.clone(), is_type: false };
            table.units.insert(i + 1, declared);
        }
        let is_taken = take.wants(i + 1, Some(&name));
        // Texts and moments have times of their own, if any.
        let is_timed = matches!(channel.kind, Some(Kind::Number(..) | Kind::Bool));
        if is_timed && take.is_mapped(i + 1, Some(&name)) {
            timed.push((channel, timing(channel)));
        }
        table.names.get_or_insert_default().push(name);
        if !is_taken {
            table.columns.push(Cells::Unread);
            continue;
        }
        if channel.kind == Some(Kind::Moment) {
            let declared = Declared { unit: "ns".to_owned(), is_type: true };
            table.units.insert(i + 1, declared);
        }
        if channel.timed_anew {
            let name = shown(&channel.path[1]);
            table.doubts.push(format!(
                "'{name}' begins anew within the file (its times are given twice): between is a gap that no column shows"
            ));
        }
        let of = |path: &[String]| {
            objects.iter().find(|object| object.path == path).map(|object| &object.properties)
        };
        // A scale may be named by the channel, its group, or the file.
        let scales = [&channel.path[..], &channel.path[..1], &[]].into_iter();
        let scales = scales
            .filter_map(of)
            .map(Scales::of)
            .find(|scales| scales.as_ref().map_or(true, |scales| !scales.is_empty()));
        let cells = match scales.unwrap_or_else(|| Ok(Scales::default())) {
            Ok(scales) => cells(path, bytes, channel, &scales, take)?,
            Err(why) => Cells::Other(why),
        };
        table.columns.push(cells);
    }
    if take.wants(0, Some(TIME)) {
        table.columns[0] = times(path, &timed, take)?;
        let unit = timed.first().and_then(|(channel, _)| channel.properties.get("wf_xunit_string"));
        if let Some(Property::Text(unit)) =
            unit.filter(|unit| **unit != Property::Text(String::new()))
        {
            table.units.insert(0, Declared { unit: unit.clone(), is_type: false });
        }
    }
    Ok(table)
}

/// When a channel's values were; `Err` says why that is not known.
fn timing(channel: &Object) -> Result<Timing, String> {
    let number = |key: &str| match channel.properties.get(key) {
        Some(Property::Number(value)) => Some(*value),
        _ => None,
    };
    let increment = number(INCREMENT).filter(|increment| increment.is_finite() && *increment > 0.0);
    let increment = increment.ok_or_else(|| {
        let name = shown(&channel.path[1]);
        format!(
            "'{name}' has no {INCREMENT}; name the channel of times in [time], or set rate_hz there"
        )
    })?;
    let start = match channel.properties.get(START) {
        Some(Property::Moment(start)) => Some(*start),
        _ => None,
    };
    Ok(Timing { increment, offset: number(OFFSET).unwrap_or(0.0), start })
}

/// The times that the channels have in common; else why there are none: a channel of another rate is never put on the
/// times of the first.
fn times(
    path: &Path,
    timed: &[(&Object, Result<Timing, String>)],
    take: &Take,
) -> Result<Cells, StoreError> {
    let mut common: Option<(&Object, Timing)> = None;
    for (channel, timing) in timed {
        let timing = match timing {
            Ok(timing) => *timing,
            Err(why) => return Ok(Cells::Other(why.clone())),
        };
        if let Some((first, other)) = common.filter(|(_, other)| *other != timing) {
            let [a, b] = [first, *channel].map(|one| shown(&one.path.join("/")).into_owned());
            return Ok(Cells::Other(format!(
                "'{a}' and '{b}' have not the same times ({}; {}), and no channel is put on the times of another; take \
                 those of one rate",
                in_words(other),
                in_words(timing)
            )));
        }
        common = common.or(Some((channel, timing)));
    }
    let Some((channel, timing)) = common else {
        return Ok(Cells::Other("no channel is taken whose times they could be".to_owned()));
    };
    let rows = channel.len();
    check_rows(path, rows)?;
    take.room(path, rows)?;
    let times = (0..rows).map(|i| Some(timing.offset + i as f64 * timing.increment));
    Ok(Cells::Numbers(times.collect()))
}

fn in_words(timing: Timing) -> String {
    let start = timing.start.map(|ns| format!(", begun at {:.3} s", ns as f64 * 1e-9));
    format!(
        "{} Hz from {} s on{}",
        1.0 / timing.increment,
        timing.offset,
        start.unwrap_or_default()
    )
}

/// The values of a channel, scaled.
fn cells(
    path: &Path,
    bytes: &[u8],
    channel: &Object,
    scales: &Scales,
    take: &Take,
) -> Result<Cells, StoreError> {
    let rows = channel.len();
    check_rows(path, rows)?;
    let damaged =
        || StoreError::new(path, "a channel's values are not where they should be", REMEDY);
    let kind = channel.kind.unwrap_or(Kind::Other("without a type", 0));
    let (number, size) = match kind {
        Kind::Other(what, _) => return Ok(Cells::Other(format!("it is a channel {what}"))),
        Kind::Text => return texts(path, bytes, channel, take),
        Kind::Moment => {
            take.room(path, rows)?;
            let mut moments = Vec::with_capacity(rows);
            for stretch in &channel.stretches {
                let read = |bytes: &[u8]| {
                    let moment = Reader { bytes, at: 0, big: stretch.big }.moment().ok()?;
                    moments.push(Some(moment));
                    Some(())
                };
                each(bytes, stretch, 16, read).ok_or_else(damaged)?;
            }
            return Ok(Cells::whole(moments.into_iter()));
        }
        Kind::Bool => (super::table::NumberKind::Unsigned, 1),
        Kind::Number(number, size) => (number, size),
    };
    take.room(path, rows)?;
    let mut numbers = Float64Builder::with_capacity(rows);
    for stretch in &channel.stretches {
        let number = Number { kind: number, size, big: stretch.big };
        let mut append = |count: f64| {
            numbers.append_value(if scales.is_empty() { count } else { scales.apply(count) });
        };
        if stretch.next_value != size {
            let read = |bytes: &[u8]| {
                append(number.read(bytes));
                Some(())
            };
            each(bytes, stretch, size, read).ok_or_else(damaged)?;
            continue;
        }
        for chunk in 0..stretch.chunks {
            let first = stretch.first + chunk * stretch.next_chunk;
            let end = stretch.values.checked_mul(size).and_then(|length| first.checked_add(length));
            let values = end.and_then(|end| bytes.get(first..end)).ok_or_else(damaged)?;
            number.read_each(values, &mut append);
        }
    }
    Ok(Cells::Numbers(numbers.finish()))
}

/// Gives the bytes of each value of a stretch; nothing where one does not lie in the file.
fn each(
    bytes: &[u8],
    stretch: &Stretch,
    size: usize,
    mut value: impl FnMut(&[u8]) -> Option<()>,
) -> Option<()> {
    for chunk in 0..stretch.chunks {
        let first = stretch.first + chunk * stretch.next_chunk;
        for i in 0..stretch.values {
            let at = first + i * stretch.next_value;
            value(bytes.get(at..at + size)?)?;
        }
    }
    Some(())
}

/// The texts of a channel: of each chunk first where each of them ends, then all of them.
fn texts(path: &Path, bytes: &[u8], channel: &Object, take: &Take) -> Result<Cells, StoreError> {
    let damaged =
        || StoreError::new(path, "a channel's texts are not where they should be", REMEDY);
    take.room(path, channel.len())?;
    let mut built = LargeStringBuilder::new();
    let mut length = 0;
    for stretch in &channel.stretches {
        for chunk in 0..stretch.chunks {
            let first = stretch.first + chunk * stretch.next_chunk;
            let texts = stretch.values.checked_mul(4).and_then(|ends| first.checked_add(ends));
            let texts = texts.ok_or_else(damaged)?;
            let mut ends = Reader { bytes, at: first, big: stretch.big };
            let mut begin = texts;
            for _ in 0..stretch.values {
                let end = ends.word().ok().and_then(|end| texts.checked_add(end as usize));
                let text = end.and_then(|end| bytes.get(begin..end)).ok_or_else(damaged)?;
                begin += text.len();
                length += text.len();
                if length > MOST_TEXT {
                    return Err(super::limits::too_much_text(path));
                }
                let text = String::from_utf8_lossy(text);
                built.append_option(Some(text).filter(|text| !text.is_empty()));
            }
        }
    }
    Ok(Cells::Text(built.finish()))
}
