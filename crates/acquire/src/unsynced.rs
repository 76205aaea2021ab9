//! A disk without syncs, for whole simulated studies, which can be made again.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;
use zwidth_store::{Append, Content, Files, RealFiles, Stamp, append_to};

/// The real disk without syncs. A kill costs no more than on [`RealFiles`]; a power cut may cost
/// everything.
#[derive(Debug, Clone, Copy, Default)]
pub struct Unsynced;

/// A file at its end, and how long it was when it was opened.
struct Open {
    file: File,
    length: u64,
}

impl Append for Open {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)
    }

    fn take_back(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)
    }
}

impl Files for Unsynced {
    fn stamp(&self, path: &Path) -> Option<Stamp> {
        RealFiles.stamp(path)
    }

    fn open(&self, path: &Path, most: u64) -> io::Result<Content> {
        RealFiles.open(path, most)
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.create_folder(path)
    }

    fn create_private_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.create_private_folder(path)
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
        let file = append_to(path)?;
        let length = file.metadata()?.len();
        Ok(Box::new(Open { file, length }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove_folder(path)
    }
}
