//! One file from another program, read but not yet converted.

use super::convert::Linear;
use super::format::{Format, FormatOptions};
use super::label::Label;
use super::limits::{MOST_FILE, MOST_WHOLE_ROWS, Take, too_many_rows};
use super::mapping::{CellForm, FileForm, Missing};
use super::spelling::shown;
use super::spelling::{find, is_missing, truth};
use super::table::{Cell, Cells, ColumnRef, NO_ROW, Table};
use super::text::check_readable;
use arrow::array::Array as _;
use regex::Regex;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_store::{StoreError, hex_blake3, read_named};

/// One file, read.
#[derive(Debug)]
pub(super) struct Recording {
    pub(super) path: PathBuf,
    pub(super) table: Table,
    /// BLAKE3 of the file, hexadecimal.
    pub(super) blake3: String,
    pub(super) cells: CellForm,
    /// What of other files was joined to its rows.
    pub(super) joined: Joined,
    /// Named groups of the pattern on the path.
    groups: BTreeMap<String, String>,
}

/// What of other files was joined to the rows of a recording.
#[derive(Debug, Default)]
pub(super) struct Joined {
    /// Columns of a log, by their places.
    pub(super) columns: BTreeMap<usize, JoinedColumn>,
    /// Of each row the row of the log: where that changes, another trial begins.
    pub(super) parts: Option<Arc<Vec<u32>>>,
    /// Rows that lie within what was joined; all of them where there is none.
    pub(super) within: Option<Vec<bool>>,
}

/// Where a column of a log comes from.
#[derive(Debug, Clone)]
pub(super) struct JoinedColumn {
    pub(super) log: Arc<Recording>,
    /// Its place there.
    pub(super) place: usize,
    pub(super) rows: Arc<Vec<u32>>,
}

/// The rows of a file that an import takes, and how many it leaves.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Rows in the file.
    pub(super) read: usize,
    /// The rows taken, counted from 0.
    pub(super) kept: Vec<usize>,
    /// Rows left out because a mapped cell is empty.
    pub(super) missing: usize,
    /// Rows left out because they lie outside of what was joined to the recording.
    pub(super) outside: usize,
    /// Rows left out because they come after the limit.
    pub(super) past_limit: usize,
    /// Why each row that cannot be read was left out.
    pub(super) bad: BTreeMap<usize, String>,
    /// Rows of the time of a row before them, which stands for them.
    pub(super) joined: Vec<usize>,
}

/// The rows that a trial or sweep lacks between its first row and its last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Gaps {
    /// Rows of the file that are empty.
    pub(super) empty: usize,
    /// Rows that were left out because a mapped cell is empty.
    pub(super) missing: usize,
}

/// The place of a row in its file.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Standing {
    /// Its number among the rows that have values, from 0.
    pub(super) row: usize,
    /// Its number among all rows, empty ones included, from 0.
    pub(super) place: usize,
}

/// The number of empty rows between two rows.
pub(super) fn empty_between(first: Standing, last: Standing) -> usize {
    (last.place - first.place) - (last.row - first.row)
}

impl Standing {
    /// Where a row of a part of the file stands, before which these rows lie.
    pub(super) fn of(self, part: &Table, row: usize) -> Self {
        Self { row: self.row + row, place: self.place.saturating_add(part.place(row)) }
    }
}

impl Gaps {
    /// What is between two rows, of which and of those between so many were kept and so many could not
    /// be read.
    pub(super) fn between(first: Standing, last: Standing, kept: usize, bad: usize) -> Self {
        let rows = last.row - first.row;
        Self { empty: empty_between(first, last), missing: rows + 1 - kept - bad }
    }

    /// The gaps as the file made of `kept` rows tells them; nothing if there are none.
    pub(super) fn in_words(self, kept: usize) -> Option<String> {
        let absent = self.empty.saturating_add(self.missing);
        if absent == 0 {
            return None;
        }
        let causes =
            [("empty rows", self.empty), ("rows without a value in a mapped column", self.missing)];
        let causes = causes.into_iter().filter(|(_, n)| *n > 0);
        let causes: Vec<String> = causes.map(|(what, n)| format!("{what}: {n}")).collect();
        let all = kept.saturating_add(absent);
        Some(format!("missing samples: {absent} of {all} ({})", causes.join("; ")))
    }
}

