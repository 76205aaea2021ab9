//! The plan of a study: which jobs its data give. Each file binds one stage, a pure function, to
//! the files that it reads and makes.
//!
//! A stage is declared in one place: its name and version ([`zwidth_runner::Stage`]), the files of
//! each of its jobs, and what else its function gets, as one serialisable struct. There is no
//! domain logic here: what a stage does with what it reads is the stage's.

#![allow(clippy::ptr_arg)] // a job's function takes what the job holds, not a view of it

mod average;
mod characterise;
mod conditions;
mod design;
mod figures;
mod freemotion;
mod identify;
mod likert;
mod likert_figures;
mod metrics;
mod replay;
mod replay_figures;
mod report;
mod summary;
mod tables;
mod trials;

pub use figures::chosen_in_vain;
pub use report::built_in;
pub use summary::file as summary_file;
pub use tables::printed as printed_tables;

use std::path::{Path, PathBuf};
use zwidth_runner::{Job, JobError, Made, Making};
use zwidth_store::{Findings, Layout, StudyData};
use zwidth_tables::{Table, TableError};

/// Every job of a study, of which this was found.
pub fn jobs(data: &StudyData, found: &Findings) -> Vec<Job> {
    let figures = figures::all(data);
    let mut jobs = Vec::new();
    jobs.extend(characterise::jobs(data));
    jobs.extend(metrics::jobs(data));
    jobs.extend(average::jobs(data));
    jobs.extend(freemotion::jobs(data));
    jobs.extend(replay::jobs(data));
    jobs.extend(identify::jobs(data));
    jobs.extend(replay::course_jobs(data));
    jobs.extend(likert::jobs(data));
    jobs.extend(report::jobs(data));
    jobs.extend(tables::jobs(data));
    let summary = summary::job(data, found, &figures);
    jobs.extend(figures.into_iter().map(|figure| figure.job));
    jobs.push(summary);
    jobs
}

/// The stages, in the order in which a person thinks of them.
pub const STAGES: [&str; 11] = [
    "characterise",
    "metrics",
    "average",
    "freemotion",
    "replay",
    "identify",
    "likert",
    "figures",
    "report",
    "tables",
    "summary",
];

/// A job's result: tables as Parquet files, in the order of its outputs.
fn made(tables: &[Table], making: &Making, problems: Vec<String>) -> Result<Made, JobError> {
    let bytes = |(t, path): (&Table, &PathBuf)| t.to_parquet(making.from, path);
    let outputs =
        tables.iter().zip(making.outputs).map(bytes).collect::<Result<_, TableError>>()?;
    Ok(Made { outputs, problems, ..Made::default() })
}

/// Tables that stages made.
fn read_tables(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    files.iter().map(|file| Table::from_parquet(file)).collect()
}

/// The good results, and the bad ones in words.
fn split<T, E: ToString>(results: Vec<Result<T, E>>) -> (Vec<T>, Vec<String>) {
    let mut problems = Vec::new();
    let good = results
        .into_iter()
        .filter_map(|r| r.map_err(|e| problems.push(e.to_string())).ok())
        .collect();
    (good, problems)
}

/// A file under `derived/<study>`.
fn derived(layout: &Layout, name: impl AsRef<Path>) -> PathBuf {
    layout.derived().join(name)
}
