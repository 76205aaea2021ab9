//! The journal: a trial's samples are safe on the disk while it runs.
//!
//! One file per trial in progress, made of checksummed frames ([`crate::frame`]): the trial's
//! metadata, then rows as they come, then the end. Each append is synced before it returns, so a
//! power cut loses no more than the batch that was being written. A finished trial becomes a
//! Parquet file, and its journal is removed last.

use crate::disk::atomic::{create_folders, folder_of};
use crate::form::frame::{Chain, Frame, Header, MAGIC, MOST_ROWS, Protocol, encode};
use crate::form::journaled::{DAMAGED, Journaled, read_journal};
use crate::keep::open_session::OpenSession;
use crate::keep::record::Ended;
use crate::{Append, Entered, Files, Layout, Samples, StoreError, Trial, TrialFile};
use std::path::{Path, PathBuf};
use zwidth_study::{Given, ParticipantId, Sample, SessionId, TrialMeta};

/// The journal of the trial in progress.
pub struct Journal {
    participant: ParticipantId,
    session: SessionId,
    path: PathBuf,
    file: Box<dyn Append>,
    chain: Chain,
    /// Time of the last row, s.
    last_s: f64,
    /// An append has failed: what follows it could not be read.
    broken: bool,
}

impl Journal {
    /// Begins the journal of a trial. `meta.status` and `meta.likert` do not matter: they are known
    /// at the end.
    ///
    /// # Errors
    /// The trial is there already, as a file or as a journal; a write that failed.
    pub fn create(
        files: &dyn Files,
        layout: &Layout,
        meta: &TrialMeta,
        file: &TrialFile,
        protocol: &Protocol,
    ) -> Result<Self, StoreError> {
        let path = layout.journal(&meta.participant, &meta.session, meta.trial);
        let trial = layout.trial(&meta.participant, &meta.session, meta.trial);
        for (existing, remedy) in [
            (&trial, "finished files never change; do the trial again under a number of its own"),
            (&path, "an earlier run was cut short; run `zwidth recover` first"),
        ] {
            if files.kind(existing).is_some() {
                let what = format!("trial {} is there already", meta.trial);
                return Err(StoreError::new(existing, what, remedy));
            }
        }
        let folder = folder_of(&path);
        let opened = create_folders(files, folder).and_then(|()| files.open_append(&path));
        let handle = opened.map_err(|e| StoreError::io(&path, "create the journal", &e))?;
        let mut journal = Self {
            participant: meta.participant.clone(),
            session: meta.session.clone(),
            path: path.clone(),
            file: handle,
            chain: Chain::default(),
            last_s: f64::NEG_INFINITY,
            broken: false,
        };
        let meta = meta.clone();
        let file = file.clone();
        let protocol = protocol.clone();
        journal.write(&Frame::Header(Header { meta, file, protocol }), MAGIC)?;
        // A file is no safer than its name.
        files.sync_folder(folder).map_err(|e| StoreError::io(folder, "sync the folder", &e))?;
        Ok(journal)
    }

    /// Appends rows as one frame, or as a few if there are many rows; when it returns they are safe
    /// on the disk.
    ///
    /// # Errors
    /// A row that no trial file can hold (a value that is not finite, time that does not run
    /// forward), with its column and its place among `rows`: the rows before it are kept. A
    /// write that failed: nothing can be appended after it.
    pub fn append(&mut self, rows: &[Sample]) -> Result<(), StoreError> {
        if rows.is_empty() {
            return Ok(());
        }
        let problem = self.check(rows).err();
        // An error counts rows from 1.
        let good = problem.as_ref().and_then(|p| p.row).map_or(rows.len(), |row| row - 1);
        for rows in rows[..good].chunks(MOST_ROWS) {
            self.write(&Frame::Rows(rows.to_vec()), &[])?;
            self.last_s = rows.last().map_or(self.last_s, |last| last.t_s);
        }
        problem.map_or(Ok(()), Err)
    }

    fn check(&self, rows: &[Sample]) -> Result<(), StoreError> {
        if rows[0].t_s <= self.last_s {
            let what = format!(
                "time runs backwards or stands still: {} s after {} s",
                rows[0].t_s, self.last_s
            );
            return Err(StoreError::new(&self.path, what, "check the clock").column("t_s").row0(0));
        }
        // Apart from the samples, which have no column for the device's channels here.
        let mut channels = rows.iter().map(|row| row.extra.values());
        if let Some(row) = channels.position(|values| values.iter().any(|v| !v.is_finite())) {
            let what = "a value of one of the device's channels is not a finite number";
            let remedy = "check the sensor of that channel and its cable";
            return Err(StoreError::new(&self.path, what, remedy).row0(row));
        }
        Samples::from_rows(rows).check(&self.path)
    }

