//! The trials of a study, or of one session, by their footers.

use crate::footer::{TrialFooter, read_footer_from, read_footer_seen};
use crate::study::parquet_below;
use crate::{Files, Layout, Seen, StoreError, TrialEntry};
use rayon::prelude::*;
use std::path::Path;

/// The trials below a folder of the tree: `files` lists them, and reads those that were not `seen`
/// before.
pub(crate) fn read_trials(
    (files, seen): (&dyn Files, Option<&Seen>),
    layout: &Layout,
    folder: &Path,
) -> Vec<Result<TrialEntry, StoreError>> {
    let found = match parquet_below(files, folder) {
        Ok(found) => found,
        Err(error) => return vec![Err(error)],
    };
    found
        .into_par_iter()
        .map(|path| {
            let footer = match seen {
                Some(seen) => read_footer_seen(seen, &path),
                None => read_footer_from(files, &path),
            };
            let TrialFooter { meta, file, form, signals, rows, blake3 } = footer?;
            let expected = layout.trial(&meta.participant, &meta.session, meta.trial);
            if expected != path {
                let what =
                    format!("the file is trial {} by its footer, but not by its name", meta.trial);
                let remedy =
                    format!("it belongs at {}; a trial must not exist twice", expected.display());
                return Err(StoreError::new(&path, what, remedy));
            }
            Ok(TrialEntry {
                path,
                meta,
                file,
                form,
                signals,
                rows,
                blake3,
                superseded_by: None,
                excluded: None,
                sealed: None,
            })
        })
        .collect()
}
