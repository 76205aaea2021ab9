//! A device that is never left alone.
//!
//! In real time a thread of its own holds the device for a whole session, and the caller gives it
//! one task after another. Between tasks it keeps reading at 0 V, so the turn of the shaft stays
//! known whatever the caller is waiting for: a disk, a screen, a person. On a simulated clock no
//! time passes between two tasks, and everything happens on the caller's thread.

use crate::trial::{Collected, POLL, panic_trip, read_on, run_caught};
use crate::{
    BatchSink, Clock, Controller, Device, DeviceError, Guard, Priority, Refusal, TrialEnd,
    TrialPlan, TrialRun, Trip, run_trial,
};
use rtrb::{Consumer, Producer, RingBuffer};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::slice::from_ref;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, Scope};
use zwidth_study::{Calibration, Mode, Sample, Voltages};

/// Without a known turn there is nothing to read for, and orders are looked for so often, s.
const UNHOMED_S: f64 = 0.005;

/// A device with all that belongs to it.
pub struct Station<'a> {
    /// The device.
    pub device: &'a mut dyn Device,
    /// Its time.
    pub clock: &'a mut dyn Clock,
    /// The guard before its actuators.
    pub guard: Guard,
    /// Ticks per second between tasks, Hz.
    pub(crate) rate_hz: f64,
    /// The fault that was found between tasks. The device is not homed since.
    fault: Option<Trip>,
}

/// A trial to be run.
pub struct TrialTask<'a> {
    /// Its plan.
    pub plan: TrialPlan<'a>,
    /// The mode, whose voltages it may use.
    pub mode: &'a Mode,
    /// The forces that these voltages stand for.
    pub calibration: &'a Calibration,
    /// The control, at its beginning.
    pub controller: Controller,
    /// Raised to end it.
    pub stop: &'a AtomicBool,
}

impl<'a> Station<'a> {
    /// A device that is read `rate_hz` times per second between tasks. It is not homed yet.
    pub fn new(
        device: &'a mut dyn Device,
        clock: &'a mut dyn Clock,
        guard: Guard,
        rate_hz: f64,
    ) -> Self {
        Self { device, clock, guard, rate_hz, fault: None }
    }

    /// Homes ([`Guard::home`]). Earlier faults are cleared.
    ///
    /// # Errors
    /// A device that is lost, or a lever that is not at its stop.
    pub fn home(&mut self) -> Result<(), DeviceError> {
        self.fault = None;
        let now_s = self.clock.now_s();
        self.guard.home(self.device, now_s)
    }

    /// Both actuators to 0 V.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn off(&mut self) -> Result<(), DeviceError> {
        let now_s = self.clock.now_s();
        self.device.write(now_s, Voltages::OFF)
    }

    /// The cause of a trip: a trip that only says that the turn is not known is due to a fault that
    /// was found between tasks.
    pub fn cause(&mut self, trip: Trip) -> Trip {
        if trip == Trip::NotHomed { self.fault.take().unwrap_or(trip) } else { trip }
    }

    /// Reads on at 0 V between tasks, for as long as `idle` says so at each tick; returns whether a
    /// fault was found.
    fn read_on(&mut self, idle: &mut dyn FnMut(f64) -> bool) -> bool {
        if !self.guard.is_homed() {
            let now_s = self.clock.now_s();
            idle(self.clock.wait_until(now_s + UNHOMED_S));
            return false;
        }
        let device = &mut *self.device;
        let clock = &mut *self.clock;
        let guard = &mut self.guard;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            read_on(device, clock, guard, self.rate_hz, idle, &mut |_, _, _| {})
        }))
        .unwrap_or_else(|panic| Err(panic_trip(&*panic)));
        self.fault = outcome.err();
        if self.fault.is_some() {
            // Nobody reads the device after this, so its turn may be lost.
            self.guard.lose();
        }
        self.fault.is_some()
    }
}

/// A task for a station.
type Order<'a> = Box<dyn FnOnce(&mut Station<'a>) + Send + 'a>;

