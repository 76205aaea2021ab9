//! Several files changed as one: all of them, or none.
//!
//! A list of what is to be written is on the disk before the first file is touched, and its removal
//! is the moment at which the change is made. If the list is found, the writes are taken back: by
//! the process itself after a failed write, or by the next holder of the study's lock after a kill.
//! Until then readers pass over the lines that the list names.
//!
//! Files are removed in the reverse order of writing, and only what the change wrote is removed:
//! files of an imported session or sweep, with the listed content, and the listed lines at the end
//! of a log.

use crate::disk::atomic::folder_of;
use crate::disk::hash::blake3_of;
use crate::disk::regular::text;
use crate::disk::walk::unfinished_below;
use crate::form::change_list::{List, Longer, NewFile, Stand, below, unknown};
use crate::form::events::{MOST_LOG, NewLines, count_lines, write_lines};
use crate::form::footer::read_footer_from;
use crate::form::opened::ParquetFile;
use crate::form::session_record::{MOST_RECORD, record_from};
use crate::keep::recovered::{Done, Recovered};
use crate::{Append, Entered, Entry, Files, Layout, StoreError, replace};
use std::collections::BTreeSet;
use std::path::Path;
use zwidth_study::{Event, Source};

/// The result of taking a change back.
#[derive(Debug, Default)]
pub struct TakenBack {
    /// Files that were removed.
    pub files: usize,
    /// Logs that lost lines.
    pub logs: usize,
    /// The errors of everything that could not be taken back.
    pub left: Vec<StoreError>,
    /// A folder that could not be synced: what was removed from it may come back after a power
    /// cut.
    unsynced: Option<StoreError>,
}

/// Adds events to several logs, or to none of them.
///
/// # Errors
/// A log that cannot be read to its end; a change before this one that was cut short and not taken
/// back; the write that failed, saying what became of the lines that were written before.
pub fn commit_events<'a>(
    files: &dyn Files,
    layout: &Layout,
    entered: impl Into<Entered<'a>>,
    logs: &[(&Path, &[Event])],
) -> Result<(), StoreError> {
    let change = Change::of(files, layout, entered.into(), &[], logs)?;
    // Without new files there is one error.
    change.make("changed", || Ok(())).map_err(|mut errors| errors.swap_remove(0))
}

/// A change of several files that is about to be made.
pub struct Change<'a> {
    disk: &'a dyn Files,
    layout: &'a Layout,
    list: List,
    lines: Vec<NewLines<'a>>,
}

