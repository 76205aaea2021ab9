//! Trials of a loop whose truth is known: made by the driven plant, which shares no code with the
//! model behind the answer.

use super::judge::{Origin, Oscillation, SwingAnswer, oscillation};
use super::{RecordedSwings, trial_oscillation};
use crate::WhyNot;
use crate::scene::{Parameters, Rendering};
use crate::testing::{calibration, study, trial};
use core::f64::consts::TAU;
use std::collections::VecDeque;
use zwidth_device::{Controller, Velocity};
use zwidth_dynamics::{Aim, Command, Driven, DrivenParameters, RunVerdict};
use zwidth_results::TrialOscillation;
use zwidth_store::{Samples, Signal, Trial};
use zwidth_study::{Scene, Spring, Study, Voltages};
use zwidth_tables::Table;

/// The simulated device's plant at the lever's end, with friction.
const PLANT: Parameters = Parameters {
    mass_kg: 0.0972,
    damping_ns_per_rad: 0.117,
    friction_n: 0.15,
    motor_lag_s: 53e-6,
    brake_on_s: 0.015,
    brake_off_s: 0.010,
};
/// The thesis' period, s, and one count of the prototype's angle, rad.
const PERIOD_S: f64 = 8.3e-3;
const COUNT_RAD: f64 = TAU / 4096.0 / (75.0 / 11.0);
const REST_RAD: f64 = -0.3;

/// A spring of so many N/rad by the motor.
fn stiff(stiffness_n_per_rad: f64) -> Study {
    let mut study = study();
    study.environments[0].scene = Scene::Spring(Spring { stiffness_n_per_rad, rest_rad: REST_RAD });
    study
}

fn rendering(study: &Study, mode: &str) -> Rendering {
    let mode = study.mode(&mode.parse().unwrap()).unwrap();
    Rendering::of(study, &study.environments[0], mode, Some(calibration()))
}

/// A push that rises within 30 ms to so many N, and stays: friction would hold a lever that is
/// pushed slowly.
fn push(t: f64, force_n: f64) -> f64 {
    force_n * 0.5 * (1.0 - libm::cos(TAU / 0.06 * (t - 0.5).clamp(0.0, 0.03)))
}

/// Four seconds of a person's force on the device, as its loop records them; what the controller
/// asks for acts so many ticks late.
fn recorded(study: &Study, mode: &str, delay: usize, user: &dyn Fn(f64) -> f64) -> Trial {
    let rendering = rendering(study, mode);
    let (environment, of_mode) = (&study.environments[0], mode.parse().unwrap());
    let of_mode = study.mode(&of_mode).unwrap();
    let mut controller = Controller::new(&study.control, environment, of_mode, &calibration());
    let mut velocity = Velocity::new(study.control.velocity).unwrap();
    let lever_m = rendering.lever_m.unwrap();
    let mut plant = Driven::new(DrivenParameters {
        inertia_kg_m2: PLANT.mass_kg * lever_m * lever_m,
        lever_m,
        stops_rad: rendering.stops_rad,
        friction: Some(PLANT.friction()),
        back_emf_ns_per_rad: None,
        motor_lag_s: None,
        brake_lag_on_off_s: PLANT.brake_lag_on_off_s(),
        hand: None,
    })
    .unwrap();
    plant.place(REST_RAD, 0.0).unwrap();
    let mut later: VecDeque<Voltages> = std::iter::repeat_n(Voltages::OFF, delay).collect();
    let mut columns = vec![Vec::new(); 6];
    for k in 0..480_u32 {
        // A host's ticks are a little late, now and then.
        let late = |k: u32| 1e-4 * f64::from(k * 7 % 3);
        let [t, next] = [k, k + 1].map(|k| f64::from(k) * PERIOD_S + late(k));
        let theta = (plant.state().theta_rad / COUNT_RAD).round() * COUNT_RAD;
        let rate = velocity.step(t, theta);
        let force = user(t);
        let (asked, _) = controller.step(theta, rate, force);
        later.push_back(asked);
        let voltages = later.pop_front().unwrap();
        let row = [t, theta, rate, force, voltages.motor_v, voltages.brake_v];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        let parts = 16;
        let part_s = (next - t) / f64::from(parts);
        for i in 0..parts {
            let user_n = user(t + (f64::from(i) + 0.5) * part_s);
            let motor_n = calibration().motor.force_n(voltages.motor_v) + user_n;
            let brake_n = calibration().brake.force_n(voltages.brake_v).abs();
            plant.advance(part_s, Command { motor_n, brake_n }, [Aim::default(); 2]).unwrap();
        }
    }
    let mut samples = Samples::default();
    let signals = [
        Signal::Time,
        Signal::Theta,
        Signal::ThetaDot,
        Signal::ForceEx,
        Signal::VoltageMotor,
        Signal::VoltageBrake,
    ];
    signals.into_iter().zip(columns).for_each(|(signal, values)| samples.set(signal, values));
    trial(mode, samples)
}

fn asked(study: &Study, mode: &str, trial: &Trial) -> Oscillation {
    oscillation(trial, study, &rendering(study, mode), &PLANT).unwrap()
}

/// 60 N/rad at 45 mm are 1333 N/m: twice the lifted map's limit.
#[test]
fn a_wall_stiffer_than_the_limit_swings_by_itself() {
    let study = stiff(60.0);
    let trial = recorded(&study, "active", 0, &|t| push(t, 2.5));
    let found = asked(&study, "active", &trial);
    assert_eq!(found.origin, Origin::Loop, "{:?}", Oscillation { courses: Vec::new(), ..found });
    let (recorded, alone) = (found.recorded.unwrap(), found.alone.unwrap());
    assert!((alone.frequency_hz / recorded.frequency_hz - 1.0).abs() < 0.05, "{alone:?}");
    assert!((alone.amplitude_rad / recorded.amplitude_rad - 1.0).abs() < 0.1, "{alone:?}");
    for stepped in found.stepped_rad {
        assert!((stepped / alone.amplitude_rad - 1.0).abs() < 0.1, "{:?}", found.stepped_rad);
    }
    assert!(!matches!(found.nature, Some(RunVerdict::Smooth) | None));
}