/// Gives a station one task after another. Once it is dropped, the last thing written is 0 V.
pub struct Attendant<'a>(Place<'a>);

/// Where the station is.
enum Place<'a> {
    /// With the caller.
    Here(Box<Station<'a>>),
    /// On a thread of its own.
    There { orders: Producer<Order<'a>>, shared: Arc<Shared> },
}

/// What the two threads share besides the orders.
#[derive(Default)]
struct Shared {
    /// The station's time, s, by its bits.
    now: AtomicU64,
    /// A fault was found between tasks.
    fault: AtomicBool,
    /// No more orders will come.
    closing: AtomicBool,
}

impl Shared {
    fn tell_time(&self, now_s: f64) {
        self.now.store(now_s.to_bits(), Ordering::Relaxed);
    }
}

impl<'a> Attendant<'a> {
    /// On the caller's thread: between two tasks no time passes.
    pub fn here(station: Station<'a>) -> Self {
        Self(Place::Here(Box::new(station)))
    }

    /// In real time: on a thread of its own, at an elevated priority where that is allowed.
    pub fn in_real_time<'scope>(scope: &'scope Scope<'scope, '_>, station: Station<'a>) -> Self
    where
        'a: 'scope,
    {
        let shared = Arc::<Shared>::default();
        // Before the thread runs: the caller may ask for the time at once.
        shared.tell_time(station.clock.now_s());
        let (orders, received) = RingBuffer::new(1); // one order at a time
        let shared_by_thread = Arc::clone(&shared);
        scope.spawn(move || attend(station, received, &shared_by_thread));
        Self(Place::There { orders, shared })
    }

    /// The station's time at its last tick, s.
    pub fn now_s(&mut self) -> f64 {
        match &mut self.0 {
            Place::Here(station) => station.clock.now_s(),
            Place::There { shared, .. } => f64::from_bits(shared.now.load(Ordering::Relaxed)),
        }
    }

    /// A fault that was found between tasks, reported once: the turn of the shaft is no longer
    /// known.
    pub fn fault(&mut self) -> Option<Trip> {
        let Place::There { shared, .. } = &self.0 else { return None };
        if !shared.fault.swap(false, Ordering::Relaxed) {
            return None;
        }
        // A panic on the station's thread is a fault, too.
        self.ask(|station| station.fault.take()).unwrap_or_else(Some)
    }

    /// Gives the station a task, and waits for the result.
    ///
    /// # Errors
    /// [`Trip::Panic`] if it panics on the station's own thread.
    pub fn ask<T: Send + 'a>(
        &mut self,
        work: impl FnOnce(&mut Station<'a>) -> T + Send + 'a,
    ) -> Result<T, Trip> {
        match &mut self.0 {
            Place::Here(station) => Ok(work(station)),
            Place::There { orders, shared } => wait_for(orders, shared, work, &mut || {}),
        }
    }

    /// Has the station run a trial, armed with its mode. In real time the caller's thread is given
    /// the samples that have come, every 5 ms; the batch may be empty. However long it takes
    /// for them, the loop does not wait for it; should it fall 10 s behind, samples are lost,
    /// counted, and the trial does not count as run to its end. On a simulated clock each
    /// sample is a batch.
    ///
    /// In real time a panic of the loop is a [`Trip::Panic`], and a panic of `batch` stops the
    /// trial and goes on.
    ///
    /// # Errors
    /// A mode that is not to be used on this device.
    pub fn run_trial(
        &mut self,
        task: TrialTask<'a>,
        batch: &mut BatchSink<'_>,
    ) -> Result<TrialRun, Refusal> {
        match &mut self.0 {
            Place::Here(station) => task.run(station, |station, controller, plan, stop| {
                let Station { device, clock, guard, .. } = station;
                let mut sink = |sample: &Sample| batch(from_ref(sample));
                run_trial(*device, *clock, controller, guard, plan, stop, &mut sink)
            }),
            Place::There { orders, shared } => {
                let (mut collected, mut ring) = Collected::new(task.plan.rate_hz);
                let work = move |station: &mut Station<'a>| {
                    task.run(station, |station, controller, plan, stop| {
                        let Station { device, clock, guard, .. } = station;
                        let mut sink = |sample: &Sample| ring.push(sample);
                        run_caught(*device, *clock, controller, guard, plan, stop, &mut sink)
                    })
                };
                let abandon = collected.abandon_on_panic();
                let run = wait_for(orders, shared, work, &mut || collected.hand_over(batch));
                drop(abandon);
                // Samples that came after the last look at the ring.
                collected.hand_over(batch);
                let run = run.unwrap_or_else(|trip| Ok(TrialRun::tripped(trip)))?;
                Ok(collected.conclude(run))
            }
        }
    }
}

