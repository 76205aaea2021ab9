//! Objects of MATLAB in a MAT file of version 5: tables, timetables, and the durations, moments, strings and categories in
//! them. A variable holds only the object's number; its properties lie behind all variables, in the "subsystem".
//!
//! MathWorks does not document it. Source of the layout: the documentation of mat-io 1.0.2 ("MATLAB MAT-file subsystem"),
//! which is also what it is held against (`tests/interop/laboratory.py`).

use super::super::limits::{MOST_COLUMNS, MOST_NAME, MOST_TEXT, Take};
use super::super::spelling::shown;
use super::super::table::{Cells, Declared};
use super::elements::{
    ALIGN, COMPLEX, Elements, Numbers, OPAQUE, STRUCT, TOO_MUCH, beginning, text, whole, word,
};
use super::mi;
use arrow::array::{Float64Array, LargeStringBuilder};
use std::collections::BTreeMap;

/// What the numbers of an object's place begin with.
const PLACE: u32 = 0xDD00_0000;
/// Values within values that are followed, and all values that are.
const MOST_DEPTH: usize = 12;
const MOST_VALUES: usize = 1 << 20;
/// Moments further off are none, ms: thirty thousand years.
const MOST_MS: f64 = 1e15;
/// The class of a cell array, and of texts.
const CELL: u32 = 1;
const CHAR: u32 = 4;
/// Types of texts in UTF-8 and UTF-16.
const UTF8: u32 = 16;
const UTF16: u32 = 17;

