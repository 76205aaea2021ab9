//! The record of what was made from what.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_store::{Files, StoreError, replace};

/// What is remembered of a job that succeeded. Paths are relative to the root.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Record {
    pub(crate) stage: String,
    pub(crate) version: u32,
    pub(crate) parameters: String,
    pub(crate) inputs: BTreeMap<String, String>,
    pub(crate) outputs: BTreeMap<String, String>,
    pub(crate) problems: Vec<String>,
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
}
