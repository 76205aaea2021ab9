//! Delimited text: CSV, TSV and their relatives.

use super::table::{Cells, Table};
use super::text::decode;
use crate::StoreError;
use arrow::array::LargeStringBuilder;
use std::path::Path;

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
}

/// Reads delimited text; every cell stays text, trimmed, and null where empty.
pub(super) fn read(path: &Path, bytes: &[u8], dialect: Dialect) -> Result<Table, StoreError> {
    let text = after_lines(decode(path, bytes)?, dialect.skip);
    let mut counter = Lines { rest: text, byte: 0, line: 1 + dialect.skip as u64, comment: dialect.comment };
    let mut reader = ::csv::ReaderBuilder::new()
        .delimiter(dialect.delimiter)
        .has_headers(dialect.header)
        .comment(dialect.comment)
        .trim(::csv::Trim::All)
        .from_reader(text.as_bytes());
    let names: Option<Vec<String>> = match dialect.header {
        true => {
            let header = reader.headers().map_err(|e| fault(path, &mut counter, &e))?;
            Some(header.iter().map(str::to_owned).collect())
        }
        false => None,
    };
    let mut columns: Vec<LargeStringBuilder> = Vec::new();
    columns.resize_with(names.as_ref().map_or(0, Vec::len), LargeStringBuilder::new);
    let mut lines = Vec::new();
    let mut record = ::csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(|e| fault(path, &mut counter, &e))? {
        // Without a header the first record says how many columns there are; the reader holds all to it.
        columns.resize_with(record.len(), LargeStringBuilder::new);
        for (column, cell) in columns.iter_mut().zip(&record) {
            column.append_option(Some(cell).filter(|c| !c.is_empty()));
        }
        lines.push(counter.line_of(record.position()));
    }
    let columns = columns.into_iter().map(|mut c| Cells::Text(c.finish())).collect();
    Ok(Table { names, columns, lines })
}

fn after_lines(text: &str, skip: usize) -> &str {
    (0..skip).fold(text, |rest, _| rest.split_once('\n').map_or("", |(_, rest)| rest))
}

/// Counts lines on the way through the text. The reader's own count stands before the blank lines
/// and comments that lead to a record, and inside a carriage return and line feed.
struct Lines<'a> {
    rest: &'a str,
    byte: u64,
    line: u64,
    comment: Option<u8>,
}

impl Lines<'_> {
    /// The line (from 1) of the record that the reader says begins at `position` or after it.
    fn line_of(&mut self, position: Option<&::csv::Position>) -> u64 {
        let target = position.map_or(0, ::csv::Position::byte);
        while let Some((line, rest)) = self.rest.split_once('\n') {
            let passed_by = line.trim_end_matches('\r').is_empty() || line.bytes().next() == self.comment;
            if self.byte >= target && !passed_by {
                break;
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
        ::csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = lines.line_of(pos.as_ref());
            let what = format!("line {line} has {len} cells where {expected_len} belong");
            let remedy =
                "the file may be cut off or its delimiter another; mend the line, or set delimiter in [file]";
            StoreError::new(path, what, remedy)
        }
        _ => StoreError::new(path, error.to_string(), "check the delimiter in [file]"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::{Cell, ColumnRef};
    use super::*;

    const COMMA: Dialect = Dialect { delimiter: b',', header: true, comment: None, skip: 0 };

    fn cells(text: &str, dialect: Dialect) -> Vec<Vec<String>> {
        let table = read(Path::new("a.csv"), text.as_bytes(), dialect).unwrap();
        let column = |c: &Cells| (0..c.len()).map(|i| c.cell(i).to_string()).collect();
        table.columns.iter().map(column).collect()
    }

    #[test]
    fn byte_order_mark_carriage_returns_and_blanks_are_not_part_of_a_cell() {
        let table = read(Path::new("a.csv"), "\u{feff}a , b\r\n 1,2\r\n,4\r\n".as_bytes(), COMMA).unwrap();
        let b = table.find(&ColumnRef::Name("b".to_owned())).unwrap();
        assert_eq!(table.columns[b].cell(0), Cell::Text("2"));
        assert_eq!(table.columns[0].cell(1), Cell::Empty);
        assert_eq!(table.lines, [2, 3]);
    }

    #[test]
    fn rows_know_their_lines_whatever_stands_between_them() {
        let check = |text: &str| {
            let dialect = Dialect { comment: Some(b'#'), skip: 1, ..COMMA };
            assert_eq!(read(Path::new("a.csv"), text.as_bytes(), dialect).unwrap().lines, [3, 6]);
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
        let error = read(Path::new("a.csv"), b"a,b\n1,2\n3\n", COMMA).unwrap_err();
        assert!(error.what.contains("line 3 has 1 cells where 2 belong"), "{error}");
    }
}
