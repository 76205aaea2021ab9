//! Every write, sync, rename, append and removal of a trial's life fails once, by a kill and by power cuts; what is
//! promised holds after `recover`, and after a `recover` that was itself cut short.

use crate::faulty::{Faulty, Survives};
use crate::{
    Journal, Layout, RealFiles, Signal, TrialFile, append_events, read_events, read_trial, recover, verify,
};
use rayon::prelude::*;
use std::cell::Cell;
use std::path::Path;
use zwidth_study::{
    Event, Flags, Kind, PlannedTrial, Sample, SessionRecord, Source, Status, StudyId, TrialMeta, Voltages,
    template,
};

pub(crate) const UTC: &str = "2026-01-01T00:00:00Z";
/// Rows of an append, and appends of a trial.
const BATCH: usize = 5;
const BATCHES: usize = 2;
/// Steps of a session's first trial: each write, sync, rename, append and removal.
const STEPS: u32 = 44;

pub(crate) fn meta(trial: u32) -> TrialMeta {
    TrialMeta {
        participant: "P01".parse().unwrap(),
        session: "S01".parse().unwrap(),
        trial,
        repeat: trial,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "spring".parse().unwrap(),
        mode: "hybrid".parse().unwrap(),
        likert: None,
        source: Source::Recorded,
    }
}

fn row(i: usize) -> Sample {
    let x = i as f64;
    Sample {
        t_s: 1e-3 * x,
        t_device_s: None,
        theta_rad: 0.01 * x,
        theta_dot_rad_s: 10.0,
        force_ex_n: 0.1 * x,
        voltages: Voltages { motor_v: 0.1 * x, brake_v: 0.0 },
        force_age_s: Some(0.003),
        theta_raw: Some(i as u16),
        force_cmd_n: 0.026 * x,
        flags: Flags::MOTOR_ON,
    }
}

pub(crate) fn rows(from: usize, n: usize) -> Vec<Sample> {
    (from..from + n).map(row).collect()
}

/// What was promised: each step that returned without an error.
#[derive(Debug, Default)]
struct Promised {
    rows: usize,
    ended: bool,
    finished: bool,
    told: bool,
}

pub(crate) fn planned(trial: u32) -> PlannedTrial {
    PlannedTrial {
        trial,
        repeat: trial,
        kind: Kind::Trial,
        environment: "spring".parse().unwrap(),
        mode: "hybrid".parse().unwrap(),
        samples: true,
    }
}

/// A study with a session of two trials; the first is finished if `first`.
fn study(root: &Path, first: bool) -> Layout {
    let layout = Layout::new(root, StudyId::new("demo").unwrap());
    std::fs::create_dir_all(layout.sessions()).unwrap();
    std::fs::write(layout.study_toml(), template(layout.study())).unwrap();
    let m = meta(1);
    let record = SessionRecord::new(
        m.participant.clone(),
        m.session.clone(),
        Source::Recorded,
        "tests",
        "",
        vec![planned(1), planned(2)],
    );
    std::fs::write(layout.session(&m.participant, &m.session), record.to_json().unwrap()).unwrap();
    if first {
        // On the model of a disk, because a real one takes milliseconds for each sync.
        let disk = Faulty::killed_at(None, root);
        trial(&disk, &layout, 1, &mut Promised::default()).unwrap();
    }
    layout
}

/// A folder with a study in it, whose session has two trials and none done.
pub(crate) fn folder_with_study() -> (tempfile::TempDir, Layout) {
    let folder = tempfile::tempdir().unwrap();
    let layout = study(&folder.path().join("root"), false);
    (folder, layout)
}

/// A whole trial, and an event after it; notes what was promised on the way.
fn trial(
    files: &dyn crate::Files,
    layout: &Layout,
    number: u32,
    promised: &mut Promised,
) -> Result<(), crate::StoreError> {
    let mut journal = Journal::create(files, layout, &meta(number), &TrialFile::new())?;
    for batch in 0..BATCHES {
        journal.append(&rows(batch * BATCH, BATCH))?;
        promised.rows += BATCH;
    }
    journal.end()?;
    promised.ended = true;
    journal.finish(files, layout, Some(4), UTC)?;
    promised.finished = true;
    let note = Event::Note { trial: Some(number), text: "a note".into() };
    let m = meta(number);
    append_events(files, &layout.events(&m.participant, &m.session), UTC, &[note])?;
    promised.told = true;
    Ok(())
}

