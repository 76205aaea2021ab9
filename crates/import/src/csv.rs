//! Delimited text: CSV, TSV and their relatives.

use super::labview::has_comments;
use super::limits::{MOST_COLUMNS, MOST_LINE, MOST_WHOLE_ROWS, Take, check_name, more_rows};
use super::plain::{is_labchart, labchart, spaced};
use super::spelling::shown;
use super::table::{Cells, EmptyRows, Table};
use super::text::{Encoding, count_lines, decode_from, latin_1_note};
use arrow::array::LargeStringBuilder;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::StoreError;

/// How a delimited file is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dialect {
    pub(super) delimiter: u8,
    /// Whether the first line names the columns.
    pub(super) header: bool,
    /// Lines that begin with it are passed by.
    pub(super) comment: Option<u8>,
    /// Lines before the header that are passed by.
    pub(super) skip: usize,
    /// How its bytes spell characters.
    pub(super) encoding: Encoding,
    /// The number of lines with another number of cells that may be left out.
    pub(super) bad_lines: usize,
    /// Lines of the file before the text, where that is a part of it.
    pub(super) before: u64,
}

/// The delimiter that stands for any white space.
pub(super) const WHITE_SPACE: u8 = b' ';

/// Reads delimited text; every cell stays text, trimmed, and null where empty. A record without a
/// value is an empty row.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    dialect: Dialect,
    take: &Take,
) -> Result<Table, StoreError> {
    let decoded = decode_from(path, bytes, dialect.encoding, dialect.before)?;
    let mut text = decoded.as_ref();
    for passed in 0..dialect.skip {
        let Some((_, after)) = text.split_once('\n') else {
            let skip = dialect.skip;
            let what =
                format!("skip = {skip} passes the whole file by: it has {} lines", passed + 1);
            return Err(StoreError::new(path, what, "mend skip in [file]"));
        };
        text = after;
    }
    // Its comments and heads are empty lines here, and its times say where samples are missing.
    let has_empty_rows = !is_labchart(text);
    let Delimited { rewritten, dialect, note } = as_delimited(text, dialect);
    let mut notes: Vec<String> = note.into_iter().collect();
    notes.extend(latin_1_note(bytes, dialect.encoding));
    let text = rewritten.as_deref().unwrap_or(text);
    // Before the reader sees the text: it takes memory for a record of any length.
    check_records(path, text, dialect)?;
    let mut counter = Lines::new(text, dialect);
    let mut reader = ::csv::ReaderBuilder::new()
        .delimiter(dialect.delimiter)
        .has_headers(dialect.header)
        .comment(dialect.comment)
        // Cells are trimmed where they are taken: the reader would copy each record for it.
        .trim(::csv::Trim::Headers)
        // Records of another length are bad lines, which have a count and a place below.
        .flexible(true)
        .from_reader(text.as_bytes());
    let mut names: Option<Vec<String>> = match dialect.header {
        true => {
            let header = reader.headers().map_err(|e| fault(path, &mut counter, &e))?;
            Some(header.iter().map(str::to_owned).collect())
        }
        false => None,
    };
    check_names(path, names.as_deref().unwrap_or_default())?;
    let mut record = ::csv::StringRecord::new();
    let mut more = next_record(path, &mut reader, &mut record, &mut counter)?;
    if let Some(names) = names.as_mut().filter(|_| more) {
        notes.extend(one_cell_short(names, &record));
    }
    let has_comments = names.as_deref().is_some_and(has_comments);
    // Without a header the first record says how many columns there are.
    let width = names.as_ref().map_or(record.len(), Vec::len);
    let mut columns: Vec<Option<LargeStringBuilder>> = (0..width)
        .map(|place| {
            let name = names.as_ref().and_then(|names| names.get(place));
            take.wants(place, name.map(String::as_str)).then(LargeStringBuilder::new)
        })
        .collect();
    let taken = columns.iter().flatten().count();
    let mut lines = Vec::new();
    let mut bad = Vec::new();
    let mut empty = EmptyRows::default();
    while more {
        let line = counter.line;
        empty.add(lines.len(), std::mem::take(&mut counter.empty));
        // LabVIEW ends rows without a comment before that column.
        if has_comments && record.len() + 1 == width {
            record.push_field("");
        }
        if record.len() != width {
            let quotes = match record.iter().map(str::trim).any(opens_single_quote) {
                true => ", as a delimiter stands in single quotes, and only \" quotes",
                false => "",
            };
            let what =
                format!("line {line} has {} cells where {width} belong{quotes}", record.len());
            if bad.len() == dialect.bad_lines {
                let more = match dialect.bad_lines {
                    0 => String::new(),
                    n => format!(", after {n} other bad lines"),
                };
                let remedy = "the file may be cut off or its delimiter another; mend the line, set delimiter in [file], or pass a few such \
                              lines by with bad_lines";
                return Err(StoreError::new(path, format!("{what}{more}"), remedy));
            }
            bad.push((lines.len(), what));
            // An empty row in its place: the rows behind it keep their numbers.
            record = ::csv::StringRecord::from(vec![""; width]);
        }
        if lines.len() == MOST_WHOLE_ROWS {
            return Err(more_rows(path));
        }
        // Row by row: how many will come is known at the end alone.
        take.room(path, taken)?;
        for (column, cell) in columns.iter_mut().zip(&record) {
            if let Some(column) = column {
                column.append_option(Some(cell.trim()).filter(|c| !c.is_empty()));
            }
        }
        lines.push(line);
        more = next_record(path, &mut reader, &mut record, &mut counter)?;
    }
    empty.add(lines.len(), counter.empty);
    if !has_empty_rows {
        empty = EmptyRows::default();
    }
    let columns = columns.into_iter().map(Cells::of_text).collect();
    Ok(Table { columns, names, lines, told: notes, bad, empty, ..Table::default() })
}

