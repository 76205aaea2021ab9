//! The study's folder, held open while a session is recorded into it.
//!
//! If the folder is moved or removed meanwhile, the next check notices it. The folder is never made
//! anew: later files would then lie apart from all earlier recordings.

use crate::AcquireError;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_store::{Append, Entry, Files, Held, Stamp, StoreError};

/// The disk, of which nothing is touched once the study's folder is not where it was.
#[derive(Clone)]
pub(crate) struct Within<'a> {
    files: &'a dyn Files,
    path: PathBuf,
    /// Which folder was at the path at the start.
    folder: Arc<dyn Held>,
}

impl<'a> Within<'a> {
    /// Opens the study's folder.
    ///
    /// # Errors
    /// It is not there, or cannot be read.
    pub(crate) fn open(files: &'a dyn Files, path: &Path) -> Result<Self, StoreError> {
        let folder =
            files.hold(path).map_err(|e| StoreError::io(path, "open the study's folder", &e))?;
        Ok(Self { files, path: path.to_owned(), folder: folder.into() })
    }

    /// Checks that the folder is still at its path.
    ///
    /// # Errors
    /// It was moved or removed: what became of it, and what to do.
    pub(crate) fn check(&self) -> Result<(), AcquireError> {
        if self.folder.is_there() {
            return Ok(());
        }
        let went = match self.folder.now() {
            Some(now) => format!("what was recorded is now in {}", now.display()),
            None => "what was recorded went with it".to_owned(),
        };
        let what = format!(
            "{}: the study's folder was moved or removed while the session ran, and nothing is written to another; {went}, the samples of a trial in progress in its folder journal",
            self.path.display()
        );
        Err(AcquireError::refused(what, "put it back, and give the same command"))
    }

    /// The disk, if the study's folder is where it was.
    fn checked(&self) -> io::Result<&'a dyn Files> {
        check_place(&*self.folder).map(|()| self.files)
    }

    /// The same for a folder that is created: the study's own is never made here, not even if it
    /// went since that look.
    fn checked_for_folder(&self, path: &Path) -> io::Result<&'a dyn Files> {
        let files = self.checked()?;
        if self.path.starts_with(path) {
            return Err(io::ErrorKind::NotFound.into());
        }
        Ok(files)
    }
}

/// An error for a write; the runner's says more ([`Within::check`]).
fn check_place(folder: &dyn Held) -> io::Result<()> {
    if folder.is_there() {
        return Ok(());
    }
    Err(io::Error::new(io::ErrorKind::NotFound, "the study's folder is not where it was"))
}

impl Files for Within<'_> {
    fn kind(&self, path: &Path) -> Option<Entry> {
        self.files.kind(path)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        self.files.list(folder)
    }

    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        self.files.read(path, most)
    }

    fn stamp(&self, path: &Path) -> Option<Stamp> {
        self.files.stamp(path)
    }

    fn hold(&self, folder: &Path) -> io::Result<Box<dyn Held>> {
        self.files.hold(folder)
    }

    fn make_private(&self, path: &Path) -> io::Result<()> {
        self.checked()?.make_private(path)
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        self.checked_for_folder(path)?.create_folder(path)
    }

    fn create_private_folder(&self, path: &Path) -> io::Result<()> {
        self.checked_for_folder(path)?.create_private_folder(path)
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.checked()?.write_synced(path, bytes)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        self.checked()?.rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        self.checked()?.sync_folder(path)
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let file = self.checked()?.open_append(path)?;
        Ok(Box::new(WithinFile { file, folder: Arc::clone(&self.folder) }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.checked()?.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        self.checked()?.remove_folder(path)
    }
}

/// A file in the study's folder.
struct WithinFile {
    file: Box<dyn Append>,
    folder: Arc<dyn Held>,
}

impl Append for WithinFile {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        // First the bytes: the file went with its folder, and keeps them there.
        self.file.append_synced(bytes)?;
        check_place(&*self.folder)
    }

    fn take_back(&mut self) -> io::Result<()> {
        self.file.take_back()
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_store::{RealFiles, write_new};

    /// `raw/s` in a folder of its own, held.
    fn held() -> (tempfile::TempDir, PathBuf, Within<'static>) {
        let root = tempfile::tempdir().unwrap();
        let path = root.path().join("raw/s");
        fs::create_dir_all(&path).unwrap();
        let files = Within::open(&RealFiles, &path).unwrap();
        (root, path, files)
    }

    #[test]
    fn a_folder_that_was_moved_is_not_made_anew_and_is_named_where_it_is() {
        let (root, path, files) = held();
        write_new(&files, &path.join("a/first"), b"1").unwrap();
        let moved = root.path().join("elsewhere");
        fs::rename(&path, &moved).unwrap();
        assert!(write_new(&files, &path.join("b/second"), b"2").is_err());
        assert!(
            files.create_folder(&path).is_err() && files.open_append(&path.join("log")).is_err()
        );
        assert!(!path.exists());
        let words = files.check().unwrap_err().to_string();
        assert!(words.contains("moved or removed"), "{words}");
        if cfg!(target_os = "linux") {
            assert!(words.contains(&moved.display().to_string()), "{words}");
        }
        fs::rename(&moved, &path).unwrap();
        files.check().unwrap();
        write_new(&files, &path.join("b/second"), b"2").unwrap();
    }

    #[test]
    fn another_folder_in_its_place_is_not_it() {
        let (root, path, files) = held();
        fs::rename(&path, root.path().join("old")).unwrap();
        fs::create_dir(&path).unwrap();
        assert!(files.check().is_err());
        assert!(write_new(&files, &path.join("x"), b"").is_err() && !path.join("x").exists());
        fs::remove_dir_all(root.path().join("old")).unwrap();
        let words = files.check().unwrap_err().to_string();
        assert!(!words.contains("deleted") && words.contains("went with it"), "{words}");
    }

    #[test]
    fn what_is_appended_to_an_open_file_is_kept_where_the_folder_went() {
        let (root, path, files) = held();
        let mut file = files.open_append(&path.join("log")).unwrap();
        file.append_synced(b"one ").unwrap();
        fs::rename(&path, root.path().join("old")).unwrap();
        assert!(file.append_synced(b"two").is_err());
        assert_eq!(fs::read(root.path().join("old/log")).unwrap(), b"one two");
    }
}
