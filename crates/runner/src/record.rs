//! The record of what was made from what.

use crate::Job;
use crate::hashes::Hashes;
use crate::provenance::origin;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{Files, StoreError, replace};

/// What is remembered of a job that succeeded. Paths are relative to the root, hashes are BLAKE3 of contents.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// The job's stage.
    pub stage: String,
    /// The stage's algorithm version.
    pub version: u32,
    /// The job's parameters, as canonical text.
    pub parameters: String,
    /// What it read: path → hash; empty for a file that was missing.
    pub inputs: BTreeMap<String, String>,
    /// What it made: path → hash.
    pub outputs: BTreeMap<String, String>,
    /// What had to be left out.
    pub problems: Vec<String>,
    /// The word that each of its outputs carries ([`crate::ORIGIN`]).
    pub origin: String,
}

impl Record {
    /// The record of a job as it would be written now, before its outputs are made.
    pub(crate) fn now(job: &Job, root: &Path, hashes: &Hashes) -> Self {
        Self {
            stage: job.stage.to_owned(),
            version: job.version,
            parameters: job.parameters.clone(),
            inputs: hashes.of(root, &job.inputs),
            ..Self::default()
        }
    }

    /// The same with its origin.
    pub(crate) fn with_origin(mut self, name: &str) -> Self {
        self.origin = origin(name, &self);
        self
    }
}

/// The records of a study's jobs, by job name.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Records(pub(crate) BTreeMap<String, Record>);

impl Records {
    /// Reads the records. A missing file, or one that cannot be understood, gives none: then
    /// everything is made again, which is always right.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        serde_json::from_str(&text).unwrap_or_default()
    }

    /// Writes the records, as a whole.
    pub fn write(&self, files: &dyn Files, path: &Path) -> Result<(), StoreError> {
        let text = serde_json::to_vec(self).map_err(|e| {
            StoreError::new(path, e.to_string(), "this is a defect of zwidth; please report it")
        })?;
        replace(files, path, &text)
    }

    /// The record of the job of that name.
    pub fn get(&self, name: &str) -> Option<&Record> {
        self.0.get(name)
    }

    /// Every job's name and record, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Record)> {
        self.0.iter().map(|(name, record)| (name.as_str(), record))
    }

    /// The job that made the file at `path`, relative to the root.
    pub fn maker(&self, path: &str) -> Option<(&str, &Record)> {
        self.iter().find(|(_, record)| record.outputs.contains_key(path))
    }
}
