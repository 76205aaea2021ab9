//! Checks the claims of a Parquet file before any memory is allocated for them.
//!
//! A few bytes can claim 10¹² rows, a list of 2³¹ row groups, or a page that unpacks to gigabytes;
//! the decoder reserves memory for these claims, and a failed reservation ends the process. So the
//! claims are read here first, by walking the structures of the footer and the headers of the pages
//! (Thrift's compact protocol; parquet-format, `parquet.thrift`: `FileMetaData`, `PageHeader`)
//! without keeping any of them.

use crate::StoreError;
use crate::disk::content::Content;
use bytes::Bytes;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};
use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::Path;
use std::string::FromUtf8Error;

/// Rows of one file: nine hours at 1 kHz; a column in memory takes 256 MiB.
pub const MOST_ROWS: usize = 1 << 25;
/// Numbers that are read of one recording at once: 1 GiB.
pub(crate) const MOST_VALUES: usize = 1 << 27;
/// Columns of one file: forty times those of a trial.
pub const MOST_COLUMNS: usize = 1 << 10;
/// Bytes of a column once unpacked, of a file that is decoded whole: four million numbers and as
/// much for their levels and dictionary.
pub const MOST_COLUMN_BYTES: u64 = 1 << 26;
/// Bytes of a column of a recording of ours, which is decoded part by part: [`MOST_ROWS`] numbers
/// and as much again.
pub(crate) const MOST_RECORDED_BYTES: u64 = 1 << 29;
/// Bytes of a footer: a thousand times a trial's.
const MOST_FOOTER: usize = 1 << 24;
/// Row groups: their numbers are 16 bits wide.
const MOST_GROUPS: usize = i16::MAX as usize;
/// Structures within each other, in a footer and in a schema: a reader goes down by calling itself.
const MOST_DEPTH: usize = 32;
/// The bytes a Parquet file begins and ends with.
const MAGIC: &[u8; 4] = b"PAR1";
/// Bytes behind the footer: its length and [`MAGIC`].
const TAIL: usize = 8;

/// Why a file cannot be read.
#[derive(Debug)]
pub(crate) enum Why {
    /// What is wrong with it, in words.
    Claim(String),
    /// The operating system does not give it: that says nothing of the file.
    System(io::Error),
}

impl From<String> for Why {
    fn from(words: String) -> Self {
        Self::Claim(words)
    }
}

impl From<&str> for Why {
    fn from(words: &str) -> Self {
        Self::Claim(words.to_owned())
    }
}

impl From<io::Error> for Why {
    fn from(error: io::Error) -> Self {
        match error.raw_os_error() {
            Some(_) => Self::System(error),
            // Of ours, and about the file: it is shorter than it claims to be.
            None => Self::Claim(error.to_string()),
        }
    }
}

/// Checks what the footer of a Parquet file claims, as far as the decoder would believe it.
///
/// # Errors
/// Why the file cannot be read, in words.
pub fn check_footer(bytes: &[u8]) -> Result<(), String> {
    claims_of(footer_of(bytes).ok_or(NO_FOOTER)?).map(drop)
}

/// The contents of a file's footer, except for the places of the columns.
pub(crate) struct FooterClaims {
    /// The bytes that are its schema.
    pub(crate) schema: Bytes,
    /// The claimed number of rows.
    pub(crate) rows: usize,
    /// Its keys and their values.
    pub(crate) entries: BTreeMap<String, String>,
}

