//! Reads a recording without a mapping: how its text is written, and its first columns.

use super::csv::{Dialect, WHITE_SPACE, opens_single_quote, record_ends};
use super::format::{Format, FormatOptions};
use super::labview::{self, LabView};
use super::limits::{Budget, MOST_FILE, Take};
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
    /// The matrix or the table of fields that the columns are of, if it is all that the file has.
    pub(super) part: Option<String>,
    /// What its columns are called where the line above them is no header that is read.
    pub(super) labels: Vec<String>,
    /// Its format, where its name does not tell.
    pub(super) format: Option<Format>,
    /// How it is written, if it is delimited text.
    pub(super) written: Option<Written>,
    /// Whether the rows of its matrix are the signals.
    pub(super) turned: bool,
    /// What the heads of LabVIEW's format say, if it is of that.
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
    let mut labview = None;
    let mut labels = Vec::new();
    let mut form = Written {
        encoding,
        delimiter: b',',
        decimal_comma: false,
        header: true,
        skip: 0,
        comment: None,
    };
    if is_delimited(format) {
        check_is_text(path, &bytes)?;
        let text = decode(path, &bytes, encoding)?;
        labview = labview::heads(&text);
        form = written(&text, encoding);
        if !form.header {
            labels = labels_above(&text, form);
        }
    }
    let dialect = Dialect {
        delimiter: form.delimiter,
        header: form.header,
        comment: form.comment,
        skip: form.skip,
        encoding,
        bad_lines: usize::MAX,
        before: 0,
    };
    let columns: Vec<ColumnRef> = (1..=MOST_GUESSED).map(ColumnRef::Position).collect();
    let budget = Budget::default();
    let take = Take::of(columns.iter().collect(), &budget);
    let options = FormatOptions { dialect, part: None, clock: XdfClock::Corrected, dejitter: true };
    let mut table = format.read(path, bytes, options, &take)?;
    let again = |part: Option<&str>, turned: bool| {
        let bytes = read_named(path, MOST_FILE).map_err(|e| StoreError::io(path, "read", &e))?;
        let take = Take { turned, columns: take.columns.clone(), ..take };
        format.read(path, bytes, FormatOptions { part, ..options }, &take)
    };
    let part = only_part(&table, &|name| again(Some(name), false).ok());
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

/// The one column of a file without vectors that has columns of its own, with these.
fn only_part(table: &Table, read: &dyn Fn(&str) -> Option<Table>) -> Option<(String, Table)> {
    let names = table.names.as_ref()?;
    if table.columns.iter().any(|cells| cells.len() > 1) {
        return None;
    }
    let others = names.iter().zip(&table.columns);
    let others = others.filter(|(_, cells)| matches!(cells, Cells::Other(_))).take(MOST_PARTS);
    let mut parts = others.filter_map(|(name, _)| {
        let part = read(name)?;
        let columns = part.columns.iter().filter(|cells| cells.len() > 1).count();
        (columns > 1).then(|| (name.clone(), part))
    });
    let first = parts.next();
    first.filter(|_| parts.next().is_none())
}

/// The names in the line above the first row, where they are no header that is read: of LabVIEW some come twice,
/// and behind a list in single quotes they stand above other cells.
fn labels_above(text: &str, form: Written) -> Vec<String> {
    let Some(line) = form.skip.checked_sub(1).and_then(|line| text.lines().nth(line)) else {
        return Vec::new();
    };
    let mut names = cells(line, form.delimiter);
    let first = text.lines().nth(form.skip).map(|row| cells(row, form.delimiter));
    let parted = first.and_then(|row| row.iter().position(|cell| opens_single_quote(cell)));
    names.truncate(parted.unwrap_or(names.len()));
    names
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
    let text = text.trim_start_matches('\u{feff}');
    if let Some(heads) = labview::heads(text) {
        let begin: usize = text.split_inclusive('\n').take(heads.lines).map(str::len).sum();
        let rest = form(&text[begin..], encoding, Some(heads.delimiter));
        // Names that come twice name nothing.
        let names = if heads.has_many_times { rest.skip + 1 } else { rest.skip };
        return Written { header: !heads.has_many_times, skip: heads.lines + names, ..rest };
    }
    if let Some((delimiter, rest)) = named_delimiter(text) {
        let rest = form(rest, encoding, Some(delimiter));
        return Written { skip: 1 + rest.skip, ..rest };
    }
    let first = text.as_bytes().first();
    let whole = || form(text, encoding, None);
    let Some(mark) = REMARKS.into_iter().find(|mark| first == Some(mark)) else { return whole() };
    let rest = text.lines().filter(|line| line.as_bytes().first() != Some(&mark));
    let rest = form(&Vec::from_iter(rest).join("\n"), encoding, None);
    if rest.header { Written { comment: Some(mark), ..rest } } else { whole() }
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

    /// Whether it may name columns: most of its cells are filled, and none is a number.
    fn may_be_header(&self, decimal_comma: bool) -> bool {
        let filled = self.cells.iter().filter(|cell| !cell.is_empty()).count();
        2 * filled > self.cells.len() && !self.has_number(decimal_comma)
    }
}

