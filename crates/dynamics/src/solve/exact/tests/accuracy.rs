//! The error against closed forms, as the condition number of a step's exponential runs from 1 to
//! 1e9 and beyond.
//!
//! Parameters are dyadic, so that the arguments of the closed forms are exact: at a condition
//! number of 1e6 the rounding of an argument alone adds 1e-10. All other parameters have a
//! reference in `reference.rs`.

use super::super::*;
use super::oscillator;
use crate::scene::ModelScene;
use crate::scene::actuators::DriveMode;
use crate::scene::environment::Environment;
use crate::scene::finger::{Finger, FingerLaw};
use crate::scene::input::Input;
use crate::scene::table3;
use crate::system::{OMEGA, THETA};

/// On a lever of 1 m, kg.
const MASS: f64 = 1.0;

/// A run of so many steps against a closed form of one entry of its state.
struct Case {
    scene: ModelScene,
    steps: f64,
    entry: usize,
    closed: Box<dyn Fn(f64) -> f64>,
}

/// Condition number, and largest error over largest signal; no error where the run ended in the
/// typed error of a motion with more swings in a step than the work limits allow.
fn measure(case: &Case) -> (f64, Option<f64>) {
    let scene = ModelScene { duration_s: case.steps * case.scene.step_s, ..case.scene.clone() };
    let system = System::new(scene).unwrap();
    let run = match Exact::default().run(&system, &Grid::of(&system)) {
        Ok(run) => run,
        Err(DynamicsError::TooMuchWork { .. }) => {
            let region = system.first_region(&system.start().0);
            return (system.condition(&region, case.scene.step_s), None);
        }
        Err(error) => panic!("{error}"),
    };
    let closed: Vec<f64> = run.t_s.iter().map(|&t| (case.closed)(t)).collect();
    let errors = closed.iter().enumerate().map(|(i, x)| (run.state(i)[case.entry] - x).abs());
    let signal = closed.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let condition = system.largest_condition(&run, case.scene.step_s);
    (condition, Some(errors.fold(0.0, f64::max) / signal))
}

/// The promise of [`Exact`]: a number below 1e6, a number or the typed error above.
fn keep_promise(name: &str, case: &Case) -> f64 {
    let (condition, error) = measure(case);
    let bound = if condition < 1e6 { 1e-12 } else { 1e-12 + 2.0 * f64::EPSILON * condition };
    match error {
        Some(error) => {
            assert!(error <= bound, "{name}: {error} at a condition number of {condition}")
        }
        None => assert!(condition >= 1e6, "{name}: gave up at a condition number of {condition}"),
    }
    condition
}

/// Every case of a family, one a power of two, keeps the promise; the condition numbers cover 1 to
/// 1e9.
fn check(name: &str, powers: std::ops::RangeInclusive<i32>, family: impl Fn(f64) -> Case) {
    let conditions = powers
        .map(|power| keep_promise(&format!("{name}, 2^{power}"), &family(libm::ldexp(1.0, power))));
    let (least, most) = conditions
        .fold((f64::INFINITY, 0.0), |(least, most), x| (f64::min(least, x), f64::max(most, x)));
    assert!(least < 20.0 && most > 1e9, "{name}: {least} to {most}");
}

/// m x¨ + b x˙ + k x = F, of which k/m and b/m are given.
fn spring(stiffness: f64, damping: f64, input: Input, theta_rad: f64, step_s: f64) -> ModelScene {
    let mut scene = oscillator(0.0, input, theta_rad);
    scene.plant.mass_kg = MASS;
    scene.environment = Environment::spring(stiffness * MASS, damping * MASS, 0.0);
    scene.motor.max_n = 1e30;
    ModelScene { step_s, ..scene }
}

fn at_rest() -> Input {
    Input::constant(0.0)
}

#[test]
fn a_free_oscillation_keeps_its_phase_however_long_the_step_is() {
    check("angle", -2..=16, |h| {
        let scene = spring(1.0, 0.0, at_rest(), 1.0, h);
        Case { scene, steps: 1.0, entry: THETA, closed: Box::new(libm::cos) }
    });
    check("velocity", -2..=16, |h| {
        let scene = spring(1.0, 0.0, at_rest(), 1.0, h);
        Case { scene, steps: 1.0, entry: OMEGA, closed: Box::new(|t| -libm::sin(t)) }
    });
}

#[test]
fn a_free_oscillation_keeps_its_phase_however_stiff_the_spring_is() {
    check("stiffness", 0..=13, |natural| {
        let scene = spring(natural * natural, 0.0, at_rest(), 1.0, 0.125);
        Case { scene, steps: 64.0, entry: THETA, closed: Box::new(move |t| libm::cos(natural * t)) }
    });
}