/// [`check_footer`] of a file of which no more is read than that; what it says.
///
/// # Errors
/// Those of [`check_footer`]; the disk's.
pub(crate) fn check_footer_in(content: &Content) -> Result<FooterClaims, Why> {
    let end = content.length().checked_sub(TAIL as u64).ok_or(NO_FOOTER)?;
    let tail = content.range(end, TAIL)?;
    let (length, magic) = tail.split_first_chunk::<4>().ok_or(NO_FOOTER)?;
    let length = u32::from_le_bytes(*length) as usize;
    if magic != MAGIC || content.range(0, MAGIC.len())?.as_ref() != MAGIC {
        return Err(NO_FOOTER.into());
    }
    let from = end.checked_sub(length as u64).ok_or(NO_FOOTER)?;
    // Before it is read.
    check_length(length)?;
    let footer = content.range(from, length)?;
    let Claims { schema, rows, entries, .. } = claims_of(&footer)?;
    let entries = entries.into_iter().map(|(key, value)| {
        let [key, value] = [key, value].map(|bytes| String::from_utf8(footer[bytes].to_vec()));
        Ok((key?, value?))
    });
    let entries: Result<_, FromUtf8Error> = entries.collect();
    let entries = entries.map_err(|_| "its footer is no text")?;
    let rows = usize::try_from(rows).unwrap_or(0);
    Ok(FooterClaims { schema: footer.slice(schema), rows, entries })
}

const NO_FOOTER: &str = "its end is missing: it was cut short, or is not a Parquet file";

fn check_length(bytes: usize) -> Result<(), String> {
    match bytes > MOST_FOOTER {
        true => Err(format!("its footer has {bytes} bytes, and at most {MOST_FOOTER} are read")),
        false => Ok(()),
    }
}

/// The claims of a footer, if they can be believed.
fn claims_of(footer: &[u8]) -> Result<Claims, String> {
    check_length(footer.len())?;
    let mut claims = Claims::default();
    // In `FileMetaData` field 2 is the schema, 3 the number of rows, 4 the row groups, and 5 the entries.
    Walk { bytes: footer, at: 0 }
        .fields(0, &mut |walk, field, kind| match (field, kind) {
            (2, LIST) => {
                let from = walk.at;
                walk.list(&mut |walk, _| walk.schema_element(&mut claims.children))?;
                claims.schema = from..walk.at;
                Some(())
            }
            (3, I64) => walk.zigzag().map(|rows| claims.rows = rows),
            (4, LIST) => walk.list(&mut |walk, kind| {
                claims.groups += 1;
                walk.skip(kind, 1)
            }),
            (5, LIST) => walk.list(&mut |walk, kind| match kind {
                STRUCT => walk.entry().map(|entry| claims.entries.push(entry)),
                _ => walk.skip(kind, 1),
            }),
            _ => walk.skip(kind, 0),
        })
        .ok_or("its footer is damaged")?;
    if claims.groups > MOST_GROUPS {
        return Err(format!("it has more than {MOST_GROUPS} row groups"));
    }
    if depth(&claims.children).is_none_or(|depth| depth > MOST_DEPTH) {
        return Err(format!("its columns are nested more than {MOST_DEPTH} deep"));
    }
    Ok(claims)
}

/// Checks the number of rows and columns, and that the row groups have as many, by the footer's
/// metadata.
///
/// # Errors
/// The number and the limit.
pub(crate) fn check_size(
    path: &Path,
    metadata: &ParquetMetaData,
    remedy: &str,
) -> Result<(), StoreError> {
    let columns = metadata.file_metadata().schema_descr().num_columns();
    let rows = metadata.file_metadata().num_rows();
    // The decoder goes by the groups, and a run of one value takes a few bytes whatever its length.
    let left = metadata.row_groups().iter().try_fold(rows, |left, group| {
        let n = group.num_rows();
        (0..=left).contains(&n).then(|| left - n)
    });
    let what = if columns > MOST_COLUMNS {
        format!("the file claims {columns} columns, and at most {MOST_COLUMNS} are read")
    } else if !usize::try_from(rows).is_ok_and(|rows| rows <= MOST_ROWS) {
        format!("the file claims {rows} rows, and at most {MOST_ROWS} are read")
    } else if left != Some(0) {
        format!("the file claims {rows} rows, and its row groups others")
    } else {
        return Ok(());
    };
    Err(StoreError::new(path, what, remedy))
}

