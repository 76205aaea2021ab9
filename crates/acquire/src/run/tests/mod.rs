mod checks;
mod in_memory;
mod long;
mod marks;
#[cfg(unix)]
mod moved;
mod pairs;
mod protocol;
mod secret;
mod slow_disk;
mod tasks;
mod whole;

use super::*;
use crate::{Auto, Nobody, Phase as Shown, Unsynced};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use tempfile::TempDir;
use zwidth_device::SimulatedClock;
use zwidth_device::mock::{Fault, Mock};
use zwidth_store::{
    Append, Entry, Layout, RealFiles, Stamp, StudyData, append_events, recover, verify,
};
use zwidth_study::{Calibration, Kind, ModeId, Status, Study, Voltages, template};

const UTC: &str = "2026-01-01T00:00:00Z";
const TRIALS: usize = 7;

/// One practice trial and one of each of six conditions, at 120 Hz.
fn small(id: &str, blinded: bool) -> String {
    template(&id.parse().unwrap())
        .replace("repeats = 6", "repeats = 1")
        .replace("familiarisation = 3", "familiarisation = 1")
        .replace("rate_hz = 1000.0", "rate_hz = 120.0")
        .replace("blinded = false", &format!("blinded = {blinded}"))
}

struct Desk {
    folder: TempDir,
    plan: Plan,
    options: Options,
    judge: fn(&Trial) -> Option<Verdict>,
}

impl Desk {
    fn new(blinded: bool) -> Self {
        Self::with(small("small", blinded))
    }

    /// A desk with that study.toml of the study `small`.
    fn with(text: String) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "small".parse().unwrap());
        std::fs::create_dir_all(layout.raw()).unwrap();
        std::fs::write(layout.study_toml(), &text).unwrap();
        let study = Study::from_toml(&text).unwrap();
        let plan = Plan {
            study_toml: text.into_bytes(),
            accept_study_change: false,
            rate_hz: study.control.rate_hz,
            layout,
            study,
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            calibration: Calibration::thesis(),
            software: "test 1".to_owned(),
            seed: None,
            keys: folder.path().join("keys"),
            secret: [9; 32],
        };
        Self { folder, plan, options: Options::default(), judge: |_| None }
    }

    fn run(
        &self,
        device: &mut Mock,
        files: &dyn Files,
        front: &mut dyn Front,
    ) -> Result<Outcome, AcquireError> {
        let session = Session::open(&self.plan, device.capabilities(), files)?;
        let mut clock = SimulatedClock::new(1);
        let parts = Parts {
            device,
            clock: &mut clock,
            files,
            front,
            utc: &|_| UTC.to_owned(),
            judge: &self.judge,
        };
        run(&self.plan, session, &self.options, parts)
    }

    fn data(&self) -> StudyData {
        StudyData::load(&self.plan.layout).unwrap()
    }

    fn root(&self) -> &Path {
        self.folder.path()
    }
}

/// Somebody who starts every trial, gives the same answer always, and does what a closure says
/// before all else.
struct Somebody<F>(F, Shown, Option<Input>);

impl<F: FnMut(&View) -> Option<Input>> Front for Somebody<F> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        self.1 = view.phase.clone();
        if let Some(input) = (self.0)(view) {
            if input == Input::Failed("killed".into()) {
                return Err(AcquireError::refused("killed", ""));
            }
            self.2 = Some(input);
        }
        Ok(())
    }

    fn next(&mut self, _wait: Duration) -> Result<Option<Input>, AcquireError> {
        Ok(self.2.take().or(match self.1 {
            Shown::Ready => Some(Input::Start),
            Shown::Question { .. } => Some(Input::Answer(4)),
            Shown::Done | Shown::Stopped { .. } => Some(Input::Quit),
            _ => None,
        }))
    }
}

/// Somebody who leaves once so many trials are done.
fn quits_after(done: usize) -> Somebody<impl FnMut(&View) -> Option<Input>> {
    somebody(move |view: &View| (view.done == done).then_some(Input::Quit))
}

fn somebody(
    own: impl FnMut(&View) -> Option<Input>,
) -> Somebody<impl FnMut(&View) -> Option<Input>> {
    Somebody(own, Shown::Check, None)
}

fn diligent() -> Somebody<impl FnMut(&View) -> Option<Input>> {
    somebody(|_| None)
}

