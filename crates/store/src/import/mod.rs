//! Import: recordings of other rigs, through a mapping file, into a study (`docs/import.md`).
//!
//! All files are read, converted and checked before anything is written, and what is written is
//! written whole or not at all. What a recording lacks is a null column; what was computed (a
//! derivative, a time from a rate) was asked for in the mapping, and the files made say so.
//!
//! A file goes through: `recording` (its format becomes a `table` of text and number columns) →
//! `trials`, `sweeps` or `likert` (labels resolved, units converted) → `batch` (bytes, written).

mod batch;
mod check;
mod check_samples;
mod check_sweeps;
mod convert;
mod csv;
mod identity;
mod jsonl;
mod label;
mod likert;
mod mapping;
mod mat;
mod parquet;
mod plan;
#[cfg(test)]
mod real;
mod recording;
mod report;
mod shape;
mod sweeps;
mod table;
mod text;
mod trials;
mod unit;
mod wide;
#[cfg(test)]
mod world;

pub use mapping::Mapping;
pub use report::{ColumnDropped, FileReport, Report, RowsDropped};

use crate::study::MOST_STUDY;
use crate::{Files, Layout, StoreError, hex_blake3, read_regular};
use batch::Batch;
use mapping::Content;
use recording::{Recording, Rows};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_study::Study;

/// Imports `files` into the study at `layout`, as `mapping` says.
///
/// `study` is the content of the study's `study.toml`; `utc` is the time in RFC 3339, for the event
/// log; `software` is the program with its version, for the session records; `disk` does the writing.
///
/// # Errors
/// Everything found wrong, each with file, column and row; then nothing was written. When writing
/// fails, what this import had written is removed again, and the error says so.
pub fn import(
    layout: &Layout,
    study: &Study,
    mapping: &Mapping,
    files: &[PathBuf],
    utc: &str,
    software: &str,
    disk: &dyn Files,
) -> Result<Report, Vec<StoreError>> {
    let read = read_regular(&layout.study_toml(), MOST_STUDY);
    let read = read.map_err(|e| Errors::from(StoreError::io(&layout.study_toml(), "read", &e)));
    let made = read.and_then(|study_toml| {
        let study_blake3 = hex_blake3(&study_toml);
        let context = Context { layout, study, mapping, software, study_toml, study_blake3 };
        let batch = batch(&context, files)?;
        batch.write(disk, layout, utc)?;
        Ok(batch)
    });
    made.map(|batch| batch.report(layout)).map_err(|errors| errors.0)
}

fn batch(context: &Context, files: &[PathBuf]) -> Result<Batch, Errors> {
    distinct(files)?;
    match &context.mapping.content {
        Content::Trials { who, time, columns } => trials::trials(context, (who, time, columns), files),
        Content::Sweeps { labels, form } => sweeps::sweeps(context, (labels, form), files),
        Content::Likert { who, questions } => likert::likert(context, (who, questions), files),
    }
}

fn distinct(files: &[PathBuf]) -> Result<(), Errors> {
    if files.is_empty() {
        return Err(StoreError::new(Path::new("."), "no file is given", "name the files to import").into());
    }
    let mut seen = BTreeSet::new();
    let once = |f: &PathBuf| match seen.insert(f.clone()) {
        true => Ok(()),
        false => Err(StoreError::new(f, "the file is given twice", "give every file once")),
    };
    all(files.iter().map(once)).map(|_| ())
}

/// Everything found wrong; never empty.
#[derive(Debug)]
struct Errors(Vec<StoreError>);

impl From<StoreError> for Errors {
    fn from(error: StoreError) -> Self {
        Self(vec![error])
    }
}

/// Every value, or every error.
fn all<T, E: Into<Errors>>(results: impl IntoIterator<Item = Result<T, E>>) -> Result<Vec<T>, Errors> {
    let (mut values, mut errors) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(value) => values.push(value),
            Err(found) => errors.extend(found.into().0),
        }
    }
    if errors.is_empty() { Ok(values) } else { Err(Errors(errors)) }
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
}

impl Context<'_> {
    fn read(&self, path: &Path) -> Result<Recording, StoreError> {
        Recording::read(path, &self.mapping.file, self.mapping.name.as_ref())
    }

    /// What a file made from a recording says of itself. The recording's name is left out: it may hold
    /// a person's.
    fn footer(&self, source_blake3: String, computed: &[String]) -> BTreeMap<String, String> {
        let mut footer = BTreeMap::from([
            ("study_blake3".to_owned(), self.study_blake3.clone()),
            ("device".to_owned(), self.study.device.name.clone()),
            ("software".to_owned(), self.software.to_owned()),
            ("source_blake3".to_owned(), source_blake3),
            ("mapping_blake3".to_owned(), self.mapping.blake3.clone()),
        ]);
        if !computed.is_empty() {
            footer.insert("made_by_import".to_owned(), computed.join("; "));
        }
        footer
    }

    /// The report on a file as far as all kinds share it; `used` are the columns that were taken.
    ///
    /// # Errors
    /// A column that the mapping drops by name but the file does not have, or one that it also uses.
    fn file_report(
        &self,
        recording: &Recording,
        rows: &Rows,
        used: &[usize],
    ) -> Result<FileReport, StoreError> {
        let names: Vec<String> =
            (0..recording.table.columns.len()).map(|i| recording.table.name(i)).collect();
        let stray = |name: &&String| !names.iter().enumerate().any(|(i, n)| n == *name && !used.contains(&i));
        if let Some(name) = self.mapping.drop.keys().find(stray) {
            let what = "the column is named in [drop], but it is missing or used";
            return Err(recording.error(what, "remove it from [drop]").column(name));
        }
        let unused = names.iter().enumerate().filter(|(i, _)| !used.contains(i));
        let why =
            |name: &String| self.mapping.drop.get(name).cloned().unwrap_or_else(|| "not mapped".to_owned());
        let limit = self.mapping.file.rows.unwrap_or(rows.read);
        let dropped = [
            (rows.missing, "a mapped cell is empty or NaN (missing = \"drop\")".to_owned()),
            (rows.past_limit, format!("after the first {limit} (rows = {limit})")),
        ];
        Ok(FileReport {
            file: recording.path.display().to_string(),
            rows_read: rows.read,
            rows_kept: rows.kept.len(),
            rows_dropped: dropped
                .into_iter()
                .filter(|d| d.0 > 0)
                .map(|(rows, why)| RowsDropped { rows, why })
                .collect(),
            columns_dropped: unused
                .map(|(_, name)| ColumnDropped { column: name.clone(), why: why(name) })
                .collect(),
            converted: Vec::new(),
            computed: Vec::new(),
            null: Vec::new(),
            made: Vec::new(),
        })
    }
}
