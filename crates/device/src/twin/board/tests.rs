//! The board: what it shows, when it acts, and that a seed repeats.

use super::*;
use crate::trial::tests::environment;
use zwidth_study::{AnswerScale, Scene};

fn twin() -> Twin {
    Twin::new(TwinParameters::default(), Person::typical(1), 1).unwrap()
}

fn begin(twin: &mut Twin, now_s: f64, trial: u32) {
    twin.begin(now_s, &Cue { trial, environment: &environment(Scene::Free), limit_s: 4.0 });
}

fn counts(reading: &Reading) -> i32 {
    let Angle::Counts(counts) = reading.angle else { panic!("a twin counts") };
    i32::from(counts)
}

#[test]
fn it_says_what_it_is() {
    let capabilities = twin().capabilities().clone();
    assert_eq!(capabilities.watchdog_s, Some(0.05));
    assert_eq!((capabilities.counts_per_turn, capabilities.force_rate_hz), (Some(4096), 80.0));
    assert_eq!((capabilities.motor_max_v, capabilities.brake_max_v), (16.0, 8.0));
    assert_eq!(capabilities.source, Source::Twin);
}

#[test]
fn voltages_act_and_the_watchdog_takes_them_away() {
    let mut twin = twin();
    twin.home(100.0).unwrap();
    twin.write(100.0, Voltages { motor_v: -8.0, brake_v: 8.0 }).unwrap();
    twin.read(100.049).unwrap();
    let held = twin.truth();
    assert!((held.motor_n + 2.08).abs() < 1e-9 && held.brake_n > 12.0, "{held:?}");
    twin.read(100.0505).unwrap();
    assert!(twin.truth().motor_n.abs() < 1e-3);
    twin.read(100.2).unwrap();
    assert!(twin.truth().motor_n.abs() < 1e-9 && twin.truth().brake_n < 1e-3);
}

/// At the stop nothing moves: I = U / R after some τ = 53 µs. Moving, the winding's voltage is
/// taken off.
#[test]
fn the_winding_s_current_is_that_of_its_voltage_less_that_of_its_motion() {
    let mut twin = twin();
    twin.home(100.0).unwrap();
    twin.write(100.0, Voltages { motor_v: -8.0, brake_v: 0.0 }).unwrap();
    let reading = twin.read(100.01).unwrap();
    assert_eq!(twin.capabilities().channels[1].id.as_str(), "current_motor_a");
    assert!((reading.extra.values()[1] + 8.0 / 30.4).abs() < 1e-9, "{reading:?}");
    let parameters = TwinParameters::default();
    let emf_v = 75.0 / 11.0 * 0.0536 * 2.0;
    let of = |motor_n| parameters.motor_current_a(motor_n, 2.0);
    assert!((of(2.08) - (8.0 - emf_v) / 30.4).abs() < 1e-12);
    assert!((of(-2.08) + (8.0 + emf_v) / 30.4).abs() < 1e-12);
}

#[test]
fn homing_puts_the_lever_at_its_stop_with_everything_off() {
    let mut twin = twin();
    let first = counts(&twin.home(3.0).unwrap());
    twin.write(3.0, Voltages { motor_v: 16.0, brake_v: 0.0 }).unwrap();
    twin.read(3.04).unwrap();
    assert!(twin.truth().theta_rad > STOPS_RAD[0]);
    assert_eq!(counts(&twin.home(3.04).unwrap()), first);
    assert_eq!(twin.truth().motor_n.to_bits(), 0);
}

#[test]
fn a_force_value_is_held_for_12_5_ms_and_says_its_age() {
    let mut twin = twin();
    twin.home(0.0).unwrap();
    begin(&mut twin, 0.0, 1);
    let readings: Vec<Reading> =
        (1..=3000).map(|i| twin.read(f64::from(i) * 1e-3).unwrap()).collect();
    let changes =
        readings.windows(2).filter(|pair| pair[0].force_n.to_bits() != pair[1].force_n.to_bits());
    assert_eq!(changes.count(), 240); // 3 s at 80/s
    assert!(readings.iter().all(|reading| (0.0..0.0126).contains(&reading.force_age_s.unwrap())));
}

#[test]
fn the_boards_clock_drifts_by_less_than_50_ppm() {
    let mut twin = twin();
    let start_s = twin.home(0.0).unwrap().t_device_s.unwrap();
    let end_s = twin.read(100.0).unwrap().t_device_s.unwrap();
    let ppm = 1e6 * ((end_s - start_s) / 100.0 - 1.0);
    assert!(ppm.abs() > 0.1 && ppm.abs() < 50.0, "{ppm}");
}

#[test]
fn a_trial_depends_on_its_number_and_not_on_those_before() {
    let run = |twin: &mut Twin, trial| {
        twin.home(0.0).unwrap();
        begin(twin, 0.0, trial);
        let readings: Vec<Reading> =
            (1..500).map(|i| twin.read(f64::from(i) * 8.3e-3).unwrap()).collect();
        (readings, twin.answer(&AnswerScale::FivePoint))
    };
    let (mut fresh, mut used) = (twin(), twin());
    run(&mut used, 1);
    run(&mut used, 2);
    assert_eq!(run(&mut used, 3), run(&mut fresh, 3));
    assert_ne!(run(&mut used, 4), run(&mut fresh, 5));
}

#[test]
fn after_a_trial_the_lever_is_carried_back_slowly_enough_to_count_its_turns() {
    let mut twin = twin();
    let home = counts(&twin.home(0.0).unwrap());
    begin(&mut twin, 0.0, 1);
    let (mut raw, mut total, mut highest, mut longest) = (home, 0, 0, 0);
    for i in 1..8000 {
        let now = counts(&twin.read(f64::from(i) * 1e-3).unwrap());
        let step = (now - raw + 2048).rem_euclid(4096) - 2048;
        (raw, total, longest) = (now, total + step, longest.max(step.abs()));
        highest = highest.max(total);
    }
    assert!(highest > 4096 && longest < 60, "{highest} {longest}");
    assert_eq!(total, 0);
}

#[test]
fn a_tick_allocates_nothing() {
    let mut twin = twin();
    twin.home(0.0).unwrap();
    begin(&mut twin, 0.0, 1);
    let used = allocation_counter::measure(|| {
        for i in 1..3000 {
            let now_s = f64::from(i) * 1e-3;
            twin.read(now_s).unwrap();
            twin.write(now_s, Voltages { motor_v: -2.0, brake_v: 1.5 }).unwrap();
        }
    });
    assert_eq!(used.count_total, 0);
}

#[test]
fn a_parameter_that_makes_no_sense_is_named() {
    let parameters = TwinParameters { lever_kg_m2: f64::NAN, ..TwinParameters::default() };
    let error = Twin::new(parameters, Person::typical(1), 1).unwrap_err().to_string();
    assert!(error.contains("lever_kg_m2 is NaN"), "{error}");
}
