//! A new folder of files that is complete or absent: what it will hold is written into a folder
//! beside it, which gets its name once all is on the disk.

use crate::disk::atomic::{folder_of, is_unfinished, temporary};
use crate::keep::stream::Out;
use crate::{Entry, Files, StoreError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// A folder that is being written.
pub struct NewFolder<'f> {
    files: &'f dyn Files,
    path: PathBuf,
    beside: PathBuf,
    /// The folders that were made, each after the one that it lies in.
    folders: Vec<PathBuf>,
    written: Vec<PathBuf>,
}

impl<'f> NewFolder<'f> {
    /// Begins the folder `path`, which is not there yet, in a folder that is.
    ///
    /// # Errors
    /// Something at `path`; the disk's.
    pub fn begin(files: &'f dyn Files, path: &Path) -> Result<Self, StoreError> {
        if files.kind(path).is_some() {
            return Err(StoreError::io(path, "write", &std::io::ErrorKind::AlreadyExists.into()));
        }
        let beside = temporary(path);
        // Of an earlier process of the same number: what it left is nobody's, and not to be mixed with this.
        if files.kind(&beside).is_some() {
            let what = "an unfinished export lies here";
            return Err(StoreError::new(&beside, what, "remove it, and give the command again"));
        }
        let mut folder =
            Self { files, path: path.to_owned(), beside, folders: Vec::new(), written: Vec::new() };
        let beside = folder.beside.clone();
        match folder.create(&beside) {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.discard();
                Err(error)
            }
        }
    }

    /// What earlier processes left of the folder `path` when they were killed.
    pub fn unfinished(files: &dyn Files, path: &Path) -> Vec<PathBuf> {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned());
        let begins = format!(".{}.", name.unwrap_or_default());
        let beside = files.list(folder_of(path)).unwrap_or_default().into_iter();
        let is_left = |(left, kind): &(PathBuf, Entry)| {
            let name = left.file_name().map(|name| name.to_string_lossy().into_owned());
            let process = name.as_deref().unwrap_or_default().strip_prefix(&begins);
            let process = process.and_then(|rest| rest.strip_suffix(".tmp")).unwrap_or_default();
            let is_number = process.bytes().all(|byte| byte.is_ascii_digit());
            *kind == Entry::Folder && is_unfinished(left) && is_number
        };
        beside.filter(is_left).map(|(left, _)| left).collect()
    }

    /// Writes a file of the folder, a part at a time, and syncs it; `name` has `/` between its folders.
    /// Or the error of `write`.
    ///
    /// # Errors
    /// The disk's.
    pub fn write<E>(
        &mut self,
        name: &str,
        write: impl FnOnce(&mut (dyn Write + Send)) -> Result<(), E>,
    ) -> Result<Result<(), E>, StoreError> {
        let mut path = self.beside.clone();
        let mut parts = name.split('/').peekable();
        while let Some(part) = parts.next() {
            path.push(part);
            if parts.peek().is_some() && !self.folders.contains(&path) {
                self.create(&path)?;
            }
        }
        let shown = self.path.join(name);
        let failed = |error: std::io::Error| StoreError::io(&shown, "write", &error);
        self.written.push(path.clone());
        let mut out = Out::begin(self.files, &path).map_err(failed)?;
        let written = write(&mut out);
        // What the disk refused is that, whatever `write` makes of it.
        if let Some(disk) = out.failed.take() {
            return Err(failed(disk));
        }
        if written.is_ok() {
            out.sync().map_err(failed)?;
        }
        Ok(written)
    }

    /// Gives the folder its name. After an error nothing of it is left, or the error says what is.
    ///
    /// # Errors
    /// The disk's; something that lies at its place by now.
    pub fn publish(self) -> Result<(), StoreError> {
        let placed = self
            .folders
            .iter()
            .try_for_each(|folder| self.files.sync_folder(folder))
            .and_then(|()| match self.files.kind(&self.path) {
                // Another process: a rename would put this one in the place of an empty folder.
                Some(_) => Err(std::io::ErrorKind::AlreadyExists.into()),
                None => self.files.rename(&self.beside, &self.path),
            })
            .map_err(|e| StoreError::io(&self.path, "write", &e));
        if let Err(error) = placed {
            self.discard();
            return Err(error);
        }
        let synced = self.files.sync_folder(folder_of(&self.path));
        synced.map_err(|e| {
            let mut error = StoreError::io(&self.path, "sync the folder", &e);
            error.what +=
                "; it is there and whole, and whether it stays after a power cut is not known";
            error
        })
    }

    /// Removes what was written.
    pub fn discard(self) {
        // The first error was the one to report; what cannot be removed is told by the next export.
        for path in self.written.iter().filter(|path| self.files.kind(path).is_some()) {
            let _ = self.files.remove(path);
        }
        for folder in self.folders.iter().rev() {
            let _ = self.files.remove_folder(folder);
        }
    }

    fn create(&mut self, folder: &Path) -> Result<(), StoreError> {
        let made = self.files.create_folder(folder);
        made.map_err(|e| StoreError::io(&self.path, "create the folder", &e))?;
        self.folders.push(folder.to_owned());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Fault, Memory, RealFiles, Survives};

    const FILES: [&str; 3] = ["a.csv", "deep/er/b.csv", "deep/c.csv"];

    fn export(disk: &dyn Files, to: &Path) -> Result<(), StoreError> {
        let mut folder = NewFolder::begin(disk, to)?;
        for name in FILES {
            let written = folder.write(name, |out| out.write_all(name.as_bytes()));
            match written {
                Ok(Ok(())) => {}
                Ok(Err(error)) => panic!("{error}"),
                Err(error) => {
                    folder.discard();
                    return Err(error);
                }
            }
        }
        folder.publish()
    }

    fn whole(disk: &Memory) -> bool {
        let all = disk.below(Path::new("/out/new"));
        FILES.iter().all(|name| all.contains_key(&Path::new("/out/new").join(name)))
            && all.len() == FILES.len()
    }

    #[test]
    fn after_a_kill_or_a_full_disk_at_any_step_the_folder_is_complete_or_absent() {
        let new = Path::new("/out/new");
        let disk = Memory::new();
        disk.put(Path::new("/out/other"), b"theirs");
        let before = disk.steps();
        export(&disk, new).unwrap();
        let steps = disk.steps() - before;
        assert!(whole(&disk) && steps > 10, "{steps}");
        for (step, fault) in (0..steps)
            .flat_map(|step| [Fault::End, Fault::Full, Fault::ReadOnly].map(|fault| (step, fault)))
        {
            for survives in [Survives::Everything, Survives::Synced, Survives::Zeros] {
                let disk = Memory::new();
                disk.put(Path::new("/out/other"), b"theirs");
                disk.fail_in(step, fault);
                export(&disk, new).unwrap_err();
                disk.restart(if fault == Fault::End { survives } else { Survives::Everything });
                let is_there = disk.kind(new).is_some();
                assert!(!is_there || whole(&disk), "{fault:?} at {step}, {survives:?}");
                assert_eq!(disk.read(Path::new("/out/other"), 9).unwrap(), b"theirs");
                if fault == Fault::Full {
                    let left = NewFolder::unfinished(&disk, new);
                    assert!(left.is_empty(), "full at {step}: {left:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_there_is_never_written_over_and_what_a_kill_left_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let new = folder.path().join("new");
        std::fs::create_dir(folder.path().join(".new.17.tmp")).unwrap();
        std::fs::create_dir(folder.path().join(".new.other.17.tmp")).unwrap();
        assert_eq!(NewFolder::unfinished(&RealFiles, &new), [folder.path().join(".new.17.tmp")]);
        export(&RealFiles, &new).unwrap();
        assert_eq!(std::fs::read(new.join("deep/er/b.csv")).unwrap(), b"deep/er/b.csv");
        let error = export(&RealFiles, &new).unwrap_err();
        assert!(error.to_string().contains("exists"), "{error}");
        // It came into being while the other was written.
        let late = folder.path().join("late");
        let begun = NewFolder::begin(&RealFiles, &late).unwrap();
        std::fs::create_dir(&late).unwrap();
        assert!(begun.publish().is_err() && std::fs::read_dir(&late).unwrap().next().is_none());
    }
}