/// Checks the pages of the columns that `wanted` picks by their place: their unpacked size, and
/// that they are in the file. Returns their unpacked size together, bytes.
///
/// # Errors
/// Why the column cannot be read, in words.
pub fn check_pages(
    bytes: &[u8],
    metadata: &ParquetMetaData,
    wanted: impl Fn(usize) -> bool,
) -> Result<u64, String> {
    let unpacked = check_each_chunk(
        |from, length| {
            let from = usize::try_from(from).ok();
            Ok(from.and_then(|from| bytes.get(from..from.checked_add(length)?)))
        },
        metadata,
        MOST_COLUMN_BYTES,
        wanted,
    );
    unpacked.map_err(|why| match why {
        Why::Claim(words) => words,
        Why::System(error) => error.to_string(),
    })
}

/// [`check_pages`] of a file of which one column chunk is read at a time; a column may unpack to
/// `most` bytes.
///
/// # Errors
/// Those of [`check_pages`]; the disk's.
pub(crate) fn check_pages_in(
    content: &Content,
    metadata: &ParquetMetaData,
    most: u64,
    wanted: impl Fn(usize) -> bool,
) -> Result<u64, Why> {
    check_each_chunk(
        |from, length| match content.range(from, length) {
            Err(error) if error.raw_os_error().is_some() => Err(Why::System(error)),
            read => Ok(read.ok()),
        },
        metadata,
        most,
        wanted,
    )
}

/// `pages_at` gives the bytes of a file from a place on, so many of them, if it has them.
fn check_each_chunk<B: AsRef<[u8]>>(
    pages_at: impl Fn(u64, usize) -> Result<Option<B>, Why>,
    metadata: &ParquetMetaData,
    most: u64,
    wanted: impl Fn(usize) -> bool,
) -> Result<u64, Why> {
    let mut unpacked = vec![0_u64; metadata.file_metadata().schema_descr().num_columns()];
    for group in metadata.row_groups() {
        for (place, column) in
            group.columns().iter().enumerate().filter(|(place, _)| wanted(*place))
        {
            let pages = match place_of(column) {
                Some((from, length)) => pages_at(from, length)?,
                None => None,
            };
            let Some(length) = pages.and_then(|pages| unpacked_length(pages.as_ref())) else {
                let name = column.column_path().string();
                return Err(format!("the pages of column {name} are damaged").into());
            };
            // Over all row groups: the values of a column are joined in memory.
            unpacked[place] = unpacked[place].saturating_add(length);
            if unpacked[place] > most {
                let name = column.column_path().string();
                return Err(format!("column {name} unpacks to more than {most} bytes").into());
            }
        }
    }
    Ok(unpacked.iter().fold(0, |sum, n| sum.saturating_add(*n)))
}

/// Where a column chunk begins in its file, and how many bytes it has.
pub(crate) fn place_of(column: &ColumnChunkMetaData) -> Option<(u64, usize)> {
    // A dictionary, where there is one, lies before the data.
    let first = column.dictionary_page_offset().unwrap_or(i64::MAX).min(column.data_page_offset());
    Some((u64::try_from(first).ok()?, usize::try_from(column.compressed_size()).ok()?))
}

/// What the pages of a column chunk claim to unpack to, bytes.
fn unpacked_length(pages: &[u8]) -> Option<u64> {
    let mut rest = pages;
    let mut total = 0_u64;
    while !rest.is_empty() {
        let header = page_header(rest)?;
        total = total.saturating_add(u64::try_from(header.unpacked).ok()?);
        rest = header.page_and_rest(rest)?.1;
    }
    Some(total)
}

/// The header of a page, as far as it matters for a column without lists.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PageHeader {
    /// Bytes of the header itself.
    length: usize,
    /// 0 for data, 2 for a dictionary; others are of later versions.
    pub(crate) kind: i64,
    /// Bytes of the page once unpacked.
    pub(crate) unpacked: i64,
    /// Bytes of the page in the file.
    packed: i64,
    /// The number of values.
    pub(crate) values: i64,
    /// The encoding of the values.
    pub(crate) encoding: i64,
    /// The encoding of the nulls.
    pub(crate) nulls: i64,
}

