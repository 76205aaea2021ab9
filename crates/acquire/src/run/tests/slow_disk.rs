//! A disk that stands still for seconds, in real time: the device is read all the while.

use super::*;
use crate::flow::EMERGENCY_STOP;
use std::cell::Cell;
use std::sync::Condvar;
use zwidth_device::mock::SharedClock;
use zwidth_device::{Capabilities, Cue, DeviceError, Reading};
use zwidth_store::verify_kept;

/// A lever that somebody swings all the time, whatever else goes on: its shaft turns 1.6 times a
/// second at most.
struct Swinging {
    mock: Mock,
    homed_s: f64,
    log: Arc<Mutex<Log>>,
    gate: Option<Gate>,
}

/// The loop does not pass this time of the second trial, s, before the gate is opened.
const GATE_S: f64 = 1.0;

#[derive(Clone, Default)]
struct Gate(Arc<(Mutex<bool>, Condvar)>);

impl Gate {
    fn open(&self) {
        *self.0.0.lock().unwrap() = true;
        self.0.1.notify_all();
    }

    fn pass(&self) {
        let patience = Duration::from_secs(20);
        drop(
            self.0.1.wait_timeout_while(self.0.0.lock().unwrap(), patience, |open| !*open).unwrap(),
        );
    }
}

/// What became of the device.
#[derive(Default)]
struct Log {
    read_s: f64,
    /// The longest time between two readings, s.
    longest_s: f64,
    homings: u32,
    begun_s: Vec<f64>,
    writes: Vec<(f64, Voltages)>,
}

fn swinging(t_s: f64) -> (f64, f64) {
    let phase = t_s * std::f64::consts::TAU / 2.3;
    (30_f64.to_radians() * (1.0 - phase.cos()) - 45_f64.to_radians(), 3.0)
}

impl Device for Swinging {
    fn capabilities(&self) -> &Capabilities {
        self.mock.capabilities()
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let mut log = self.log.lock().unwrap();
        (log.homings, log.read_s, self.homed_s) = (log.homings + 1, now_s, now_s);
        self.mock.home(now_s)
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let mut log = self.log.lock().unwrap();
        log.longest_s = log.longest_s.max(now_s - log.read_s);
        log.read_s = now_s;
        let at_gate = log.begun_s.get(1).is_some_and(|begun_s| now_s > begun_s + GATE_S);
        drop(log);
        if let Some(gate) = self.gate.take_if(|_| at_gate) {
            gate.pass();
        }
        self.mock.read(now_s - self.homed_s)
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.log.lock().unwrap().writes.push((now_s, voltages));
        Ok(())
    }

    fn begin(&mut self, now_s: f64, _cue: &Cue<'_>) {
        self.log.lock().unwrap().begun_s.push(now_s);
    }
}

/// A session in real time with this device, on a disk that is waited for so before a write or a
/// sync: of which file, and whether a running trial waits for it.
fn live(
    desk: &mut Desk,
    mut device: Swinging,
    clock: &SharedClock,
    wait: impl Fn(&Path, bool) + Sync + Send + 'static,
    front: &mut dyn Front,
) -> (Outcome, Log) {
    desk.options.live = true;
    let session = Session::open(&desk.plan, device.capabilities(), &RealFiles).unwrap();
    let files = Heard::new(move |request| {
        match request {
            Request::Append(path, _) => {
                wait(path, path.extension().is_some_and(|e| e == "journal"));
            }
            Request::Write(path, _) | Request::Sync(path) => wait(path, false),
            _ => {}
        }
        Ok(())
    });
    let mut clock = clock.clone();
    let parts = Parts {
        device: &mut device,
        clock: &mut clock,
        files: &files,
        front,
        utc: &|_| UTC.to_owned(),
        judge: &|_| None,
    };
    let outcome = run(&desk.plan, session, &desk.options, parts).unwrap();
    (outcome, std::mem::take(&mut device.log.lock().unwrap()))
}

impl Swinging {
    fn new(mock: Mock) -> Self {
        Self { mock, homed_s: 0.0, log: Arc::default(), gate: None }
    }
}

/// How long the disk stands still at each write and sync between trials, s.
const STANDS_S: f64 = 5.0;
/// …and at an append while a trial runs, s: as long as the samples of a whole append take.
const APPEND_S: f64 = 0.05;
/// A loop of 120 Hz reads more often than this, s.
const LONGEST_S: f64 = 0.02;

#[test]
fn the_turn_stays_known_and_nothing_is_driven_while_the_disk_stands_still_for_seconds() {
    let mut desk = Desk::new(false);
    let (clock, stood) = (SharedClock::default(), Arc::<Mutex<Vec<(f64, f64)>>>::default());
    let (of_disk, spans) = (clock.clone(), Arc::clone(&stood));
    let wait = move |_: &Path, in_trial: bool| {
        let span = of_disk.stand(if in_trial { APPEND_S } else { STANDS_S });
        if !in_trial {
            spans.lock().unwrap().push(span);
        }
    };
    let (outcome, log) =
        live(&mut desk, Swinging::new(Mock::new(swinging)), &clock, wait, &mut quits_after(2));
    assert_eq!((outcome.stopped, outcome.done, log.homings), (None, 2, 1));
    assert!(log.longest_s < LONGEST_S, "not read for {} s", log.longest_s);
    let stood = stood.lock().unwrap();
    assert!(stood.len() > 20, "{stood:?}");
    for (at_s, voltages) in log.writes.iter().filter(|(_, v)| *v != Voltages::OFF) {
        let span = stood.iter().find(|(from_s, until_s)| (*from_s..*until_s).contains(at_s));
        assert_eq!(span, None, "{voltages:?} at {at_s}");
    }
    assert!(log.writes.iter().any(|(_, v)| *v != Voltages::OFF));
    assert_eq!(verify_kept(&RealFiles, &desk.plan.layout), []);
}

