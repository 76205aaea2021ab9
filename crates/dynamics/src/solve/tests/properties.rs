//! What must hold for any scene: passivity, the energy balance, and a result or a named error.

use proptest::prelude::*;

use super::super::adaptive::Tolerances;
use super::super::dormand_prince::DormandPrince;
use super::super::exact::Exact;
use super::super::moreau_jean::MoreauJean;
use super::super::rk4::Rk4;
use super::super::symplectic_euler::SymplecticEuler;
use super::super::tr_bdf2::TrBdf2;
use super::super::*;
use crate::energy::EnergyBalance;
use crate::error::DynamicsError;
use crate::scene::actuators::{BrakeLaw, DriveMode};
use crate::scene::environment::Environment;
use crate::scene::finger::{Finger, FingerLaw};
use crate::scene::friction::Friction;
use crate::scene::input::{Input, Series};
use crate::scene::terms::pull::Pull;
use crate::scene::{ModelScene, table3};
use crate::trajectory::Forces;

/// A scene is quick to run, and the odd ones are rare: forty times as many cases as other
/// properties have.
fn many() -> ProptestConfig {
    let usual = ProptestConfig::default();
    ProptestConfig { cases: 40 * usual.cases, ..usual }
}

/// 10^x for x uniform between two exponents.
fn log(low: f64, high: f64) -> impl Strategy<Value = f64> + Clone {
    (low..high).prop_map(|x| libm::pow(10.0, x))
}

fn mode() -> impl Strategy<Value = DriveMode> {
    prop_oneof![Just(DriveMode::Active), Just(DriveMode::Passive), Just(DriveMode::Hybrid)]
}

fn input() -> impl Strategy<Value = Input> {
    let series = prop::collection::vec((0.001..0.2_f64, -8.0..8.0_f64), 1..12).prop_map(|steps| {
        let mut t = 0.0;
        let mut series = Series { t_s: vec![0.0], value: vec![0.0] };
        for (dt, value) in steps {
            t += dt;
            series.t_s.push(t);
            series.value.push(value);
        }
        Input::Series(series)
    });
    prop_oneof![
        log(-1.0, 1.0).prop_map(|magnitude| Input::Step { magnitude, period_s: 1.0 }),
        log(-1.0, 1.0).prop_map(|magnitude| Input::Ramp { magnitude, period_s: 1.0 }),
        (log(-1.0, 1.0), log(-1.0, 2.0))
            .prop_map(|(magnitude, omega_rad_s)| Input::Sine { magnitude, omega_rad_s }),
        series,
    ]
}

fn finger() -> impl Strategy<Value = Option<Finger>> {
    prop::option::of((log(-2.0, -0.5), log(1.0, 3.0), log(-1.0, 1.0)).prop_map(
        |(mass_kg, k, b)| Finger {
            law: FingerLaw::Consistent,
            mass_kg,
            stiffness_n_per_m: k,
            damping_ns_per_m: b,
            length_m: Some(0.006),
        },
    ))
}

fn friction() -> impl Strategy<Value = Option<Friction>> {
    let levels = (0.0..0.4_f64, 0.0..1.0_f64, 0.0..0.1_f64);
    prop::option::of(levels.prop_map(|(static_n, share, viscous_ns_per_rad)| Friction {
        static_n,
        kinetic_n: share * static_n,
        viscous_ns_per_rad,
    }))
}

prop_compose! {
    /// A device-like scene of one second, at rest on its lower stop with nothing stored.
    fn scene()(
        mode in mode(),
        input in input(),
        spring in (log(-1.0, 1.5), log(-2.0, 0.5)),
        plant in (log(-3.0, 0.0), log(-1.5, 0.3)),
        limits in (log(-0.5, 1.0), log(0.0, 1.5)),
        wall in prop::option::of(-0.5..0.7_f64),
        finger in finger(),
        friction in friction(),
    ) -> ModelScene {
        let environment = Environment::spring(spring.0, spring.1, -table3::HALF_STROKE_RAD);
        let mut scene = table3::scene(mode, input);
        scene.environment = wall.map_or(environment.clone(), |wall| environment.with_wall(wall));
        scene.duration_s = 1.0;
        (scene.plant.mass_kg, scene.plant.lever_m) = plant;
        (scene.motor.max_n, scene.brake.max_n) = limits;
        (scene.finger, scene.friction) = (finger, friction);
        scene
    }
}