#[test]
fn a_critically_damped_motion_is_the_closed_form_at_any_stiffness() {
    check("critical", 0..=20, |natural| {
        let scene = spring(natural * natural, 2.0 * natural, at_rest(), 1.0, 0.125);
        let closed = move |t: f64| libm::exp(-natural * t) * (1.0 + natural * t);
        Case { scene, steps: 64.0, entry: THETA, closed: Box::new(closed) }
    });
}

#[test]
fn a_stiff_overdamped_motion_keeps_its_slow_part() {
    check("stiff", 1..=36, |fast| {
        let scene = spring(fast, 1.0 + fast, at_rest(), 1.0, 0.125);
        let closed = move |t: f64| (fast * libm::exp(-t) - libm::exp(-fast * t)) / (fast - 1.0);
        Case { scene, steps: 64.0, entry: THETA, closed: Box::new(closed) }
    });
}

#[test]
fn a_motion_forced_by_a_sine_is_the_closed_form_however_fast_it_could_swing() {
    // x¨ + n² x = (a + a sin w t)/m from rest.
    check("forced", 1..=13, |natural| {
        let (a, w) = (2.0, 1.5);
        let (square, per_mass) = (natural * natural, a / MASS);
        let closed = move |t: f64| {
            let swing = libm::sin(w * t) - w / natural * libm::sin(natural * t);
            per_mass * ((1.0 - libm::cos(natural * t)) / square + swing / (square - w * w))
        };
        let scene = spring(square, 0.0, Input::Sine { magnitude: a, omega_rad_s: w }, 0.0, 0.125);
        Case { scene, steps: 64.0, entry: THETA, closed: Box::new(closed) }
    });
}

/// A finger on a lever that the brake holds, pulled by 1 N from rest.
fn held_finger(mass_kg: f64, stiffness_n_per_m: f64, damping_ns_per_m: f64, step_s: f64) -> Case {
    let mut scene = table3::scene(DriveMode::Passive, Input::constant(-1.0));
    let law = FingerLaw::Consistent;
    scene.finger =
        Some(Finger { law, mass_kg, stiffness_n_per_m, damping_ns_per_m, length_m: None });
    let natural = (stiffness_n_per_m / mass_kg).sqrt();
    let ratio = damping_ns_per_m / (2.0 * (stiffness_n_per_m * mass_kg).sqrt());
    let (sigma, omega) = (ratio * natural, natural * (1.0 - ratio * ratio).sqrt());
    let closed = move |t: f64| {
        let swing = libm::cos(omega * t) + sigma / omega * libm::sin(omega * t);
        -1.0 / stiffness_n_per_m * (1.0 - libm::exp(-sigma * t) * swing)
    };
    Case { scene: ModelScene { step_s, ..scene }, steps: 64.0, entry: 2, closed: Box::new(closed) }
}

#[test]
fn a_finger_on_a_held_lever_is_the_closed_form_at_any_stiffness() {
    check("finger", 0..=13, |natural| {
        held_finger(0.015_625, natural * natural * 0.015_625, 0.0, 0.125)
    });
}

#[test]
fn table_3s_finger_of_26_55_hz_is_the_closed_form_at_any_step() {
    for power in -9..=4 {
        let finger = table3::finger(FingerLaw::Consistent);
        let step_s = libm::ldexp(1.0, power);
        let case =
            held_finger(finger.mass_kg, finger.stiffness_n_per_m, finger.damping_ns_per_m, step_s);
        keep_promise(&format!("{step_s} s"), &case);
    }
}

#[test]
fn coefficients_that_had_to_be_rounded_cost_no_more_than_the_promise_allows() {
    for exponent in 0..6 {
        let natural = libm::pow(10.0, f64::from(exponent));
        let mut scene = oscillator(0.0, at_rest(), 1.0);
        scene.environment = Environment::spring(natural * natural * 0.005, 0.0, 0.0);
        scene.motor.max_n = 1e30;
        scene.step_s = 1.0;
        let closed = Box::new(move |t| libm::cos(natural * t));
        keep_promise(
            &format!("{natural} rad/s"),
            &Case { scene, steps: 1.0, entry: THETA, closed },
        );
    }
}

#[test]
fn a_million_samples_cost_no_more_than_an_epsilon_each() {
    let case = held_finger(0.015_625, 4.0, 0.0, 0.0);
    let system = System::new(ModelScene { step_s: 1.0, ..case.scene }).unwrap();
    let (step_s, steps) = (libm::ldexp(1.0, -10), 1_000_000);
    let (mut error, mut signal): (f64, f64) = (0.0, 0.0);
    let mut visit = |t: f64, z: &[f64]| {
        let expect = (case.closed)(t);
        (error, signal) = (error.max((z[case.entry] - expect).abs()), signal.max(expect.abs()));
    };
    let grid = Grid::Even { step_s, steps };
    Exact::default().prepare(&system, &grid).unwrap().visit(&grid, &mut visit).unwrap();
    assert!(error <= (1e-12 + f64::EPSILON * steps as f64) * signal, "{error} of {signal}");
}
