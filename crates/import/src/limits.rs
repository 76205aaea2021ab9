//! How much of other people's files is read: their claims never decide how much memory is allocated
//! (`docs/data.md`, "Limits").

use super::spelling::shown;
use super::table::ColumnRef;
use regex::Regex;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use zwidth_store::{Samples, Signal, StoreError};

/// Bytes of one recording (256 MiB); files are read side by side up to as many together.
pub(super) const MOST_FILE: u64 = 1 << 28;
/// Bytes of a recording of which only the numbers of mapped columns are unpacked (1 GiB): no other file is read beside it.
pub(super) const LARGEST_WHOLE: u64 = 1 << 30;
/// Bytes of a long text, which is read block by block (8 GiB).
pub(super) const LONGEST_FILE: u64 = 1 << 33;
/// Texts of more bytes are read block by block (32 MiB).
pub(super) const LONG_FROM: u64 = 1 << 25;
/// Rows of a recording that is read whole: with every signal in memory twice, 0.9 GB.
pub(super) const MOST_WHOLE_ROWS: usize = 1 << 22;
/// Bytes of a mapping file (256 KiB).
pub(super) const MOST_MAPPING: u64 = 1 << 18;
/// Problems of a mapping file that are kept: each reads the text for its line.
pub(super) const MOST_ERRORS: usize = 1_000;
/// Bytes of a line of text, a cell in quotes with line breaks included: 64 for each of
/// [`MOST_COLUMNS`].
pub(super) const MOST_LINE: usize = 1 << 20;
/// Columns, keys or variables of one recording.
pub(super) const MOST_COLUMNS: usize = 1 << 14;
/// Bytes of a column's name.
pub(super) const MOST_NAME: usize = 1 << 12;
/// Bytes that the mapped columns of a Parquet file, or a variable of a MAT file, unpack to (256
/// MiB).
pub(super) const MOST_UNPACKED: u64 = 1 << 28;
/// Bytes of the texts in the mapped columns of a Parquet file (128 MiB): a word that every row
/// repeats is packed once.
pub(super) const MOST_TEXT: usize = 1 << 27;
/// Cells of mapped columns, over all files of an import: as numbers 256 MiB.
const MOST_CELLS: usize = 1 << 25;
/// Trials, sweeps, or rows of questionnaires of an import: each has a file or an entry of its own.
const MOST_TRIALS: usize = 1 << 14;
/// Answers to tasks of an import: each has an entry of its own in the record of its session.
const MOST_ANSWERS: usize = 1_000_000;
/// Answers to tasks of a session: its record has to be read again.
pub(super) const MOST_OF_SESSION: usize = 50_000;
/// The highest number of a trial, a repeat or a sweep.
pub(super) const MOST_NUMBER: u32 = 1_000_000;
/// Rates of a recording, Hz.
pub(super) const RATES_HZ: std::ops::RangeInclusive<f64> = 1e-3..=1e6;
/// From the first sample to the last, s: a day.
const MOST_SPAN_S: f64 = 86_400.0;
/// The latest time, s, from whatever it is counted: three thousand years.
const MOST_TIME_S: f64 = 1e11;
/// Positions and forces in space, and the largest of them, m or N.
const IN_SPACE: [Signal; 6] =
    [Signal::X, Signal::Y, Signal::Z, Signal::ForceX, Signal::ForceY, Signal::ForceZ];
const MOST_IN_SPACE: f64 = 1e9;
/// The largest angle, rad: a thousand turns.
const MOST_ANGLE_RAD: f64 = 1_000.0 * std::f64::consts::TAU;

/// The room that an import has left, over all its files, which are read side by side.
#[derive(Debug, Default)]
pub(super) struct Budget {
    cells: AtomicUsize,
    trials: AtomicUsize,
    answers: AtomicUsize,
}

impl Budget {
    /// Takes room for cells, before memory is; `false` where there is none left.
    pub(super) fn cells(&self, n: usize) -> bool {
        spend(&self.cells, n, MOST_CELLS)
    }