#[test]
fn a_tremor_s_force_is_the_user_s() {
    let study = stiff(4.0);
    let tremor = |t: f64| push(t, 1.0) + 0.5 * libm::sin(TAU * 9.0 * t) * push(t, 1.0);
    let trial = recorded(&study, "active", 0, &tremor);
    let found = asked(&study, "active", &trial);
    assert_eq!(found.origin, Origin::User, "{:?}", Oscillation { courses: Vec::new(), ..found });
    assert!((found.recorded.unwrap().frequency_hz - 9.0).abs() < 0.5);
    assert!(found.power_factor.unwrap() > 0.1 && found.alone.is_none());
}

#[test]
fn a_calm_trial_and_one_that_trembles_below_a_count_have_none() {
    let study = stiff(4.0);
    for size in [0.0, 0.0005] {
        for mode in ["active", "hybrid", "passive"] {
            let user = |t: f64| push(t, 1.0) + size * libm::sin(TAU * 9.0 * t);
            let found = asked(&study, mode, &recorded(&study, mode, 0, &user));
            assert_eq!((found.origin, found.recorded), (Origin::None, None), "{mode}");
            let counts = found.bound_rad / COUNT_RAD;
            assert!((1.0 - 1e-6..3.0).contains(&counts), "{mode}: {counts} counts");
        }
    }
}

/// 400 N/m bears no period of delay, of which the model knows nothing.
#[test]
fn what_the_model_lacks_cannot_be_told() {
    let study = stiff(18.0);
    let trial = recorded(&study, "active", 1, &|t| push(t, 2.0));
    let found = asked(&study, "active", &trial);
    assert!(found.recorded.is_some_and(|swings| swings.swings > 10), "{:?}", found.recorded);
    assert_eq!(found.origin, Origin::NotReproduced);
    assert_eq!(found.origin.answer(), SwingAnswer::CannotTell);
}

#[test]
fn two_ticks_in_a_cycle_may_be_a_faster_swing_and_without_a_calibration_there_is_no_model() {
    let study = stiff(60.0);
    let mut trial = recorded(&study, "active", 0, &|t| push(t, 2.5));
    let rendering = Rendering { calibration: None, ..rendering(&study, "active") };
    let found = oscillation(&trial, &study, &rendering, &PLANT).unwrap();
    assert_eq!(found.origin, Origin::NoModel(WhyNot::NoCalibration));
    let theta = trial.samples.get(Signal::Theta).unwrap();
    let flip = |i: usize| {
        if i > 100 && i.is_multiple_of(2) { 0.01 } else { COUNT_RAD * f64::from(u8::from(i > 9)) }
    };
    let flips = (0..theta.len()).map(flip).collect();
    trial.samples.set(Signal::Theta, flips);
    assert_eq!(asked(&study, "active", &trial).origin, Origin::TooFewTicks);
}

#[test]
fn a_table_has_a_row_a_trial_and_nothing_that_is_no_number() {
    let study = stiff(60.0);
    let mut rows = Vec::new();
    for force_n in [2.5, 0.0] {
        let trial = recorded(&study, "active", 0, &|t| push(t, force_n));
        rows.push(trial_oscillation(&trial.meta, &asked(&study, "active", &trial)));
    }
    let table = Table::of_rows(&rows).unwrap();
    assert_eq!(table.to_rows::<TrialOscillation>().unwrap(), rows);
    assert_eq!([&rows[0].answer, &rows[1].answer], ["real", "no oscillation"]);
    assert_eq!(rows[1].stepped_amplitude_rad, None);
}

/// The table of answers, cell by cell.
#[test]
fn what_the_force_feeds_and_what_swings_alone_give_the_answer() {
    let swings = |amplitude_rad, frequency_hz| RecordedSwings {
        from_s: 0.0,
        to_s: 1.0,
        swings: 20,
        amplitude_rad,
        frequency_hz,
    };
    let recorded = swings(0.01, 10.0);
    let case = |alone, with_force, cos_phi, quarter| {
        let all = Oscillation {
            origin: Origin::None,
            bound_rad: 1e-4,
            recorded: Some(recorded),
            with_force,
            alone,
            stepped_rad: [0.01, 0.01, quarter],
            nature: Some(RunVerdict::LimitCycle),
            power_factor: Some(cos_phi),
            courses: Vec::new(),
        };
        super::judge::origin(&all, &recorded)
    };
    let is = Some(swings(0.008, 11.0));
    assert_eq!(case(is, None, -0.5, 0.008), Origin::Loop);
    assert_eq!(case(is, is, 0.05, 0.008), Origin::Loop);
    assert_eq!(case(is, is, 0.5, 0.008), Origin::BothCould);
    assert_eq!(case(is, is, -0.5, 0.001), Origin::NotKnown);
    assert_eq!(case(None, is, 0.5, 0.0), Origin::User);
    assert_eq!(case(None, is, -0.5, 0.0), Origin::NeitherCould);
    assert_eq!(case(None, None, 0.5, 0.0), Origin::NotReproduced);
    let short = RecordedSwings { swings: 9, ..recorded };
    for unlike in [swings(0.003, 10.0), swings(0.01, 16.0), swings(0.01, 6.0), short] {
        assert_eq!(case(Some(unlike), None, -0.5, 0.01), Origin::NotReproduced);
    }
}