impl<'a> Change<'a> {
    /// The change that writes these new files, each with its BLAKE3, hexadecimal, and then adds
    /// these events to logs.
    ///
    /// # Errors
    /// A log that cannot be read to its end.
    pub fn of(
        disk: &'a dyn Files,
        layout: &'a Layout,
        entered: Entered<'_>,
        files: &[(&Path, String)],
        logs: &[(&'a Path, &[Event])],
    ) -> Result<Self, StoreError> {
        let raw = layout.raw();
        // Sorted, so that outer ones come first.
        let mut folders = BTreeSet::new();
        for (path, _) in files {
            let parents = path.ancestors().skip(1).take_while(|parent| parent.starts_with(&raw));
            folders.extend(parents.filter(|parent| disk.kind(parent).is_none()));
        }
        let with_lines = logs.iter().filter(|(_, events)| !events.is_empty());
        let lines = with_lines
            .map(|(path, events)| NewLines::of(disk, path, entered, events))
            .collect::<Result<Vec<_>, _>>()?;
        let new_files = files
            .iter()
            .map(|(path, blake3)| NewFile { path: listed(path, &raw), blake3: blake3.clone() });
        let longer = lines.iter().map(|new| Longer {
            path: listed(new.path, &raw),
            bytes_before: new.bytes_before,
            lines_before: new.lines_before,
            bytes: new.text.len() as u64,
            first: new.text.lines().next().unwrap_or_default().to_owned() + "\n",
        });
        let list = List {
            files: new_files.collect(),
            folders: folders.into_iter().map(|folder| listed(folder, &raw)).collect(),
            logs: longer.collect(),
        };
        Ok(Self { disk, layout, list, lines })
    }

    /// Makes the change; `write` writes the new files. An error says that nothing was `done`.
    ///
    /// # Errors
    /// A change before this one that was cut short and not taken back; the write that failed, with
    /// the fate of earlier writes, and after it each file that could not be removed again.
    pub fn make(
        &self,
        done: &str,
        write: impl FnOnce() -> Result<(), StoreError>,
    ) -> Result<(), Vec<StoreError>> {
        let path = self.layout.unfinished();
        if self.disk.kind(&path).is_some() {
            let what = "a change before this one was cut short, and is not taken back yet";
            let remedy = format!("run `zwidth recover {}`", self.layout.study());
            return Err(vec![StoreError::new(&path, what, remedy)]);
        }
        let mut open = Vec::new();
        let change = serde_json::to_vec(&self.list)
            .map_err(|e| StoreError::defect(&path, &e))
            .and_then(|list| replace(self.disk, &path, &list))
            .and_then(|()| write())
            // Last, because logs have lines of others too.
            .and_then(|()| {
                for lines in &self.lines {
                    open.push(write_lines(self.disk, lines.path, &lines.text)?);
                }
                Ok(())
            })
            .and_then(|()| remove(self.disk, &path));
        if let Err(mut error) = change {
            let (outcome, left) = self.undo(done, open);
            error.what += &outcome;
            return Err([vec![error], left].concat());
        }
        // Only now: a log whose head counts the lines says that the change was made.
        for lines in &self.lines {
            count_lines(self.disk, lines.path, &lines.digests);
        }
        Ok(())
    }

    /// Takes back what was written before a write failed; what became of it, in words, and each file
    /// that could not be removed again.
    fn undo(&self, done: &str, open: Vec<Box<dyn Append>>) -> (String, Vec<StoreError>) {
        let is_listed = self.disk.kind(&self.layout.unfinished()).is_some();
        let mut cut = Ok(());
        for mut log in open.into_iter().rev() {
            cut = log.take_back().and(cut);
        }
        for log in &self.list.logs {
            log.remove_if_new(self.disk, self.layout);
        }
        let back = self.list.take_back_files(self.disk, self.layout);
        if cut.is_ok() && back.left.is_empty() {
            // A list that stays names what is gone: whoever finds it has nothing to take back.
            let _ = self.disk.remove(&self.layout.unfinished());
            let files = match back.files {
                0 => String::new(),
                1 => ", and the file written before was removed again".to_owned(),
                n => format!(", and the {n} files written before were removed again"),
            };
            let outcome = format!("; nothing was {done}{files}");
            return (outcome, Vec::new());
        }
        let outcome = match (is_listed, back.left.len()) {
            (false, _) => "; whether it was done is not known: look with `zwidth list`".to_owned(),
            (true, 0) => {
                "; lines written before could not be taken back, which the next command will try"
                    .to_owned()
            }
            (true, n) => format!(
                "; {n} files written before could not be removed again, which the next command will try"
            ),
        };
        (outcome, back.left)
    }
}

/// A path as the list has it: below `raw`, with `/` between folders on any system.
fn listed(path: &Path, raw: &Path) -> String {
    let below = path.strip_prefix(raw).unwrap_or(path);
    below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

impl List {
    /// Takes back what was written of the list.
    fn take_back(&self, disk: &dyn Files, layout: &Layout) -> TakenBack {
        let mut lines = Vec::new();
        let mut left = Vec::new();
        for log in &self.logs {
            match log.stand(disk, layout) {
                Ok(stand) => lines.push((log, stand)),
                Err(error) => left.push(error),
            }
        }
        // The list went, and a power cut brought it back: the change was made.
        if lines.iter().any(|(_, stand)| *stand == Stand::Counted) {
            return TakenBack::default();
        }
        let mut logs = 0;
        // Logs before files: none must speak of what is gone.
        for (log, _) in lines.iter().filter(|(_, stand)| *stand == Stand::Longer) {
            match log.cut(disk, layout) {
                Ok(()) => logs += 1,
                Err(error) => left.push(error),
            }
        }
        for (log, _) in lines.iter().filter(|(_, stand)| *stand == Stand::Before) {
            log.remove_if_new(disk, layout);
        }
        let mut back = self.take_back_files(disk, layout);
        back.left.splice(0..0, left);
        TakenBack { logs, ..back }
    }

    /// Removes the new files, and the folders that were made for them.
    fn take_back_files(&self, disk: &dyn Files, layout: &Layout) -> TakenBack {
        let mut done = TakenBack::default();
        for new in self.files.iter().rev() {
            match new.remove(disk, layout) {
                Ok(false) => {}
                Ok(true) => {
                    done.files += 1;
                    if let Some(path) = below(layout, &new.path) {
                        done.sync(disk, folder_of(&path));
                    }
                }
                Err(error) => done.left.push(error),
            }
        }
        for folder in self.folders.iter().rev().filter_map(|folder| below(layout, folder)) {
            // A folder that stays holds something that is none of the change's.
            if disk.kind(&folder) == Some(Entry::Folder) && disk.remove_folder(&folder).is_ok() {
                done.sync(disk, folder_of(&folder));
            }
        }
        done
    }
}

impl NewFile {
    /// Removes a file if it is the one that the change wrote.
    fn remove(&self, disk: &dyn Files, layout: &Layout) -> Result<bool, StoreError> {
        let path = below(layout, &self.path).ok_or_else(|| unknown(layout, &self.path))?;
        if disk.kind(&path).is_none() {
            return Ok(false);
        }
        if blake3_of(disk, &path)? != self.blake3 || !is_a_changes_own(disk, layout, &path) {
            let what = "a change that was cut short lists it, but did not write it as it is now";
            let list = layout.unfinished();
            let remedy = format!("look at it; if it is to stay, remove {}", list.display());
            return Err(StoreError::new(&path, what, remedy));
        }
        disk.remove(&path).map_err(|e| StoreError::io(&path, "remove again", &e))?;
        Ok(true)
    }
}

impl Longer {
    /// Removes a log that the change began, and that has no line. One that stays says nothing, so that nothing is lost.
    fn remove_if_new(&self, disk: &dyn Files, layout: &Layout) {
        if let Ok(path) = self.place(layout)
            && self.bytes_before == 0
            && disk.read(&path, MOST_LOG).is_ok_and(|bytes| bytes.is_empty())
        {
            let _ = disk.remove(&path).and_then(|()| disk.sync_folder(folder_of(&path)));
        }
    }

    /// Cuts off what follows the lines of before.
    fn cut(&self, disk: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
        let path = self.place(layout)?;
        let mut bytes =
            disk.read(&path, MOST_LOG).map_err(|e| StoreError::io(&path, "read", &e))?;
        bytes.truncate(usize::try_from(self.bytes_before).unwrap_or(usize::MAX));
        if !bytes.is_empty() {
            return replace(disk, &path, &bytes);
        }
        let removed = disk.remove(&path).and_then(|()| disk.sync_folder(folder_of(&path)));
        removed.map_err(|e| StoreError::io(&path, "take lines back from", &e))
    }
}

impl TakenBack {
    fn sync(&mut self, disk: &dyn Files, folder: &Path) {
        let synced = disk.sync_folder(folder).map_err(|e| StoreError::io(folder, "sync", &e));
        self.unsynced = self.unsynced.take().or(synced.err());
    }
}

/// Whether a file belongs to an imported session, or is an imported sweep, or a table of a metric or a stream from outside.
/// No other is a change's to remove.
fn is_a_changes_own(disk: &dyn Files, layout: &Layout, path: &Path) -> bool {
    if path.parent() == Some(layout.own().as_path()) || path.starts_with(layout.beside()) {
        return true;
    }
    if path.extension().is_some_and(|e| e == "parquet") {
        let source = match read_footer_from(disk, path) {
            Ok(trial) => Some(trial.meta.source),
            // No trial: a sweep, if anything of ours.
            Err(_) => ParquetFile::open(disk, path)
                .ok()
                .and_then(|sweep| Source::from_word(sweep.footer.get("source")?)),
        };
        return source.is_some_and(Source::is_imported);
    }
    // `P01_S01.json`, `.study.toml`, `.events.jsonl`, `.events.head`: the record tells for all of
    // them. Log and head are written after it and removed before it; the copy of study.toml may
    // stand alone.
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let Some((session, kind)) = name.split_once('.') else { return false };
    let record = path.with_file_name(format!("{session}.json"));
    if disk.kind(&record).is_none() {
        return kind == "study.toml";
    }
    let record = text(disk, &record, MOST_RECORD).and_then(|text| record_from(&record, &text));
    record.is_ok_and(|record| record.source.is_imported())
}

/// Removes a file, and syncs that.
fn remove(disk: &dyn Files, path: &Path) -> Result<(), StoreError> {
    let removed = disk.remove(path).and_then(|()| disk.sync_folder(folder_of(path)));
    removed.map_err(|e| StoreError::io(path, "remove", &e))
}

/// Takes back what a change that was cut short has left: half-written files, and what its list
/// names. The caller holds the study's lock.
///
/// # Errors
/// One each for what could not be removed: it is not what a change wrote, or the disk failed.
pub fn settle(disk: &dyn Files, layout: &Layout) -> Vec<Result<Recovered, StoreError>> {
    let mut results = Vec::new();
    for path in unfinished_below(disk, &layout.raw()) {
        results.push(remove(disk, &path).map(|()| Recovered { path, done: Done::Swept }));
    }
    let path = layout.unfinished();
    match List::read(disk, &path) {
        Ok(None) => {}
        Ok(Some(list)) => {
            let TakenBack { files, logs, left, unsynced } = list.take_back(disk, layout);
            if left.is_empty() && unsynced.is_none() {
                let done = Done::TakenBack { files, logs };
                results.push(remove(disk, &path).map(|()| Recovered { path, done }));
            } else {
                results.extend(left.into_iter().chain(unsynced).map(Err));
            }
        }
        Err(error) => results.push(Err(error)),
    }
    results
}
