//! A disk that is not waited for: for whole simulated studies, which can be made again.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;
use zwidth_store::{Append, Content, Files, RealFiles, append_to};

/// The real disk without syncs. A kill costs no more than on [`RealFiles`]; a power cut may cost
/// everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unsynced;

/// A file at its end.
struct Open(File);

impl Append for Open {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }
}

impl Files for Unsynced {
    fn open(&self, path: &Path, most: u64) -> io::Result<Content> {
        RealFiles.open(path, most)
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.create_folder(path)
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        // What stands there may be a link, and is removed and not written to, as on the real disk.
        match fs::remove_file(path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => {}
        }
        File::options().write(true).create_new(true).open(path)?.write_all(bytes)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        RealFiles.rename(from, to)
    }

    fn sync_folder(&self, _path: &Path) -> io::Result<()> {
        Ok(())
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        Ok(Box::new(Open(append_to(path)?)))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove_folder(path)
    }
}
