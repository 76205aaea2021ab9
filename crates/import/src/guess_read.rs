//! Reading a recording of which nothing is known yet: how its text is written, and its first
//! columns.

use super::csv::{Dialect, WHITE_SPACE};
use super::format::{Format, FormatOptions};
use super::limits::{Budget, MOST_FILE, Take};
use super::plain::is_labchart;
use super::recording::number;
use super::shape::XdfClock;
use super::table::{ColumnRef, Table};
use super::text::{Encoding, check_readable, decode, is_windows_1252};
use std::io::Read as _;
use std::path::Path;
use zwidth_store::{StoreError, open_named, read_named};

/// Columns that are looked at: more are not one recording's.
pub(super) const MOST_GUESSED: usize = 64;
/// Lines and rows that are looked at.
pub(super) const LOOKED_AT: usize = 200;
/// Bytes of a text that tell its header (64 KiB).
const HEAD: u64 = 1 << 16;
/// Lines before the header, at most.
const MOST_PREAMBLE: usize = 50;
/// What stands between cells, the likeliest first.
const DELIMITERS: [u8; 5] = [b'\t', b';', b',', b'|', WHITE_SPACE];

/// How a text is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Written {
    pub(super) encoding: Encoding,
    pub(super) delimiter: u8,
    pub(super) decimal_comma: bool,
    pub(super) header: bool,
    pub(super) skip: usize,
    /// What a line of remarks begins with.
    pub(super) comment: Option<u8>,
}

/// What lines of remarks begin with.
const REMARKS: [u8; 3] = [b'%', b'#', b'!'];

/// A recording, its form guessed.
pub(super) struct Looked {
    pub(super) table: Table,
    /// Its format, where its name does not tell.
    pub(super) format: Option<Format>,
    /// How it is written, if it is delimited text.
    pub(super) written: Option<Written>,
}

/// Reads a recording whole.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn look(path: &Path) -> Result<Looked, StoreError> {
    let bytes = read_named(path, MOST_FILE).map_err(|e| StoreError::io(path, "read", &e))?;
    looked(path, bytes)
}

/// Reads of a text only so much as tells its header, and any other format whole.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn look_at_head(path: &Path) -> Result<Looked, StoreError> {
    if !is_delimited(format_of(path).1) {
        return look(path);
    }
    let mut bytes = Vec::new();
    open_named(path)
        .and_then(|file| file.take(HEAD).read_to_end(&mut bytes))
        .map_err(|e| StoreError::io(path, "read", &e))?;
    if bytes.len() as u64 == HEAD {
        // A line that is cut off is no line, and half a letter no letter.
        let end = bytes.iter().rposition(|byte| *byte == b'\n').map_or(bytes.len(), |at| at + 1);
        bytes.truncate(end);
        if encoding(&bytes) == Encoding::Utf16 {
            bytes.truncate(bytes.len() / 2 * 2);
        }
    }
    looked(path, bytes)
}

/// The format that a name tells, and the one to read it by.
fn format_of(path: &Path) -> (Option<Format>, Format) {
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let named = Format::ALL.into_iter().find(|f| f.extensions().contains(&extension.as_str()));
    (named, named.unwrap_or(Format::Txt))
}

fn is_delimited(format: Format) -> bool {
    matches!(format, Format::Csv | Format::Tsv | Format::Txt)
}

fn looked(path: &Path, bytes: Vec<u8>) -> Result<Looked, StoreError> {
    check_readable(path, &bytes)?;
    let (named, format) = format_of(path);
    let encoding = encoding(&bytes);
    let written = match is_delimited(format) {
        true => written(&decode(path, &bytes, encoding)?, encoding),
        false => Written {
            encoding,
            delimiter: b',',
            decimal_comma: false,
            header: true,
            skip: 0,
            comment: None,
        },
    };
    let dialect = Dialect {
        delimiter: written.delimiter,
        header: written.header,
        comment: written.comment,
        skip: written.skip,
        encoding,
        bad_lines: usize::MAX,
        before: 0,
    };
    let columns: Vec<ColumnRef> = (1..=MOST_GUESSED).map(ColumnRef::Position).collect();
    let budget = Budget::default();
    let take = Take { columns: columns.iter().collect(), pattern: None, budget: &budget };
    let table = format.read(
        path,
        bytes,
        FormatOptions { dialect, part: None, clock: XdfClock::Corrected, dejitter: true },
        &take,
    )?;
    let (format, written) =
        (named.is_none().then_some(format), is_delimited(format).then_some(written));
    Ok(Looked { table, format, written })
}

