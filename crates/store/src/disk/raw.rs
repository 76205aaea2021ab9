//! The handle that writes below `raw/<study>`: commands have no other way to write there.
//!
//! It is a file layer. When a file is opened, it refuses files elsewhere, and actions that its
//! command may not do: a command that records only adds files, and removes only its own journals;
//! `recover` and `import` may also remove and rewrite what an unfinished process left. To get this
//! handle, a command must hold the study's lock or make the study.

use crate::disk::atomic::is_unfinished;
use crate::disk::content::Content;
use crate::{Append, Entry, Files, Held, Layout, Stamp, StudyLock};
use std::io;
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The operations that a handle permits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum May {
    Add,
    Mend,
}

/// The right to write below `raw/<study>`.
pub struct Raw<'a> {
    files: &'a dyn Files,
    layout: Layout,
    vault: Option<PathBuf>,
    may: May,
    /// The file that was given its name last: it is taken away again where its name cannot be
    /// synced.
    newest: Mutex<Option<PathBuf>>,
}

impl<'a> Raw<'a> {
    fn of(files: &'a dyn Files, layout: &Layout, may: May) -> Self {
        Self { files, layout: layout.clone(), vault: None, may, newest: Mutex::new(None) }
    }

    /// For a new study: nobody can hold its lock yet.
    pub fn new_study(files: &'a dyn Files, layout: &Layout) -> Self {
        Self::of(files, layout, May::Add)
    }

    /// For a command that records: it adds, and removes its own journals.
    pub fn adds(files: &'a dyn Files, layout: &Layout, _lock: &'a StudyLock) -> Self {
        Self::of(files, layout, May::Add)
    }

    /// For `recover` and `import`: they take back what an unfinished life left.
    pub fn mends(files: &'a dyn Files, layout: &Layout, _lock: &'a StudyLock) -> Self {
        Self::of(files, layout, May::Mend)
    }

    /// The same, which may add to the folder of seals too. An empty path names none: every path
    /// begins with it.
    #[must_use]
    pub fn with_vault(self, folder: &Path) -> Self {
        let vault = Some(folder.to_owned()).filter(|folder| *folder != Path::new(""));
        Self { vault, ..self }
    }

    /// The layer below, if the handle is for this path, by its text and by every folder on the way.
    fn layer_for(&self, path: &Path) -> io::Result<&'a dyn Files> {
        let vault = self.vault.as_deref().filter(|vault| path.starts_with(vault));
        // From the root on: raw/ and the study's folder may be links too.
        let is_raw = path.starts_with(self.layout.raw());
        let top = if is_raw { Some(self.layout.root()) } else { vault };
        // Nothing below `top` may lead up again. `top` itself is the user's to spell: `../data`.
        let top = top
            .filter(|top| {
                path.strip_prefix(top)
                    .is_ok_and(|below| below.components().all(|part| part != Component::ParentDir))
            })
            .ok_or_else(|| refused(path, "this command writes only below raw/ of its study"))?;
        let mut folders =
            path.ancestors().skip(1).take_while(|folder| *folder != top && folder.starts_with(top));
        // A link on the way would lead a writer out of the study.
        match folders.find(|folder| self.files.kind(folder) == Some(Entry::Link)) {
            Some(link) => Err(refused(link, "this command does not follow a link below raw/")),
            None => Ok(self.files),
        }
    }

    /// The same for a folder that is created: those above raw/ and the vault have to be made as
    /// well, and nothing is recorded in them.
    fn layer_for_folder(&self, path: &Path) -> io::Result<&'a dyn Files> {
        let is_above = self.layout.raw().starts_with(path)
            || self.vault.as_deref().is_some_and(|vault| vault.starts_with(path));
        if is_above { Ok(self.files) } else { self.layer_for(path) }
    }

    /// Whether this is a session's copy of study.toml without the session's record: no session
    /// names it, and laying the session down writes it anew.
    fn is_orphaned_copy(&self, path: &Path) -> bool {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let session = name.strip_suffix(".study.toml").filter(|session| !session.is_empty());
        let record = session.map(|session| path.with_file_name(format!("{session}.json")));
        let in_sessions = path.parent() == Some(self.layout.sessions().as_path());
        in_sessions && record.is_some_and(|record| self.files.kind(&record).is_none())
    }

    /// Whether this is a log without a line: a write failed that was to begin it.
    fn is_empty_log(&self, path: &Path) -> bool {
        let is_log = path.to_string_lossy().ends_with(".events.jsonl");
        is_log && self.files.read(path, 1).is_ok_and(|bytes| bytes.is_empty())
    }

    fn newest(&self) -> MutexGuard<'_, Option<PathBuf>> {
        // A panic elsewhere leaves a path or none.
        self.newest.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The same for something that is removed or replaced, which a command that records may do to
    /// its `own` only.
    fn layer_for_removal(&self, path: &Path, own: bool) -> io::Result<&'a dyn Files> {
        if own || self.may == May::Mend {
            return self.layer_for(path);
        }
        Err(refused(path, "this command does not remove what was recorded"))
    }
}

