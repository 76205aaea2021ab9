//! The segments of a TDMS file: what they say of each object, and where the values of its channels lie.

use super::super::limits::{MOST_COLUMNS, MOST_NAME};
use super::super::table::{Number, NumberKind};
use std::collections::{BTreeMap, HashMap};

/// The first bytes of a segment, and the bytes of its lead-in.
pub(super) const TAG: &[u8] = b"TDSm";
const LEAD_IN: usize = 28;
/// Stretches of values that are kept in mind: each segment adds one a channel.
const MOST_STRETCHES: usize = 1 << 22;

/// Bits of a segment's table of contents.
mod contents {
    pub(super) const META_DATA: u32 = 1 << 1;
    pub(super) const NEW_LIST: u32 = 1 << 2;
    pub(super) const RAW_DATA: u32 = 1 << 3;
    pub(super) const INTERLEAVED: u32 = 1 << 5;
    pub(super) const BIG_ENDIAN: u32 = 1 << 6;
    pub(super) const DAQMX: u32 = 1 << 7;
}

/// What stands where the description of an object's values begins.
mod index {
    pub(super) const NO_VALUES: u32 = 0xFFFF_FFFF;
    pub(super) const AS_BEFORE: u32 = 0;
    pub(super) const DAQMX: [u32; 2] = [0x1269, 0x126A];
}

/// How the values of a channel are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(NumberKind, usize),
    Bool,
    Text,
    /// Seconds since 1904 and fractions of 2⁻⁶⁴ s.
    Moment,
    /// Of another type, with its bytes.
    Other(&'static str, usize),
}

impl Kind {
    fn of(number: u32) -> Result<Self, String> {
        Ok(match number {
            0x01 => Self::Number(NumberKind::Signed, 1),
            0x02 => Self::Number(NumberKind::Signed, 2),
            0x03 => Self::Number(NumberKind::Signed, 4),
            0x04 => Self::Number(NumberKind::Signed, 8),
            0x05 => Self::Number(NumberKind::Unsigned, 1),
            0x06 => Self::Number(NumberKind::Unsigned, 2),
            0x07 => Self::Number(NumberKind::Unsigned, 4),
            0x08 => Self::Number(NumberKind::Unsigned, 8),
            0x09 | 0x19 => Self::Number(NumberKind::Float, 4),
            0x0A | 0x1A => Self::Number(NumberKind::Float, 8),
            0x0B | 0x1B => Self::Other("of numbers of extended precision", 16),
            0x20 => Self::Text,
            0x21 => Self::Bool,
            0x44 => Self::Moment,
            0x0008_000C => Self::Other("of complex numbers", 8),
            0x0010_000D => Self::Other("of complex numbers", 16),
            other => return Err(format!("a channel has values of an unknown type, 0x{other:X}")),
        })
    }

    /// The bytes of a value; of a text none, because each has its own.
    fn size(self) -> usize {
        match self {
            Self::Number(_, size) | Self::Other(_, size) => size,
            Self::Bool => 1,
            Self::Moment => 16,
            Self::Text => 0,
        }
    }
}

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Property {
    Number(f64),
    Text(String),
    Moment(i128),
    Other,
}

pub(super) type Properties = BTreeMap<String, Property>;

/// The file, a group, or a channel of a group.
pub(super) struct Object {
    /// Empty for the file, of one name for a group, of two for a channel.
    pub(super) path: Vec<String>,
    pub(super) properties: Properties,
    pub(super) kind: Option<Kind>,
    pub(super) stretches: Vec<Stretch>,
    /// Timing that was given anew after values had come.
    pub(super) timed_anew: bool,
    /// Values and bytes of a chunk.
    values: usize,
    bytes: usize,
}

/// Values of a channel in a segment, which lie in equal chunks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Stretch {
    /// The place of the first value of the first chunk, and from a chunk to the next.
    pub(super) first: usize,
    pub(super) next_chunk: usize,
    pub(super) chunks: usize,
    /// The values of a chunk, and from one to the next.
    pub(super) values: usize,
    pub(super) next_value: usize,
    pub(super) big: bool,
}

