mod accuracy;
mod condition;
mod reference;

use super::*;
use crate::scene::actuators::DriveMode;
use crate::scene::environment::Environment;
use crate::scene::finger::FingerLaw;
use crate::scene::friction::Friction;
use crate::scene::input::{Input, Series};
use crate::scene::plant::Start;
use crate::scene::terms::gravity::Gravity;
use crate::scene::terms::pull::Pull;
use crate::scene::{ModelScene, table3};
use crate::system::region::{Contact, Motion};
use crate::system::transition::EventKind;

pub(super) fn run(scene: ModelScene) -> Trajectory {
    let system = System::new(scene).unwrap();
    Exact::default().run(&system, &Grid::of(&system)).unwrap()
}

fn kinds(run: &Trajectory) -> Vec<EventKind> {
    run.events.iter().skip(1).map(|event| event.kind).collect()
}

/// Largest error of θ against a closed form, over the largest signal.
fn check_theta(run: &Trajectory, bound: f64, exact: impl Fn(f64) -> f64) {
    let signal = run.theta_rad().fold(0.0, |m: f64, x| m.max(x.abs()));
    let error =
        run.t_s.iter().zip(run.theta_rad()).map(|(&t, x)| (x - exact(t)).abs()).fold(0.0, f64::max);
    assert!(error <= bound * signal, "{error} of {signal}");
}

/// A lever on an unsaturated spring, no stops, with a given damping; m L = 0.005, K = 4.
pub(super) fn oscillator(damping: f64, input: Input, theta_rad: f64) -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, input);
    scene.environment = Environment::spring(4.0, damping, 0.0);
    scene.motor.max_n = 1e6;
    scene.plant.stops_rad = None;
    scene.start = Start { theta_rad, theta_dot_rad_s: 0.0 };
    scene
}

const INERTIA: f64 = table3::OBJECT_MASS_KG * table3::LEVER_M;

