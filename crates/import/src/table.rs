//! The table that every format becomes: columns of text or numbers, not yet interpreted.

use super::spelling::plain;
use super::spelling::shown;
use arrow::array::{Array, Float64Array, Float64Builder, LargeStringArray, LargeStringBuilder};
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;

/// A column, by its name or by its place (from 1).
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(untagged, expecting = "expected a column's name, or its position from 1")]
pub(super) enum ColumnRef {
    Position(usize),
    Name(String),
}

impl fmt::Display for ColumnRef {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Position(n) => write!(f, "{n}"),
            Self::Name(name) => f.write_str(name),
        }
    }
}

/// The cells of a column.
#[derive(Debug, Clone)]
pub(super) enum Cells {
    /// As text, empty cells null.
    Text(LargeStringArray),
    /// As numbers, missing ones null.
    Numbers(Float64Array),
    /// Those of another file, by the row of it that belongs to each row; [`NO_ROW`] where none does.
    Joined { cells: Arc<Cells>, rows: Arc<Vec<u32>> },
    /// Neither: why, in words.
    Other(String),
    /// Not mapped, and not kept.
    Unread,
}

/// In the place of a row's number: there is none.
pub(super) const NO_ROW: u32 = u32::MAX;

/// One cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Cell<'a> {
    Empty,
    Text(&'a str),
    Number(f64),
}

impl fmt::Display for Cell<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Empty => Ok(()),
            Self::Text(text) => f.write_str(text),
            Self::Number(number) => write!(f, "{number}"),
        }
    }
}

impl Cell<'_> {
    /// Whether two cells of a label say the same, however it is spelled.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Text(text), Self::Text(other)) => text == other || plain(text) == plain(other),
            _ => self == other,
        }
    }
}

impl ColumnRef {
    /// Whether it is the column at `place` (from 0), which has this name if it has one.
    pub(super) fn means(&self, place: usize, name: Option<&str>) -> bool {
        match self {
            Self::Position(n) => *n == place + 1,
            Self::Name(wanted) => name == Some(wanted),
        }
    }
}

impl Cells {
    /// The cells of a column of text, if one was built.
    pub(super) fn of_text(built: Option<LargeStringBuilder>) -> Self {
        built.map_or(Self::Unread, |mut built| Self::Text(built.finish()))
    }

    /// Whole numbers: as numbers if a double holds each of them, else as texts, which lose no digit where
    /// a time is taken from the first sample on.
    #[allow(clippy::cast_precision_loss)] // Checked.
    pub(super) fn whole(values: impl Iterator<Item = Option<i128>> + Clone) -> Self {
        const MOST: u128 = 1 << f64::MANTISSA_DIGITS;
        if values.clone().flatten().all(|value| value.unsigned_abs() <= MOST) {
            return Self::Numbers(values.map(|value| value.map(|value| value as f64)).collect());
        }
        Self::Text(values.map(|value| value.map(|value| value.to_string())).collect())
    }

    /// The number of cells.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Text(cells) => cells.len(),
            Self::Numbers(cells) => cells.len(),
            Self::Joined { rows, .. } => rows.len(),
            Self::Other(_) | Self::Unread => 0,
        }
    }

    /// The cell in `row`, from 0.
    pub(super) fn cell(&self, row: usize) -> Cell<'_> {
        match self {
            // A column that is not mapped may be shorter.
            Self::Text(cells) if row < cells.len() && cells.is_valid(row) => {
                Cell::Text(cells.value(row))
            }
            Self::Numbers(cells) if row < cells.len() && cells.is_valid(row) => {
                Cell::Number(cells.value(row))
            }
            Self::Joined { cells, rows } => match rows.get(row) {
                Some(row) if *row != NO_ROW => cells.cell(*row as usize),
                _ => Cell::Empty,
            },
            _ => Cell::Empty,
        }
    }
}

/// A column that grows as its values are read.
pub(super) enum Built {
    Unread,
    Numbers(Float64Builder),
    /// Numbers of which a double may not hold every digit.
    Whole(Vec<Option<i128>>),
    Text(LargeStringBuilder),
}

