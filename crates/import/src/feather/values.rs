//! The values of a column: numbers and texts.

use super::super::limits::MOST_TEXT;
use super::super::table::Cells;
use super::batch::{Batch, Place, Room};
use arrow::array::{Float64Builder, LargeStringBuilder};
use arrow_ipc::{DateUnit, Field, Precision, TimeUnit, Type};
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

/// How a number is written: bytes, and what they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Number {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

/// How texts are written: behind offsets of four or eight bytes, or as views.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Text {
    Offsets(usize),
    Views,
}

impl Number {
    fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Float(size) => size,
        }
    }

    /// The number in bytes of its size, if it is a whole one.
    fn whole(self, bytes: &[u8]) -> i128 {
        let mut eight = [0; 8];
        eight[..bytes.len()].copy_from_slice(bytes);
        match self {
            Self::Unsigned(_) => i128::from(u64::from_le_bytes(eight)),
            _ => {
                let unused = 64 - 8 * bytes.len();
                i128::from(i64::from_le_bytes(eight) << unused >> unused)
            }
        }
    }

    /// The number in bytes of its size.
    #[allow(clippy::cast_precision_loss, clippy::cast_possible_wrap)] // Past 2⁵³ the nearest one, as in every other format.
    fn read(self, bytes: &[u8]) -> f64 {
        let mut eight = [0; 8];
        eight[..bytes.len()].copy_from_slice(bytes);
        let bits = u64::from_le_bytes(eight);
        match self {
            Self::Unsigned(_) => bits as f64,
            Self::Signed(size) => {
                let unused = 64 - 8 * size;
                ((bits << unused) as i64 >> unused) as f64
            }
            Self::Float(4) => {
                f64::from(f32::from_le_bytes([eight[0], eight[1], eight[2], eight[3]]))
            }
            Self::Float(_) => f64::from_bits(bits),
        }
    }
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
            let index = dictionary.indexType();
            let number = match index {
                Some(index) => int(index.bitWidth(), index.is_signed()),
                None => int(32, true),
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
        Type::Int => {
            field.type_as_int().and_then(|int_type| int(int_type.bitWidth(), int_type.is_signed()))
        }
        Type::FloatingPoint => match field.type_as_floating_point()?.precision() {
            Precision::SINGLE => Some(Number::Float(4)),
            Precision::DOUBLE => Some(Number::Float(8)),
            _ => None,
        },
        Type::Timestamp | Type::Duration => Some(Number::Signed(8)),
        Type::Time => int(field.type_as_time()?.bitWidth(), true),
        Type::Date if field.type_as_date()?.unit() == DateUnit::DAY => Some(Number::Signed(4)),
        Type::Date => Some(Number::Signed(8)),
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
    [
        (TimeUnit::SECOND, "s"),
        (TimeUnit::MILLISECOND, "ms"),
        (TimeUnit::MICROSECOND, "us"),
        (TimeUnit::NANOSECOND, "ns"),
    ]
    .into_iter()
    .find_map(|(other, word)| (other == unit).then_some(word))
}

fn int(bits: i32, is_signed: bool) -> Option<Number> {
    let size = usize::try_from(bits / 8).ok().filter(|_| [8, 16, 32, 64].contains(&bits))?;
    Some(if is_signed { Number::Signed(size) } else { Number::Unsigned(size) })
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
    let needed = batch.rows * number.size();
    let bytes = batch.buffer(at + 1, needed)?;
    let bytes = bytes.get(..needed).ok_or("a column is cut off")?;
    let mut values = bytes.chunks_exact(number.size()).enumerate();
    values.try_for_each(|(row, value)| add(Some(value).filter(|_| valid.has(row))))
}

/// The texts of a batch, `None` where there is none.
fn texts(batch: &Batch, at: Place, form: Text, add: Add<str>) -> Result<(), String> {
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
            let offset = |i: usize| {
                let mut eight = [0; 8];
                eight[..size].copy_from_slice(offsets.get(i * size..(i + 1) * size)?);
                usize::try_from(u64::from_le_bytes(eight)).ok()
            };
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
    let [length, run, from] = [0, 8, 12].map(|at| {
        let four = view.get(at..at + 4)?.try_into().ok()?;
        usize::try_from(i32::from_le_bytes(four)).ok()
    });
    let length = length?;
    // So short a text stands in the view itself, in place of its run and its offset there.
    if length <= 12 {
        return view.get(4..4 + length);
    }
    let from = from?;
    runs.get(run?)?.get(from..from.checked_add(length)?)
}

/// The words of a dictionary.
#[derive(Default)]
pub(super) struct Words(Vec<Option<String>>);

impl Words {
    /// Adds more words behind those that are there.
    pub(super) fn add(&mut self, more: Self) {
        self.0.extend(more.0);
    }
}

/// The words of a batch of a dictionary.
pub(super) fn words(batch: &Batch, form: Text) -> Result<Words, String> {
    let mut words = Vec::new();
    texts(batch, Place::default(), form, &mut |word| {
        words.push(word.map(str::to_owned));
        batch.room.word(word)
    })?;
    Ok(Words(words))
}

/// A column that grows batch by batch.
pub(super) struct Growing {
    kind: Kind,
    built: Built,
}

enum Built {
    Numbers(Float64Builder),
    /// Numbers of which a double may not hold every digit.
    Whole(Vec<Option<i128>>),
    Texts(LargeStringBuilder),
}

impl Growing {
    pub(super) fn new(kind: Kind) -> Self {
        let built = match kind {
            // Only numbers of eight bytes may have more digits than a double holds.
            Kind::Number(Number::Signed(8) | Number::Unsigned(8)) => Built::Whole(Vec::new()),
            Kind::Number(_) => Built::Numbers(Float64Builder::new()),
            _ => Built::Texts(LargeStringBuilder::new()),
        };
        Self { kind, built }
    }

    /// Adds the rows of a batch.
    pub(super) fn extend(
        &mut self,
        batch: &Batch,
        at: Place,
        words: &BTreeMap<i64, Words>,
    ) -> Result<(), String> {
        let room = batch.room;
        match (&mut self.built, self.kind) {
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
            (Built::Texts(built), Kind::Text(form)) => {
                texts(batch, at, form, &mut |text| append(built, room, text))
            }
            (Built::Texts(built), Kind::Word { dictionary, number, .. }) => {
                let words = words.get(&dictionary).ok_or("a dictionary is missing")?;
                numbers(batch, at.buffers, number, &mut |value| {
                    let Some(value) = value else { return append(built, room, None) };
                    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                    // Below 2⁵³, and what is negative becomes 0 or saturates: looked up all the
                    // same.
                    let place = Some(number.read(value)).filter(|n| *n >= 0.0).map(|n| n as usize);
                    let word = place.and_then(|place| words.0.get(place));
                    append(built, room, word.ok_or("a word is missing")?.as_deref())
                })
            }
            _ => Ok(()),
        }
    }

    pub(super) fn finish(self) -> Cells {
        match self.built {
            Built::Numbers(mut built) => Cells::Numbers(built.finish()),
            Built::Whole(built) => Cells::whole(built.into_iter()),
            Built::Texts(mut built) => Cells::Text(built.finish()),
        }
    }
}

fn append(built: &mut LargeStringBuilder, room: &Room, text: Option<&str>) -> Result<(), String> {
    // Room first: a dictionary has a word once, and a column has it in every row.
    room.text(text)?;
    built.append_option(text);
    Ok(())
}