/// A value of any class.
enum Value<'a> {
    Numbers { size: Vec<usize>, real: Numbers<'a>, imaginary: Option<Numbers<'a>> },
    Text(String),
    Cells(Vec<Value<'a>>),
    Fields(Vec<(String, Value<'a>)>),
    Other,
}

type Properties<'s, 'a> = BTreeMap<&'s str, &'s Value<'a>>;

/// The objects of a file.
pub(super) struct Objects<'a> {
    big: bool,
    names: Vec<String>,
    /// Numbers about classes, objects, and the two kinds of lists of properties.
    classes: &'a [u8],
    objects: &'a [u8],
    saved: &'a [u8],
    listed: &'a [u8],
    values: Vec<Value<'a>>,
}

/// A column of a table.
pub(super) struct Column<'s, 'a> {
    pub(super) name: String,
    pub(super) unit: Option<Declared>,
    of: Of<'s, 'a>,
}

enum Of<'s, 'a> {
    /// A column of a value, from 0.
    Value(&'s Value<'a>, usize),
    /// Times at a step from a first on, s.
    Every { first_s: f64, step_s: f64, rows: usize },
}

/// The subsystem that begins at a place of a file, unpacked.
pub(super) fn subsystem(bytes: &[u8], at: usize, big: bool, most: u64) -> Option<Vec<u8>> {
    let (kind, data) = Elements { bytes: bytes.get(at..)?, big }.next()?;
    let unpacked;
    let matrix = match kind {
        mi::MATRIX => data,
        mi::COMPRESSED => {
            unpacked = beginning(data, most)?;
            unpacked.get(ALIGN..)?
        }
        _ => return None,
    };
    let mut parts = Elements { bytes: matrix, big };
    // Flags, size and name; then its bytes are a file of their own, with a short head.
    let (_, _, _) = (parts.next()?, parts.next()?, parts.next()?);
    Some(parts.next()?.1.get(ALIGN..)?.to_vec())
}

impl<'a> Objects<'a> {
    /// Reads an unpacked subsystem.
    pub(super) fn read(bytes: &'a [u8], big: bool) -> Option<Self> {
        let (_, data) = Elements { bytes, big }.next()?;
        let mut left = MOST_VALUES;
        let Value::Fields(systems) = value(data, big, 0, &mut left)? else { return None };
        let (_, wrapper) = systems.into_iter().find(|(name, _)| name == "MCOS")?;
        let Value::Cells(mut cells) = wrapper else { return None };
        let Value::Numbers { real: Numbers { data: head, .. }, .. } = cells.first()? else {
            return None;
        };
        let head = *head;
        // The version, and how many cells at the end are about classes.
        let about_classes = match word(head, big)? {
            2 => 1,
            3 => 2,
            4 => 3,
            _ => return None,
        };
        let ends: Option<Vec<usize>> =
            (0..8).map(|i| Some(word(head.get(8 + 4 * i..)?, big)? as usize)).collect();
        let ends = ends?;
        let region = |i: usize| head.get(ends[i]..ends[i + 1]);
        let names = head.get(40..ends[0])?.split(|byte| *byte == 0).filter(|name| !name.is_empty());
        let names = names.map(|name| String::from_utf8_lossy(name).into_owned()).collect();
        let (classes, saved, objects, listed) = (region(0)?, region(1)?, region(2)?, region(3)?);
        cells.truncate(cells.len().checked_sub(about_classes)?);
        let values = cells.split_off(2.min(cells.len()));
        Some(Self { big, names, classes, objects, saved, listed, values })
    }

    fn word(&self, region: &[u8], place: usize) -> Option<usize> {
        Some(word(region.get(place.checked_mul(4)?..)?, self.big)? as usize)
    }

    fn name(&self, number: usize) -> Option<&str> {
        self.names.get(number.checked_sub(1)?).map(String::as_str)
    }

    /// The class of an object and its properties.
    fn object(&self, id: usize) -> Option<(&str, Properties<'_, 'a>)> {
        let about = |field: usize| self.word(self.objects, id.checked_mul(6)?.checked_add(field)?);
        let class = self.name(self.word(self.classes, about(0)?.checked_mul(4)? + 1)?)?;
        let (list, number) = match (about(3)?, about(4)?) {
            (0, number) => (self.listed, number),
            (number, _) => (self.saved, number),
        };
        // Each list is its length, then three numbers a property, and ends at an even place.
        let mut at = 0;
        for _ in 0..number {
            at += 1 + 3 * self.word(list, at)?;
            at += at % 2;
        }
        let mut properties = Properties::new();
        for i in 0..self.word(list, at)? {
            let field = |field: usize| self.word(list, at + 1 + 3 * i + field);
            // Others stand for themselves, such as what is on or off.
            if field(1)? == 1 {
                properties.insert(self.name(field(0)?)?, self.values.get(field(2)?)?);
            }
        }
        Some((class, properties))
    }

    /// The columns of a table or a timetable; `Err` says what else it is, or what it lacks.
    pub(super) fn columns(&self, id: usize) -> Result<Vec<Column<'_, 'a>>, String> {
        let damaged = || "it is an object whose properties cannot be read".to_owned();
        let (class, properties) = self.object(id).ok_or_else(damaged)?;
        let of = |name: &str| properties.get(name).copied();
        let (data, names, units, times) = match class {
            "table" => {
                let about = of("props").ok_or_else(damaged)?;
                let names =
                    names_in(about, "useVariableNames2048", "VariableNames2048").or_else(|| {
                        names_in(about, "useVariableNamesOriginal", "VariableNamesOriginal")
                    });
                let names = names.or_else(|| of("varnames"));
                (of("data"), names, field(about, "VariableUnits"), None)
            }
            "timetable" => {
                let about = of("any").ok_or_else(damaged)?;
                let names = names_in(about, "useVarNames2048", "varNames2048")
                    .or_else(|| names_in(about, "useVarNamesOrig", "varNamesOrig"));
                let names = names.or_else(|| field(about, "varNames"));
                let times = self.times(about).ok_or_else(damaged)?;
                (field(about, "data"), names, field(about, "varUnits"), Some(times))
            }
            class => return Err(format!("it is an object of the class {}", shown(class))),
        };
        let (Some(Value::Cells(data)), Some(Value::Cells(names))) = (data, names) else {
            return Err(damaged());
        };
        let mut columns = Vec::from_iter(times);
        for (place, (value, name)) in data.iter().zip(names).enumerate() {
            let Value::Text(name) = name else { return Err(damaged()) };
            let unit = match units {
                Some(Value::Cells(units)) => units.get(place),
                _ => None,
            };
            let unit = match unit {
                Some(Value::Text(unit)) if !unit.is_empty() => {
                    Some(Declared { unit: unit.clone(), is_type: false })
                }
                _ => self.unit_of(value),
            };
            let width = match value {
                Value::Numbers { size, .. } if self.place(value).is_none() => {
                    size.iter().skip(1).fold(1_usize, |all, n| all.saturating_mul(*n))
                }
                _ => 1,
            };
            if columns.len().saturating_add(width) > MOST_COLUMNS || name.len() > MOST_NAME {
                return Err("it has more columns, or longer names, than are read".to_owned());
            }
            for i in 0..width {
                let name = if width == 1 { name.clone() } else { format!("{name}({})", i + 1) };
                columns.push(Column { name, unit: unit.clone(), of: Of::Value(value, i) });
            }
        }
        Ok(columns)
    }

    /// The times of a timetable's rows.
    fn times<'s>(&'s self, about: &'s Value<'a>) -> Option<Column<'s, 'a>> {
        let name =
            match names_in(about, "useDimNamesOrig", "dimNamesOrig").or(field(about, "dimNames")) {
                Some(Value::Cells(names)) => match names.first() {
                    Some(Value::Text(name)) => name.clone(),
                    _ => "Time".to_owned(),
                },
                _ => "Time".to_owned(),
            };
        let times = field(about, "rowTimes")?;
        if !matches!(times, Value::Fields(_)) {
            return Some(Column { name, unit: self.unit_of(times), of: Of::Value(times, 0) });
        }
        // Of a steady rate MATLAB keeps the first time and the step, or the rate.
        let number = |name: &str| match field(times, name) {
            Some(Value::Numbers { real, .. }) => real.values(0, 1).map(|one| one[0]),
            _ => None,
        };
        let seconds = |name: &str| {
            let (class, properties) = self.object(self.place(field(times, name)?)?)?;
            // A moment in place of a duration: times count from it.
            if class != "duration" {
                return Some(0.0);
            }
            match properties.get("millis")? {
                Value::Numbers { real, .. } => Some(real.values(0, 1)?[0] * 1e-3),
                _ => None,
            }
        };
        let is_rate = number("specifiedAsRate").is_some_and(|is_rate| is_rate > 0.0);
        let step_s = if is_rate { 1.0 / number("sampleRate")? } else { seconds("stepSize")? };
        let rows = match field(about, "numRows")? {
            Value::Numbers { real, .. } => whole(real.values(0, 1)?[0])?,
            _ => return None,
        };
        let unit = Some(Declared { unit: "s".to_owned(), is_type: true });
        Some(Column { name, unit, of: Of::Every { first_s: seconds("origin")?, step_s, rows } })
    }

    /// The number of the object that a value stands for.
    fn place(&self, value: &Value) -> Option<usize> {
        let Value::Numbers { real, .. } = value else { return None };
        object_of(real.data, self.big)
    }

    /// The unit that belongs to the type of a column.
    fn unit_of(&self, value: &Value) -> Option<Declared> {
        let (class, _) = self.object(self.place(value)?)?;
        let unit = match class {
            "duration" => "ms",
            "datetime" => "ns",
            _ => return None,
        };
        Some(Declared { unit: unit.to_owned(), is_type: true })
    }

    /// The cells of a column.
    ///
    /// # Errors
    /// More than is read, or damage.
    pub(super) fn cells(&self, column: &Column, take: &Take) -> Result<Cells, String> {
        let room =
            |rows: usize| if take.budget.cells(rows) { Ok(()) } else { Err(TOO_MUCH.to_owned()) };
        let damaged = || format!("the column '{}' is damaged", shown(&column.name));
        let (value, place) = match column.of {
            Of::Every { first_s, step_s, rows } => {
                room(rows)?;
                let times = (0..rows).map(|i| Some(first_s + i as f64 * step_s));
                return Ok(Cells::Numbers(times.collect()));
            }
            Of::Value(value, place) => (value, place),
        };
        if let Some(id) = self.place(value) {
            return self.object_cells(id, take).ok_or_else(damaged)?;
        }
        match value {
            Value::Numbers { imaginary: Some(_), .. } => {
                Ok(Cells::Other("it is complex".to_owned()))
            }
            Value::Numbers { size, real, .. } => {
                let rows = size.first().copied().unwrap_or(0);
                room(rows)?;
                let values = real.values(place.checked_mul(rows).ok_or_else(damaged)?, rows);
                Ok(Cells::Numbers(Float64Array::from(values.ok_or_else(damaged)?)))
            }
            Value::Cells(cells) => {
                room(cells.len())?;
                let texts: Option<Vec<&str>> = cells
                    .iter()
                    .map(|cell| match cell {
                        Value::Text(text) => Some(text.as_str()),
                        Value::Other => Some(""),
                        _ => None,
                    })
                    .collect();
                Ok(texts.map_or_else(
                    || Cells::Other("it is a cell array of more than texts".to_owned()),
                    |texts| of_texts(texts.into_iter().map(|text| Some(text.to_owned()))),
                ))
            }
            _ => Ok(Cells::Other("it is neither of numbers nor of texts".to_owned())),
        }
    }

    /// The values of an object in a column: durations in ms, moments in ns since 1970, texts.
    fn object_cells(&self, id: usize, take: &Take) -> Option<Result<Cells, String>> {
        let (class, properties) = self.object(id)?;
        let of = |name: &str| properties.get(name).copied();
        let numbers = |name: &str| match of(name) {
            Some(Value::Numbers { real, imaginary, .. }) => Some((real, imaginary)),
            _ => None,
        };
        let rows = match class {
            "duration" => numbers("millis")?.0.count(),
            "datetime" => numbers("data")?.0.count(),
            "string" => numbers("any")?.0.count(),
            "categorical" => numbers("codes")?.0.count(),
            class => {
                return Some(Ok(Cells::Other(format!(
                    "it is an object of the class {}",
                    shown(class)
                ))));
            }
        };
        if !take.budget.cells(rows) {
            return Some(Err(TOO_MUCH.to_owned()));
        }
        Some(Ok(match class {
            "duration" => {
                let millis = numbers("millis")?.0.values(0, rows)?;
                Cells::Numbers(
                    millis.into_iter().map(|ms| Some(ms).filter(|ms| !ms.is_nan())).collect(),
                )
            }
            "datetime" => {
                // The imaginary part is what of a millisecond the real one has no digits for.
                let (real, imaginary) = numbers("data")?;
                let rest = match imaginary {
                    Some(imaginary) => imaginary.values(0, rows)?,
                    None => vec![0.0; rows],
                };
                let moments = real.values(0, rows)?.into_iter().zip(rest).map(|(ms, rest)| {
                    let ns = ((ms.fract() + rest) * 1e6).round() as i64;
                    (ms.abs() < MOST_MS).then(|| ms.trunc() as i128 * 1_000_000 + i128::from(ns))
                });
                Cells::whole(moments.collect::<Vec<_>>().into_iter())
            }
            "categorical" => {
                let Value::Cells(names) = of("categoryNames")? else { return None };
                let codes = numbers("codes")?.0.values(0, rows)?;
                of_texts(codes.into_iter().map(|code| {
                    match names.get(whole(code)?.checked_sub(1)?)? {
                        Value::Text(name) => Some(name.clone()),
                        _ => None,
                    }
                }))
            }
            _ => {
                // Version, dimensions, their sizes, the length of each, then all letters in UTF-16.
                let data = numbers("any")?.0.data;
                let long = |place: usize| {
                    let eight = *data.get(place.checked_mul(8)?..)?.first_chunk::<8>()?;
                    let long = if self.big {
                        u64::from_be_bytes(eight)
                    } else {
                        u64::from_le_bytes(eight)
                    };
                    Some(long)
                };
                let dimensions = usize::try_from(long(1)?).ok()?;
                let sizes = (0..dimensions).map(|i| usize::try_from(long(2 + i)?).ok());
                let count = sizes.collect::<Option<Vec<_>>>()?;
                let count = count.into_iter().try_fold(1_usize, usize::checked_mul)?;
                let mut at = (2 + dimensions).checked_add(count)?.checked_mul(8)?;
                let mut texts = Vec::new();
                for i in 0..count {
                    let length = long(2 + dimensions + i)?;
                    // Of all ones where the string is missing.
                    if length == u64::MAX {
                        texts.push(None);
                        continue;
                    }
                    let end = at.checked_add(usize::try_from(length).ok()?.checked_mul(2)?)?;
                    texts.push(Some(utf_16(data.get(at..end)?, self.big)));
                    at = end;
                }
                of_texts(texts.into_iter())
            }
        }))
    }
}