#[test]
fn a_whole_session_leaves_every_trial_complete_with_its_answer_and_verify_has_no_findings() {
    let desk = Desk::new(false);
    let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    assert_eq!((outcome.done, outcome.total, outcome.stopped), (TRIALS, TRIALS, None));
    let data = desk.data();
    assert_eq!(data.trials.len(), TRIALS);
    for trial in &data.trials {
        assert_eq!((trial.meta.status, trial.meta.likert), (Status::Complete, None));
        let number = trial.meta.trial;
        let four = |e: &&Event| matches!(e, Event::Answer { trial, value, .. } if (*trial, *value) == (number, 4.into()));
        assert_eq!(data.sessions[0].events.iter().filter(four).count(), 1);
        assert!(trial.rows > 200, "{}", trial.rows);
    }
    assert_eq!(data.counting().count(), TRIALS - 1);
    assert_eq!(verify(&desk.plan.layout), []);
    assert!(desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap().done == TRIALS);
}

#[test]
fn the_order_recorded_is_the_order_drawn() {
    let desk = Desk::new(false);
    desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    let data = desk.data();
    let drawn = &data.sessions[0].record.trials;
    let found: Vec<_> =
        data.trials.iter().map(|t| (t.meta.trial, t.meta.mode.clone(), t.meta.repeat)).collect();
    assert_eq!(
        found,
        drawn.iter().map(|t| (t.trial, t.mode.clone(), t.repeat)).collect::<Vec<_>>()
    );
    assert_eq!(drawn[0].kind, Kind::Familiarisation);
}

#[test]
fn repeats_exclusions_and_notes_end_up_in_the_log() {
    let desk = Desk::new(false);
    let mut said = vec![
        (2, Input::Repeat),
        (3, Input::Exclude("the phone rang".into())),
        (4, Input::Note("slowly".into())),
    ];
    let mut front = somebody(|view: &View| {
        let due =
            view.phase == Shown::Ready && said.first().is_some_and(|(done, _)| *done == view.done);
        due.then(|| said.remove(0).1)
    });
    desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    let data = desk.data();
    let why = |n: u32| data.trials.iter().find(|t| t.meta.trial == n).unwrap().why_not();
    assert_eq!(why(2).as_deref(), Some("superseded by trial 8"));
    assert_eq!(why(8), None);
    // It was missing, and done again at the end.
    assert_eq!(why(3).as_deref(), Some("superseded by trial 9"));
    assert_eq!(why(9), None);
    let excluded = Event::Excluded { trial: 3, reason: "the phone rang".into() };
    assert!(data.sessions[0].events.contains(&excluded), "{:?}", data.sessions[0].events);
    // What was excluded is done no longer: four are when the fifth has ended.
    let note = Event::Note { trial: Some(5), text: "slowly".into() };
    assert!(data.sessions[0].events.contains(&note), "{:?}", data.sessions[0].events);
    assert_eq!(verify(&desk.plan.layout), []);
}

/// What a disk is asked for.
enum Request<'a> {
    /// What a file or a name is.
    Look,
    /// The names in a folder; so many there are.
    List(usize),
    /// A file's bytes; so many there are.
    Read(usize),
    Write(&'a Path, &'a [u8]),
    Append(&'a Path, &'a [u8]),
    Sync(&'a Path),
}

