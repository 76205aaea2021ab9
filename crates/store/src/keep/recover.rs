//! `recover`: repairs what a killed process or a power cut has left.
//!
//! It can itself be killed at any moment: when run again, it continues where it stopped. The caller
//! holds the study's lock.

use crate::disk::atomic::sync_file;
use crate::disk::regular::text;
use crate::disk::walk::files_below;
use crate::form::journaled::read_journal;
use crate::form::session_record::{MOST_RECORD, record_from};
use crate::keep::commit::settle;
use crate::keep::journal::clear;
use crate::keep::lay_down::mend_laid_down;
use crate::keep::mend_log::{mend_head, mend_log};
use crate::keep::recovered::{Done, Recovered};
use crate::keep::sweep_log::take_in;
use crate::{Entry, Files, Layout, StoreError, record_trial};
use std::path::{Path, PathBuf};

/// Repairs a study after a kill or a power cut, and reports what it did: half-written files and the
/// files of an interrupted change are removed, unfinished lines of event logs are cut off, and each
/// journal becomes a trial, `complete` if its end is in the journal and `incomplete` otherwise.
/// There is one error for each thing that could not be repaired; the rest is repaired.
///
/// `utc` is the time of the events that are written.
pub fn recover(
    files: &dyn Files,
    layout: &Layout,
    utc: &str,
) -> Vec<Result<Recovered, StoreError>> {
    let mut results = settle(files, layout);
    // Logs before journals: a trial is called recorded in a log that is whole.
    let mut logs = find_named(files, &layout.sessions(), ".events.jsonl");
    let beside = [layout.sweep_events(), layout.own_events()];
    logs.extend(beside.into_iter().filter(|path| files.kind(path) == Some(Entry::File)));
    for path in logs {
        let mended = mend_log(files, &path).transpose();
        results.extend(mended.map(|done| done.map(|done| Recovered { path: path.clone(), done })));
        // Not told: it is what a kill between a line and its count leaves.
        results.extend(mend_head(files, &path).err().map(Err));
    }
    // The logs of records that have none.
    for path in find_named(files, &layout.sessions(), ".json") {
        // What cannot be read is an error of whoever reads it.
        let Ok(text) = text(files, &path, MOST_RECORD) else { continue };
        let Ok(record) = record_from(&path, &text) else { continue };
        if path != layout.session(&record.participant, &record.session) {
            continue;
        }
        match mend_laid_down(files, layout, &record, text.as_bytes(), utc) {
            Ok(false) => {}
            Ok(true) => results.push(Ok(Recovered { path, done: Done::Logged })),
            Err(error) => results.push(Err(error)),
        }
    }
    match take_in(files, layout, utc) {
        Ok(paths) => {
            results.extend(paths.into_iter().map(|path| Ok(Recovered { path, done: Done::Logged })))
        }
        Err(error) => results.push(Err(error)),
    }
    for path in find_named(files, &layout.journals(), ".journal") {
        match journal(files, layout, &path, utc) {
            Ok(done) => results.extend(done),
            Err(error) => results.push(Err(error)),
        }
    }
    results
}

fn find_named(files: &dyn Files, folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut paths = files_below(files, folder).unwrap_or_default();
    paths.retain(|path| path.to_string_lossy().ends_with(ending));
    paths
}

