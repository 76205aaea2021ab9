//! A job: what it needs, what it makes, and the function that makes it.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;

/// Where a result comes from: stage, version, parameters and the hash of each input, for the footer
/// of a table or the metadata of a figure.
pub type Provenance = BTreeMap<String, String>;

/// What a job made.
#[derive(Debug, Default)]
pub struct Made {
    /// The content of each output, in the order of [`Job::outputs`].
    pub outputs: Vec<Vec<u8>>,
    /// What had to be left out, and why: remembered, and reported at every run.
    pub problems: Vec<String>,
}

/// The function that makes a job's outputs. It reads the job's inputs and nothing else.
pub type Make<'a> = Box<dyn Fn(&Provenance) -> Result<Made, Box<dyn Error + Send + Sync>> + Send + Sync + 'a>;

/// One unit of work.
pub struct Job<'a> {
    /// The stage it belongs to: `metrics`.
    pub stage: &'static str,
    /// Its name within the study, unique: `metrics P01_S01`.
    pub name: String,
    /// The stage's algorithm version.
    pub version: u32,
    /// Everything but files that the outputs depend on, as canonical text.
    pub parameters: String,
    /// Files it reads.
    pub inputs: Vec<PathBuf>,
    /// Files it makes.
    pub outputs: Vec<PathBuf>,
    /// Whether it is made even when some of its inputs could not be: they are then missing files.
    pub tolerant: bool,
    /// Makes them.
    pub make: Make<'a>,
}
