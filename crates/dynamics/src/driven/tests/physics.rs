//! What the solution must satisfy as physics: energy, one-sided contact, and finite numbers over
//! the whole range.

use super::super::*;
use super::{drive, prototype};
use crate::DynamicsError;

/// Work done on the lever by part, J, summed over fine steps by the trapezoidal rule.
#[derive(Debug, Default)]
struct Works {
    hand_j: f64,
    motor_j: f64,
    brake_j: f64,
    friction_j: f64,
    summed_j: f64,
}

fn works(parameters: &DrivenParameters, h_s: f64, states: &[DrivenState]) -> Works {
    let (l, friction) = (parameters.lever_m, parameters.friction.unwrap());
    let viscous = friction.viscous_ns_per_rad + parameters.back_emf_ns_per_rad.unwrap();
    let mut works = Works::default();
    for pair in states.windows(2) {
        let mean =
            |power: &dyn Fn(&DrivenState) -> f64| 0.5 * h_s * (power(&pair[0]) + power(&pair[1]));
        let w = |s: &DrivenState| l * s.theta_dot_rad_s;
        let parts = [
            mean(&|s| s.contact_n * w(s)),
            mean(&|s| s.motor_n * w(s)),
            -mean(&|s| s.brake_n * w(s).abs()),
            -mean(&|s| friction.kinetic_n * w(s).abs() + viscous * s.theta_dot_rad_s * w(s)),
        ];
        works.hand_j += parts[0];
        works.motor_j += parts[1];
        works.brake_j += parts[2];
        works.friction_j += parts[3];
        works.summed_j += parts.iter().map(|x| x.abs()).sum::<f64>();
    }
    works
}

/// Two seconds of a press with commands as a function of time, sampled finely.
fn run(
    parameters: &DrivenParameters,
    h_s: f64,
    command: impl Fn(f64) -> Command,
) -> Vec<DrivenState> {
    let mut plant = Driven::new(*parameters).unwrap();
    drive(&mut plant, h_s, (1.9 / h_s) as usize, |t, _| command((t * 1e3).floor() * 1e-3))
}

#[test]
fn the_work_of_all_parts_is_what_the_lever_holds() {
    let parameters = prototype();
    let states = run(&parameters, 1e-5, |t| Command {
        motor_n: -0.8 - 0.5 * libm::sin(9.0 * t),
        brake_n: 0.4 + 0.4 * libm::sin(23.0 * t),
    });
    let works = works(&parameters, 1e-5, &states);
    let kinetic =
        |s: &DrivenState| 0.5 * parameters.inertia_kg_m2 * s.theta_dot_rad_s * s.theta_dot_rad_s;
    let stored_j = kinetic(&states[states.len() - 1]) - kinetic(&states[0]);
    let residual_j = works.hand_j + works.motor_j + works.brake_j + works.friction_j - stored_j;
    assert!(
        works.summed_j > 0.1 && residual_j.abs() < 1e-5 * works.summed_j,
        "{residual_j} {works:?}"
    );
}

#[test]
fn brake_and_friction_never_give_energy_to_the_hand() {
    let parameters = prototype();
    let patterns: [fn(f64) -> f64; 3] = [
        |t| if libm::sin(120.0 * t) > 0.0 { 3.0 } else { 0.0 },
        |t| 4.0 * t,
        |t| 2.0 + 2.0 * libm::sin(300.0 * t),
    ];
    for brake in patterns {
        let states = run(&parameters, 2e-5, |t| Command { motor_n: 0.0, brake_n: brake(t) });
        let mut taken_j = 0.0;
        for pair in states.windows(2) {
            let power = |s: &DrivenState| s.contact_n * parameters.lever_m * s.theta_dot_rad_s;
            taken_j += 1e-5 * (power(&pair[0]) + power(&pair[1]));
            assert!(taken_j >= -1e-9, "{taken_j}");
        }
        assert!(taken_j > 1e-3);
    }
}

#[test]
fn the_hand_never_pulls_and_lifts_off_a_lever_that_stays() {
    let states = run(&prototype(), 1e-3, |_| Command { motor_n: 0.0, brake_n: 1.5 });
    assert!(states.iter().all(|s| s.contact_n >= 0.0));
    let last = states[states.len() - 1];
    let highest = states.iter().map(|s| s.theta_rad).fold(f64::MIN, f64::max);
    assert_eq!(last.theta_rad.to_bits(), highest.to_bits()); // a brake does not return
    assert_eq!(last.contact_n.to_bits(), 0);
    assert!(last.hand_m < 0.045 * last.theta_rad - 0.01); // and the hand went back without it
}