impl PageHeader {
    /// The page that follows its header at the beginning of `bytes`, and what follows it.
    pub(crate) fn page_and_rest<'a>(&self, bytes: &'a [u8]) -> Option<(&'a [u8], &'a [u8])> {
        bytes.get(self.length..)?.split_at_checked(usize::try_from(self.packed).ok()?)
    }
}

/// The header that `bytes` begin with.
pub(crate) fn page_header(bytes: &[u8]) -> Option<PageHeader> {
    let mut header = PageHeader::default();
    let mut walk = Walk { bytes, at: 0 };
    // In `PageHeader` 1 is the kind, 2 the size unpacked, 3 the one in the file, 5 what data has besides,
    // and 7 what a dictionary has; in both of these 1 is the number of values, and 2 their encoding.
    walk.fields(0, &mut |walk, field, kind| match (field, kind) {
        (1, I32) => walk.zigzag().map(|kind| header.kind = kind),
        (2, I32) => walk.zigzag().map(|size| header.unpacked = size),
        (3, I32) => walk.zigzag().map(|size| header.packed = size),
        (5 | 7, STRUCT) => walk.fields(1, &mut |walk, field, kind| match (field, kind) {
            (1, I32) => walk.zigzag().map(|n| header.values = n),
            (2, I32) => walk.zigzag().map(|encoding| header.encoding = encoding),
            (3, I32) => walk.zigzag().map(|encoding| header.nulls = encoding),
            _ => walk.skip(kind, 1),
        }),
        _ => walk.skip(kind, 0),
    })?;
    header.length = walk.at;
    Some(header)
}

/// How many ones levels say that there are, where they are one run of them: twice its length, then the
/// level.
pub(crate) fn run_of_ones(levels: &[u8]) -> Option<u64> {
    let mut walk = Walk { bytes: levels, at: 0 };
    let run = walk.varint()?;
    let level = walk.byte()?;
    // An odd number begins values that are packed bit by bit (parquet-format, `Encodings.md`, RLE).
    (run & 1 == 0 && level == 1 && walk.at == levels.len()).then_some(run >> 1)
}

fn footer_of(bytes: &[u8]) -> Option<&[u8]> {
    let (body, tail) = bytes.split_at_checked(bytes.len().checked_sub(TAIL)?)?;
    let (length, magic) = tail.split_first_chunk::<4>()?;
    let length = u32::from_le_bytes(*length) as usize;
    let whole = magic == MAGIC && body.starts_with(MAGIC);
    body.get(body.len().checked_sub(length)?..).filter(|_| whole)
}

#[derive(Default)]
struct Claims {
    /// Where the schema lies.
    schema: Range<usize>,
    rows: i64,
    /// Where keys and their values lie.
    entries: Vec<(Range<usize>, Range<usize>)>,
    groups: usize,
    /// The number of children of each schema element, in the order in which a tree is walked.
    children: Vec<usize>,
}

/// How deep a schema is nested; nothing if its numbers of children fit no tree.
fn depth(children: &[usize]) -> Option<usize> {
    let mut open: Vec<usize> = Vec::new();
    let mut deepest = 0;
    for n in children {
        if let Some(parent) = open.last_mut() {
            *parent = parent.checked_sub(1)?;
        }
        open.push(*n);
        deepest = deepest.max(open.len());
        if deepest > MOST_DEPTH {
            return Some(deepest);
        }
        while open.last() == Some(&0) {
            open.pop();
        }
    }
    Some(deepest)
}

// Types of Thrift's compact protocol.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const I16: u8 = 4;
const I32: u8 = 5;
const I64: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const STRUCT: u8 = 12;
/// Bytes of a double.
const DOUBLE_BYTES: usize = 8;
/// A length in the upper half of a list's first byte that says that the length follows.
const LONG: u8 = 15;

