//! The trials of a study, or of one session, by their footers.

use crate::read::{TrialFooter, read_footer_from};
use crate::study::parquet_below;
use crate::{Files, Layout, StoreError, TrialEntry};
use rayon::prelude::*;
use std::path::Path;

/// Every trial of the study.
pub(crate) fn read_trials(
    files: &dyn Files,
    layout: &Layout,
) -> Vec<Result<TrialEntry, StoreError>> {
    read_trials_below(files, layout, &layout.trials())
}

/// The trials below a folder of the tree.
pub(crate) fn read_trials_below(
    files: &dyn Files,
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
            let TrialFooter { meta, file, form, signals, rows, blake3 } =
                read_footer_from(files, &path)?;
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
