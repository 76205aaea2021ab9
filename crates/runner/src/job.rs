//! A job: what it needs, what it makes, and the function that makes it.

use crate::Provenance;
use std::error::Error;
use std::path::PathBuf;

/// What a job made.
#[derive(Debug, Default)]
pub struct Made {
    /// The content of each output, in the order of [`Job::outputs`].
    pub outputs: Vec<Vec<u8>>,
    /// What had to be left out, and why: remembered, and reported at every run.
    pub problems: Vec<String>,
    /// What is in the outputs and is to be read with care, and why: remembered and reported
    /// likewise.
    pub care: Vec<String>,
}

/// The function that makes a job's outputs. It reads the job's inputs and nothing else.
pub type Make<'a> =
    Box<dyn Fn(&Provenance) -> Result<Made, Box<dyn Error + Send + Sync>> + Send + Sync + 'a>;

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

impl Job<'_> {
    /// Whether a person who says `name` means this job: its stage, its name, or the file stem of an
    /// output.
    pub fn is_called(&self, name: &str) -> bool {
        let has_stem = |o: &PathBuf| o.file_stem().is_some_and(|stem| stem == name);
        self.stage == name || self.name == name || self.outputs.iter().any(has_stem)
    }
}
