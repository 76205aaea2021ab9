//! The file by which a participant's screen finds the session that is being recorded.
//!
//! It is beside the study's lock while a session is recorded, and only this user can read it: a
//! screen accepts no file that others could have read or written. A file that a killed process left
//! behind leads nowhere, and the next process writes it anew.

use crate::disk::atomic::temporary;
use crate::disk::lock::StudyLock;
use crate::disk::regular::open_regular;
use crate::{Layout, StoreError};
use std::fs::{File, OpenOptions, remove_file};
use std::io::{self, Read as _, Write as _};
use std::path::{Path, PathBuf};

/// Longest text of the file, bytes.
const MOST_TEXT: u64 = 1 << 8;

/// The file, which goes when this is dropped.
#[derive(Debug)]
pub struct PortFile {
    path: PathBuf,
}

impl PortFile {
    /// Writes the file; only the holder of the study's lock may.
    ///
    /// # Errors
    /// Something in its place that cannot be removed; a folder that cannot be written.
    pub fn write(layout: &Layout, _lock: &StudyLock, text: &str) -> Result<Self, StoreError> {
        let path = layout.port();
        write_new(&path, text).map_err(|e| StoreError::io(&path, "write the port", &e))?;
        Ok(Self { path })
    }
}

impl Drop for PortFile {
    fn drop(&mut self) {
        // One that stays leads nowhere.
        let _ = remove_file(&self.path);
    }
}

/// The text of the file; none if there is no such file.
///
/// # Errors
/// Anything else than a short text that this user alone can read is there, or it cannot be read.
pub fn read_port(layout: &Layout) -> Result<Option<String>, StoreError> {
    let path = layout.port();
    let file = match open_regular(&path) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(e) => return Err(StoreError::io(&path, "read the port", &e)),
    };
    if !is_of_this_user_alone(&file).map_err(|e| StoreError::io(&path, "read the port", &e))? {
        let what = "belongs to another user, or others can read or write it, so it may lead to a program of theirs";
        let remedy =
            "remove it, and start the session and the participant's screen as the same user";
        return Err(StoreError::new(&path, what, remedy));
    }
    let mut text = Vec::new();
    file.take(MOST_TEXT)
        .read_to_end(&mut text)
        .map_err(|e| StoreError::io(&path, "read the port", &e))?;
    Ok(Some(String::from_utf8_lossy(&text).into_owned()))
}

/// Whether an open file belongs to whoever runs this program, and nobody else can read or write it.
/// Asked of what was opened: another file may lie at its path by now.
#[cfg(unix)]
fn is_of_this_user_alone(file: &File) -> io::Result<bool> {
    /// The permissions of a file's group and of everybody.
    const OTHERS: u32 = 0o077;
    use std::os::unix::fs::MetadataExt as _;
    let metadata = file.metadata()?;
    Ok(metadata.uid() == rustix::process::geteuid().as_raw() && metadata.mode() & OTHERS == 0)
}

/// Users are not told apart here.
#[cfg(not(unix))]
fn is_of_this_user_alone(_file: &File) -> io::Result<bool> {
    Ok(true)
}

/// Writes a file in place of what an earlier one left, whole: a screen that looks for it meanwhile finds
/// none, or all of it. What lies there is replaced, not opened: it may be a link to another file.
fn write_new(path: &Path, text: &str) -> io::Result<()> {
    let beside = temporary(path);
    match remove_file(&beside) {
        Err(e) if e.kind() != io::ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    // Private from its first moment: a mode that is set later leaves time to open it.
    create(&beside)?.write_all(text.as_bytes())?;
    std::fs::rename(&beside, path)
}

/// A new file that this user alone can read, where users are told apart.
fn create(path: &Path) -> io::Result<File> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::folder_with_study;

    #[test]
    fn the_file_is_there_as_long_as_it_is_held_and_is_no_finding() {
        let (_folder, layout) = folder_with_study();
        assert_eq!(read_port(&layout).unwrap(), None);
        let lock = StudyLock::take(&layout, "me").unwrap();
        let file = PortFile::write(&layout, &lock, "4711 word\n").unwrap();
        assert_eq!(read_port(&layout).unwrap().as_deref(), Some("4711 word\n"));
        assert_eq!(crate::verify(&layout), []);
        drop(file);
        assert_eq!(read_port(&layout).unwrap(), None);
    }

    #[test]
    fn what_a_killed_process_left_is_written_anew() {
        let (_folder, layout) = folder_with_study();
        create(&layout.port()).unwrap().write_all(b"1 another\n").unwrap();
        let lock = StudyLock::take(&layout, "me").unwrap();
        let _file = PortFile::write(&layout, &lock, "2 word\n").unwrap();
        assert_eq!(read_port(&layout).unwrap().as_deref(), Some("2 word\n"));
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_others_can_read_or_write_is_refused() {
        use std::os::unix::fs::PermissionsExt as _;
        let (_folder, layout) = folder_with_study();
        create(&layout.port()).unwrap().write_all(b"1 word\n").unwrap();
        assert_eq!(read_port(&layout).unwrap().as_deref(), Some("1 word\n"));
        for mode in [0o640, 0o604, 0o620, 0o602, 0o666] {
            let permissions = std::fs::Permissions::from_mode(mode);
            std::fs::set_permissions(layout.port(), permissions).unwrap();
            let told = read_port(&layout).unwrap_err().to_string();
            assert!(told.contains("others can read or write it"), "{mode:o}: {told}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_file_of_another_user_is_refused() {
        let (_folder, layout) = folder_with_study();
        create(&layout.port()).unwrap().write_all(b"1 word\n").unwrap();
        if let Err(error) = std::os::unix::fs::chown(layout.port(), Some(65_534), None) {
            println!("skipped: only root gives a file to another user ({error})");
            return;
        }
        let told = read_port(&layout).unwrap_err().to_string();
        assert!(told.contains("belongs to another user"), "{told}");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_in_its_place_goes_and_what_it_leads_to_stays_as_it_is() {
        use std::os::unix::fs::{MetadataExt as _, symlink};
        let (_folder, layout) = folder_with_study();
        let text = std::fs::read(layout.study_toml()).unwrap();
        symlink("study.toml", layout.port()).unwrap();
        assert!(read_port(&layout).is_err());
        let lock = StudyLock::take(&layout, "me").unwrap();
        let _file = PortFile::write(&layout, &lock, "2 word\n").unwrap();
        assert_eq!(std::fs::read(layout.study_toml()).unwrap(), text);
        assert_eq!(std::fs::metadata(layout.port()).unwrap().mode() & 0o777, 0o600);
    }
}