/// The balance of a run; none where a motor bounces on its wall without end, which ends in an
/// error.
fn energy(scene: ModelScene) -> Option<EnergyBalance> {
    let bounces = scene.mode != DriveMode::Passive && scene.environment.zones.len() > 1;
    let system = System::new(scene).unwrap();
    let solver = Exact { energy: true, most_events: 10_000, ..Exact::default() };
    let grid = Grid::of(&system);
    match solver.prepare(&system, &grid).and_then(|mut run| run.visit(&grid, &mut |_, _| ())) {
        Ok(run) => run.energy,
        Err(DynamicsError::TooMuchWork { .. }) if bounces => None,
        Err(error) => panic!("{error}"),
    }
}

proptest! {
    #![proptest_config(many())]

    #[test]
    fn the_passive_mode_takes_no_energy_from_nothing_and_every_balance_closes(scene in scene()) {
        let passive = scene.mode == DriveMode::Passive;
        let Some(e) = energy(scene) else { return Ok(()) };
        prop_assert!(e.residual_j().abs() <= 1e-10 * e.summed_j(), "{:?}: {}", e, e.residual_j() / e.summed_j());
        if passive {
            prop_assert!(e.external_j >= -1e-10 * e.summed_j(), "{:?}", e);
            prop_assert!(e.brake_j <= 0.0);
        }
    }
}

/// A number from the whole range, or one no equation likes.
fn extreme() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => log(-9.0, 9.0),
        1 => prop_oneof![
            Just(0.0), Just(f64::NAN), Just(f64::INFINITY), Just(f64::MIN_POSITIVE / 8.0), Just(-1.0),
            Just(f64::MAX), Just(5e-324), Just(1e-300), Just(1e300)
        ],
    ]
}

/// A scene with one parameter (by number) at an extreme, or all of them.
fn extreme_scene(mut scene: ModelScene, which: usize, x: &[f64]) -> ModelScene {
    let mut finger = table3::finger(FingerLaw::Consistent);
    let mut friction = Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.02 };
    let (mut stiff, mut damped) = (4.0, 1.0);
    let (mut motor_lag, mut lag_on, mut lag_off) = (0.002, 0.015, 0.01);
    let mut magnitude = 2.15;
    let mut omega = 1.57;
    let mut stiffness = 1.0;
    let mut rate = 0.3;
    let places: [&mut f64; 20] = [
        &mut scene.plant.mass_kg,
        &mut scene.plant.lever_m,
        &mut scene.motor.max_n,
        &mut scene.brake.max_n,
        &mut stiff,
        &mut damped,
        &mut finger.mass_kg,
        &mut finger.stiffness_n_per_m,
        &mut finger.damping_ns_per_m,
        &mut friction.static_n,
        &mut friction.kinetic_n,
        &mut friction.viscous_ns_per_rad,
        &mut motor_lag,
        &mut lag_on,
        &mut lag_off,
        &mut magnitude,
        &mut omega,
        &mut stiffness,
        &mut rate,
        &mut scene.brake.dead_zone_n,
    ];
    let count = places.len();
    for (i, place) in places.into_iter().enumerate() {
        if which % (count + 1) == i || which % (count + 1) == count {
            *place = x[i];
        }
    }
    let bits = which / (count + 1);
    scene.environment = Environment::spring(stiff, damped, -table3::HALF_STROKE_RAD).with_wall(0.3);
    scene.input = match bits >> 5 {
        0 => Input::Sine { magnitude, omega_rad_s: omega },
        1 => Input::Step { magnitude, period_s: omega },
        _ => Input::Ramp { magnitude, period_s: omega },
    };
    scene.finger = (bits & 1 == 1).then_some(finger);
    scene.friction = (bits & 2 == 2).then_some(friction);
    scene.motor.lag_s = (bits & 4 == 4).then_some(motor_lag);
    scene.brake.lag_on_off_s = (bits & 8 == 8).then_some([lag_on, lag_off]);
    let displacement = Input::Line { value: 0.0, rate };
    if bits & 16 == 16 {
        scene.terms.set(Pull { stiffness_n_per_rad: stiffness, displacement });
    }
    scene
}

