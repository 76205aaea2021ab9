//! Whole files or none: written beside the final name, synced, renamed, the folder synced.
//!
//! [`Files`] is the seam at which tests inject faults (a write, sync or rename that fails, a power cut that drops
//! what was not synced).

use crate::StoreError;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The file operations that writing needs.
pub trait Files: Sync {
    /// Creates one folder; none is made where there is one.
    fn create_folder(&self, path: &Path) -> io::Result<()>;
    /// Creates `path`, writes `bytes`, and syncs them to the disk.
    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()>;
    /// Gives the file `from` the name `to`, replacing what stood there.
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()>;
    /// Syncs a folder, so that the names in it survive a power cut.
    fn sync_folder(&self, path: &Path) -> io::Result<()>;
    /// Opens `path` at its end, created if missing.
    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>>;
    /// Removes a file.
    fn remove(&self, path: &Path) -> io::Result<()>;
    /// Removes an empty folder.
    fn remove_folder(&self, path: &Path) -> io::Result<()>;
}

/// A file held open at its end.
pub trait Append: Send {
    /// Appends `bytes`, and syncs them and the file's length to the disk.
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()>;
}

/// The real disk.
#[derive(Debug, Clone, Copy, Default)]
pub struct RealFiles;

impl Files for RealFiles {
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        match fs::create_dir(path) {
            Err(_) if path.is_dir() => Ok(()),
            made => made,
        }
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        let mut file = File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        File::open(path)?.sync_all()
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let file = File::options().append(true).create(true).open(path)?;
        Ok(Box::new(file))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        fs::remove_dir(path)
    }
}

impl Append for File {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.write_all(bytes)?;
        self.sync_data()
    }
}

/// Creates every missing folder of `path`, each with its name synced: a file in a folder whose own name is lost is
/// lost too.
pub(crate) fn create_folders(files: &dyn Files, path: &Path) -> io::Result<()> {
    let missing: Vec<&Path> = path.ancestors().take_while(|p| !p.exists()).collect();
    missing.into_iter().rev().filter(|p| *p != Path::new("")).try_for_each(|folder| {
        files.create_folder(folder)?;
        files.sync_folder(folder_of(folder))
    })
}

/// Syncs what a file holds, and its name: a process that was killed may have left either unsynced.
pub(crate) fn sync_file(files: &dyn Files, path: &Path) -> io::Result<()> {
    files.open_append(path)?.append_synced(&[])?;
    files.sync_folder(folder_of(path))
}

/// The folder a path lies in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| *p != Path::new("")).unwrap_or_else(|| Path::new("."))
}

/// Writes a new file as a whole; refuses when `path` exists, because finished files never change.
pub fn write_new(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    if path.exists() {
        let exists = io::Error::from(io::ErrorKind::AlreadyExists);
        return Err(StoreError::io(path, "write", &exists));
    }
    replace(files, path, bytes)
}

/// Writes a file as a whole; whatever stood at `path` stays until the new one is safe on the disk.
pub fn replace(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let folder = folder_of(path);
    create_folders(files, folder).map_err(|e| StoreError::io(folder, "create the folder", &e))?;
    let beside = temporary(path);
    let placed = files
        .write_synced(&beside, bytes)
        .and_then(|()| files.rename(&beside, path))
        .and_then(|()| files.sync_folder(folder));
    placed.map_err(|e| {
        // The first error is the one to report; a temporary file that cannot be removed is swept up by `verify`.
        let _ = files.remove(&beside);
        StoreError::io(path, "write", &e)
    })
}

/// The name beside `path` under which it is written: hidden, so that readers of the folder pass it by.
fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faulty::Faulty;

    #[test]
    fn a_fault_at_any_step_leaves_the_old_file_or_the_new_one_whole() {
        for fault in 0..4 {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a/x.bin");
            replace(&RealFiles, &path, b"old content").unwrap();
            let error = replace(&Faulty::at(fault), &path, b"the new content").unwrap_err();
            assert!(error.remedy.contains("free some space"), "{error}");
            let found = fs::read(&path).unwrap();
            assert!(found == b"old content" || found == b"the new content", "fault {fault}");
            assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1, "litter after {fault}");
        }
    }

    #[test]
    fn a_fault_at_any_step_of_a_new_file_leaves_no_half_file() {
        for fault in 0..5 {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("a/x.bin");
            assert!(write_new(&Faulty::at(fault), &path, b"content").is_err());
            assert!(!path.exists(), "fault {fault}");
        }
    }

    #[test]
    fn a_finished_file_is_never_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.bin");
        write_new(&RealFiles, &path, b"first").unwrap();
        let error = write_new(&RealFiles, &path, b"second").unwrap_err();
        assert!(error.remedy.contains("never change"), "{error}");
        assert_eq!(fs::read(&path).unwrap(), b"first");
    }
}
