//! Terms that are defined only here: what a new file would contain.

use serde::{Deserialize, Serialize};

use super::*;
use crate::scene::actuators::DriveMode;
use crate::scene::environment::Environment;
use crate::scene::input::Input;
use crate::scene::parameter::Parameter;
use crate::scene::plant::Plant;
use crate::scene::{ModelScene, table3};
use crate::solve::adaptive::Tolerances;
use crate::{DormandPrince, DynamicsError, Exact, Grid, Rk4, Solver, Switching, System, TrBdf2};

/// A second spring with a damper: F = −K (θ − θ_rest) − B θ̇.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Bed {
    stiffness_n_per_rad: f64,
    damping_ns_per_rad: f64,
    rest_rad: f64,
}

impl Term for Bed {
    fn name(&self) -> &'static str {
        "bed"
    }

    fn about(&self) -> &'static str {
        "force of the spring bed"
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            Parameter::not_negative("stiffness_n_per_rad", self.stiffness_n_per_rad, 1.0),
            Parameter::not_negative("damping_ns_per_rad", self.damping_ns_per_rad, 1.0),
            Parameter::any("rest_rad", self.rest_rad, 1.0),
        ]
    }

    fn affine(&self, _: &Plant) -> Affine {
        let k = self.stiffness_n_per_rad;
        let (per_rad_n, per_rad_s_n) = (-k, -self.damping_ns_per_rad);
        Affine { constant_n: k * self.rest_rad, per_rad_n, per_rad_s_n, per_input_n: 0.0 }
    }
}

/// Magnets that hold the lever at n angles a turn, and air that brakes it: F = −A sin(n θ) − c θ̇
/// |θ̇|.
#[derive(Debug, Clone, Copy, Serialize)]
struct Detent {
    force_n: f64,
    per_turn: f64,
    drag_ns2_per_rad2: f64,
}

impl Term for Detent {
    fn name(&self) -> &'static str {
        "detent"
    }

    fn about(&self) -> &'static str {
        "force of the magnets, and drag"
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![
            Parameter::any("force_n", self.force_n, 1.0),
            Parameter::not_negative("per_turn", self.per_turn, 1.0),
            Parameter::not_negative("drag_ns2_per_rad2", self.drag_ns2_per_rad2, 1.0),
        ]
    }

    fn curve(&self, _: &Plant, theta_rad: f64, theta_dot_rad_s: f64) -> Option<Curve> {
        let (sine, cosine) = libm::sincos(self.per_turn * theta_rad);
        let speed = theta_dot_rad_s.abs();
        Some(Curve {
            force_n: -self.force_n * sine - self.drag_ns2_per_rad2 * theta_dot_rad_s * speed,
            per_rad_n: -self.force_n * self.per_turn * cosine,
            per_rad_s_n: -2.0 * self.drag_ns2_per_rad2 * speed,
        })
    }
}

/// Table 3 without environment or stops, released at 0.3 rad.
fn free() -> ModelScene {
    let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
    scene.environment = Environment::free();
    scene.plant.stops_rad = None;
    scene.start.theta_rad = 0.3;
    ModelScene { duration_s: 1.0, step_s: 1e-3, ..scene }
}

fn bed() -> Bed {
    Bed { stiffness_n_per_rad: 4.0, damping_ns_per_rad: 0.25, rest_rad: 0.1 }
}

#[test]
fn a_spring_bed_swings_as_its_closed_form_in_every_solver() {
    let mut scene = free();
    scene.terms.set(bed());
    let system = System::new(scene).unwrap();
    let (sigma, inertia) = (0.25 / (2.0 * table3::OBJECT_MASS_KG), table3::OBJECT_MASS_KG);
    let omega = (4.0 / inertia - sigma * sigma).sqrt();
    let tolerances = Tolerances::of(1e-11);
    let solvers: [(&dyn Solver, f64); 4] = [
        (&Exact::default(), 1e-13),
        (&DormandPrince { tolerances }, 1e-9),
        (&TrBdf2 { tolerances: Tolerances::of(1e-8) }, 1e-6),
        (&Rk4 { switching: Switching::PerStage }, 1e-5),
    ];
    for (solver, bound) in solvers {
        let run = solver.run(&system, &Grid::of(&system)).unwrap();
        for (t, theta) in run.t_s.iter().zip(run.theta_rad()) {
            let swing = libm::cos(omega * t) + sigma / omega * libm::sin(omega * t);
            let expect = 0.1 + 0.2 * libm::exp(-sigma * t) * swing;
            assert!((theta - expect).abs() < bound, "{} at {t}: {}", solver.name(), theta - expect);
        }
    }
}

#[test]
fn the_force_of_a_term_is_told_by_its_place_and_its_work_closes_the_balance() {
    let mut scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
    scene.terms.set(bed());
    scene.terms.set(pull::Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.5) });
    let system = System::new(scene).unwrap();
    let run = Exact { energy: true, ..Exact::default() }.run(&system, &Grid::of(&system)).unwrap();
    for i in 0..run.len() {
        let [theta, omega] = [run.state(i)[0], run.state(i)[1]];
        let parts: Vec<f64> = system.term_forces_n(run.state(i)).collect();
        let expect = [-4.0 * (theta - 0.1) - 0.25 * omega, 2.0 * (0.5 - theta)];
        let far = parts.iter().zip(expect).any(|(found, expect)| (found - expect).abs() > 1e-12);
        assert!(!far && parts.len() == 2, "{parts:?} instead of {expect:?}");
        assert!((run.forces(&system, i).terms_n - parts[0] - parts[1]).abs() < 1e-12);
    }
    let energy = run.energy.unwrap();
    assert!(
        energy.terms_j.abs() > 0.01 && energy.residual_j().abs() < 1e-10 * energy.summed_j(),
        "{energy:?}"
    );
}