impl Built {
    pub(super) fn finish(self) -> Cells {
        match self {
            Self::Unread => Cells::Unread,
            Self::Numbers(mut numbers) => Cells::Numbers(numbers.finish()),
            Self::Whole(whole) => Cells::whole(whole.into_iter()),
            Self::Text(mut texts) => Cells::Text(texts.finish()),
        }
    }
}

/// What the bytes of a number are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NumberKind {
    Signed,
    Unsigned,
    Float,
}

/// How a number is written in a binary format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Number {
    pub(super) kind: NumberKind,
    /// Its bytes, one to eight.
    pub(super) size: usize,
    /// Whether its first byte is the highest.
    pub(super) big: bool,
}

impl Number {
    fn bits(self, bytes: &[u8]) -> u64 {
        let mut eight = [0; 8];
        let own = &mut eight[..bytes.len()];
        own.copy_from_slice(bytes);
        if self.big {
            own.reverse();
        }
        u64::from_le_bytes(eight)
    }

    /// Shifted up and down again, a number of fewer bytes keeps its sign.
    fn signed(self, bits: u64) -> i64 {
        let unused = 64 - 8 * self.size;
        (bits << unused) as i64 >> unused
    }

    /// The whole number in bytes of its size.
    pub(super) fn whole(self, bytes: &[u8]) -> i128 {
        let bits = self.bits(bytes);
        match self.kind {
            NumberKind::Unsigned => i128::from(bits),
            _ => i128::from(self.signed(bits)),
        }
    }

    /// The number in bytes of its size; of a whole one past 2⁵³ the nearest double.
    pub(super) fn read(self, bytes: &[u8]) -> f64 {
        let bits = self.bits(bytes);
        match self.kind {
            NumberKind::Signed => self.signed(bits) as f64,
            NumberKind::Unsigned => bits as f64,
            NumberKind::Float if self.size == 4 => f64::from(f32::from_bits(bits as u32)),
            NumberKind::Float => f64::from_bits(bits),
        }
    }
}

impl Number {
    /// Gives each number of bytes in which they follow each other. The same as [`Number::read`] of each; compiled for the
    /// common kinds, this is some times as fast.
    pub(super) fn read_each(self, bytes: &[u8], mut each: impl FnMut(f64)) {
        use NumberKind::{Float, Signed, Unsigned};
        macro_rules! of {
            ($number:ty, $size:literal) => {{
                let (numbers, _) = bytes.as_chunks::<$size>();
                numbers.iter().for_each(|own| each(<$number>::from_le_bytes(*own) as f64))
            }};
        }
        match (self.kind, self.size, self.big) {
            (Float, 8, false) => of!(f64, 8),
            (Float, 4, false) => of!(f32, 4),
            (Signed, 2, false) => of!(i16, 2),
            (Unsigned, 2, false) => of!(u16, 2),
            (Signed, 4, false) => of!(i32, 4),
            (Unsigned, 4, false) => of!(u32, 4),
            _ => bytes.chunks_exact(self.size).for_each(|own| each(self.read(own))),
        }
    }
}

/// The whole number in so many bytes, at most eight, from a place on: the lowest comes first.
pub(super) fn little(bytes: &[u8], at: usize, size: usize) -> Option<usize> {
    let bytes = bytes.get(at..at.checked_add(size)?)?;
    let number = bytes.iter().rev().fold(0, |number, byte| number << 8 | u64::from(*byte));
    usize::try_from(number).ok()
}

/// A file's columns. Columns of a MAT file may differ in length.
#[derive(Debug, Clone, Default)]
pub(super) struct Table {
    /// The columns' names; `None` where the file has no header.
    pub(super) names: Option<Vec<String>>,
    /// The columns.
    pub(super) columns: Vec<Cells>,
    /// For text files the line (from 1) of every row.
    pub(super) lines: Vec<u64>,
    /// Assumptions made in reading it.
    pub(super) told: Vec<String>,
    /// Rows (from 0) that could not be read, and why: their cells are empty.
    pub(super) bad: Vec<(usize, String)>,
    /// Rows of the file in which no cell has a value: they are no rows of the table.
    pub(super) empty: EmptyRows,
    /// The parts of the recording that could not be read, in words.
    pub(super) lost: Option<String>,
    /// Why what is made of it is to be read with care.
    pub(super) doubts: Vec<String>,
    /// Objects of the file whose columns cannot be seen, with what to do about them.
    pub(super) hidden: Vec<String>,
    /// The units that the file names, by the places of their columns.
    pub(super) units: BTreeMap<usize, Declared>,
    /// The units that it names for all angles and angular velocities, whichever of its columns they are.
    pub(super) angles: Option<[&'static str; 2]>,
}

/// The unit that a file names of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Declared {
    /// As the file spells it.
    pub(super) unit: String,
    /// Whether it belongs to the type of the numbers, so that no other can be meant; else it is a word of
    /// somebody who may have been wrong.
    pub(super) is_type: bool,
}