    /// Gives back the room of cells that are not kept.
    pub(super) fn give_back(&self, n: usize) {
        let _ = self.cells.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |spent| {
            Some(spent.saturating_sub(n))
        });
    }

    /// Takes room for trials.
    ///
    /// # Errors
    /// There is none left.
    pub(super) fn trials(&self, path: &Path, n: usize) -> Result<(), StoreError> {
        if spend(&self.trials, n, MOST_TRIALS) { Ok(()) } else { Err(too_much(path)) }
    }

    /// Takes room for answers to tasks.
    ///
    /// # Errors
    /// There is none left.
    pub(super) fn answers(&self, path: &Path, n: usize) -> Result<(), StoreError> {
        if spend(&self.answers, n, MOST_ANSWERS) { Ok(()) } else { Err(too_much(path)) }
    }

    /// Whether all there was to be taken fitted. Which of the files was one too many depends on the
    /// order in which they were read, so that all of them are named together.
    ///
    /// # Errors
    /// There was too much of something; the error names it.
    pub(super) fn held(&self, files: &[std::path::PathBuf]) -> Result<(), StoreError> {
        let over = [
            (&self.cells, MOST_CELLS, "cells in mapped columns"),
            (&self.trials, MOST_TRIALS, "trials, sweeps or answered rows"),
            (&self.answers, MOST_ANSWERS, "answers to tasks"),
        ]
        .into_iter()
        .find(|(spent, most, _)| spent.load(Ordering::Relaxed) > *most);
        let Some((_, most, of_what)) = over else { return Ok(()) };
        let what = format!("more than {most} {of_what}, and no more are read in one import");
        let first = files.first().map_or(Path::new("."), std::path::PathBuf::as_path);
        Err(match files.len() {
            1 => StoreError::new(first, format!("the file has {what}"), "split it"),
            n => {
                let what = format!("this file and the {} others have {what}", n - 1);
                let remedy = "import them in several commands, whole sessions in each";
                StoreError::new(first, what, remedy)
            }
        })
    }
}

fn spend(spent: &AtomicUsize, n: usize, most: usize) -> bool {
    // Saturating, for a file may claim so much that a sum would begin at 0 again.
    let before = spent
        .fetch_update(Ordering::Relaxed, Ordering::Relaxed, |spent| Some(spent.saturating_add(n)));
    before.unwrap_or(usize::MAX).saturating_add(n) <= most
}

/// Stands for the error of [`Budget::held`], which takes its place.
fn too_much(path: &Path) -> StoreError {
    let what = "with it the import has more than is read at once";
    StoreError::new(path, what, "import fewer files at once")
}

/// The error of a recording with too many rows; `rows` in words.
pub(super) fn too_many_rows(path: &Path, rows: &str) -> StoreError {
    let what = format!("the file has {rows} rows, and at most {MOST_WHOLE_ROWS} are read");
    let remedy = "split it, or write it as CSV: a long text is read part by part";
    StoreError::new(path, what, remedy)
}

/// The error of a recording whose rows are counted only up to those that are read.
pub(super) fn more_rows(path: &Path) -> StoreError {
    too_many_rows(path, &format!("more than {MOST_WHOLE_ROWS}"))
}

/// Checks that so many rows are read whole.
///
/// # Errors
/// There are too many.
pub(super) fn check_rows(path: &Path, rows: usize) -> Result<(), StoreError> {
    if rows > MOST_WHOLE_ROWS { Err(too_many_rows(path, &rows.to_string())) } else { Ok(()) }
}

/// The error of mapped columns with too long texts.
pub(super) fn too_much_text(path: &Path) -> StoreError {
    let what = format!("the texts in mapped columns have more than {MOST_TEXT} bytes");
    StoreError::new(path, what, "split the file")
}

/// The error of a line, or a record, that is longer than any is read.
pub(super) fn long_line(path: &Path, line: u64) -> StoreError {
    let what = format!("line {line} has more than {MOST_LINE} bytes, and no more are read");
    StoreError::new(path, what, "check the quotes of the line, and how lines end")
}

