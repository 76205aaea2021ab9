//! The method's own facts: stability regions, and the cases that were once judged wrongly.

use super::stability::Growth;
use super::*;
use crate::scene::ModelScene;
use crate::scene::actuators::DriveMode;
use crate::scene::environment::Environment;
use crate::scene::finger::FingerLaw;
use crate::scene::friction::Friction;
use crate::scene::input::Input;
use crate::scene::plant::Start;
use crate::scene::table3;
use crate::scene::terms::gravity::Gravity;
use crate::scene::terms::pull::Pull;
use crate::solve::Grid;
use crate::solve::Switching;
use crate::solve::exact::Exact;
use crate::solve::moreau_jean::MoreauJean;
use crate::solve::named::NAMED_SOLVERS;
use crate::solve::rk4::Rk4;
use crate::solve::symplectic_euler::SymplecticEuler;
use crate::system::linear::LinearPart;
use crate::system::region::{Contact, Side};
use crate::system::{OMEGA, System, THETA};

fn stage() -> Rk4 {
    Rk4 { switching: Switching::PerStage }
}

fn check(solver: &dyn Solver, scene: ModelScene, h: f64, expect: RunVerdict) {
    let judgement = judge(solver, &System::new(scene).unwrap(), h);
    assert_eq!(judgement.verdict, expect, "{} at {h}: {judgement:?}", solver.name());
}

fn solvers() -> Vec<Box<dyn Solver>> {
    NAMED_SOLVERS.iter().map(|named| (named.make)(1e-9)).collect()
}

fn sticking() -> ModelScene {
    table3::scene(DriveMode::Hybrid, Input::sine(2.15))
}

#[test]
fn methods_that_switch_on_the_sign_chatter_where_the_lever_sticks_and_the_others_do_not() {
    for h in [8.3e-3, 0.83e-3, 0.2e-3] {
        check(&stage(), sticking(), h, RunVerdict::NumericalChattering);
        check(
            &Rk4 { switching: Switching::PerStep },
            sticking(),
            h,
            RunVerdict::NumericalChattering,
        );
        check(&SymplecticEuler, sticking(), h, RunVerdict::NumericalChattering);
        check(&MoreauJean::default(), sticking(), h, RunVerdict::Smooth);
        check(&Exact::default(), sticking(), h, RunVerdict::Smooth);
    }
}

/// Between the brake's engaging and its letting go the model says nothing of a lever at rest: with
/// one rule the brake lets go and the lever creeps on in jerks, with the other it holds.
#[test]
fn a_brake_that_engages_late_moves_the_lever_as_the_rule_at_rest_has_it() {
    let mut scene = sticking();
    scene.brake.lag_on_off_s = Some([0.015, 0.010]);
    let system = System::new(scene).unwrap();
    let reference = Reference::of(&system);
    for h in [2e-3, 0.2e-3] {
        for solver in solvers() {
            let judgement = reference.judge(solver.as_ref(), h);
            let name = solver.name();
            assert_eq!(judgement.verdict, RunVerdict::DependsOnRestRule, "{name}: {judgement:?}");
            let (release, compress) =
                (judgement.reference.unwrap(), judgement.other_rest_rule.unwrap());
            let apart = release.theta_max_rad - compress.theta_max_rad;
            assert!(apart.to_degrees() > 20.0, "{release:?} {compress:?}");
        }
    }
}

#[test]
fn a_short_lever_makes_the_thesis_step_unstable_though_saturation_and_stops_bound_the_run() {
    for (lever_m, expect) in [(0.045, RunVerdict::UnstableStep), (0.58, RunVerdict::UnstableStep)] {
        let mut scene = sticking();
        scene.plant.lever_m = lever_m;
        check(&stage(), scene, 8.3e-3, expect);
    }
}

#[test]
fn an_extreme_scene_that_ends_in_an_error_has_failed() {
    let mut scene = sticking();
    scene.environment = crate::scene::environment::Environment::spring(1e9, 0.0, 0.0);
    let few = Exact { most_events: 10, ..Exact::default() };
    check(&few, scene, 8.3e-3, RunVerdict::Failed);
}

/// Bisects for the value at which `stable` turns from false to true between two values.
fn limit(mut unstable: f64, mut stable: f64, is_stable: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..40 {
        let middle = 0.5 * (unstable + stable);
        if is_stable(middle) { stable = middle } else { unstable = middle }
    }
    0.5 * (unstable + stable)
}

/// The unsaturated system of a scene.
fn unsaturated(mut scene: ModelScene) -> System {
    scene.mode = DriveMode::Active;
    scene.motor.max_n = 1e30;
    scene.plant.stops_rad = None;
    scene.input = Input::constant(1.0);
    System::new(scene).unwrap()
}