impl Joined {
    /// Leaves out the rows, of so many, of which this is not so.
    pub(super) fn keep(&mut self, height: usize, is_within: impl Fn(usize) -> bool) {
        let within = self.within.get_or_insert_with(|| vec![true; height]);
        for (row, kept) in within.iter_mut().enumerate() {
            *kept &= is_within(row);
        }
    }
}

impl Recording {
    /// Reads the columns of `path` that are taken, as the mapping says.
    pub(super) fn read(
        path: &Path,
        form: &FileForm,
        name: Option<&Regex>,
        take: &Take,
    ) -> Result<Self, StoreError> {
        let most = form.format_of(path).map_or(MOST_FILE, Format::most_bytes);
        let bytes = read_named(path, most).map_err(|e| StoreError::io(path, "read", &e))?;
        // Before the format's own reader, whose error would not say how to convert the file.
        check_readable(path, &bytes)?;
        let blake3 = hex_blake3(&bytes);
        let groups = name.map_or_else(|| Ok(BTreeMap::new()), |pattern| groups(path, pattern))?;
        let format = form.format_of(path)?;
        let options = FormatOptions {
            dialect: form.dialect(format),
            part: form.part.as_deref(),
            clock: form.clock,
            dejitter: form.dejitter,
        };
        let table = format.read(path, bytes, options, take)?;
        let joined = Joined::default();
        Ok(Self { path: path.to_owned(), table, blake3, cells: form.cells.clone(), joined, groups })
    }

    /// A part of a recording, read.
    pub(super) fn part(
        path: &Path,
        table: Table,
        cells: CellForm,
        groups: BTreeMap<String, String>,
    ) -> Self {
        let joined = Joined::default();
        Self { path: path.to_owned(), table, blake3: String::new(), cells, joined, groups }
    }

    /// The same with this column alone, in which times may be read otherwise than they are written.
    pub(super) fn alone(&self, place: usize) -> Self {
        let Table { names, lines, empty, columns, .. } = &self.table;
        let columns = columns.iter().enumerate();
        let columns = columns
            .map(|(i, cells)| if i == place { cells.clone() } else { Cells::Unread })
            .collect();
        let (names, lines, empty) = (names.clone(), lines.clone(), empty.clone());
        let table = Table { names, lines, empty, columns, ..Table::default() };
        Self::part(&self.path, table, self.cells.clone(), BTreeMap::new())
    }

    /// An error about the file.
    pub(super) fn error(&self, what: impl Into<String>, remedy: impl Into<String>) -> StoreError {
        // An error may repeat a text from the file, however long that is.
        StoreError::new(&self.path, shown(&what.into()), remedy)
    }

    /// The text of a named group of the pattern on the path.
    pub(super) fn group(&self, name: &str) -> Result<String, StoreError> {
        self.groups.get(name).cloned().ok_or_else(|| {
            let what = format!("group '{name}' of the pattern is not in the path");
            self.error(what, "mend the pattern in [name]")
        })
    }

    /// The place of a column, from 0.
    pub(super) fn find(&self, column: &ColumnRef) -> Result<usize, StoreError> {
        let remedy = "name the column as the file does";
        self.table.find(column).map_err(|what| self.error(what, remedy).column(column.to_string()))
    }