/// Checks that so many columns may be read.
///
/// # Errors
/// There are too many.
pub(super) fn check_columns(path: &Path, columns: usize) -> Result<(), StoreError> {
    if columns <= MOST_COLUMNS {
        return Ok(());
    }
    let what = format!("the file has {columns} columns, and at most {MOST_COLUMNS} are read");
    let remedy = "leave out those that are not needed, or check the delimiter in [file]";
    Err(StoreError::new(path, what, remedy))
}

/// Checks that a name is short enough.
///
/// # Errors
/// It is longer.
pub(super) fn check_name(path: &Path, name: &str) -> Result<(), StoreError> {
    if name.len() <= MOST_NAME {
        return Ok(());
    }
    let what =
        format!("a column's name has {} bytes, and at most {MOST_NAME} are read", name.len());
    Err(StoreError::new(path, what, "shorten it").column(shown(name)))
}

/// The columns of a recording that are taken; no other is kept in memory.
pub(super) struct Take<'a> {
    pub(super) columns: Vec<&'a ColumnRef>,
    /// Columns whose names match are taken too.
    pub(super) pattern: Option<&'a Regex>,
    /// Whether the columns of a matrix are its rows.
    pub(super) turned: bool,
    pub(super) budget: &'a Budget,
}

impl<'a> Take<'a> {
    /// These columns.
    pub(super) fn of(columns: Vec<&'a ColumnRef>, budget: &'a Budget) -> Self {
        Self { columns, pattern: None, turned: false, budget }
    }

    /// Takes room for cells, before memory is.
    ///
    /// # Errors
    /// There is none left.
    pub(super) fn room(&self, path: &Path, cells: usize) -> Result<(), StoreError> {
        if self.budget.cells(cells) { Ok(()) } else { Err(too_much(path)) }
    }

    /// Whether the mapping names the column at `place` (from 0).
    pub(super) fn is_mapped(&self, place: usize, name: Option<&str>) -> bool {
        self.columns.iter().any(|column| column.means(place, name))
    }

    /// Whether the column at `place` (from 0) is taken; `name` is its name where it has one.
    pub(super) fn wants(&self, place: usize, name: Option<&str>) -> bool {
        self.is_mapped(place, name)
            || name.is_some_and(|name| self.pattern.is_some_and(|pattern| pattern.is_match(name)))
    }
}

/// Checks that angle and time are of a size that analyses can go through step by step. The error
/// names our column and the row.
pub(super) fn check_sizes(path: &Path, samples: &Samples) -> Result<(), StoreError> {
    if let Some(t) = samples.get(Signal::Time) {
        check_time(t).map_err(|(row, what)| {
            let error = StoreError::new(path, what, "check the unit of the time");
            error.column(Signal::Time.name()).row0(row)
        })?;
    }
    for signal in IN_SPACE {
        let values = samples.get(signal).unwrap_or_default();
        if let Some(row) = values.iter().position(|v| v.abs() > MOST_IN_SPACE) {
            let (unit, value) = (signal.column().unit, values[row]);
            let what = format!("{value:e} {unit} is more than any device has");
            let remedy = "check unit, scale and offset of the column, or leave the row out";
            return Err(StoreError::new(path, what, remedy).column(signal.name()).row0(row));
        }
    }
    let theta = samples.get(Signal::Theta).unwrap_or_default();
    let Some(row) = theta.iter().position(|v| v.abs() > MOST_ANGLE_RAD) else { return Ok(()) };
    let what = format!("the angle {} rad is more than a thousand turns", theta[row]);
    let remedy = "check unit, scale and offset of the angle, or leave the row out";
    let error = StoreError::new(path, what, remedy);
    Err(error.column(Signal::Theta.name()).row0(row))
}