/// Where a file has rows without any value. Each is a place at which no sample was taken.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct EmptyRows(Vec<EmptyStretch>);

/// Empty rows that follow each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct EmptyStretch {
    /// The row of the table (from 0) that they stand before; one past the last at the end.
    before: usize,
    /// The number of empty rows before that row, in the whole file.
    count: usize,
}

impl EmptyRows {
    /// The empty rows of a file of which every line is a row of the table or empty; `lines` are those
    /// of the table's rows.
    pub(super) fn between(lines: &[u64]) -> Self {
        let mut empty = Self::default();
        for (i, pair) in lines.windows(2).enumerate() {
            let passed = pair[1].saturating_sub(pair[0]).saturating_sub(1);
            empty.add(i + 1, usize::try_from(passed).unwrap_or(usize::MAX));
        }
        empty
    }

    /// Adds empty rows that stand before a row, behind all that were added.
    pub(super) fn add(&mut self, before: usize, count: usize) {
        if count > 0 {
            let count = self.0.last().map_or(0, |last| last.count).saturating_add(count);
            self.0.push(EmptyStretch { before, count });
        }
    }

    /// The number of empty rows before a row.
    pub(super) fn before(&self, row: usize) -> usize {
        let stretches = self.0.partition_point(|stretch| stretch.before <= row);
        stretches.checked_sub(1).map_or(0, |last| self.0[last].count)
    }
}

/// Most names that an error lists.
pub(super) const MOST_LISTED: usize = 20;

/// The first of these names, as an error lists them.
pub(super) fn listed(mut names: impl Iterator<Item = String>) -> String {
    let first: Vec<String> = names.by_ref().take(MOST_LISTED).collect();
    let more = if names.next().is_some() { ", …" } else { "" };
    first.join(", ") + more
}

impl Table {
    /// The place of a row among all rows of the file, empty ones included, from 0.
    pub(super) fn place(&self, row: usize) -> usize {
        row.saturating_add(self.empty.before(row))
    }

    /// Whether it has fewer rows than columns, as many as no device has signals in a text: then its rows
    /// are the signals. A matrix alone has neither names nor lines.
    pub(super) fn is_turned(&self) -> bool {
        const MOST_SIGNALS_OF_TEXT: usize = 256;
        let is_matrix = self.names.is_none() && self.lines.is_empty();
        let rows = self.columns.iter().map(Cells::len).max().unwrap_or(0);
        let most = if is_matrix { 0 } else { MOST_SIGNALS_OF_TEXT };
        rows < self.columns.len() && self.columns.len() > most
    }

    /// The place (from 0) of the column meant; `Err` says what there is instead.
    pub(super) fn find(&self, column: &ColumnRef) -> Result<usize, String> {
        let place = match (column, &self.names) {
            (ColumnRef::Position(n), _) => (1..=self.columns.len()).contains(n).then(|| n - 1),
            (ColumnRef::Name(_), None) => {
                let n = self.columns.len();
                return Err(format!(
                    "the file has no header; name the column by its position, 1 to {n}"
                ));
            }
            (ColumnRef::Name(name), Some(names)) => {
                // Formats other than text may have two columns of one name.
                if names.iter().filter(|n| *n == name).count() > 1 {
                    return Err(
                        "two columns have this name; name the one meant by its position".to_owned()
                    );
                }
                names.iter().position(|n| n == name)
            }
        };
        let index = place.ok_or_else(|| {
            let n = self.columns.len();
            let listing = match &self.names {
                None => format!("{n} columns"),
                Some(names) => {
                    let first: Vec<_> =
                        names.iter().take(MOST_LISTED).map(|name| shown(name)).collect();
                    let more = n > MOST_LISTED;
                    let rest = if more { format!(", … ({n} columns)") } else { String::new() };
                    first.join(", ") + &rest
                }
            };
            let hidden = self.hidden.first().map(|hidden| format!("; {hidden}"));
            let hidden = hidden.unwrap_or_default();
            format!("the column is missing; the file has {listing}{hidden}")
        })?;
        match &self.columns[index] {
            Cells::Unread => Err("the column was not read".to_owned()),
            Cells::Other(why) => Err(format!("the column cannot be used: {why}")),
            _ => Ok(index),
        }
    }

