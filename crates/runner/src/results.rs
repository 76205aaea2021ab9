//! The results of a study, and the one handle by which a run writes and removes them.
//!
//! A path in a record cannot be trusted: whoever can write a record could have any file removed. So
//! each path must be below one of a run's two own folders. Its text is checked first, and then,
//! whenever something is opened or removed, the disk: no folder on the way may be a link.

use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use zwidth_store::{
    Content, Entry, Files, Layout, MOST_BYTES, StoreError, files_below, hex_blake3, replace,
    replace_by, unfinished_below,
};

/// `derived/<study>` and `reports/<study>`: nothing else in a run writes or removes there, and it
/// writes and removes nothing elsewhere.
pub struct Results<'a> {
    layout: &'a Layout,
    files: &'a dyn Files,
}

/// Keeps others away from the study's results until it is dropped.
#[derive(Debug)]
pub(crate) struct Hold(File);

impl Drop for Hold {
    fn drop(&mut self) {
        // A program that is being started meanwhile has what is open until it runs, and the lock is
        // that of what is open: closing it here alone would not give it back. If that fails, closing has
        // to do.
        let _ = self.0.unlock();
    }
}

impl<'a> Results<'a> {
    /// The results of a study, on this disk.
    pub fn new(layout: &'a Layout, files: &'a dyn Files) -> Self {
        Self { layout, files }
    }

    /// Where the study lies.
    pub(crate) fn layout(&self) -> &Layout {
        self.layout
    }

    /// The folder that paths are shown relative to.
    pub(crate) fn root(&self) -> &Path {
        self.layout.root()
    }

    /// Where the records of the study's jobs are.
    pub fn records_file(layout: &Layout) -> PathBuf {
        layout.derived().join("records.json")
    }

    /// A file of the study's results as records name it: relative to the root, with `/`.
    ///
    /// # Errors
    /// Why the path is not one of a result, in words.
    pub fn named(layout: &Layout, path: &str) -> Result<PathBuf, String> {
        relative(path)?;
        let study = layout.study().as_str();
        match path.split('/').collect::<Vec<_>>().as_slice() {
            // A third part at least: the folders themselves are no results.
            ["derived" | "reports", name, _, ..] if *name == study => Ok(layout.root().join(path)),
            _ => Err(format!("it is neither below derived/{study} nor below reports/{study}")),
        }
    }