/// Checks that times are of a sensible size; `Err` is the row (from 0) and what is wrong.
pub(super) fn check_time(t_s: &[f64]) -> Result<(), (usize, String)> {
    let first = t_s.first().copied().unwrap_or_default();
    let late = t_s.iter().position(|t| t.abs() > MOST_TIME_S || t - first > MOST_SPAN_S);
    late.map_or(Ok(()), |row| {
        let what = if t_s[row].abs() > MOST_TIME_S {
            format!("the time {} s is past {MOST_TIME_S} s", t_s[row])
        } else {
            format!("{} s after the first sample is more than a day", t_s[row] - first)
        };
        Err((row, what))
    })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::table::{Cell, Table};
    use super::*;

    /// Every column of a file of up to 64.
    pub(in super::super) fn everything<T>(read: impl FnOnce(&Take) -> T) -> T {
        let columns: Vec<ColumnRef> = (1..=64).map(ColumnRef::Position).collect();
        let budget = Budget::default();
        read(&Take::of(columns.iter().collect(), &budget))
    }

    /// The columns of these names.
    pub(in super::super) fn only<T>(names: &[&str], read: impl FnOnce(&Take) -> T) -> T {
        let named = names.iter().map(|name| ColumnRef::Name((*name).to_owned()));
        let columns: Vec<ColumnRef> = named.collect();
        let budget = Budget::default();
        read(&Take::of(columns.iter().collect(), &budget))
    }

    /// The numbers of a column, null where there is none.
    pub(in super::super) fn numbers(table: &Table, name: &str) -> Vec<Option<f64>> {
        let place = table.find(&ColumnRef::Name(name.to_owned())).unwrap();
        let cell = |row| match table.columns[place].cell(row) {
            Cell::Number(number) => Some(number),
            _ => None,
        };
        (0..table.columns[place].len()).map(cell).collect()
    }

    /// Every column of a matrix whose rows are the signals.
    pub(in super::super) fn everything_turned<T>(read: impl FnOnce(&Take) -> T) -> T {
        everything(|take| {
            read(&Take { turned: true, ..Take::of(take.columns.clone(), take.budget) })
        })
    }

    #[test]
    fn what_is_spent_by_many_files_is_told_as_theirs_together() {
        let budget = Budget::default();
        assert!(budget.cells(MOST_CELLS) && !budget.cells(1) && !budget.cells(usize::MAX));
        let two = ["a.csv", "b.csv"].map(std::path::PathBuf::from);
        let error = budget.held(&two).unwrap_err().to_string();
        assert!(error.contains("the 1 others have more than 33554432 cells"), "{error}");
        let budget = Budget::default();
        assert!(budget.trials(&two[0], MOST_TRIALS).is_ok() && budget.held(&two).is_ok());
        assert!(budget.trials(&two[0], 1).is_err());
        assert!(budget.held(&two[..1]).unwrap_err().what.contains("more than 16384 trials"));
    }

    #[test]
    fn times_of_more_than_a_day_and_angles_of_more_than_a_thousand_turns_are_refused_with_their_row()
     {
        let with = |t: &[f64], theta: &[f64]| {
            let mut samples = Samples::default();
            samples.set(Signal::Time, t.to_vec());
            samples.set(Signal::Theta, theta.to_vec());
            check_sizes(Path::new("a.csv"), &samples)
        };
        assert_eq!(with(&[1.7e9, 1.7e9 + 86_400.0], &[6_283.0, -6_283.0]), Ok(()));
        for (t, theta, row, words) in [
            ([0.0, 86_401.0], [0.0, 0.0], 2, "more than a day"),
            ([1e12, 1e308], [0.0, 0.0], 1, "is past"),
            ([0.0, 1.0], [0.0, -1e6], 2, "-1000000 rad is more than a thousand turns"),
            ([0.0, 1.0], [1e308, 0.0], 1, "thousand turns"),
        ] {
            let error = with(&t, &theta).unwrap_err();
            assert!(error.row == Some(row) && error.what.contains(words), "{error}");
        }
    }
}
