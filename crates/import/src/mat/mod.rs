//! MAT files of version 5 (MATLAB `-v6` and `-v7`; SciPy, Octave): real numeric variables.
//!
//! Source of the format: MathWorks, "MAT-File Format" (R2024b), "Level 5 MAT-File Format".

use super::limits::{MOST_COLUMNS, MOST_NAME, MOST_UNPACKED, Take, shown};
use super::table::{Cells, Table};
use arrow::array::Float64Array;
use flate2::read::ZlibDecoder;
use std::io::Read as _;
use std::path::Path;
use zwidth_store::StoreError;

/// Length of the header; its last two bytes give the byte order, the two before the version.
const HEADER: usize = 128;
/// Elements begin at multiples of this many bytes.
const ALIGN: usize = 8;
/// Most bytes that a small element carries in its tag.
const SMALL: usize = 4;

/// Data types of elements (table "MAT-File Data Types").
mod mi {
    pub(super) const INT8: u32 = 1;
    pub(super) const UINT8: u32 = 2;
    pub(super) const INT16: u32 = 3;
    pub(super) const UINT16: u32 = 4;
    pub(super) const INT32: u32 = 5;
    pub(super) const UINT32: u32 = 6;
    pub(super) const SINGLE: u32 = 7;
    pub(super) const DOUBLE: u32 = 9;
    pub(super) const INT64: u32 = 12;
    pub(super) const UINT64: u32 = 13;
    pub(super) const MATRIX: u32 = 14;
    pub(super) const COMPRESSED: u32 = 15;
}

/// Flag of a complex array, in the array flags.
const COMPLEX: u32 = 0x0800;

/// Most bytes of the beginning of a variable: its flags, its size in [`MOST_DIMENSIONS`], its name.
const HEAD: u64 = 2 * MOST_NAME as u64;
/// Most dimensions of a variable.
const MOST_DIMENSIONS: usize = 32;

/// Reads a MAT file: its vectors by name, or with `matrix` the columns of that variable by
/// position.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    matrix: Option<&str>,
    take: &Take,
) -> Result<Table, StoreError> {
    let remedy =
        "the file may be cut off or damaged; save it again with -v7, without what is not needed";
    let cannot = |what| StoreError::new(path, format!("not a readable MAT file: {what}"), remedy);
    let Some(matrix) = matrix else {
        let mut table = Table { names: Some(Vec::new()), ..Table::default() };
        variables(bytes, &mut |head, data| {
            let place = table.columns.len();
            let cells = if take.wants(place, Some(&head.name)) {
                vector(head, data, take)
            } else {
                Ok(Cells::Unread)
            };
            table.columns.push(cells?);
            table.names.get_or_insert_default().push(head.name.clone());
            Ok(())
        })
        .map_err(cannot)?;
        return Ok(table);
    };
    let (mut names, mut found) = (Vec::new(), None);
    variables(bytes, &mut |head, data| {
        // The first of the name: nothing keeps a file from having two.
        if head.name == matrix && found.is_none() {
            found = Some(columns(head, data, take)?);
        }
        names.push(shown(&head.name).into_owned());
        Ok(())
    })
    .map_err(cannot)?;
    let missing = || format!("the variable is missing; the file has {}", names.join(", "));
    let table = found.unwrap_or_else(|| Err(missing()));
    table.map_err(|what| {
        StoreError::new(path, what, "set matrix in [file] to a numeric matrix of the file")
            .column(matrix)
    })
}

/// What a variable says of itself before its values.
struct Head {
    name: String,
    size: Vec<usize>,
    /// What it is where it is not a real numeric array.
    class: Option<&'static str>,
}

/// The values of a variable, not decoded yet.
struct Numbers<'a> {
    kind: u32,
    data: &'a [u8],
    big: bool,
}

/// Gives the values of the variable at hand; only who asks has them unpacked.
type Values<'a> = &'a dyn Fn(&mut dyn FnMut(Numbers) -> Option<()>) -> Result<(), String>;

/// A variable as a column: its values if it is a vector of numbers, else why not.
fn vector(head: &Head, values: Values, take: &Take) -> Result<Cells, String> {
    if let Some(class) = head.class {
        return Ok(Cells::Other(format!(
            "it is {class}; save what is wanted of it as a numeric variable"
        )));
    }
    if head.size.iter().filter(|n| **n != 1).count() > 1 {
        let size = head.size.iter().map(usize::to_string).collect::<Vec<_>>().join(" × ");
        return Ok(Cells::Other(format!(
            "it is a {size} matrix; name it as matrix in [file] to use its columns"
        )));
    }
    let mut cells = Cells::Unread;
    let mut fits = true;
    values(&mut |numbers| {
        let n = numbers.count()?;
        fits = take.budget.cells(n);
        if fits && Some(n) == head.count() {
            cells = Cells::Numbers(Float64Array::from(numbers.values(0, n)?));
        }
        // Nothing means damage; what does not fit is told below.
        (!fits || matches!(cells, Cells::Numbers(_))).then_some(())
    })?;
    if fits { Ok(cells) } else { Err(TOO_MUCH.to_owned()) }
}

