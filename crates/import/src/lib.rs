//! Import: recordings of other rigs, through a mapping file, into a study (`docs/import.md`).
//!
//! All files are read, converted and checked before anything is written, and what is written is
//! written whole or not at all. What a recording lacks is a null column; what was computed (a
//! derivative, a time from a rate) was asked for in the mapping, and the files made say so.
//!
//! A file goes through: `recording` (its format becomes a `table` of text and number columns) →
//! `trials`, `sweeps` or `likert` (labels resolved, units converted) → `batch` (bytes, written).

mod added;
mod batch;
mod blocks;
mod check;
mod check_likert;
mod check_samples;
mod check_sweeps;
mod clock;
mod convert;
mod counter;
mod csv;
mod declared;
mod exclusions;
mod feather;
mod format;
mod given;
mod guess;
mod guess_answers;
mod guess_apart;
mod guess_names;
mod guess_read;
mod guess_words;
mod hdf5;
mod identity;
mod jsonl;
#[cfg(test)]
mod killed;
mod label;
mod labview;
mod late;
mod likert;
mod limits;
mod long;
mod mapping;
mod mat;
mod matlab;
mod mend;
#[cfg(test)]
mod mistakes;
mod npy;
mod once;
mod order;
mod outline;
mod parquet;
mod plain;
mod plan;
#[cfg(any(test, feature = "testing"))]
pub mod readers;
#[cfg(test)]
mod real;
mod recording;
mod report;
mod shape;
#[cfg(test)]
mod skipped;
mod spelling;
mod stream;
mod sweeps;
mod table;
mod text;
mod trials;
mod unit;
mod wide;
mod workbook;
#[cfg(test)]
mod world;
mod xdf;
mod xml;
mod zero;
mod zip;

pub use guess::{Guess, guess};
pub use late::{Claims, LateAnswer, LateAnswers, TrialMeant};
pub use mapping::Mapping;
pub use report::{ColumnDropped, FileReport, Report, RowsDropped, Unplanned};

use batch::Batch;
use format::Format;
use limits::{Budget, MOST_FILE, Take, shown};
use mapping::Content;
use order::in_order;
use rayon::prelude::*;
use recording::{Recording, Rows};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use table::ColumnRef;
use zwidth_store::commit::settle;
use zwidth_store::{
    Files, FirstErrors, Layout, MOST_STUDY, SOURCE, StoreError, StudyData, against_plan, hex_blake3,
};
use zwidth_study::{Study, printable};

/// A piece of an import's work that is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// So many bytes of the recordings were read and converted.
    Read(u64),
    /// One of so many files of the study was written. Nothing is read any more.
    Written {
        /// How many there are.
        all: usize,
    },
}

/// Who imports, and when.
#[derive(Debug, Clone, Copy)]
pub struct By<'a> {
    /// The time in RFC 3339, for the event log.
    pub utc: &'a str,
    /// The program with its version, for the session records.
    pub software: &'a str,
}

/// Imports `files` into the study at `layout`, as `mapping` says.
///
/// `study` is the content of the study's `study.toml`; `disk` holds the study; `progress` is told
/// each step, from any thread. The caller
/// holds the study's lock. What an import before this one left because it was killed is removed
/// first.
///
/// # Errors
/// Everything found wrong, each with file, column and row; then nothing was written. When writing
/// fails, what this import had written is removed again, and the error says so.
pub fn import(
    layout: &Layout,
    study: &Study,
    mapping: &Mapping,
    files: &[PathBuf],
    by: By,
    disk: &dyn Files,
    progress: &(dyn Fn(Step) + Sync),
) -> Result<Report, FirstErrors> {
    // What the last import left would stand in the way of what this one writes.
    all(settle(disk, layout))?;
    let read = disk.read(&layout.study_toml(), MOST_STUDY);
    let study_toml = read.map_err(|e| StoreError::io(&layout.study_toml(), "read", &e))?;
    let study_blake3 = hex_blake3(&study_toml);
    let context = Context {
        layout,
        study,
        mapping,
        software: by.software,
        study_toml,
        study_blake3,
        files: disk,
        progress,
    };
    if files.is_empty() {
        let what = "no file is given";
        return Err(StoreError::new(Path::new("."), what, "name the files to import").into());
    }
    let files = &in_order(files);
    let batch = match &mapping.content {
        Content::Trials { who, time, columns, channels } => {
            trials::trials(&context, who, time, columns, channels, files)?
        }
        Content::Sweeps(sweep) => sweeps::sweeps(&context, sweep, files)?,
        Content::Likert(asked) => likert::likert(&context, asked, files)?,
        // They add to logs that are there.
        Content::Exclusions(form) => return exclusions::import(&context, form, files, by.utc),
    };
    batch.write(disk, layout, by.utc, &|all| progress(Step::Written { all }))?;
    let odd = against_plan_of(disk, layout, &batch);
    Ok(batch.report(layout, odd))
}

