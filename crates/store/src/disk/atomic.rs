//! Whole files, or no file: written beside the final name, synced, renamed, the folder synced.
//!
//! [`Files`] is the seam at which tests inject faults (a write, sync or rename that fails, a power
//! cut that drops what was not synced).

use crate::StoreError;
use crate::disk::content::Content;
use crate::disk::held::{Held, hold};
use crate::disk::regular::{open_content, open_or_create, read_regular};
use crate::disk::stamp::Stamp;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// A kind of thing at a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// A regular file.
    File,
    /// A folder.
    Folder,
    /// A link, wherever it leads.
    Link,
    /// A pipe, a socket, a device.
    Special,
}

/// The file operations that recording and checking need. Files are on the real disk, unless a layer
/// says otherwise.
pub trait Files: Sync {
    /// What lies at `path`; nothing if nothing does, or nothing that can be looked at.
    fn kind(&self, path: &Path) -> Option<Entry> {
        path.symlink_metadata().ok().map(|metadata| entry(metadata.file_type()))
    }
    /// The names in a folder, sorted, each with what it is.
    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        let mut entries = Vec::new();
        for item in fs::read_dir(folder)? {
            let item = item?;
            match item.file_type() {
                Ok(kind) => entries.push((item.path(), entry(kind))),
                Err(e) if e.kind() == io::ErrorKind::NotFound => {} // gone since
                Err(e) => return Err(e),
            }
        }
        // All of one folder, so that bytes have the order of names.
        entries.sort_by(|a, b| a.0.as_os_str().cmp(b.0.as_os_str()));
        Ok(entries)
    }
    /// Reads a regular file of at most `most` bytes whole.
    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        read_regular(path, most)
    }
    /// The content of a regular file of at most `most` bytes, to be read part by part.
    fn open(&self, path: &Path, most: u64) -> io::Result<Content> {
        self.read(path, most).map(Content::of)
    }
    /// What tells whether the file or folder at `path` changes; nothing where there is none, or
    /// nothing is told. So says a layer that does not know.
    fn stamp(&self, _path: &Path) -> Option<Stamp> {
        None
    }
    /// Holds a folder open, so that it is known again wherever it goes.
    fn hold(&self, folder: &Path) -> io::Result<Box<dyn Held>> {
        hold(folder)
    }
    /// Keeps a file or a folder for this user alone: 0600 and 0700, whatever the umask says.
    /// Systems without such modes have it as its folder has it.
    fn make_private(&self, path: &Path) -> io::Result<()> {
        set_private_mode(path)
    }
    /// Creates one folder, unless it is there already.
    fn create_folder(&self, path: &Path) -> io::Result<()>;
    /// Creates one folder for this user alone ([`Files::make_private`]). One that is there already
    /// keeps its mode: it may be the user's home.
    fn create_private_folder(&self, path: &Path) -> io::Result<()> {
        if self.kind(path).is_some() {
            return Ok(());
        }
        self.create_folder(path)?;
        self.make_private(path)
    }
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
    /// Takes back what was appended since the file was opened: it has the length that it had then,
    /// also on the disk.
    fn take_back(&mut self) -> io::Result<()>;
}

/// The real disk.
#[derive(Debug, Clone, Copy, Default)]
pub struct RealFiles;

impl Files for RealFiles {
    fn stamp(&self, path: &Path) -> Option<Stamp> {
        Stamp::of_any(path)
    }

    fn open(&self, path: &Path, most: u64) -> io::Result<Content> {
        open_content(path, most)
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        match fs::create_dir(path) {
            // Another process may have made it in between.
            Err(_) if path.is_dir() => Ok(()),
            result => result,
        }
    }

