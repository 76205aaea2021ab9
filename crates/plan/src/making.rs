//! What the jobs of every stage share: where results lie, reading and writing tables, keeping apart
//! what went well and what did not.

use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_runner::{JobError, Made, Making};
use zwidth_store::Layout;
use zwidth_tables::{Table, TableError};

/// A job's result: tables as Parquet files, in the order of its outputs.
pub(crate) fn write_tables(
    tables: &[Table],
    making: &Making,
    problems: Vec<String>,
) -> Result<Made, JobError> {
    let files = tables.iter().zip(making.outputs);
    let outputs = files
        .map(|(table, path)| table.to_parquet(making.from, path))
        .collect::<Result<_, TableError>>()?;
    Ok(Made { outputs, problems, ..Made::default() })
}

/// Tables that stages made.
pub(crate) fn read_tables(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    files.iter().map(|file| Table::from_parquet(file)).collect()
}

/// Tables of one form that are read at a time to be joined.
const JOINED_AT_ONCE: usize = 256;

/// The same as fewer tables, to be joined: a large study has thousands of one form. Titles and notes
/// are left out.
pub(crate) fn read_parts(files: &[PathBuf]) -> Result<Vec<Table>, TableError> {
    let part = |files: &[PathBuf]| Table::concat("part", "", read_tables(files)?);
    let parts: Result<Vec<_>, TableError> = files.par_chunks(JOINED_AT_ONCE).map(part).collect();
    Ok(parts?.into_iter().flatten().collect())
}

/// The good results, and the bad ones in words.
pub(crate) fn split<T, E: ToString>(results: Vec<Result<T, E>>) -> (Vec<T>, Vec<String>) {
    let mut problems = Vec::new();
    let good = results
        .into_iter()
        .filter_map(|r| r.map_err(|e| problems.push(e.to_string())).ok())
        .collect();
    (good, problems)
}

/// A file under `derived/<study>`.
pub(crate) fn derived(layout: &Layout, name: impl AsRef<Path>) -> PathBuf {
    layout.derived().join(name)
}