#[test]
fn a_disk_that_stands_still_for_seconds_within_a_trial_costs_no_sample() {
    let mut desk = Desk::new(false);
    let (clock, stood) = (SharedClock::default(), Arc::<Mutex<Option<(f64, f64)>>>::default());
    let (of_disk, span) = (clock.clone(), Arc::clone(&stood));
    let wait = move |path: &Path, in_trial: bool| {
        let begun = std::fs::metadata(path).is_ok_and(|m| m.len() > 0);
        let second = in_trial && begun && path.to_string_lossy().contains("trial-002");
        let mut span = span.lock().unwrap();
        if second && span.is_none() {
            *span = Some(of_disk.stand(STANDS_S));
        }
    };
    let (outcome, log) =
        live(&mut desk, Swinging::new(Mock::new(swinging)), &clock, wait, &mut quits_after(2));
    assert_eq!((outcome.stopped, outcome.done, log.homings), (None, 2, 1));
    let (from_s, until_s) = stood.lock().unwrap().unwrap();
    // The clock's sums round.
    assert!(until_s - from_s >= STANDS_S - 1e-9, "it stood for {} s", until_s - from_s);
    assert!(log.longest_s < LONGEST_S, "not read for {} s", log.longest_s);
    let data = desk.data();
    let expect = (desk.plan.study.design.trial_limit_s * desk.plan.rate_hz) as usize;
    for trial in &data.trials {
        assert_eq!(trial.meta.status, Status::Complete);
        assert!(trial.rows.abs_diff(expect) <= 2, "{} of {expect} samples", trial.rows);
    }
    assert_eq!(verify_kept(&RealFiles, &desk.plan.layout), []);
}

#[test]
fn an_emergency_stop_is_obeyed_at_once_while_the_disk_stands_still() {
    let mut desk = Desk::new(false);
    let (clock, gate) = (SharedClock::default(), Gate::default());
    let (stop, stopped_s) = (Arc::clone(&desk.options.stop), Arc::<Mutex<Option<f64>>>::default());
    let device = Swinging { gate: Some(gate.clone()), ..Swinging::new(Mock::new(swinging)) };
    let (of_disk, told) = (clock.clone(), Arc::clone(&stopped_s));
    let wait = move |path: &Path, in_trial: bool| {
        let begun = std::fs::metadata(path).is_ok_and(|m| m.len() > 0);
        let second = in_trial && begun && path.to_string_lossy().contains("trial-002");
        let mut told = told.lock().unwrap();
        if second && told.is_none() {
            // Voltages are on, somebody hits the stop key, and the disk does not come back.
            *told = Some(of_disk.is_s());
            stop.store(true, Ordering::SeqCst);
            gate.open();
            of_disk.stand(STANDS_S);
        }
    };
    let (outcome, log) = live(&mut desk, device, &clock, wait, &mut diligent());
    assert_eq!((outcome.stopped.as_deref(), outcome.done), (Some(EMERGENCY_STOP), 1));
    let stopped_s = stopped_s.lock().unwrap().unwrap();
    let last_on_s = log.writes.iter().rfind(|(_, v)| *v != Voltages::OFF).unwrap().0;
    assert!(
        (last_on_s - stopped_s).abs() < 2.0 / 120.0 + 1e-6,
        "on at {last_on_s}, stopped at {stopped_s}"
    );
    assert_eq!(desk.data().trials[1].meta.status, Status::Incomplete);
}

#[test]
fn a_turn_that_is_lost_in_a_pause_stops_the_session_with_the_reason() {
    let mut desk = Desk::new(false);
    let clock = SharedClock::default();
    // So long after homing the turn seems another, while the session rests.
    let device = Swinging::new(Mock::new(swinging).failing(30.0, Fault::AngleOff(0.4)));
    let of_front = clock.clone();
    let mut front = somebody(move |view: &View| {
        if view.done == 1 && matches!(view.phase, Shown::Pause { .. }) {
            of_front.stand(30.0);
        }
        None
    });
    let (outcome, _) = live(&mut desk, device, &clock, |_, _| {}, &mut front);
    let why = outcome.stopped.unwrap();
    assert!(why.contains("the turns can no longer be counted") && outcome.done == 1, "{why}");
}

#[test]
fn a_trial_is_no_part_of_the_pause_after_it() {
    let mut desk = Desk::new(false);
    desk.plan.study.environments.iter_mut().for_each(|e| e.question = None);
    desk.plan.study.design.pause_s = 1e6;
    let device = Swinging::new(Mock::new(swinging));
    let (clock, log) = (SharedClock::default(), Arc::clone(&device.log));
    let limit_s = desk.plan.study.design.trial_limit_s;
    let (of_front, rested) = (clock.clone(), Cell::new(0.0));
    let mut front = somebody(|view: &View| {
        let Shown::Pause { left_s, pause_s } = view.phase else { return None };
        let ended_s = log.lock().unwrap().begun_s[0] + limit_s;
        rested.set(pause_s - left_s);
        // The loop's last tick may come a period before the time is up.
        assert!(
            rested.get() <= of_front.is_s() - ended_s + LONGEST_S,
            "{} s of rest",
            rested.get()
        );
        (rested.get() > 0.0).then_some(Input::Quit)
    });
    live(&mut desk, device, &clock, |_, _| {}, &mut front);
    assert!(rested.get() > 0.0);
}