    fn create_private_folder(&self, path: &Path) -> io::Result<()> {
        match create_private(path) {
            Err(_) if path.is_dir() => Ok(()),
            // A umask may have taken even its owner's rights.
            Ok(()) => set_private_mode(path),
            failed => failed,
        }
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        // What an earlier write of this name left is removed and not written to: it may be a link.
        match fs::remove_file(path) {
            Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
            _ => {}
        }
        let mut file = File::options().write(true).create_new(true).open(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::rename(from, to)
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        // Windows opens no folder as a file (error 5). Its file system keeps a journal of names itself.
        if cfg!(windows) {
            return Ok(());
        }
        File::open(path)?.sync_all()
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let file = append_to(path)?;
        let length = file.metadata()?.len();
        Ok(Box::new(Opened { file, length }))
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        fs::remove_file(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        fs::remove_dir(path)
    }
}

/// A file of the real disk at its end, and how long it was when it was opened.
struct Opened {
    file: File,
    length: u64,
}

impl Append for Opened {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(bytes)?;
        // Syncs the length too; the times, which it may leave out, nobody reads after a power cut.
        self.file.sync_data()
    }

    fn take_back(&mut self) -> io::Result<()> {
        self.file.set_len(self.length)?;
        self.file.sync_all()
    }
}

#[cfg(unix)]
fn set_private_mode(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    let mode = match entry(path.symlink_metadata()?.file_type()) {
        Entry::File => 0o600,
        Entry::Folder => 0o700,
        // What it leads to is somebody else's.
        Entry::Link | Entry::Special => return Err(io::ErrorKind::InvalidInput.into()),
    };
    fs::set_permissions(path, fs::Permissions::from_mode(mode))
}

#[cfg(not(unix))]
fn set_private_mode(_path: &Path) -> io::Result<()> {
    Ok(())
}

/// Creates a folder that nobody else can enter, not even before its mode is set.
#[cfg(unix)]
fn create_private(path: &Path) -> io::Result<()> {
    use std::os::unix::fs::DirBuilderExt as _;
    fs::DirBuilder::new().mode(0o700).create(path)
}

#[cfg(not(unix))]
fn create_private(path: &Path) -> io::Result<()> {
    fs::create_dir(path)
}

/// Opens a regular file at its end, or creates it. A link is not followed.
///
/// # Errors
/// What the system says; anything but a regular file at `path`.
pub fn append_to(path: &Path) -> io::Result<File> {
    open_or_create(File::options().append(true), path)
}

fn entry(kind: fs::FileType) -> Entry {
    match (kind.is_file(), kind.is_dir(), kind.is_symlink()) {
        (true, _, _) => Entry::File,
        (_, true, _) => Entry::Folder,
        (_, _, true) => Entry::Link,
        _ => Entry::Special,
    }
}

/// Creates every missing folder of `path`, each with its name synced: a file in a folder whose own
/// name is lost is lost too.
pub(crate) fn create_folders(files: &dyn Files, path: &Path) -> io::Result<()> {
    for folder in missing_folders(files, path) {
        files.create_folder(folder)?;
        files.sync_folder(folder_of(folder))?;
    }
    Ok(())
}

/// The folders of `path` that are not there, from the outermost on.
fn missing_folders<'p>(files: &dyn Files, path: &'p Path) -> Vec<&'p Path> {
    let mut missing: Vec<&Path> = path
        .ancestors()
        .take_while(|folder| *folder != Path::new("") && files.kind(folder).is_none())
        .collect();
    missing.reverse();
    missing
}

/// Syncs what a file holds, and its name: a process that was killed may have left either unsynced.
pub(crate) fn sync_file(files: &dyn Files, path: &Path) -> io::Result<()> {
    files.open_append(path)?.append_synced(&[])?;
    files.sync_folder(folder_of(path))
}

/// Syncs the names of a file or folder, and of its parents below `top`, as far as they exist: a
/// process that was killed may have left one unsynced, and a power cut would take everything in it.
///
/// # Errors
/// A folder that cannot be synced; a folder that may not be read is skipped.
pub fn sync_names(files: &dyn Files, path: &Path, top: &Path) -> Result<(), StoreError> {
    let below = path.ancestors().take_while(|p| *p != top && *p != Path::new(""));
    for existing in below.filter(|p| files.kind(p).is_some()) {
        match files.sync_folder(folder_of(existing)) {
            Err(e) if e.kind() != io::ErrorKind::PermissionDenied => {
                return Err(StoreError::io(folder_of(existing), "sync the folder", &e));
            }
            _ => {}
        }
    }
    Ok(())
}

/// The folder a path lies in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| *p != Path::new("")).unwrap_or_else(|| Path::new("."))
}

/// Writes a new file as a whole; refuses when `path` exists, because finished files never change.
pub fn write_new(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    if files.kind(path).is_some() {
        return Err(StoreError::io(path, "write", &io::ErrorKind::AlreadyExists.into()));
    }
    replace(files, path, bytes).map_err(|error| take_away(files, path, error))
}

