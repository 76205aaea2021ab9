//! C3D, the files of motion capture: points in space, and channels of an analog converter at a rate of their own.
//!
//! Source of the format: "The C3D File Format: A Technical User Guide" (Motion Lab Systems, 2021). By hand: `c3dio` 0.8
//! panics on some damaged files, and of one that is cut off it says nothing.

mod parameters;
#[cfg(test)]
pub(super) mod tests;

use super::limits::{MOST_TEXT, Take, check_columns, check_name, check_rows, too_much_text};
use super::spelling::shown;
use super::table::{Cells, ColumnRef, Declared, Table};
use arrow::array::{Float64Builder, LargeStringArray};
use parameters::{BLOCK, Parameters, Processor};
use std::path::Path;
use zwidth_store::StoreError;

/// The second byte of a file, and of its parameters.
pub(super) const KEY: u8 = 0x50;
const REMEDY: &str = "copy the file again, or export it again from the program that made it";
/// The column of times, before those of a part.
const TIME: &str = "time_s";
/// The parts of a file, as `group` in [file] names them.
const POINTS: &str = "points";
const ANALOG: &str = "analog";
const EVENTS: &str = "events";
/// What stands in the header where it has events, and the most that it has.
const HAS_EVENTS: u16 = 12345;
const MOST_EVENTS: usize = 18;

/// What a file says of its frames.
struct Frames {
    processor: Processor,
    /// Bytes of a number: of whole numbers 2, with decimals 4.
    size: usize,
    begin: usize,
    /// Bytes of a frame: those of its points, then those of its analog samples.
    bytes: usize,
    points: usize,
    /// Channels, and samples of each in a frame.
    channels: usize,
    samples: usize,
    /// The number of frames that are there.
    count: usize,
    /// The number of the first, from 1.
    first: usize,
    rate_hz: f64,
    /// m or mm a whole number.
    scale: f64,
    /// Whether whole numbers of analog channels carry no sign.
    unsigned: bool,
}

/// A column: how many of its values a frame has, and each of them.
enum Column {
    /// A coordinate (0 to 2) of a point.
    Point(usize, usize),
    /// A channel, and what makes its quantity of a number: minus the first, times the second.
    Analog(usize, f64, f64),
}

