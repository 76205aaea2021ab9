//! The head of a log: how many lines it has, and the digest of the last, in a file of its own.
//!
//! A log that was cut at the end of a line looks whole; only something outside the log can reveal
//! the cut. The head is written after the lines that it counts are safe on the disk, so it may be
//! behind the log (after a kill in between), but never ahead of it.

use crate::disk::regular::text;
use crate::form::json::from_json;
use crate::{Files, StoreError, replace};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Longest head, bytes.
const MOST_HEAD: u64 = 1 << 12;

/// The contents of a log's head.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Head {
    /// Lines of the log.
    pub(crate) lines: usize,
    /// The digest of the last of them.
    pub(crate) blake3: String,
}

/// Where the head of a log lies.
pub(crate) fn head_of(log: &Path) -> PathBuf {
    log.with_extension("head")
}

/// Writes the head of a log with these digests of its lines.
pub(crate) fn write_head(
    files: &dyn Files,
    log: &Path,
    digests: &[String],
) -> Result<(), StoreError> {
    head_bytes(log, digests)?.map_or(Ok(()), |bytes| replace(files, &head_of(log), &bytes))
}

/// The bytes of the head of a log with these digests of its lines; an empty log has no head.
pub(crate) fn head_bytes(log: &Path, digests: &[String]) -> Result<Option<Vec<u8>>, StoreError> {
    let Some(blake3) = digests.last().cloned() else { return Ok(None) };
    let text = serde_json::to_string(&Head { lines: digests.len(), blake3 })
        .map_err(|e| StoreError::defect(&head_of(log), &e))?;
    Ok(Some((text + "\n").into_bytes()))
}

/// How many lines the head of a log counts; nothing where there is no head, or none to be read.
pub(crate) fn counted(files: &dyn Files, log: &Path) -> Option<usize> {
    let head: Head = from_json(&text(files, &head_of(log), MOST_HEAD).ok()?).ok()?;
    Some(head.lines)
}

/// Holds a log, by the digests of its lines, against its head. Whether the head is to be written
/// anew: there is none, or it counts fewer lines.
///
/// # Errors
/// Lines that are gone, or another log than the head's; a head that cannot be read.
pub(crate) fn check_head(
    files: &dyn Files,
    log: &Path,
    digests: &[String],
) -> Result<bool, StoreError> {
    let path = head_of(log);
    if files.kind(&path).is_none() {
        return Ok(true);
    }
    let text = text(files, &path, MOST_HEAD)?;
    let remedy = "restore the log and its head from a copy";
    let head: Head = from_json(&text)
        .map_err(|e| StoreError::new(&path, format!("not the head of a log: {e}"), remedy))?;
    let lines = digests.len();
    if lines < head.lines {
        let what = format!(
            "the log has {lines} lines where its head counts {}: the others are gone",
            head.lines
        );
        return Err(StoreError::new(log, what, remedy));
    }
    if head.lines.checked_sub(1).and_then(|last| digests.get(last)) != Some(&head.blake3) {
        let what = "the log is not the one that its head belongs to: a line was changed, or the log was replaced";
        return Err(StoreError::new(log, what, remedy));
    }
    Ok(lines > head.lines)
}
