//! How well the control loop keeps 1 kHz, beside the loop that people write in Python: `cargo bench
//! -p zwidth-benches --bench timing [-- SECONDS]`. On a quiet machine, and with every core busy.
//! Lateness is the time from the deadline to the waking up; a deadline is missed when the next one
//! has come before its tick.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::print_stdout)] // a bench may panic

use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_device::mock::Mock;
use zwidth_device::{
    Controller, Cue, Guard, Limits, LiveRun, Priority, RealClock, TrialEnd, TrialPlan, Velocity,
    run_live,
};
use zwidth_study::{Calibration, Control, Environment, Levels, Mode, Scene, Spring};

const HALF_STROKE_RAD: f64 = std::f64::consts::FRAC_PI_4;
const SECONDS: f64 = 10.0;

/// To and fro, for as long as it takes.
fn to_and_fro(t_s: f64) -> (f64, f64) {
    (-0.5 * HALF_STROKE_RAD * (1.0 + (2.0 * t_s).cos()), 1.0)
}

/// A hybrid trial in the thesis' walled spring on a mock: all of the loop but a serial port.
fn ours(seconds: f64) -> LiveRun {
    let mut device = Mock::new(to_and_fro);
    let limits =
        Limits { theta_min_rad: -HALF_STROKE_RAD, theta_max_rad: HALF_STROKE_RAD, force_n: 10.0 };
    let spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: -HALF_STROKE_RAD };
    let scene = Scene::SpringWall { spring, wall_rad: -0.1 };
    let environment = Environment {
        id: "e".parse().unwrap(),
        label: String::new(),
        scene,
        delay_s: 0.0,
        question: None,
        further: Vec::new(),
        factors: Levels::new(),
    };
    let (motor_max_v, brake_max_v) = (Some(8.0), Some(8.0));
    let mode = Mode {
        id: "m".parse().unwrap(),
        label: String::new(),
        motor_max_v,
        brake_max_v,
        law: None,
        factors: Levels::new(),
    };
    let (control, calibration) = (Control::default(), Calibration::thesis());
    let mut controller = Controller::new(&control, &environment, &mode, &calibration);
    let mut guard = Guard::new(&device.capabilities, limits, false);
    guard.home(&mut device, 0.0).unwrap();
    guard.arm(&mode, &calibration).unwrap();
    let cue = Cue { trial: 1, environment: &environment, limit_s: seconds };
    let plan = TrialPlan {
        cue,
        varied: None,
        rate_hz: control.rate_hz,
        velocity: Velocity::new(control.velocity).unwrap(),
        shows_moments: false,
    };
    let mut kept = Vec::new();
    let mut keep = |batch: &[_]| {
        kept.extend_from_slice(batch);
        ControlFlow::Continue(())
    };
    let stop = AtomicBool::new(false);
    let mut clock = RealClock::new();
    run_live(&mut device, &mut clock, &mut controller, &mut guard, &plan, &stop, &mut keep)
}

fn row(name: &str, numbers: [f64; 5], counts: [u64; 3]) {
    let us = numbers.map(|s| format!("{:9.1}", s * 1e6)).join("");
    let [ticks, missed, lost] = counts;
    println!("{name:<34}{us}{ticks:9}{missed:8}{lost:6}");
}

fn print_ours(load: &str, live: &LiveRun) {
    let timing = &live.run.timing;
    let late = |percent| timing.lateness.percentile_s(percent);
    let priority = match live.priority {
        Priority::RealTime => "real-time",
        Priority::Ordinary => "ordinary",
    };
    let numbers = [
        late(50.0),
        late(99.0),
        late(99.9),
        timing.lateness.max_s(),
        timing.work.percentile_s(99.0),
    ];
    row(
        &format!("zwidth, {priority} thread, {load}"),
        numbers,
        [timing.ticks, timing.missed, live.lost],
    );
    if let TrialEnd::Tripped(trip) = &live.run.end {
        println!("  ended early: {trip}");
    }
}

/// The Python loop prints the same numbers, tab-separated.
fn print_python(load: &str, seconds: f64) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/timing.py");
    let Ok(output) = Command::new("python3").arg(script).arg(seconds.to_string()).output() else {
        println!("no python3: its row is left out");
        return;
    };
    let text = String::from_utf8(output.stdout).unwrap();
    let values: Vec<f64> = text.split_whitespace().map(|word| word.parse().unwrap()).collect();
    let [p50, p99, p999, max, work, ticks, missed] = values[..] else {
        panic!("python3 failed: {text}")
    };
    row(
        &format!("Python, time.sleep, {load}"),
        [p50, p99, p999, max, work],
        [ticks as u64, missed as u64, 0],
    );
}

/// Runs with every core busy.
fn busy<T>(run: impl FnOnce() -> T) -> T {
    let done = AtomicBool::new(false);
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let result = run();
        done.store(true, Ordering::Relaxed);
        result
    })
}

fn main() {
    let seconds = std::env::args().find_map(|word| word.parse().ok()).unwrap_or(SECONDS);
    println!("1 kHz for {seconds} s, us");
    println!(
        "{:<34}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>8}{:>6}",
        "", "late p50", "p99", "p99.9", "max", "work p99", "ticks", "missed", "lost"
    );
    print_ours("quiet", &ours(seconds));
    print_python("quiet", seconds);
    print_ours("busy", &busy(|| ours(seconds)));
    busy(|| print_python("busy", seconds));
}
