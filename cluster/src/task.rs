//! What an executor is asked, and what it answers.

use serde::{Deserialize, Serialize};
use zwidth_runner::Records;

/// The name of the function that executors have: from a task to its answer.
pub(crate) const FUNCTION: &str = "zwidth_part";

/// Largest gRPC message that scheduler, executors and clients send or take, bytes (512 MiB).
pub(crate) const MOST_MESSAGE: u32 = 1 << 29;

/// Largest task, and largest answer, bytes (256 MiB): what a message can hold with its envelope.
pub(crate) const MOST_PACKED: usize = 1 << 28;

/// The jobs of one part of a study (`P01.S01.spring.hybrid`). Its contents are those of `given`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Task {
    /// The version of the program that asks.
    pub(crate) zwidth: String,
    /// The study.
    pub(crate) study: String,
    /// The part.
    pub(crate) part: String,
    /// The names of the jobs.
    pub(crate) jobs: Vec<String>,
    /// Where the raw files lie: `file:///shared/data`, `s3://bucket/prefix`.
    pub(crate) source: String,
    /// The raw files that the jobs and their plan need.
    pub(crate) raw: Vec<RawFile>,
    /// The paths of derived files that the jobs read, relative to the root.
    pub(crate) given: Vec<String>,
}

/// A raw file that an executor fetches.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct RawFile {
    /// Its path relative to the root: `raw/study/study.toml`.
    pub(crate) path: String,
    /// BLAKE3 of its content, hexadecimal, as the client has it.
    pub(crate) blake3: String,
}

/// What came of a task. Its contents are those of the files.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Answer {
    /// The records of the jobs that were made, and the paths of their files.
    Made { records: Records, files: Vec<String> },
    /// Why nothing was made. Another executor would say the same.
    Refused(String),
}