/// Hears of a request, and may refuse it.
type Hears = dyn Fn(Request<'_>) -> io::Result<()> + Send + Sync;

/// A disk, and somebody who hears of each request: before anything is written.
struct Heard(Arc<Hears>);

struct HeardFile(Box<dyn Append>, PathBuf, Arc<Hears>);

impl Heard {
    fn new(hears: impl Fn(Request<'_>) -> io::Result<()> + Send + Sync + 'static) -> Self {
        Self(Arc::new(hears))
    }
}

impl Append for HeardFile {
    fn append_synced(&mut self, bytes: &[u8]) -> io::Result<()> {
        (self.2)(Request::Append(&self.1, bytes))?;
        self.0.append_synced(bytes)
    }
    fn take_back(&mut self) -> io::Result<()> {
        self.0.take_back()
    }
}

impl Files for Heard {
    fn kind(&self, path: &Path) -> Option<Entry> {
        (self.0)(Request::Look).ok()?;
        Unsynced.kind(path)
    }
    fn stamp(&self, path: &Path) -> Option<Stamp> {
        (self.0)(Request::Look).ok()?;
        Unsynced.stamp(path)
    }
    fn list(&self, folder: &Path) -> io::Result<Vec<(PathBuf, Entry)>> {
        let found = Unsynced.list(folder)?;
        (self.0)(Request::List(found.len()))?;
        Ok(found)
    }
    fn read(&self, path: &Path, most: u64) -> io::Result<Vec<u8>> {
        let bytes = Unsynced.read(path, most)?;
        (self.0)(Request::Read(bytes.len()))?;
        Ok(bytes)
    }
    fn create_folder(&self, path: &Path) -> io::Result<()> {
        Unsynced.create_folder(path)
    }
    fn write_synced(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        (self.0)(Request::Write(path, bytes))?;
        Unsynced.write_synced(path, bytes)
    }
    fn rename(&self, from: &Path, to: &Path) -> io::Result<()> {
        Unsynced.rename(from, to)
    }
    fn sync_folder(&self, path: &Path) -> io::Result<()> {
        (self.0)(Request::Sync(path))?;
        Unsynced.sync_folder(path)
    }
    fn open_append(&self, path: &Path) -> io::Result<Box<dyn Append>> {
        let file = Unsynced.open_append(path)?;
        Ok(Box::new(HeardFile(file, path.to_owned(), Arc::clone(&self.0))))
    }
    fn remove(&self, path: &Path) -> io::Result<()> {
        Unsynced.remove(path)
    }
    fn remove_folder(&self, path: &Path) -> io::Result<()> {
        Unsynced.remove_folder(path)
    }
}

fn take(left: &Mutex<u32>) -> io::Result<()> {
    let mut left = left.lock().unwrap();
    *left = left.checked_sub(1).ok_or(io::ErrorKind::StorageFull)?;
    Ok(())
}

/// A disk that takes so many writes and is full from then on.
fn full(left: &Arc<Mutex<u32>>) -> Heard {
    let left = Arc::clone(left);
    Heard::new(move |request| match request {
        Request::Write(..) | Request::Append(..) => take(&left),
        _ => Ok(()),
    })
}

#[test]
fn a_disk_that_fills_up_at_any_moment_ends_the_session_at_0_v_and_the_rest_follows_in_the_same_order()
 {
    let whole = Desk::new(false);
    whole.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    let drawn = whole.data().sessions[0].record.trials.clone();
    let left = Arc::new(Mutex::new(10_000));
    Desk::new(false).run(&mut Mock::default(), &full(&left), &mut diligent()).unwrap();
    let used = 10_000 - *left.lock().unwrap();
    // At the record and the first journal; in the midst of a trial; at every write that makes it a
    // file; at the last line of the log. (Its count comes after it, and may stay behind.)
    let a_trial = used / TRIALS as u32;
    for room in
        [0, 1, 2, 3, 30].into_iter().chain(a_trial - 8..a_trial + 8).chain([used / 2, used - 2])
    {
        let desk = Desk::new(false);
        let mut mock = Mock::default();
        let full = full(&Arc::new(Mutex::new(room)));
        let error = desk.run(&mut mock, &full, &mut diligent()).unwrap_err().to_string();
        assert!(error.contains("free some space") || error.contains("recover"), "{room}: {error}");
        assert_eq!(mock.writes.last().map(|(_, v)| *v), Some(Voltages::OFF), "{room}");
        check_resumed(&desk, &drawn, room);
    }
}

/// After `recover` nothing is lost, and the session goes on to its end in the order drawn.
fn check_resumed(desk: &Desk, drawn: &[zwidth_study::PlannedTrial], case: u32) {
    for found in recover(&RealFiles, &desk.plan.layout, UTC) {
        found.unwrap();
    }
    assert_eq!(verify(&desk.plan.layout), [], "{case}");
    let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    assert_eq!((outcome.done, outcome.total), (TRIALS, TRIALS), "{case}");
    assert_eq!(verify(&desk.plan.layout), [], "{case}");
    let data = desk.data();
    let mut counting: Vec<_> = data.counting().collect();
    // A trial done again has a later number, but the place of the first.
    let first = |n: u32| {
        data.trials.iter().find(|t| t.superseded_by == Some(n)).map_or(n, |t| t.meta.trial)
    };
    counting.sort_by_key(|t| first(t.meta.trial));
    let found: Vec<_> =
        counting.iter().map(|t| (&t.meta.environment, &t.meta.mode, t.meta.repeat)).collect();
    let experiment = drawn.iter().filter(|t| t.kind == Kind::Trial);
    assert_eq!(
        found,
        experiment.map(|t| (&t.environment, &t.mode, t.repeat)).collect::<Vec<_>>(),
        "{case}"
    );
}

#[test]
fn a_session_killed_while_a_question_is_open_asks_it_again() {
    let desk = Desk::new(false);
    let mut front = somebody(|view: &View| {
        let open = matches!(view.phase, Shown::Question { .. }) && view.done == 2;
        open.then(|| Input::Failed("killed".into()))
    });
    desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap_err();
    recover(&RealFiles, &desk.plan.layout, UTC);
    assert_eq!(desk.data().trials[2].meta.status, Status::Complete);
    desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    let data = desk.data();
    assert_eq!(data.answers.len(), TRIALS - 1);
    assert_eq!(data.trials.len(), TRIALS);
}

#[test]
fn a_front_end_that_goes_away_leaves_the_session_as_a_signal_does_in_every_phase() {
    let phases: [fn(&Shown) -> bool; 5] = [
        |phase| matches!(phase, Shown::Check | Shown::Homing),
        |phase| matches!(phase, Shown::Ready),
        |phase| matches!(phase, Shown::Question { .. }),
        |phase| matches!(phase, Shown::Pause { .. }),
        |phase| matches!(phase, Shown::Done),
    ];
    for (number, is_phase) in phases.into_iter().enumerate() {
        let desk = Desk::new(false);
        let mut front = Going(diligent(), is_phase);
        let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut front).unwrap();
        assert!(outcome.interrupted, "{number}");
        assert_eq!(outcome.gone.as_deref(), Some("the window was closed"), "{number}");
        assert_eq!(recover(&RealFiles, &desk.plan.layout, UTC).len(), 0, "{number}");
        assert_eq!(verify(&desk.plan.layout), [], "{number}");
        let desk = Desk { options: Options::default(), ..desk };
        let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
        assert_eq!((outcome.done, outcome.gone), (TRIALS, None), "{number}");
    }
}

/// Somebody whose window is closed in a phase.
struct Going<F>(F, fn(&Shown) -> bool);

impl<F: Front> Front for Going<F> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        if (self.1)(&view.phase) {
            return Err(io::Error::other("the window was closed").into());
        }
        self.0.show(view)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        self.0.next(wait)
    }
}

