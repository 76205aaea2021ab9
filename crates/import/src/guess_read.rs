//! Reads a recording without a mapping: how its text is written, and its first columns.

use super::csv::{Dialect, WHITE_SPACE, opens_single_quote, record_ends};
use super::format::{Format, FormatOptions};
use super::labview::{self, LabView};
use super::limits::{Budget, MOST_FILE, Take};
use super::mapping::format_named;
use super::plain::is_labchart;
use super::recording::number;
use super::table::{Cell, Cells, ColumnRef, Table};
use super::text::{Encoding, check_is_text, check_readable, decode, is_windows_1252};
use super::xdf::XdfClock;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;
use zwidth_store::{StoreError, open_named, read_named};

/// Columns that are looked at: more are not one recording's.
pub(super) const MOST_GUESSED: usize = 64;
/// Lines and rows that are looked at.
pub(super) const LOOKED_AT: usize = 200;
/// Bytes of a text that tell its header (64 KiB).
const HEAD: u64 = 1 << 16;
/// Delimiters, the likeliest first.
const DELIMITERS: [u8; 5] = [b'\t', b';', b',', b'|', WHITE_SPACE];

/// How a text is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Written {
    pub(super) dialect: Dialect,
    pub(super) decimal_comma: bool,
}

/// The usual dialect. No line is refused: the guess counts the bad ones for `bad_lines`.
const USUAL: Dialect = Dialect {
    delimiter: b',',
    header: true,
    comment: None,
    skip: 0,
    encoding: Encoding::Utf8,
    bad_lines: usize::MAX,
    before: 0,
};

/// First bytes of lines of remarks.
const REMARKS: [u8; 3] = [b'%', b'#', b'!'];