    /// The name of a column for people: its header, or its position.
    pub(super) fn name(&self, index: usize) -> String {
        shown(&self.full_name(index)).into_owned()
    }

    /// The header of a column, however long, or its position.
    pub(super) fn full_name(&self, index: usize) -> Cow<'_, str> {
        let named = self.names.as_ref().and_then(|names| names.get(index));
        named.map_or_else(
            || Cow::Owned((index + 1).to_string()),
            |name| Cow::Borrowed(name.as_str()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(names: Option<&[&str]>) -> Table {
        let cells = || Cells::Numbers(Float64Array::from(vec![Some(1.0), None]));
        let columns = vec![cells(), cells(), Cells::Other("a struct".to_owned())];
        let names = names.map(|n| n.iter().map(|s| (*s).to_owned()).collect());
        Table { names, columns, ..Table::default() }
    }

    #[test]
    fn a_row_has_its_place_among_the_empty_ones() {
        let empty = EmptyRows::between(&[2, 3, 6, 7, 9]);
        let table = Table { empty, ..table(None) };
        assert_eq!([0, 1, 2, 3, 4, 5].map(|row| table.place(row)), [0, 1, 4, 5, 7, 8]);
        let far = EmptyRows::between(&[1, u64::MAX, 5]);
        assert_eq!(
            (far.before(0), far.before(1), far.before(2)),
            (0, usize::MAX - 2, usize::MAX - 2)
        );
    }

    #[test]
    fn numbers_that_follow_each_other_are_those_that_are_read_one_by_one() {
        // Any bits, among them numbers that are none.
        let bytes: Vec<u8> = (0..720_u32).map(|i| (i * i + 7 * i) as u8).collect();
        let kinds = [NumberKind::Signed, NumberKind::Unsigned, NumberKind::Float];
        for (kind, size) in kinds.into_iter().flat_map(|kind| (1..=8).map(move |size| (kind, size)))
        {
            if kind == NumberKind::Float && ![4, 8].contains(&size) {
                continue;
            }
            for big in [false, true] {
                let number = Number { kind, size, big };
                let mut found = Vec::new();
                number.read_each(&bytes, |value| found.push(value.to_bits()));
                let expect = bytes.chunks_exact(size).map(|own| number.read(own).to_bits());
                assert!(found.into_iter().eq(expect), "{number:?}");
            }
        }
    }

    #[test]
    fn columns_are_found_by_name_and_by_position() {
        let table = table(Some(&["a", "b", "c"]));
        assert_eq!(table.find(&ColumnRef::Name("b".to_owned())), Ok(1));
        assert_eq!(table.find(&ColumnRef::Position(1)), Ok(0));
        assert_eq!(table.columns[0].cell(0), Cell::Number(1.0));
        assert_eq!(table.columns[0].cell(1), Cell::Empty);
    }

    #[test]
    fn what_cannot_be_found_is_said_with_what_there_is() {
        let check = |names, column, words: &str| {
            let error = table(names).find(&column).unwrap_err();
            assert!(error.contains(words), "{error}");
        };
        let name = |n: &str| ColumnRef::Name(n.to_owned());
        check(Some(&["a", "b", "c"]), name("x"), "missing; the file has a, b, c");
        check(Some(&["a", "a", "c"]), name("a"), "two columns");
        check(Some(&["a", "b", "c"]), name("c"), "a struct");
        check(None, name("a"), "no header");
        check(None, ColumnRef::Position(4), "3 columns");
    }
}
