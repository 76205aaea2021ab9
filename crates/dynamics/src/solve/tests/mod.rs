//! All methods against each other and against closed forms, in loops over scenes.

mod properties;

use super::adaptive::Tolerances;
use super::dormand_prince::DormandPrince;
use super::exact::Exact;
use super::moreau_jean::MoreauJean;
use super::named::NAMED_SOLVERS;
use super::rk4::Rk4;
use super::symplectic_euler::SymplecticEuler;
use super::tr_bdf2::TrBdf2;
use super::*;
use crate::scene::actuators::{BrakeLaw, DriveMode};
use crate::scene::environment::Environment;
use crate::scene::finger::FingerLaw;
use crate::scene::friction::Friction;
use crate::scene::input::{Input, Series};
use crate::scene::terms::gravity::Gravity;
use crate::scene::terms::pull::Pull;
use crate::scene::{ModelScene, table3};

/// The scenes on which methods are compared: every mode, law and term at least once.
fn scenes() -> Vec<ModelScene> {
    let mut list = Vec::new();
    let uneven = Series {
        t_s: vec![0.0, 0.3, 0.35, 1.2, 2.0, 2.9],
        value: vec![0.0, 4.0, 3.5, 6.0, 1.0, 2.0],
    };
    let inputs = [Input::sine(2.15), Input::step(2.0), Input::ramp(3.2), Input::Series(uneven)];
    for mode in [DriveMode::Active, DriveMode::Passive, DriveMode::Hybrid] {
        for input in &inputs {
            let plain = table3::scene(mode, input.clone());
            let mut walled = plain.clone();
            walled.environment = table3::spring_wall();
            let mut thesis = plain.clone();
            thesis.brake.law = BrakeLaw::Thesis;
            let mut rough = plain.clone();
            rough.friction =
                Some(Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.02 });
            let mut cautious = walled.clone();
            cautious.brake.let_go_n = Some(1.5);
            let mut slow = plain.clone();
            slow.motor.lag_s = Some(0.002);
            let mut pulled = rough.clone();
            let displacement = Input::Line { value: -0.7, rate: 0.4 };
            pulled.terms.set(Pull { stiffness_n_per_rad: 2.0, displacement });
            let printed =
                ModelScene { finger: Some(table3::finger(FingerLaw::Thesis)), ..plain.clone() };
            let both = table3::with_finger(walled.clone());
            let rough_finger = table3::with_finger(rough.clone());
            list.extend([
                named("plain", plain),
                named("walled", walled),
                named("thesis brake", thesis),
                named("rough", rough),
                named("let-go", cautious),
                named("motor lag", slow),
                named("pulled", pulled),
                named("thesis finger", printed),
                named("finger and wall", both),
                named("finger and friction", rough_finger),
            ]);
        }
    }
    list
}

fn named(name: &str, scene: ModelScene) -> ModelScene {
    ModelScene { name: format!("{name}, {:?}, {:?}", scene.mode, scene.input), ..scene }
}