/// A matrix' columns by position, or why it has none.
fn columns(head: &Head, values: Values, take: &Take) -> Result<Result<Table, String>, String> {
    if let Some(class) = head.class {
        return Ok(Err(format!("the variable is {class}")));
    }
    let &[rows, columns] = head.size.as_slice() else {
        return Ok(Err(format!("the variable has {} dimensions where 2 belong", head.size.len())));
    };
    if columns > MOST_COLUMNS {
        return Err(format!(
            "the matrix has {columns} columns, and at most {MOST_COLUMNS} are read"
        ));
    }
    let mut table = Table::default();
    let mut fits = true;
    values(&mut |numbers| {
        let whole = numbers.count() == head.count();
        for place in (0..columns).filter(|_| whole && rows > 0) {
            let wanted = take.wants(place, None);
            fits = fits && (!wanted || take.budget.cells(rows));
            table.columns.push(match wanted && fits {
                true => Cells::Numbers(Float64Array::from(numbers.values(place * rows, rows)?)),
                false => Cells::Unread,
            });
        }
        whole.then_some(())
    })?;
    if fits { Ok(Ok(table)) } else { Err(TOO_MUCH.to_owned()) }
}

/// Stands for the error of the budget, which takes its place.
const TOO_MUCH: &str = "it has more values than are read";

/// Goes through the variables of a file.
fn variables(
    bytes: &[u8],
    each: &mut dyn FnMut(&Head, Values) -> Result<(), String>,
) -> Result<(), String> {
    let header = bytes.get(..HEADER).ok_or("it is shorter than a MAT header")?;
    let big = match &header[HEADER - 2..] {
        b"IM" => false,
        b"MI" => true,
        _ => {
            return Err(
                "its header gives no byte order; only version 5 is read (save with -v7)".to_owned()
            );
        }
    };
    // The high byte of 0x0100, of 0x0200 in version 7.3; each order has it at another place.
    let version = header[if big { HEADER - 4 } else { HEADER - 3 }];
    if version != 1 {
        return Err("it is a version 7.3 (HDF5) file; save it with -v7".to_owned());
    }
    let mut elements = Elements { bytes: &bytes[HEADER..], big };
    let mut last: Option<String> = None;
    for count in 1.. {
        if elements.bytes.is_empty() {
            break;
        }
        if count > MOST_COLUMNS {
            return Err(format!("it has more than {MOST_COLUMNS} variables, and no more are read"));
        }
        let damaged = || match &last {
            None => "its first variable is cut off or damaged".to_owned(),
            Some(name) => format!("it is cut off or damaged after variable '{}'", shown(name)),
        };
        let (kind, data) = elements.next().ok_or_else(damaged)?;
        // Of a compressed variable only the beginning is unpacked, until its values are asked for.
        let beginning = match kind {
            mi::MATRIX => Vec::new(),
            mi::COMPRESSED => inflate(data, HEAD).ok_or_else(damaged)?,
            _ => return Err(damaged()),
        };
        let (size, plain) = match kind {
            mi::MATRIX => (data.len() as u64, data),
            _ => matrix_tag(&beginning, big).ok_or_else(damaged)?,
        };
        let (head, _) = head(plain, big).ok_or_else(damaged)?;
        each(&head, &|take| match kind {
            mi::MATRIX => real_part(data, big).and_then(&mut *take).ok_or_else(damaged),
            _ => {
                if size > MOST_UNPACKED {
                    let name = shown(&head.name);
                    return Err(format!(
                        "variable '{name}' unpacks to {size} bytes, and at most {MOST_UNPACKED} are read"
                    ));
                }
                let plain = inflate(data, ALIGN as u64 + size).ok_or_else(damaged)?;
                let matrix = Elements { bytes: &plain, big }.next().map(|(_, data)| data);
                matrix
                    .and_then(|data| real_part(data, big))
                    .and_then(&mut *take)
                    .ok_or_else(damaged)
            }
        })?;
        last = Some(head.name);
    }
    Ok(())
}

/// The first bytes of a compressed element, at most `most`: what it claims of its size decides
/// nothing.
fn inflate(data: &[u8], most: u64) -> Option<Vec<u8>> {
    let mut plain = Vec::new();
    ZlibDecoder::new(data).take(most).read_to_end(&mut plain).ok()?;
    Some(plain)
}

/// The elements of a stretch of bytes, one after the other.
struct Elements<'a> {
    bytes: &'a [u8],
    big: bool,
}