impl<'a> TrialTask<'a> {
    /// Arms the guard and runs the trial. If it could not begin because the turn is not known, its
    /// end says why the turn was lost.
    fn run(
        mut self,
        station: &mut Station<'a>,
        run: impl FnOnce(&mut Station<'a>, &mut Controller, &TrialPlan<'a>, &AtomicBool) -> TrialRun,
    ) -> Result<TrialRun, Refusal> {
        station.guard.arm(self.mode, self.calibration)?;
        let mut run = run(station, &mut self.controller, &self.plan, self.stop);
        if let TrialEnd::Tripped(trip) = run.end {
            run.end = TrialEnd::Tripped(station.cause(trip));
        }
        Ok(run)
    }
}

impl Drop for Attendant<'_> {
    fn drop(&mut self) {
        match &mut self.0 {
            // A device that is lost was told, and has its watchdog.
            Place::Here(station) => _ = station.off(),
            Place::There { shared, .. } => shared.closing.store(true, Ordering::Relaxed),
        }
    }
}

/// Has the station's thread do `work`, and calls `meanwhile` again and again until it is done.
fn wait_for<'a, T: Send + 'a>(
    orders: &mut Producer<Order<'a>>,
    shared: &Arc<Shared>,
    work: impl FnOnce(&mut Station<'a>) -> T + Send + 'a,
    meanwhile: &mut dyn FnMut(),
) -> Result<T, Trip> {
    let (mut answer, mut answered) = RingBuffer::new(1);
    let shared = Arc::clone(shared);
    let caller = thread::current();
    // Neither ring is ever full: each has room for one, and the order before was answered.
    let _ = orders.push(Box::new(move |station: &mut Station<'a>| {
        let done = catch_unwind(AssertUnwindSafe(|| work(station)));
        // Before the answer: whoever has that may ask for the time at once.
        shared.tell_time(station.clock.now_s());
        let _ = answer.push(done.map_err(|panic| panic_trip(&*panic)));
        caller.unpark();
    }));
    loop {
        meanwhile();
        // Before `pop`: a thread may answer and end between the two, and its answer counts.
        let gone = answered.is_abandoned() || orders.is_abandoned();
        match answered.pop() {
            Ok(done) => return done,
            Err(_) if gone => return Err(Trip::Panic { what: "its thread has ended".to_owned() }),
            Err(_) => thread::park_timeout(POLL),
        }
    }
}