/// Largest difference of θ and of θ̇; samples next to an event of the first run are passed over for
/// θ̇.
fn difference(a: &Trajectory, b: &Trajectory) -> (f64, f64) {
    let near = |t: f64| a.events.iter().any(|event| (event.t_s - t).abs() < 1e-6);
    let theta = a.theta_rad().zip(b.theta_rad()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let omega = a.theta_dot_rad_s().zip(b.theta_dot_rad_s()).zip(&a.t_s);
    let omega =
        omega.filter(|(_, t)| !near(**t)).map(|((x, y), _)| (x - y).abs()).fold(0.0, f64::max);
    (theta, omega)
}

#[test]
fn the_exact_solver_agrees_with_dormand_prince_on_every_scene() {
    let peer = DormandPrince { tolerances: Tolerances::of(1e-12) };
    for scene in scenes() {
        let system = System::new(scene).unwrap();
        let grid = Grid::of(&system);
        let exact = Exact::default().run(&system, &grid).unwrap();
        let (theta, omega) = difference(&exact, &peer.run(&system, &grid).unwrap());
        let name = &system.scene().name;
        assert!(theta < 1e-9 && omega < 1e-7, "{name}: {theta} rad, {omega} rad/s");
    }
}

/// Checks the balance of the scenes whose finger keeps energy; the largest energy.
fn check_balances(scenes: impl Iterator<Item = ModelScene>) -> f64 {
    let mut largest = 0.0_f64;
    for scene in scenes {
        if scene.finger.is_some_and(|finger| finger.law == FingerLaw::Thesis) {
            continue;
        }
        let system = System::new(scene).unwrap();
        let solver = Exact { energy: true, ..Exact::default() };
        let energy = solver.run(&system, &Grid::of(&system)).unwrap().energy.unwrap();
        let share = energy.residual_j().abs() / energy.summed_j();
        assert!(share < 1e-10, "{}: {share} of {energy:?}", system.scene().name);
        largest = largest.max(energy.summed_j());
    }
    largest
}

#[test]
fn the_energy_balance_closes_on_every_scene_whose_finger_keeps_energy() {
    check_balances(scenes().into_iter());
}

#[test]
fn the_parts_of_the_force_add_up_to_mass_times_acceleration_on_every_scene() {
    for scene in scenes() {
        let system = System::new(scene).unwrap();
        let run = Exact::default().run(&system, &Grid::of(&system)).unwrap();
        for i in 0..run.len() {
            let f = run.forces(&system, i);
            let sum = f.tip_n + f.motor_n + f.brake_n + f.friction_n + f.terms_n + f.stop_n;
            let region = &run.regions[usize::from(run.region[i])];
            let needed =
                system.inertia() * system.value(&system.acceleration_in(region), run.state(i));
            assert!(
                (sum - needed).abs() < 1e-11,
                "{} at {}: {f:?}",
                system.scene().name,
                run.t_s[i]
            );
        }
    }
}

/// Largest error of θ against the exact run at the end of a smooth scene, for steps that are
/// halved.
fn errors(solver: &dyn Solver, scene: &ModelScene, steps: &[f64]) -> Vec<f64> {
    let system = System::new(scene.clone()).unwrap();
    let error = |&h: &f64| {
        let grid = Grid::filling(1.0, h);
        let exact = Exact::default().run(&system, &grid).unwrap();
        let run = solver.run(&system, &grid).unwrap();
        exact.theta_rad().zip(run.theta_rad()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    steps.iter().map(error).collect()
}

#[test]
fn every_fixed_step_method_converges_with_its_order_on_smooth_scenes() {
    let mut plain = table3::scene(DriveMode::Active, Input::sine(1.0));
    plain.environment = Environment::spring(4.0, 0.05, -0.9);
    plain.plant.stops_rad = None;
    plain.motor.max_n = 100.0;
    plain.start.theta_rad = -0.6;
    let finger = table3::with_finger(plain.clone());
    let methods: [(&dyn Solver, f64); 5] = [
        (&SymplecticEuler, 1.0),
        (&MoreauJean { theta: 1.0 }, 1.0),
        (&MoreauJean { theta: 0.5 }, 2.0),
        (&Rk4 { switching: Switching::PerStage }, 4.0),
        (&Rk4 { switching: Switching::PerStep }, 4.0),
    ];
    for (solver, order) in methods {
        for scene in [&plain, &finger] {
            let e = errors(solver, scene, &[1.0 / 4000.0, 1.0 / 8000.0]);
            let slope = (e[0] / e[1]).log2();
            assert!(
                (slope - order).abs() < 0.1,
                "{}: {slope} instead of {order}, {e:?}",
                solver.name()
            );
        }
    }
}

#[test]
fn time_stepping_and_rk4_come_close_to_the_exact_solution_on_every_scene() {
    // Three ways of saying one thing: the law at a step's end, the thesis' switching right-hand
    // side, the regions.
    for mut scene in scenes() {
        let grid = Grid::filling(4.0, 1e-4);
        if let Some(friction) = &mut scene.friction {
            friction.static_n = friction.kinetic_n; // the switching right-hand side has no level at rest
        }
        let creeps = scene.mode == DriveMode::Passive || scene.brake.let_go_n.is_some();
        let system = System::new(scene).unwrap();
        let name = &system.scene().name;
        let exact = Exact::default().run(&system, &grid).unwrap();
        let (theta, _) = difference(&exact, &MoreauJean::default().run(&system, &grid).unwrap());
        assert!(theta < 5e-3, "moreau_jean, {name}: {theta}");
        // Where the brake holds a lever by itself, switching on the sign lets it creep.
        if !creeps {
            let rk4 = Rk4 { switching: Switching::PerStage }.run(&system, &grid).unwrap();
            let (theta, _) = difference(&exact, &rk4);
            assert!(theta < 5e-3, "rk4, {name}: {theta}");
        }
    }
}

#[test]
fn time_stepping_finds_the_cycle_of_a_late_brake() {
    let mut scene = table3::scene(DriveMode::Hybrid, Input::sine(2.15));
    scene.brake.lag_on_off_s = Some([0.015, 0.010]);
    let system = System::new(scene).unwrap();
    let at = |h: f64| {
        let grid = Grid::filling(2.0, h);
        let exact = Exact::default().run(&system, &grid).unwrap();
        difference(&exact, &MoreauJean::default().run(&system, &grid).unwrap()).0
    };
    let (coarse, fine) = (at(2e-4), at(2e-5));
    assert!(fine < 2e-3 && fine < 0.3 * coarse, "{coarse} {fine}");
}

#[test]
fn gravity_swings_with_the_period_of_a_compound_pendulum() {
    // Hanging below the axis, small amplitude: omega^2 = m g r / (M_O L^2).
    let mut scene = table3::scene(DriveMode::Passive, Input::constant(0.0));
    scene.brake.max_n = 0.0;
    scene.plant.stops_rad = None;
    scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.05 });
    scene.start.theta_rad = std::f64::consts::PI + 1e-4;
    let system = System::new(scene).unwrap();
    let omega = (0.02 * 9.80665 * 0.05 / 0.005_f64).sqrt();
    let solvers: [(&dyn Solver, f64); 2] = [
        (&DormandPrince { tolerances: Tolerances::of(1e-11) }, 1e-12),
        (&TrBdf2 { tolerances: Tolerances::of(1e-9) }, 1e-8),
    ];
    for (solver, bound) in solvers {
        let run = solver.run(&system, &Grid::filling(4.0, 0.01)).unwrap();
        for (t, theta) in run.t_s.iter().zip(run.theta_rad()) {
            let expect = std::f64::consts::PI + 1e-4 * libm::cos(omega * t);
            assert!(
                (theta - expect).abs() < bound + 1e-12,
                "{} at {t}: {}",
                solver.name(),
                theta - expect
            );
        }
    }
}

#[test]
fn the_stiff_method_agrees_with_the_exact_one_where_the_finger_is_hard() {
    let mut scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
    if let Some(finger) = &mut scene.finger {
        finger.damping_ns_per_m = 1e5;
    }
    let system = System::new(scene).unwrap();
    let grid = Grid::of(&system);
    let exact = Exact::default().run(&system, &grid).unwrap();
    let stiff = TrBdf2 { tolerances: Tolerances::of(1e-8) }.run(&system, &grid).unwrap();
    assert!(difference(&exact, &stiff).0 < 1e-5, "{:?}", difference(&exact, &stiff));
    assert!(stiff.work.steps < 200_000, "{:?}", stiff.work);
}

#[test]
fn the_step_ends_at_0_as_5_has_it_and_starts_anew_in_a_run_that_goes_on() {
    let tolerances = Tolerances::of(1e-6);
    let solvers: [&dyn Solver; 6] = [
        &Exact::default(),
        &DormandPrince { tolerances },
        &TrBdf2 { tolerances },
        &MoreauJean::default(),
        &SymplecticEuler,
        &Rk4 { switching: Switching::PerStage },
    ];
    let scene = table3::scene(DriveMode::Hybrid, Input::step(2.0));
    let system = System::new(scene).unwrap();
    let uneven = Grid::Times(vec![0.0, 0.5, 1.0, 2.7, 4.0]);
    for solver in solvers {
        let force = |run: &Trajectory, i: usize| run.forces(&system, i).external_n;
        for grid in [Grid::filling(4.0, 1e-3), uneven.clone()] {
            let run = solver.run(&system, &grid).unwrap();
            let last = run.len() - 1;
            assert!((run.t_s[last] - 4.0).abs() < 1e-15);
            assert_eq!(force(&run, last).to_bits(), 0.0_f64.to_bits(), "{}", solver.name());
        }
        let run = solver.run(&system, &Grid::filling(4.5, 1e-3)).unwrap();
        for (i, expect) in [
            (0, 4.0),
            (999, 4.0),
            (1000, 0.0),
            (1999, 0.0),
            (2000, 4.0),
            (3999, 0.0),
            (4000, 4.0_f64),
        ] {
            assert_eq!(force(&run, i).to_bits(), expect.to_bits(), "{}, sample {i}", solver.name());
        }
    }
}

#[test]
fn a_run_whose_steps_miss_its_end_takes_a_last_short_sample_with_every_solver() {
    // 481 steps of 8.3 ms are 3.9923 s.
    let system = System::new(table3::scene(DriveMode::Active, Input::ramp(1.0))).unwrap();
    let grid = Grid::of(&system);
    assert_eq!(grid.samples(), 483);
    let whole = Exact::default().run(&system, &Grid::filling(4.0, 1e-3)).unwrap();
    for named in NAMED_SOLVERS {
        let run = (named.make)(1e-9).run(&system, &grid).unwrap();
        assert_eq!((run.len(), run.t_s[482].to_bits()), (483, 4.0_f64.to_bits()));
        assert!((run.t_s[481] - 3.9923).abs() < 1e-12);
        let (end, expect) = (run.state(482)[0], whole.state(4000)[0]);
        let bound = if named.name == "exact" { 1e-12 } else { 0.02 };
        assert!((end - expect).abs() < bound, "{}: {end} instead of {expect}", named.name);
    }
}

#[test]
fn the_energy_balance_closes_for_a_lever_that_starts_at_1e9_rad_per_s() {
    let largest = check_balances(scenes().into_iter().map(|mut scene| {
        scene.start.theta_dot_rad_s = 1e9;
        scene
    }));
    assert!(largest > 1e15, "{largest}"); // half of 0.005 kg · (1e9 m/s)²
}
