//! The log of a session that is being recorded: read and checked once, then only appended to.
//!
//! The holder of the study's lock is the only writer, but an editor asks for no lock. So before
//! each append the system is asked whether log and head are the files that were left ([`Stamp`]);
//! if not, they are read and checked again, as for a first append. This misses a change that keeps
//! the length and falls within the same step of the system's clock as our own write; the next
//! command that reads the log finds it.

use crate::disk::stamp::Stamp;
use crate::form::events::{chained, count_lines, finished_text, lines_of, write_lines};
use crate::form::head::{check_head, head_of};
use crate::{Entered, Files, StoreError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, QuestionId};

/// A log that is appended to many times.
#[derive(Debug)]
pub(crate) struct OpenLog {
    pub(crate) path: PathBuf,
    /// Nothing before it was read, and after an append that failed: nobody knows then what the log
    /// holds.
    contents: Option<Contents>,
}

/// The contents of a log when it was last read or appended to.
#[derive(Debug)]
pub(crate) struct Contents {
    /// The log and its head, where the system tells whether they change.
    stamps: Option<[Stamp; 2]>,
    digests: Vec<String>,
    /// The hash with which each trial was recorded first.
    pub(crate) recorded: BTreeMap<u32, String>,
    /// The questions of trials that have an answer.
    pub(crate) answered: BTreeSet<(u32, QuestionId)>,
}

impl Contents {
    fn read(files: &dyn Files, path: &Path) -> Result<Self, StoreError> {
        // First: what changes while it is read has another stamp than this one.
        let stamps = stamps(files, path);
        let recorded = BTreeMap::new();
        let answered = BTreeSet::new();
        let mut contents = Self { stamps, digests: Vec::new(), recorded, answered };
        for line in lines_of(path, &finished_text(files, path)?)? {
            contents.add(&line.event);
            contents.digests.push(line.blake3);
        }
        check_head(files, path, &contents.digests)?;
        Ok(contents)
    }

    fn add(&mut self, event: &Event) {
        match event {
            Event::Recorded { trial, blake3 } => {
                self.recorded.entry(*trial).or_insert_with(|| blake3.clone());
            }
            Event::Answer { trial, question, .. } => {
                self.answered.insert((*trial, question.clone()));
            }
            _ => {}
        }
    }
}

impl OpenLog {
    /// The log at a path, which is read when something is asked of it.
    pub(crate) fn new(path: PathBuf) -> Self {
        Self { path, contents: None }
    }

    /// Whether log and head are as this handle read or left them.
    pub(crate) fn is_unchanged(&self, files: &dyn Files) -> bool {
        let before = self.contents.as_ref().and_then(|contents| contents.stamps);
        before.is_some() && before == stamps(files, &self.path)
    }

    /// The log's present contents, read only if they may have changed.
    ///
    /// # Errors
    /// A log that cannot be read to its end, or lost lines by its head.
    pub(crate) fn contents(&mut self, files: &dyn Files) -> Result<&Contents, StoreError> {
        let contents = self.take(files)?;
        Ok(self.contents.insert(contents))
    }

    /// The same, taken out of this handle until they are put back.
    fn take(&mut self, files: &dyn Files) -> Result<Contents, StoreError> {
        let is_unchanged = self.is_unchanged(files);
        match self.contents.take().filter(|_| is_unchanged) {
            Some(contents) => Ok(contents),
            None => Contents::read(files, &self.path),
        }
    }

    /// Appends events in one synced write, as [`crate::append_events`] does.
    ///
    /// # Errors
    /// Those of [`OpenLog::contents`]; the write that failed.
    pub(crate) fn append(
        &mut self,
        files: &dyn Files,
        entered: Entered<'_>,
        events: &[Event],
    ) -> Result<(), StoreError> {
        let mut contents = self.take(files)?;
        let text = chained(&self.path, &mut contents.digests, entered, events)?;
        write_lines(files, &self.path, &text)?;
        count_lines(files, &self.path, &contents.digests);
        events.iter().for_each(|event| contents.add(event));
        let before = contents.stamps.map_or(0, |[log, _]| log.length);
        // A log that is longer than our lines make it was written by somebody else meanwhile.
        contents.stamps =
            stamps(files, &self.path).filter(|[log, _]| log.length == before + text.len() as u64);
        self.contents = Some(contents);
        Ok(())
    }
}

