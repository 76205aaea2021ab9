//! Trials of a mock, through every fault; and what the tests of this crate share.

use super::*;
use crate::mock::{self, Fault, Mock, Motion, forward_and_back};
use crate::participant::intent::tests::SPRING;
use crate::{Angle, AngleFault, Limits, SimulatedClock};
use std::f64::consts::{FRAC_PI_4, PI};
use std::panic::{AssertUnwindSafe, catch_unwind};
use zwidth_study::{Calibration, Control, Mode, Moment, Scene, Spring, Voltages};

pub(crate) const TICK_S: f64 = 1e-3;
/// When faults begin: the lever is on its way, and every mode has a voltage on.
const FAULT_S: f64 = 0.6;

/// A trial of the hybrid mode in the thesis' spring, ready to be run.
pub(crate) struct Bench {
    pub(crate) device: Mock,
    pub(crate) guard: Guard,
    pub(crate) controller: Controller,
    pub(crate) environment: Environment,
    shows_moments: bool,
}

/// The work space of the mock.
pub(crate) const LIMITS: Limits =
    Limits { theta_min_rad: -FRAC_PI_4, theta_max_rad: FRAC_PI_4, force_n: 10.0 };

pub(crate) fn mode_of(motor_max_v: Option<f64>, brake_max_v: Option<f64>) -> Mode {
    Mode {
        id: "m".parse().unwrap(),
        label: String::new(),
        motor_max_v,
        brake_max_v,
        law: None,
        factors: Default::default(),
    }
}

/// The hybrid mode.
pub(crate) fn mode() -> Mode {
    mode_of(Some(8.0), Some(8.0))
}

pub(crate) fn environment(scene: Scene) -> Environment {
    let id = "e".parse().unwrap();
    Environment {
        id,
        label: String::new(),
        scene,
        delay_s: 0.0,
        question: None,
        further: Vec::new(),
        factors: Default::default(),
    }
}

pub(crate) fn controller(environment: &Environment, mode: &Mode) -> Controller {
    Controller::new(&Control::default(), environment, mode, &Calibration::thesis())
}

/// A sample without voltages.
pub(crate) fn sample(t_s: f64, theta_rad: f64, theta_dot_rad_s: f64, force_ex_n: f64) -> Sample {
    Sample {
        t_s,
        t_device_s: None,
        theta_rad,
        theta_dot_rad_s,
        force_ex_n,
        voltages: Voltages::OFF,
        force_age_s: None,
        theta_raw: None,
        force_cmd_n: 0.0,
        flags: Flags::default(),
        extra: zwidth_study::Extra::default(),
    }
}

pub(crate) fn bench(device: Mock) -> Bench {
    let environment = environment(Scene::Spring(SPRING));
    let mut bench = Bench {
        guard: Guard::new(&device.capabilities, LIMITS, false),
        device,
        controller: controller(&environment, &mode()),
        environment,
        shows_moments: false,
    };
    bench.guard.home(&mut bench.device, 0.0).unwrap();
    bench.guard.arm(&mode(), &Calibration::thesis()).unwrap();
    bench
}

pub(crate) fn plan(environment: &Environment) -> TrialPlan<'_> {
    let velocity = Velocity::new(Control::default().velocity).unwrap();
    let cue = Cue { trial: 1, environment, limit_s: 4.0 };
    TrialPlan { cue, varied: None, rate_hz: 1.0 / TICK_S, velocity, shows_moments: false }
}

impl Bench {
    fn run_with(
        &mut self,
        clock: &mut dyn Clock,
        stop: &AtomicBool,
        sink: &mut Sink<'_>,
    ) -> TrialRun {
        let plan = TrialPlan { shows_moments: self.shows_moments, ..plan(&self.environment) };
        run_trial(&mut self.device, clock, &mut self.controller, &mut self.guard, &plan, stop, sink)
    }

    pub(crate) fn run(&mut self) -> (TrialRun, Vec<Sample>) {
        self.run_on(&mut SimulatedClock::new(1))
    }

    fn run_on(&mut self, clock: &mut dyn Clock) -> (TrialRun, Vec<Sample>) {
        let mut samples = Vec::new();
        let mut keep = |sample: &Sample| {
            samples.push(*sample);
            ControlFlow::Continue(())
        };
        let run = self.run_with(clock, &AtomicBool::new(false), &mut keep);
        (run, samples)
    }

