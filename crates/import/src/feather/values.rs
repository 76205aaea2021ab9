//! The values of a column: numbers and texts.

use super::super::limits::MOST_TEXT;
use super::super::table::{Built, Number, NumberKind, little};
use super::batch::{Batch, Room, Runs};
use arrow::array::{Float64Builder, LargeStringBuilder};
use arrow_ipc::{DateUnit, Field, Int, Precision, TimeUnit, Type};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The kind of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Number(Number),
    Text(Text),
    /// Numbers of words that stand in a dictionary.
    Word {
        dictionary: i64,
        number: Number,
        of: Text,
    },
}

/// How texts are written: behind offsets of four or eight bytes, or as views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Text {
    Offsets(usize),
    Views,
}

/// The kind of a column; `Err` says why it cannot be read.
pub(super) fn kind(field: &Field) -> Result<Kind, String> {
    let text = match field.type_type() {
        Type::Utf8 => Some(Text::Offsets(4)),
        Type::LargeUtf8 => Some(Text::Offsets(8)),
        Type::Utf8View => Some(Text::Views),
        _ => None,
    };
    let kind = match (field.dictionary(), text) {
        (Some(dictionary), Some(of)) => {
            let number = match dictionary.indexType() {
                Some(index) => int(index),
                None => number_of(NumberKind::Signed, 32),
            };
            number.map(|number| Kind::Word { dictionary: dictionary.id(), number, of })
        }
        (Some(_), None) => None,
        (None, Some(text)) => Some(Kind::Text(text)),
        (None, None) => number(field).map(Kind::Number),
    };
    kind.ok_or_else(|| {
        let name = field.type_type().variant_name().unwrap_or("unknown").trim_end_matches('_');
        format!("its type {name} is neither number nor text")
    })
}

fn number(field: &Field) -> Option<Number> {
    match field.type_type() {
        Type::Int => int(field.type_as_int()?),
        Type::FloatingPoint => match field.type_as_floating_point()?.precision() {
            Precision::SINGLE => number_of(NumberKind::Float, 32),
            Precision::DOUBLE => number_of(NumberKind::Float, 64),
            _ => None,
        },
        Type::Timestamp | Type::Duration => number_of(NumberKind::Signed, 64),
        Type::Time => number_of(NumberKind::Signed, field.type_as_time()?.bitWidth()),
        Type::Date if field.type_as_date()?.unit() == DateUnit::DAY => {
            number_of(NumberKind::Signed, 32)
        }
        Type::Date => number_of(NumberKind::Signed, 64),
        _ => None,
    }
}

/// The unit of a column of times: of a duration, a moment since 1970 or a time of day; of a date, days.
pub(super) fn unit(field: &Field) -> Option<&'static str> {
    if field.dictionary().is_some() {
        return None;
    }
    let unit = match field.type_type() {
        Type::Timestamp => field.type_as_timestamp()?.unit(),
        Type::Duration => field.type_as_duration()?.unit(),
        Type::Time => field.type_as_time()?.unit(),
        Type::Date if field.type_as_date()?.unit() == DateUnit::DAY => return Some("d"),
        Type::Date => TimeUnit::MILLISECOND,
        _ => return None,
    };
    match unit {
        TimeUnit::SECOND => Some("s"),
        TimeUnit::MILLISECOND => Some("ms"),
        TimeUnit::MICROSECOND => Some("us"),
        TimeUnit::NANOSECOND => Some("ns"),
        _ => None,
    }
}

fn int(int: Int) -> Option<Number> {
    let kind = if int.is_signed() { NumberKind::Signed } else { NumberKind::Unsigned };
    number_of(kind, int.bitWidth())
}

/// A number of so many bits, its first byte the lowest.
fn number_of(kind: NumberKind, bits: i32) -> Option<Number> {
    let size = usize::try_from(bits / 8).ok().filter(|_| [8, 16, 32, 64].contains(&bits))?;
    Some(Number { kind, size, big: false })
}

/// Whether each row has a value.
struct Valid<'a>(Cow<'a, [u8]>);

impl<'a> Valid<'a> {
    fn of(batch: &Batch<'a>, buffer: usize) -> Result<Self, String> {
        let bytes = batch.buffer(buffer, batch.rows.div_ceil(8))?;
        match bytes.len() {
            0 => Ok(Self(bytes)),
            length if length >= batch.rows.div_ceil(8) => Ok(Self(bytes)),
            _ => Err("a column is cut off".to_owned()),
        }
    }

    /// Without any bits all of them have.
    fn has(&self, row: usize) -> bool {
        self.0.get(row / 8).is_none_or(|byte| byte >> (row % 8) & 1 == 1)
    }
}

/// Takes the value of each row, or none.
type Add<'a, T> = &'a mut dyn FnMut(Option<&T>) -> Result<(), String>;