/// The stamps of a log and its head; `None` if the system does not give both.
fn stamps(files: &dyn Files, log: &Path) -> Option<[Stamp; 2]> {
    Some([files.stamp(log)?, files.stamp(&head_of(log))?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::events::read_events_from;
    use crate::{Fault, Memory, Survives, append_events, read_events};

    const UTC: &str = "2026-01-01T00:00:00Z";

    fn note(text: &str) -> Event {
        Event::Note { trial: None, text: text.to_owned() }
    }

    /// A log of two lines, by an open log.
    fn two() -> (Memory, OpenLog) {
        let path = Path::new("/s/P01_S01.events.jsonl");
        let (files, mut log) = (Memory::new(), OpenLog::new(path.to_owned()));
        files.put(Path::new("/s/study.toml"), b"");
        for text in ["one", "two"] {
            log.append(&files, UTC.into(), &[note(text)]).unwrap();
        }
        (files, log)
    }

    fn events(files: &Memory, log: &OpenLog) -> Vec<Event> {
        read_events_from(files, &log.path).unwrap()
    }

    #[test]
    fn nothing_is_read_for_an_append_while_only_this_handle_writes() {
        let (files, mut log) = two();
        let before = files.reads();
        for _ in 0..9 {
            log.append(&files, UTC.into(), &[note("more")]).unwrap();
        }
        assert_eq!(files.reads(), before);
        assert_eq!(events(&files, &log).len(), 11);
        // By their bytes too they are the lines that single appends give.
        let (other, path) = (Memory::new(), log.path.clone());
        other.put(Path::new("/s/study.toml"), b"");
        for event in events(&files, &log) {
            append_events(&other, &path, UTC, &[event]).unwrap();
        }
        assert_eq!(other.below(&path), files.below(&path));
    }

    #[test]
    fn lines_that_somebody_else_appended_are_read_and_followed() {
        let (files, mut log) = two();
        append_events(&files, &log.path, UTC, &[note("theirs")]).unwrap();
        log.append(&files, UTC.into(), &[note("ours")]).unwrap();
        assert_eq!(events(&files, &log), ["one", "two", "theirs", "ours"].map(note));
    }

    #[test]
    fn a_log_or_head_that_was_changed_is_refused_as_by_a_first_append_and_stays() {
        type Damage = fn(&Memory, &Path);
        let damages: [Damage; 5] = [
            |disk, log| {
                let text = String::from_utf8(disk.read(log, 9999).unwrap()).unwrap();
                disk.write_synced(log, text.replace("one", "eno").as_bytes()).unwrap();
            },
            |disk, log| disk.write_synced(log, b"").unwrap(),
            |disk, log| disk.remove(log).unwrap(),
            |disk, log| disk.open_append(log).unwrap().append_synced(b"{\"utc\"").unwrap(),
            |disk, log| disk.write_synced(&head_of(log), b"{}").unwrap(),
        ];
        for damage in damages {
            let (files, mut log) = two();
            damage(&files, &log.path);
            let before = files.below(Path::new("/"));
            let error = log.append(&files, UTC.into(), &[note("more")]).unwrap_err();
            let first = append_events(&files, &log.path, UTC, &[note("more")]).unwrap_err();
            assert_eq!(error, first);
            assert_eq!(files.below(Path::new("/")), before);
            // It is refused again, and goes on when the log is what it was.
            assert_eq!(log.append(&files, UTC.into(), &[]).unwrap_err(), error);
        }
    }

    #[test]
    fn after_an_append_that_failed_the_log_is_read_again() {
        for step in 0..9 {
            let (files, mut log) = two();
            files.fail_in(step, Fault::Full);
            let written = log.append(&files, UTC.into(), &[note("three")]);
            files.restart(Survives::Everything);
            let Err(error) = written else { return };
            assert!(error.remedy.contains("free some space"), "{error}");
            // Half a line is for `recover`; a whole one, or none, is followed.
            crate::keep::mend_log::mend_log(&files, &log.path).unwrap();
            let mut expect = events(&files, &log);
            log.append(&files, UTC.into(), &[note("four")]).unwrap();
            expect.push(note("four"));
            assert_eq!(events(&files, &log), expect, "step {step}");
        }
        panic!("an append has fewer steps");
    }

    #[test]
    fn on_the_real_disk_a_line_that_is_edited_in_place_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("P01_S01.events.jsonl");
        let mut log = OpenLog::new(path.clone());
        for text in ["one", "two"] {
            log.append(&crate::RealFiles, UTC.into(), &[note(text)]).unwrap();
        }
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("one", "enough")).unwrap();
        let error = log.append(&crate::RealFiles, UTC.into(), &[]).unwrap_err();
        assert_eq!(error.row, Some(1), "{error}");
        std::fs::write(&path, &text).unwrap();
        log.append(&crate::RealFiles, UTC.into(), &[note("three")]).unwrap();
        assert_eq!(read_events(&path).unwrap(), ["one", "two", "three"].map(note));
    }
}
