//! The trials of a study, or of one session, by their footers.

use crate::disk::walk::parquet_below;
use crate::form::footer::{TrialFooter, read_footer_from, read_footer_seen};
use crate::form::trial::START;
use crate::memo::Memo;
use crate::{Files, Layout, SOURCE, Said, Seen, StoreError, TrialEntry};
use rayon::prelude::*;
use std::cell::RefCell;
use std::path::Path;
use std::sync::Arc;

/// The trials below a folder of the tree: `files` lists them, and reads those that were not `seen`
/// before.
pub(crate) fn read_trials(
    files: &dyn Files,
    seen: Option<&Seen>,
    layout: &Layout,
    folder: &Path,
) -> Vec<Result<TrialEntry, StoreError>> {
    let paths = match parquet_below(files, folder) {
        Ok(paths) => paths,
        Err(error) => return vec![Err(error)],
    };
    paths
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
                path: path.into(),
                meta,
                said: shared(Said { file, form, signals }),
                rows,
                blake3,
                superseded_by: None,
                excluded: None,
                is_unmet: false,
                sealed: None,
            })
        })
        .collect()
}

/// What a file says, without when its trial began and which file it was imported from: the rest is the
/// same in all trials of a session, and each thread keeps it once for those that it reads one after the
/// other.
fn shared(mut contents: Said) -> Arc<Said> {
    thread_local! {
        static LAST: RefCell<Memo<Arc<Said>, Arc<Said>>> = const { RefCell::new(Memo::new()) };
    }
    // These two differ from trial to trial, and would leave nothing to share.
    contents.file.retain(|key, _| key != START && key != SOURCE);
    LAST.with_borrow_mut(|last| {
        last.get(|kept| **kept == contents).unwrap_or_else(|| {
            let contents = Arc::new(contents);
            last.keep(contents.clone(), contents.clone());
            contents
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RealFiles;
    use crate::form::read::tests::{form, sample_trial};

    #[test]
    fn trials_of_a_session_share_what_is_the_same_in_all_of_them() {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "demo".parse().unwrap());
        for number in 1..=3 {
            let mut trial = sample_trial();
            trial.meta.trial = number;
            trial.file.insert(START.to_owned(), format!("2026-01-01T00:00:0{number}Z"));
            trial.file.insert(SOURCE.to_owned(), crate::hex_blake3(&[number as u8]));
            trial.file.insert("device".to_owned(), if number < 3 { "a" } else { "b" }.to_owned());
            let path = layout.trial(&trial.meta.participant, &trial.meta.session, number);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, crate::trial_bytes(&trial, &form(), &path).unwrap()).unwrap();
        }
        // One after the other, as one thread of many would.
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let read = || read_trials(&RealFiles, None, &layout, &layout.trials());
        let trials: Vec<TrialEntry> = one.install(read).into_iter().map(Result::unwrap).collect();
        let [first, second, third] = &trials[..] else { panic!("{trials:?}") };
        assert!(Arc::ptr_eq(&first.said, &second.said) && !Arc::ptr_eq(&first.said, &third.said));
        assert_eq!((&*first.said.file["device"], &*third.said.file["device"]), ("a", "b"));
        assert_eq!(first.meta.mode.as_str().as_ptr(), second.meta.mode.as_str().as_ptr());
        assert_eq!((first.meta.trial, third.meta.trial), (1, 3));
    }
}
