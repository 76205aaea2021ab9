//! Repairs the end of a log and its head after a kill or a power cut.

use crate::disk::atomic::sync_file;
use crate::form::events::{Entered, Line, MOST_LOG, digest, digests_of, finished_text, lines_of};
use crate::form::head::{check_head, counted, write_head};
use crate::form::json::from_json;
use crate::keep::recovered::Done;
use crate::{Files, StoreError, replace};
use std::path::Path;

/// Writes a log's head anew where it is behind the log, and says whether it was.
///
/// # Errors
/// A log that lost lines by its head, or is another.
pub(crate) fn mend_head(files: &dyn Files, path: &Path) -> Result<bool, StoreError> {
    // A line in doubt is an error of whoever reads the log.
    let read = finished_text(files, path).and_then(|text| digests_of(path, &text));
    let Ok(digests) = read else { return Ok(false) };
    let behind = check_head(files, path, &digests)? && !digests.is_empty();
    if behind {
        // The head must not outlive the lines that it counts.
        sync_file(files, path).map_err(|e| StoreError::io(path, "sync", &e))?;
        write_head(files, path, &digests)?;
    }
    Ok(behind)
}

/// Brings the end of a log in order after a kill or a power cut.
///
/// An append ends with a line feed, so a last line without one was never finished: it is cut off,
/// or gets its line feed if it is whole. So is one with a zero byte, which no line of ours has:
/// some file systems show zeros where data were not synced, and of an append of several lines any
/// of its sectors may be missing. What the head counts was synced: with one such line in doubt, as
/// with any other, the log stays as it is, and is an error of whoever reads it.
pub(crate) fn mend_log(files: &dyn Files, path: &Path) -> Result<Option<Done>, StoreError> {
    let bytes = files.read(path, MOST_LOG).map_err(|e| StoreError::io(path, "read", &e))?;
    let lines: Vec<&[u8]> = bytes.split_inclusive(|b| *b == b'\n').collect();
    let (Some(last), whole) = (lines.last(), whole_lines(&lines)) else { return Ok(None) };
    if whole == lines.len() {
        if last.ends_with(b"\n") {
            return Ok(None);
        }
        replace(files, path, &[&bytes, b"\n".as_slice()].concat())?;
        return Ok(Some(Done::Ended));
    }
    let before = lines[..whole].concat();
    let tail = lines[whole..].concat();
    if tail.ends_with(b"\n") && !tail.contains(&0) {
        return Ok(None);
    }
    let is_uncounted = counted(files, path).is_some_and(|lines| lines <= whole);
    if whole + 1 < lines.len() && !is_uncounted {
        lines_of(path, &String::from_utf8_lossy(&bytes))?;
    }
    let cut = String::from_utf8_lossy(&tail);
    let cut = cut.trim_end_matches(['\0', '\n']).replace(['\0', '\n'], " ");
    replace(files, path, &before)?;
    Ok(Some(Done::Cut(cut)))
}

/// The number of lines at the beginning of a log that are whole and follow each other.
fn whole_lines(lines: &[&[u8]]) -> usize {
    let mut previous = String::new();
    for (whole, line) in lines.iter().enumerate() {
        let Ok(Ok(line)) = std::str::from_utf8(line).map(|line| from_json::<Line>(line.trim_end()))
        else {
            return whole;
        };
        let entered = Entered { utc: &line.utc, by: line.by.as_ref() };
        if !digest(&previous, entered, &line.event).is_ok_and(|digest| digest == line.blake3) {
            return whole;
        }
        previous = line.blake3;
    }
    lines.len()
}
