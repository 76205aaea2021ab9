//! The control tick allocates nothing: a trial of 2,000 ticks allocates as often as one of 200,
//! once at its start.
#![allow(clippy::unwrap_used)] // a test may panic

use std::ops::ControlFlow;
use std::sync::atomic::AtomicBool;
use zwidth_device::mock::Mock;
use zwidth_device::{
    Controller, Cue, Guard, Limits, SimulatedClock, TrialEnd, TrialPlan, Velocity, run_trial, watch,
};
use zwidth_study::{
    Calibration, Control, Environment, Mode, Sample, Scene, Spring, VelocityFilter,
};

const HALF_STROKE_RAD: f64 = std::f64::consts::FRAC_PI_4;
const LIMITS: Limits =
    Limits { theta_min_rad: -HALF_STROKE_RAD, theta_max_rad: HALF_STROKE_RAD, force_n: 10.0 };

/// Allocations of so much reading between trials, s.
fn allocations_between(for_s: f64) -> u64 {
    let mut device = Mock::default();
    let mut guard = Guard::new(&device.capabilities, LIMITS, false);
    guard.home(&mut device, 0.0).unwrap();
    let (mut clock, stop) = (SimulatedClock::new(1), AtomicBool::new(false));
    let mut reads = 0;
    let counted = allocation_counter::measure(|| {
        watch(&mut device, &mut clock, &mut guard, 1000.0, for_s, &stop, &mut |_, _, _| reads += 1)
            .unwrap();
    });
    assert_eq!(reads, (for_s * 1000.0) as u32);
    counted.count_total
}

#[test]
fn reading_on_between_trials_allocates_nothing() {
    assert_eq!((allocations_between(0.2), allocations_between(20.0)), (0, 0));
}

fn allocations(limit_s: f64, filter: VelocityFilter, delay_s: f64) -> u64 {
    let mut device = Mock::default();
    let spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: -HALF_STROKE_RAD };
    let scene = Scene::SpringWall { spring, wall_rad: 0.1 };
    let label = String::new();
    let id = "e".parse().unwrap();
    let environment = Environment {
        id,
        label,
        scene,
        delay_s,
        question: None,
        further: Vec::new(),
        factors: Default::default(),
    };
    let label = String::new();
    let id = "m".parse().unwrap();
    let mode = Mode {
        id,
        label,
        motor_max_v: Some(8.0),
        brake_max_v: Some(8.0),
        law: None,
        factors: Default::default(),
    };
    let calibration = Calibration::thesis();
    let mut controller = Controller::new(&Control::default(), &environment, &mode, &calibration);
    let mut guard = Guard::new(&device.capabilities, LIMITS, false);
    guard.home(&mut device, 0.0).unwrap();
    guard.arm(&mode, &calibration).unwrap();
    let cue = Cue { trial: 1, environment: &environment, limit_s };
    let velocity = Velocity::new(filter).unwrap();
    let plan = TrialPlan { cue, varied: None, rate_hz: 1000.0, velocity, shows_moments: true };
    let (mut clock, stop) = (SimulatedClock::new(1), AtomicBool::new(false));
    let mut samples = 0;
    let mut sink = |_: &Sample| {
        samples += 1;
        ControlFlow::Continue(())
    };
    let counted = allocation_counter::measure(|| {
        let run = run_trial(
            &mut device,
            &mut clock,
            &mut controller,
            &mut guard,
            &plan,
            &stop,
            &mut sink,
        );
        assert_eq!(run.end, TrialEnd::Limit);
    });
    assert_eq!(samples, (limit_s * 1000.0) as u32);
    counted.count_total
}

#[test]
fn the_tick_allocates_nothing() {
    for filter in [VelocityFilter::Difference, VelocityFilter::SecondOrder { cutoff_hz: 40.0 }] {
        let short = allocations(0.2, filter, 0.0);
        assert_eq!(allocations(2.0, filter, 0.0), short);
        assert!(short <= 2, "{short}: two histograms"); // and the counter counts: nothing else allocates at all
        assert!(short > 0);
        // What is late is kept in one piece more.
        assert_eq!(allocations(2.0, filter, 0.5), short + 1);
    }
}
