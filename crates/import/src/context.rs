//! The context in which every file is converted; reads and converts files side by side.

use super::errors::{Errors, all};
use super::format::Format;
use super::limits::{Budget, MOST_FILE, Take};
use super::mapping::Mapping;
use super::recording::{Recording, Rows};
use super::report::{ColumnDropped, FileReport, RowsDropped};
use super::spelling::shown;
use super::table::ColumnRef;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_store::{Files, Layout, SOURCE, StoreError};
use zwidth_study::{Study, printable};

/// A piece of an import's work that is done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// This many bytes of the recordings were read and converted.
    Read(u64),
    /// One of so many files of the study was written. Nothing is read any more.
    Written {
        /// The number of files.
        all: usize,
    },
}

/// The bytes of these files: all that [`Step::Read`] tells of.
pub fn bytes_of(files: &[PathBuf]) -> u64 {
    files.iter().filter_map(|path| std::fs::metadata(path).ok()).map(|file| file.len()).sum()
}

/// Why rows are left out where the mapping drops those without a value.
pub(super) const MISSING: &str = "a mapped cell is empty or NaN (missing = \"drop\")";

/// Why empty rows are left out that are no samples.
pub(super) const EMPTY: &str = "empty";
/// Why empty rows are left out where samples come at a rate.
pub(super) const EMPTY_AT_A_RATE: &str =
    "empty: within a trial no sample stands there, and later samples keep their time";

/// A file, and what was made of it.
pub(super) struct Converted<T> {
    pub(super) path: PathBuf,
    /// BLAKE3 of the file, hexadecimal.
    pub(super) blake3: String,
    pub(super) parsed: T,
}

/// Everything that the conversion of a file needs besides the file.
pub(super) struct Context<'a> {
    pub(super) layout: &'a Layout,
    pub(super) study: &'a Study,
    pub(super) mapping: &'a Mapping,
    pub(super) software: &'a str,
    /// The text of `study.toml`, of which each session keeps a copy.
    pub(super) study_toml: Vec<u8>,
    pub(super) study_blake3: String,
    /// The disk that holds the study.
    pub(super) files: &'a dyn Files,
    /// Is told each step.
    pub(super) progress: &'a (dyn Fn(Step) + Sync),
}

impl Context<'_> {
    /// These columns, of matrices as the mapping says that they lie.
    pub(super) fn take<'t>(&self, columns: Vec<&'t ColumnRef>, budget: &'t Budget) -> Take<'t> {
        Take { turned: self.mapping.file.turned, ..Take::of(columns, budget) }
    }

    /// Reads every file and converts it, side by side as far as they fit into memory together.
    ///
    /// # Errors
    /// Everything found wrong; more in all of them than is read; a recording that is there twice.
    pub(super) fn convert<T: Send>(
        &self,
        files: &[PathBuf],
        take: &Take,
        convert: impl Fn(&mut Recording) -> Result<T, Errors> + Sync,
    ) -> Result<Vec<Converted<T>>, Errors> {
        let mut converted = Vec::new();
        for group in self.groups(files) {
            let results = group.par_iter().map(|path| {
                let mut recording =
                    Recording::read(path, &self.mapping.file, self.mapping.name.as_ref(), take)?;
                let parsed = convert(&mut recording)?;
                (self.progress)(Step::Read(bytes_of(std::slice::from_ref(path))));
                let Recording { path, blake3, .. } = recording;
                Ok::<_, Errors>(Converted { path, blake3, parsed })
            });
            converted.extend(results.collect::<Vec<_>>());
            // Before more is read than can be kept.
            take.budget.held(files)?;
        }
        let converted = all(converted)?;
        // By content: copies and links give one recording under several names.
        given_once(&converted)?;
        Ok(converted)
    }

    /// The files in groups whose contents have at most [`MOST_FILE`] bytes together. What a packed
    /// file unpacks to may be as much on its own.
    fn groups<'f>(&self, files: &'f [PathBuf]) -> Vec<&'f [PathBuf]> {
        let form = &self.mapping.file;
        let mut groups = Vec::new();
        let mut from = 0;
        let mut together = 0;
        for (i, path) in files.iter().enumerate() {
            let bytes = match form.format_of(path).is_ok_and(Format::is_packed) {
                true => MOST_FILE,
                false => std::fs::metadata(path).map_or(0, |file| file.len()),
            };
            // A larger file is refused when it is read: here it only has to fill its group.
            let bytes = bytes.min(MOST_FILE);
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
    pub(super) fn footer(
        &self,
        source_blake3: String,
        computed: &[String],
    ) -> BTreeMap<String, String> {
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
    pub(super) fn file_report(
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
            dropped_by_name.find(|name| !unused.clone().any(|(_, other)| *other == name.as_str()))
        {
            let what = "the column is named in [drop], but it is missing or used";
            return Err(recording.error(what, "remove it from [drop]").column(name));
        }
        let limit = self.mapping.file.rows.unwrap_or(rows.read);
        let dropped = [
            (rows.missing, MISSING.to_owned()),
            (
                rows.outside,
                "they lie outside of the times of what is joined to the recording".to_owned(),
            ),
            (rows.past_limit, format!("after the first {limit} (rows = {limit})")),
            (
                rows.joined.len(),
                "they have the time of a row before them (equal in [time])".to_owned(),
            ),
        ];
        // Each bad row has a reason of its own.
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
                    why: match self.mapping.drop.get(name.as_ref()) {
                        Some(why) => why.clone(),
                        None => "not mapped".to_owned(),
                    },
                })
                .collect(),
            lost: recording.lost(rows, 0..usize::MAX),
            told: recording.table.told.clone(),
            ..FileReport::default()
        })
    }
}

/// Checks that no recording is given twice, under whatever names.
pub(super) fn given_once<T>(files: &[Converted<T>]) -> Result<(), Errors> {
    let mut seen = BTreeMap::new();
    let checked = files.iter().enumerate().map(|(place, file)| {
        let first = *seen.entry(&file.blake3).or_insert(place);
        if first == place {
            return Ok(());
        }
        let first = files[first].path.display();
        let what = format!("the recording is given twice: {first} has the same content");
        Err(StoreError::new(&file.path, what, "give every recording once"))
    });
    all(checked).map(drop)
}
