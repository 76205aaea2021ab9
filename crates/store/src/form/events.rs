//! The event log of a session: one JSON object per line, chained by checksums; lines are only ever
//! appended.

use crate::disk::atomic::{create_folders, folder_of};
use crate::disk::regular::{as_text, text};
use crate::form::head::{check_head, head_bytes, head_of, write_head};
use crate::form::json::from_json;
use crate::{Append, Files, RealFiles, StoreError, hex_blake3};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, ExperimenterId};

/// Largest log that is read, bytes: a hundred thousand events and more.
pub(crate) const MOST_LOG: u64 = 1 << 26;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Line {
    /// When it was written, UTC, RFC 3339.
    pub(crate) utc: String,
    /// The code of the person who had it written, if known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) by: Option<ExperimenterId>,
    #[serde(rename = "what")]
    pub(crate) event: Event,
    /// BLAKE3 over the previous line's digest, the time, who, and the event: a changed or missing
    /// line shows.
    pub(crate) blake3: String,
}

/// The data written beside each event: the time, UTC, and the person who caused it, if known.
#[derive(Debug, Clone, Copy)]
pub struct Entered<'a> {
    /// The time in RFC 3339.
    pub utc: &'a str,
    /// The person's code.
    pub by: Option<&'a ExperimenterId>,
}

impl<'a> From<&'a str> for Entered<'a> {
    fn from(utc: &'a str) -> Self {
        Self { utc, by: None }
    }
}

impl<'a> From<&'a String> for Entered<'a> {
    fn from(utc: &'a String) -> Self {
        utc.as_str().into()
    }
}

pub(crate) fn digest(
    previous: &str,
    entered: Entered<'_>,
    event: &Event,
) -> Result<String, serde_json::Error> {
    // A line without a code has the digest that it always had; an event begins with a brace, which
    // no code does.
    let by = entered.by.map(|by| format!("{by}\n")).unwrap_or_default();
    let event = serde_json::to_string(event)?;
    Ok(hex_blake3(format!("{previous}\n{}\n{by}{event}", entered.utc).as_bytes()))
}

/// Appends events in one synced write.
///
/// After a kill meanwhile, each line is whole or recognisably unfinished; [`crate::recover`] then
/// repairs the log. Use [`crate::commit_events`] for lines of which all or none must stay.
///
/// # Errors
/// A log that cannot be read to its end, because nothing may follow a line that is in doubt; the
/// write that failed. Then no line was added.
pub fn append_events<'a>(
    files: &dyn Files,
    path: &Path,
    entered: impl Into<Entered<'a>>,
    events: &[Event],
) -> Result<(), StoreError> {
    let lines = NewLines::of(files, path, entered.into(), events)?;
    write_lines(files, path, &lines.text)?;
    count_lines(files, path, &lines.digests);
    Ok(())
}

/// Lines that are to be added to a log, and how the log was before.
pub(crate) struct NewLines<'a> {
    /// The log.
    pub(crate) path: &'a Path,
    /// The new lines.
    pub(crate) text: String,
    /// Bytes of the log before.
    pub(crate) bytes_before: u64,
    /// Lines of the log before.
    pub(crate) lines_before: usize,
    /// The digests of all lines, the new ones included.
    pub(crate) digests: Vec<String>,
}

impl<'a> NewLines<'a> {
    /// # Errors
    /// A log that cannot be read to its end; an event that JSON cannot hold.
    pub(crate) fn of(
        files: &dyn Files,
        path: &'a Path,
        entered: Entered<'_>,
        events: &[Event],
    ) -> Result<Self, StoreError> {
        let before = finished_text(files, path)?;
        let mut digests = digests_of(path, &before)?;
        check_head(files, path, &digests)?;
        let lines_before = digests.len();
        let text = chained(path, &mut digests, entered, events)?;
        Ok(Self { path, text, bytes_before: before.len() as u64, lines_before, digests })
    }
}

/// Appends these lines in one synced write; the log is given open, so that they can be taken back.
///
/// # Errors
/// The write that failed, after which no line was added.
pub(crate) fn write_lines(
    files: &dyn Files,
    path: &Path,
    text: &str,
) -> Result<Box<dyn Append>, StoreError> {
    let folder = folder_of(path);
    let opened = create_folders(files, folder).and_then(|()| files.open_append(path));
    let mut log = opened.map_err(|e| StoreError::io(path, "append to", &e))?;
    let written = log.append_synced(text.as_bytes()).and_then(|()| files.sync_folder(folder));
    written.map_err(|e| {
        // What cannot be taken back either is an unfinished line, which `recover` cuts off.
        let _ = log.take_back();
        StoreError::io(path, "append to", &e)
    })?;
    Ok(log)
}