/// A place in a structure. Each step is nothing where the bytes end too early or make no sense.
struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Walk<'_> {
    fn byte(&mut self) -> Option<u8> {
        let byte = *self.bytes.get(self.at)?;
        self.at += 1;
        Some(byte)
    }

    fn varint(&mut self) -> Option<u64> {
        /// Seven bits a byte: ten bytes hold 64.
        const BITS: u32 = 7;
        let mut value = 0;
        for shift in (0..u64::BITS).step_by(BITS as usize) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(value);
            }
        }
        None
    }

    fn zigzag(&mut self) -> Option<i64> {
        let n = self.varint()?;
        // The lowest bit is the sign.
        Some((n >> 1).cast_signed() ^ -(n & 1).cast_signed())
    }

    fn pass(&mut self, n: usize) -> Option<()> {
        self.at = self.at.checked_add(n).filter(|at| *at <= self.bytes.len())?;
        Some(())
    }

    /// Walks the fields of a structure; `field` gets each one's number and type, and must walk its
    /// value.
    fn fields(
        &mut self,
        depth: usize,
        field: &mut dyn FnMut(&mut Self, i64, u8) -> Option<()>,
    ) -> Option<()> {
        let mut number = 0;
        if depth > MOST_DEPTH {
            return None;
        }
        loop {
            let head = self.byte()?;
            // A structure ends with a stop field.
            if head == 0 {
                return Some(());
            }
            number = match head >> 4 {
                // Too far for four bits: the number itself follows.
                0 => self.zigzag()?,
                step => i64::from(step).checked_add(number)?,
            };
            field(self, number, head & 0x0f)?;
        }
    }

    /// Walks a list; `element` gets the type, and must walk one. No list has more elements than
    /// bytes follow.
    fn list(&mut self, element: &mut dyn FnMut(&mut Self, u8) -> Option<()>) -> Option<()> {
        let head = self.byte()?;
        let length = match head >> 4 {
            LONG => usize::try_from(self.varint()?).ok()?,
            short => usize::from(short),
        };
        if length > self.bytes.len() - self.at {
            return None;
        }
        (0..length).try_for_each(|_| element(self, head & 0x0f))
    }

    fn skip(&mut self, kind: u8, depth: usize) -> Option<()> {
        match kind {
            _ if depth > MOST_DEPTH => None,
            // The type is the value.
            TRUE | FALSE => Some(()),
            BYTE => self.pass(1),
            I16 | I32 | I64 => self.varint().map(drop),
            DOUBLE => self.pass(DOUBLE_BYTES),
            BINARY => self.binary().map(drop),
            LIST | SET => self.list(&mut |walk, kind| match kind {
                TRUE | FALSE => walk.pass(1), // in a list a truth value has a byte of its own
                _ => walk.skip(kind, depth + 1),
            }),
            STRUCT => self.fields(depth + 1, &mut |walk, _, kind| walk.skip(kind, depth + 1)),
            _ => None,
        }
    }

    /// Walks bytes that follow their length: where they lie.
    fn binary(&mut self) -> Option<Range<usize>> {
        let length = usize::try_from(self.varint()?).ok()?;
        let from = self.at;
        self.pass(length)?;
        Some(from..self.at)
    }

    /// Walks a key with its value, which is empty where there is none.
    fn entry(&mut self) -> Option<(Range<usize>, Range<usize>)> {
        let mut key = 0..0;
        let mut value = 0..0;
        // In `KeyValue` 1 is the key, and 2 the value.
        self.fields(1, &mut |walk, field, kind| match (field, kind) {
            (1, BINARY) => walk.binary().map(|bytes| key = bytes),
            (2, BINARY) => walk.binary().map(|bytes| value = bytes),
            _ => walk.skip(kind, 2),
        })?;
        Some((key, value))
    }

    /// Walks an element of the schema and notes its number of children.
    fn schema_element(&mut self, children: &mut Vec<usize>) -> Option<()> {
        let mut n = 0;
        // In `SchemaElement` field 5 is the number of children; a column has none.
        self.fields(1, &mut |walk, field, kind| match (field, kind) {
            (5, I32) => {
                walk.zigzag().and_then(|count| usize::try_from(count).ok()).map(|count| n = count)
            }
            _ => walk.skip(kind, 1),
        })?;
        children.push(n);
        Some(())
    }
}

#[cfg(test)]
mod tests;
