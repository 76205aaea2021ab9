//! What the system says about a file; it reveals a change without reading the file.

use serde::{Deserialize, Serialize};
use std::fs::Metadata;
use std::path::Path;
use std::time::{Duration, SystemTime};

/// A file whose state changed so little ago may change again and have the same time: systems count
/// it in steps, of two seconds at most.
pub(crate) const SETTLED: Duration = Duration::from_secs(2);

/// What the system says about a file or a folder: it differs after every change of the content, or
/// of the names in the folder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Stamp {
    pub(crate) length: u64,
    /// Seconds and nanoseconds of its last write.
    pub(crate) modified: (i64, i64),
    /// Likewise of its last change of any kind.
    pub(crate) changed: (i64, i64),
    /// Its number on its disk.
    pub(crate) number: u64,
}

impl Stamp {
    #[cfg(unix)]
    fn of(metadata: &Metadata) -> Option<Self> {
        use std::os::unix::fs::MetadataExt as _;
        let kind = metadata.file_type();
        // The time of the last change too: a program can set that of the last write back.
        (kind.is_file() || kind.is_dir()).then(|| Self {
            length: metadata.len(),
            modified: (metadata.mtime(), metadata.mtime_nsec()),
            changed: (metadata.ctime(), metadata.ctime_nsec()),
            number: metadata.ino(),
        })
    }

    #[cfg(not(unix))]
    fn of(_: &Metadata) -> Option<Self> {
        None
    }

    /// The stamp of the file at `path`; a link is no file.
    pub(crate) fn at(path: &Path) -> Option<Self> {
        let metadata = path.symlink_metadata().ok()?;
        Self::of(&metadata).filter(|_| metadata.is_file())
    }

    /// The stamp of the file or folder at `path`; a link is neither.
    pub(crate) fn of_any(path: &Path) -> Option<Self> {
        Self::of(&path.symlink_metadata().ok()?)
    }

    #[cfg(any(test, feature = "testing"))]
    /// The stamp of something on a disk that counts its changes, in the process that is `life`.
    pub(crate) fn counted(number: u64, life: i64, changes: i64, length: u64) -> Self {
        Self { length, modified: (life, 0), changed: (changes, 0), number }
    }

    /// The same, if it would reveal any change from now on.
    pub(crate) fn settled(path: &Path) -> Option<Self> {
        Self::at(path).filter(|stamp| stamp.is_settled(SystemTime::now()))
    }

    /// Whether any change after `now` shows.
    pub(crate) fn is_settled(&self, now: SystemTime) -> bool {
        let since = now
            .checked_sub(SETTLED)
            .and_then(|now| now.duration_since(SystemTime::UNIX_EPOCH).ok());
        since.is_some_and(|since| {
            let since = (
                i64::try_from(since.as_secs()).unwrap_or(i64::MAX),
                i64::from(since.subsec_nanos()),
            );
            self.changed < since
        })
    }
}