/// The number of the object that a variable stands for, by the numbers behind its class; an array of objects has none.
pub(super) fn object_of(data: &[u8], big: bool) -> Option<usize> {
    let word = |place: usize| Some(word(data.get(4 * place..)?, big)? as usize);
    let dimensions = word(1).filter(|n| word(0) == Some(PLACE as usize) && *n <= 32)?;
    let is_one = (0..dimensions).all(|i| word(2 + i) == Some(1));
    word(2 + dimensions).filter(|_| is_one)
}

/// A field of a structure.
fn field<'s, 'a>(value: &'s Value<'a>, name: &str) -> Option<&'s Value<'a>> {
    let Value::Fields(fields) = value else { return None };
    fields.iter().find(|(own, _)| own == name).map(|(_, value)| value)
}

/// Names that are no words of MATLAB's stand in a field of their own, and another field says so.
fn names_in<'s, 'a>(about: &'s Value<'a>, is_used: &str, names: &str) -> Option<&'s Value<'a>> {
    let Some(Value::Numbers { real, .. }) = field(about, is_used) else { return None };
    let is_used = real.values(0, 1).is_some_and(|one| one[0] > 0.0);
    is_used.then(|| field(about, names)).flatten()
}

fn of_texts(texts: impl Iterator<Item = Option<String>>) -> Cells {
    let mut built = LargeStringBuilder::new();
    let mut letters = 0;
    for text in texts {
        let text = text.filter(|text| !text.is_empty());
        letters += text.as_ref().map_or(0, String::len);
        if letters > MOST_TEXT {
            return Cells::Other(format!("its texts have more than {MOST_TEXT} bytes"));
        }
        built.append_option(text);
    }
    Cells::Text(built.finish())
}

