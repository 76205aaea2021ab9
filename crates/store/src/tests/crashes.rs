//! Every write, sync, rename, append and removal of a trial's life fails once, by a kill and by
//! power cuts; the promises hold after `recover`, and after a `recover` that was itself cut short.

use crate::form::events::read_events_from;
use crate::form::read::read_trial_from;
use crate::tests::faulty::Faulty;
use crate::{
    Fault, Files, Journal, Layout, Memory, Protocol, Signal, Survives, TrialFile, append_events,
    lay_down, recover, verify_from,
};
use rayon::prelude::*;
use std::cell::Cell;
use std::path::Path;
use zwidth_study::{
    Event, Flags, Given, Kind, PlannedTrial, Sample, SessionRecord, Source, Status, StudyId,
    TrialMeta, Voltages, template,
};

pub(crate) const UTC: &str = "2026-01-01T00:00:00Z";
/// Rows of an append, and appends of a trial.
const BATCH: usize = 5;
const BATCHES: usize = 2;
/// Steps of a session's first trial: each write, sync, rename, append and removal.
const STEPS: u64 = 52;

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
        presented: None,
    }
}

/// What the study of the template asks after these trials, and the form of its files.
pub(crate) fn protocol() -> Protocol {
    Protocol { question: Some("felt_spring".parse().unwrap()), ..Protocol::default() }
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
        extra: zwidth_study::Extra::default(),
    }
}

pub(crate) fn rows(from: usize, n: usize) -> Vec<Sample> {
    (from..from + n).map(row).collect()
}

/// The answer to the question after a trial.
pub(crate) const FOUR: Option<Given> = Some(Given { value: 4, time_ms: None });

/// A journal with all that can be chosen of it, at its end.
pub(crate) fn ended_as(
    files: &dyn Files,
    layout: &Layout,
    meta: &TrialMeta,
    file: &TrialFile,
    protocol: &Protocol,
    rows: &[Sample],
) -> Journal {
    let mut journal = Journal::create(files, layout, meta, file, protocol).unwrap();
    journal.append(rows).unwrap();
    journal.end().unwrap();
    journal
}

/// The journal of the first trial with so many rows, at its end.
pub(crate) fn ended(files: &dyn Files, layout: &Layout, n: usize) -> Journal {
    ended_as(files, layout, &meta(1), &TrialFile::new(), &protocol(), &rows(0, n))
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
        task: None,
    }
}

/// A study without any session.
pub(crate) fn study_alone(root: &Path) -> Layout {
    let layout = Layout::new(root, StudyId::new("demo").unwrap());
    std::fs::create_dir_all(layout.sessions()).unwrap();
    std::fs::write(layout.study_toml(), toml(&layout)).unwrap();
    layout
}

/// The text of the study's `study.toml`.
pub(crate) fn toml(layout: &Layout) -> Vec<u8> {
    template(layout.study()).into_bytes()
}

/// The record of a session of these trials.
pub(crate) fn record(layout: &Layout, trials: Vec<PlannedTrial>) -> SessionRecord {
    let (m, hash) = (meta(1), crate::hex_blake3(&toml(layout)));
    SessionRecord::new(m.participant, m.session, Source::Recorded, "tests", hash, trials)
}

/// Lays down a session of two trials.
fn lay_down_two(files: &dyn Files, layout: &Layout) {
    let two = record(layout, vec![planned(1), planned(2)]);
    lay_down(files, layout, UTC, &two, &toml(layout)).unwrap();
}

/// A study in memory with a session of two trials; the first is finished if `first`.
pub(crate) fn study(first: bool) -> (Memory, Layout) {
    let (disk, layout) =
        (Memory::new(), Layout::new(Path::new("/root"), StudyId::new("demo").unwrap()));
    disk.put(&layout.study_toml(), &toml(&layout));
    lay_down_two(&disk, &layout);
    if first {
        trial(&disk, &layout, 1, &mut Promised::default()).unwrap();
    }
    (disk, layout)
}

/// A folder with a study in it, whose session has two trials and none done.
pub(crate) fn folder_with_study() -> (tempfile::TempDir, Layout) {
    let folder = tempfile::tempdir().unwrap();
    let layout = study_alone(&folder.path().join("root"));
    // Without syncs, which take milliseconds each.
    lay_down_two(&Faulty::never(), &layout);
    (folder, layout)
}

/// A whole trial, and an event after it; notes what was promised on the way.
fn trial(
    files: &dyn crate::Files,
    layout: &Layout,
    number: u32,
    promised: &mut Promised,
) -> Result<(), crate::StoreError> {
    let mut journal =
        Journal::create(files, layout, &meta(number), &TrialFile::new(), &protocol())?;
    for batch in 0..BATCHES {
        journal.append(&rows(batch * BATCH, BATCH))?;
        promised.rows += BATCH;
    }
    journal.end()?;
    promised.ended = true;
    journal.finish(files, layout, FOUR, UTC)?;
    promised.finished = true;
    let note = Event::Note { trial: Some(number), text: "a note".into() };
    let m = meta(number);
    append_events(files, &layout.events(&m.participant, &m.session), UTC, &[note])?;
    promised.told = true;
    Ok(())
}

