//! One writer at a time: a lock file that says who holds it.
//!
//! The lock is the operating system's (`flock`, `LockFileEx`): it ends with the process that holds
//! it, however the process ends, so no lock is ever stale. The file stays where it is, empty while
//! nobody holds it; if it still names an owner, that owner did not end in order.

use crate::disk::atomic::create_folders;
use crate::disk::regular::open_or_create;
use crate::{Layout, RealFiles, StoreError};
use std::fs::{File, TryLockError};
use std::io::{self, Read as _, Seek as _, Write as _};
use std::path::Path;

/// The right to write to a study, until it is dropped.
#[derive(Debug)]
pub struct StudyLock {
    file: File,
}

impl StudyLock {
    /// Takes the lock of a study for `owner` ([`owner`] makes one).
    ///
    /// # Errors
    /// Somebody else holds it, with who that is; a folder that cannot be written.
    pub fn take(layout: &Layout, owner: &str) -> Result<Self, StoreError> {
        let path = layout.lock();
        let mut file = open(&path).map_err(|e| StoreError::io(&path, "open the lock", &e))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let holder = read(&mut file).filter(|text| !text.is_empty());
                let holder = holder.unwrap_or_else(|| "another process".to_owned());
                let what = format!("the study is in use: {holder}");
                return Err(StoreError::new(&path, what, "wait for it, or end it"));
            }
            Err(TryLockError::Error(e)) => return Err(StoreError::io(&path, "lock", &e)),
        }
        // An owner who did not end in order may have left a longer name.
        file.set_len(0)
            .and_then(|()| file.rewind())
            .and_then(|()| writeln!(file, "{owner}"))
            .map_err(|e| StoreError::io(&path, "write the lock", &e))?;
        Ok(Self { file })
    }
}

impl Drop for StudyLock {
    fn drop(&mut self) {
        // A name that stays says no more than that its owner did not end in order; the lock itself
        // goes in any case.
        let _ = self.file.set_len(0);
        // A program that is being started meanwhile has the open file until it runs, and the lock is
        // the file's: closing it here alone would not give it back.
        let _ = self.file.unlock();
    }
}

/// An owner's id: what it does, its process and host, and since when.
pub fn owner(command: &str, utc: &str) -> String {
    // Linux says it in /proc, Windows in the environment; elsewhere the process has to do.
    let host = std::fs::read_to_string("/proc/sys/kernel/hostname")
        .ok()
        .or(std::env::var("COMPUTERNAME").ok());
    let host = host.map(|name| format!(" on {}", name.trim())).unwrap_or_default();
    format!("{command}, process {}{host}, since {utc}", std::process::id())
}

/// Opens the lock's file, or creates it. It is written to, so nothing but a file of its own will
/// do: what a link or a second name leads to would be emptied.
fn open(path: &Path) -> io::Result<File> {
    create_folders(&RealFiles, crate::disk::atomic::folder_of(path))?;
    let file = open_or_create(File::options().read(true).write(true), path)?;
    let metadata = file.metadata()?;
    #[cfg(unix)]
    let has_second_name = std::os::unix::fs::MetadataExt::nlink(&metadata) > 1;
    #[cfg(not(unix))]
    let has_second_name = false;
    if has_second_name || metadata.len() > MOST_OWNER {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, OTHER));
    }
    Ok(file)
}

/// Why a file is not taken for the lock's.
const OTHER: &str =
    ".lock is not the file that zwidth makes there, or has a second name (a hard link); remove it";
/// Longest owner, bytes.
const MOST_OWNER: u64 = 1 << 12;

fn read(file: &mut File) -> Option<String> {
    let mut text = String::new();
    file.rewind().ok()?;
    file.read_to_string(&mut text).ok()?;
    Some(text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::crashes::folder_with_study;

    #[test]
    fn the_second_who_asks_is_told_who_holds_it() {
        let (_folder, layout) = folder_with_study();
        let first =
            StudyLock::take(&layout, &owner("zwidth acquire", "2026-01-01T00:00:00Z")).unwrap();
        let error = StudyLock::take(&layout, "another").unwrap_err();
        let words = format!("in use: zwidth acquire, process {}", std::process::id());
        assert!(error.what.contains(&words) && error.what.contains("since 2026-01-01"), "{error}");
        // What a program has that is started at this moment.
        let _started = first.file.try_clone().unwrap();
        drop(first);
        assert!(StudyLock::take(&layout, "another").is_ok());
    }

    #[test]
    fn an_owner_that_did_not_end_in_order_keeps_nobody_out() {
        let (_folder, layout) = folder_with_study();
        std::fs::write(layout.lock(), "zwidth acquire, process 1, since yesterday\n").unwrap();
        let lock = StudyLock::take(&layout, "me").unwrap();
        drop(lock);
        assert_eq!(std::fs::read(layout.lock()).unwrap(), b"");
    }

    #[cfg(unix)]
    #[test]
    fn a_lock_that_is_a_link_or_a_second_name_of_a_file_leaves_that_file_as_it_is() {
        let (_folder, layout) = folder_with_study();
        let text = std::fs::read(layout.study_toml()).unwrap();
        let as_link = |lock: &Path| std::os::unix::fs::symlink("study.toml", lock);
        let as_name = |lock: &Path| std::fs::hard_link(layout.study_toml(), lock);
        for make in [&as_link as &dyn Fn(&Path) -> io::Result<()>, &as_name] {
            make(&layout.lock()).unwrap();
            let error = StudyLock::take(&layout, "me").unwrap_err();
            assert_eq!(error.path, layout.lock());
            assert!(error.remedy.contains("put the file itself"), "{error}");
            assert_eq!(std::fs::read(layout.study_toml()).unwrap(), text);
            std::fs::remove_file(layout.lock()).unwrap();
        }
    }

    #[test]
    fn a_lock_is_no_finding() {
        let (_folder, layout) = folder_with_study();
        let _lock = StudyLock::take(&layout, "me").unwrap();
        assert_eq!(crate::verify(&layout), []);
    }
}
