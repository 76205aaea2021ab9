//! The real disk, failing on purpose, for tests of code that does not read it through [`Files`].
//! [`crate::Memory`] simulates kills and power cuts.

use crate::{Append, Files, RealFiles};
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

/// Fails at the n-th step, after doing half of it where it is a write, and from then on. Nothing is
/// synced.
#[derive(Clone)]
pub(crate) struct Faulty {
    /// Steps that still work; none counts down where nothing fails.
    left: Arc<Mutex<Option<u32>>>,
}

impl Faulty {
    /// A disk that is full from step n on: what is there can still be removed.
    pub(crate) fn at(n: u32) -> Self {
        Self { left: Arc::new(Mutex::new(Some(n))) }
    }

    /// A disk that works, and waits for no sync.
    pub(crate) fn never() -> Self {
        Self { left: Arc::default() }
    }

    fn left(&self) -> MutexGuard<'_, Option<u32>> {
        self.left.lock().unwrap()
    }

    fn step(&self) -> io::Result<()> {
        match &mut *self.left() {
            None => Ok(()),
            Some(0) => Err(io::Error::from(io::ErrorKind::StorageFull)),
            Some(n) => {
                *n -= 1;
                Ok(())
            }
        }
    }

    /// Writes and syncs: two steps, of which the first may do half of its work.
    fn write(
        &self,
        bytes: &[u8],
        mut write: impl FnMut(&[u8]) -> io::Result<()>,
    ) -> io::Result<()> {
        if let Err(e) = self.step() {
            write(&bytes[..bytes.len() / 2])?;
            return Err(e);
        }
        write(bytes)?;
        self.step()
    }
}

impl Files for Faulty {
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        self.step()?;
        RealFiles.create_folder(path)
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.write(bytes, |bytes| fs::write(path, bytes))
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.step()?;
        RealFiles.rename(from, to)
    }

    fn sync_folder(&self, _path: &Path) -> io::Result<()> {
        self.step()
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        self.step()?;
        let file = fs::File::options().append(true).create(true).open(path)?;
        let length = file.metadata()?.len();
        Ok(Box::new(Handle { disk: self.clone(), path: path.to_owned(), length }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        RealFiles.remove_folder(path)
    }
}

struct Handle {
    disk: Faulty,
    path: PathBuf,
    length: u64,
}

impl Append for Handle {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        let write =
            |bytes: &[u8]| fs::File::options().append(true).open(&self.path)?.write_all(bytes);
        self.disk.write(bytes, write)
    }

    fn take_back(&mut self) -> io::Result<()> {
        fs::File::options().append(true).open(&self.path)?.set_len(self.length)
    }
}