/// Runs a scaled plant for 50 ms; either it ends in finite numbers or in an error that names what
/// was wrong.
fn survives(parameters: DrivenParameters, command: Command) {
    let outcome = Driven::new(parameters).and_then(|mut plant| {
        for i in 0..50 {
            let aim = |k: i32| Aim { position_m: 1e-3 * f64::from(k), velocity_m_s: 1.0 };
            plant.advance(1e-3, command, [aim(i), aim(i + 1)])?;
        }
        Ok(plant.state())
    });
    match outcome {
        Ok(s) => {
            let all = [
                s.theta_rad,
                s.theta_dot_rad_s,
                s.motor_n,
                s.brake_n,
                s.contact_n,
                s.hand_m,
                s.hand_m_s,
            ];
            assert!(all.iter().all(|x| x.is_finite()), "{parameters:?}: {s:?}");
        }
        Err(DynamicsError::Parameter { name, .. }) => assert!(!name.is_empty()),
        Err(
            DynamicsError::NotFinite { suspect, .. } | DynamicsError::TooMuchWork { suspect, .. },
        ) => {
            assert!(suspect.contains(" = "));
        }
        Err(other) => panic!("{other}"),
    }
}

/// Each number of the parameters in turn.
fn numbers(p: &mut DrivenParameters) -> [&mut f64; 14] {
    let friction = p.friction.as_mut().unwrap();
    let [on, off] = p.brake_lag_on_off_s.as_mut().unwrap();
    let hand = p.hand.as_mut().unwrap();
    [
        &mut p.inertia_kg_m2,
        &mut p.lever_m,
        &mut friction.static_n,
        &mut friction.kinetic_n,
        &mut friction.viscous_ns_per_rad,
        p.back_emf_ns_per_rad.as_mut().unwrap(),
        p.motor_lag_s.as_mut().unwrap(),
        on,
        off,
        &mut hand.mass_kg,
        &mut hand.stiffness_n_per_m,
        &mut hand.damping_ns_per_m,
        &mut hand.tissue.stiffness_n_per_m,
        &mut hand.tissue.damping_ns_per_m,
    ]
}

#[test]
fn extreme_parameters_end_in_numbers_or_in_an_error_that_names_one() {
    for i in 0..14 {
        for scale in
            [0.0, 1e-12, 1e-6, 1e-3, 1e3, 1e6, 1e12, 1e300, f64::NAN, f64::INFINITY, -1.0, 5e-324]
        {
            let mut parameters = prototype();
            *numbers(&mut parameters)[i] *= scale;
            survives(parameters, Command { motor_n: -1.0, brake_n: 1.0 });
        }
    }
}

#[test]
fn extreme_commands_end_in_numbers_or_in_an_error_that_names_one() {
    for force in [0.0, 1e-300, 1e9, 1e300, f64::NAN, f64::INFINITY] {
        survives(prototype(), Command { motor_n: force, brake_n: 0.0 });
        survives(prototype(), Command { motor_n: 0.0, brake_n: force });
        survives(
            DrivenParameters { stops_rad: None, ..prototype() },
            Command { motor_n: force, brake_n: 0.0 },
        );
    }
    let mut plant = Driven::new(prototype()).unwrap();
    let error = plant
        .advance(1e-3, Command { motor_n: 0.0, brake_n: -1.0 }, [Aim::default(); 2])
        .unwrap_err();
    assert!(error.to_string().starts_with("command.brake_n is -1"), "{error}");
    let error = plant.advance(f64::NAN, Command::default(), [Aim::default(); 2]).unwrap_err();
    assert!(error.to_string().starts_with("dt_s is NaN"), "{error}");
}

#[test]
fn each_term_can_be_left_out() {
    for i in 0..6 {
        let mut parameters = prototype();
        match i {
            0 => parameters.stops_rad = None,
            1 => parameters.friction = None,
            2 => parameters.back_emf_ns_per_rad = None,
            3 => parameters.motor_lag_s = None,
            4 => parameters.brake_lag_on_off_s = None,
            _ => parameters.hand = None,
        }
        survives(parameters, Command { motor_n: -1.0, brake_n: 0.5 });
        survives(parameters, Command::default());
    }
}