    /// Voltage was on at `fault_s`, and off within two ticks of `due_s`; nothing is allowed any
    /// more.
    fn check_off(&self, fault_s: f64, due_s: f64) {
        let last_on = self
            .device
            .writes
            .iter()
            .rposition(|(_, voltages)| *voltages != Voltages::OFF)
            .unwrap();
        let (on_s, off_s) = (self.device.writes[last_on].0, self.device.writes[last_on + 1].0);
        assert!(on_s > fault_s - 2.0 * TICK_S, "nothing was on before the fault: last at {on_s}");
        assert!(off_s <= due_s + 2.0 * TICK_S, "off at {off_s} instead of {due_s}");
        assert!(!self.guard.is_armed());
    }
}

/// Runs into a fault and says what took the voltages away; they are off within two ticks of
/// `due_s`.
fn tripped(device: Mock, due_s: f64) -> (Trip, Bench) {
    let mut bench = bench(device.clone());
    let (run, _) = bench.run();
    bench.check_off(device.faults.first().map_or(0.0, |(from_s, _)| *from_s), due_s);
    match run.end {
        TrialEnd::Tripped(trip) => (trip, bench),
        end => panic!("not tripped: {end:?}"),
    }
}

#[test]
fn a_device_shows_start_contact_and_end_where_it_is_to_and_its_end_by_a_fault_too() {
    let walled = || {
        let mut bench = bench(Mock::default());
        let Scene::Spring(spring) = bench.environment.scene else { panic!("no spring") };
        bench.environment.scene = Scene::SpringWall { spring, wall_rad: -FRAC_PI_4 + 0.5 };
        bench.controller = controller(&bench.environment, &mode());
        bench
    };
    let shown = |mut bench: Bench, shows_moments| {
        bench.shows_moments = shows_moments;
        bench.run();
        bench.device.moments
    };
    assert_eq!(shown(walled(), true), [Moment::Start, Moment::Contact, Moment::End]);
    assert_eq!(shown(walled(), false), []);
    let mut unplugged = walled();
    unplugged.device = unplugged.device.failing(FAULT_S, Fault::Unplugged);
    assert_eq!(shown(unplugged, true), [Moment::Start, Moment::Contact, Moment::End]);
}

#[test]
fn a_trial_ends_by_itself_half_a_second_after_the_participant_let_go_at_0_v() {
    let mut bench = bench(Mock::default());
    let (run, samples) = bench.run();
    assert_eq!(run.end, TrialEnd::LetGo);
    let last = samples.last().unwrap();
    assert!((last.t_s - 2.5).abs() < 0.15, "{}", last.t_s);
    assert_eq!(bench.device.writes.last().unwrap().1, Voltages::OFF);
    assert!(!bench.guard.is_armed() && bench.guard.is_homed());
    assert_eq!((run.timing.ticks, run.timing.missed), (samples.len() as u64, 0));
}

#[test]
fn a_trial_that_is_not_let_go_ends_at_its_limit_at_0_v() {
    let held: Motion = |t_s| (forward_and_back(t_s.min(1.0)).0, 3.0);
    let mut bench = bench(Mock::new(held));
    let (run, samples) = bench.run();
    assert_eq!((run.end, samples.len()), (TrialEnd::Limit, 4000));
    assert!(samples.iter().all(|s| s.t_s < 4.0));
    bench.check_off(4.0, 4.0);
}

#[test]
fn samples_say_what_the_lever_did_and_what_was_commanded() {
    let (_, samples) = bench(Mock::default()).run();
    for sample in &samples {
        let (theta_rad, force_n) = forward_and_back(sample.t_s);
        assert!(
            (sample.theta_rad - theta_rad).abs() < 1.2e-4,
            "more than half a count off at {}",
            sample.t_s
        );
        assert_eq!(sample.force_ex_n.to_bits(), on_steps(force_n).to_bits());
        let Voltages { motor_v, brake_v } = sample.voltages;
        assert_eq!(
            (sample.flags.has(Flags::MOTOR_ON), sample.flags.has(Flags::BRAKE_ON)),
            (motor_v != 0.0, brake_v != 0.0)
        );
    }
    let at = |t_s: f64| samples.iter().find(|s| s.t_s >= t_s).unwrap();
    assert!(at(0.5).voltages.brake_v > 0.0 && at(1.5).voltages.motor_v < 0.0);
    assert!((at(0.5).force_cmd_n - 4.0 * PI / 6.0).abs() < 0.03); // K (θ − θ_rest), half way
    assert!((at(0.5).theta_dot_rad_s - PI * PI / 6.0).abs() < 0.05);
}