impl Object {
    /// The number of its values.
    pub(super) fn len(&self) -> usize {
        self.stretches.iter().map(|one| one.chunks * one.values).sum()
    }
}

/// A file's objects, in the order in which they come.
pub(super) struct Segments {
    pub(super) objects: Vec<Object>,
    /// The bytes that could not be read, in words.
    pub(super) lost: Option<String>,
}

/// Reads what the segments say. A file that is cut off or damaged is read as far as its segments go.
///
/// # Errors
/// What nothing can be made of, in words.
pub(super) fn read(bytes: &[u8]) -> Result<Segments, String> {
    let mut objects: Vec<Object> = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    // Those with values in the segment at hand, in the order of their values.
    let mut active: Vec<usize> = Vec::new();
    let mut lost = None;
    let mut stretches = 0;
    let mut begin = 0;
    while begin < bytes.len() {
        let Some(lead_in) = bytes.get(begin..begin + LEAD_IN).filter(|b| b.starts_with(TAG)) else {
            lost = Some(format!("the bytes from {} on are no segment", begin + 1));
            break;
        };
        // The table of contents has the lowest byte first, whatever the rest has.
        let toc = Reader { bytes: lead_in, at: TAG.len(), big: false }.word()?;
        let big = toc & contents::BIG_ENDIAN != 0;
        let mut lead_in = Reader { bytes: lead_in, at: TAG.len() + 8, big };
        // The first is of all ones where the program that wrote it was ended before it could say.
        let (next, raw) = (lead_in.long()?, lead_in.long()?);
        if toc & contents::DAQMX != 0 {
            return Err(DAQMX.to_owned());
        }
        let after = begin + LEAD_IN;
        let end = usize::try_from(next).ok().and_then(|next| after.checked_add(next));
        let is_whole = end.is_some_and(|end| end <= bytes.len());
        let end = end.map_or(bytes.len(), |end| end.min(bytes.len()));
        let raw = usize::try_from(raw).ok().and_then(|raw| after.checked_add(raw));
        let raw = raw.filter(|raw| *raw <= end);
        if raw.is_none() && !is_whole {
            lost = Some(format!("the segment at byte {} is cut off in its description", begin + 1));
            break;
        }
        let raw = raw.ok_or("a segment's values begin past its end")?;
        if toc & contents::META_DATA != 0 {
            if toc & contents::NEW_LIST != 0 {
                active.clear();
            }
            let described = &bytes[..raw];
            described_objects(
                &mut Reader { bytes: described, at: after, big },
                &mut objects,
                &mut places,
                &mut active,
            )?;
        }
        if toc & contents::RAW_DATA != 0 && raw < end {
            let there = end - raw;
            let interleaved = toc & contents::INTERLEAVED != 0;
            let left = values(&mut objects, &active, raw, there, interleaved, big)?;
            stretches += active.len();
            if stretches > MOST_STRETCHES {
                return Err(format!(
                    "its values lie in more than {MOST_STRETCHES} pieces; defragment it in LabVIEW"
                ));
            }
            if left > 0 {
                lost = Some(format!(
                    "the last {left} bytes of the segment at byte {} hold no whole row",
                    begin + 1
                ));
            }
        }
        if !is_whole && next != u64::MAX {
            let absent = next.saturating_sub((bytes.len() - after) as u64);
            lost = Some(format!("the file is cut off: its last segment lacks {absent} bytes"));
        }
        begin = end;
    }
    Ok(Segments { objects, lost })
}

pub(super) const DAQMX: &str =
    "its values are those of DAQmx, as a device gave them, each with a description of its own";