    /// One cell.
    pub(super) fn cell(&self, column: &ColumnRef, row: usize) -> Result<Cell<'_>, StoreError> {
        Ok(self.table.columns[self.find(column)?].cell(row))
    }

    /// An error about a cell: column, row, and its line where the file has lines.
    pub(super) fn cell_error(
        &self,
        column: usize,
        row: usize,
        what: &str,
        remedy: &str,
    ) -> StoreError {
        // What a log says wrong is mended there.
        if let Some(JoinedColumn { log, place, rows }) = self.joined.columns.get(&column)
            && let Some(own) = rows.get(row).filter(|row| **row != NO_ROW)
        {
            return log.cell_error(*place, *own as usize, what, remedy);
        }
        let what = match self.table.lines.get(row) {
            Some(line) => format!("{} (line {line})", shown(what)),
            None => what.to_owned(),
        };
        self.error(what, remedy).column(self.table.name(column)).row0(row)
    }

    /// An error about a row: its number, and its line where the file has lines.
    pub(super) fn row_error(&self, row: usize, what: &str, remedy: &str) -> StoreError {
        let line = self.table.lines.get(row).map(|line| format!(" (line {line})"));
        self.error(format!("{what}{}", line.unwrap_or_default()), remedy).row0(row)
    }

    /// The name of a row: its line, if the file has lines.
    pub(super) fn row_name(&self, row: usize) -> String {
        let line = self.table.lines.get(row);
        line.map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"))
    }

    /// How the cells of a column are written: those of a log as the log has them.
    pub(super) fn form_of(&self, column: usize) -> &CellForm {
        self.joined.columns.get(&column).map_or(&self.cells, |joined| &joined.log.cells)
    }

    /// The number in a cell, `None` where it is missing; `Err` says what stands there instead.
    pub(super) fn number(&self, column: usize, row: usize) -> Result<Option<f64>, String> {
        let cell = self.table.columns[column].cell(row);
        let form = self.form_of(column);
        if form.is_missing(&cell) {
            return Ok(None);
        }
        match cell {
            Cell::Empty => Ok(None),
            // Arrays have no other way to write a missing value.
            Cell::Number(value) if value.is_nan() => Ok(None),
            Cell::Number(value) if value.is_finite() => Ok(Some(value)),
            Cell::Number(value) => Err(format!("{value} is not a finite number")),
            Cell::Text(text) => {
                // `true` and `false` stand for 1 and 0 only where the mapping makes a state or a channel of them.
                let truth = truth(text).filter(|_| {
                    let name = self.table.names.as_ref().and_then(|names| names.get(column));
                    let name = name.map(String::as_str);
                    self.cells.truths.iter().any(|listed| listed.means(column, name))
                });
                match truth {
                    Some(truth) => Ok(Some(f64::from(u8::from(truth)))),
                    None => number(text, form.decimal_comma),
                }
            }
        }
    }

    /// Whether the comma stands before decimals in a cell: a number of a workbook has neither sign.
    pub(super) fn has_decimal_comma(&self, column: usize, row: usize) -> bool {
        let cell = self.table.columns[column].cell(row);
        self.form_of(column).decimal_comma && matches!(cell, Cell::Text(_))
    }

    /// Whether the answer that a label names is missing, in a recording whose missing values are left
    /// out.
    pub(super) fn lacks_answer(&self, label: &Label, row: usize) -> Result<bool, StoreError> {
        let Some(column) = label.column().map(|column| self.find(column)).transpose()? else {
            return Ok(false);
        };
        let cell = self.table.columns[column].cell(row).to_string();
        let is_word = find(&label.translate, &cell).is_some();
        let drops = self.form_of(column).missing == Missing::Drop;
        Ok(drops && !is_word && self.number(column, row) == Ok(None))
    }

    /// Whether nothing stands in a cell of a label. What other programs write for a missing value may
    /// be a word of theirs here, such as a mode `None`, unless the mapping names it.
    pub(super) fn is_without_label(&self, column: usize, row: usize) -> bool {
        let cell = self.table.columns[column].cell(row);
        cell == Cell::Empty || self.form_of(column).is_missing(&cell)
    }

    /// The numbers of a column in the rows given; the error names the first cell that is none.
    pub(super) fn numbers(&self, column: usize, rows: &[usize]) -> Result<Vec<f64>, StoreError> {
        // A column that is not mapped may be shorter.
        let values = self.all_numbers(column).and_then(|values| {
            rows.iter().map(|row| values.get(*row).copied()).collect::<Option<Vec<f64>>>()
        });
        if let Some(values) = values {
            return Ok(values);
        }
        let remedy = "mend the cell, or set delimiter and decimal in [file]";
        let numbers = rows.iter().map(|row| match self.number(column, *row) {
            Ok(Some(value)) => Ok(value),
            Ok(None) => Err(self.missing(column, *row)),
            Err(what) => Err(self.cell_error(column, *row, &what, remedy)),
        });
        numbers.collect()
    }

    /// The values of a column of numbers, none of which is missing or refused: most are such.
    fn all_numbers(&self, column: usize) -> Option<&[f64]> {
        let Cells::Numbers(cells) = &self.table.columns[column] else { return None };
        let values = cells.values();
        let is_whole = cells.null_count() == 0
            && self.cells.missing_words.is_empty()
            && values.iter().fold(true, |all, value| all & value.is_finite());
        is_whole.then_some(values)
    }

    /// These numbers as ours, by a line and the factor of their unit.
    pub(super) fn converted(
        &self,
        column: usize,
        rows: &[usize],
        line: &Linear,
        factor: f64,
    ) -> Result<Vec<f64>, StoreError> {
        let mut values = self.numbers(column, rows)?;
        line.apply_to_all(&mut values, factor);
        Ok(values)
    }

    fn missing(&self, column: usize, row: usize) -> StoreError {
        let cell = self.table.columns[column].cell(row);
        let what = match cell {
            Cell::Empty => "the cell is empty".to_owned(),
            cell if self.form_of(column).is_missing(&cell) => {
                format!("'{cell}' stands for a missing value (missing_words)")
            }
            Cell::Text(mark) if !mark.eq_ignore_ascii_case("nan") => {
                format!("'{mark}' is not a number, and stands for a missing value")
            }
            cell => format!("{cell} is not a number"),
        };
        let remedy = "mend the cell, or leave such rows out with missing = \"drop\" in [file]";
        self.cell_error(column, row, &what, remedy)
    }

    /// The rows to take: up to the limit, and without those where one of `numeric` or `text` has no
    /// value if the mapping drops such rows.
    ///
    /// # Errors
    /// No rows at all, columns of different lengths, or a missing value where they are not dropped.
    pub(super) fn rows(
        &self,
        form: &FileForm,
        numeric: &[usize],
        text: &[usize],
    ) -> Result<Rows, StoreError> {
        let rows = self.rows_in(form, numeric, text)?;
        if rows.kept.is_empty() {
            let what =
                if rows.read == 0 { "the file has 0 rows" } else { "no row has all mapped values" };
            return Err(self.error(what, "leave the file out of the import"));
        }
        Ok(rows)
    }

    /// Like [`Recording::rows`], for a part of a recording, which may have no rows.
    ///
    /// # Errors
    /// Columns of different lengths, or a missing value where they are not dropped.
    pub(super) fn rows_in(
        &self,
        form: &FileForm,
        numeric: &[usize],
        text: &[usize],
    ) -> Result<Rows, StoreError> {
        let read = self.height(numeric, text)?;
        if read > MOST_WHOLE_ROWS {
            return Err(too_many_rows(&self.path, &read.to_string()));
        }
        let limit = form.rows.unwrap_or(read).min(read);
        let bad = self.bad_rows(limit, numeric, form.bad_lines);
        let is_outside =
            |row: &usize| self.joined.within.as_ref().is_some_and(|within| !within[*row]);
        let outside = (0..limit).filter(|row| is_outside(row) && !bad.contains_key(row)).count();
        let readable = (0..limit).filter(|row| !bad.contains_key(row) && !is_outside(row));
        let kept: Vec<usize> = match form.cells.missing {
            Missing::Error => readable.collect(),
            Missing::Drop => {
                let gappy = numeric.iter().filter(|column| self.all_numbers(**column).is_none());
                let gappy: Vec<usize> = gappy.copied().collect();
                readable
                    .filter(|row| {
                        // Text that is no number counts as a value here: reading the column reports it.
                        text.iter().all(|column| !self.is_without_label(*column, *row))
                            && gappy.iter().all(|column| self.number(*column, *row) != Ok(None))
                    })
                    .collect()
            }
        };
        let missing = limit - kept.len() - bad.len() - outside;
        Ok(Rows { read, missing, outside, past_limit: read - limit, kept, bad, joined: Vec::new() })
    }

    /// Leaves out of the rows of a questionnaire those that are its header once more, as programs write it
    /// that add to a file; how many.
    pub(super) fn leave_out_headers(&self, rows: &mut Rows, columns: &[usize]) -> usize {
        let before = rows.kept.len();
        let names = self.table.names.as_deref().unwrap_or_default();
        rows.kept.retain(|row| {
            let is_header = columns.iter().all(|column| {
                let cell = self.table.columns[*column].cell(*row);
                names.get(*column).is_some_and(|name| cell == Cell::Text(name))
            });
            columns.is_empty() || !is_header
        });
        before - rows.kept.len()
    }

    /// Rows up to `limit` that cannot be read, at most as many as are allowed: what more there are
    /// is an error of whoever reads them.
    fn bad_rows(&self, limit: usize, numeric: &[usize], allowed: usize) -> BTreeMap<usize, String> {
        let mut bad: BTreeMap<usize, String> =
            self.table.bad.iter().filter(|(row, _)| *row < limit).cloned().collect();
        for row in 0..limit {
            if bad.len() >= allowed {
                break;
            }
            let why = numeric.iter().find_map(|column| {
                let what = self.number(*column, row).err()?;
                Some(self.cell_error(*column, row, &what, "").what)
            });
            if let Some(why) = why.filter(|_| !bad.contains_key(&row)) {
                bad.insert(row, why);
            }
        }
        bad
    }

    /// `rows` in stretches in which the number of `column` does not fall. What is no number parts
    /// nothing, and is an error of whoever reads it.
    pub(super) fn restarts<'a>(
        &self,
        rows: &'a [usize],
        column: usize,
    ) -> impl Iterator<Item = &'a [usize]> {
        rows.chunk_by(move |a, b| {
            let [a, b] = [a, b].map(|row| self.number(column, *row).ok().flatten());
            !a.zip(b).is_some_and(|(a, b)| b < a)
        })
    }

    /// `rows` in stretches of labels that are alike, and of one row of a log: each is one trial or one sweep.
    pub(super) fn pieces<'a>(
        &self,
        rows: &'a [usize],
        labels: &[usize],
    ) -> impl Iterator<Item = &'a [usize]> {
        let parts = self.joined.parts.as_deref();
        rows.chunk_by(move |a, b| {
            let is_one = parts.is_none_or(|parts| parts[*a] == parts[*b]);
            is_one
                && labels.iter().all(|column| {
                    let cells = &self.table.columns[*column];
                    cells.cell(*a).is_like(&cells.cell(*b))
                })
        })
    }

    /// What of the recording could not be read, in words: of the rows that were passed by, those among
    /// `part`.
    pub(super) fn lost(&self, rows: &Rows, part: Range<usize>) -> Option<String> {
        let mut bad = rows.bad.range(part).map(|(row, _)| *row);
        let passed_by = bad.next().map(|first| {
            let first = self.row_name(first);
            match bad.count() {
                0 => format!("{first} could not be read, and is left out (bad_lines)"),
                n => {
                    format!("{first} and {n} more could not be read, and are left out (bad_lines)")
                }
            }
        });
        let lost: Vec<String> = self.table.lost.iter().cloned().chain(passed_by).collect();
        (!lost.is_empty()).then(|| lost.join("; "))
    }

    /// The gaps of a stretch of the rows taken, between its first row and its last.
    pub(super) fn gaps(&self, taken: &Rows, rows: &[usize]) -> Gaps {
        let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
            return Gaps::default();
        };
        let joined = taken.joined.iter().filter(|row| (first..=last).contains(row)).count();
        let bad = taken.bad.range(first..=last).count() + joined;
        let [first, last] = [*first, *last].map(|row| Standing::default().of(&self.table, row));
        Gaps::between(first, last, rows.len(), bad)
    }

    /// The places of rows among all rows of the file, from the first of them on: at a rate, the
    /// number of a sample.
    pub(super) fn places(&self, rows: &[usize]) -> Vec<usize> {
        let first = rows.first().map_or(0, |first| self.table.place(*first));
        rows.iter().map(|row| self.table.place(*row) - first).collect()
    }

    /// The number of rows that the columns in use have.
    ///
    /// # Errors
    /// Columns of different lengths.
    pub(super) fn height(&self, numeric: &[usize], text: &[usize]) -> Result<usize, StoreError> {
        let mut columns = numeric.iter().chain(text);
        let Some(first) = columns.next() else {
            let read = self.table.columns.iter().find(|column| !matches!(column, Cells::Unread));
            return Ok(read.map_or(0, Cells::len));
        };
        let rows = self.table.columns[*first].len();
        match columns.find(|c| self.table.columns[**c].len() != rows) {
            None => Ok(rows),
            Some(other) => {
                let has = self.table.columns[*other].len();
                let what =
                    format!("it has {has} values where '{}' has {rows}", self.table.name(*first));
                Err(self
                    .error(what, "map only columns of one length")
                    .column(self.table.name(*other)))
            }
        }
    }
}