/// Writes the head of a log with these digests anew, last: it must never count a line that is not on
/// the disk. One that cannot be written stays behind the log, as after a kill, and the next line
/// counts for both.
pub(crate) fn count_lines(files: &dyn Files, path: &Path, digests: &[String]) {
    let _ = write_head(files, path, digests);
}

/// The lines of events that follow the lines with these digests, to which theirs are added.
pub(crate) fn chained(
    path: &Path,
    digests: &mut Vec<String>,
    entered: Entered<'_>,
    events: &[Event],
) -> Result<String, StoreError> {
    let mut text = String::new();
    for event in events {
        let previous = digests.last().map(String::as_str).unwrap_or_default();
        let blake3 = digest(previous, entered, event).map_err(|e| StoreError::defect(path, &e))?;
        let utc = entered.utc.to_owned();
        let by = entered.by.cloned();
        let line = Line { utc, by, event: event.clone(), blake3: blake3.clone() };
        text += &serde_json::to_string(&line).map_err(|e| StoreError::defect(path, &e))?;
        text.push('\n');
        digests.push(blake3);
    }
    Ok(text)
}

/// A new log of these events and its head, as files to write in this order.
///
/// # Errors
/// An event that JSON cannot hold.
pub fn new_log(
    path: &Path,
    utc: &str,
    events: &[Event],
) -> Result<Vec<(PathBuf, Vec<u8>)>, StoreError> {
    let mut digests = Vec::new();
    let text = chained(path, &mut digests, utc.into(), events)?;
    let head = head_bytes(path, &digests)?.map(|head| (head_of(path), head));
    Ok(std::iter::once((path.to_owned(), text.into_bytes())).chain(head).collect())
}

/// The text of a log to which lines can be appended. A missing log has none.
///
/// # Errors
/// A last line that is not finished.
pub(crate) fn finished_text(files: &dyn Files, path: &Path) -> Result<String, StoreError> {
    if files.kind(path).is_none() {
        return Ok(String::new());
    }
    let text = text(files, path, MOST_LOG)?;
    if !text.is_empty() && !text.ends_with('\n') {
        let what = "the last line is not finished: it has no line feed";
        let remedy = "run `zwidth recover`, which brings the end of the log in order";
        return Err(StoreError::new(path, what, remedy));
    }
    Ok(text)
}

/// The digests of a log's lines.
pub(crate) fn digests_of(path: &Path, text: &str) -> Result<Vec<String>, StoreError> {
    Ok(lines_of(path, text)?.into_iter().map(|line| line.blake3).collect())
}

/// The events of a log, in order. A missing log has no lines.
///
/// # Errors
/// A line that is not JSON, an unknown event, a checksum that does not follow from the line before;
/// lines that the log's head counts and that are gone.
pub fn read_events(path: &Path) -> Result<Vec<Event>, StoreError> {
    read_events_from(&RealFiles, path)
}

pub(crate) fn read_events_from(files: &dyn Files, path: &Path) -> Result<Vec<Event>, StoreError> {
    read_events_to(files, path, None)
}

/// The events of a log up to so many bytes: those after them belong to a change that was not made.
pub(crate) fn read_events_to(
    files: &dyn Files,
    path: &Path,
    most: Option<usize>,
) -> Result<Vec<Event>, StoreError> {
    Ok(read_lines_to(files, path, most)?.into_iter().map(|line| line.event).collect())
}

/// The same with the time of each, and who had it written.
pub(crate) fn read_lines_to(
    files: &dyn Files,
    path: &Path,
    most: Option<usize>,
) -> Result<Vec<Line>, StoreError> {
    let mut bytes = match files.kind(path) {
        Some(_) => files.read(path, MOST_LOG).map_err(|e| StoreError::io(path, "read", &e))?,
        None => Vec::new(),
    };
    bytes.truncate(most.unwrap_or(bytes.len()));
    let text = as_text(path, bytes)?;
    let lines = lines_of(path, &text)?;
    let digests: Vec<String> = lines.iter().map(|line| line.blake3.clone()).collect();
    check_head(files, path, &digests)?;
    Ok(lines)
}

