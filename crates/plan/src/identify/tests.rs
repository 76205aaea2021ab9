//! Simulate, record, fit: without sensor noise every parameter is recovered.

use super::*;
use crate::shared::conditions::spread_within;
use zwidth_device::{Controller, TwinParameters};
use zwidth_dynamics::{Aim, Command, Driven, DrivenParameters, Hand, Tissue, table3};
use zwidth_results::Identifiability;
use zwidth_store::{Samples, TrialFile};
use zwidth_study::ParticipantId;
use zwidth_study::{Calibration, Scene, Spring, Study, TrialMeta, template};

/// Samples of angle and force a second, Hz: what is between them is a cubic.
const RATE_HZ: f64 = 3000.0;
/// A motor slow enough to show: that of the prototype takes 53 µs.
const MOTOR_LAG_S: f64 = 0.004;

fn study() -> Study {
    let mut study = Study::from_toml(&template(&"noiseless".parse().unwrap())).unwrap();
    let spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: -std::f64::consts::FRAC_PI_4 };
    study.environments[0].scene = Scene::Spring(spring);
    study
}

/// The twin's plant with that motor, and a hand.
fn device() -> DrivenParameters {
    let tissue = Tissue {
        stiffness_n_per_m: table3::FINGER_STIFFNESS_N_PER_M,
        damping_ns_per_m: table3::FINGER_DAMPING_NS_PER_M,
    };
    let hand = Hand { mass_kg: 0.08, stiffness_n_per_m: 290.0, damping_ns_per_m: 3.0, tissue };
    DrivenParameters {
        motor_lag_s: Some(MOTOR_LAG_S),
        ..TwinParameters::default().plant(Some(hand))
    }
}

/// Where the hand means to be: forward and back, a little otherwise in each repeat.
fn aim(repeat: u32, t_s: f64) -> Aim {
    let (reach_m, rate) = (0.07 + 0.003 * f64::from(repeat), 2.2 + 0.1 * f64::from(repeat));
    let phase = rate * (t_s - 0.3).clamp(0.0, std::f64::consts::TAU / rate);
    Aim {
        position_m: -0.036 + reach_m * (1.0 - libm::cos(phase)) / 2.0,
        velocity_m_s: reach_m * rate * libm::sin(phase) / 2.0,
    }
}

/// One trial as sensors without noise record it.
fn trial(study: &Study, mode: &str, repeat: u32) -> Trial {
    let (environment, calibration) = (&study.environments[0], Calibration::thesis());
    let mut controller = Controller::new(
        &study.control,
        environment,
        study.mode(&mode.parse().unwrap()).unwrap(),
        &calibration,
    );
    let mut plant = Driven::new(device()).unwrap();
    let mut columns = vec![Vec::new(); 6];
    for i in 0..(3.2 * RATE_HZ) as u32 {
        let [t_s, end_s] = [i, i + 1].map(|i| f64::from(i) / RATE_HZ);
        let state = plant.state();
        let (angle, velocity, force) = (state.theta_rad, state.theta_dot_rad_s, state.contact_n);
        let (voltages, _) = controller.step(angle, velocity, force);
        let sample = [t_s, angle, velocity, force, voltages.motor_v, voltages.brake_v];
        columns.iter_mut().zip(sample).for_each(|(column, value)| column.push(value));
        let command = Command {
            motor_n: calibration.motor.force_n(voltages.motor_v),
            brake_n: calibration.brake.force_n(voltages.brake_v),
        };
        plant.advance(end_s - t_s, command, [aim(repeat, t_s), aim(repeat, end_s)]).unwrap();
    }
    let signals = [
        Signal::Time,
        Signal::Theta,
        Signal::ThetaDot,
        Signal::ForceEx,
        Signal::VoltageMotor,
        Signal::VoltageBrake,
    ];
    let mut samples = Samples::default();
    signals.into_iter().zip(columns).for_each(|(signal, column)| samples.set(signal, column));
    let meta =
        TrialMeta { environment: environment.id.clone(), ..zwidth_testing::meta(repeat, mode) };
    Trial { meta, file: TrialFile::new(), samples }
}

#[test]
fn a_large_study_is_fitted_by_the_trials_of_participants_spread_over_its_list() {
    let people: Vec<ParticipantId> = (0..10).map(|i| format!("P{i:02}").parse().unwrap()).collect();
    let trials: Vec<_> = people.iter().flat_map(|who| [(who, 300), (who, 100)]).collect();
    let names = |most| -> Vec<&str> {
        spread_within(&trials, most).into_iter().map(ParticipantId::as_str).collect()
    };
    assert_eq!(names(4000).len(), 10);
    assert_eq!(names(3999).len(), 9);
    assert_eq!(names(1300), ["P00", "P03", "P06"]);
    assert_eq!(names(1), ["P00"], "somebody's");
    assert!(spread_within(&[], 1).is_empty());
}

