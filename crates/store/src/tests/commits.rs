//! Events of several logs: all or none, wherever the disk fails or the process ends.

use crate::tests::crashes::{UTC, planned, record, toml};
use crate::{
    Fault, Files as _, Layout, Memory, StoreError, StudyData, Survives, append_events,
    commit_events, lay_down, recover, verify_from,
};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_study::{Event, SessionRecord, StudyId};

/// A study of three sessions without samples, and their logs.
fn study() -> (Memory, Layout, Vec<PathBuf>) {
    let (disk, layout) =
        (Memory::new(), Layout::new(Path::new("/root"), StudyId::new("demo").unwrap()));
    disk.put(&layout.study_toml(), &toml(&layout));
    let mut logs = Vec::new();
    for session in ["S01", "S02", "S03"] {
        let record = SessionRecord {
            session: session.parse().unwrap(),
            ..record(&layout, vec![planned(1), planned(2)])
        };
        lay_down(&disk, &layout, UTC, &record, &toml(&layout)).unwrap();
        logs.push(layout.events(&record.participant, &record.session));
    }
    (disk, layout, logs)
}

fn note(text: &str) -> Event {
    Event::Note { trial: None, text: text.into() }
}

/// Two lines for each log.
fn commit(disk: &Memory, layout: &Layout, logs: &[PathBuf]) -> Result<(), StoreError> {
    let events = [note("one"), note("two")];
    let logs: Vec<(&Path, &[Event])> =
        logs.iter().map(|log| (log.as_path(), &events[..])).collect();
    commit_events(disk, layout, UTC, &logs)
}

/// How many notes each session has, as a reader sees it.
fn notes(disk: &Memory, layout: &Layout) -> Vec<usize> {
    let data = StudyData::load_from(disk, layout).unwrap();
    let notes =
        |events: &[Event]| events.iter().filter(|e| matches!(e, Event::Note { .. })).count();
    data.sessions.iter().map(|log| notes(&log.events)).collect()
}

const NONE: [usize; 3] = [0; 3];
const ALL: [usize; 3] = [2; 3];

#[test]
fn a_kill_at_any_step_leaves_all_lines_or_none_for_readers_and_for_who_recovers() {
    let ends =
        [Survives::Everything, Survives::Synced, Survives::Names, Survives::Zeros, Survives::Half];
    for end in ends {
        let mut steps = 0;
        for n in 0.. {
            let (disk, layout, logs) = study();
            disk.fail_in(n, Fault::End);
            let made = commit(&disk, &layout, &logs);
            let killed = disk.has_failed();
            disk.restart(end);
            let what = format!("step {n}, {end:?} survives, {made:?}");
            let seen = notes(&disk, &layout);
            assert!(seen == NONE || seen == ALL, "{what}: a reader sees {seen:?}");
            let is_listed = disk.kind(&layout.unfinished()).is_some();
            let told = verify_from(&disk, &layout).iter().any(|f| f.path == layout.unfinished());
            assert_eq!(told, is_listed, "{what}");
            let found = recover(&disk, &layout, UTC);
            assert!(found.iter().all(Result::is_ok), "{what}: {found:?}");
            assert_eq!(notes(&disk, &layout), seen, "{what}");
            assert!(made.is_err() || seen == ALL, "{what}: what was acknowledged is gone");
            assert_eq!(verify_from(&disk, &layout), [], "{what}");
            if seen == NONE {
                commit(&disk, &layout, &logs).unwrap();
            }
            assert_eq!(notes(&disk, &layout), ALL, "{what}");
            if !killed {
                steps = n;
                break;
            }
        }
        // The list has 4, each log and the heads as many, and the removal of the list 2.
        assert!(steps > 20, "{steps}");
    }
}

#[test]
fn a_recovery_that_is_cut_short_is_finished_by_the_next() {
    let tried: usize = (0..26_u64)
        .into_par_iter()
        .map(|n| {
            let mut cut = 0;
            for m in 0.. {
                let (disk, layout, logs) = study();
                disk.fail_in(n, Fault::End);
                let _ = commit(&disk, &layout, &logs);
                disk.restart(Survives::Half);
                let seen = notes(&disk, &layout);
                disk.fail_in(m, Fault::End);
                let _ = recover(&disk, &layout, UTC);
                let killed = disk.has_failed();
                disk.restart(Survives::Synced);
                let found = recover(&disk, &layout, UTC);
                assert!(found.iter().all(Result::is_ok), "{n}, {m}: {found:?}");
                assert_eq!(notes(&disk, &layout), seen, "{n}, {m}");
                if !killed {
                    break;
                }
                cut += 1;
            }
            cut
        })
        .sum();
    assert!(tried > 100, "{tried}");
}

