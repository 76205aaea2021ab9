//! A disk that fails on purpose, for tests.

use crate::{Files, RealFiles};
use std::cell::Cell;
use std::io;
use std::path::Path;
use std::sync::Mutex;

/// Fails at the n-th operation, after doing half of it where it is a write, and from then on.
pub(crate) struct Faulty {
    left: Mutex<Cell<u32>>,
    /// Whether nothing can be removed either.
    stuck: bool,
}

impl Faulty {
    pub(crate) fn at(n: u32) -> Self {
        Self { left: Mutex::new(Cell::new(n)), stuck: false }
    }

    /// Nothing can be removed from it either.
    pub(crate) fn stuck_at(n: u32) -> Self {
        Self { stuck: true, ..Self::at(n) }
    }

    fn step(&self) -> io::Result<()> {
        let cell = self.left.lock().unwrap();
        if cell.get() == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        cell.set(cell.get() - 1);
        Ok(())
    }
}

impl Files for Faulty {
    fn create_folders(&self, path: &Path) -> io::Result<()> {
        self.step()?;
        RealFiles.create_folders(path)
    }
    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        if let Err(e) = self.step() {
            RealFiles.write_synced(path, &bytes[..bytes.len() / 2])?;
            return Err(e);
        }
        RealFiles.write_synced(path, bytes)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.step()?;
        RealFiles.rename(from, to)
    }
    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.step()?;
        RealFiles.sync_folder(path)
    }
    fn append_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.step()?;
        RealFiles.append_synced(path, bytes)
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        if self.stuck {
            return Err(io::Error::from(io::ErrorKind::ReadOnlyFilesystem));
        }
        RealFiles.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove_folder(path)
    }
}