    /// Writes an output, whole.
    ///
    /// # Errors
    /// A path that is not below the study's results, or a link on the way to it; a write that
    /// failed.
    pub(crate) fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
        self.check(path)?;
        replace(self.files, path, bytes)
    }

    /// Writes an output, whole, a part at a time, and gives its BLAKE3; or the error of `write`.
    ///
    /// # Errors
    /// Those of [`Results::write`].
    pub(crate) fn write_by<E>(
        &self,
        path: &Path,
        write: impl FnOnce(&mut (dyn io::Write + Send)) -> Result<(), E>,
    ) -> Result<Result<String, E>, StoreError> {
        self.check(path)?;
        replace_by(self.files, path, write)
    }

    /// Removes an output that its own job made, or was to make. It may be missing.
    ///
    /// # Errors
    /// Those of [`Results::write`].
    pub(crate) fn remove(&self, path: &Path) -> Result<(), StoreError> {
        self.check(path)?;
        match self.files.kind(path) {
            None => Ok(()),
            Some(Entry::File) => {
                self.files.remove(path).map_err(|e| StoreError::io(path, "remove", &e))
            }
            Some(_) => Err(StoreError::new(path, "it is not a file, and was not removed", BY_HAND)),
        }
    }

    /// Removes an output that no job makes any more, if it still is what a job made.
    ///
    /// # Errors
    /// Those of [`Results::remove`]; another content than the one with this hash, which stays.
    pub(crate) fn remove_made(&self, path: &Path, blake3: &str) -> Result<(), StoreError> {
        self.check(path)?;
        if self.files.kind(path) == Some(Entry::File) {
            let bytes =
                self.files.read(path, MOST_BYTES).map_err(|e| StoreError::io(path, "read", &e))?;
            if hex_blake3(&bytes) != blake3 {
                let what = "no job makes it any more, but it was changed since it was made, and so it stays";
                return Err(StoreError::new(path, what, BY_HAND));
            }
        }
        self.remove(path)
    }

    /// Reads a file of the study's results, of at most `most` bytes; `None` if it is missing. The
    /// inner error says why it cannot be read.
    ///
    /// # Errors
    /// A link on the way to it.
    pub fn read(
        &self,
        path: &Path,
        most: u64,
    ) -> Result<Option<Result<Vec<u8>, StoreError>>, StoreError> {
        self.check(path)?;
        Ok(match self.files.read(path, most) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            bytes => Some(bytes.map_err(|e| StoreError::io(path, "read", &e))),
        })
    }

    /// What a file of the study's results holds, as [`Results::read`] reads it, to be read part by
    /// part.
    ///
    /// # Errors
    /// A link on the way to it.
    pub(crate) fn open(
        &self,
        path: &Path,
        most: u64,
    ) -> Result<Option<Result<Content, StoreError>>, StoreError> {
        self.check(path)?;
        Ok(match self.files.open(path, most) {
            Err(error) if error.kind() == ErrorKind::NotFound => None,
            opened => Some(opened.map_err(|e| StoreError::io(path, "read", &e))),
        })
    }

    /// The tables among the study's results.
    ///
    /// # Errors
    /// A folder that cannot be listed.
    pub(crate) fn tables(&self) -> Result<Vec<PathBuf>, StoreError> {
        let mut files = files_below(self.files, &self.layout.derived())?;
        files.retain(|path| path.extension().is_some_and(|end| end == "parquet"));
        Ok(files)
    }

    /// The names in a folder of the study's results; empty if there is no such folder.
    ///
    /// # Errors
    /// A link on the way to it; a folder that cannot be listed.
    pub(crate) fn list(&self, folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
        self.check_way(folder)?;
        match self.files.list(folder) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
            Err(error) => Err(StoreError::io(folder, "list", &error)),
            Ok(entries) => Ok(entries.into_iter().map(|(path, _)| path).collect()),
        }
    }

    /// Removes a folder of the study's results if nothing lies in it.
    pub(crate) fn remove_empty(&self, folder: &Path) {
        if self.check(folder).is_ok() {
            // One that has something in it stays, and costs nothing.
            let _ = self.files.remove_folder(folder);
        }
    }

    /// [`Self::hold_alone`], and removes the half-written files of earlier runs that were cut short:
    /// what lies here unfinished is nobody's work. If that fails, only litter stays.
    ///
    /// # Errors
    /// A run, a merge or a shard goes on.
    pub(crate) fn hold(&self) -> Result<Option<Hold>, StoreError> {
        let lock = self.hold_alone()?;
        if lock.is_some() {
            for folder in [self.layout.derived(), self.layout.reports()] {
                if self.check_way(&folder).is_ok() {
                    let unfinished = unfinished_below(self.files, &folder);
                    // What cannot be removed is litter still, and the next run's to sweep.
                    unfinished.iter().for_each(|path| _ = self.remove(path));
                }
            }
        }
        Ok(lock)
    }

    /// Keeps runs and merges away until what is returned is dropped, where the disk knows locks; other
    /// shards may work beside. Nothing is removed: on a disk that several machines share, not every
    /// lock is known to all of them, and what lies here unfinished may be another's work.
    ///
    /// # Errors
    /// A run or a merge goes on.
    pub(crate) fn hold_beside_shards(&self) -> Result<Option<Hold>, StoreError> {
        self.lock(File::try_lock_shared, "a run or a merge of the study goes on here")
    }

    /// Keeps runs, merges and shards away until what is returned is dropped, where the disk knows
    /// locks: each would write its own records over the other's.
    ///
    /// # Errors
    /// One of them goes on.
    pub(crate) fn hold_alone(&self) -> Result<Option<Hold>, StoreError> {
        self.lock(File::try_lock, "a run, a merge or a shard of the study goes on here")
    }

    fn lock(
        &self,
        try_lock: fn(&File) -> Result<(), TryLockError>,
        who: &str,
    ) -> Result<Option<Hold>, StoreError> {
        let Some(locked) = self.open_derived() else { return Ok(None) };
        match try_lock(&locked) {
            Ok(()) => Ok(Some(Hold(locked))),
            Err(TryLockError::WouldBlock) => {
                let remedy = "wait for its end, then try again";
                Err(StoreError::new(&self.layout.derived(), who, remedy))
            }
            // A disk that knows no locks: better a run without one than none.
            Err(TryLockError::Error(_)) => Ok(None),
        }
    }

    /// The study's derived folder, which is created if there is none; where no folder can be opened, on Windows, a file
    /// in it that nothing is written to.
    fn open_derived(&self) -> Option<File> {
        let folder = self.layout.derived();
        self.check_way(&folder).ok()?;
        for folder in [self.layout.root().join("derived"), folder.clone()] {
            if self.files.kind(&folder).is_none() {
                self.files.create_folder(&folder).ok()?;
            }
        }
        if cfg!(unix) {
            return File::open(&folder).ok();
        }
        let file = folder.join(".lock");
        let is_ours = matches!(self.files.kind(&file), None | Some(Entry::File));
        let mut options = File::options();
        // `LockFileEx` asks for a file that may be read or written.
        options.read(true).write(true).create(true).truncate(false);
        if is_ours { options.open(&file).ok() } else { None }
    }

    /// Whether a path is below the study's results, by its text and by every folder on the way.
    fn check(&self, path: &Path) -> Result<(), StoreError> {
        let text = match path.strip_prefix(self.root()) {
            Ok(below_root) => below_root.to_str().ok_or_else(|| "its name is not UTF-8".to_owned()),
            Err(error) => Err(error.to_string()),
        };
        text.and_then(|text| {
            Self::named(self.layout, &text.replace(std::path::MAIN_SEPARATOR, "/"))
        })
        .map_err(|why| {
            StoreError::new(path, format!("not a result of the study: {why}"), DEFECT)
        })?;
        path.parent().map_or(Ok(()), |folder| self.check_way(folder))
    }

    /// Whether every folder from the root down to this one is a folder, as far as there are any.
    fn check_way(&self, folder: &Path) -> Result<(), StoreError> {
        let mut at = self.root().to_owned();
        for part in folder.strip_prefix(self.root()).unwrap_or(folder) {
            at.push(part);
            match self.files.kind(&at) {
                Some(Entry::Folder) => {}
                // Below what is not there nothing can be a link.
                None => break,
                Some(Entry::Link) => {
                    return Err(StoreError::new(
                        &at,
                        "it is a link, and results are written into folders of the study's own alone",
                        "put a folder in its place; if the results are to lie on another disk, name that with --root",
                    ));
                }
                Some(_) => {
                    let remedy = "move what lies here elsewhere";
                    return Err(StoreError::new(&at, "a folder belongs here", remedy));
                }
            }
        }
        Ok(())
    }
}