pub(crate) fn lines_of(path: &Path, text: &str) -> Result<Vec<Line>, StoreError> {
    let mut previous = String::new();
    let mut lines = Vec::new();
    for (row, json) in text.lines().enumerate() {
        let line: Line = from_json(json)
            .map_err(|e| unreadable(path, row, format!("not a readable event: {e}")))?;
        let entered = Entered { utc: &line.utc, by: line.by.as_ref() };
        let expected = digest(&previous, entered, &line.event)
            .map_err(|e| unreadable(path, row, e.to_string()))?;
        if line.blake3 != expected {
            let what = "the checksum does not match: a line was changed or is missing";
            return Err(unreadable(path, row, what.to_owned()));
        }
        previous.clone_from(&line.blake3);
        lines.push(line);
    }
    Ok(lines)
}

fn unreadable(path: &Path, row: usize, what: String) -> StoreError {
    let remedy =
        "restore the log from a copy; if its last line was cut by a crash, run `zwidth recover`";
    StoreError::new(path, what, remedy).row0(row)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::keep::mend_log::{mend_head, mend_log};
    use crate::{Done, Fault, Memory, Survives};
    use std::fs;

    const UTC: &str = "2026-01-01T00:00:00Z";

    fn log() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("P01_S01.events.jsonl");
        let excluded = Event::Excluded { trial: 2, reason: "the phone rang".into() };
        append_events(&RealFiles, &path, UTC, &[Event::Superseded { trial: 1, by: 7 }, excluded])
            .unwrap();
        let note = Event::Note { trial: None, text: "the end".into() };
        append_events(&RealFiles, &path, UTC, &[note]).unwrap();
        (folder, path)
    }

    #[test]
    fn events_come_back_in_order() {
        let (_folder, path) = log();
        let events = read_events(&path).unwrap();
        assert_eq!(events.len(), 3);
        assert!(matches!(events[2], Event::Note { .. }));
    }

    #[test]
    fn who_had_a_line_written_is_part_of_what_its_checksum_keeps() {
        let (_folder, path) = log();
        let by = ExperimenterId::new("E1").unwrap();
        let entered = Entered { utc: UTC, by: Some(&by) };
        let answer = Event::Note { trial: Some(1), text: "once more".into() };
        append_events(&RealFiles, &path, entered, std::slice::from_ref(&answer)).unwrap();
        assert_eq!(read_events(&path).unwrap().last(), Some(&answer));
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.lines().last().unwrap().contains(r#""by":"E1""#), "{text}");
        for other in ["\"E2\"", "null"] {
            fs::write(&path, text.replace("\"E1\"", other)).unwrap();
            assert_eq!(read_events(&path).unwrap_err().row, Some(4), "{other}");
        }
    }

    /// The time of a line is kept as it was written, and nothing is computed with it.
    #[test]
    fn a_line_of_any_time_is_read() {
        let (_folder, path) = log();
        let note = Event::Note { trial: None, text: "a moment".into() };
        let times = [
            "0001-01-01T00:00:00Z",
            "-009999-01-01T00:00:00-25:59",
            "9999-12-31T23:59:59.999999999Z",
            "9999-12-31T23:59:60+23:59",
            "10000-01-01T00:00:00Z",
            "2016-12-31T23:59:60Z",
            "no time",
            "",
        ];
        for utc in times {
            append_events(&RealFiles, &path, utc, std::slice::from_ref(&note)).unwrap();
        }
        assert_eq!(read_events(&path).unwrap().len(), 3 + times.len());
    }

    #[test]
    fn a_changed_a_missing_and_a_cut_line_are_noticed() {
        let (_folder, path) = log();
        let text = fs::read_to_string(&path).unwrap();
        let second_missing =
            text.lines().enumerate().filter(|(i, _)| *i != 1).map(|(_, l)| l).collect::<Vec<_>>();
        for (bad, row) in [
            (text.replace("phone", "clock"), 2),
            (second_missing.join("\n"), 2),
            (text[..text.len() - 9].to_owned(), 3),
        ] {
            fs::write(&path, bad).unwrap();
            assert_eq!(read_events(&path).unwrap_err().row, Some(row));
        }
    }

    #[test]
    fn nothing_is_appended_to_a_line_without_its_end() {
        let (_folder, path) = log();
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.trim_end()).unwrap();
        let error = append_events(&RealFiles, &path, UTC, &[]).unwrap_err();
        assert!(error.remedy.contains("zwidth recover"), "{error}");
        mend_log(&RealFiles, &path).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
    }

    #[test]
    fn a_log_that_lost_whole_lines_or_is_gone_or_another_is_noticed_and_nothing_is_appended_to_it()
    {
        let (folder, path) = log();
        let text = fs::read_to_string(&path).unwrap();
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        let other = folder.path().join("other/P01_S01.events.jsonl");
        let notes: Vec<Event> =
            (0..3).map(|i| Event::Note { trial: None, text: i.to_string() }).collect();
        append_events(&RealFiles, &other, UTC, &notes).unwrap();
        for (bad, words) in [
            (lines[..2].concat(), "has 2 lines where its head counts 3"),
            (String::new(), "has 0 lines where its head counts 3"),
            (fs::read_to_string(&other).unwrap(), "not the one that its head belongs to"),
        ] {
            fs::write(&path, &bad).unwrap();
            let error = read_events(&path).unwrap_err();
            assert!(error.what.contains(words), "{error}");
            assert_eq!(append_events(&RealFiles, &path, UTC, &notes).unwrap_err(), error);
            assert_eq!(mend_head(&RealFiles, &path), Err(error));
            assert_eq!(fs::read_to_string(&path).unwrap(), bad);
        }
        fs::remove_file(&path).unwrap();
        assert!(read_events(&path).unwrap_err().what.contains("has 0 lines"));
    }

    #[test]
    fn a_head_that_a_kill_left_behind_is_no_finding_and_is_brought_in_order() {
        let (_folder, path) = log();
        let head = fs::read(head_of(&path)).unwrap();
        append_events(&RealFiles, &path, UTC, &[Event::Note { trial: None, text: "more".into() }])
            .unwrap();
        let newer = fs::read(head_of(&path)).unwrap();
        fs::write(head_of(&path), &head).unwrap();
        assert_eq!(read_events(&path).unwrap().len(), 4);
        assert_eq!(mend_head(&RealFiles, &path), Ok(true));
        assert_eq!(fs::read(head_of(&path)).unwrap(), newer);
        assert_eq!(mend_head(&RealFiles, &path), Ok(false));
    }

    #[test]
    fn an_append_of_several_lines_of_which_any_sector_is_missing_is_cut_off_and_no_counted_line_is()
    {
        let path = Path::new("/s/P01_S01.events.jsonl");
        let note = |i: usize| Event::Note { trial: None, text: format!("{i} {}", "x".repeat(150)) };
        let mut cut = 0;
        for seed in 0..200 {
            let disk = Memory::new();
            disk.put(Path::new("/s/study.toml"), b"");
            let before: Vec<Event> = (0..3).map(note).collect();
            append_events(&disk, path, UTC, &before).unwrap();
            // The file is open and written to, and not synced.
            disk.fail_in(2, Fault::End);
            let more: Vec<Event> = (3..9).map(note).collect();
            append_events(&disk, path, UTC, &more).unwrap_err();
            disk.restart(Survives::Torn(seed));
            let done = mend_log(&disk, path).unwrap();
            cut += usize::from(matches!(done, Some(Done::Cut(_))));
            mend_head(&disk, path).unwrap();
            let events = read_events_from(&disk, path).unwrap();
            assert!(events.len() >= 3 && (0..9).map(note).take(events.len()).eq(events), "{seed}");
        }
        assert!(cut > 100, "{cut}");
    }

    #[test]
    fn a_line_that_the_head_counts_is_not_cut_off_with_what_follows_it() {
        let path = Path::new("/s/P01_S01.events.jsonl");
        let disk = Memory::new();
        disk.put(Path::new("/s/study.toml"), b"");
        let notes = ["one", "two", "three"];
        let notes = notes.map(|text| Event::Note { trial: None, text: text.into() });
        append_events(&disk, path, UTC, &notes).unwrap();
        let text = disk.below(path).remove(path).unwrap();
        let second = text.iter().position(|byte| *byte == b'\n').unwrap() + 5;
        let damaged = [&text[..second], &[0; 20], &text[second + 20..]].concat();
        disk.put(path, &damaged);
        assert_eq!(mend_log(&disk, path).unwrap_err().row, Some(2));
        assert_eq!(disk.below(path).remove(path).unwrap(), damaged);
    }

    #[test]
    fn a_missing_log_has_no_events() {
        assert_eq!(read_events(Path::new("/nonexistent/x.jsonl")), Ok(vec![]));
    }
}
