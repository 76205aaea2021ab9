//! Hashes of files, each computed once per run.

use std::borrow::Borrow;
use std::collections::{BTreeMap, HashMap};
use std::ffi::OsStr;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use zwidth_store::Seen;

/// In place of the hash of an output that would be made again: nobody knows its content yet.
pub(crate) const TO_BE_MADE: &str = "to be made";

/// A path that is looked up by its bytes: paths of one plan are written alike, and bytes are compared
/// sooner than names.
#[derive(Debug)]
struct Written(Arc<Path>);

impl Borrow<OsStr> for Written {
    fn borrow(&self) -> &OsStr {
        self.0.as_os_str()
    }
}

impl Hash for Written {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.as_os_str().hash(state);
    }
}

impl PartialEq for Written {
    fn eq(&self, other: &Self) -> bool {
        self.0.as_os_str() == other.0.as_os_str()
    }
}

impl Eq for Written {}

/// BLAKE3 of files that were read already. A copy shares it.
#[derive(Debug, Clone, Default)]
pub struct HashesRead(Arc<HashMap<Written, blake3::Hash>>);

/// Of each file its path and its hash, hexadecimal.
impl<P: Into<Arc<Path>>, H: AsRef<str>> FromIterator<(P, H)> for HashesRead {
    fn from_iter<I: IntoIterator<Item = (P, H)>>(files: I) -> Self {
        let mut hashes = HashMap::new();
        for (path, hash) in files {
            if let Ok(hash) = blake3::Hash::from_hex(hash.as_ref()) {
                hashes.insert(Written(path.into()), hash);
            }
        }
        // Kept for the whole run, with one entry per recording of the study.
        hashes.shrink_to_fit();
        Self(Arc::new(hashes))
    }
}

/// The content of a file, by its hash: a third of the memory of a hash as text. Of a file without one,
/// what stands in its place: nothing if it is missing, or [`TO_BE_MADE`].
type FileState = Result<blake3::Hash, &'static str>;

/// Hashes of files, each computed once a run; a missing file's is empty.
#[derive(Default)]
pub(crate) struct Hashes {
    read_before: HashesRead,
    /// Those that came since, by the files' paths as they are written.
    since: Mutex<HashMap<Box<OsStr>, FileState>>,
    seen: Arc<Seen>,
}

impl Hashes {
    /// Begins with the hashes of files that were read already, and with what other files were when they
    /// were last read.
    pub(crate) fn seen(read_before: &HashesRead, seen: Arc<Seen>) -> Self {
        Self { read_before: read_before.clone(), since: Mutex::default(), seen }
    }

    pub(crate) fn of(&self, root: &Path, paths: &[impl AsRef<Path>]) -> BTreeMap<String, String> {
        paths.iter().map(AsRef::as_ref).map(|p| (show_path(root, p), self.hash(p))).collect()
    }

    fn hash(&self, path: &Path) -> String {
        // `since` first: the file may have been written after it was read.
        let since = self.lock().get(path.as_os_str()).copied();
        let state = since.or_else(|| self.read_before.0.get(path.as_os_str()).copied().map(Ok));
        if let Some(state) = state {
            return state.map_or_else(str::to_owned, |hash| hash.to_hex().to_string());
        }
        // Not locked meanwhile: others go on, and at worst two threads find the same hash.
        let hash = self.seen.blake3(path).unwrap_or_default();
        self.set(path, &hash);
        hash
    }

    pub(crate) fn set(&self, path: &Path, hash: &str) {
        let state = blake3::Hash::from_hex(hash)
            .map_err(|_| if hash == TO_BE_MADE { TO_BE_MADE } else { "" });
        self.lock().insert(path.as_os_str().into(), state);
    }

    /// The hash of what was just written.
    pub(crate) fn written(&self, path: &Path, hash: &str) {
        self.seen.written(path, hash);
        self.set(path, hash);
    }

    /// In a dry run an output that would be made has no known content, so that the jobs that need
    /// it are listed too.
    pub(crate) fn forget(&self, paths: &[PathBuf]) {
        for path in paths {
            self.set(path, TO_BE_MADE);
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<Box<OsStr>, FileState>> {
        // Poisoned is as good: no entry is ever half written.
        self.since.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

/// A path as records have it: relative to the root, with `/`.
pub(crate) fn show_path(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/")
}