#[test]
fn a_safety_trigger_stops_the_session_and_the_trial_is_done_again_after_homing() {
    let desk = Desk::new(false);
    let mut mock = Mock::default().failing(1.0, Fault::Force(12.0));
    let outcome = desk.run(&mut mock, &RealFiles, &mut Auto::new(Nobody)).unwrap();
    let why = outcome.stopped.unwrap();
    assert!(why.contains("12.0 N"), "{why}");
    let cut = desk.data().trials.iter().filter(|t| t.meta.status == Status::Incomplete).count();
    assert_eq!(cut, 1);
    let outcome = desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    assert_eq!(outcome.done, TRIALS);
    assert_eq!(desk.data().counting().count(), TRIALS - 1);
}

#[test]
fn a_session_refuses_another_device_rate_calibration_or_seed_and_says_which_with_both_sides() {
    let desk = Desk::new(false);
    desk.run(&mut Mock::default(), &RealFiles, &mut quits_after(1)).unwrap();
    let refused = |plan: &Plan, device: &Mock| {
        Session::open(plan, device.capabilities(), &RealFiles).unwrap_err().to_string()
    };
    let mut other = Mock::default();
    other.capabilities.name = "mock 2".to_owned();
    assert!(refused(&desk.plan, &other).contains("the device is mock 2, and was mock 1"));
    let mut plan = desk.plan.clone();
    plan.calibration.motor.force_n[1] = 4.0;
    assert!(refused(&plan, &Mock::default()).contains("the calibration is "));
    let plan = Plan { rate_hz: 60.0, seed: Some(4), ..desk.plan.clone() };
    let expect = format!(
        "cannot go on with {}: the device is mock 2, and was mock 1; the rate is 60 Hz, and was 120 Hz; the seed is 4, \
         and was {}; begin a new session, or restore what this one began with",
        plan.layout.session(&plan.participant, &plan.session).display(),
        crate::seed_of(&plan.study)
    );
    assert_eq!(refused(&plan, &other), expect);
}

