//! Hashes of files, each computed once a run.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use zwidth_store::file_blake3;

/// In place of the hash of an output that would be made again: nobody knows its content yet.
pub(crate) const TO_BE_MADE: &str = "to be made";

/// Hashes of files, each computed once a run; a missing file's is empty.
#[derive(Default)]
pub(crate) struct Hashes(Mutex<HashMap<PathBuf, String>>);

impl Hashes {
    /// Begins with the hashes of files that were read already.
    pub(crate) fn new(known: &[(PathBuf, String)]) -> Self {
        Self(Mutex::new(known.iter().cloned().collect()))
    }

    pub(crate) fn of(&self, root: &Path, paths: &[PathBuf]) -> BTreeMap<String, String> {
        paths.iter().map(|p| (show_path(root, p), self.one(p))).collect()
    }

    fn one(&self, path: &Path) -> String {
        if let Some(hash) = self.lock().get(path) {
            return hash.clone();
        }
        // Not locked meanwhile: others go on, and at worst two threads find the same hash.
        let hash = file_blake3(path).unwrap_or_default();
        self.lock().insert(path.to_owned(), hash.clone());
        hash
    }

    pub(crate) fn set(&self, path: &Path, hash: String) {
        self.lock().insert(path.to_owned(), hash);
    }

    /// In a dry run an output that would be made has no known content, so that the jobs that need
    /// it are listed too.
    pub(crate) fn forget(&self, paths: &[PathBuf]) {
        for path in paths {
            self.set(path, TO_BE_MADE.to_owned());
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<PathBuf, String>> {
        self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// A path as records have it: relative to the root, with `/`.
pub(crate) fn show_path(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/")
}