#[test]
fn one_seed_gives_one_trial_bit_for_bit() {
    assert_eq!(bench(Mock::default()).run(), bench(Mock::default()).run());
}

#[test]
fn a_stop_request_ends_at_0_v() {
    let mut bench = bench(Mock::default());
    let stop = AtomicBool::new(false);
    let mut sink = |sample: &Sample| {
        stop.store(sample.t_s > FAULT_S, Ordering::Relaxed);
        ControlFlow::Continue(())
    };
    let run = bench.run_with(&mut SimulatedClock::new(1), &stop, &mut sink);
    assert_eq!(run.end, TrialEnd::Stopped);
    bench.check_off(FAULT_S, FAULT_S + TICK_S);
}

#[test]
fn a_full_disk_ends_at_0_v() {
    let mut bench = bench(Mock::default());
    let mut sink = |s: &Sample| {
        if s.t_s > FAULT_S { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let run = bench.run_with(&mut SimulatedClock::new(1), &AtomicBool::new(false), &mut sink);
    assert_eq!(run.end, TrialEnd::Tripped(Trip::Storage));
    bench.check_off(FAULT_S, FAULT_S + TICK_S);
}

#[test]
fn a_panic_of_the_sink_ends_at_0_v() {
    let mut bench = bench(Mock::default());
    let mut sink = |s: &Sample| {
        assert!(s.t_s < FAULT_S, "a sink that fails");
        ControlFlow::Continue(())
    };
    let mut run =
        || bench.run_with(&mut SimulatedClock::new(1), &AtomicBool::new(false), &mut sink);
    assert!(catch_unwind(AssertUnwindSafe(&mut run)).is_err());
    bench.check_off(FAULT_S, FAULT_S + TICK_S);
}

#[test]
fn a_panic_of_the_device_ends_at_0_v() {
    let mut bench = bench(Mock::default().failing(FAULT_S, Fault::Panic));
    assert!(catch_unwind(AssertUnwindSafe(|| bench.run())).is_err());
    bench.check_off(FAULT_S, FAULT_S);
}

#[test]
fn an_unplugged_cable_is_noticed_at_once_and_the_boards_watchdog_turns_it_off() {
    let mut bench = bench(Mock::default().failing(FAULT_S, Fault::Unplugged));
    let (run, _) = bench.run();
    assert!(
        matches!(run.end, TrialEnd::Tripped(Trip::Device(DeviceError::Lost { .. }))),
        "{:?}",
        run.end
    );
    assert_ne!(bench.device.output(FAULT_S), Voltages::OFF);
    assert_eq!(bench.device.output(FAULT_S + 0.05), Voltages::OFF);
    assert!(!bench.guard.is_homed() && !bench.guard.is_armed());
}

#[test]
fn a_sensor_that_stops_ends_at_0_v_after_50_ms() {
    for (fault, name) in [(Fault::AngleStops, "angle"), (Fault::ForceStops, "force")] {
        let (trip, _) = tripped(Mock::default().failing(FAULT_S, fault), FAULT_S + 0.05);
        assert!(matches!(trip, Trip::Stale { sensor, .. } if sensor == name), "{trip:?}");
    }
}

#[test]
fn a_slow_force_sensor_may_be_silent_for_three_of_its_periods() {
    let mut device = Mock::default().failing(FAULT_S, Fault::ForceStops);
    device.capabilities.force_rate_hz = 10.0;
    let mut bench = bench_brake_only(device);
    let (run, _) = bench.run();
    assert!(
        matches!(run.end, TrialEnd::Tripped(Trip::Stale { limit_s, .. }) if (limit_s - 0.3).abs() < 1e-12)
    );
    bench.check_off(FAULT_S, FAULT_S + 0.3);
}

/// The same with the brake alone, which does not switch on the force.
fn bench_brake_only(mut device: Mock) -> Bench {
    let force_rate_hz = std::mem::replace(&mut device.capabilities.force_rate_hz, 80.0);
    let mut bench = bench(device);
    bench.device.capabilities.force_rate_hz = force_rate_hz;
    bench.guard = Guard::new(&bench.device.capabilities, LIMITS, false);
    bench.guard.home(&mut bench.device, 0.0).unwrap();
    let passive = Mode { motor_max_v: None, ..mode() };
    bench.guard.arm(&passive, &Calibration::thesis()).unwrap();
    bench.controller = controller(&bench.environment, &passive);
    bench
}

#[test]
fn what_is_not_a_number_ends_at_0_v() {
    let (trip, _) = tripped(Mock::default().failing(FAULT_S, Fault::ForceNan), FAULT_S);
    assert!(matches!(trip, Trip::NotFinite { what: "the force" }));
    let mut angles = Mock::default().failing(FAULT_S, Fault::AngleNan);
    angles.capabilities.counts_per_turn = None;
    assert!(matches!(tripped(angles, FAULT_S).0, Trip::NotFinite { what: "the angle" }));
}

#[test]
fn a_jump_of_the_angle_ends_at_0_v_and_asks_for_homing() {
    let (trip, mut bench) =
        tripped(Mock::default().failing(FAULT_S, Fault::AngleOff(0.3)), FAULT_S);
    assert!(
        matches!(trip, Trip::Angle(AngleFault::Jump { .. }))
            && trip.to_string().contains("home again")
    );
    assert!(!bench.guard.is_homed());
    bench.guard.arm(&mode(), &Calibration::thesis()).unwrap();
    assert_eq!(bench.run().0.end, TrialEnd::Tripped(Trip::NotHomed));
}

#[test]
fn two_degrees_outside_the_work_space_end_at_0_v() {
    let beyond: Motion = |t_s| (-FRAC_PI_4 + t_s, 1.0); // a radian a second: 47 degrees at 1.6057 s
    let (trip, _) = tripped(Mock::new(beyond), 92_f64.to_radians());
    assert!(
        matches!(trip, Trip::Outside { theta_rad } if (theta_rad.to_degrees() - 47.0).abs() < 0.1),
        "{trip:?}"
    );
}

#[test]
fn a_force_over_the_limit_ends_at_0_v() {
    let (trip, _) = tripped(Mock::default().failing(FAULT_S, Fault::Force(10.1)), FAULT_S);
    assert_eq!(trip, Trip::Force { force_n: 10.1, limit_n: 10.0 });
    let mut bench = bench(Mock::default().failing(FAULT_S, Fault::Force(9.9)));
    assert!(!matches!(bench.run().0.end, TrialEnd::Tripped(_)));
}

/// A clock that, once, is away for a while; or that misses one deadline in so many.
struct Stalling {
    clock: SimulatedClock,
    at_s: f64,
    away_s: f64,
    every: Option<u32>,
    waits: u32,
}

impl Clock for Stalling {
    fn now_s(&mut self) -> f64 {
        self.clock.now_s()
    }
    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        self.waits += 1;
        let stall = deadline_s >= self.at_s
            && self.every.is_none_or(|every| self.waits.is_multiple_of(every));
        if stall && self.every.is_none() {
            self.at_s = f64::INFINITY;
        }
        self.clock.wait_until(if stall { deadline_s + self.away_s } else { deadline_s })
    }
}

fn stalling(at_s: f64, away_s: f64, every: Option<u32>) -> Stalling {
    Stalling { clock: SimulatedClock::new(1), at_s, away_s, every, waits: 0 }
}

fn stalled(away_s: f64, every: Option<u32>) -> (TrialRun, Bench) {
    let mut bench = bench(Mock::default());
    let (run, _) = bench.run_on(&mut stalling(FAULT_S, away_s, every));
    (run, bench)
}

#[test]
fn a_burst_of_missed_deadlines_ends_at_0_v_and_a_hiccup_is_only_counted() {
    let (run, mut bench) = stalled(0.06, None);
    assert!(matches!(run.end, TrialEnd::Tripped(Trip::Deadlines { .. })), "{:?}", run.end);
    bench.check_off(FAULT_S, FAULT_S + 0.06);
    bench.guard.arm(&mode(), &Calibration::thesis()).unwrap();
    assert!(
        !matches!(bench.run().0.end, TrialEnd::Tripped(_)),
        "what was lost is forgiven to the next trial"
    );
    let (run, _) = stalled(0.03, None);
    assert_eq!((run.end, run.timing.missed), (TrialEnd::LetGo, 30));
    assert!(run.timing.lateness.max_s() >= 0.03);
}

/// Found by seed 3013 of `cargo xtask soak simulate`: a machine that slept from a trial's start to
/// beyond its end left a complete trial without a sample.
#[test]
fn a_loop_that_sleeps_through_the_rest_of_a_trial_has_not_completed_it() {
    for at_s in [0.0, FAULT_S, 3.99] {
        let mut bench = bench(Mock::new(|_| (-FRAC_PI_4, 3.0)));
        let (run, _) = bench.run_on(&mut stalling(at_s, 3600.0, None));
        assert!(
            matches!(run.end, TrialEnd::Tripped(Trip::Deadlines { .. })),
            "{at_s}: {:?}",
            run.end
        );
        assert_eq!(bench.device.writes.last().map(|(_, v)| *v), Some(Voltages::OFF));
    }
}

#[test]
fn deadlines_missed_all_the_time_trip_above_one_in_twenty() {
    let (run, _) = stalled(TICK_S, Some(5));
    assert!(matches!(run.end, TrialEnd::Tripped(Trip::Deadlines { .. })), "{:?}", run.end);
    let (run, _) = stalled(TICK_S, Some(30));
    assert!(run.end == TrialEnd::LetGo && run.timing.missed > 50);
}

#[test]
fn a_missed_deadline_is_flagged_on_the_next_sample() {
    let (_, samples) = bench(Mock::default()).run_on(&mut stalling(FAULT_S, 0.01, None));
    let flagged: Vec<f64> =
        samples.iter().filter(|s| s.flags.has(Flags::DROPOUT)).map(|s| s.t_s).collect();
    assert!(flagged.len() == 1 && (flagged[0] - 0.61).abs() < 1e-3, "{flagged:?}");
}

#[test]
fn no_voltage_before_homing_or_without_an_armed_mode() {
    let mut unhomed = bench(Mock::default());
    unhomed.guard.lose();
    let mut unarmed = bench(Mock::default());
    unarmed.guard.disarm();
    for (mut bench, trip) in [(unhomed, Trip::NotHomed), (unarmed, Trip::NotArmed)] {
        let (run, samples) = bench.run();
        assert_eq!((run.end, samples.len()), (TrialEnd::Tripped(trip), 0));
        assert!(bench.device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
    }
}

#[test]
fn the_motor_stays_off_until_the_angle_has_moved_since_homing() {
    let waiting: Motion = |t_s| (-FRAC_PI_4 + if t_s < 0.5 { 0.0 } else { 0.1 }, 0.0);
    let mut bench = bench(Mock::new(waiting));
    let stretched = Spring { stiffness_n_per_rad: 4.0, rest_rad: -1.0 };
    bench.environment.scene = Scene::Spring(stretched);
    bench.controller = controller(&bench.environment, &mode());
    let (_, samples) = bench.run();
    let (before, after): (Vec<Sample>, Vec<Sample>) =
        samples.into_iter().partition(|s| s.t_s < 0.5);
    assert!(before.iter().all(|s| s.voltages == Voltages::OFF && s.flags.has(Flags::CLIPPED)));
    assert!(before.iter().all(|s| s.force_cmd_n == 0.0)); // what went out, not what was asked for
    assert!(after.iter().any(|s| s.voltages.motor_v < 0.0));
}

#[test]
fn a_sensor_that_has_proved_itself_need_not_do_so_again_unless_it_was_lost() {
    let mut bench = bench(Mock::default());
    let asked = Voltages { motor_v: -1.0, brake_v: 0.0 };
    let mut runs_after = |after: &dyn Fn(&mut Guard)| {
        after(&mut bench.guard);
        bench.guard.home(&mut bench.device, 1.0).unwrap();
        bench.guard.arm(&mode(), &Calibration::thesis()).unwrap();
        bench.guard.permit(asked).unwrap().0 == asked
    };
    let moved = mock::reading(Angle::Counts(100));
    assert!(!runs_after(&|_| {}));
    assert!(runs_after(&|guard| drop(guard.see(1.1, 0.1, 0.0, &moved))));
    assert!(!runs_after(&Guard::lose));
}

#[test]
fn voltages_are_clamped_to_the_armed_mode_whoever_asks() {
    let mut bench = bench(Mock::default());
    let wild = |motor_v, brake_v| Voltages { motor_v, brake_v };
    let permit = |guard: &Guard, asked| guard.permit(asked).unwrap();
    assert_eq!(permit(&bench.guard, wild(-8.0, 9.0)), (wild(0.0, 8.0), true)); // the motor has to wait for its proof
    let moved = mock::reading(Angle::Counts(100));
    bench.guard.see(0.1, 0.1, 0.0, &moved).unwrap();
    assert_eq!(permit(&bench.guard, wild(-99.0, -1.0)), (wild(-8.0, 0.0), true));
    assert_eq!(permit(&bench.guard, wild(5.0, 3.0)), (wild(5.0, 3.0), false));
    assert!(matches!(bench.guard.permit(wild(f64::NAN, 0.0)), Err(Trip::NotFinite { .. })));
    assert!(matches!(bench.guard.permit(wild(0.0, f64::INFINITY)), Err(Trip::NotFinite { .. })));
}

#[test]
fn a_trial_whose_motor_no_watchdog_watches_is_marked() {
    let mut device = Mock::default();
    device.capabilities.watchdog_s = None;
    let mut guard = Guard::new(&device.capabilities, LIMITS, true);
    guard.arm(&mode(), &Calibration::thesis()).unwrap();
    assert!(guard.unwatched());
    guard.arm(&Mode { motor_max_v: None, ..mode() }, &Calibration::thesis()).unwrap();
    assert!(!guard.unwatched());
    assert!(!bench(Mock::default()).run().0.unwatched);
    let mut watched = Guard::new(&mock::capabilities(), LIMITS, true);
    watched.arm(&mode(), &Calibration::thesis()).unwrap();
    assert!(!watched.unwatched());
}

#[test]
fn a_reading_is_flagged_where_a_value_is_old_or_the_lever_outside() {
    let mut guard = bench(Mock::default()).guard;
    let mut flags = |t_s: f64, reading| guard.see(t_s, TICK_S, 0.0, &reading).unwrap().flags;
    let at_stop = mock::reading(Angle::Counts(0));
    assert_eq!(flags(0.1, at_stop), Flags::default());
    assert_eq!(flags(0.101, Reading { angle_age_s: 0.001, ..at_stop }), Flags::STALE_ANGLE);
    assert_eq!(flags(0.102, Reading { force_age_s: Some(0.0251), ..at_stop }), Flags::STALE_FORCE); // 2 of 12.5 ms
    assert_eq!(flags(0.103, Reading { force_age_s: Some(0.0249), ..at_stop }), Flags::default());
    assert_eq!(flags(0.104, mock::reading(Angle::Counts(4095))), Flags::default());
    assert_eq!(flags(0.105, mock::reading(Angle::Counts(4090))), Flags::OUTSIDE);
}

#[test]
fn homing_turns_both_actuators_off_first() {
    let mut bench = bench(Mock::default());
    bench.device.write(1.0, Voltages { motor_v: -8.0, brake_v: 8.0 }).unwrap();
    bench.guard.home(&mut bench.device, 1.01).unwrap();
    assert_eq!(bench.device.output(1.01), Voltages::OFF);
    assert!(!bench.guard.is_armed());
}

#[test]
fn the_turn_stays_known_while_a_pause_is_watched() {
    let mut bench = bench(Mock::default()); // the lever goes over a whole turn of the shaft and back
    let mut clock = SimulatedClock::new(1);
    let (mut furthest_rad, stop) = (f64::MIN, AtomicBool::new(false));
    let mut seen =
        |_: f64, _: &Reading, seen: &Seen| furthest_rad = furthest_rad.max(seen.theta_rad);
    watch(&mut bench.device, &mut clock, &mut bench.guard, 1000.0, 1.5, &stop, &mut seen).unwrap();
    assert!((furthest_rad - (PI / 3.0 - FRAC_PI_4)).abs() < 1e-3);
    assert!(bench.device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
    assert!(bench.guard.is_homed() && !bench.guard.is_armed());
}

#[test]
fn a_machine_that_stalls_in_a_pause_does_no_harm() {
    let mut bench = bench(Mock::default());
    let mut clock = stalling(FAULT_S, 0.06, None);
    let (mut last_rad, stop) = (f64::NAN, AtomicBool::new(false));
    let mut seen = |_: f64, _: &Reading, seen: &Seen| last_rad = seen.theta_rad;
    watch(&mut bench.device, &mut clock, &mut bench.guard, 1000.0, 3.0, &stop, &mut seen).unwrap();
    assert!((last_rad + FRAC_PI_4).abs() < 1e-3, "it is back at its start: {last_rad}");
    assert!(bench.guard.is_homed());
}

#[test]
fn a_fault_in_a_pause_is_told() {
    let mut bench = bench(Mock::default().failing(FAULT_S, Fault::Unplugged));
    let (mut clock, stop) = (SimulatedClock::new(1), AtomicBool::new(false));
    let Bench { device, guard, .. } = &mut bench;
    let trip = watch(device, &mut clock, guard, 1000.0, 1.5, &stop, &mut |_, _, _| {});
    assert!(matches!(trip, Err(Trip::Device(DeviceError::Lost { .. }))) && !bench.guard.is_homed());
}