fn all_finite(force: &Forces) -> bool {
    let Forces { external_n, tip_n, tissue_n, motor_n, brake_n, friction_n, terms_n, stop_n } =
        *force;
    [external_n, tip_n, tissue_n, motor_n, brake_n, friction_n, terms_n, stop_n]
        .iter()
        .all(|x| x.is_finite())
}

proptest! {
    #![proptest_config(many())]

    #[test]
    fn an_extreme_scene_ends_in_a_finite_result_or_in_an_error_that_names_a_parameter(
        mode in mode(),
        law in prop_oneof![Just(BrakeLaw::Coulomb), Just(BrakeLaw::Thesis)],
        finger in prop_oneof![Just(FingerLaw::Consistent), Just(FingerLaw::Thesis)],
        which in 0_usize..21 * 96,
        x in prop::collection::vec(extreme(), 20),
    ) {
        let mut scene = extreme_scene(table3::scene(mode, Input::sine(1.0)), which, &x);
        scene.brake.law = law;
        if let Some(chosen) = &mut scene.finger {
            chosen.law = finger;
        }
        prop_assert_eq!(ends_well(scene, which % 2 == 0), Ok(()));
    }
}

/// Runs a scene with every method; what did not end as it must.
fn ends_well(scene: ModelScene, energy: bool) -> std::result::Result<(), String> {
    let exact = Exact { most_events: 500, most_pieces: 20_000, energy };
    let tolerances = Tolerances { most_steps: 1_000, ..Tolerances::of(1e-6) };
    let solvers: [&dyn Solver; 6] = [
        &exact,
        &Rk4 { switching: Switching::PerStage },
        &SymplecticEuler,
        &MoreauJean::default(),
        &DormandPrince { tolerances },
        &TrBdf2 { tolerances },
    ];
    let system = match System::new(scene) {
        Ok(system) => system,
        Err(DynamicsError::Parameter { name, .. }) if name.contains('.') => return Ok(()),
        Err(DynamicsError::Combination { .. }) => return Ok(()),
        Err(error) => return Err(error.to_string()),
    };
    for solver in solvers {
        let wrong = |what: &str| Err(format!("{}: {what}", solver.name()));
        match solver.run(&system, &Grid::filling(0.4, 0.008)) {
            Ok(run) if !run.states.iter().all(|x| x.is_finite()) => {
                return wrong("a state is not finite");
            }
            Ok(run) if (0..run.len()).any(|i| !all_finite(&run.forces(&system, i))) => {
                return wrong("a force is not finite");
            }
            Err(error) if !error.to_string().contains(" = ") => return wrong(&error.to_string()),
            Ok(_) | Err(_) => {}
        }
    }
    Ok(())
}

/// Found by the property above, with numbers beyond 1e30 still allowed: its forces were no numbers.
#[test]
fn a_brake_of_the_largest_number_is_refused_by_name() {
    let mut x = [1.0; 20];
    x[..8].copy_from_slice(&[
        2.947674143981418e-8,
        347142.4023179618,
        1.0,
        f64::MAX,
        0.44352422811830217,
        0.0,
        1.0,
        1.0,
    ]);
    let mut scene = extreme_scene(table3::scene(DriveMode::Passive, Input::sine(1.0)), 1469, &x);
    if let Some(finger) = &mut scene.finger {
        finger.law = FingerLaw::Thesis;
    }
    assert_eq!(ends_well(scene.clone(), false), Ok(()));
    let error = System::new(scene).unwrap_err().to_string();
    assert!(error.starts_with("brake.max_n is 1797693134862315"), "{error}");
}

/// Found by the property above: the state stays finite, and the inertia of a bottomed finger times
/// 0 is no force.
#[test]
fn a_finger_too_heavy_for_its_lever_is_refused_by_name() {
    let mut scene = table3::with_finger(table3::scene(
        DriveMode::Passive,
        Input::Ramp { magnitude: 1.0, period_s: 1.0 },
    ));
    scene.plant.lever_m = 716132134.7158322;
    scene.finger.as_mut().unwrap().mass_kg = f64::MAX;
    let error = System::new(scene).unwrap_err().to_string();
    assert!(error.starts_with("finger.mass_kg is 1797693134862315"), "{error}");
}