#[test]
fn without_noise_every_parameter_comes_back_to_a_millionth() {
    let (study, calibration) = (study(), Calibration::thesis());
    let repeats =
        ["active", "passive", "hybrid"].iter().flat_map(|mode| [1, 2, 3].map(|r| (*mode, r)));
    let trials: Vec<Trial> = repeats.map(|(mode, repeat)| trial(&study, mode, repeat)).collect();
    let balance = |trial: &Trial| {
        let mode = study.mode(&trial.meta.mode).unwrap();
        let how = Rendering::of(&study, &study.environments[0], mode, Some(calibration.clone()));
        Balance::new(trial, &how).unwrap()
    };
    let balances: Vec<Balance> = trials.iter().map(balance).collect();
    let recordings: Vec<Recording> = trials
        .iter()
        .zip(&balances)
        .map(|(trial, balance)| Recording { meta: &trial.meta, observed: balance.measured_ns() })
        .collect();
    let task = Task { parameters: &PLANT, starts: &STARTS[..1], level: 0.95 };
    let explain = |i: usize, points: &[[f64; P]]| {
        let plants: Vec<Parameters> = points.iter().map(plant).collect();
        balances[i].needed_ns(&plants).into_iter().map(Some).collect()
    };
    let found = zwidth_identify::identify(&recordings, &task, explain, |_, _| None).unwrap();
    let truth = device();
    let (friction, [on, off]) = (truth.friction.unwrap(), truth.brake_lag_on_off_s.unwrap());
    let expect = [
        truth.inertia_kg_m2 / (truth.lever_m * truth.lever_m),
        friction.viscous_ns_per_rad + truth.back_emf_ns_per_rad.unwrap(),
        friction.kinetic_n,
        MOTOR_LAG_S,
        on,
        off,
    ];
    for (estimate, expect) in found.estimates.iter().zip(expect) {
        let (name, fitted) = (estimate.parameter.name.as_str(), estimate.fitted);
        assert!((fitted / expect - 1.0).abs() < 1e-6, "{name}: {fitted} instead of {expect}");
        assert_eq!(estimate.verdict, Identifiability::Identifiable, "{name}");
    }
    let tables = [
        zwidth_identify::estimates_table(&found).unwrap(),
        Table::of_rows(&zwidth_identify::covariances(&found)).unwrap(),
    ];
    let plant = plant_with_spread(&tables[0], &tables[1]).unwrap().unwrap();
    let known = [plant.mass_kg, plant.damping_ns_per_rad, plant.friction_n];
    assert!(known.iter().zip(expect).all(|(found, e)| (found / e - 1.0).abs() < 1e-6), "{plant:?}");
    for (j, estimate) in found.estimates.iter().take(3).enumerate() {
        let std_error = estimate.std_error.unwrap();
        assert!((plant.covariance[j][j].sqrt() / std_error - 1.0).abs() < 1e-9, "{plant:?}");
        let same = |k: usize| plant.covariance[j][k].to_bits() == plant.covariance[k][j].to_bits();
        assert!((0..3).all(same), "{plant:?}");
    }
    actuators_of_the_twin(&study, &trials, &plant);
}

/// With the plant as found, motor alone: the actuators differ by no more than the controller is
/// late, and the user by a multiple; hybrid: by what Appendix B says, at the reversal. What is left
/// there, some 0.04 N, are the brake's lags: going in its force is K τ θ̇ behind, going back it has
/// not quite let go.
fn actuators_of_the_twin(study: &Study, trials: &[Trial], plant: &Plant) {
    for trial in trials {
        let mode = study.mode(&trial.meta.mode).unwrap();
        let parameters = zwidth_metrics::Parameters::of(study, &study.environments[0], mode);
        let found = zwidth_metrics::plant_metrics(trial, &parameters, Some(plant)).unwrap();
        let user = zwidth_metrics::trial_metrics(trial, &parameters).unwrap();
        let (found, mode) = (found.discrepancy, trial.meta.mode.as_str());
        match mode {
            "active" => {
                let (mean, felt) = (found.mean_n.unwrap(), user.discrepancy.mean_n.unwrap());
                assert!(mean.abs() < 0.05 && felt > 0.4, "{mean} N, the user {felt} N");
            }
            "hybrid" => {
                let theta = user.movement.theta_max_rad.unwrap();
                let expect = 4.0 * (theta + std::f64::consts::FRAC_PI_4) - 2.08;
                let [low, high] = [found.step_ci_low_n, found.step_ci_high_n].map(Option::unwrap);
                assert!(low <= expect && expect <= high, "{low} to {high} N: {expect} N");
                let step = found.step_n.unwrap();
                assert!((step - expect).abs() < 0.1, "{step} N instead of {expect} N");
                assert!(high - low < 0.5 * expect, "{low} to {high} N says something");
            }
            _ => assert_eq!(found.mean_n, None, "a brake has no way back"),
        }
    }
}