/// Reads the next record that has a value, if there is one; the empty ones before it are counted.
fn next_record(
    path: &Path,
    reader: &mut ::csv::Reader<&[u8]>,
    record: &mut ::csv::StringRecord,
    counter: &mut Lines,
) -> Result<bool, StoreError> {
    loop {
        let more = reader.read_record(record).map_err(|e| fault(path, counter, &e))?;
        counter.line_of(record.position());
        if !more || record.iter().any(|cell| !cell.trim().is_empty()) {
            return Ok(more);
        }
        counter.empty += 1;
    }
}

/// A text as the reader takes it.
struct Delimited {
    /// The text with tabs, if it was a table in another way.
    rewritten: Option<String>,
    dialect: Dialect,
    /// For the report.
    note: Option<String>,
}

fn as_delimited(text: &str, dialect: Dialect) -> Delimited {
    let tabs = Dialect { delimiter: b'\t', ..dialect };
    if is_labchart(text) {
        let note =
            "read as a LabChart export: the channels' titles are the header, `Time` before them";
        let dialect = Dialect { header: true, ..tabs };
        return Delimited { rewritten: Some(labchart(text)), dialect, note: Some(note.to_owned()) };
    }
    if dialect.delimiter != WHITE_SPACE {
        return Delimited { rewritten: None, dialect, note: None };
    }
    let mut lines = text.lines();
    let first =
        lines.find(|line| !line.trim().is_empty() && line.bytes().next() != dialect.comment);
    let (rewritten, note) = match first.is_some_and(|line| line.contains('\t')) {
        true => (None, "cells are taken to stand between tabs"),
        false => {
            let rewritten = spaced(text, dialect.comment);
            (Some(rewritten), "cells are taken to stand between any blanks")
        }
    };
    Delimited { rewritten, dialect: tabs, note: Some(note.to_owned()) }
}

/// Mends a header that is one cell short of the first record: as R writes names of rows, or because
/// each line ends in a delimiter. Says what it was taken for.
fn one_cell_short(names: &mut Vec<String>, record: &::csv::StringRecord) -> Option<String> {
    // A delimiter within single quotes parts cells, so that no column is without a name.
    if record.len() != names.len() + 1 || record.iter().map(str::trim).any(opens_single_quote) {
        return None;
    }
    if record.iter().next_back().is_some_and(|cell| cell.trim().is_empty()) {
        names.push(String::new());
        return Some("the header is one cell short: lines end in a delimiter".to_owned());
    }
    names.insert(0, String::new());
    Some("the header is one cell short: the first column is taken for one without a name, as R writes row names".to_owned())
}

/// Whether a cell is the beginning of a text in single quotes, which are no quotes here: `'[1` of `'[1, 2]'`.
pub(super) fn opens_single_quote(cell: &str) -> bool {
    cell.starts_with('\'') && (cell.len() == 1 || !cell.ends_with('\''))
}