/// After a whole `recover` every promise holds, nothing is left to be done, and nothing is found wrong.
fn holds(layout: &Layout, promised: &Promised, first: bool, what: &str) {
    assert_eq!(verify(layout), [], "{what}");
    assert_eq!(recover(&RealFiles, layout, UTC), [], "{what}");
    let m = meta(2);
    let path = |trial| layout.trial(&m.participant, &m.session, trial);
    let all = BATCHES * BATCH;
    if first {
        let one = read_trial(&path(1), Signal::all()).unwrap();
        assert_eq!((one.samples.len(), one.meta.status), (all, Status::Complete), "{what}");
    }
    let two = path(2).exists().then(|| read_trial(&path(2), Signal::all()).unwrap());
    let kept = two.as_ref().map_or(0, |t| t.samples.len());
    assert!(kept >= promised.rows && kept % BATCH == 0, "{what}: {kept} rows of {promised:?}");
    if let Some(two) = &two {
        let theta: Vec<f64> = rows(0, kept).iter().map(|r| r.theta_rad).collect();
        assert_eq!(two.samples.get(Signal::Theta), Some(theta.as_slice()), "{what}");
        assert!(two.meta.status == Status::Complete || !promised.ended, "{what}");
        assert!(two.meta.likert == Some(4) || !promised.finished, "{what}");
    }
    let events = read_events(&layout.events(&m.participant, &m.session)).unwrap();
    let recorded = |e: &&Event| matches!(e, Event::Recorded { trial: 2, .. });
    assert_eq!(events.iter().filter(recorded).count(), usize::from(two.is_some()), "{what}");
    let notes = events.iter().filter(|e| matches!(e, Event::Note { trial: Some(2), .. })).count();
    assert!(notes <= 1 && notes >= usize::from(promised.told), "{what}");
}

const ENDS: [Survives; 4] = [Survives::Everything, Survives::Synced, Survives::Names, Survives::Zeros];

/// Kills the trial at its n-th step; whether that came before its end.
fn killed(n: u32, end: Survives, first: bool, then: impl Fn(&Faulty, &Layout, &Promised)) -> bool {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path().join("root");
    let layout = study(&root, first);
    let disk = Faulty::killed_at(Some(n), folder.path());
    let mut promised = Promised::default();
    let ran = trial(&disk, &layout, 2, &mut promised);
    disk.restart(folder.path(), end, None);
    then(&disk, &layout, &promised);
    ran.is_err()
}

#[test]
fn a_fault_at_any_step_of_a_trial_loses_no_more_than_the_batch_being_written() {
    for first in [false, true] {
        for end in ENDS {
            let mut n = 0;
            while killed(n, end, first, |disk, layout, promised| {
                let found = recover(disk, layout, UTC);
                let what = format!("step {n}, {end:?} survives: {found:?}");
                assert!(found.iter().all(Result::is_ok), "{what}");
                holds(layout, promised, first, &what);
            }) {
                n += 1;
            }
            assert_eq!(n, if first { STEPS - 8 } else { STEPS }, "the folders are there after a first trial");
        }
    }
}

/// The folder a test is in, as the model of the disk knows it.
fn folder(layout: &Layout) -> &Path {
    layout.root().parent().unwrap()
}

/// Recovers once with a kill at its m-th step, and then to the end; whether the kill came before the first's end.
fn recovered_twice(n: u32, m: u32, [end, again]: [Survives; 2]) -> (bool, bool) {
    let cut = Cell::new(false);
    let killed = killed(n, end, false, |disk, layout, promised| {
        disk.restart(folder(layout), Survives::Everything, Some(m));
        let found = recover(disk, layout, UTC);
        disk.restart(folder(layout), again, None);
        let mended = recover(disk, layout, UTC);
        let what = format!("step {n} {end:?}, recovery {m} {again:?}: {found:?} {mended:?}");
        assert!(mended.iter().all(Result::is_ok), "{what}");
        holds(layout, promised, false, &what);
        cut.set(found.iter().any(Result::is_err));
    });
    (killed, cut.get())
}

/// Every step of the trial, and every step of its recovery.
fn check_recoveries(ends: [Survives; 2]) {
    let of_step = |n: u32| {
        // A recovery has some thirty steps; the one that was not cut is where it ends.
        (0..100).take_while(|m| recovered_twice(n, *m, ends).1).count()
    };
    let tried: usize = (0..STEPS).into_par_iter().map(of_step).sum();
    assert!(tried > 500, "only {tried} recoveries of {ends:?}");
}

const KILLED_TWICE: [[Survives; 2]; 4] = [
    [Survives::Everything, Survives::Everything],
    [Survives::Everything, Survives::Synced],
    [Survives::Synced, Survives::Synced],
    [Survives::Zeros, Survives::Names],
];

#[test]
fn a_recovery_that_is_cut_short_at_any_step_is_finished_by_the_next() {
    KILLED_TWICE.into_iter().for_each(check_recoveries);
}
