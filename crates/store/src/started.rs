//! The list of what an import is about to write. It is on the disk before the first of these files
//! is and goes after the last, so that whoever finds it knows exactly what an import that was cut
//! short has left, and takes it back.
//!
//! Files go in the reverse of the order in which they were written, and only what the import wrote
//! goes: a file of a session or sweep that was imported, with the listed content.

use crate::atomic::folder_of;
use crate::events::{mend_log, take_back_events};
use crate::footer::read_footer_from;
use crate::hash::blake3_of;
use crate::json::from_json;
use crate::opened::ParquetFile;
use crate::recover::{Done, Recovered, sweep_unfinished};
use crate::regular::text;
use crate::sessions::{MOST_RECORD, record_from};
use crate::{Entry, Files, Layout, StoreError, replace};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};
use zwidth_study::{Event, Source};

/// What an import is about to write.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Started {
    /// The new files in the order in which they are written.
    files: Vec<New>,
    /// The folders that are made for them, outer ones first.
    folders: Vec<String>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct New {
    /// Below `raw/<study>`, with `/` between folders.
    path: String,
    blake3: String,
}

/// What was taken back.
#[derive(Debug, Default)]
pub struct TakenBack {
    /// Files that were removed.
    pub removed: usize,
    /// What could not be taken back.
    pub left: Vec<StoreError>,
    /// A folder that could not be synced: what was removed from it may come back after a power
    /// cut.
    unsynced: Option<StoreError>,
}

impl Started {
    /// The list of these files, each with its BLAKE3, hexadecimal.
    pub fn of(disk: &dyn Files, layout: &Layout, files: &[(&Path, String)]) -> Self {
        let raw = layout.raw();
        let shown = |path: &Path| {
            let below = path.strip_prefix(&raw).unwrap_or(path);
            below.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
        };
        let mut folders = BTreeSet::new();
        for (path, _) in files {
            let parents = path.ancestors().skip(1).take_while(|parent| parent.starts_with(&raw));
            folders.extend(parents.filter(|parent| disk.kind(parent).is_none()));
        }
        let files =
            files.iter().map(|(path, blake3)| New { path: shown(path), blake3: blake3.clone() });
        Self { files: files.collect(), folders: folders.into_iter().map(shown).collect() }
    }

    /// Writes the list.
    pub fn begin(&self, disk: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
        let path = layout.import_list();
        let json = serde_json::to_vec(self);
        let json = json.map_err(|e| {
            StoreError::new(&path, e.to_string(), "this is a defect of zwidth, please report it")
        })?;
        replace(disk, &path, &json)
    }

    /// Takes back what was written of the list, and then the list, unless something could not be
    /// taken back.
    pub fn take_back(&self, disk: &dyn Files, layout: &Layout) -> TakenBack {
        let mut done = TakenBack::default();
        // The log of the sweeps before the sweeps: it must not speak of what is gone.
        if let Err(error) = self.take_back_sweeps(disk, layout) {
            done.left.push(error);
        }
        for new in self.files.iter().rev() {
            match self.remove(disk, layout, new) {
                Ok(false) => {}
                Ok(true) => {
                    done.removed += 1;
                    if let Some(path) = below(layout, &new.path) {
                        done.sync(disk, folder_of(&path));
                    }
                }
                Err(error) => done.left.push(error),
            }
        }
        for folder in self.folders.iter().rev().filter_map(|folder| below(layout, folder)) {
            // A folder that stays holds something that is none of the import's.
            if disk.kind(&folder) == Some(Entry::Folder) && disk.remove_folder(&folder).is_ok() {
                done.sync(disk, folder_of(&folder));
            }
        }
        done
    }

    /// Removes a file if it is the one that the import wrote.
    fn remove(&self, disk: &dyn Files, layout: &Layout, new: &New) -> Result<bool, StoreError> {
        let list = layout.import_list();
        let Some(path) = below(layout, &new.path) else {
            let what = format!("it lists '{}', which no import writes", new.path);
            return Err(StoreError::new(&list, what, "look at who wrote it, and remove the list"));
        };
        if disk.kind(&path).is_none() {
            return Ok(false);
        }
        if blake3_of(disk, &path)? != new.blake3 || !is_imported(disk, &path) {
            let what = "an import that was cut short lists it, but did not write it as it is now";
            let remedy = format!("look at it; if it is to stay, remove {}", list.display());
            return Err(StoreError::new(&path, what, remedy));
        }
        disk.remove(&path).map_err(|e| StoreError::io(&path, "remove again", &e))?;
        Ok(true)
    }