fn forward(system: &System) -> LinearPart {
    let (z, _) = system.start();
    system.linear_part(&system.moving_region(Side::Up, Contact::Free, &z))
}

fn analytic_stable(system: &System, h: f64) -> bool {
    let part = forward(system);
    Growth::of(&stage(), &part, h).unwrap().excess() <= 1.0 + 1e-12
}

/// Whether a run of 4,000 steps dies out or blows up.
fn measured_stable(system: &System, h: f64) -> bool {
    let run = stage().run(system, &Grid::Even { step_s: h, steps: 4_000 });
    run.is_ok_and(|run| run.theta_dot_rad_s().last().unwrap().abs() < 1.0)
}

#[test]
fn rk4_at_8_3_ms_is_stable_from_a_lever_of_0_5889_m_on() {
    let lever = |lever_m: f64| {
        let mut scene = sticking();
        scene.plant.lever_m = lever_m;
        unsaturated(scene)
    };
    let analytic = limit(0.3, 1.0, |l| analytic_stable(&lever(l), 8.3e-3));
    let measured = limit(0.3, 1.0, |l| measured_stable(&lever(l), 8.3e-3));
    assert!((analytic - 0.5889).abs() < 5e-5, "{analytic}");
    assert!((measured / analytic - 1.0).abs() < 5e-3, "{measured} instead of {analytic}");
}

#[test]
fn rk4_runs_the_linear_two_mass_model_up_to_7_312_ms() {
    let system = unsaturated(table3::linear(DriveMode::Active, Input::constant(1.0), 13.0));
    let analytic = limit(9e-3, 5e-3, |h| analytic_stable(&system, h));
    let measured = limit(9e-3, 5e-3, |h| measured_stable(&system, h));
    assert!((analytic - 7.312e-3).abs() < 5e-7, "{analytic}");
    assert!((measured / analytic - 1.0).abs() < 5e-3, "{measured} instead of {analytic}");
    let part = forward(&system);
    assert!((Growth::of(&stage(), &part, 8.3e-3).unwrap().excess() - 1.721).abs() < 5e-4);
}

/// A lever on a spring (K, B about θ = 0) that nobody pushes, from 0.1 rad on.
fn spring(stiffness: f64, damping: f64) -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
    scene.environment = Environment::spring(stiffness, damping, 0.0);
    scene.motor.max_n = 1e6;
    scene.plant.stops_rad = None;
    scene.start = Start { theta_rad: 0.1, theta_dot_rad_s: 0.0 };
    scene
}

fn check_all(scene: &ModelScene, steps_s: &[f64], expect: RunVerdict) {
    let system = System::new(scene.clone()).unwrap();
    let reference = Reference::of(&system);
    for &h in steps_s {
        for solver in solvers() {
            let judgement = reference.judge(solver.as_ref(), h);
            assert_eq!(judgement.verdict, expect, "{} at {h}: {judgement:?}", solver.name());
        }
    }
}

#[test]
fn reversals_within_a_tenth_of_a_picosecond_are_no_limit_cycle() {
    // scenes/ramp_finger.toml with its spring at rest upright: 1,983 reversals within 2e-13 s.
    let mut scene = table3::scene(DriveMode::Hybrid, Input::ramp(2.15));
    scene.environment = Environment::spring(4.0, 1.0, 0.0);
    scene.finger = Some(table3::finger(FingerLaw::Thesis));
    let system = System::new(scene).unwrap();
    let judgement = judge(&Exact::default(), &system, 8.3e-3);
    assert_eq!(judgement.verdict, RunVerdict::Smooth);
}

#[test]
fn a_damped_spring_that_nobody_pushes_is_a_transient() {
    // K 400 N/rad, M L 0.005 kg m, B 0.0566 N s/rad: ζ = 0.02, so that it loses 12 % a cycle.
    check_all(&spring(400.0, 0.0566), &[1e-4, 5e-4, 2e-3], RunVerdict::Transient);
}

#[test]
fn a_linear_system_that_is_shaken_at_40_hz_is_forced() {
    // ζ = 0.1 at 45 Hz: what it started with is down to e^-112 after 4 s, and what is left has the
    // input's period.
    let mut scene = spring(400.0, 0.283);
    scene.input = Input::Sine { magnitude: 1.0, omega_rad_s: 80.0 * std::f64::consts::PI };
    check_all(&scene, &[1e-4, 5e-4, 2e-3], RunVerdict::Forced);
}