fn utf_16(bytes: &[u8], big: bool) -> String {
    let pairs = bytes.as_chunks::<2>().0.iter();
    let units =
        pairs.map(|two| if big { u16::from_be_bytes(*two) } else { u16::from_le_bytes(*two) });
    char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// The value in a matrix; nothing if it is damaged, or has more in it than is read.
fn value<'a>(data: &'a [u8], big: bool, depth: usize, left: &mut usize) -> Option<Value<'a>> {
    *left = left.checked_sub(1)?;
    if depth > MOST_DEPTH {
        return None;
    }
    // What was never set has nothing at all.
    if data.is_empty() {
        return Some(Value::Other);
    }
    let mut parts = Elements { bytes: data, big };
    let flags = word(parts.next()?.1, big)?;
    let class = flags & 0xff;
    if class == OPAQUE {
        let (_name, _system, _class) = (parts.next()?, parts.next()?, parts.next()?);
        return value(parts.next()?.1, big, depth + 1, left);
    }
    let (kind, size) = parts.next()?;
    let size = Numbers::new(kind, size, big)?;
    let size = size.values(0, size.count().min(32))?.into_iter().map(whole);
    let size = size.collect::<Option<Vec<usize>>>()?;
    let count = size.iter().try_fold(1_usize, |all, n| all.checked_mul(*n))?;
    let _name = parts.next()?;
    Some(match class {
        CELL => {
            let mut cells = Vec::new();
            for _ in 0..count {
                cells.push(value(parts.next()?.1, big, depth + 1, left)?);
            }
            Value::Cells(cells)
        }
        STRUCT if count == 1 => {
            let (kind, length) = parts.next()?;
            let length = whole(Numbers::new(kind, length, big)?.values(0, 1)?[0])?;
            let (_, names) = parts.next()?;
            let mut fields = Vec::new();
            for name in names.chunks_exact(length.clamp(1, MOST_NAME)) {
                let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
                fields.push((text(&name[..end]), value(parts.next()?.1, big, depth + 1, left)?));
            }
            Value::Fields(fields)
        }
        CHAR => {
            let (kind, letters) = parts.next()?;
            Value::Text(match kind {
                mi::UINT16 | UTF16 => utf_16(letters, big),
                UTF8 => String::from_utf8_lossy(letters).into_owned(),
                _ => letters.iter().map(|byte| char::from(*byte)).collect(),
            })
        }
        6..=15 => {
            let (kind, real) = parts.next()?;
            let imaginary = match flags & COMPLEX {
                0 => None,
                _ => parts.next().and_then(|(kind, data)| Numbers::new(kind, data, big)),
            };
            Value::Numbers { size, real: Numbers::new(kind, real, big)?, imaginary }
        }
        _ => Value::Other,
    })
}