/// UTF-8 where the bytes are, and else Windows-1252 where only that has letters for them, or Latin-1,
/// in which any bytes are text.
fn encoding(bytes: &[u8]) -> Encoding {
    let marked = bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff");
    // Half of the bytes of plain letters are 0 in UTF-16.
    let zeros = bytes.iter().take(LOOKED_AT).filter(|b| **b == 0).count();
    if !marked && 4 * zeros > bytes.len().min(LOOKED_AT) {
        return Encoding::Utf16;
    }
    match bytes {
        bytes if marked || std::str::from_utf8(bytes).is_ok() => Encoding::Utf8,
        bytes if is_windows_1252(bytes) => Encoding::Windows1252,
        _ => Encoding::Latin1,
    }
}

/// How a delimited text is written. Lines of remarks are left out, unless the header is one.
fn written(text: &str, encoding: Encoding) -> Written {
    let first = text.trim_start_matches('\u{feff}').as_bytes().first();
    let whole = || form(text, encoding);
    let Some(mark) = REMARKS.into_iter().find(|mark| first == Some(mark)) else { return whole() };
    let rest = text.lines().filter(|line| line.as_bytes().first() != Some(&mark));
    let rest = form(&Vec::from_iter(rest).join("\n"), encoding);
    if rest.header { Written { comment: Some(mark), ..rest } } else { whole() }
}

/// The delimiter that parts most lines into the same number of cells, the most of them, and what
/// follows from it.
fn form(text: &str, encoding: Encoding) -> Written {
    let lines: Vec<&str> =
        text.lines().filter(|line| !line.trim().is_empty()).take(LOOKED_AT).collect();
    let of = |delimiter: u8| {
        let counts: Vec<usize> = lines.iter().map(|line| cells(line, delimiter).len()).collect();
        let usual = counts.last().copied().unwrap_or(1);
        (counts.iter().filter(|n| **n == usual && usual > 1).count(), delimiter)
    };
    let best = DELIMITERS
        .into_iter()
        .map(of)
        .fold((0, b','), |best, next| if next.0 > best.0 { next } else { best });
    let (delimiter, last) = (best.1, lines.last().copied().unwrap_or_default());
    let width = cells(last, delimiter).len();
    // A comma that is no delimiter and stands between digits is one before decimals.
    let has_comma = |cell: &&str| number(cell, false).is_err() && number(cell, true).is_ok();
    let decimal_comma = delimiter != b',' && cells(last, delimiter).iter().any(has_comma);
    let mut all = text.lines();
    let fits = |line: &str| !line.trim().is_empty() && cells(line, delimiter).len() + 1 >= width;
    let skip = all.position(fits).filter(|skip| *skip <= MOST_PREAMBLE).unwrap_or(0);
    let first = text.lines().nth(skip).unwrap_or_default();
    let is_number = |cell: &&str| matches!(number(cell, decimal_comma), Ok(Some(_)));
    let header = is_labchart(text) || !cells(first, delimiter).iter().any(is_number);
    let skip = if is_labchart(text) { 0 } else { skip };
    Written { encoding, delimiter, decimal_comma, header, skip, comment: None }
}

fn cells(line: &str, delimiter: u8) -> Vec<&str> {
    match delimiter {
        WHITE_SPACE => line.split_whitespace().collect(),
        _ => line.split(char::from(delimiter)).map(str::trim).collect(),
    }
}