const DEFECT: &str = "this is a defect of zwidth; please report it";
const BY_HAND: &str = "remove it when nobody needs it";

/// Whether a path leads down from where it begins, on any system.
///
/// # Errors
/// Why not, in words.
pub(crate) fn relative(path: &str) -> Result<(), String> {
    if path.split('/').any(|part| matches!(part, "" | "." | "..")) {
        return Err("it leads out of the data folder".to_owned());
    }
    // On Windows a backslash parts folders, and a colon names a drive.
    if path.contains(|c: char| c == '\\' || c == ':' || c.is_control()) {
        return Err("it has a character that no path of zwidth has".to_owned());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_store::RealFiles;

    fn world() -> (tempfile::TempDir, Layout) {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(&folder.path().join("root"), "s".parse().unwrap());
        fs::create_dir_all(layout.raw()).unwrap();
        fs::create_dir_all(layout.derived()).unwrap();
        fs::write(layout.study_toml(), "study").unwrap();
        (folder, layout)
    }

    #[test]
    fn only_relative_paths_below_the_two_folders_of_the_study_are_results() {
        let (_folder, layout) = world();
        for good in ["derived/s/a", "reports/s/figures/θ.svg"] {
            assert_eq!(Results::named(&layout, good), Ok(layout.root().join(good)));
        }
        for bad in [
            "",
            "/etc/passwd",
            "derived/s",
            "derived/s/",
            "derived/s/../../raw/s/study.toml",
            "derived/./s/a",
            "derived//s/a",
            "derived/other/a",
            "raw/s/study.toml",
            "study.toml",
            "../x/derived/s/a",
            "reports/S/a",
            "derived\\s\\a",
            "derived/s/a:b",
            "C:/derived/s/a",
            "derived/s/a\nb",
        ] {
            assert!(Results::named(&layout, bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn nothing_outside_is_written_or_removed_by_whatever_path() {
        let (folder, layout) = world();
        let results = Results::new(&layout, &RealFiles);
        let outside = folder.path().join("outside");
        fs::write(&outside, "theirs").unwrap();
        for path in
            [outside.clone(), layout.study_toml(), layout.derived().join("../../raw/s/study.toml")]
        {
            assert!(results.write(&path, b"x").is_err(), "{path:?}");
            assert!(
                results.remove(&path).is_err() && results.remove_made(&path, "").is_err(),
                "{path:?}"
            );
        }
        assert_eq!(fs::read_to_string(&outside).unwrap(), "theirs");
        assert_eq!(fs::read_to_string(layout.study_toml()).unwrap(), "study");
    }

    #[cfg(unix)]
    #[test]
    fn a_link_on_the_way_or_in_the_place_leads_nowhere() {
        use std::os::unix::fs::symlink;
        let (folder, layout) = world();
        let results = Results::new(&layout, &RealFiles);
        let outside = folder.path().join("outside");
        fs::create_dir(&outside).unwrap();
        fs::write(outside.join("a"), "theirs").unwrap();
        symlink(&outside, layout.derived().join("linked")).unwrap();
        let path = layout.derived().join("linked/a");
        let hash = hex_blake3(b"theirs");
        for error in [
            results.write(&path, b"ours").unwrap_err(),
            results.remove(&path).unwrap_err(),
            results.remove_made(&path, &hash).unwrap_err(),
        ] {
            assert_eq!(error.path, layout.derived().join("linked"));
            assert!(error.what.contains("it is a link"), "{error}");
        }
        let link = layout.derived().join("a");
        symlink(outside.join("a"), &link).unwrap();
        assert!(results.remove_made(&link, &hash).is_err() && link.is_symlink());
        results.write(&link, b"ours").unwrap();
        assert!(!link.is_symlink(), "the name is ours, what it led to is not");
        assert_eq!(fs::read_to_string(outside.join("a")).unwrap(), "theirs");
    }

    #[test]
    fn what_was_changed_since_it_was_made_stays() {
        let (_folder, layout) = world();
        let results = Results::new(&layout, &RealFiles);
        let path = layout.derived().join("a");
        results.write(&path, b"made").unwrap();
        let hash = hex_blake3(b"made");
        fs::write(&path, "edited").unwrap();
        let error = results.remove_made(&path, &hash).unwrap_err();
        assert!(error.what.contains("was changed since it was made"), "{error}");
        fs::write(&path, "made").unwrap();
        results.remove_made(&path, &hash).unwrap();
        assert!(!path.exists());
        results.remove_made(&path, &hash).unwrap();
    }

    #[test]
    fn litter_of_cut_writes_is_swept_where_no_other_run_goes_on_and_nothing_else_is() {
        let (_folder, layout) = world();
        let results = Results::new(&layout, &RealFiles);
        fs::create_dir_all(layout.reports().join("figures")).unwrap();
        let litter = layout.reports().join("figures/.likert.svg.17.tmp");
        let kept = [
            layout.derived().join("notes.tmp"),
            layout.derived().join(".x.tmp"),
            layout.raw().join(".a.17.tmp"),
        ];
        for path in kept.iter().chain([&litter]) {
            fs::write(path, "half").unwrap();
        }
        let run = results.hold().unwrap();
        assert!(!litter.exists() && kept.iter().all(|path| path.exists()));
        fs::write(&litter, "half").unwrap();
        for other in [results.hold(), results.hold_alone(), results.hold_beside_shards()] {
            let error = other.unwrap_err();
            assert!(error.what.starts_with("a run"), "{error}");
        }
        assert!(litter.exists(), "it may be the run's");
        // What a program has that is started at this moment.
        let _started = run.as_ref().map(|hold| hold.0.try_clone().unwrap());
        drop(run);
        let shards = [(); 2].map(|()| results.hold_beside_shards().unwrap());
        assert!(results.hold().is_err() && litter.exists(), "it may be a shard's");
        drop(shards);
        drop(results.hold().unwrap());
        assert!(!litter.exists());
    }
}