    /// Takes back the lines about the listed sweeps from the end of their log.
    fn take_back_sweeps(&self, disk: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
        let sweeps: Vec<PathBuf> =
            self.files.iter().filter_map(|new| below(layout, &new.path)).collect();
        let log = layout.sweep_events();
        if disk.kind(&log) != Some(Entry::File)
            || !sweeps.iter().any(|p| p.starts_with(layout.sweeps()))
        {
            return Ok(());
        }
        mend_log(disk, &log)?;
        take_back_events(disk, &log, &|event| match event {
            Event::SweepRecorded { actuator, sweep, .. } => {
                sweeps.contains(&layout.sweep(actuator, *sweep))
            }
            _ => false,
        })
    }
}

impl TakenBack {
    fn sync(&mut self, disk: &dyn Files, folder: &Path) {
        let synced = disk.sync_folder(folder).map_err(|e| StoreError::io(folder, "sync", &e));
        self.unsynced = self.unsynced.take().or(synced.err());
    }
}

/// The path that the list means; only files and folders of an import are meant by one.
fn below(layout: &Layout, listed: &str) -> Option<PathBuf> {
    let mut parts = Path::new(listed).components();
    let top = parts.next()?;
    let is_plain = |part: Component| matches!(part, Component::Normal(_));
    let ours = ["trials", "sweeps", "sessions"].iter().any(|name| top.as_os_str() == *name);
    (ours && is_plain(top) && parts.all(is_plain)).then(|| layout.raw().join(listed))
}

/// Whether a file belongs to an imported session, or is an imported sweep. No other is an import's
/// to remove.
fn is_imported(disk: &dyn Files, path: &Path) -> bool {
    if path.extension().is_some_and(|e| e == "parquet") {
        return source_of(disk, path).is_some_and(Source::is_imported);
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

/// Where a recording comes from, a trial or else a sweep.
fn source_of(disk: &dyn Files, path: &Path) -> Option<Source> {
    if let Ok(trial) = read_footer_from(disk, path) {
        return Some(trial.meta.source);
    }
    let sweep = ParquetFile::open(disk, path).ok()?;
    Source::from_word(sweep.footer.get("source")?)
}

/// Ends an import in order: its files are whole, and the list goes.
pub fn end(disk: &dyn Files, layout: &Layout) -> Result<(), StoreError> {
    let path = layout.import_list();
    let removed = disk.remove(&path).and_then(|()| disk.sync_folder(folder_of(&path)));
    removed.map_err(|e| StoreError::io(&path, "remove", &e))
}

/// Takes back what an import that was cut short has left: half-written files, and those of its
/// list. The caller holds the study's lock.
///
/// # Errors
/// One each for what could not be removed: it is not what an import wrote, or the disk failed.
pub fn settle(disk: &dyn Files, layout: &Layout) -> Vec<Result<Recovered, StoreError>> {
    let mut found = sweep_unfinished(disk, layout);
    found.extend(take_back_listed(disk, layout));
    found
}

/// Takes back what the list of an import names, if there is one.
pub(crate) fn take_back_listed(
    disk: &dyn Files,
    layout: &Layout,
) -> Vec<Result<Recovered, StoreError>> {
    let path = layout.import_list();
    if disk.kind(&path).is_none() {
        return Vec::new();
    }
    let read = text(disk, &path, MOST_RECORD).and_then(|text| {
        from_json(&text).map_err(|e| {
            let what = format!("not the list of an import: {e}");
            StoreError::new(&path, what, "look at what the last import left, and remove the list")
        })
    });
    let started: Started = match read {
        Ok(started) => started,
        Err(error) => return vec![Err(error)],
    };
    let done = started.take_back(disk, layout);
    let left: Vec<StoreError> = done.left.into_iter().chain(done.unsynced).collect();
    if !left.is_empty() {
        return left.into_iter().map(Err).collect();
    }
    let done = Recovered { path, done: Done::TakenBack { files: done.removed } };
    vec![end(disk, layout).map(|()| done)]
}