/// A column is named by its header, so that a header must be there once.
fn check_names(path: &Path, names: &[String]) -> Result<(), StoreError> {
    names.iter().try_for_each(|name| check_name(path, name))?;
    let mut seen = BTreeMap::new();
    for (place, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
        if let Some(first) = seen.insert(name, place) {
            let what = format!("columns {} and {} have the same header", first + 1, place + 1);
            let remedy = "rename one of them, or name columns by position with header = false and skip = 1 in [file]";
            return Err(StoreError::new(path, what, remedy).column(shown(name)));
        }
    }
    Ok(())
}

/// Lines of the file before the text that is read.
fn first_line(dialect: Dialect) -> u64 {
    dialect.before + dialect.skip as u64
}

/// The number of bytes that whole records take in a text that begins with a record.
pub(super) fn whole_records(text: &[u8], dialect: Dialect) -> usize {
    // Without a quote every line is a record: no walk byte by byte is needed.
    if !text.contains(&b'"') {
        return text.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
    }
    record_ends(text, dialect).last().unwrap_or(0)
}

/// The end of each record of a text that begins with a record.
pub(super) fn record_ends(text: &[u8], dialect: Dialect) -> impl Iterator<Item = usize> {
    let mut at = At::Record;
    text.iter().enumerate().filter_map(move |(i, byte)| {
        // Of blanks it is not known yet whether they are tabs.
        let is_blank = dialect.delimiter == WHITE_SPACE && *byte == b'\t';
        at = at.after(if is_blank { WHITE_SPACE } else { *byte }, dialect);
        (at == At::Record && *byte == b'\n').then_some(i + 1)
    })
}

/// A position in the walk through a record.
#[derive(Clone, Copy, PartialEq)]
enum At {
    Record,
    Comment,
    Cell,
    InCell,
    Quoted,
    /// Behind a quote in a quoted cell.
    Quote,
}

impl At {
    /// The position behind this byte: [`At::Cell`] if the byte begins another cell.
    fn after(self, byte: u8, dialect: Dialect) -> Self {
        let ends = byte == b'\n' || byte == b'\r';
        match self {
            At::Record if ends => At::Record,
            At::Record if Some(byte) == dialect.comment => At::Comment,
            At::Comment if byte == b'\n' => At::Record,
            At::Comment => At::Comment,
            At::Quoted if byte == b'"' => At::Quote,
            At::Quoted => At::Quoted,
            At::Record | At::Cell | At::Quote if byte == b'"' => At::Quoted,
            _ if byte == dialect.delimiter => At::Cell,
            _ if ends => At::Record,
            _ => At::InCell,
        }
    }
}

/// Checks that no record has more cells or bytes than are read, before the reader takes memory for
/// it. It goes through the text as the reader does: a quote has a meaning only where a cell begins.
fn check_records(path: &Path, text: &str, dialect: Dialect) -> Result<(), StoreError> {
    let mut at = At::Record;
    let mut start = 0;
    let mut cells = 1;
    for (i, byte) in text.bytes().enumerate() {
        at = at.after(byte, dialect);
        cells += usize::from(at == At::Cell);
        if at == At::Record {
            (start, cells) = (i + 1, 1);
        } else if cells > MOST_COLUMNS || i - start >= MOST_LINE {
            let line = 1 + first_line(dialect) + count_lines(&text.as_bytes()[..start]);
            let (what, most) =
                if cells > MOST_COLUMNS { ("columns", MOST_COLUMNS) } else { ("bytes", MOST_LINE) };
            let what = format!("line {line} has more than {most} {what}, and no more are read");
            let remedy = "check the delimiter in [file] and the quotes of the line, or leave out columns that are not needed";
            return Err(StoreError::new(path, what, remedy));
        }
    }
    Ok(())
}

/// Counts lines on the way through the text. The reader's own count stands before the blank lines
/// and comments that lead to a record, and inside a carriage return and line feed.
struct Lines<'a> {
    rest: &'a str,
    byte: u64,
    line: u64,
    comment: Option<u8>,
    /// What a line ends in: a line feed, or in old texts a carriage return alone.
    end: char,
    /// Blank lines that led to the records asked for.
    empty: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str, dialect: Dialect) -> Self {
        let end = if text.contains('\n') { '\n' } else { '\r' };
        let line = 1 + first_line(dialect);
        Self { rest: text, byte: 0, line, comment: dialect.comment, end, empty: 0 }
    }

    /// The line (from 1) of the record that the reader says begins at `position` or after it.
    fn line_of(&mut self, position: Option<&::csv::Position>) -> u64 {
        // On from where the last one was found: records come in the order of the text.
        let target = position.map_or(0, ::csv::Position::byte);
        while let Some((line, rest)) = self.rest.split_once(self.end) {
            let is_blank = line.trim_end_matches('\r').is_empty();
            let is_comment = !is_blank && line.bytes().next() == self.comment;
            if self.byte >= target {
                if !is_blank && !is_comment {
                    break;
                }
                self.empty += usize::from(is_blank);
            }
            self.byte += line.len() as u64 + 1;
            self.line += 1;
            self.rest = rest;
        }
        self.line
    }
}

