//! A pushed lever on a spring, for the tests of this crate.

use crate::Parameter;
use zwidth_dynamics::{
    DriveMode, Environment, Exact, Friction, Grid, Input, ModelScene, Plant, Series, Solver, Start,
    System, table3,
};
use zwidth_results::PlantParameter;
use zwidth_study::TrialMeta;

const fn parameter(name: PlantParameter, unit: &'static str, by_eye: f64, upper: f64) -> Parameter {
    Parameter { name, unit, by_eye, lower: 0.0, upper }
}

/// Mass, damping, dry friction.
pub(crate) const PARAMETERS: [Parameter; 3] = [
    Parameter { lower: 1e-4, ..parameter(PlantParameter::Mass, "kg", 0.1, 10.0) },
    parameter(PlantParameter::Damping, "N·s/rad", 1.0, 100.0),
    parameter(PlantParameter::Friction, "N", 0.0, 5.0),
];
pub(crate) const STARTS: [[f64; 3]; 1] = [[0.1, 0.2, 0.05]];
/// What the trials are simulated with.
pub(crate) const TRUE: [f64; 3] = [0.4, 0.15, 0.12];

/// The trials' identities: repeats of one condition.
pub(crate) fn metas(count: u32) -> Vec<TrialMeta> {
    (1..=count).map(|trial| zwidth_testing::meta(trial, "active")).collect()
}

/// θ of trial `i`: a push there and back, each trial another one.
pub(crate) fn pushed(i: usize, [mass_kg, damping, friction_n]: &[f64; 3]) -> Option<Vec<f64>> {
    let t_s: Vec<f64> = (0..=150).map(|k| f64::from(k) * 0.02).collect();
    let size = 1.5 + 0.1 * i as f64;
    let omega = 2.0 + 0.3 * i as f64;
    let push = |t: f64| size * (1.0 - libm::cos(omega * t)) + 0.2 * libm::sin(11.0 * t);
    let value = t_s.iter().map(|t| push(*t)).collect();
    let scene = ModelScene {
        duration_s: 3.0,
        environment: Environment::spring(4.0, 0.0, 0.0),
        plant: Plant { mass_kg: *mass_kg, lever_m: 0.05, stops_rad: None },
        friction: Some(Friction {
            static_n: *friction_n,
            kinetic_n: *friction_n,
            viscous_ns_per_rad: *damping,
        }),
        start: Start::default(),
        ..table3::scene(DriveMode::Active, Input::Series(Series { t_s: t_s.clone(), value }))
    };
    let run = Exact::default().run(&System::new(scene).ok()?, &Grid::Times(t_s)).ok()?;
    Some(run.theta_rad().collect())
}

/// A model that explains one point at a time, for those who ask for several.
pub(crate) fn each<const P: usize>(
    explain: impl Fn(usize, &[f64; P]) -> Option<Vec<f64>>,
) -> impl Fn(usize, &[[f64; P]]) -> Vec<Option<Vec<f64>>> {
    move |i, points| points.iter().map(|p| explain(i, p)).collect()
}