/// What of these sessions is more, less or other than planned. What keeps the study from being read is told by
/// whoever reads it next: this import is made.
fn against_plan_of(disk: &dyn Files, layout: &Layout, batch: &Batch) -> Vec<Unplanned> {
    let Ok(data) = StudyData::load_from(disk, layout) else { return Vec::new() };
    let new: BTreeSet<&Path> = batch.outputs.iter().map(|(path, _)| path.as_path()).collect();
    let found =
        against_plan(&data).into_iter().filter(|finding| new.contains(finding.path.as_path()));
    found
        .map(|finding| Unplanned {
            file: layout.shown(&finding.path).display().to_string(),
            what: format!("{}; {}", finding.what, finding.remedy),
        })
        .collect()
}

/// Why rows are left out where the mapping drops those without a value.
const MISSING: &str = "a mapped cell is empty or NaN (missing = \"drop\")";

/// What is said of empty rows that are no samples.
const EMPTY: &str = "empty";
/// What is said of empty rows where samples come at a rate.
const EMPTY_AT_A_RATE: &str =
    "empty: within a trial no sample stands there, and later samples keep their time";

/// A file, and what was made of it.
struct Converted<T> {
    path: PathBuf,
    /// BLAKE3 of the file, hexadecimal.
    blake3: String,
    made: T,
}

/// Everything found wrong; never empty.
type Errors = FirstErrors;

/// Every value, or every error.
fn all<T, E: Into<Errors>>(
    results: impl IntoIterator<Item = Result<T, E>>,
) -> Result<Vec<T>, Errors> {
    let mut values = Vec::new();
    let mut errors = Errors::default();
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(found) => append(&mut errors, found),
        }
    }
    errors.none().map(|()| values)
}

/// Adds errors behind others.
fn append(errors: &mut Errors, found: impl Into<Errors>) {
    let found = found.into();
    errors.extend(found.iter().cloned());
    errors.count(found.more());
}

/// The bytes of these files: all that [`Step::Read`] tells of.
pub fn bytes_of(files: &[PathBuf]) -> u64 {
    files.iter().filter_map(|path| std::fs::metadata(path).ok()).map(|found| found.len()).sum()
}

/// What every file of an import is converted with.
struct Context<'a> {
    layout: &'a Layout,
    study: &'a Study,
    mapping: &'a Mapping,
    software: &'a str,
    /// The text of `study.toml`, of which each session keeps a copy.
    study_toml: Vec<u8>,
    study_blake3: String,
    /// Where the study lies.
    files: &'a dyn Files,
    /// Is told each step.
    progress: &'a (dyn Fn(Step) + Sync),
}