#[test]
fn bounces_of_1_5e_9_rad_do_not_exist() {
    // A push of 1 N against a wall of 3.25 N from 1e-9 rad away, which gives way by 1 N/2.25 N of
    // that: half of the way is 0.7e-9 rad.
    let mut scene = table3::scene(DriveMode::Active, Input::constant(1.0));
    scene.environment = Environment::spring(0.0, 0.001, 0.0).with_wall(0.0);
    scene.plant.stops_rad = None;
    scene.start = Start { theta_rad: -1e-9, theta_dot_rad_s: 0.0 };
    scene.duration_s = 0.1;
    let system = System::new(scene).unwrap();
    assert_eq!(judge(&Exact::default(), &system, 1e-3).verdict, RunVerdict::Smooth);
}

#[test]
fn an_oscillation_of_1e_69_rad_does_not_exist() {
    let mut scene = spring(400.0, 0.0);
    scene.start.theta_rad = 1e-69;
    check_all(&scene, &[1e-4, 5e-4, 2e-3], RunVerdict::Smooth);
}

/// Rabinowicz' stick–slip: F_s 0.5, F_k 0.2, pulled over 4000 N/rad at 0.02 rad/s.
fn stick_slip() -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
    scene.environment = Environment::free();
    scene.plant.stops_rad = None;
    scene.friction = Some(Friction { static_n: 0.5, kinetic_n: 0.2, viscous_ns_per_rad: 0.0 });
    let displacement = Input::Line { value: 0.0, rate: 0.02 };
    scene.terms.set(Pull { stiffness_n_per_rad: 4000.0, displacement });
    scene.start = Start::default();
    scene.duration_s = 1.0;
    scene
}

#[test]
fn slow_stick_slip_is_a_limit_cycle_for_rk4_too() {
    check_all(&stick_slip(), &[5e-4], RunVerdict::LimitCycle);
}

#[test]
fn a_hanging_pendulum_with_a_step_beyond_the_limit_is_an_unstable_step() {
    // ω h = 3.2 > 2.83 with ω² = m g r / (M_O L²), the linearised weight; a hundredth of a radian.
    let mut scene = table3::scene(DriveMode::Passive, Input::constant(0.0));
    scene.brake.max_n = 0.0;
    scene.plant.stops_rad = None;
    scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.05 });
    scene.start.theta_rad = std::f64::consts::PI + 0.01;
    scene.duration_s = 60.0;
    let omega = (0.02 * 9.80665 * 0.05 / 0.005_f64).sqrt();
    let system = System::new(scene).unwrap();
    let reference = Reference::of(&system);
    for solver in [&stage() as &dyn Solver, &SymplecticEuler] {
        let unstable = reference.judge(solver, 3.2 / omega);
        assert_eq!(unstable.verdict, RunVerdict::UnstableStep, "{unstable:?}");
        let stable = reference.judge(solver, 0.1 / omega);
        assert_eq!(stable.verdict, RunVerdict::FreeUndamped, "{stable:?}");
    }
}

/// 5 kN/rad at 8.3 ms.
const CONTROLLER: Controller = Controller {
    period_s: 8.3e-3,
    stiffness_n_per_rad: 5000.0,
    damping_ns_per_rad: 0.0,
    rest_rad: 0.0,
    one_sided: false,
    delay_ticks: 0,
    max_n: 1e9,
};

/// A wall of 5 kN/rad on a free mass, sampled at 8.3 ms.
fn wall() -> SampledLoop {
    let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
    scene.environment = Environment::free();
    scene.plant.stops_rad = None;
    scene.plant.mass_kg = 1.0;
    scene.start = Start { theta_rad: 0.1, theta_dot_rad_s: 0.0 };
    scene.duration_s = 0.083;
    SampledLoop::new(scene, CONTROLLER).unwrap()
}

#[test]
fn the_controllers_period_stays_what_it_is_whatever_the_step() {
    // Over a tick θ' = θ + T θ̇ − (K/M) T²/2 θ and θ̇' = θ̇ − (K/M) T θ.
    let (t, square) = (8.3e-3, 5000.0);
    let (mut theta, mut omega) = (0.1, 0.0);
    for _ in 0..10 {
        (theta, omega) =
            (theta + t * omega - square * t * t / 2.0 * theta, omega - square * t * theta);
    }
    for step_s in [8.3e-3, 4.15e-3, 3e-3, 1e-4, 1.0] {
        let run = wall().run(&Exact::default(), step_s).unwrap();
        let last = run.state(run.len() - 1);
        assert!((last[THETA] / theta - 1.0).abs() < 1e-10, "{step_s}: {} {theta}", last[THETA]);
        assert!((last[OMEGA] / omega - 1.0).abs() < 1e-10, "{step_s}: {} {omega}", last[OMEGA]);
        assert!((run.t_s[run.len() - 1] - 0.083).abs() < 1e-15);
    }
}