/// Removes a new file again, of which something could not be written: who is told of the error finds
/// nothing there, or is told that too.
pub(crate) fn take_away(files: &dyn Files, path: &Path, mut error: StoreError) -> StoreError {
    if files.kind(path).is_some() {
        // The first error is the one to report.
        let _ = files.remove(path).and_then(|()| files.sync_folder(folder_of(path)));
        if files.kind(path).is_some() {
            error.what += "; it is there all the same, and whether it stays is not known";
        }
    }
    error
}

/// Writes a file as a whole; whatever stood at `path` stays until the new one is safe on the disk.
pub fn replace(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let folder = folder_of(path);
    create_folders(files, folder).map_err(|e| StoreError::io(folder, "create the folder", &e))?;
    place(files, path, |beside| files.write_synced(beside, bytes))
}

/// Writes a new file as a whole that this user alone can read, in a folder that nobody else can
/// enter, whatever the umask says. Missing folders are made in the same way.
///
/// # Errors
/// A file that already exists; a write that failed; a folder that is another user's or on a disk
/// without modes.
pub fn write_private(files: &dyn Files, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    if files.kind(path).is_some() {
        return Err(StoreError::io(path, "write", &io::ErrorKind::AlreadyExists.into()));
    }
    let folder = folder_of(path);
    for missing in missing_folders(files, folder) {
        files
            .create_private_folder(missing)
            .and_then(|()| files.sync_folder(folder_of(missing)))
            .map_err(|e| StoreError::io(folder, "create the folder", &e))?;
    }
    // A folder that was there already keeps its mode above.
    keep_private(files, folder)?;
    place(files, path, |beside| {
        files.write_synced(beside, bytes)?;
        files.make_private(beside)
    })
    .map_err(|error| take_away(files, path, error))
}

/// Restricts an existing file or folder to this user alone.
///
/// # Errors
/// It is another user's, or on a disk without modes.
pub fn keep_private(files: &dyn Files, path: &Path) -> Result<(), StoreError> {
    files.make_private(path).map_err(|e| StoreError::io(path, "keep from other users", &e))
}

/// Writes beside a path, and gives what was written its name.
pub(crate) fn place(
    files: &dyn Files,
    path: &Path,
    write: impl FnOnce(&Path) -> io::Result<()>,
) -> Result<(), StoreError> {
    let beside = temporary(path);
    let placed = write(&beside)
        // Only now: a name must never lead to content that a power cut can take.
        .and_then(|()| files.rename(&beside, path))
        .and_then(|()| files.sync_folder(folder_of(path)));
    placed.map_err(|e| {
        // The first error is the one to report; a temporary file that cannot be removed is swept up
        // by `verify`.
        let _ = files.remove(&beside);
        StoreError::io(path, "write", &e)
    })
}

/// The name beside `path` under which it is written: hidden, so that readers of the folder pass it
/// by.
pub(crate) fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    // With the process, so that no two of them write the same file.
    path.with_file_name(format!(".{name}.{}.tmp", std::process::id()))
}

/// Whether a file's name is one under which [`replace`] writes, so that the file is what a write
/// that was cut short left.
pub fn is_unfinished(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let inner = name.strip_prefix('.').and_then(|name| name.strip_suffix(".tmp"));
    // From the right: the file's own name may have dots.
    inner.and_then(|inner| inner.rsplit_once('.')).is_some_and(|(name, process)| {
        !name.is_empty() && !process.is_empty() && process.bytes().all(|b| b.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::faulty::Faulty;

    #[test]
    fn a_name_that_a_cut_write_left_is_known_and_no_other_is() {
        assert!(is_unfinished(&temporary(Path::new("a/likert.svg"))));
        for other in [
            "a/.notes.tmp",
            "a/notes.17.tmp",
            ".x.17.tmp.svg",
            "a/..17.tmp",
            ".x.17a.tmp",
            ".x..tmp",
            ".17.tmp",
            "",
        ] {
            assert!(!is_unfinished(Path::new(other)), "{other}");
        }
    }

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
            let files = fs::read_dir(path.parent().unwrap()).unwrap().count();
            assert_eq!(files, 1, "litter after {fault}");
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