fn fault(path: &Path, lines: &mut Lines, error: &::csv::Error) -> StoreError {
    match error.kind() {
        ::csv::ErrorKind::Utf8 { pos, .. } => {
            let what = format!("line {} is not UTF-8 text", lines.line_of(pos.as_ref()));
            StoreError::new(path, what, "set encoding in [file]")
        }
        _ => StoreError::new(path, error.to_string(), "check the delimiter in [file]"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::limits::tests::{everything, only};
    use super::super::table::{Cell, ColumnRef};
    use super::*;

    fn read(text: &str, dialect: Dialect) -> Result<Table, StoreError> {
        everything(|take| super::read(Path::new("a.csv"), text.as_bytes(), dialect, take))
    }

    const COMMA: Dialect = Dialect {
        delimiter: b',',
        header: true,
        comment: None,
        skip: 0,
        encoding: Encoding::Utf8,
        bad_lines: 0,
        before: 0,
    };

    fn cells(text: &str, dialect: Dialect) -> Vec<Vec<String>> {
        let table = read(text, dialect).unwrap();
        let column = |c: &Cells| (0..c.len()).map(|i| c.cell(i).to_string()).collect();
        table.columns.iter().map(column).collect()
    }

    #[test]
    fn byte_order_mark_carriage_returns_and_blanks_are_not_part_of_a_cell() {
        let table = read("\u{feff}a , b\r\n 1,2\r\n,4\r\n", COMMA).unwrap();
        let b = table.find(&ColumnRef::Name("b".to_owned())).unwrap();
        assert_eq!(table.columns[b].cell(0), Cell::Text("2"));
        assert_eq!(table.columns[0].cell(1), Cell::Empty);
        assert_eq!(table.lines, [2, 3]);
    }

    #[test]
    fn rows_know_their_lines_whatever_stands_between_them() {
        let check = |text: &str| {
            let dialect = Dialect { comment: Some(b'#'), skip: 1, ..COMMA };
            assert_eq!(read(text, dialect).unwrap().lines, [3, 6]);
        };
        check("x\na,b\n1,2\n\n# pause\n3,4\n");
        check("x\r\na,b\r\n1,2\r\n\r\n# pause\r\n3,4\r\n");
    }

    #[test]
    fn delimiter_comments_skipped_lines_and_a_missing_header_are_as_the_dialect_says() {
        let tabs = Dialect { delimiter: b'\t', ..COMMA };
        assert_eq!(cells("a\tb\n1\t2\n", tabs), [["1"], ["2"]]);
        let bare = Dialect { header: false, comment: Some(b'#'), ..COMMA };
        assert_eq!(cells("# rig 2\n1,2\n# pause\n3,4\n", bare), [["1", "3"], ["2", "4"]]);
        let skipping = Dialect { skip: 2, delimiter: b';', ..COMMA };
        assert_eq!(cells("LabView, 3\nx\na;b\n1;2\n", skipping), [["1"], ["2"]]);
    }

    #[test]
    fn a_row_of_another_length_is_refused_with_its_line() {
        let error = refused("a,b\n1,2\n3\n", COMMA);
        assert!(error.contains("line 3 has 1 cells where 2 belong"), "{error}");
    }

    #[test]
    fn white_space_of_any_kind_stands_between_cells_where_it_is_the_delimiter() {
        let blank = Dialect { delimiter: WHITE_SPACE, ..COMMA };
        assert_eq!(cells("t   f\n 0.0  1\n 0.5\t2\n", blank), [["0.0", "0.5"], ["1", "2"]]);
        assert_eq!(cells("time (s)\tF\n0\t1\n", blank), [["0"], ["1"]]);
    }

    #[test]
    fn a_header_one_cell_short_is_mended_and_told() {
        let table = |text: &str| read(text, COMMA).unwrap();
        let named = table("t,f\n1,0.0,5\n2,0.5,6\n");
        assert_eq!(named.names.as_deref(), Some(["", "t", "f"].map(str::to_owned).as_slice()));
        assert!(named.told[0].contains("row names"), "{:?}", named.told);
        let ended = table("t,f\n0.0,5,\n0.5,6,\n");
        assert_eq!(ended.names.as_deref(), Some(["t", "f", ""].map(str::to_owned).as_slice()));
        assert!(table("t,f\n0,1\n").told.is_empty());
    }

    #[test]
    fn as_many_bad_lines_as_allowed_are_marked_and_one_more_is_refused() {
        let text = "t,f\n0,1\n1\n2,3\n3,4,5\n4,5\n";
        let table = read(text, Dialect { bad_lines: 2, ..COMMA }).unwrap();
        assert_eq!(table.lines, [2, 3, 4, 5, 6]);
        let expect =
            [(1, "line 3 has 1 cells where 2 belong"), (3, "line 5 has 3 cells where 2 belong")];
        assert_eq!(table.bad, expect.map(|(row, what)| (row, what.to_owned())));
        let error = refused(text, Dialect { bad_lines: 1, ..COMMA });
        assert!(
            error.contains("line 5 has 3 cells where 2 belong, after 1 other bad lines"),
            "{error}"
        );
    }

    fn refused(text: &str, dialect: Dialect) -> String {
        read(text, dialect).unwrap_err().to_string()
    }

    #[test]
    fn only_the_columns_that_are_taken_are_kept() {
        let read = |take: &Take| super::read(Path::new("a.csv"), b"t,f,x\n1,2,3\n", COMMA, take);
        let table = only(&["f"], read).unwrap();
        assert!(matches!(table.columns[..], [Cells::Unread, Cells::Text(_), Cells::Unread]));
    }

    #[test]
    fn more_lines_to_skip_than_there_are_is_told_at_once() {
        for skip in [3, 1_000_000_000_000, usize::MAX] {
            let error = refused("a,b\n1,2\nx", Dialect { skip, ..COMMA });
            assert!(error.contains("passes the whole file by: it has 3 lines"), "{error}");
        }
    }

    #[test]
    fn a_header_or_a_record_of_too_many_columns_is_refused_with_its_line() {
        let wide = |n: usize| ",".repeat(n);
        let error = refused(&wide(1_000_000), COMMA);
        assert!(error.contains("line 1 has more than 16384 columns"), "{error}");
        for bare in [true, false] {
            let text = format!("a\n\n# {0}\n1\n\"{0}\"\n{0}\n", wide(MOST_COLUMNS));
            let error = refused(&text, Dialect { comment: Some(b'#'), header: !bare, ..COMMA });
            assert!(error.contains("line 6 has more than 16384 columns"), "{error}");
        }
        // A quote inside a cell is a quote, and nothing else.
        let error = refused(&format!("a,b\n5\" {}\n", wide(MOST_COLUMNS)), COMMA);
        assert!(error.contains("line 2 has more"), "{error}");
        let error = refused(&format!("a,b\n\"5\"\" {}\n", wide(MOST_LINE)), COMMA);
        assert!(error.contains("line 2 has more than 1048576 bytes"), "{error}");
    }

    #[test]
    fn one_enormous_line_or_a_quote_that_never_ends_is_refused() {
        let long = "x".repeat(MOST_LINE + 1);
        for text in
            [format!("a,b\n1,{long}\n"), format!("a,b\n1,\"{}\n", "x\n".repeat(MOST_LINE / 2))]
        {
            let error = refused(&text, COMMA);
            assert!(error.contains("line 2 has more than 1048576 bytes"), "{error}");
        }
    }

    #[test]
    fn a_header_that_comes_twice_is_refused_but_columns_without_one_are_not() {
        let error = refused("t,f, t\n1,2,3\n", COMMA);
        assert!(error.contains("column t: columns 1 and 3 have the same header"), "{error}");
        assert!(read("t,f,,\n1,2,,\n", COMMA).is_ok());
    }

    #[test]
    fn a_name_of_more_bytes_than_a_name_has_is_refused() {
        let error = refused(&format!("t,{}\n1,2\n", "n".repeat(5000)), COMMA);
        assert!(error.contains("name has 5000 bytes") && error.len() < 1000, "{error}");
    }
}