/// Reads the points, the analog channels or the events of a file. Without a part its points are `points/NAME.x` and its
/// channels `analog/NAME`, and by their own names where there are only these or only those.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    part: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let unreadable =
        |why: &str| StoreError::new(path, format!("not a readable C3D file: {why}"), REMEDY);
    let (block, key) = (bytes.first().copied().unwrap_or(0), bytes.get(1).copied());
    if key != Some(KEY) || bytes.len() < BLOCK {
        return Err(unreadable("its first block is not that of a C3D file"));
    }
    let parameters = Parameters::read(bytes, block).map_err(|why| unreadable(&why))?;
    if part == Some(EVENTS) {
        return events(path, bytes, &parameters, take);
    }
    let (frames, lost) = frames(bytes, &parameters).map_err(|why| unreadable(&why))?;
    let parts = [(POINTS, frames.points), (ANALOG, frames.channels * frames.samples.min(1))];
    let mut there = parts.iter().filter(|(_, count)| *count > 0).map(|(part, _)| *part);
    let part = match (part, (there.next(), there.next())) {
        (Some(part), (first, second)) if ![first, second].contains(&Some(part)) => {
            let have = [first, second].into_iter().flatten().collect::<Vec<_>>().join(" and ");
            let what = format!("the file has no '{}'; it has {have}", shown(part));
            let remedy = "set group in [file] to points, analog or events";
            return Err(StoreError::new(path, what, remedy));
        }
        (Some(part), _) => Some(part),
        (None, (only, None)) => only,
        (None, _) => None,
    };
    let named = |group: &str, name: &str| match part {
        Some(_) => name.to_owned(),
        None => format!("{group}/{name}"),
    };
    // Before any is named: a damaged file of a few bytes claims 65,535 points.
    let of_points = if part == Some(ANALOG) { 0 } else { 3 * frames.points };
    let of_channels = if part == Some(POINTS) || frames.samples == 0 { 0 } else { frames.channels };
    check_columns(path, 1 + of_points + of_channels)?;
    let mut columns = Vec::with_capacity(of_points + of_channels);
    if of_points > 0 {
        let labels = parameters.long_texts("POINT:LABELS");
        for point in 0..frames.points {
            let label = label(&labels, point, "point");
            for (axis, letter) in ["x", "y", "z"].iter().enumerate() {
                let name = named(POINTS, &format!("{label}.{letter}"));
                columns.push((name, Column::Point(point, axis)));
            }
        }
    }
    if of_channels > 0 {
        let labels = parameters.long_texts("ANALOG:LABELS");
        let scales = parameters.long_numbers("ANALOG:SCALE", true);
        let offsets = parameters.long_numbers("ANALOG:OFFSET", !frames.unsigned);
        let general = parameters.number("ANALOG:GEN_SCALE").unwrap_or(1.0);
        for channel in 0..frames.channels {
            let scale = scales.get(channel).copied().unwrap_or(1.0) * general;
            let offset = offsets.get(channel).copied().unwrap_or(0.0);
            let name = named(ANALOG, &label(&labels, channel, "channel"));
            columns.push((name, Column::Analog(channel, offset, scale)));
        }
    }
    let mut table = Table { names: Some(vec![TIME.to_owned()]), lost, ..Table::default() };
    table.columns.push(Cells::Unread);
    table.units.insert(0, Declared { unit: "s".to_owned(), is_type: true });
    let units = parameters.texts("POINT:UNITS");
    let analog_units = parameters.long_texts("ANALOG:UNITS");
    let mut taken = Vec::new();
    for (place, (name, column)) in columns.iter().enumerate() {
        check_name(path, name)?;
        let unit = match column {
            Column::Point(..) => units.first(),
            Column::Analog(channel, ..) => analog_units.get(*channel),
        };
        if let Some(unit) = unit.filter(|unit| !unit.is_empty()) {
            table.units.insert(place + 1, Declared { unit: unit.clone(), is_type: false });
        }
        table.names.get_or_insert_default().push(name.clone());
        if !take.wants(place + 1, Some(name)) {
            table.columns.push(Cells::Unread);
            continue;
        }
        let a_frame = match column {
            Column::Point(..) => 1,
            Column::Analog(..) => frames.samples,
        };
        if take.is_mapped(place + 1, Some(name)) && !taken.contains(&a_frame) {
            taken.push(a_frame);
        }
        let rows = frames.count.saturating_mul(a_frame);
        check_rows(path, rows)?;
        take.room(path, rows)?;
        table.columns.push(
            cells(bytes, &frames, column).ok_or_else(|| unreadable("its frames are cut off"))?,
        );
    }
    // Where no column is taken, the times are those of the frames.
    let a_frame = taken.first().copied().unwrap_or(1);
    if take.wants(0, Some(TIME)) {
        table.columns[0] = match taken.len() {
            0 | 1 => times(path, &frames, a_frame, take)?,
            _ => Cells::Other(
                "points and analog channels have not the same rate, and none is put on the times of another: take \
                 those of one, by group in [file]"
                    .to_owned(),
            ),
        };
    }
    let analog_hz = parameters.number("ANALOG:RATE").filter(|rate| *rate > 0.0);
    let by_frames_hz = frames.rate_hz * frames.samples as f64;
    if let Some(rate) = analog_hz
        && part != Some(POINTS)
        && (rate - by_frames_hz).abs() > 1e-3 * by_frames_hz
    {
        table.doubts.push(format!(
            "the file says that its analog channels come at {rate} Hz, and that each frame has as many as at {by_frames_hz} Hz: \
             times are by the latter"
        ));
    }
    if frames.first > 1 {
        table.told.push(format!(
            "its first frame is the {}th of the recording: times count from there",
            frames.first
        ));
    }
    // A parameter is a column of the same text throughout, where it is asked for.
    for column in &take.columns {
        if let ColumnRef::Name(name) = column
            && name.contains(':')
            && !table.names.iter().flatten().any(|other| other == name)
            && let Some(text) = parameters.in_words(name)
        {
            let rows = frames.count.saturating_mul(a_frame);
            check_rows(path, rows)?;
            take.room(path, rows)?;
            if text.len().saturating_mul(rows) > MOST_TEXT {
                return Err(too_much_text(path));
            }
            let text = Some(text).filter(|text| !text.is_empty());
            let cells: LargeStringArray = (0..rows).map(|_| text.as_deref()).collect();
            table.columns.push(Cells::Text(cells));
            table.names.get_or_insert_default().push(name.clone());
        }
    }
    Ok(table)
}