/// The objects that a segment describes; those with values join the active ones.
fn described_objects(
    reader: &mut Reader,
    objects: &mut Vec<Object>,
    places: &mut HashMap<String, usize>,
    active: &mut Vec<usize>,
) -> Result<(), String> {
    for _ in 0..reader.word()? {
        let path = reader.text()?;
        let place = match places.get(&path) {
            Some(place) => *place,
            None => {
                if objects.len() > 2 * MOST_COLUMNS {
                    return Err(format!("it has more than {MOST_COLUMNS} channels"));
                }
                objects.push(Object {
                    path: parts(&path)?,
                    properties: Properties::new(),
                    kind: None,
                    stretches: Vec::new(),
                    timed_anew: false,
                    values: 0,
                    bytes: 0,
                });
                places.insert(path, objects.len() - 1);
                objects.len() - 1
            }
        };
        let object = &mut objects[place];
        match reader.word()? {
            index::NO_VALUES => active.retain(|other| *other != place),
            before => {
                if index::DAQMX.contains(&before) {
                    return Err(DAQMX.to_owned());
                }
                if before != index::AS_BEFORE {
                    let kind = Kind::of(reader.word()?)?;
                    if object.kind.is_some_and(|known| known != kind) {
                        return Err(format!("the type of '{}' changes", object.path.join("/")));
                    }
                    if reader.word()? != 1 {
                        return Err("a channel has values of more than one dimension".to_owned());
                    }
                    let too_many = "a channel claims more values than any file holds";
                    let values = usize::try_from(reader.long()?).map_err(|_| too_many)?;
                    let bytes = match kind {
                        // Where each text ends has four bytes of its own.
                        Kind::Text => {
                            let bytes = usize::try_from(reader.long()?).ok();
                            let ends = values.checked_mul(4);
                            bytes.filter(|bytes| ends.is_some_and(|ends| ends <= *bytes))
                        }
                        kind => values.checked_mul(kind.size()),
                    };
                    object.kind = Some(kind);
                    object.values = values;
                    object.bytes = bytes.ok_or(too_many)?;
                }
                if object.kind.is_none() {
                    return Err(
                        "a channel's values are said to be as before, and none were".to_owned()
                    );
                }
                let has_values = object.values > 0 && object.bytes > 0;
                match active.contains(&place) {
                    false if has_values => active.push(place),
                    true if !has_values => active.retain(|other| *other != place),
                    _ => {}
                }
            }
        }
        for _ in 0..reader.word()? {
            let name = reader.text()?;
            let value = reader.property()?;
            let is_timing = TIMING.contains(&name.as_str());
            let before = object.properties.insert(name, value.clone());
            let is_other = before.is_some_and(|before| before != value);
            object.timed_anew |= is_timing && is_other && !object.stretches.is_empty();
        }
    }
    Ok(())
}

/// Properties of a waveform that say when its values were.
pub(super) const INCREMENT: &str = "wf_increment";
pub(super) const OFFSET: &str = "wf_start_offset";
pub(super) const START: &str = "wf_start_time";
const TIMING: [&str; 3] = [INCREMENT, OFFSET, START];

/// Adds the values of a segment to its channels; how many bytes hold no whole row.
fn values(
    objects: &mut [Object],
    active: &[usize],
    raw: usize,
    there: usize,
    interleaved: bool,
    big: bool,
) -> Result<usize, String> {
    let mut chunk = 0_usize;
    for place in active {
        let sum = chunk.checked_add(objects[*place].bytes);
        chunk = sum.ok_or("a segment claims more values than any file holds")?;
    }
    if chunk == 0 {
        return Ok(there);
    }
    let (chunks, rest) = (there / chunk, there % chunk);
    if interleaved {
        let values = objects[active[0]].values;
        let is_even = active.iter().all(|place| {
            let object = &objects[*place];
            object.values == values && object.kind != Some(Kind::Text)
        });
        if !is_even {
            return Err("interleaved channels have not the same number of values each".to_owned());
        }
        let width = chunk / values;
        let mut first = raw;
        for place in active {
            let object = &mut objects[*place];
            let (next_chunk, rows) = (there, there / width);
            let stretch =
                Stretch { first, next_chunk, chunks: 1, values: rows, next_value: width, big };
            object.stretches.push(stretch);
            first += object.kind.map_or(0, Kind::size);
        }
        return Ok(rest % width);
    }
    // Of a chunk that is cut off: rows of which every channel has its value.
    let mut before = 0;
    let rows = active.iter().map(|place| {
        let object = &objects[*place];
        let there = rest.saturating_sub(before);
        before += object.bytes;
        match object.kind {
            Some(Kind::Text) | None => 0,
            Some(kind) => (there / kind.size()).min(object.values),
        }
    });
    let rows = rows.min().unwrap_or(0);
    let mut first = raw;
    for place in active {
        let object = &mut objects[*place];
        let next_value = object.kind.map_or(0, Kind::size);
        let whole =
            Stretch { first, next_chunk: chunk, chunks, values: object.values, next_value, big };
        object.stretches.push(whole);
        if rows > 0 {
            let first = first + chunks * chunk;
            object.stretches.push(Stretch { first, chunks: 1, values: rows, ..whole });
        }
        first = first.saturating_add(object.bytes);
    }
    let width: usize = active.iter().map(|place| objects[*place].kind.map_or(0, Kind::size)).sum();
    Ok(rest - rows * width)
}

