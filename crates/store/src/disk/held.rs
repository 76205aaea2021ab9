//! A folder held open: it is recognised wherever it is moved, and no other folder is mistaken for
//! it.

#[cfg(unix)]
use std::fs::File;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// A folder that [`crate::Files::hold`] holds.
pub trait Held: Send + Sync {
    /// Whether its path still leads to it.
    fn is_there(&self) -> bool;
    /// Where it is now, if it is elsewhere and that is known.
    fn now(&self) -> Option<PathBuf>;
}

/// A folder of the real disk, and which one it was when it was opened.
#[derive(Debug)]
struct RealFolder {
    path: PathBuf,
    /// While it is open nothing else gets its identity.
    #[cfg(unix)]
    handle: File,
    identity: Identity,
}

/// Distinguishes a folder from any other that stands in its place.
#[cfg(unix)]
type Identity = (u64, u64);
/// Distinguishes a folder from most others that stand in its place: the time when it was made.
#[cfg(not(unix))]
type Identity = Option<std::time::SystemTime>;

#[cfg(unix)]
fn identity(metadata: &Metadata) -> Identity {
    use std::os::unix::fs::MetadataExt as _;
    (metadata.dev(), metadata.ino())
}

#[cfg(not(unix))]
fn identity(metadata: &Metadata) -> Identity {
    metadata.created().ok()
}

/// Holds a folder of the real disk.
pub(crate) fn hold(path: &Path) -> io::Result<Box<dyn Held>> {
    #[cfg(unix)]
    let handle = File::open(path)?;
    #[cfg(unix)]
    let metadata = handle.metadata()?;
    #[cfg(not(unix))]
    let metadata = fs::metadata(path)?;
    if !metadata.is_dir() {
        return Err(io::ErrorKind::NotADirectory.into());
    }
    Ok(Box::new(RealFolder {
        path: path.to_owned(),
        #[cfg(unix)]
        handle,
        identity: identity(&metadata),
    }))
}

impl Held for RealFolder {
    fn is_there(&self) -> bool {
        leads_to(&self.path, self.identity)
    }

    /// As far as the system tells: Linux does.
    #[cfg(unix)]
    fn now(&self) -> Option<PathBuf> {
        use std::os::fd::AsRawFd as _;
        let now = fs::read_link(format!("/proc/self/fd/{}", self.handle.as_raw_fd())).ok()?;
        // For a folder that was removed Linux gives a path that leads nowhere.
        leads_to(&now, self.identity).then_some(now)
    }

    #[cfg(not(unix))]
    fn now(&self) -> Option<PathBuf> {
        None
    }
}

fn leads_to(path: &Path, folder: Identity) -> bool {
    fs::metadata(path).is_ok_and(|metadata| metadata.is_dir() && identity(&metadata) == folder)
}