#[test]
fn an_error_at_any_step_means_that_nothing_happened() {
    for fault in [Fault::Full, Fault::ReadOnly] {
        for n in 0.. {
            let (disk, layout, logs) = study();
            let before = disk.below(&layout.raw());
            disk.fail_in(n, fault);
            let made = commit(&disk, &layout, &logs);
            let failed = disk.has_failed();
            disk.restart(Survives::Everything);
            let what = format!("{fault:?} from step {n}: {made:?}");
            match &made {
                Ok(()) => assert_eq!(notes(&disk, &layout), ALL, "{what}"),
                Err(error) if error.what.contains("is not known") => {
                    // The list is gone, its folder cannot be synced, and nothing can be taken back.
                    assert_eq!(fault, Fault::ReadOnly, "{what}");
                }
                Err(_) => {
                    assert_eq!(notes(&disk, &layout), NONE, "{what}");
                    let found = recover(&disk, &layout, UTC);
                    assert!(found.iter().all(Result::is_ok), "{what}: {found:?}");
                    assert_eq!(disk.below(&layout.raw()), before, "{what}");
                }
            }
            if !failed {
                break;
            }
        }
    }
}

#[test]
fn a_line_of_one_log_is_not_there_after_an_error() {
    for n in 0.. {
        let (disk, layout, logs) = study();
        disk.fail_in(n, Fault::Full);
        let made = append_events(&disk, &logs[0], UTC, &[note("one")]);
        let failed = disk.has_failed();
        disk.restart(Survives::Everything);
        assert_eq!(notes(&disk, &layout)[0], usize::from(made.is_ok()), "step {n}: {made:?}");
        assert_eq!(verify_from(&disk, &layout), [], "step {n}");
        if !failed {
            break;
        }
    }
}

#[test]
fn a_list_that_a_power_cut_brings_back_takes_nothing_back_that_was_made() {
    let (disk, layout, logs) = study();
    disk.fail_in(13, Fault::End);
    commit(&disk, &layout, &logs).unwrap_err();
    disk.restart(Survives::Everything);
    let list = disk.read(&layout.unfinished(), 1 << 20).unwrap();
    assert!(recover(&disk, &layout, UTC).iter().all(Result::is_ok));
    commit(&disk, &layout, &logs).unwrap();
    // The same bytes again, so that the list is of these lines; then the log goes on.
    disk.put(&layout.unfinished(), &list);
    assert_eq!(notes(&disk, &layout), ALL);
    assert!(recover(&disk, &layout, UTC).iter().all(Result::is_ok));
    assert_eq!(notes(&disk, &layout), ALL);
    append_events(&disk, &logs[1], UTC, &[note("three")]).unwrap();
    disk.put(&layout.unfinished(), &list);
    assert!(recover(&disk, &layout, UTC).iter().all(Result::is_ok));
    assert_eq!(notes(&disk, &layout), [2, 3, 2]);
}

#[test]
fn a_change_that_was_not_taken_back_keeps_the_next_from_being_made() {
    let (disk, layout, logs) = study();
    disk.put(&layout.unfinished(), b"{}");
    let error = commit(&disk, &layout, &logs).unwrap_err();
    assert!(error.what.contains("cut short") && error.remedy.contains("recover"), "{error}");
    assert_eq!(notes(&disk, &layout), NONE);
}

#[test]
fn a_list_that_names_other_files_than_logs_cuts_none() {
    let (disk, layout, _) = study();
    let before = disk.below(&layout.raw());
    for path in [
        "../other/x.jsonl",
        "study.toml",
        "sessions/P01_S01.json",
        "/root/x",
        "trials/x.events.jsonl",
    ] {
        let list = format!(
            "{{\"files\":[],\"folders\":[],\"logs\":[{{\"path\":{path:?},\"bytes_before\":0,\"lines_before\":0,\"bytes\":9,\
             \"first\":\"x\"}}]}}"
        );
        disk.put(&layout.unfinished(), list.as_bytes());
        let found = recover(&disk, &layout, UTC);
        assert!(
            found.iter().any(|f| f.as_ref().is_err_and(|e| e.what.contains("no change writes"))),
            "{found:?}"
        );
        let mut after = disk.below(&layout.raw());
        after.remove(&layout.unfinished());
        assert_eq!(after, before, "{path}");
    }
}