/// The station's thread: carries out orders, and reads on between them, tick by tick.
fn attend<'a>(mut station: Station<'a>, mut orders: Consumer<Order<'a>>, shared: &Shared) {
    Priority::raise();
    loop {
        match orders.pop() {
            // Orders first: what was given before the closing is still carried out.
            Ok(order) => order(&mut station),
            Err(_) if shared.closing.load(Ordering::Relaxed) => break,
            Err(_) => {
                let is_faulty = station.read_on(&mut |now_s| {
                    shared.tell_time(now_s);
                    orders.is_empty() && !shared.closing.load(Ordering::Relaxed)
                });
                if is_faulty {
                    shared.fault.store(true, Ordering::Relaxed);
                }
            }
        }
    }
    // A device that is lost was reported, and has its watchdog.
    let _ = station.off();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::{Fault, Mock, SharedClock};
    use crate::participant::intent::tests::SPRING;
    use crate::trial::tests::{LIMITS, controller, environment, mode, plan};
    use crate::watch;
    use std::ops::ControlFlow;
    use zwidth_study::{Environment, Scene};

    const RATE_HZ: f64 = 120.0;

    fn station<'a>(device: &'a mut Mock, clock: &'a mut SharedClock) -> Station<'a> {
        let guard = Guard::new(&device.capabilities, LIMITS, false);
        Station::new(device, clock, guard, RATE_HZ)
    }

    /// What is asked of an attendant in real time; what comes of it, and the device afterwards.
    fn attended<T>(
        device: Mock,
        ask: impl for<'a> FnOnce(&mut Attendant<'a>, &SharedClock) -> T,
    ) -> (T, Mock) {
        let mut device = device.resting();
        let clock = SharedClock::default();
        let mut of_device = clock.clone();
        let station = station(&mut device, &mut of_device);
        let found =
            thread::scope(|scope| ask(&mut Attendant::in_real_time(scope, station), &clock));
        (found, device)
    }

    fn homed(attendant: &mut Attendant<'_>) {
        attendant.ask(Station::home).unwrap().unwrap();
    }

    #[test]
    fn while_nothing_is_asked_the_device_is_read_at_every_tick_at_0_v() {
        let (homed_s, device) = attended(Mock::default(), |attendant, clock| {
            homed(attendant);
            let (homed_s, until_s) = clock.stand(5.0);
            assert!(attendant.now_s() > until_s - 1.0 && attendant.fault().is_none());
            assert!(attendant.ask(|station| station.guard.is_homed()).unwrap());
            homed_s
        });
        let writes: Vec<f64> =
            device.writes.iter().map(|(at_s, _)| *at_s).filter(|s| *s > homed_s).collect();
        assert!(
            writes.len() >= 600 && writes.windows(2).all(|pair| pair[1] - pair[0] < 1.01 / RATE_HZ)
        );
        assert!(device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
    }

    #[test]
    fn what_is_found_while_nothing_is_asked_is_told_once_and_is_over_after_homing() {
        let (told, _) =
            attended(Mock::default().failing(2.0, Fault::AngleStops), |attendant, clock| {
                homed(attendant);
                clock.stand(5.0);
                let told = attendant.fault();
                assert_eq!(attendant.fault(), None);
                assert!(!attendant.ask(|station| station.guard.is_homed()).unwrap());
                clock.stand(1.0);
                assert_eq!(attendant.fault(), None, "without a turn to keep nothing is read");
                homed(attendant);
                clock.stand(1.0);
                homed(attendant);
                told
            });
        assert!(matches!(told, Some(Trip::Stale { sensor: "angle", .. })), "{told:?}");
    }

    #[test]
    fn what_finds_no_turn_says_why_there_is_none() {
        let (why, _) =
            attended(Mock::default().failing(1.0, Fault::AngleOff(0.5)), |attendant, clock| {
                homed(attendant);
                clock.stand(2.0);
                let looked = |station: &mut Station<'_>| {
                    let Station { device, clock, guard, .. } = station;
                    let (stop, until_s) = (AtomicBool::default(), clock.now_s() + 1.0);
                    let found =
                        watch(*device, *clock, guard, RATE_HZ, until_s, &stop, &mut |_, _, _| {});
                    found.map_err(|trip| station.cause(trip)).unwrap_err()
                };
                attendant.ask(looked).unwrap()
            });
        assert!(matches!(why, Trip::Angle(_)), "{why}");
    }

    #[test]
    fn a_panic_is_told_the_device_is_at_0_v_and_the_thread_goes_on() {
        let (asked, device) =
            attended(Mock::default().failing(3.0, Fault::Panic), |attendant, clock| {
                let asked =
                    attendant.ask(|_| -> u8 { panic!("out of cheese") }).unwrap_err().to_string();
                homed(attendant);
                clock.stand(4.0);
                let found = attendant.fault().unwrap().to_string();
                assert!(found.contains("asked to"), "{found}");
                attendant.ask(|station| station.off()).unwrap().unwrap();
                asked
            });
        assert!(asked.contains("out of cheese"), "{asked}");
        assert_eq!(device.writes.last().unwrap().1, Voltages::OFF);
    }

    /// What a trial needs that outlives a session.
    struct Place {
        environment: Environment,
        mode: Mode,
        calibration: Calibration,
        stop: AtomicBool,
    }

    impl Place {
        fn new() -> Self {
            Self {
                environment: environment(Scene::Spring(SPRING)),
                mode: mode(),
                calibration: Calibration::thesis(),
                stop: AtomicBool::default(),
            }
        }

        fn task(&self) -> TrialTask<'_> {
            let Self { environment, mode, calibration, stop } = self;
            let controller = controller(environment, mode);
            TrialTask { plan: plan(environment), mode, calibration, controller, stop }
        }
    }

    /// A trial, and a second of rest; how it ended, and its samples.
    fn trial<'a>(
        place: &'a Place,
        attendant: &mut Attendant<'a>,
        keep: usize,
    ) -> (TrialEnd, Vec<Sample>) {
        let mut samples = Vec::new();
        attendant.ask(Station::home).unwrap().unwrap();
        let mut batch = |batch: &[Sample]| {
            samples.extend_from_slice(batch);
            if samples.len() < keep { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        let run = attendant.run_trial(place.task(), &mut batch).unwrap();
        (run.end, samples)
    }

    #[test]
    fn a_trial_is_the_same_on_the_caller_s_thread_and_on_its_own_and_the_turn_stays_known_after_it()
    {
        let place = Place::new();
        let (mut device, mut clock) = (Mock::default().resting(), SharedClock::default());
        let (end, samples) =
            trial(&place, &mut Attendant::here(station(&mut device, &mut clock)), usize::MAX);
        let (mut device, mut clock) = (Mock::default().resting(), SharedClock::default());
        let of_test = clock.clone();
        let station = station(&mut device, &mut clock);
        let (end_there, samples_there) = thread::scope(|scope| {
            let mut attendant = Attendant::in_real_time(scope, station);
            let found = trial(&place, &mut attendant, usize::MAX);
            of_test.stand(5.0);
            assert_eq!(attendant.fault(), None);
            assert!(attendant.ask(|s| s.guard.is_homed()).unwrap());
            found
        });
        // It begins at another time there, by whose rounding half a second of rest ends a tick
        // later.
        assert!(
            samples.len().abs_diff(samples_there.len()) <= 1,
            "{} and {}",
            samples.len(),
            samples_there.len()
        );
        assert_eq!(end, TrialEnd::LetGo);
        assert_eq!(end, end_there);
        let close = |(a, b): (&Sample, &Sample)| {
            (a.t_s - b.t_s).abs() < 1e-9 && (a.force_cmd_n - b.force_cmd_n).abs() < 0.01
        };
        assert!(samples.iter().zip(&samples_there).all(close));
        assert_eq!(device.writes.last().unwrap().1, Voltages::OFF);
        assert!(device.writes.iter().any(|(_, v)| *v != Voltages::OFF));
    }

    #[test]
    fn a_trial_whose_samples_cannot_be_kept_ends_at_0_v_on_either_thread() {
        let place = Place::new();
        let (mut device, mut clock) = (Mock::default().resting(), SharedClock::default());
        let (end, _) = trial(&place, &mut Attendant::here(station(&mut device, &mut clock)), 100);
        assert_eq!(end, TrialEnd::Tripped(Trip::Storage));
        let (mut device, mut clock) = (Mock::default().resting(), SharedClock::default());
        let station = station(&mut device, &mut clock);
        let (end, _) =
            thread::scope(|scope| trial(&place, &mut Attendant::in_real_time(scope, station), 100));
        assert_eq!(end, TrialEnd::Tripped(Trip::Storage));
        assert_eq!(device.writes.last().unwrap().1, Voltages::OFF);
    }
}