#[test]
fn a_detent_holds_with_its_force_and_loses_no_energy_but_to_drag() {
    let detent = |drag_ns2_per_rad2| {
        let mut scene = free();
        scene.terms.set(Detent { force_n: 2.0, per_turn: 8.0, drag_ns2_per_rad2 });
        scene.start.theta_dot_rad_s = 1.0;
        System::new(scene).unwrap()
    };
    let energy =
        |z: &[f64]| 0.5 * table3::OBJECT_MASS_KG * z[1] * z[1] - 2.0 / 8.0 * libm::cos(8.0 * z[0]);
    let tolerances = Tolerances::of(1e-10);
    let system = detent(0.0);
    let run = DormandPrince { tolerances }.run(&system, &Grid::of(&system)).unwrap();
    let start = energy(run.state(0));
    assert!((0..run.len()).all(|i| (energy(run.state(i)) - start).abs() < 1e-8));
    assert!(
        run.theta_rad().all(|theta| theta.abs() < std::f64::consts::PI / 8.0),
        "it left its magnet"
    );
    // With drag the implicit method, which needs the derivatives, agrees with the explicit one.
    let system = detent(0.02);
    let explicit = DormandPrince { tolerances }.run(&system, &Grid::of(&system)).unwrap();
    let implicit =
        TrBdf2 { tolerances: Tolerances::of(1e-8) }.run(&system, &Grid::of(&system)).unwrap();
    let difference = explicit.theta_rad().zip(implicit.theta_rad()).map(|(a, b)| (a - b).abs());
    assert!(difference.fold(0.0, f64::max) < 1e-5);
    assert!(implicit.work.steps < 200_000, "{:?}", implicit.work);
    let (first, last) = (energy(explicit.state(0)), energy(explicit.state(explicit.len() - 1)));
    assert!(last < first - 1e-3, "{first} {last}");
}

#[test]
fn a_curved_term_is_refused_by_name_where_the_flow_must_be_affine() {
    let mut scene = free();
    scene.terms.set(Detent { force_n: 2.0, per_turn: 8.0, drag_ns2_per_rad2: 0.0 });
    let system = System::new(scene).unwrap();
    let error = Exact::default().run(&system, &Grid::of(&system)).unwrap_err();
    assert_eq!(error, DynamicsError::NotPiecewiseAffine { term: "detent" });
}

#[test]
fn a_number_that_makes_no_sense_is_named_with_its_term() {
    for (stiffness_n_per_rad, says) in
        [(-1.0, "is -1"), (f64::NAN, "is NaN"), (1e300, "at most 1e30")]
    {
        let mut scene = free();
        scene.terms.set(Bed { stiffness_n_per_rad, ..bed() });
        let error = System::new(scene).unwrap_err().to_string();
        assert!(error.contains("bed.stiffness_n_per_rad") && error.contains(says), "{error}");
    }
}

#[test]
fn an_extreme_term_is_the_suspect_of_a_run_that_goes_wrong() {
    let mut scene = free();
    scene.terms.set(Bed { stiffness_n_per_rad: 1e30, ..bed() });
    let error =
        Exact::default().run(&System::new(scene).unwrap(), &Grid::filling(1.0, 0.1)).unwrap_err();
    assert!(error.to_string().contains("bed.stiffness_n_per_rad = 1"), "{error}");
}

#[test]
fn the_order_in_which_terms_are_set_does_not_matter_and_a_name_stands_once() {
    let pull = pull::Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.5) };
    let (mut one, mut other) = (Terms::default(), Terms::default());
    one.set(bed());
    one.set(pull.clone());
    other.set(pull);
    other.set(Bed { rest_rad: 3.0, ..bed() });
    assert_ne!(one, other);
    other.set(bed());
    assert_eq!(one, other);
    assert_eq!(one.iter().map(Term::name).collect::<Vec<_>>(), ["bed", "pull"]);
}

#[test]
fn a_second_term_with_an_input_of_its_own_is_refused() {
    #[derive(Debug, Serialize)]
    struct Other(pull::Pull);
    impl Term for Other {
        fn name(&self) -> &'static str {
            "other"
        }
        fn about(&self) -> &'static str {
            "force of another moved spring"
        }
        fn parameters(&self) -> Vec<Parameter> {
            self.0.parameters()
        }
        fn input(&self) -> Option<(&'static str, &Input)> {
            self.0.input()
        }
    }
    let pull = pull::Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.5) };
    let mut scene = free();
    scene.terms.set(pull.clone());
    scene.terms.set(Other(pull));
    assert!(matches!(System::new(scene), Err(DynamicsError::Combination { .. })));
}

#[test]
fn each_reader_reads_the_term_of_its_key() {
    let mut scene = free();
    scene.terms.set(gravity::Gravity { mass_kg: 0.02, radius_m: 0.04 });
    scene.terms.set(pull::Pull { stiffness_n_per_rad: 2.0, displacement: Input::constant(0.5) });
    let read = ModelScene::from_toml(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(read.terms.iter().map(Term::name).collect::<Vec<_>>(), names().collect::<Vec<_>>());
}