/// After a whole `recover` every promise holds, nothing is left to be done, and nothing is found
/// wrong.
fn holds(disk: &Memory, layout: &Layout, promised: &Promised, first: bool, what: &str) {
    assert_eq!(verify_from(disk, layout), [], "{what}");
    assert_eq!(recover(disk, layout, UTC), [], "{what}");
    let m = meta(2);
    let read = |trial| {
        let path = layout.trial(&m.participant, &m.session, trial);
        disk.kind(&path).map(|_| read_trial_from(disk, &path, Signal::all()).unwrap())
    };
    let all = BATCHES * BATCH;
    if first {
        let one = read(1).unwrap();
        assert_eq!((one.samples.len(), one.meta.status), (all, Status::Complete), "{what}");
    }
    let two = read(2);
    let kept = two.as_ref().map_or(0, |t| t.samples.len());
    assert!(kept >= promised.rows && kept % BATCH == 0, "{what}: {kept} rows of {promised:?}");
    if let Some(two) = &two {
        let theta: Vec<f64> = rows(0, kept).iter().map(|r| r.theta_rad).collect();
        assert_eq!(two.samples.get(Signal::Theta), Some(theta.as_slice()), "{what}");
        assert!(two.meta.status == Status::Complete || !promised.ended, "{what}");
    }
    let events = read_events_from(disk, &layout.events(&m.participant, &m.session)).unwrap();
    let four =
        |e: &&Event| matches!(e, Event::Answer { trial: 2, value, .. } if *value == 4.into());
    let answers = events.iter().filter(four).count();
    assert!(answers <= 1 && answers >= usize::from(promised.finished), "{what}");
    let recorded = |e: &&Event| matches!(e, Event::Recorded { trial: 2, .. });
    assert_eq!(events.iter().filter(recorded).count(), usize::from(two.is_some()), "{what}");
    let notes = events.iter().filter(|e| matches!(e, Event::Note { trial: Some(2), .. })).count();
    assert!(notes <= 1 && notes >= usize::from(promised.told), "{what}");
}

const ENDS: [Survives; 7] = [
    Survives::Everything,
    Survives::Synced,
    Survives::Names,
    Survives::Zeros,
    Survives::Half,
    Survives::Torn(1),
    Survives::Torn(4),
];

/// Ends the process at the n-th step of the trial; whether that came before the trial's end.
fn killed(n: u64, end: Survives, first: bool, then: impl Fn(&Memory, &Layout, &Promised)) -> bool {
    let (disk, layout) = study(first);
    disk.fail_in(n, Fault::End);
    let mut promised = Promised::default();
    let _ = trial(&disk, &layout, 2, &mut promised);
    // A head that cannot be written is no error, and the kill came all the same.
    let killed = disk.has_failed();
    disk.restart(end);
    then(&disk, &layout, &promised);
    killed
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
                holds(disk, layout, promised, first, &what);
            }) {
                n += 1;
            }
            // The folders are there after a first trial.
            assert_eq!(n, if first { STEPS - 8 } else { STEPS });
        }
    }
}

/// Recovers once with a kill at its m-th step, and then to the end; whether the kill came before
/// the first's end.
fn recovered_twice(n: u64, m: u64, [end, again]: [Survives; 2]) -> (bool, bool) {
    let cut = Cell::new(false);
    let killed = killed(n, end, false, |disk, layout, promised| {
        disk.fail_in(m, Fault::End);
        let found = recover(disk, layout, UTC);
        disk.restart(again);
        let mended = recover(disk, layout, UTC);
        let what = format!("step {n} {end:?}, recovery {m} {again:?}: {found:?} {mended:?}");
        assert!(mended.iter().all(Result::is_ok), "{what}");
        holds(disk, layout, promised, false, &what);
        cut.set(found.iter().any(Result::is_err));
    });
    (killed, cut.get())
}

/// Every step of the trial, and every step of its recovery.
fn check_recoveries(ends: [Survives; 2]) {
    let of_step = |n: u64| {
        // A recovery has some thirty steps; the one that was not cut is where it ends.
        (0..100).take_while(|m| recovered_twice(n, *m, ends).1).count()
    };
    let tried: usize = (0..STEPS).into_par_iter().map(of_step).sum();
    assert!(tried > 500, "only {tried} recoveries of {ends:?}");
}

/// What survives the first time, and the second.
const KILLED_TWICE: [[Survives; 2]; 5] = [
    [Survives::Everything, Survives::Everything],
    [Survives::Everything, Survives::Synced],
    [Survives::Synced, Survives::Half],
    [Survives::Half, Survives::Synced],
    [Survives::Zeros, Survives::Names],
];

#[test]
fn a_recovery_that_is_cut_short_at_any_step_is_finished_by_the_next() {
    KILLED_TWICE.into_iter().for_each(check_recoveries);
}

#[test]
fn a_disk_that_fills_up_at_any_step_loses_nothing_that_was_stored() {
    for n in 0..STEPS {
        let (disk, layout) = study(true);
        disk.fail_in(n, Fault::Full);
        let mut promised = Promised::default();
        let ran = trial(&disk, &layout, 2, &mut promised);
        disk.restart(Survives::Everything);
        let found = recover(&disk, &layout, UTC);
        let what = format!("full from step {n}: {ran:?}, {found:?}");
        assert!(found.iter().all(Result::is_ok), "{what}");
        holds(&disk, &layout, &promised, true, &what);
    }
}