/// A label of a list, or one of its number where it has none.
fn label(labels: &[String], place: usize, what: &str) -> String {
    let label = labels.get(place).filter(|label| !label.is_empty());
    label.cloned().unwrap_or_else(|| format!("{what}_{}", place + 1))
}

/// What the header and the parameters say of the frames, and what of them is not there.
fn frames(bytes: &[u8], parameters: &Parameters) -> Result<(Frames, Option<String>), String> {
    let processor = parameters.processor;
    let word = |number: usize| {
        bytes.get(2 * number - 2..).and_then(|rest| processor.word(rest)).map_or(0, usize::from)
    };
    let float = |number: usize| {
        bytes.get(2 * number - 2..).and_then(|rest| processor.float(rest)).map_or(0.0, f64::from)
    };
    let points = parameters.number("POINT:USED").map_or_else(|| word(2), |used| used as usize);
    let (all, first, last, samples) = (word(3), word(4).max(1), word(5), word(10));
    let channels = all.checked_div(samples).unwrap_or(0);
    if points == 0 && channels == 0 {
        return Err("it has neither points nor analog channels".to_owned());
    }
    let scale = parameters.number("POINT:SCALE").unwrap_or_else(|| float(7));
    let size = if scale < 0.0 { 4 } else { 2 };
    let frame = (4 * points + channels * samples) * size;
    // A word counts to 65,535, and longer files say it elsewhere.
    let long = |name: &str| match parameters.numbers(name, false)[..] {
        [low, high, ..] => Some(low + 65_536.0 * high),
        _ => None,
    };
    let actual = long("TRIAL:ACTUAL_END_FIELD")
        .map(|end| end - long("TRIAL:ACTUAL_START_FIELD").unwrap_or(1.0) + 1.0);
    let longer =
        [actual, parameters.number("POINT:LONG_FRAMES"), parameters.number("POINT:FRAMES")];
    let longer =
        longer.into_iter().flatten().find(|longer| *longer >= 1.0).map(|longer| longer as usize);
    let by_header = (last + 1).saturating_sub(first);
    let claimed = match longer {
        Some(longer) if last >= usize::from(u16::MAX) || last < first => longer,
        _ => by_header,
    };
    let begin = (word(9).max(1) - 1) * BLOCK;
    let there = bytes.len().saturating_sub(begin) / frame;
    let lost = (there < claimed)
        .then(|| format!("it holds {there} of the {claimed} frames that it names"));
    let rate_hz =
        parameters.number("POINT:RATE").filter(|rate| *rate > 0.0).unwrap_or_else(|| float(11));
    if !(rate_hz.is_finite() && rate_hz > 0.0) {
        return Err("it names no rate".to_owned());
    }
    let unsigned = parameters
        .texts("ANALOG:FORMAT")
        .first()
        .is_some_and(|format| format.eq_ignore_ascii_case("unsigned"));
    let count = claimed.min(there);
    let frames = Frames {
        processor,
        size,
        begin,
        bytes: frame,
        points,
        channels,
        samples,
        count,
        first,
        rate_hz,
        scale,
        unsigned,
    };
    Ok((frames, lost))
}