impl Context<'_> {
    /// These columns, of matrices as the mapping says that they lie.
    fn take<'t>(&self, columns: Vec<&'t ColumnRef>, budget: &'t Budget) -> Take<'t> {
        Take { turned: self.mapping.file.turned, ..Take::of(columns, budget) }
    }

    /// Reads every file and converts it, side by side as far as they fit into memory together.
    ///
    /// # Errors
    /// Everything found wrong; more in all of them than is read; a recording that is there twice.
    fn convert<T: Send>(
        &self,
        files: &[PathBuf],
        take: &Take,
        convert: impl Fn(&mut Recording) -> Result<T, Errors> + Sync,
    ) -> Result<Vec<Converted<T>>, Errors> {
        let one = |path: &PathBuf| {
            let mut recording =
                Recording::read(path, &self.mapping.file, self.mapping.name.as_ref(), take)?;
            let made = convert(&mut recording)?;
            (self.progress)(Step::Read(bytes_of(std::slice::from_ref(path))));
            Ok::<_, Errors>(Converted { path: recording.path, blake3: recording.blake3, made })
        };
        let mut found = Vec::new();
        for group in self.groups(files) {
            found.extend(group.par_iter().map(one).collect::<Vec<_>>());
            // Before more is read than can be kept.
            take.budget.held(files)?;
        }
        let converted = all(found)?;
        once::given_once(&converted)?;
        Ok(converted)
    }

    /// The files in groups whose contents have at most [`MOST_FILE`] bytes together. What a packed
    /// file unpacks to may be as much on its own.
    fn groups<'f>(&self, files: &'f [PathBuf]) -> Vec<&'f [PathBuf]> {
        let is_packed =
            |path: &Path| self.mapping.file.format_of(path).is_ok_and(Format::is_packed);
        let bytes = |path: &PathBuf| match is_packed(path) {
            true => MOST_FILE,
            false => std::fs::metadata(path).map_or(0, |found| found.len()),
        };
        let mut groups = Vec::new();
        let mut from = 0;
        let mut together = 0;
        for (i, path) in files.iter().enumerate() {
            let bytes = bytes(path).min(MOST_FILE);
            // A group has one file at least, however large that is.
            if i > from && together + bytes > MOST_FILE {
                groups.push(&files[from..i]);
                (from, together) = (i, 0);
            }
            together += bytes;
        }
        groups.push(&files[from..]);
        groups
    }

    /// What a file made from a recording says of itself. The recording's name is left out: it may
    /// hold a person's.
    fn footer(&self, source_blake3: String, computed: &[String]) -> BTreeMap<String, String> {
        let mut footer = BTreeMap::from([
            ("study_blake3".to_owned(), self.study_blake3.clone()),
            ("device".to_owned(), self.study.device.name.clone()),
            ("software".to_owned(), self.software.to_owned()),
            (SOURCE.to_owned(), source_blake3),
            ("mapping_blake3".to_owned(), self.mapping.blake3.clone()),
        ]);
        if !computed.is_empty() {
            footer.insert("made_by_import".to_owned(), computed.join("; "));
        }
        footer
    }

    /// The report on a file as far as all kinds share it, of whose rows so many were kept; `used`
    /// are the columns that were taken.
    ///
    /// # Errors
    /// A column that the mapping drops by name but the file does not have, or one that it also
    /// uses.
    fn file_report(
        &self,
        recording: &Recording,
        rows: &Rows,
        kept: usize,
        used: &[usize],
    ) -> Result<FileReport, StoreError> {
        let names: Vec<_> =
            (0..recording.table.columns.len()).map(|i| recording.table.full_name(i)).collect();
        let unused = names.iter().enumerate().filter(|(i, _)| !used.contains(i));
        let mut dropped_by_name = self.mapping.drop.keys();
        if let Some(name) =
            dropped_by_name.find(|name| !unused.clone().any(|(_, of)| *of == name.as_str()))
        {
            let what = "the column is named in [drop], but it is missing or used";
            return Err(recording.error(what, "remove it from [drop]").column(name));
        }
        let why = |name: &str| {
            self.mapping.drop.get(name).cloned().unwrap_or_else(|| "not mapped".to_owned())
        };
        let limit = self.mapping.file.rows.unwrap_or(rows.read);
        let dropped = [
            (rows.missing, MISSING.to_owned()),
            (rows.past_limit, format!("after the first {limit} (rows = {limit})")),
            (
                rows.joined.len(),
                "they have the time of a row before them (equal in [time])".to_owned(),
            ),
        ];
        let bad = rows.bad.values().map(|why| (1, format!("{why} (bad_lines)")));
        Ok(FileReport {
            file: printable(&recording.path.to_string_lossy()).into_owned(),
            rows_read: rows.read,
            rows_kept: kept,
            rows_dropped: dropped
                .into_iter()
                .chain(bad)
                .filter(|d| d.0 > 0)
                .map(|(rows, why)| RowsDropped { rows, why })
                .collect(),
            columns_dropped: unused
                .map(|(_, name)| ColumnDropped {
                    column: printable(&shown(name)).into_owned(),
                    why: why(name),
                })
                .collect(),
            converted: Vec::new(),
            computed: Vec::new(),
            null: Vec::new(),
            made: Vec::new(),
            lost: recording.lost(rows, 0..usize::MAX),
            care: Vec::new(),
            told: recording.table.told.clone(),
            there: None,
        })
    }
}