/// The named groups of a pattern on a path.
pub(super) fn groups(path: &Path, pattern: &Regex) -> Result<BTreeMap<String, String>, StoreError> {
    // So that one pattern does on every system.
    let text = path.to_string_lossy().replace('\\', "/");
    let captures = pattern.captures(&text).ok_or_else(|| {
        let what = format!("the path does not match the pattern '{pattern}'");
        StoreError::new(path, what, "mend the pattern in [name], or leave the file out")
    })?;
    let groups = pattern
        .capture_names()
        .flatten()
        .filter_map(|name| Some((name.to_owned(), captures.name(name)?.as_str().to_owned())));
    Ok(groups.collect())
}

/// The number that `text` spells, `None` where it spells a missing value.
pub(super) fn number(text: &str, decimal_comma: bool) -> Result<Option<f64>, String> {
    if is_missing(text) {
        return Ok(None);
    }
    // The other sign may part thousands, or stand before decimals after all: nobody knows.
    let value: Option<f64> = match (decimal_comma, text.contains('.'), text.contains(',')) {
        (true, true, _) | (false, _, true) => None,
        (true, false, _) => text.replace(',', ".").parse().ok(),
        (false, _, false) => text.parse().ok(),
    };
    match value {
        Some(value) if value.is_finite() => Ok(Some(value)),
        Some(_) => Err(format!("'{text}' is not a finite number")),
        None if text.contains([',', '.']) => {
            let point = if decimal_comma { ',' } else { '.' };
            Err(format!("'{text}' is not a number with '{point}' before its decimals"))
        }
        None => Err(format!("'{text}' is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::{FORCE, ONE, World, trials_map};
    use super::super::{mat, parquet};
    use super::*;
    use zwidth_store::Signal;

    #[test]
    #[allow(clippy::float_cmp)]
    fn denormals_and_minus_zero_read_with_their_bits() {
        let bits = |text: &str| number(text, false).unwrap().unwrap().to_bits();
        assert_eq!(bits("1.98614e-321"), 402);
        assert_eq!(bits("1e-321"), 1e-321_f64.to_bits());
        assert_eq!(bits("-0"), (-0.0_f64).to_bits());
        assert_eq!(number("-1,5", true), Ok(Some(-1.5)));
        assert_eq!(number("NaN", false), Ok(None));
    }

    #[test]
    fn what_is_no_number_is_refused_with_its_text() {
        let check = |text: &str, comma: bool, words: &str| {
            let error = number(text, comma).unwrap_err();
            assert!(error.contains(text) && error.contains(words), "{error}");
        };
        check("abc", false, "not a number");
        check("1,5", false, "'.' before its decimals");
        check("1.234,5", true, "',' before its decimals");
        check("inf", false, "finite");
        check("1e999", false, "finite");
        check("0x10", false, "not a number");
    }

    #[test]
    fn semicolons_decimal_commas_carriage_returns_and_a_byte_order_mark_read_alike() {
        let world = World::new();
        let file = world.file("a.csv", "\u{feff}t;f\r\n0;1,5\r\n0,5;-2\r\n");
        let form = "[file]\ndelimiter = \";\"\ndecimal = \",\"\n";
        world.import(&trials_map(&[form, ONE, FORCE]), &[file]).unwrap();
        assert_eq!(world.column(1, Signal::Time), [0.0, 0.5]);
        assert_eq!(world.column(1, Signal::ForceEx), [1.5, -2.0]);
    }

    fn parquet_file() -> Vec<u8> {
        use arrow::array::{ArrayRef, Float64Array, Int32Array, RecordBatch};
        let f: ArrayRef = std::sync::Arc::new(Float64Array::from(vec![1.5, 2.0, 4.0]));
        let t: ArrayRef = std::sync::Arc::new(Int32Array::from(vec![0, 500, 1000]));
        parquet::tests::encode(&RecordBatch::try_from_iter([("f", f), ("t", t)]).unwrap())
    }

    #[test]
    fn every_format_gives_the_same_trial() {
        let map = trials_map(&[ONE, &FORCE.replace("\"s\"", "\"ms\"")]);
        let mat = |big| {
            let t = [0.0, 500.0, 1e3];
            mat::tests::encode(&[(b'z', &[1.0]), (b't', &t), (b'f', &[1.5, 2.0, 4.0])], big)
        };
        let check = |name: &str, form: &str, content: &[u8]| {
            let world = World::new();
            world.import(&format!("{map}{form}"), &[world.file(name, content)]).unwrap();
            assert_eq!(world.column(1, Signal::Time), [0.0, 0.5, 1.0], "{name}");
            assert_eq!(world.column(1, Signal::ForceEx), [1.5, 2.0, 4.0], "{name}");
        };
        check("a.csv", "", b"t,f\n0,1.5\n500,2\n1e3,4\n");
        check("a.tsv", "", b"f\tt\n1.5\t0\n2\t500\n4\t1000\n");
        check("a.jsonl", "", b"{\"t\":0,\"f\":1.5}\n{\"f\":2,\"t\":5e2}\n{\"f\":4,\"t\":1000}\n");
        check("a.parquet", "", &parquet_file());
        check("a.mat", "", &mat(false));
        check("a.mat", "", &mat(true));
        let blanks = "[file]\nformat = \"csv\"\ndelimiter = \" \"\n";
        check("a.txt", blanks, b"t f\n0 1.5\n500 2\n1000 4\n");
    }

    #[test]
    fn a_cut_file_of_any_format_is_one_clear_error() {
        let world = World::new();
        let mat = mat::tests::encode(&[(b't', &[0.0, 1.0]), (b'f', &[1.0, 2.0])], false);
        for (name, content) in [
            ("a.parquet", parquet_file()),
            ("a.mat", mat),
            ("a.jsonl", b"{\"t\":0,\"f\":1}\n{\"t\":1".to_vec()),
        ] {
            let cut = world.file(name, &content[..content.len() - 9]);
            world.refuses(&trials_map(&[ONE, FORCE]), &cut, "not a", None);
        }
    }

    #[test]
    fn mapped_columns_of_different_lengths_are_refused_others_do_not_matter() {
        let world = World::new();
        let columns: [(u8, &[f64]); 3] =
            [(b't', &[0.0, 1.0]), (b'f', &[1.0, 2.0, 3.0]), (b'z', &[1.0])];
        let mat = mat::tests::encode(&columns, false);
        let words = "it has 3 values where 't' has 2";
        world.refuses(&trials_map(&[ONE, FORCE]), &world.file("a.mat", mat), words, None);
    }

    #[test]
    fn bad_input_is_one_clear_error_with_file_column_and_row() {
        let world = World::new();
        let backwards = "time runs backwards or stands still: 0.5 s after 1 s";
        let comma = "'1,5' is not a number with '.' before its decimals";
        for (csv, words, at) in [
            ("t,f\n0,1\n1,abc\n", "'abc' is not a number (line 3)", Some(("f", 2))),
            ("t,f\n0,1\n1,NaN\n", "NaN is not a number (line 3)", Some(("f", 2))),
            ("t,f\n0,1\n1,inf\n", "'inf' is not a finite number", Some(("f", 2))),
            ("t,f\n0,1\n1,\n", "the cell is empty (line 3)", Some(("f", 2))),
            ("t,f\n0,1\n1,2\n0.5,3\n", backwards, Some(("t", 3))),
            ("t,f\n0,1\n0,2\n", "stands still", Some(("t", 2))),
            ("t,g\n0,1\n", "column f: the column is missing; the file has t, g", None),
            ("t;f\n0;1\n", "column t: the column is missing", None),
            ("t,f\n0,1\n1\n", "line 3 has 1 cells where 2 belong", None),
            ("t,f\n0,\"1,5\"\n", comma, Some(("f", 1))),
            ("\u{feff}\r\n", "the file is empty", None),
        ] {
            let file = world.file("bad.csv", csv);
            world.refuses(&trials_map(&[ONE, FORCE]), &file, words, at);
        }
    }

    #[test]
    fn what_others_write_for_a_missing_value_is_one_whatever_the_format() {
        let map = trials_map(&["[file]\nmissing = \"drop\"\n", ONE, FORCE]);
        for mark in ["NA", "n/a", "-nan(ind)", "1.#QNAN", "#N/A", "None", "null", ".", "NaN", ""] {
            let lines = format!("t,f\n0,1\n1,{mark}\n2,3\n");
            let json =
                format!("{{\"t\":0,\"f\":1}}\n{{\"t\":1,\"f\":\"{mark}\"}}\n{{\"t\":2,\"f\":3}}\n");
            for (name, text) in [("a.csv", &lines), ("a.jsonl", &json)] {
                let world = World::new();
                let file = world.file(name, text);
                let strict = map.replace("missing = \"drop\"", "");
                world.refuses(&strict, &file, "leave such rows out with missing", Some(("f", 2)));
                let report = world.import(&map, &[file]).unwrap();
                assert_eq!(report.files[0].rows_dropped[0].rows, 1, "{mark}");
                assert_eq!(world.column(1, Signal::Time), [0.0, 2.0], "{mark}");
            }
            let world = World::new();
            let report = world.import_streamed(&map, &[world.file("a.csv", lines)]).unwrap();
            assert_eq!(report.files[0].rows_kept, 2, "{mark}");
        }
    }

    #[test]
    fn own_words_for_a_missing_value_are_named_in_the_mapping() {
        let words = "[file]\nmissing = \"drop\"\nmissing_words = [\"-99\", \"x\"]\n";
        let map = trials_map(&[words, ONE, FORCE]);
        for (name, text) in [
            ("a.csv", "t,f\n0,1\n1,-99\n2,x\n3,-99.0\n4,5\n"),
            ("a.jsonl", "{\"t\":0,\"f\":1}\n{\"t\":1,\"f\":-99}\n{\"t\":4,\"f\":5}\n"),
        ] {
            let world = World::new();
            world.import(&map, &[world.file(name, text)]).unwrap();
            assert_eq!(world.column(1, Signal::Time), [0.0, 4.0], "{name}");
        }
        let world = World::new();
        let strict = map.replace("missing = \"drop\"", "");
        let file = world.file("a.csv", "t,f\n0,1\n1,-99\n");
        world.refuses(&strict, &file, "'-99' stands for a missing value", Some(("f", 2)));
    }

    #[test]
    fn truth_values_are_numbers_only_where_bits_or_a_channel_are_asked_for() {
        let world = World::new();
        let bits = "[[column]]\nto = \"state_bits\"\nfrom = \"on\"\nunit = \"bits\"\n";
        let file = world.file("a.csv", "t,f,on\n0,1,True\n1,2,FALSE\n2,3,1\n");
        world.import(&trials_map(&[ONE, FORCE, bits]), &[file]).unwrap();
        assert_eq!(world.column(1, Signal::StateBits), [1.0, 0.0, 1.0]);
        let world = World::new();
        let file = world.file("a.csv", "t,f\n0,TRUE\n");
        world.refuses(&trials_map(&[ONE, FORCE]), &file, "'TRUE' is not a number", Some(("f", 1)));
    }

    #[test]
    fn a_trial_whose_answer_is_missing_is_a_trial_without_one() {
        let map = format!("{ONE}likert = {{ column = \"q\" }}\n");
        let map = trials_map(&["[file]\nmissing = \"drop\"\n", &map, FORCE]);
        for mark in ["", "None"] {
            for import in [World::import, World::import_streamed] {
                let world = World::new();
                let file = world.file("a.csv", format!("t,f,q\n0,1,{mark}\n1,2,{mark}\n"));
                let report = import(&world, &map, &[file]).unwrap();
                assert_eq!((report.trials, report.answers), (1, 0));
            }
        }
    }

    #[test]
    fn every_error_of_every_file_is_reported() {
        let world = World::new();
        let files = [
            world.file("a.csv", "t,f\nx,y\n"),
            world.file("b.csv", "t\n0\n"),
            world.file("c.xyz", "t,f\n"),
        ];
        let errors = world.import(&trials_map(&[ONE, FORCE]), &files).unwrap_err();
        assert_eq!(errors.len(), 4, "{errors:?}");
    }

    #[test]
    fn a_file_that_is_wrong_throughout_is_told_up_to_a_thousand_errors() {
        let world = World::new();
        let one: String = (0..3000).map(|i| format!("{i},x\n")).collect();
        let map = trials_map(&[&ONE.replace("\"hybrid\"", "{ column = \"f\" }"), FORCE]);
        let bad: String = (0..3000).map(|i| format!("{i},x{i}\n")).collect();
        let errors = world.import(&map, &[world.file("a.csv", format!("t,f\n{one}"))]).unwrap_err();
        assert_eq!(errors.len(), 1);
        let errors = world.import(&map, &[world.file("b.csv", format!("t,f\n{bad}"))]).unwrap_err();
        assert_eq!(errors.len(), 1001);
        assert!(errors[1000].what.contains("more errors than these"), "{}", errors[1000]);
    }

    #[test]
    fn a_missing_file_and_a_damaged_one_are_refused() {
        let world = World::new();
        let map = trials_map(&[ONE, FORCE]);
        world.refuses(&map, &world.layout.raw().join("nothing.csv"), "cannot read", None);
        for name in ["a.parquet", "a.mat", "a.jsonl"] {
            world.refuses(&map, &world.file(name, b"PAR1 what is this"), "not a", None);
        }
    }
}