fn refused(path: &Path, why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::PermissionDenied, format!("{why}: {}", path.display()))
}

impl Files for Raw<'_> {
    fn kind(&self, path: &Path) -> Option<Entry> {
        self.files.kind(path)
    }

    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        self.files.list(folder)
    }

    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        self.files.read(path, most)
    }

    fn open(&self, path: &Path, most: u64) -> io::Result<Content> {
        self.files.open(path, most)
    }

    fn stamp(&self, path: &Path) -> Option<Stamp> {
        self.files.stamp(path)
    }

    fn hold(&self, folder: &Path) -> io::Result<Box<dyn Held>> {
        self.files.hold(folder)
    }

    fn make_private(&self, path: &Path) -> io::Result<()> {
        self.layer_for(path)?.make_private(path)
    }

    fn create_folder(&self, path: &Path) -> io::Result<()> {
        self.layer_for_folder(path)?.create_folder(path)
    }

    fn create_private_folder(&self, path: &Path) -> io::Result<()> {
        self.layer_for_folder(path)?.create_private_folder(path)
    }

    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        // What is written lies beside its name first; the name itself is never written to.
        let beside = is_unfinished(path) || self.files.kind(path).is_none();
        self.layer_for_removal(path, beside)?.write_synced(path, bytes)
    }

    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        // The head of a log counts its lines, and is written anew with each.
        let is_head = to.extension().is_some_and(|e| e == "head");
        let is_new = self.files.kind(to).is_none();
        let free = is_new || is_head || self.is_orphaned_copy(to);
        self.layer_for(from)?;
        self.layer_for_removal(to, free && is_unfinished(from))?.rename(from, to)?;
        // What stood under a name that was replaced is gone: to remove it would not undo anything.
        *self.newest() = is_new.then(|| to.to_owned());
        Ok(())
    }

    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        // Anywhere: it changes nothing, and the names of outer folders are synced as well.
        self.files.sync_folder(path)
    }

    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        self.layer_for(path)?.open_append(path)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        let own = is_unfinished(path)
            || path.starts_with(self.layout.journals())
            // The list of a change of several files goes when that is made.
            || path == self.layout.unfinished()
            || self.newest().as_deref() == Some(path)
            || self.is_empty_log(path);
        self.layer_for_removal(path, own)?.remove(path)
    }

    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        self.layer_for_removal(path, path == self.layout.journals())?.remove_folder(path)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Memory, replace, write_new, write_private};

    fn study() -> (Memory, Layout) {
        let layout = Layout::new(Path::new("/r"), "demo".parse().unwrap());
        let disk = Memory::new();
        disk.put(&layout.study_toml(), b"study");
        disk.put(&layout.raw().join("trials/trial-001.parquet"), b"a trial");
        disk.put(&layout.journals().join("a.journal"), b"a journal");
        disk.put(Path::new("/r/derived/demo/x"), b"a result");
        disk.put(Path::new("/r/raw/other/study.toml"), b"another study");
        (disk, layout)
    }

    #[test]
    fn no_handle_writes_or_removes_outside_of_its_study() {
        let (disk, layout) = study();
        let before = disk.below(Path::new("/"));
        for may in [May::Add, May::Mend] {
            let raw = Raw::of(&disk, &layout, may).with_vault(Path::new("/keys"));
            for path in [
                "/r/derived/demo/x",
                "/r/raw/other/study.toml",
                "/r/raw/demo/../other/study.toml",
                "/etc/x",
            ] {
                let path = Path::new(path);
                assert!(
                    replace(&raw, path, b"no").is_err() && raw.remove(path).is_err(),
                    "{path:?}"
                );
                assert!(
                    raw.open_append(path).is_err() && raw.remove_folder(path).is_err(),
                    "{path:?}"
                );
                assert!(raw.rename(&layout.study_toml(), path).is_err(), "{path:?}");
                assert!(raw.make_private(path).is_err(), "{path:?}");
            }
        }
        assert_eq!(disk.below(Path::new("/")), before);
    }

    #[test]
    fn folders_above_the_vault_are_made_and_nothing_is_written_in_them() {
        let (disk, layout) = study();
        let vault = Path::new("/home/.local/state/zwidth");
        let raw = Raw::of(&disk, &layout, May::Add).with_vault(vault);
        write_private(&raw, &vault.join("demo/seed"), b"1").unwrap();
        assert!(write_private(&raw, Path::new("/home/.local/seed"), b"1").is_err());
        assert!(raw.make_private(Path::new("/home/.local")).is_err());
    }

    #[test]
    fn a_vault_without_a_name_opens_no_other_folder() {
        let (disk, layout) = study();
        let raw = Raw::of(&disk, &layout, May::Add).with_vault(Path::new(""));
        assert!(write_new(&raw, Path::new("/r/derived/demo/new"), b"no").is_err());
    }

    #[test]
    fn root_and_vault_may_lead_up_and_nothing_below_them() {
        let layout = Layout::new(Path::new("../r"), "demo".parse().unwrap());
        let (disk, vault) = (Memory::new(), Path::new("../keys"));
        let raw = Raw::of(&disk, &layout, May::Add).with_vault(vault);
        write_new(&raw, &layout.study_toml(), b"study").unwrap();
        write_private(&raw, &vault.join("demo/seed"), b"1").unwrap();
        for path in ["../r/raw/demo/../other/x", "../keys/../x"] {
            assert!(write_new(&raw, Path::new(path), b"no").is_err(), "{path}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn no_handle_follows_a_linked_folder_out_of_its_study() {
        use crate::RealFiles;
        use std::fs;
        use std::os::unix::fs::symlink;
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(&folder.path().join("root"), "demo".parse().unwrap());
        let (outside, vault) = (folder.path().join("outside"), folder.path().join("vault"));
        for made in [&layout.raw(), &outside, &vault] {
            fs::create_dir_all(made).unwrap();
        }
        fs::write(outside.join("theirs"), "theirs").unwrap();
        symlink(&outside, layout.trials()).unwrap();
        symlink(&outside, vault.join("demo")).unwrap();
        for may in [May::Add, May::Mend] {
            let raw = Raw::of(&RealFiles, &layout, may).with_vault(&vault);
            for linked in [layout.trials(), vault.join("demo")] {
                let error = write_new(&raw, &linked.join("new"), b"ours").unwrap_err();
                assert!(error.to_string().contains("does not follow a link"), "{error}");
                let theirs = linked.join("theirs");
                assert!(raw.remove(&theirs).is_err() && raw.open_append(&theirs).is_err());
                assert!(raw.create_folder(&linked.join("folder")).is_err());
            }
        }
        let left: Vec<_> =
            fs::read_dir(&outside).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["theirs"]);
    }

    #[test]
    fn a_handle_that_adds_changes_and_removes_nothing_that_was_recorded() {
        let (disk, layout) = study();
        let raw = Raw::new_study(&disk, &layout).with_vault(Path::new("/keys"));
        let trial = layout.raw().join("trials/trial-001.parquet");
        for path in [&trial, &layout.study_toml()] {
            assert!(raw.remove(path).is_err() && replace(&raw, path, b"no").is_err());
            assert!(raw.write_synced(path, b"no").is_err());
        }
        assert!(raw.remove_folder(&layout.trials()).is_err());
        write_new(&raw, &layout.raw().join("trials/trial-002.parquet"), b"a second").unwrap();
        write_new(&raw, Path::new("/keys/demo/seed"), b"1").unwrap();
        let head = layout.raw().join("sessions/P01_S01.events.head");
        replace(&raw, &head, b"1").unwrap();
        replace(&raw, &head, b"2").unwrap();
        raw.remove(&layout.journals().join("a.journal")).unwrap();
        raw.remove_folder(&layout.journals()).unwrap();
    }

    /// Found by `soak kill`: a life that was killed between the copy and the record of a session
    /// kept the next one from laying the session down.
    #[test]
    fn a_copy_of_the_study_that_no_record_names_is_written_anew_and_one_that_is_named_is_not() {
        let (disk, layout) = study();
        let raw = Raw::new_study(&disk, &layout);
        let copy = layout.raw().join("sessions/P01_S01.study.toml");
        write_new(&raw, &copy, b"killed").unwrap();
        replace(&raw, &copy, b"again").unwrap();
        write_new(&raw, &layout.raw().join("sessions/P01_S01.json"), b"{}").unwrap();
        assert!(replace(&raw, &copy, b"never").is_err() && raw.remove(&copy).is_err());
        assert!(replace(&raw, &layout.study_toml(), b"never").is_err());
    }

    #[test]
    fn a_handle_that_mends_may_take_back_what_lies_in_its_study() {
        let (disk, layout) = study();
        let raw = Raw::of(&disk, &layout, May::Mend);
        raw.remove(&layout.raw().join("trials/trial-001.parquet")).unwrap();
        replace(&raw, &layout.raw().join("sessions/P01_S01.events.jsonl"), b"mended").unwrap();
    }
}
