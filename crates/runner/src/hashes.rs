//! Hashes of files, each computed once a run.

use std::collections::{BTreeMap, HashMap};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use zwidth_store::Seen;

/// In place of the hash of an output that would be made again: nobody knows its content yet.
pub(crate) const TO_BE_MADE: &str = "to be made";

/// Hashes of files, each computed once a run; a missing file's is empty.
#[derive(Default)]
pub(crate) struct Hashes {
    /// By their paths as they are written.
    all: Mutex<HashMap<OsString, String>>,
    seen: Arc<Seen>,
}

impl Hashes {
    /// Begins with the hashes of files that were read already.
    pub(crate) fn new(known: &[(PathBuf, String)]) -> Self {
        Self::seen(known, Arc::default())
    }

    /// The same, where it is known what other files were when they were last read.
    pub(crate) fn seen(known: &[(PathBuf, String)], seen: Arc<Seen>) -> Self {
        let known = known.iter().map(|(path, hash)| (path.clone().into(), hash.clone()));
        Self { all: Mutex::new(known.collect()), seen }
    }

    pub(crate) fn of(&self, root: &Path, paths: &[PathBuf]) -> BTreeMap<String, String> {
        paths.iter().map(|p| (show_path(root, p), self.one(p))).collect()
    }

    fn one(&self, path: &Path) -> String {
        if let Some(hash) = self.lock().get(path.as_os_str()) {
            return hash.clone();
        }
        // Not locked meanwhile: others go on, and at worst two threads find the same hash.
        let hash = self.seen.blake3(path).unwrap_or_default();
        self.lock().insert(path.into(), hash.clone());
        hash
    }

    pub(crate) fn set(&self, path: &Path, hash: String) {
        self.lock().insert(path.into(), hash);
    }

    /// The hash of what was just written.
    pub(crate) fn written(&self, path: &Path, hash: String) {
        self.seen.written(path, &hash);
        self.set(path, hash);
    }

    /// In a dry run an output that would be made has no known content, so that the jobs that need
    /// it are listed too.
    pub(crate) fn forget(&self, paths: &[PathBuf]) {
        for path in paths {
            self.set(path, TO_BE_MADE.to_owned());
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<OsString, String>> {
        self.all.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// A path as records have it: relative to the root, with `/`.
pub(crate) fn show_path(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/")
}
