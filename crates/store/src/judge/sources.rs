//! Which recordings of other programs a study's files were imported from, so that each counts once.
//! A file that cannot be read is a finding of `verify`, not an error here.

use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::footer::{TrialFooter, read_footer_from};
use crate::form::opened::ParquetFile;
use crate::form::session_record::{MOST_RECORD, record_from};
use crate::{Files, Layout, SOURCE, StoreError};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{ParticipantId, SessionId, SessionRecord};

/// A trial of a study.
pub type TrialName = (ParticipantId, SessionId, u32);

/// The recordings that trials were imported from, by their hash, with the trials.
///
/// # Errors
/// A folder that cannot be listed.
pub fn trial_sources(
    files: &dyn Files,
    layout: &Layout,
) -> Result<BTreeMap<String, BTreeSet<TrialName>>, StoreError> {
    let paths = files_below(files, &layout.trials())?;
    let trials = paths.par_iter().filter_map(|path| {
        let TrialFooter { meta, file, .. } = read_footer_from(files, path).ok()?;
        Some((file.get(SOURCE)?.clone(), (meta.participant, meta.session, meta.trial)))
    });
    let mut sources: BTreeMap<String, BTreeSet<TrialName>> = BTreeMap::new();
    for (source, name) in trials.collect::<Vec<_>>() {
        sources.entry(source).or_default().insert(name);
    }
    Ok(sources)
}

/// The recordings from which sweeps were imported, by their hash, with what they became in words.
///
/// # Errors
/// A folder that cannot be listed.
pub fn sweep_sources(
    files: &dyn Files,
    layout: &Layout,
) -> Result<BTreeMap<String, String>, StoreError> {
    let paths = files_below(files, &layout.sweeps())?;
    let sweeps = paths.par_iter().filter_map(|path| {
        let footer = ParquetFile::open(files, path).ok()?.footer;
        let words = format!("sweep {} of {}", footer.get("sweep")?, footer.get("actuator")?);
        Some((footer.get(SOURCE)?.clone(), words))
    });
    Ok(sweeps.collect())
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