/// The times of so many values a frame.
fn times(path: &Path, frames: &Frames, a_frame: usize, take: &Take) -> Result<Cells, StoreError> {
    let rows = frames.count.saturating_mul(a_frame);
    check_rows(path, rows)?;
    take.room(path, rows)?;
    let rate_hz = frames.rate_hz * a_frame as f64;
    let before = (frames.first - 1) * a_frame;
    Ok(Cells::Numbers((0..rows).map(|i| Some((before + i) as f64 / rate_hz)).collect()))
}

/// The values of a column; nothing where the frames are not where they should be. A point that was not seen is missing.
fn cells(bytes: &[u8], frames: &Frames, column: &Column) -> Option<Cells> {
    let Frames { processor, size, .. } = *frames;
    let number = |at: usize, unsigned: bool| {
        let bytes = bytes.get(at..at + size)?;
        match size {
            4 => processor.float(bytes).map(f64::from),
            _ if unsigned => processor.word(bytes).map(f64::from),
            _ => processor.word(bytes).map(|word| f64::from(word as i16)),
        }
    };
    let mut built = Float64Builder::new();
    for frame in 0..frames.count {
        let begin = frames.begin + frame * frames.bytes;
        match *column {
            Column::Point(point, axis) => {
                let at = begin + 4 * point * size;
                let value = number(at + axis * size, false)?;
                // The fourth is negative where the point was not seen.
                let seen = number(at + 3 * size, false)? >= 0.0;
                let value = if size == 4 { value } else { value * frames.scale };
                built.append_option(seen.then_some(value));
            }
            Column::Analog(channel, offset, scale) => {
                for sample in 0..frames.samples {
                    let place = 4 * frames.points + sample * frames.channels + channel;
                    let count = number(begin + place * size, frames.unsigned)?;
                    built.append_value((count - offset) * scale);
                }
            }
        }
    }
    Some(Cells::Numbers(built.finish()))
}

/// The events of a file: when, their labels and what they are about, from its parameters or its header.
fn events(
    path: &Path,
    bytes: &[u8],
    parameters: &Parameters,
    take: &Take,
) -> Result<Table, StoreError> {
    let processor = parameters.processor;
    let (mut times, mut labels, mut contexts) = (Vec::new(), Vec::new(), Vec::new());
    for group in ["EVENT", "EVENTS"] {
        let found = parameters.long_numbers(&format!("{group}:TIMES"), true);
        labels.extend(parameters.long_texts(&format!("{group}:LABELS")));
        contexts.extend(parameters.long_texts(&format!("{group}:CONTEXTS")));
        // As the guide has it a time is minutes and seconds; some programs write seconds alone.
        let is_pair = labels.is_empty() || found.len() >= 2 * labels.len();
        match is_pair {
            true => times.extend(found.chunks_exact(2).map(|pair| 60.0 * pair[0] + pair[1])),
            false => times.extend(found),
        }
        if !times.is_empty() {
            break;
        }
    }
    let word = |number: usize| bytes.get(2 * number - 2..).and_then(|rest| processor.word(rest));
    if times.is_empty() && word(150) == Some(HAS_EVENTS) {
        let count = word(151).map_or(0, usize::from).min(MOST_EVENTS);
        for event in 0..count {
            let time = bytes.get(304 + 4 * event..).and_then(|rest| processor.float(rest));
            let label = bytes.get(396 + 4 * event..400 + 4 * event).unwrap_or_default();
            times.push(time.map_or(f64::NAN, f64::from));
            labels.push(String::from_utf8_lossy(label).trim_matches(['\0', ' ']).to_owned());
        }
    }
    let rows = times.len();
    check_rows(path, rows)?;
    take.room(path, 3 * rows)?;
    let texts = |list: &[String]| {
        let cells =
            (0..rows).map(|row| list.get(row).filter(|text| !text.is_empty()).map(String::as_str));
        Cells::Text(cells.collect())
    };
    Ok(Table {
        names: Some([TIME, "label", "context"].map(str::to_owned).to_vec()),
        columns: vec![
            Cells::Numbers(times.into_iter().map(Some).collect()),
            texts(&labels),
            texts(&contexts),
        ],
        ..Table::default()
    })
}