/// The numbers of a batch, `None` where there is none.
fn numbers(batch: &Batch, at: usize, number: Number, add: Add<[u8]>) -> Result<(), String> {
    let valid = Valid::of(batch, at)?;
    let needed = batch.rows * number.size;
    let bytes = batch.buffer(at + 1, needed)?;
    let bytes = bytes.get(..needed).ok_or("a column is cut off")?;
    let mut values = bytes.chunks_exact(number.size).enumerate();
    values.try_for_each(|(row, value)| add(Some(value).filter(|_| valid.has(row))))
}

/// The texts of a batch, `None` where there is none.
fn texts(batch: &Batch, at: Runs, form: Text, add: Add<str>) -> Result<(), String> {
    let valid = Valid::of(batch, at.buffers)?;
    let mut give = |row: usize, text: Option<&[u8]>| match valid.has(row) {
        false => add(None),
        true => add(Some(
            str::from_utf8(text.ok_or_else(|| "a column of texts is cut off".to_owned())?)
                .map_err(|_| "a text is not UTF-8")?,
        )),
    };
    match form {
        Text::Offsets(size) => {
            let offsets = batch.buffer(at.buffers + 1, (batch.rows + 1) * size)?;
            let all = batch.buffer(at.buffers + 2, MOST_TEXT + 1)?;
            let offset = |i: usize| little(&offsets, i * size, size);
            (0..batch.rows).try_for_each(|row| {
                give(row, offset(row).zip(offset(row + 1)).and_then(|(from, to)| all.get(from..to)))
            })
        }
        Text::Views => {
            let views = batch.buffer(at.buffers + 1, batch.rows * 16)?;
            let mut runs = Vec::new();
            let mut room = MOST_TEXT;
            for run in 0..batch.views(at.views)? {
                let run = batch.buffer(at.buffers + 2 + run, MOST_TEXT + 1)?;
                room =
                    room.checked_sub(run.len()).ok_or("its texts have more bytes than are read")?;
                runs.push(run);
            }
            (0..batch.rows).try_for_each(|row| {
                let view = views.get(16 * row..16 * row + 16);
                give(row, view.and_then(|view| viewed(view, &runs)))
            })
        }
    }
}

/// The text of a view: within it, or in one of the runs.
fn viewed<'v>(view: &'v [u8], runs: &'v [Cow<[u8]>]) -> Option<&'v [u8]> {
    let length = little(view, 0, 4)?;
    // So short a text stands in the view itself, in place of its run and its offset there.
    if length <= 12 {
        return view.get(4..4 + length);
    }
    let run = little(view, 8, 4)?;
    let from = little(view, 12, 4)?;
    runs.get(run)?.get(from..from.checked_add(length)?)
}

/// The words of a dictionary.
pub(super) type Words = Vec<Option<String>>;

/// The words of a batch of a dictionary.
pub(super) fn words(batch: &Batch, form: Text) -> Result<Words, String> {
    let mut words = Vec::new();
    texts(batch, Runs::default(), form, &mut |word| {
        words.push(word.map(str::to_owned));
        batch.room.word(word)
    })?;
    Ok(words)
}

/// A column of this kind, without rows.
pub(super) fn column(kind: Kind) -> Built {
    match kind {
        // Only numbers of eight bytes may have more digits than a double holds.
        Kind::Number(number) if number.size == 8 && number.kind != NumberKind::Float => {
            Built::Whole(Vec::new())
        }
        Kind::Number(_) => Built::Numbers(Float64Builder::new()),
        _ => Built::Text(LargeStringBuilder::new()),
    }
}

/// Adds the rows of a batch to a column of this kind.
pub(super) fn extend(
    column: &mut Built,
    kind: Kind,
    batch: &Batch,
    at: Runs,
    words: &BTreeMap<i64, Words>,
) -> Result<(), String> {
    let room = batch.room;
    match (column, kind) {
        (Built::Numbers(built), Kind::Number(number)) => {
            numbers(batch, at.buffers, number, &mut |value| {
                built.append_option(value.map(|value| number.read(value)));
                Ok(())
            })
        }
        (Built::Whole(built), Kind::Number(number)) => {
            numbers(batch, at.buffers, number, &mut |value| {
                built.push(value.map(|value| number.whole(value)));
                Ok(())
            })
        }
        (Built::Text(built), Kind::Text(form)) => {
            texts(batch, at, form, &mut |text| append(built, room, text))
        }
        (Built::Text(built), Kind::Word { dictionary, number, .. }) => {
            let words = words.get(&dictionary).ok_or("a dictionary is missing")?;
            numbers(batch, at.buffers, number, &mut |value| {
                let Some(value) = value else { return append(built, room, None) };
                let place = usize::try_from(number.whole(value)).ok();
                let word = place.and_then(|place| words.get(place));
                append(built, room, word.ok_or("a word is missing")?.as_deref())
            })
        }
        _ => Ok(()),
    }
}

fn append(built: &mut LargeStringBuilder, room: &Room, text: Option<&str>) -> Result<(), String> {
    // Room first: a dictionary has a word once, and a column has it in every row.
    room.text(text)?;
    built.append_option(text);
    Ok(())
}