/// The first records of a text, parted as the importer parts them: a delimiter in quotes is none.
fn records(text: &str, delimiter: u8) -> Vec<Record> {
    let dialect = Dialect {
        delimiter,
        header: false,
        comment: None,
        skip: 0,
        encoding: Encoding::Utf8,
        bad_lines: 0,
        before: 0,
    };
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

/// How many cells most records have, of those with more than one; 1 where there are none.
fn usual_width(records: &[Record]) -> usize {
    let mut widths: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
    for (place, record) in records.iter().enumerate().filter(|(_, record)| record.cells.len() > 1) {
        let (count, last) = widths.entry(record.cells.len()).or_default();
        (*count, *last) = (*count + 1, place);
    }
    // Of equally many, those that come last: what stands before a table is another width.
    widths.into_iter().max_by_key(|(_, standing)| *standing).map_or(1, |(width, _)| width)
}

/// The delimiter that a first line names, as Excel reads and writes it (`sep=;`), and what follows it.
fn named_delimiter(text: &str) -> Option<(u8, &str)> {
    let (line, rest) = text.split_once('\n')?;
    let line = line.trim_end_matches('\r').trim_matches('"');
    let [delimiter] = line.strip_prefix("sep=")?.as_bytes() else { return None };
    delimiter.is_ascii().then_some((*delimiter, rest))
}

/// The delimiter that is named, or that parts most records into the same number of cells, and what
/// follows from it.
fn form(text: &str, encoding: Encoding, named: Option<u8>) -> Written {
    let delimiter = named.unwrap_or_else(|| {
        let counts = DELIMITERS.into_iter().map(|delimiter| {
            let records = records(text, delimiter);
            let usual = usual_width(&records);
            (records.iter().filter(|r| r.cells.len() == usual && usual > 1).count(), delimiter)
        });
        counts.fold((0, b','), |best, next| if next.0 > best.0 { next } else { best }).1
    });
    let records = records(text, delimiter);
    let width = usual_width(&records);
    let rows = || records.iter().filter(|record| record.cells.len() == width);
    // A comma that is no delimiter and stands between digits is one before decimals.
    let is_comma = |cell: &&String| number(cell, false).is_err() && number(cell, true).is_ok();
    let all_cells = || rows().flat_map(|record| &record.cells);
    let decimal_comma = delimiter != b','
        && all_cells().filter(is_comma).count()
            > all_cells()
                .filter(|cell| cell.contains('.') && matches!(number(cell, false), Ok(Some(_))))
                .count();
    // The names stand above the first row of numbers, with a row of units between them perhaps; a table
    // without numbers begins with them.
    let quotes = rows().any(|row| row.cells.iter().any(|cell| opens_single_quote(cell)));
    let fits = |record: &Record| record.cells.len() + usize::from(!quotes) >= width;
    let header_above = |data: usize| {
        let is_other = |r: &Record| !(fits(r) && r.may_be_header(decimal_comma));
        let top = records[..data].iter().rposition(is_other).map_or(0, |other| other + 1);
        (top < data).then_some(top)
    };
    let numbers = |is_wide: &dyn Fn(usize) -> bool| {
        records.iter().position(|r| is_wide(r.cells.len()) && r.has_number(decimal_comma))
    };
    let data = numbers(&|cells| cells == width);
    let header = match data {
        // Rows may have a cell more than the header, all but the first of them perhaps.
        Some(data) => header_above(data).or_else(|| {
            let short = numbers(&|cells| cells > 2 && cells + 1 == width)?;
            header_above(short).filter(|_| short < data)
        }),
        None => records.iter().position(fits),
    };
    let first = header.or(data).and_then(|place| records.get(place));
    let skip = first.map_or(0, |record| record.line);
    let is_labchart = is_labchart(text);
    Written {
        encoding,
        delimiter,
        decimal_comma,
        header: is_labchart || header.is_some(),
        skip: if is_labchart { 0 } else { skip },
        comment: None,
    }
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