#[test]
fn a_blinded_session_shows_neither_modes_nor_voltages_and_its_files_hold_codes() {
    let desk = Desk::new(true);
    let mut views: Vec<View> = Vec::new();
    let mut front = somebody(|view: &View| {
        views.push(view.clone());
        None
    });
    desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    drop(front);
    assert!(views.iter().all(|v| v.blinded && v.trial.as_ref().is_none_or(|t| t.mode.is_none())));
    assert!(views.iter().flat_map(|v| &v.trace).all(|p| p.voltages.is_none()));
    assert!(views.iter().any(|v| !v.trace.is_empty()));
    let data = desk.data();
    let codes: std::collections::BTreeSet<&ModeId> =
        data.trials.iter().map(|t| &t.meta.mode).collect();
    assert_eq!(codes.len(), TRIALS);
    assert!(data.trials.iter().all(|t| t.sealed.is_some()) && data.counting().count() == 0);
    let shown = format!("{:?}", views);
    for word in ["active", "passive", "hybrid", "Active", "Passive", "Hybrid"] {
        assert!(!shown.contains(word), "{word}");
        assert!(!std::fs::read_to_string(&data.sessions[0].path).unwrap().contains(word), "{word}");
    }
    let record = &data.sessions[0].record;
    assert_eq!((record.seed, verify(&desk.plan.layout)), (None, vec![]));
    let seal =
        crate::vault::find(&RealFiles, &desk.plan.keys, desk.plan.layout.study(), record).unwrap();
    append_events(&RealFiles, &data.sessions[0].events_path, UTC, &[seal.event()]).unwrap();
    assert_eq!(desk.data().counting().count(), TRIALS - 1);
}

#[test]
fn a_blinded_session_cut_short_resumes_from_its_seal_and_repeats_keep_their_mode() {
    let desk = Desk::new(true);
    let full = full(&Arc::new(Mutex::new(150)));
    desk.run(&mut Mock::default(), &full, &mut diligent()).unwrap_err();
    recover(&RealFiles, &desk.plan.layout, UTC);
    let elsewhere = Plan { keys: PathBuf::from("/nonexistent"), ..desk.plan.clone() };
    let refused = Session::open(&elsewhere, Mock::default().capabilities(), &RealFiles);
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("--key"), "{error}");
    desk.run(&mut Mock::default(), &Unsynced, &mut diligent()).unwrap();
    let log = desk.data().sessions[0].clone();
    let seal =
        crate::vault::find(&RealFiles, &desk.plan.keys, desk.plan.layout.study(), &log.record)
            .unwrap();
    append_events(&RealFiles, &log.events_path, UTC, &[seal.event()]).unwrap();
    let data = desk.data();
    assert_eq!(verify(&desk.plan.layout), []);
    assert_eq!(data.counting().count(), TRIALS - 1);
    assert!(data.trials.iter().any(|t| t.superseded_by.is_some()));
}

#[test]
fn a_signal_leaves_the_session_in_order() {
    let desk = Desk::new(false);
    let quit = Arc::clone(&desk.options.quit);
    let mut front = somebody(|view: &View| {
        quit.store(view.done == 3, Ordering::SeqCst);
        None
    });
    let outcome = desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    assert_eq!((outcome.done, outcome.interrupted), (3, true));
    assert_eq!(verify(&desk.plan.layout), []);
    assert!(desk.root().join("raw/small/sessions/P01_S01.json").exists());
}

#[test]
fn a_participant_without_a_number_is_told_how_it_is_counterbalanced_and_the_log_says_so() {
    let mut desk = Desk::new(false);
    (desk.plan.participant, desk.plan.session) = ("anna".parse().unwrap(), "pre".parse().unwrap());
    let mut said = Vec::new();
    let mut front = somebody(|view: &View| {
        said = view.messages.iter().cloned().collect();
        (view.done == 1).then_some(Input::Quit)
    });
    desk.run(&mut Mock::default(), &RealFiles, &mut front).unwrap();
    drop(front);
    assert!(said.iter().any(|m| m.contains("anna ends in no number")), "{said:?}");
    let log = desk.data().sessions[0].clone();
    let noted = |word: &str| {
        log.events.iter().any(|e| matches!(e, Event::Note { text, .. } if text.contains(word)))
    };
    assert!(noted("participant anna ends in no number") && noted("session pre ends in no number"));
    let order = log.record.order.unwrap();
    assert_eq!((order.participant_number, order.session_number), (1, 1));
    assert_eq!(verify(&desk.plan.layout), []);
}
