//! Which recordings of others a study's files were imported from, so that each counts once. What
//! cannot be read is a finding of `verify`, and no error here.

use crate::footer::read_footer_from;
use crate::opened::ParquetFile;
use crate::regular::text;
use crate::sessions::{MOST_RECORD, record_from};
use crate::walk::files_below;
use crate::{Files, Layout, SOURCE, StoreError};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_study::SessionRecord;

/// By the hash of a recording: what was made of it, in words.
pub type Sources = BTreeMap<String, String>;

/// The recordings that trials were imported from.
///
/// # Errors
/// A folder that cannot be listed.
pub fn trial_sources(files: &dyn Files, layout: &Layout) -> Result<Sources, StoreError> {
    sources(files, &layout.trials(), |path| {
        let found = read_footer_from(files, path).ok()?;
        let meta = found.meta;
        let named = format!("{} {} trial {}", meta.participant, meta.session, meta.trial);
        Some((found.file.get(SOURCE)?.clone(), named))
    })
}

/// The recordings that sweeps were imported from.
///
/// # Errors
/// A folder that cannot be listed.
pub fn sweep_sources(files: &dyn Files, layout: &Layout) -> Result<Sources, StoreError> {
    sources(files, &layout.sweeps(), |path| {
        let footer = ParquetFile::open(files, path).ok()?.footer;
        let named = format!("sweep {} of {}", footer.get("sweep")?, footer.get("actuator")?);
        Some((footer.get(SOURCE)?.clone(), named))
    })
}

/// The records of the study's sessions that can be read, in the order of their names.
///
/// # Errors
/// A folder that cannot be listed.
pub fn readable_records(
    files: &dyn Files,
    layout: &Layout,
) -> Result<Vec<SessionRecord>, StoreError> {
    let mut paths = files_below(files, &layout.sessions())?;
    paths.retain(|path| path.extension().is_some_and(|e| e == "json"));
    let records = paths
        .iter()
        .filter_map(|path| record_from(path, &text(files, path, MOST_RECORD).ok()?).ok());
    Ok(records.collect())
}

/// The source of each file below a folder, with the name of the last file that was made of it.
fn sources(
    files: &dyn Files,
    folder: &Path,
    source: impl Fn(&Path) -> Option<(String, String)> + Sync,
) -> Result<Sources, StoreError> {
    let there = files_below(files, folder)?;
    Ok(there.par_iter().filter_map(|path| source(path)).collect())
}
