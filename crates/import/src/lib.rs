//! Import: recordings of other rigs, through a mapping file, into a study (`docs/import.md`).
//!
//! All files are read, converted and checked before anything is written, and everything is written
//! whole or not at all. A quantity that a recording lacks is a null column. Computed quantities (a
//! derivative, a time from a rate) are requested in the mapping, and the resulting files say so.
//!
//! A file goes through: `recording` (its format becomes a `table` of text and number columns) → `join` (columns of
//! files beside it) → `trials`, `sweeps`, `likert` or `psychometric` (labels resolved, units converted) → `batch` (bytes, written).

mod added;
mod axes;
mod batch;
mod beside;
mod blocks;
mod c3d;
mod check;
mod check_beside;
mod check_likert;
mod check_psychometric;
mod check_samples;
mod check_sweeps;
mod clock;
mod context;
mod convert;
mod counter;
mod csv;
mod declared;
mod errors;
mod even;
mod exclusions;
mod feather;
mod format;
mod given;
mod growing;
mod guess;
mod guess_answers;
mod guess_apart;
mod guess_log;
mod guess_names;
mod guess_read;
mod guess_task;
mod guess_words;
mod hdf5;
mod identity;
mod join;
mod jsonl;
mod judgement;
#[cfg(test)]
mod killed;
mod known_trials;
mod label;
mod labelled;
mod labview;
mod late;
mod likert;
mod limits;
mod long;
mod mapping;
mod mat;
mod matlab;
mod mcap;
mod mend;
#[cfg(test)]
mod mistakes;
mod named_trial;
mod npy;
mod once;
mod opensim;
mod order;
mod outline;
mod outside;
mod parquet;
mod people;
mod plain;
mod plan;
mod presented;
mod psychometric;
#[cfg(any(test, feature = "testing"))]
pub mod readers;
#[cfg(test)]
mod real;
mod recorded;
mod recording;
mod report;
mod shape;
#[cfg(test)]
mod skipped;
mod spelling;
mod stream;
mod sweeps;
mod table;
mod tdms;
mod text;
mod trajectory;
mod trials;
mod unit;
mod workbook;
#[cfg(test)]
mod world;
mod xdf;
mod xml;
mod zero;
mod zip;

pub use beside::{Beside, Wanted, beside};
pub use context::{Step, bytes_of};
pub use guess::{Guess, guess};
pub use known_trials::{KnownTrial, Labels, SessionTrials, StudyTrials};
pub use late::{LateAnswer, LateAnswers};
pub use mapping::Mapping;
pub use named_trial::{Claims, NamedTrial, TrialMeant};
pub use outside::outside_values;
pub use report::{ColumnDropped, FileReport, Report, RowsDropped, Unplanned};
pub use trajectory::{Trajectory, texts, trajectory};

use context::Context;
use errors::all;
use mapping::Content;
use order::in_order;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_store::commit::settle;
use zwidth_store::{
    Files, FirstErrors, Layout, MOST_STUDY, StoreError, StudyData, against_plan, hex_blake3,
};
use zwidth_study::Study;

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
/// `study` is the content of the study's `study.toml`; `disk` holds the study; `progress` is called
/// at each step, from any thread. The caller holds the study's lock. Remains of an earlier import
/// that was killed are removed first.
///
/// # Errors
/// Everything found wrong, each with file, column and row; then nothing was written. If writing
/// fails, the files that this import has written are removed again, and the error says so.
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
        Content::Trials(from) => trials::trials(&context, from, files)?,
        Content::Sweeps(sweep) => sweeps::sweeps(&context, sweep, files)?,
        Content::Likert(questionnaire) => likert::likert(&context, questionnaire, files)?,
        Content::Psychometric(task) => psychometric::psychometric(&context, task, files)?,
        // They add to existing logs.
        Content::Exclusions(form) => return exclusions::import(&context, form, files, by.utc),
        // They add to the participants' file.
        Content::People(form) => return people::import(&context, form, files),
    };
    batch.write(disk, layout, by.utc, &|all| progress(Step::Written { all }))?;
    // The import is done: if the study cannot be read now, its next reader reports why.
    let data = StudyData::load_from(disk, layout);
    let findings = data.map(|data| against_plan(&data)).unwrap_or_default();
    let new: BTreeSet<&Path> = batch.outputs.iter().map(|(path, _)| path.as_path()).collect();
    let findings = findings.into_iter().filter(|finding| new.contains(finding.path.as_path()));
    let unplanned = findings.map(|finding| Unplanned {
        file: layout.shown(&finding.path).display().to_string(),
        what: format!("{}; {}", finding.what, finding.remedy),
    });
    let unplanned = unplanned.collect();
    Ok(batch.report(layout, unplanned))
}