/// A journal becomes a trial, if it has any row. One of which not all can be read stays under
/// another name besides.
fn journal(
    files: &dyn Files,
    layout: &Layout,
    path: &Path,
    utc: &str,
) -> Result<Vec<Result<Recovered, StoreError>>, StoreError> {
    // What is made of the journal must not outlive it.
    sync_file(files, path).map_err(|e| StoreError::io(path, "sync", &e))?;
    let read = read_journal(files, path)?;
    let mut results = Vec::new();
    if let Some((trial, protocol)) = read.trial() {
        let m = &trial.meta;
        let belongs = layout.journal(&m.participant, &m.session, m.trial);
        if belongs != path {
            let what = format!(
                "by its content it is the journal of {} {} trial {}",
                m.participant, m.session, m.trial
            );
            let remedy = format!("it belongs at {}", belongs.display());
            return Err(StoreError::new(path, what, remedy));
        }
        let done = Done::Trial {
            status: m.status,
            rows: trial.samples.len(),
            cut_bytes: read.unfinished,
            mended: read.mended,
        };
        let path = record_trial(files, layout, utc, &trial, &protocol, read.time_ms())?;
        results.push(Ok(Recovered { path, done }));
    }
    match clear(files, path, &read) {
        Err(aside) => results.push(Err(aside)),
        Ok(()) if results.is_empty() => {
            results.push(Ok(Recovered { path: path.to_owned(), done: Done::Empty }));
        }
        Ok(()) => {}
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::head::head_of;
    use crate::tests::crashes::{UTC, folder_with_study, meta, protocol, rows};
    use crate::{
        Journal, RealFiles, Signal, TrialFile, append_events, read_events, read_trial, verify,
    };
    use std::fs;
    use zwidth_study::{Event, Status};

    /// A journal of trial 1 with three batches of rows.
    fn journal_of_three(layout: &Layout) -> PathBuf {
        let mut journal =
            Journal::create(&RealFiles, layout, &meta(1), &TrialFile::new(), &protocol()).unwrap();
        (0..3).for_each(|i| journal.append(&rows(4 * i, 4)).unwrap());
        layout.journal(&meta(1).participant, &meta(1).session, 1)
    }

    fn recovered(layout: &Layout) -> Vec<Result<Recovered, StoreError>> {
        recover(&RealFiles, layout, UTC)
    }

    /// As many things as the caller expects.
    fn exactly<const N: usize>(layout: &Layout) -> [Result<Recovered, StoreError>; N] {
        recovered(layout).try_into().unwrap()
    }

    #[test]
    fn a_journal_without_its_end_becomes_an_incomplete_trial_and_verify_asks_for_it() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let [finding] = verify(&layout).try_into().unwrap();
        assert!(finding.path == path && finding.remedy == "run `zwidth recover demo`", "{finding}");
        let [Ok(done)] = exactly(&layout) else { panic!() };
        let words = "trial-001.parquet: recovered from its journal: incomplete, 12 samples";
        assert!(done.to_string().ends_with(words), "{done}");
        assert_eq!((verify(&layout), recovered(&layout)), (vec![], vec![]));
    }

    #[test]
    fn a_journal_cut_anywhere_keeps_whole_batches() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let bytes = fs::read(&path).unwrap();
        for cut in (0..bytes.len()).step_by(13) {
            let (_folder, layout) = folder_with_study();
            let path = layout.journal(&meta(1).participant, &meta(1).session, 1);
            fs::create_dir(layout.journals()).unwrap();
            fs::write(&path, &bytes[..cut]).unwrap();
            let [Ok(done)] = exactly(&layout) else { panic!("{cut}") };
            let rows = match done.done {
                Done::Trial { rows, status: Status::Incomplete, .. } => rows,
                _ => 0,
            };
            assert!(rows % 4 == 0 && rows * 80 <= cut, "{done} of {cut} bytes");
            assert_eq!(verify(&layout), [], "{cut}");
        }
    }

    #[test]
    fn a_journal_damaged_in_its_middle_is_kept_beside_the_rows_before() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let mut bytes = fs::read(&path).unwrap();
        let second = bytes.len() - 500;
        bytes[second] ^= 0xff; // more than one bit, which would be mended
        fs::write(&path, &bytes).unwrap();
        let [Ok(done), Err(error)] = exactly(&layout) else { panic!() };
        assert!(
            matches!(done.done, Done::Trial { rows: 8, status: Status::Incomplete, .. }),
            "before and behind the damage: {done}"
        );
        assert!(error.what.contains("8 rows are whole"), "{error}");
        assert_eq!(fs::read(&error.path).unwrap(), bytes);
        assert_eq!(recovered(&layout), []);
        let [finding] = verify(&layout).try_into().unwrap();
        assert_eq!(finding.path, error.path);
    }

    #[test]
    fn a_flipped_bit_of_a_length_or_of_the_first_line_costs_no_sample() {
        let (_folder, layout) = folder_with_study();
        let whole = fs::read(journal_of_three(&layout)).unwrap();
        for bit in 0..8 * 22 {
            let (_folder, layout) = folder_with_study();
            let path = layout.journal(&meta(1).participant, &meta(1).session, 1);
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::create_dir(layout.journals()).unwrap();
            fs::write(&path, bytes).unwrap();
            let [Ok(done)] = exactly(&layout) else { panic!("{bit}") };
            assert!(matches!(done.done, Done::Trial { rows: 12, .. }), "bit {bit}: {done}");
        }
    }

    #[test]
    fn a_journal_whose_beginning_is_lost_is_set_aside_beside_the_one_before_and_never_removed() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let whole = fs::read(&path).unwrap();
        for (turn, name) in
            ["journal.damaged", "journal.damaged-2", "journal.damaged-3"].iter().enumerate()
        {
            let mut bytes = whole.clone();
            bytes[30..60].fill(turn as u8);
            fs::write(&path, &bytes).unwrap();
            let [Err(error)] = exactly(&layout) else { panic!("{name}") };
            assert!(error.what.contains("whose trial it is; 12 rows are whole"), "{error}");
            assert_eq!(error.path, path.with_extension(name));
            assert_eq!(fs::read(&error.path).unwrap(), bytes);
        }
        assert_eq!((recovered(&layout), verify(&layout).len()), (vec![], 3));
    }

    #[test]
    fn a_file_that_is_no_journal_and_one_under_another_name_are_left_alone() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let other = layout.journal(&meta(1).participant, &meta(1).session, 2);
        fs::rename(&path, &other).unwrap();
        let later = layout.journals().join("P01_S01.trial-003.journal");
        fs::write(&later, "zwidth journal 3\n").unwrap();
        let [Err(misplaced), Err(unknown)] = exactly(&layout) else { panic!() };
        assert!(misplaced.what.contains("P01 S01 trial 1"), "{misplaced}");
        assert!(unknown.what.contains("not a journal of this version"), "{unknown}");
        assert!(other.exists() && later.exists());
    }

    #[test]
    fn a_trial_that_stands_there_already_must_be_the_journals() {
        let (_folder, layout) = folder_with_study();
        let path = journal_of_three(&layout);
        let bytes = fs::read(&path).unwrap();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        let before = [log.clone(), head_of(&log)].map(|path| (fs::read(&path).unwrap(), path));
        recovered(&layout);
        let trial = layout.trial(&meta(1).participant, &meta(1).session, 1);
        // The file is there and the log does not know it: a kill between the two.
        before.iter().for_each(|(bytes, path)| fs::write(path, bytes).unwrap());
        fs::write(&path, &bytes).unwrap();
        let [Ok(_)] = exactly(&layout) else { panic!() };
        assert_eq!(read_events(&log).unwrap().len(), 2);
        // Another trial under the same number.
        fs::write(&path, &bytes[..bytes.len() - 1]).unwrap();
        let [Err(error)] = exactly(&layout) else { panic!() };
        assert!(error.what.contains("another trial 1"), "{error}");
        assert_eq!(read_trial(&trial, Signal::all()).unwrap().samples.len(), 12);
        assert!(path.exists());
    }

    #[test]
    fn half_written_files_are_swept() {
        let (_folder, layout) = folder_with_study();
        let left = layout.sessions().join(".P02_S01.json.17.tmp");
        fs::write(&left, "{").unwrap();
        assert_eq!(verify(&layout).len(), 1);
        assert_eq!(recovered(&layout), [Ok(Recovered { path: left, done: Done::Swept })]);
        assert_eq!(verify(&layout), []);
    }

    fn notes(n: usize) -> Vec<Event> {
        (0..n).map(|i| Event::Note { trial: None, text: format!("note {i} ä") }).collect()
    }

    #[test]
    fn a_log_cut_in_its_last_line_keeps_the_lines_before() {
        let (_folder, layout) = folder_with_study();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        append_events(&RealFiles, &log, UTC, &notes(2)).unwrap();
        let head = fs::read(head_of(&log)).unwrap();
        append_events(&RealFiles, &log, UTC, &notes(3)[2..]).unwrap();
        let whole = fs::read(&log).unwrap();
        let second = whole
            .iter()
            .rposition(|b| *b == b'\n')
            .map(|end| whole[..end].iter().rposition(|b| *b == b'\n').unwrap() + 1);
        let second = second.unwrap();
        for cut in second + 1..whole.len() {
            fs::write(&log, &whole[..cut]).unwrap();
            fs::write(head_of(&log), &head).unwrap(); // it is written after the line
            let [Ok(done)] = exactly(&layout) else { panic!("{cut}") };
            let is_whole = cut == whole.len() - 1;
            let kept = if is_whole { 3 } else { 2 };
            assert_eq!(read_events(&log).unwrap()[1..], notes(kept), "{done}");
            assert_eq!(is_whole, done.done == Done::Ended);
        }
        fs::write(&log, [&whole[..], &[0; 100]].concat()).unwrap();
        assert_eq!(recovered(&layout).len(), 1);
        assert_eq!(fs::read(&log).unwrap(), whole);
    }

    #[test]
    fn a_log_with_a_changed_line_is_not_touched() {
        let (_folder, layout) = folder_with_study();
        let log = layout.events(&meta(1).participant, &meta(1).session);
        append_events(&RealFiles, &log, UTC, &notes(3)).unwrap();
        let whole = fs::read_to_string(&log).unwrap();
        let changed = whole.replace("note 1", "note 7");
        let last = whole.replace("note 2", "note 7");
        let before_a_cut = changed[..changed.len() - 20].to_owned();
        for (bad, problems) in [(changed, 0), (last, 0), (before_a_cut, 1)] {
            fs::write(&log, &bad).unwrap();
            assert_eq!(recovered(&layout).into_iter().filter_map(Result::err).count(), problems);
            assert_eq!(fs::read_to_string(&log).unwrap(), bad);
            assert!(!verify(&layout).is_empty());
        }
    }
}