#[test]
fn the_chattering_scene_sticks_once_and_reaches_14_40784_degrees() {
    let run = run(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
    let max = run.theta_rad().fold(f64::MIN, f64::max).to_degrees();
    assert!((max - 14.40784).abs() < 1e-5, "{max}");
    let mut motions: Vec<Motion> = run.events.iter().map(|event| event.region.motion).collect();
    motions.dedup();
    assert_eq!(motions, [Motion::Forward, Motion::Rest, Motion::Backward, Motion::Forward]);
    assert_eq!(run.motion_changes(), 3);
    assert_eq!(run.reversals(), 2);
}

#[test]
fn a_free_oscillation_is_the_closed_form_damped_critical_and_overdamped() {
    let natural = (4.0 / INERTIA).sqrt();
    for ratio in [0.0, 0.01, 0.5] {
        let (sigma, omega) = (ratio * natural, natural * (1.0_f64 - ratio * ratio).sqrt());
        let run = run(oscillator(2.0 * ratio * natural * INERTIA, Input::constant(0.0), 0.3));
        check_theta(&run, 1e-12, |t| {
            0.3 * libm::exp(-sigma * t)
                * (libm::cos(omega * t) + sigma / omega * libm::sin(omega * t))
        });
    }
    let critical = run(oscillator(2.0 * natural * INERTIA, Input::constant(0.0), 0.3));
    check_theta(&critical, 1e-12, |t| 0.3 * libm::exp(-natural * t) * (1.0 + natural * t));
    let (slow, fast) = (2.0, 4.0 / INERTIA / 2.0);
    let run = run(oscillator((slow + fast) * INERTIA, Input::constant(0.0), 0.3));
    check_theta(&run, 1e-12, |t| {
        0.3 * (fast * libm::exp(-slow * t) - slow * libm::exp(-fast * t)) / (fast - slow)
    });
}

#[test]
fn a_mass_under_a_constant_force_goes_half_f_t2_over_m() {
    for (force_n, input_n) in [(-0.5, 0.0), (0.3, 0.3), (0.3, 1.0)] {
        let mut scene = oscillator(0.0, Input::constant(input_n), 0.1);
        scene.environment = Environment::force(force_n);
        let course = |t: f64| 0.1 + 0.5 * (input_n - force_n) / INERTIA * t * t;
        check_theta(&run(scene.clone()), 1e-12, course);
        // The same by steps, which work the command out in another place.
        let system = System::new(scene).unwrap();
        let stepped = crate::Rk4 { switching: crate::Switching::PerStage }
            .run(&system, &Grid::of(&system))
            .unwrap();
        check_theta(&stepped, 1e-9, course);
    }
}

#[test]
fn a_forced_oscillation_by_a_sine_is_the_closed_form() {
    // m L x'' + K x = a + a sin(w t) from rest at 0.
    let (a, w) = (2.0, 1.5);
    let natural = (4.0 / INERTIA).sqrt();
    let run = run(oscillator(0.0, Input::Sine { magnitude: a, omega_rad_s: w }, 0.0));
    let gain = a / INERTIA / (natural * natural - w * w);
    check_theta(&run, 1e-12, |t| {
        a / 4.0 * (1.0 - libm::cos(natural * t))
            + gain * (libm::sin(w * t) - w / natural * libm::sin(natural * t))
    });
}

#[test]
fn a_finger_on_a_held_lever_swings_at_26_55_hz_with_damping_0_218() {
    let mut scene = table3::with_finger(table3::scene(DriveMode::Passive, Input::constant(-1.0)));
    scene.duration_s = 0.5;
    scene.step_s = 1e-3;
    let run = run(scene);
    let natural = (584.6_f64 / 0.021).sqrt();
    let ratio = 1.53 / (2.0 * (584.6_f64 * 0.021).sqrt());
    assert!((natural / std::f64::consts::TAU - 26.55).abs() < 5e-3);
    assert!((ratio - 0.218).abs() < 5e-4);
    let (sigma, omega) = (ratio * natural, natural * (1.0 - ratio * ratio).sqrt());
    for (t, x) in run.t_s.iter().zip(run.finger_m()) {
        let swing = libm::cos(omega * t) + sigma / omega * libm::sin(omega * t);
        let expect = -1.0 / 584.6 * (1.0 - libm::exp(-sigma * t) * swing);
        assert!((x - expect).abs() < 1e-12 * 3e-3, "{t}: {x} instead of {expect}");
    }
}

#[test]
fn a_coulomb_oscillator_loses_4_f_over_k_of_amplitude_a_cycle() {
    let mut scene = oscillator(0.0, Input::constant(0.0), 0.5);
    scene.friction = Some(Friction { static_n: 0.05, kinetic_n: 0.05, viscous_ns_per_rad: 0.0 });
    let run = run(scene);
    let turns: Vec<f64> =
        run.events.iter().filter(|e| e.kind == EventKind::Reversal).map(|e| e.theta_rad).collect();
    assert!(turns.len() > 10);
    let mut amplitude = 0.5;
    for pair in turns.chunks_exact(2) {
        amplitude -= 4.0 * 0.05 / 4.0;
        assert!((pair[0] + amplitude + 2.0 * 0.05 / 4.0).abs() < 1e-13);
        assert!((pair[1] - amplitude).abs() < 1e-13, "{} instead of {amplitude}", pair[1]);
    }
    assert_eq!(run.events.last().unwrap().region.motion, Motion::Rest);
}

#[test]
fn a_spring_pulled_at_constant_speed_sticks_and_slips_as_rabinowicz_found() {
    let (k, speed, fs, fk) = (40.0, 0.1, 0.4, 0.1);
    let mut scene = oscillator(0.0, Input::constant(0.0), 0.0);
    scene.environment = Environment::free();
    scene.friction = Some(Friction { static_n: fs, kinetic_n: fk, viscous_ns_per_rad: 0.0 });
    let displacement = Input::Line { value: 0.0, rate: speed };
    scene.terms.set(Pull { stiffness_n_per_rad: k, displacement });
    let run = run(scene);
    // Slip: half the load drop a = (Fs - Fk)/K to either side of Fk/K; it lasts (pi + 2 phi)... see
    // below.
    let (a, natural) = ((fs - fk) / k, (k / INERTIA).sqrt());
    let phase = libm::atan2(speed / natural, a);
    let slip_s = (std::f64::consts::PI + 2.0 * phase) / natural;
    let stick_s = 2.0 * a / speed;
    let starts: Vec<f64> =
        run.events.iter().filter(|e| e.kind == EventKind::DepartUp).map(|e| e.t_s).collect();
    let ends: Vec<f64> =
        run.events.iter().filter(|e| e.kind == EventKind::Reversal).map(|e| e.t_s).collect();
    assert!(starts.len() > 20);
    assert!((starts[0] - fs / k / speed).abs() < 1e-13);
    for (i, end) in ends.iter().enumerate() {
        assert!(
            (end - starts[i] - slip_s).abs() < 1e-12,
            "{} instead of {slip_s}",
            end - starts[i]
        );
        if let Some(next) = starts.get(i + 1) {
            assert!((next - end - stick_s).abs() < 1e-12, "{} instead of {stick_s}", next - end);
        }
    }
}

#[test]
fn a_held_lever_does_not_drift_over_ten_million_samples() {
    let mut scene = table3::scene(DriveMode::Passive, Input::constant(2.0));
    scene.start.theta_rad = 0.1;
    let system = System::new(scene).unwrap();
    let grid = Grid::Even { step_s: 1e-3, steps: 10_000_000 };
    let mut moved = 0;
    let run = Exact::default().prepare(&system, &grid).unwrap().visit(&grid, &mut |_, z| {
        moved += usize::from(z[0].to_bits() != 0.1_f64.to_bits() || z[1] != 0.0);
    });
    assert_eq!(moved, 0);
    assert_eq!(kinds(&run.unwrap()), []);
}

#[test]
fn events_do_not_depend_on_the_grid_so_that_none_inside_a_sample_is_missed() {
    for finger in [false, true] {
        for mode in [DriveMode::Active, DriveMode::Passive, DriveMode::Hybrid] {
            let mut scene = table3::scene(mode, Input::step(2.5));
            scene.environment = table3::spring_wall();
            scene.environment.zones[1].from_rad = 0.2;
            let scene = if finger { table3::with_finger(scene) } else { scene };
            let fine = run(ModelScene { step_s: 1e-4, ..scene.clone() });
            for step_s in [8.3e-3, 0.137, 1.9] {
                let coarse = run(ModelScene { step_s, ..scene.clone() });
                let until = *coarse.t_s.last().unwrap();
                let expect: Vec<_> =
                    fine.events.iter().filter(|event| event.t_s <= until).collect();
                assert_eq!(coarse.events.len(), expect.len(), "{mode:?} {step_s}");
                for (found, expect) in coarse.events.iter().zip(expect) {
                    assert_eq!(found.kind, expect.kind);
                    assert!(
                        (found.t_s - expect.t_s).abs() < 1e-10,
                        "{mode:?} {step_s}: {found:?} {expect:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn two_crossings_of_a_wall_within_one_sample_are_both_found() {
    // Thrown at the wall at 1 rad/s: it is back across after 2 v m L / F = 2.5 ms, within a sample
    // of 100 ms.
    let mut scene = oscillator(0.0, Input::constant(0.0), -0.01);
    scene.environment = Environment::free().with_wall(0.0);
    scene.motor.max_n = 4.0;
    scene.start.theta_dot_rad_s = 1.0;
    scene.step_s = 0.1;
    scene.duration_s = 0.1;
    let run = run(scene);
    assert_eq!(kinds(&run), [EventKind::Zone, EventKind::Reversal, EventKind::Zone]);
    let times: Vec<f64> = run.events.iter().skip(1).map(|event| event.t_s).collect();
    for (found, expect) in times.iter().zip([0.01, 0.01 + INERTIA / 4.0, 0.01 + INERTIA / 2.0]) {
        assert!((found - expect).abs() < 1e-13, "{times:?}");
    }
}

#[test]
fn an_event_exactly_on_a_sample_happens_once() {
    let mut scene = oscillator(0.0, Input::constant(0.0), 0.0);
    scene.environment = Environment::free().with_wall(0.25);
    scene.motor.max_n = 0.005;
    scene.start.theta_dot_rad_s = 1.0;
    scene.step_s = 0.125;
    scene.duration_s = 1.0;
    let run = run(scene);
    assert_eq!(kinds(&run)[0], EventKind::Zone);
    assert!((run.events[1].t_s - 0.25).abs() < 1e-13);
    let crossings = run.events.iter().filter(|event| event.kind == EventKind::Zone).count();
    assert_eq!(crossings, 1);
}

#[test]
fn grazing_a_wall_is_no_contact_and_a_hair_further_is() {
    // 0.3 rad of swing against a wall at 0.3 rad.
    let graze = |wall: f64| {
        let mut scene = oscillator(0.0, Input::constant(0.0), -0.3);
        scene.environment = scene.environment.with_wall(wall);
        scene.step_s = 0.013;
        run(scene).events.iter().filter(|event| event.kind == EventKind::Zone).count()
    };
    assert_eq!(graze(0.3 + 1e-11), 0);
    assert!(graze(0.3 - 1e-11) > 0);
}

#[test]
fn a_lever_that_starts_on_a_stop_stays_until_it_is_pushed_off() {
    let mut scene = table3::scene(DriveMode::Hybrid, Input::Line { value: -1.0, rate: 1.0 });
    scene.duration_s = 2.0;
    let run = run(scene);
    assert_eq!(kinds(&run)[0], EventKind::DepartUp);
    assert!((run.events[1].t_s - 1.0).abs() < 1e-12);
    let system = System::new(table3::scene(DriveMode::Hybrid, Input::constant(-1.0))).unwrap();
    let held = Exact::default().run(&system, &Grid::of(&system)).unwrap();
    assert!((held.forces(&system, 7).stop_n - 1.0).abs() < 1e-15);
}

#[test]
fn a_lever_that_starts_inside_the_wall_is_pushed_out_by_the_motor_and_held_by_the_brake() {
    let start = |mode, force| {
        let mut scene = table3::scene(mode, Input::constant(force));
        scene.environment = table3::spring_wall();
        scene.start.theta_rad = 0.6;
        run(scene)
    };
    assert_eq!(start(DriveMode::Active, 1.0).events[0].region.motion, Motion::Backward);
    assert_eq!(kinds(&start(DriveMode::Hybrid, 5.0)), []);
    assert_eq!(kinds(&start(DriveMode::Passive, -12.9)), []);
    assert_eq!(start(DriveMode::Hybrid, 13.1).events[0].region.motion, Motion::Forward);
}

#[test]
fn an_input_that_jumps_frees_a_held_lever_at_once() {
    let series = Series { t_s: vec![0.0, 1.005, 1.005], value: vec![5.0, 5.0, 1.0] };
    let mut scene = table3::scene(DriveMode::Hybrid, Input::Series(series));
    scene.environment = table3::spring_wall();
    scene.start.theta_rad = 0.6;
    let run = run(scene);
    assert_eq!(
        (run.events[1].kind, run.events[1].region.motion),
        (EventKind::Input, Motion::Backward)
    );
    assert!((run.events[1].t_s - 1.005).abs() < 1e-15);
}

#[test]
fn the_let_go_rule_holds_a_wall_until_the_user_yields() {
    let mut scene = table3::scene(DriveMode::Hybrid, Input::Line { value: 5.0, rate: -1.0 });
    scene.environment = table3::spring_wall();
    scene.start.theta_rad = 0.6;
    let depart = |scene: ModelScene| {
        let run = run(scene);
        run.events
            .iter()
            .find(|event| event.kind != EventKind::Input)
            .map(|event| (event.t_s, event.kind))
    };
    let (plain, kind) = depart(scene.clone()).unwrap();
    assert!((plain - (5.0 - table3::MOTOR_N)).abs() < 1e-12);
    assert_eq!(kind, EventKind::DepartDown);
    scene.brake.let_go_n = Some(2.0);
    let (late, kind) = depart(scene).unwrap();
    assert!((late - 3.0).abs() < 1e-12);
    assert_eq!(kind, EventKind::LetGo);
}

#[test]
fn a_pressed_finger_passes_the_whole_force_and_its_tissue_saturates_at_3_5_n() {
    let mut scene = table3::with_finger(table3::scene(DriveMode::Passive, Input::constant(6.0)));
    scene.start.theta_rad = 0.78;
    scene.duration_s = 0.4;
    let system = System::new(scene).unwrap();
    let run = Exact::default().run(&system, &Grid::of(&system)).unwrap();
    let last = run.forces(&system, run.len() - 1);
    assert_eq!(run.events.last().unwrap().region.contact, Contact::Pressed);
    assert!((last.tip_n - 6.0).abs() < 1e-12, "{last:?}");
    assert!((last.tissue_n - 584.6 * 0.006).abs() < 1e-12);
}

#[test]
fn a_finger_that_bottoms_on_a_free_lever_keeps_the_momentum() {
    // Pushed by 40 N with no object: momentum of both masses is the impulse of the force, whatever
    // the tissue does.
    let mut scene = table3::with_finger(oscillator(0.0, Input::constant(40.0), 0.0));
    scene.environment = Environment::free();
    scene.duration_s = 0.1;
    scene.step_s = 1e-3;
    let run = run(scene);
    assert!(kinds(&run).contains(&EventKind::Bottomed));
    for i in 0..run.len() {
        let z = run.state(i);
        let momentum = 0.005 * z[1] + 0.021 * (z[1] + z[3]);
        assert!((momentum - 40.0 * run.t_s[i]).abs() < 4e-12, "{i}: {momentum}");
    }
}

#[test]
fn gravity_is_refused_by_name() {
    let mut scene = table3::scene(DriveMode::Active, Input::step(1.0));
    scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.04 });
    let error =
        Exact::default().run(&System::new(scene).unwrap(), &Grid::filling(1.0, 0.1)).unwrap_err();
    assert_eq!(error, DynamicsError::NotPiecewiseAffine { term: "gravity" });
}

#[test]
fn the_thesis_finger_bottoms_without_moving_the_lever() {
    let mut scene = table3::scene(DriveMode::Passive, Input::constant(6.0));
    scene.finger = Some(table3::finger(FingerLaw::Thesis));
    let run = run(scene);
    assert!(kinds(&run).contains(&EventKind::Bottomed));
    assert!(run.finger_m().all(|x| x <= table3::FINGER_LENGTH_M));
}

#[test]
fn a_dead_zone_takes_its_share_of_the_brake() {
    // u = 4 N/rad x 1 rad = 4 N; with 1 N lost the brake holds 3 N.
    let holds = |force: f64| {
        let mut scene = table3::scene(DriveMode::Passive, Input::constant(force));
        scene.brake.dead_zone_n = 1.0;
        scene.start.theta_rad = 1.0 - table3::HALF_STROKE_RAD;
        run(scene).events[0].region.motion == Motion::Rest
    };
    assert!(holds(2.999) && holds(-2.999) && !holds(3.001) && !holds(-3.001));
}

#[test]
fn a_prepared_system_gives_the_same_bits_again_and_without_samples() {
    let system =
        System::new(table3::with_finger(table3::scene(DriveMode::Hybrid, Input::step(2.15))))
            .unwrap();
    let grid = Grid::of(&system);
    let fresh = Exact::default().run(&system, &grid).unwrap();
    let mut prepared = Exact::default().prepare(&system, &grid).unwrap();
    let mut again = fresh.clone();
    for _ in 0..3 {
        prepared.run_into(&grid, &mut again).unwrap();
        assert_eq!(again.events, fresh.events);
    }
    let mut last = Vec::new();
    let bare = prepared.visit(&grid, &mut |_, z| last = z.to_vec()).unwrap();
    assert_eq!(last, again.state(again.len() - 1));
    assert_eq!((bare.len(), bare.events.len()), (0, fresh.events.len()));
}

#[test]
fn uneven_steps_give_the_even_steps_trajectory() {
    for finger in [false, true] {
        let scene = table3::scene(DriveMode::Hybrid, Input::ramp(2.15));
        let system = System::new(if finger { table3::with_finger(scene) } else { scene }).unwrap();
        let even = Exact::default().run(&system, &Grid::filling(4.0, 1e-3)).unwrap();
        let times = (0..=4000).map(|i: i32| {
            let shift = if i % 2 == 1 { 0.4 * libm::sin(f64::from(i)) } else { 0.0 };
            (f64::from(i) + shift) * 1e-3
        });
        let uneven = Exact::default().run(&system, &Grid::Times(times.collect())).unwrap();
        for i in (0..=4000).step_by(2) {
            assert!((even.state(i)[0] - uneven.state(i)[0]).abs() < 1e-13, "{i}");
        }
    }
}
