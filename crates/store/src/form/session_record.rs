//! The record of a session, as JSON.

use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::json::from_json;
use crate::{Files, Layout, StoreError};
use serde::Deserialize;
use std::path::Path;
use zwidth_study::{RECORD_VERSION, SessionRecord};

/// What can be done about a session that is not whole.
pub(crate) const RESTORE: &str =
    "restore the session's files from a copy, or import the session again";

/// Largest session record that is read, bytes: a hundred thousand trials.
pub(crate) const MOST_RECORD: u64 = 1 << 25;

/// The records of a study's sessions whose paths are `wanted`, in the order of their names; neither
/// logs nor trials are read.
///
/// # Errors
/// The first of them that cannot be read.
pub fn read_records(
    files: &dyn Files,
    layout: &Layout,
    wanted: &dyn Fn(&Path) -> bool,
) -> Result<Vec<SessionRecord>, StoreError> {
    let mut paths = files_below(files, &layout.sessions())?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "json") && wanted(path));
    paths.iter().map(|path| record_from(path, &text(files, path, MOST_RECORD)?)).collect()
}

/// The version alone: read first, because another version may have other fields.
#[derive(Deserialize)]
struct Version {
    schema_version: u32,
}

pub(crate) fn record_from(path: &Path, text: &str) -> Result<SessionRecord, StoreError> {
    let Version { schema_version } = from_json(text).map_err(|e| no_record(path, &e))?;
    if schema_version != RECORD_VERSION {
        let remedy = format!(
            "this software reads version {RECORD_VERSION}; use the one that wrote the session"
        );
        let what = format!("schema version {schema_version} is unknown");
        return Err(StoreError::new(path, what, remedy));
    }
    serde_json::from_str(text).map_err(|e| no_record(path, &e))
}

fn no_record(path: &Path, error: &serde_json::Error) -> StoreError {
    StoreError::new(path, format!("not a session record: {error}"), RESTORE)
}