#[test]
fn a_sampled_loop_refuses_what_a_tick_would_lose() {
    let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
    scene.motor.lag_s = Some(0.001);
    let refused = SampledLoop::new(scene.clone(), CONTROLLER);
    assert!(matches!(refused, Err(DynamicsError::Combination { .. })), "{refused:?}");
    scene.motor.lag_s = None;
    let error = SampledLoop::new(scene, Controller { period_s: 0.0, ..CONTROLLER }).unwrap_err();
    assert!(error.to_string().starts_with("controller.period_s is 0"), "{error}");
}

#[test]
fn a_step_too_long_to_show_the_models_swings_is_told_beside_the_verdict() {
    // 40 Hz seen every 25 ms: always the same angle.
    let mut scene = spring(400.0, 0.283);
    scene.input = Input::Sine { magnitude: 1.0, omega_rad_s: 80.0 * std::f64::consts::PI };
    let system = System::new(scene).unwrap();
    let judgement = judge(&MoreauJean { theta: 1.0 }, &system, 0.1);
    assert_eq!(judgement.verdict, RunVerdict::Forced);
    assert!(!judgement.shows_the_reference, "{judgement:?}");
}

#[test]
fn the_swings_of_chattering_shrink_and_multiply_as_the_step_is_halved() {
    let system = System::new(sticking()).unwrap();
    let judgement = judge(&Rk4 { switching: Switching::PerStep }, &system, 8.3e-3);
    let [coarse, _, fine] = judgement.swings;
    assert!(coarse.count >= 6 && fine.count > coarse.count, "{judgement:?}");
    assert!(fine.amplitude_rad < 0.5 * coarse.amplitude_rad, "{judgement:?}");
}

#[test]
fn a_sudden_drop_of_the_force_leaves_no_oscillation() {
    for mode in DriveMode::ALL {
        let system = System::new(table3::scene(mode, Input::step(2.15))).unwrap();
        let judgement = judge(&Exact::default(), &system, 8.3e-3);
        assert_eq!(judgement.verdict, RunVerdict::Smooth, "{mode:?}: {judgement:?}");
        assert_eq!(judgement.swings.map(|swings| swings.count), [0; 3]);
    }
}

/// A lever under half of its dry friction.
fn half_the_friction() -> ModelScene {
    let mut scene = table3::scene(DriveMode::Hybrid, Input::constant(0.05));
    scene.environment = Environment::free();
    (scene.plant.mass_kg, scene.plant.lever_m) = (0.1, 0.045);
    scene.friction = Some(Friction { static_n: 0.1, kinetic_n: 0.1, viscous_ns_per_rad: 0.0 });
    scene.start = Start::default();
    scene.duration_s = 2.0;
    scene
}

/// The stages' slopes in units of F/m, from v = 0 under F/2: 1/2 (sgn 0 = 0), then −1/2, then 1/2 or
/// more again while v is below 0.
#[test]
fn a_lever_that_stands_under_half_its_friction_creeps_by_stages_and_by_no_other_method() {
    let system = System::new(half_the_friction()).unwrap();
    let reference = Reference::of(&system);
    let mut ways = Vec::new();
    for h in [1e-3, 0.5e-3, 0.25e-3] {
        let creeps = reference.judge(&stage(), h);
        assert_eq!(creeps.verdict, RunVerdict::NumericalCreep, "{creeps:?}");
        ways.push(creeps.creep_rad);
        for solver in [&Exact::default() as &dyn Solver, &MoreauJean::default()] {
            let stands = reference.judge(solver, h);
            assert_eq!(stands.verdict, RunVerdict::Smooth, "{}: {stands:?}", solver.name());
            assert!(stands.creep_rad.abs() < 1e-300);
        }
    }
    // A push of h F/m per step, which each step loses again: the way falls with the step.
    assert!(ways[0] > 1e-3, "{ways:?}");
    assert!((ways[0] / ways[1] - 2.0).abs() < 0.02 && (ways[1] / ways[2] - 2.0).abs() < 0.02);
}

#[test]
fn a_motion_that_ends_some_steps_late_is_no_creep() {
    let mut scene = half_the_friction();
    scene.input = Input::constant(0.0);
    scene.start = Start { theta_rad: 0.0, theta_dot_rad_s: 0.5 };
    let system = System::new(scene).unwrap();
    let judgement = judge(&MoreauJean { theta: 1.0 }, &system, 8.3e-3);
    assert_eq!(judgement.verdict, RunVerdict::Smooth, "{judgement:?}");
    assert!(judgement.creep_rad.abs() < 1e-300, "{judgement:?}");
}