/// A recording, its form guessed.
pub(super) struct Looked {
    pub(super) table: Table,
    /// The matrix or the table of fields that the columns are of, if it is all that the file has.
    pub(super) part: Option<String>,
    /// Labels of its columns where the line above them is no header that is read.
    pub(super) labels: Vec<String>,
    /// Its format, where its name does not tell.
    pub(super) format: Option<Format>,
    /// How it is written, if it is delimited text.
    pub(super) written: Option<Written>,
    /// Whether the rows of its matrix are the signals.
    pub(super) turned: bool,
    /// The heads of LabVIEW's format, if it has them.
    pub(super) labview: Option<LabView>,
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
    if !is_delimited(format_named(path).unwrap_or(Format::Txt)) {
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

fn is_delimited(format: Format) -> bool {
    matches!(format, Format::Csv | Format::Tsv | Format::Txt)
}

fn looked(path: &Path, bytes: Vec<u8>) -> Result<Looked, StoreError> {
    check_readable(path, &bytes)?;
    let named = format_named(path);
    let format = named.unwrap_or(Format::Txt);
    let encoding = encoding(&bytes);
    let mut labview = None;
    let mut labels = Vec::new();
    let mut form = Written { dialect: Dialect { encoding, ..USUAL }, decimal_comma: false };
    if is_delimited(format) {
        check_is_text(path, &bytes)?;
        let text = decode(path, &bytes, encoding)?;
        labview = labview::heads(&text);
        form = written(&text, encoding);
        let Dialect { delimiter, header, skip, .. } = form.dialect;
        // Where the line above the first row is no header that is read, it still labels the columns: in
        // LabVIEW's files some names come twice, and a list in single quotes is parted into several cells.
        let above = skip.checked_sub(1).and_then(|line| text.lines().nth(line));
        if let Some(above) = above.filter(|_| !header) {
            labels = cells(above, delimiter);
            let first = text.lines().nth(skip).map(|row| cells(row, delimiter));
            let parted = first.and_then(|row| row.iter().position(|cell| opens_single_quote(cell)));
            labels.truncate(parted.unwrap_or(labels.len()));
        }
    }
    let columns: Vec<ColumnRef> = (1..=MOST_GUESSED).map(ColumnRef::Position).collect();
    let budget = Budget::default();
    let take = Take::of(columns.iter().collect(), &budget);
    let options = FormatOptions {
        dialect: form.dialect,
        part: None,
        clock: XdfClock::Corrected,
        dejitter: true,
    };
    let mut table = format.read(path, bytes, options, &take)?;
    let again = |part: Option<&str>, turned: bool| {
        let bytes = read_named(path, MOST_FILE).map_err(|e| StoreError::io(path, "read", &e))?;
        let take = Take { turned, columns: take.columns.clone(), ..take };
        format.read(path, bytes, FormatOptions { part, ..options }, &take)
    };
    // Of a file without vectors: the one part that has columns of its own.
    let part = {
        let has_vectors = table.columns.iter().any(|cells| cells.len() > 1);
        let names = table.names.iter().flatten().filter(|_| !has_vectors);
        let others = names.zip(&table.columns);
        let others = others.filter(|(_, cells)| matches!(cells, Cells::Other(_))).take(MOST_PARTS);
        let mut parts = others.filter_map(|(name, _)| {
            let part = again(Some(name), false).ok()?;
            let columns = part.columns.iter().filter(|cells| cells.len() > 1).count();
            (columns > 1).then(|| (name.clone(), part))
        });
        let first = parts.next();
        first.filter(|_| parts.next().is_none())
    };
    let part = part.map(|(name, columns)| {
        table = columns;
        name
    });
    let turned = table.is_turned();
    if turned {
        table = again(part.as_deref(), true)?;
    }
    let (format, written) =
        (named.is_none().then_some(format), is_delimited(format).then_some(form));
    Ok(Looked { table, part, labels, format, written, turned, labview })
}

/// Columns that are no vectors, and that are read as matrices or as tables of fields.
const MOST_PARTS: usize = 8;

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
    let text = text.trim_start_matches('\u{feff}');
    if let Some(heads) = labview::heads(text) {
        let begin: usize = text.split_inclusive('\n').take(heads.lines).map(str::len).sum();
        let mut rest = form(&text[begin..], encoding, Some(heads.delimiter));
        // Names that come twice name nothing.
        rest.dialect.skip += heads.lines + usize::from(heads.has_many_times);
        rest.dialect.header = !heads.has_many_times;
        return rest;
    }
    // Excel reads and writes a first line that names the delimiter: `sep=;`.
    if let Some((line, rest)) = text.split_once('\n')
        && let line = line.trim_end_matches('\r').trim_matches('"')
        && let Some([delimiter]) = line.strip_prefix("sep=").map(str::as_bytes)
        && delimiter.is_ascii()
    {
        let mut rest = form(rest, encoding, Some(*delimiter));
        rest.dialect.skip += 1;
        return rest;
    }
    let first = text.as_bytes().first();
    if let Some(mark) = REMARKS.into_iter().find(|mark| first == Some(mark)) {
        let rest = text.lines().filter(|line| line.as_bytes().first() != Some(&mark));
        let mut rest = form(&Vec::from_iter(rest).join("\n"), encoding, None);
        // Where nothing behind the remarks is a header, the last remark may be it.
        if rest.dialect.header {
            rest.dialect.comment = Some(mark);
            return rest;
        }
    }
    form(text, encoding, None)
}

/// A record of a text: its line, from 0, and its cells.
struct Record {
    line: usize,
    cells: Vec<String>,
}

impl Record {
    fn has_number(&self, decimal_comma: bool) -> bool {
        self.cells.iter().any(|cell| matches!(number(cell, decimal_comma), Ok(Some(_))))
    }
}

/// The first records of a text, parted as the importer parts them: a delimiter in quotes is none.
fn records(text: &str, delimiter: u8) -> Vec<Record> {
    let dialect = Dialect { delimiter, ..USUAL };
    let mut records = Vec::new();
    let mut begin = 0;
    let mut line = 0;
    for end in record_ends(text.as_bytes(), dialect).chain([text.len()]) {
        let record = &text[begin..end];
        if !record.trim().is_empty() {
            records.push(Record { line, cells: cells(record, delimiter) });
        }
        if records.len() == LOOKED_AT {
            break;
        }
        line += record.matches('\n').count();
        begin = end;
    }
    records
}

/// The cells of a record.
fn cells(record: &str, delimiter: u8) -> Vec<String> {
    if delimiter == WHITE_SPACE {
        return record.split_whitespace().map(str::to_owned).collect();
    }
    let mut reader = ::csv::ReaderBuilder::new()
        .delimiter(delimiter)
        .has_headers(false)
        .trim(::csv::Trim::All)
        .from_reader(record.as_bytes());
    let first = reader.records().next().and_then(Result::ok).unwrap_or_default();
    first.iter().map(str::to_owned).collect()
}

/// The usual number of cells among records with more than one cell; 1 if there are none.
fn usual_width(records: &[Record]) -> usize {
    let mut widths: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (place, record) in records.iter().enumerate().filter(|(_, record)| record.cells.len() > 1) {
        let (count, last) = widths.entry(record.cells.len()).or_default();
        (*count, *last) = (*count + 1, place);
    }
    // Of equally many, those that come last: what stands before a table is another width.
    widths.into_iter().max_by_key(|(_, standing)| *standing).map_or(1, |(width, _)| width)
}

/// How a text is written whose delimiter is named, or is the one that parts most records into the same
/// number of cells.
fn form(text: &str, encoding: Encoding, named: Option<u8>) -> Written {
    let delimiter = named.unwrap_or_else(|| {
        let mut best = (0, b',');
        for delimiter in DELIMITERS {
            let records = records(text, delimiter);
            let usual = usual_width(&records);
            let count = records.iter().filter(|r| r.cells.len() == usual && usual > 1).count();
            // Of equally good ones the first stays: they stand in the order of their likelihood.
            if count > best.0 {
                best = (count, delimiter);
            }
        }
        best.1
    });
    let records = records(text, delimiter);
    let width = usual_width(&records);
    let rows: Vec<&Record> = records.iter().filter(|r| r.cells.len() == width).collect();
    // A comma that is no delimiter and stands between digits is one before decimals.
    let (mut commas, mut points) = (0, 0);
    for cell in rows.iter().flat_map(|row| &row.cells) {
        let plain = number(cell, false);
        points += usize::from(cell.contains('.') && matches!(plain, Ok(Some(_))));
        commas += usize::from(plain.is_err() && number(cell, true).is_ok());
    }
    let decimal_comma = delimiter != b',' && commas > points;
    // The names stand above the first row of numbers, with a row of units between them perhaps; a table
    // without numbers begins with them. A header may have a cell less than the rows.
    let quotes = rows.iter().any(|row| row.cells.iter().any(|cell| opens_single_quote(cell)));
    let least = width.saturating_sub(usize::from(!quotes));
    let data = records.iter().position(|r| r.cells.len() == width && r.has_number(decimal_comma));
    let header = match data {
        // Rows may have a cell more than the header, all but the first of them perhaps.
        Some(data) => header_above(&records[..data], least, decimal_comma).or_else(|| {
            let short = records.iter().position(|r| {
                r.cells.len() > 2 && r.cells.len() + 1 == width && r.has_number(decimal_comma)
            })?;
            header_above(&records[..short], least, decimal_comma).filter(|_| short < data)
        }),
        None => records.iter().position(|record| record.cells.len() >= least),
    };
    let first = header.or(data).and_then(|place| records.get(place));
    let skip = first.map_or(0, |record| record.line);
    let is_labchart = is_labchart(text);
    let dialect = Dialect {
        delimiter,
        header: is_labchart || header.is_some(),
        skip: if is_labchart { 0 } else { skip },
        encoding,
        ..USUAL
    };
    Written { dialect, decimal_comma }
}

/// The first of the records that end those `above` and may name columns: with enough cells, most of
/// them filled, and none a number.
fn header_above(above: &[Record], least: usize, decimal_comma: bool) -> Option<usize> {
    let other = above.iter().rposition(|record| {
        let filled = record.cells.iter().filter(|cell| !cell.is_empty()).count();
        let width = record.cells.len();
        width < least || 2 * filled <= width || record.has_number(decimal_comma)
    });
    let top = other.map_or(0, |other| other + 1);
    (top < above.len()).then_some(top)
}

/// A text as TOML writes it.
pub(super) fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(letter));
            }
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}

pub(super) fn first_numbers(cells: &Cells, decimal_comma: bool) -> Vec<Option<f64>> {
    (0..cells.len())
        .map(|row| match cells.cell(row) {
            Cell::Number(value) => Some(value),
            Cell::Text(text) => number(text, decimal_comma).ok().flatten(),
            Cell::Empty => None,
        })
        .collect()
}

/// Whether most of a column's first cells are numbers.
pub(super) fn is_number(cells: &Cells, decimal_comma: bool) -> bool {
    let looked_at = first_numbers(cells, decimal_comma);
    let looked_at = &looked_at[..looked_at.len().min(LOOKED_AT)];
    2 * looked_at.iter().flatten().count() > looked_at.len()
}