    /// The trial as far as it was appended; none before its first row.
    ///
    /// # Errors
    /// A read that failed.
    pub fn trial(&self, files: &dyn Files) -> Result<Option<Trial>, StoreError> {
        Ok(read_journal(files, &self.path)?.trial().map(|(trial, _)| trial))
    }

    /// The trial has run to its end. Without it, [`Journal::finish`] and [`crate::recover`] make it
    /// `incomplete`.
    ///
    /// # Errors
    /// A write that failed.
    pub fn end(&mut self) -> Result<(), StoreError> {
        self.write(&Frame::End, &[])
    }

    /// Makes the trial a finished file, with the answer to its question, and removes the journal.
    /// The path of the file; `None` if the trial has no row, so that there is nothing to keep.
    ///
    /// # Errors
    /// A write that failed: the journal is still there then, and [`crate::recover`] goes on where
    /// this stopped.
    pub fn finish<'a>(
        self,
        files: &dyn Files,
        layout: &Layout,
        likert: Option<Given>,
        entered: impl Into<Entered<'a>>,
    ) -> Result<Option<PathBuf>, StoreError> {
        let mut session = OpenSession::new(layout, &self.participant, &self.session);
        self.finish_in(files, &mut session, likert, entered)
    }

    /// The same for a session with many recorded trials.
    ///
    /// # Errors
    /// Those of [`Journal::finish`].
    pub fn finish_in<'a>(
        mut self,
        files: &dyn Files,
        session: &mut OpenSession,
        likert: Option<Given>,
        entered: impl Into<Entered<'a>>,
    ) -> Result<Option<PathBuf>, StoreError> {
        if let Some(answer) = likert {
            self.write(&Frame::Answer(answer), &[])?;
        }
        let Self { path, file, broken, .. } = self;
        drop(file); // before the file is removed: not every system removes an open one
        let mut read = read_journal(files, &path)?;
        if !broken {
            // Each append was synced: what cannot be read of one is no append that was cut short.
            read.damaged += std::mem::take(&mut read.unfinished);
        }
        // From the journal, not from memory: what is kept is what `recover` would have made.
        let written = match read.trial() {
            None => None,
            Some((trial, protocol)) => {
                let answer_time_ms = read.time_ms();
                let ended = Ended { trial: &trial, protocol: &protocol, answer_time_ms };
                Some(session.record(files, entered.into(), &ended)?)
            }
        };
        clear(files, &path, &read)?;
        Ok(written)
    }

    fn write(&mut self, frame: &Frame, before: &[u8]) -> Result<(), StoreError> {
        if self.broken {
            let what = "an earlier write failed, so that nothing can be appended";
            let remedy = "end the trial, then run `zwidth recover`";
            return Err(StoreError::new(&self.path, what, remedy));
        }
        let (bytes, chain) =
            encode(frame, self.chain).map_err(|e| StoreError::defect(&self.path, &e))?;
        let written = self.file.append_synced(&[before, &bytes].concat());
        self.broken = written.is_err();
        self.chain = chain;
        written.map_err(|e| StoreError::io(&self.path, "append to the journal", &e))
    }
}

/// Removes a journal whose trial is safe; one with bytes of which nothing could be made gets
/// another name and stays.
///
/// # Errors
/// A removal that failed; a journal that stays, with where it lies now.
pub(crate) fn clear(files: &dyn Files, path: &Path, read: &Journaled) -> Result<(), StoreError> {
    let folder = folder_of(path);
    // Rows without a header are of an unknown trial: they are not to go with the journal.
    let is_all = read.damaged == 0 && (read.header.is_some() || read.rows.is_empty());
    if is_all {
        let removed = files.remove(path).and_then(|()| files.sync_folder(folder));
        return removed.map_err(|e| StoreError::io(path, "remove the journal", &e));
    }
    let aside = free_name(files, path);
    let moved = files.rename(path, &aside).and_then(|()| files.sync_folder(folder));
    moved.map_err(|e| StoreError::io(path, "rename", &e))?;
    let rows = read.rows.len();
    if read.header.is_none() {
        let what = format!(
            "the journal is damaged where it says whose trial it is; {rows} rows are whole"
        );
        let remedy = "no trial was made of it: do the trial again, and keep this file";
        return Err(StoreError::new(&aside, what, remedy));
    }
    let damaged = read.damaged;
    let what =
        format!("the journal is damaged: {rows} rows are whole, {damaged} bytes cannot be read");
    let remedy = "the rows are kept as a trial; remove this file when nobody needs it";
    Err(StoreError::new(&aside, what, remedy))
}