/// The names of a path: `/'group'/'channel'`, in which a quote is written twice.
fn parts(path: &str) -> Result<Vec<String>, String> {
    let wrong = || format!("'{path}' is no path of an object");
    let mut parts = Vec::new();
    let mut rest = path.strip_prefix('/').ok_or_else(wrong)?;
    while !rest.is_empty() {
        let mut name = String::new();
        rest = rest.strip_prefix('\'').ok_or_else(wrong)?;
        loop {
            let (before, behind) = rest.split_once('\'').ok_or_else(wrong)?;
            name.push_str(before);
            match behind.strip_prefix('\'') {
                Some(behind) => {
                    name.push('\'');
                    rest = behind;
                }
                None => {
                    rest = behind.strip_prefix('/').unwrap_or(behind);
                    break;
                }
            }
        }
        parts.push(name);
    }
    if parts.len() > 2 { Err(wrong()) } else { Ok(parts) }
}

/// Reads numbers and texts one after the other.
pub(super) struct Reader<'a> {
    pub(super) bytes: &'a [u8],
    pub(super) at: usize,
    pub(super) big: bool,
}

impl<'a> Reader<'a> {
    fn take(&mut self, size: usize) -> Result<&'a [u8], String> {
        let end = self.at.checked_add(size);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at = self.at.saturating_add(size);
        taken.ok_or_else(|| "the description of its objects is cut off".to_owned())
    }

    fn number(&mut self, kind: NumberKind, size: usize) -> Result<f64, String> {
        let big = self.big;
        Ok(Number { kind, size, big }.read(self.take(size)?))
    }

    pub(super) fn word(&mut self) -> Result<u32, String> {
        let (big, bytes) = (self.big, self.take(4)?);
        let bytes = bytes.try_into().map_err(|_| "four bytes are not four")?;
        Ok(if big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
    }

    fn long(&mut self) -> Result<u64, String> {
        let (big, bytes) = (self.big, self.take(8)?);
        let bytes = bytes.try_into().map_err(|_| "eight bytes are not eight")?;
        Ok(if big { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.word()? as usize;
        if length > 16 * MOST_NAME {
            return Err(format!("a text of its description has {length} bytes"));
        }
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// A moment, ns since 1904.
    pub(super) fn moment(&mut self) -> Result<i128, String> {
        let (first, second) = (self.long()?, self.long()?);
        let (seconds, fraction) = if self.big { (first, second) } else { (second, first) };
        // Seconds are signed; the fraction is of 2⁻⁶⁴ s.
        let seconds = i128::from(seconds as i64);
        let half = 1 << 63;
        Ok(seconds * 1_000_000_000 + ((u128::from(fraction) * 1_000_000_000 + half) >> 64) as i128)
    }

    fn property(&mut self) -> Result<Property, String> {
        Ok(match Kind::of(self.word()?)? {
            Kind::Number(kind, size) => Property::Number(self.number(kind, size)?),
            Kind::Bool => Property::Number(self.number(NumberKind::Unsigned, 1)?),
            Kind::Text => Property::Text(self.text()?),
            Kind::Moment => Property::Moment(self.moment()?),
            Kind::Other(_, size) => {
                self.take(size)?;
                Property::Other
            }
        })
    }
}