impl<'a> Elements<'a> {
    /// The next element's type and data; `None` where it is cut off.
    fn next(&mut self) -> Option<(u32, &'a [u8])> {
        let first = word(self.bytes.get(..4)?.try_into().ok()?, self.big);
        // A small element has its length in the upper half of the word that holds its type.
        let (small, kind) = ((first >> 16) as usize, first & 0xffff);
        if small > 0 {
            let data = self.bytes.get(4..2 * SMALL)?.get(..small)?;
            self.bytes = &self.bytes[2 * SMALL..];
            return Some((kind, data));
        }
        let size = word(self.bytes.get(4..8)?.try_into().ok()?, self.big) as usize;
        let end = ALIGN.checked_add(size)?;
        let data = self.bytes.get(ALIGN..end)?;
        // Compressed elements follow each other without padding; the last one of all may lack it.
        let next = if first == mi::COMPRESSED { end } else { end.next_multiple_of(ALIGN) };
        self.bytes = self.bytes.get(next..).unwrap_or_default();
        Some((first, data))
    }
}

fn word(bytes: [u8; 4], big: bool) -> u32 {
    if big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
}

/// The size that the tag of a matrix gives, bytes, and what follows the tag.
fn matrix_tag(bytes: &[u8], big: bool) -> Option<(u64, &[u8])> {
    let (tag, data) = bytes.split_at_checked(ALIGN)?;
    let word = |at: usize| Some(word(tag.get(at..at + 4)?.try_into().ok()?, big));
    (word(0)? == mi::MATRIX).then_some((u64::from(word(4)?), data))
}

/// What a matrix says of itself, and the elements behind.
fn head(data: &[u8], big: bool) -> Option<(Head, Elements<'_>)> {
    let mut parts = Elements { bytes: data, big };
    let (_, flags) = parts.next()?;
    let flags = word(flags.get(..4)?.try_into().ok()?, big);
    let (kind, size) = parts.next()?;
    let size = Numbers { kind, data: size, big };
    let dimensions = size.count().filter(|n| *n <= MOST_DIMENSIONS)?;
    let size = size.values(0, dimensions)?.into_iter().map(whole).collect::<Option<Vec<_>>>()?;
    let (_, name) = parts.next()?;
    let name = String::from_utf8_lossy(name.get(..MOST_NAME).unwrap_or(name)).into_owned();
    Some((Head { name, size, class: not_numeric(flags) }, parts))
}

/// The values of a matrix, as they lie in the file.
fn real_part(data: &[u8], big: bool) -> Option<Numbers<'_>> {
    let (kind, data) = head(data, big)?.1.next()?;
    Some(Numbers { kind, data, big })
}

impl Head {
    /// How many values the variable has, by its size.
    fn count(&self) -> Option<usize> {
        self.size.iter().try_fold(1_usize, |n, d| n.checked_mul(*d))
    }
}

/// What the array is where it is not a real numeric one (table "MATLAB Array Types").
fn not_numeric(flags: u32) -> Option<&'static str> {
    match flags & 0xff {
        1 => Some("a cell array"),
        2 => Some("a struct"),
        4 => Some("text"),
        5 => Some("a sparse matrix"),
        6..=15 if flags & COMPLEX != 0 => Some("complex"),
        6..=15 => None,
        _ => Some("an object"),
    }
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn whole(value: f64) -> Option<usize> {
    (value >= 0.0 && value.fract() == 0.0).then_some(value as usize)
}

/// MATLAB stores whole numbers in the smallest type that holds them.
impl Numbers<'_> {
    /// Bytes of a value.
    fn width(&self) -> Option<usize> {
        match self.kind {
            mi::INT8 | mi::UINT8 => Some(1),
            mi::INT16 | mi::UINT16 => Some(2),
            mi::INT32 | mi::UINT32 | mi::SINGLE => Some(4),
            mi::DOUBLE | mi::INT64 | mi::UINT64 => Some(8),
            _ => None,
        }
    }

    /// How many values there are.
    fn count(&self) -> Option<usize> {
        Some(self.data.len() / self.width()?)
    }

    /// `n` values from the one at `from` on.
    #[allow(clippy::cast_precision_loss)]
    fn values(&self, from: usize, n: usize) -> Option<Vec<f64>> {
        let width = self.width()?;
        let data =
            self.data.get(from.checked_mul(width)?..from.checked_add(n)?.checked_mul(width)?)?;
        let big = self.big;
        macro_rules! all {
            ($type:ty) => {
                data.chunks_exact(size_of::<$type>())
                    .map(|chunk| {
                        let bytes = chunk.try_into().ok()?;
                        let value = if big {
                            <$type>::from_be_bytes(bytes)
                        } else {
                            <$type>::from_le_bytes(bytes)
                        };
                        Some(value as f64)
                    })
                    .collect()
            };
        }
        match self.kind {
            mi::INT8 => all!(i8),
            mi::UINT8 => all!(u8),
            mi::INT16 => all!(i16),
            mi::UINT16 => all!(u16),
            mi::INT32 => all!(i32),
            mi::UINT32 => all!(u32),
            mi::SINGLE => all!(f32),
            mi::DOUBLE => all!(f64),
            mi::INT64 => all!(i64),
            mi::UINT64 => all!(u64),
            _ => None,
        }
    }
}

#[cfg(test)]
pub(super) mod tests;