/// A name beside `path` that no file has: what is set aside never takes the place of what was set
/// aside before.
fn free_name(files: &dyn Files, path: &Path) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(DAMAGED);
    let first = path.with_file_name(&name);
    let numbered = (2_u32..).map(|n| {
        let mut name = name.clone();
        name.push(format!("-{n}"));
        path.with_file_name(name)
    });
    let mut names = std::iter::once(first.clone()).chain(numbered);
    names.find(|path| files.kind(path).is_none()).unwrap_or(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::SECTOR;
    use crate::tests::crashes::{UTC, ended, folder_with_study, meta, protocol, rows};
    use crate::{Fault, Memory, RealFiles, Signal, Survives, read_trial};
    use zwidth_study::{Kind, Status};

    fn create(layout: &Layout, trial: u32) -> Result<Journal, StoreError> {
        let file = [("device".to_owned(), "none".to_owned())].into();
        Journal::create(&RealFiles, layout, &meta(trial), &file, &protocol())
    }

    /// A study in memory.
    fn in_memory() -> (Memory, Layout) {
        let layout = Layout::new(Path::new("/root"), "demo".parse().unwrap());
        let disk = Memory::new();
        disk.put(&layout.study_toml(), b"");
        (disk, layout)
    }

    #[test]
    fn a_finished_trial_is_a_file_with_its_answer_and_no_journal() {
        let (_folder, layout) = folder_with_study();
        let mut journal = create(&layout, 1).unwrap();
        journal.append(&rows(0, 100)).unwrap();
        journal.append(&[]).unwrap();
        journal.append(&rows(100, 20)).unwrap();
        journal.end().unwrap();
        let path = journal
            .finish(&RealFiles, &layout, Some(Given { value: 5, time_ms: None }), UTC)
            .unwrap()
            .unwrap();
        let trial = read_trial(&path, Signal::all()).unwrap();
        assert_eq!(trial.meta, meta(1));
        let log = layout.events(&meta(1).participant, &meta(1).session);
        let question = "felt_spring".parse().unwrap();
        let answer =
            zwidth_study::Event::Answer { trial: 1, question, value: 5.into(), time_ms: None };
        assert_eq!(crate::read_events(&log).unwrap().last(), Some(&answer));
        let expect = Samples::from_rows(&rows(0, 120));
        assert_eq!(trial.samples.get(Signal::Theta), expect.get(Signal::Theta));
        assert_eq!(trial.file["device"], "none");
        assert_eq!(std::fs::read_dir(layout.journals()).unwrap().count(), 0);
    }

    #[test]
    fn without_its_end_a_trial_is_incomplete() {
        let (_folder, layout) = folder_with_study();
        let mut journal = create(&layout, 1).unwrap();
        journal.append(&rows(0, 7)).unwrap();
        let path = journal.finish(&RealFiles, &layout, None, UTC).unwrap().unwrap();
        let trial = read_trial(&path, []).unwrap();
        assert_eq!((trial.meta.status, trial.meta.likert), (Status::Incomplete, None));
        assert_eq!(trial.meta.kind, Kind::Trial);
    }

    #[test]
    fn a_trial_without_a_sample_leaves_nothing() {
        let (_folder, layout) = folder_with_study();
        let journal = create(&layout, 1).unwrap();
        assert_eq!(journal.finish(&RealFiles, &layout, None, UTC), Ok(None));
        assert_eq!(crate::verify(&layout), []);
    }

    #[test]
    fn a_row_that_no_file_can_hold_is_refused_and_those_before_it_are_kept() {
        for (damage, words) in [
            (
                (|r: &mut Sample| r.force_ex_n = f64::NAN) as fn(&mut Sample),
                "column force_ex_n, row 4: NaN",
            ),
            (|r| r.t_s = 0.0, "column t_s, row 4: time runs backwards"),
            (|r| r.voltages.motor_v = 1e39, "column voltage_motor_v, row 4"),
        ] {
            let (_folder, layout) = folder_with_study();
            let mut journal = create(&layout, 1).unwrap();
            let mut bad = rows(0, 6);
            damage(&mut bad[3]);
            let error = journal.append(&bad).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
            let late = journal.append(&rows(2, 1)).unwrap_err();
            let words = "row 1: time runs backwards or stands still";
            assert!(late.to_string().contains(words), "{late}");
            journal.append(&rows(3, 2)).unwrap();
            let path = journal.finish(&RealFiles, &layout, None, UTC).unwrap().unwrap();
            assert_eq!(read_trial(&path, []).unwrap().samples.len(), 5);
        }
    }

    #[test]
    fn a_trial_that_is_there_is_not_begun_again() {
        let (_folder, layout) = folder_with_study();
        let mut journal = create(&layout, 1).unwrap();
        let error = create(&layout, 1).err().unwrap();
        assert!(error.remedy.contains("zwidth recover"), "{error}");
        journal.append(&rows(0, 1)).unwrap();
        journal.finish(&RealFiles, &layout, None, UTC).unwrap();
        let error = create(&layout, 1).err().unwrap();
        assert!(error.remedy.contains("a number of its own"), "{error}");
    }

    #[test]
    fn after_a_write_that_failed_nothing_is_appended_behind_it() {
        let (disk, layout) = in_memory();
        // Folder and its name, the open file, the header's two steps, the folder: then the first
        // rows fail.
        disk.fail_in(6, Fault::End);
        let mut journal =
            Journal::create(&disk, &layout, &meta(1), &TrialFile::new(), &Protocol::default())
                .unwrap();
        assert!(journal.append(&rows(0, 3)).is_err());
        disk.restart(Survives::Everything);
        let error = journal.append(&rows(3, 3)).unwrap_err();
        assert!(error.remedy.contains("zwidth recover"), "{error}");
    }

    #[test]
    fn of_an_append_that_a_power_cut_ended_any_sectors_may_be_missing_and_it_is_no_damage() {
        // The header, or rows of several sectors: written, and not synced.
        for steps in [4, 6] {
            for seed in 0..200 {
                let (disk, layout) = in_memory();
                disk.fail_in(steps, Fault::End);
                let file = [("device".to_owned(), "x".repeat(900))].into();
                let begun = Journal::create(&disk, &layout, &meta(1), &file, &protocol());
                let appended = begun.and_then(|mut journal| journal.append(&rows(0, 30)));
                assert!(appended.is_err());
                disk.restart(Survives::Torn(seed));
                let path = layout.journal(&meta(1).participant, &meta(1).session, 1);
                if disk.kind(&path).is_none() {
                    continue;
                }
                let read = read_journal(&disk, &path).unwrap_or_else(|e| panic!("{seed}: {e}"));
                assert_eq!(read.damaged, 0, "{seed}");
                assert!([0, 30].contains(&read.rows.len()), "{seed}");
                assert!(steps < 6 || read.header.is_some(), "{seed}");
            }
        }
    }

    #[test]
    fn a_journal_that_lost_a_sector_of_what_was_synced_is_kept_and_its_trial_is_incomplete() {
        for (lost, words) in [
            ("the end", "the journal is damaged"),
            ("the first sector", "not a journal of this version"),
        ] {
            let (disk, layout) = in_memory();
            let journal = ended(&disk, &layout, 30);
            let path = layout.journal(&meta(1).participant, &meta(1).session, 1);
            let mut bytes = disk.below(&path).remove(&path).unwrap();
            let last = (bytes.len() - 1) / SECTOR * SECTOR;
            let sector = if lost == "the end" { last..bytes.len() } else { 0..SECTOR };
            bytes[sector].fill(0);
            disk.put(&path, &bytes);
            let error = journal.finish(&disk, &layout, None, UTC).unwrap_err();
            assert!(error.what.contains(words), "{lost}: {error}");
            assert_eq!(disk.below(&layout.journals()).into_values().collect::<Vec<_>>(), [bytes]);
            let trial = layout.trial(&meta(1).participant, &meta(1).session, 1);
            if disk.kind(&trial).is_some() {
                let kept = crate::form::read::read_whole_trial(&disk, &trial).unwrap();
                assert_eq!(kept.meta.status, Status::Incomplete, "{lost}");
            }
        }
    }

    #[test]
    fn a_journal_stays_until_its_file_reads_as_it_was_written() {
        let mut refused = 0;
        for seed in 0..60 {
            let (disk, layout) = in_memory();
            let journal = ended(&disk, &layout, 30);
            disk.misdirect_in(0, seed); // the next write is the trial's file
            let Err(error) = journal.finish(&disk, &layout, None, UTC) else { continue };
            if error.what.contains("reads otherwise than it was written") {
                refused += 1;
                let path = layout.journal(&meta(1).participant, &meta(1).session, 1);
                assert!(disk.kind(&path).is_some(), "{seed}");
            }
        }
        assert!(refused > 10, "{refused}");
    }
}
