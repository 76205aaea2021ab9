//! The list of a change of several files; it is on the disk until the change is made.

use crate::disk::regular::text;
use crate::form::events::MOST_LOG;
use crate::form::head::counted;
use crate::form::json::from_json;
use crate::form::session_record::MOST_RECORD;
use crate::{Files, Layout, StoreError};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// The files and lines that a change is about to write.
#[derive(Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct List {
    /// The new files in the order in which they are written.
    pub(crate) files: Vec<NewFile>,
    /// The folders that are made for them, outer ones first.
    pub(crate) folders: Vec<String>,
    /// The logs that get lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) logs: Vec<Longer>,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct NewFile {
    /// Below `raw/<study>`, with `/` between folders.
    pub(crate) path: String,
    pub(crate) blake3: String,
}

/// A log that gets lines at its end.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Longer {
    /// Below `raw/<study>`, with `/` between folders.
    pub(crate) path: String,
    /// Bytes of the log before.
    pub(crate) bytes_before: u64,
    /// Lines of the log before.
    pub(crate) lines_before: usize,
    /// Bytes of the new lines.
    pub(crate) bytes: u64,
    /// The first of the new lines, by which they are known.
    pub(crate) first: String,
}

/// How much of the lines that it was to get a log has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stand {
    /// It has none of them.
    Before,
    /// It ends with them, or with a part of them.
    Longer,
    /// Its head counts them, or lines of others follow them.
    Counted,
}

/// The path that the list means; only files and folders that a change writes are meant by one.
pub(crate) fn below(layout: &Layout, listed: &str) -> Option<PathBuf> {
    let mut parts = Path::new(listed).components();
    let top = parts.next()?;
    let ours = ["trials", "sweeps", "sessions", "own", "beside"]
        .iter()
        .any(|name| top.as_os_str() == *name);
    let path = layout.raw().join(listed);
    let is_below = ours && parts.all(|part| matches!(part, Component::Normal(_)));
    (is_below || is_log_beside(layout, &path)).then_some(path)
}

/// Whether a path is that of a log that lies beside the sessions: of sweeps, or of metrics from outside.
fn is_log_beside(layout: &Layout, path: &Path) -> bool {
    path == layout.sweep_events() || path == layout.own_events()
}

pub(crate) fn unknown(layout: &Layout, listed: &str) -> StoreError {
    let what = format!("it lists '{listed}', which no change writes");
    StoreError::new(&layout.unfinished(), what, "look at who wrote it, and remove the list")
}

/// The length in bytes that each log had before a change that was cut short added lines to it.
pub(crate) fn pending(disk: &dyn Files, layout: &Layout) -> BTreeMap<PathBuf, usize> {
    // A list that cannot be read is told by `verify`.
    let list = List::read(disk, &layout.unfinished()).ok().flatten().unwrap_or_default();
    let mut pending = BTreeMap::new();
    for log in &list.logs {
        let (Ok(stand), Ok(path)) = (log.stand(disk, layout), log.place(layout)) else { continue };
        let Ok(bytes) = usize::try_from(log.bytes_before) else { continue };
        match stand {
            Stand::Before => {}
            Stand::Longer => {
                pending.insert(path, bytes);
            }
            // Heads are written last, so the change was made, and all of its lines count.
            Stand::Counted => return BTreeMap::new(),
        }
    }
    pending
}

impl List {
    /// The list that lies at a path; nothing if none does.
    pub(crate) fn read(disk: &dyn Files, path: &Path) -> Result<Option<Self>, StoreError> {
        if disk.kind(path).is_none() {
            return Ok(None);
        }
        from_json(&text(disk, path, MOST_RECORD)?).map(Some).map_err(|e| {
            let what = format!("not the list of a change: {e}");
            StoreError::new(path, what, "look at what the last change left, and remove the list")
        })
    }
}

impl Longer {
    pub(crate) fn place(&self, layout: &Layout) -> Result<PathBuf, StoreError> {
        let path = below(layout, &self.path).filter(|path| {
            is_log_beside(layout, path)
                || path.parent() == Some(layout.sessions().as_path())
                    && path.to_string_lossy().ends_with(".events.jsonl")
        });
        path.ok_or_else(|| unknown(layout, &self.path))
    }

    pub(crate) fn stand(&self, disk: &dyn Files, layout: &Layout) -> Result<Stand, StoreError> {
        let path = self.place(layout)?;
        if disk.kind(&path).is_none() {
            return Ok(Stand::Before);
        }
        let bytes = disk.read(&path, MOST_LOG).map_err(|e| StoreError::io(&path, "read", &e))?;
        let before = usize::try_from(self.bytes_before).unwrap_or(usize::MAX);
        let rest = bytes.get(before..).unwrap_or_default();
        // A line that is whole and another than the first of the change is somebody else's: the
        // change was taken back before, and the log went on. One with a zero byte is not whole: some
        // file systems show zeros where data were not synced.
        let first = rest.split_inclusive(|byte| *byte == b'\n').next().unwrap_or_default();
        let is_whole = first.ends_with(b"\n") && !first.contains(&0);
        Ok(if rest.is_empty() || is_whole && first != self.first.as_bytes() {
            Stand::Before
        } else if rest.len() as u64 > self.bytes || counted(disk, &path) > Some(self.lines_before) {
            Stand::Counted
        } else {
            Stand::Longer
        })
    }
}
