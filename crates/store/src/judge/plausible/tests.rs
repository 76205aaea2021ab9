//! Recordings spoilt on purpose.

use super::{Asked, implausible};
use crate::{Samples, Signal, StoreError};
use core::f64::consts::TAU;
use std::path::Path;
use zwidth_study::{Coordinate, Scene, Spring};

/// A spring of 4 N/rad at rest at −45°, on a lever of 75 mm.
fn asked() -> Asked {
    let spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: -core::f64::consts::FRAC_PI_4 };
    Asked {
        theta_min_rad: None,
        theta_max_rad: None,
        trial_limit_s: 60.0,
        onset_rad_s: 10_f64.to_radians(),
        coordinate: Coordinate::Rotational,
        lever_m: Some(0.075),
        scene: Scene::Spring(spring),
    }
}

/// There and back in 2 s over 77° on that spring, 500 samples per second, with noise of the force.
fn recording() -> Samples {
    let t: Vec<f64> = (0..1000u32).map(|i| f64::from(i) * 2e-3).collect();
    let (size, omega) = (77_f64.to_radians(), core::f64::consts::PI);
    let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 20) * 1e-5;
    let theta: Vec<f64> = t
        .iter()
        .map(|t| -core::f64::consts::FRAC_PI_4 + size * (1.0 - libm::cos(omega * t)) / 2.0)
        .collect();
    let mut samples = Samples::default();
    let force = (0..).zip(&theta);
    let force = force.map(|(i, x)| 4.0 * (x + core::f64::consts::FRAC_PI_4) + noise(i));
    samples.set(Signal::ForceEx, force.collect());
    let velocity = t.iter().map(|t| size * omega * libm::sin(omega * t) / 2.0).collect();
    samples.set(Signal::ThetaDot, velocity);
    samples.set(Signal::Theta, theta);
    samples.set(Signal::Time, t);
    samples
}

/// The recording with one signal changed, sample by sample.
fn changed(signal: Signal, change: impl Fn(usize, f64) -> f64) -> Samples {
    let mut samples = recording();
    let values = samples.get(signal).unwrap().iter().enumerate();
    let values = values.map(|(i, v)| change(i, *v)).collect();
    samples.set(signal, values);
    samples
}

/// What is said of samples.
fn findings(samples: &Samples) -> Vec<StoreError> {
    implausible(&asked(), Path::new("a"), samples)
}

/// What is said of the recording with one signal changed, sample by sample: columns and words.
#[track_caller]
fn check(signal: Signal, change: impl Fn(usize, f64) -> f64, expect: &[(Signal, &str)]) {
    let found = findings(&changed(signal, change));
    assert_eq!(found.len(), expect.len(), "{found:#?}");
    for (found, (signal, words)) in found.iter().zip(expect) {
        assert_eq!(found.column.as_deref(), Some(signal.name()), "{found}");
        assert!(found.to_string().contains(words), "{found} without '{words}'");
    }
}

/// The same where the changed signal alone is told.
#[track_caller]
fn check_own(signal: Signal, change: impl Fn(usize, f64) -> f64, words: &str) {
    check(signal, change, &[(signal, words)]);
}

#[test]
fn a_recording_that_fits_itself_has_no_finding() {
    check(Signal::Theta, |_, v| v, &[]);
}

#[test]
fn a_clock_that_jumps_is_found_where_it_does() {
    let found = findings(&changed(Signal::Time, |i, t| if i >= 700 { t + 5.0 } else { t }));
    assert_eq!(found[0].row, Some(701));
    assert!(found[0].what.starts_with("the clock jumps by 5.002 s"), "{}", found[0]);
}

#[test]
fn a_hole_of_a_few_hundredths_of_a_second_is_found() {
    let later = |i, t| if i >= 700 { t + 0.078 } else { t };
    let jumps = (Signal::Time, "the clock jumps by 0.079 s");
    check_at_1_khz(later, &[jumps]);
    check_at_1_khz(|i, t| if i >= 700 { t + 0.03 } else { t }, &[]);
}

/// As [`check`] of the time, with a sample every millisecond.
#[track_caller]
fn check_at_1_khz(change: impl Fn(usize, f64) -> f64, expect: &[(Signal, &str)]) {
    let mut samples = changed(Signal::ThetaDot, |_, v| 2.0 * v);
    samples.set(Signal::Time, (0..1000).map(|i| change(i, 1e-3 * i as f64)).collect());
    let found = findings(&samples);
    let found: Vec<_> = found.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), expect.len(), "{found:#?}");
    assert!(found.iter().zip(expect).all(|(f, (_, words))| f.contains(words)), "{found:#?}");
}

/// 12°/s of noise before the lever moves, above the onset's 10°/s, in every third sample, forwards
/// and backwards.
#[test]
fn noise_above_the_onset_before_the_movement_is_found() {
    let noisy = |i: usize, v: f64| match i {
        0..10 if i.is_multiple_of(3) => 0.21 * if i.is_multiple_of(2) { 1.0 } else { -1.0 },
        _ => v,
    };
    check_own(Signal::ThetaDot, noisy, "passes onset_deg_s 4 times");
    let one_way = |i: usize, v: f64| if i < 10 { noisy(i, v).abs() } else { v };
    check(Signal::ThetaDot, one_way, &[]);
}

#[test]
fn milliseconds_taken_for_seconds_and_the_other_way_round_are_named() {
    for (factor, words, times) in [
        (1e3, "milliseconds taken for seconds", "1000 times"),
        (1e-3, "seconds taken for milliseconds", "0.001 times"),
    ] {
        let both = [(Signal::Time, words), (Signal::ThetaDot, times)];
        check(Signal::Time, |_, t| factor * t, &both);
    }
}

#[test]
fn two_clocks_that_differ_are_named() {
    let mut samples = recording();
    let device = samples.get(Signal::Time).unwrap().iter().map(|t| 1e3 * t).collect();
    samples.set(Signal::DeviceTime, device);
    let found = findings(&samples);
    assert_eq!(found.len(), 1, "{found:#?}");
    assert!(found[0].what.contains("another unit"), "{}", found[0]);
}

#[test]
fn an_angle_of_a_thousand_degrees_is_none() {
    check(
        Signal::Theta,
        |_, v| v.to_degrees(),
        &[
            (Signal::Theta, "degrees taken for radians"),
            (Signal::ThetaDot, "0.0175 times"),
            (Signal::ForceEx, "angle"),
        ],
    );
}

#[test]
fn an_angle_that_starts_over_at_a_full_turn_is_found_where_it_does() {
    let samples = changed(Signal::Theta, |_, v| if v < 0.0 { v + TAU } else { v });
    let found = findings(&samples);
    let words = "goes from 360° to 0° within a sample";
    assert!(found[0].what.contains(words) && found[0].row.is_some(), "{found:#?}");
    let linear = Asked { coordinate: Coordinate::Linear { lever_m: 1e-3 }, ..asked() };
    let found = implausible(&linear, Path::new("a"), &samples);
    assert!(found.iter().all(|f| !f.what.contains("full turn")), "{found:#?}");
}

#[test]
fn a_force_that_no_hand_has_is_found() {
    let found = findings(&changed(Signal::ForceEx, |i, v| if i == 20 { -9999.0 } else { v }));
    assert!(found[0].what.starts_with("-9.999e3 N is more than a person weighs"), "{found:#?}");
    assert_eq!(found[0].row, Some(21));
}

#[test]
fn a_signal_that_stops_is_found_and_no_force_in_free_motion_is_none() {
    check_own(Signal::ForceEx, |_, _| 0.0, "it is 0 throughout, while theta_rad");
    let held = |i: usize, v: f64| if i >= 300 { 3.25 } else { v };
    check_own(Signal::ForceEx, held, "it holds 3.25 for 1.40 s");
    let none = changed(Signal::ForceEx, |_, _| 0.0);
    let free = Asked { scene: Scene::Free, ..asked() };
    assert!(implausible(&free, Path::new("a"), &none).is_empty());
}

/// Samples of 2 ms: few of them are looked at before all are.
#[test]
fn a_force_that_holds_for_little_more_than_a_second_is_found_wherever_it_does() {
    let is_found = |held: std::ops::Range<usize>| {
        let samples = changed(Signal::ForceEx, |i, v| if held.contains(&i) { 3.25 } else { v });
        let found = findings(&samples);
        found.iter().any(|f| f.what.starts_with("it holds 3.25 for 1.01 s"))
    };
    for from in (150..350).step_by(13) {
        assert!(is_found(from..from + 506), "{from}");
        assert!(!is_found(from..from + 500), "{from}");
    }
}

#[test]
fn a_force_at_the_end_of_its_sensors_range_is_found() {
    check_own(Signal::ForceEx, |_, v| v.min(4.5), "it stands at its largest value");
    let held = |i: usize, _| 4.0 * f64::from(u32::try_from(i / 60).unwrap() % 5 + 1);
    let found = findings(&changed(Signal::ForceEx, held));
    assert!(found.iter().all(|f| !f.what.contains("largest")), "a slow sensor: {found:#?}");
}

#[test]
fn a_velocity_in_another_unit_or_with_another_sign_is_named() {
    let degrees = "57.3 times the angle's derivative: deg/s taken for rad/s";
    check_own(Signal::ThetaDot, |_, v| v.to_degrees(), degrees);
    let turned = "1 times the angle's derivative, with the opposite sign";
    check_own(Signal::ThetaDot, |_, v| -v, turned);
    check_own(Signal::ThetaDot, |_, v| v * 60.0 / TAU, "rpm taken for rad/s");
    check(Signal::ThetaDot, |_, v| v * 1.5, &[]);
}

#[test]
fn a_force_against_the_motion_has_the_wrong_sign() {
    check_own(Signal::ForceEx, |_, v| -v, "set sign = -1");
}

/// A device that swings by itself drives the hand: the sign of its work says nothing of the sensor.
#[test]
fn of_a_lever_that_swings_fast_the_sign_of_the_force_is_not_asked() {
    let mut samples = recording();
    let t = samples.get(Signal::Time).unwrap().to_vec();
    let growing = |t: &f64| 0.3 * t * libm::sin(20.0 * TAU * t);
    let theta: Vec<f64> = t.iter().map(growing).collect();
    let force = theta.windows(2).map(|x| -30.0 * (x[1] - x[0])).chain([0.0]).collect();
    let velocity = theta.windows(2).map(|x| (x[1] - x[0]) / 2e-3).chain([0.0]).collect();
    samples.set(Signal::ForceEx, force);
    samples.set(Signal::ThetaDot, velocity);
    samples.set(Signal::Theta, theta);
    let found = findings(&samples);
    assert!(found.iter().all(|f| !f.to_string().contains("sign = -1")), "{found:#?}");
}

#[test]
fn a_torque_taken_for_a_force_is_a_lever_too_small() {
    check_own(Signal::ForceEx, |_, v| 0.075 * v, "a torque in N·m taken");
    check_own(Signal::ForceEx, |_, v| v / 0.075, "a force in N taken for a torque");
    check(
        Signal::ForceEx,
        |_, v| 1e3 * v,
        &[
            (Signal::ForceEx, "a person weighs: mN taken for N"),
            (Signal::ForceEx, "mN taken for N"),
        ],
    );
    check(Signal::ForceEx, |_, v| 0.5 * v, &[]);
}

#[test]
fn a_value_that_stands_alone_is_found_and_a_blow_is_none() {
    let lost = |i: usize, v: f64| if [300, 302, 640].contains(&i) { -1.73 } else { v };
    check_own(Signal::Theta, lost, "where its neighbours are");
    let lost = |i: usize, v: f64| if i == 300 { -99.0 } else { v };
    check_own(Signal::ForceEx, lost, "it is -99.0000 where its neighbours are");
    let lost = |i: usize, v: f64| if (900..940).contains(&i) { -999.0 } else { v };
    check_own(Signal::ForceEx, lost, "-999.0000 in 40 samples, far from all others");
    // Six newtons more for two samples, as where a lever meets a wall.
    let blow = |i: usize, v: f64| if [500, 501].contains(&i) { v + 6.0 } else { v };
    check(Signal::ForceEx, blow, &[]);
}

#[test]
fn a_movement_whose_beginning_is_missing_is_found() {
    let part = |rows: std::ops::Range<usize>| {
        let mut part = Samples::default();
        for signal in [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::ForceEx] {
            part.set(signal, recording().get(signal).unwrap()[rows.clone()].to_vec());
        }
        findings(&part)
    };
    let found: Vec<String> = part(250..1000).iter().map(ToString::to_string).collect();
    assert!(found.len() == 1 && found[0].contains("100 % of its largest speed"), "{found:?}");
    // Nor is its end: it may be a hand that never rests.
    assert!(part(250..750).is_empty());
}

#[test]
fn a_recording_shorter_than_a_movement_is_found() {
    let found = findings(&changed(Signal::Time, |_, t| t / 50.0));
    assert!(found[0].what.contains("the whole recording lasts 0.0400 s"), "{}", found[0]);
}

#[test]
fn a_force_in_coarse_steps_is_at_no_end_and_neither_is_a_load_that_is_held() {
    for step in [0.02, 0.05, 0.1, 0.2] {
        check(Signal::ForceEx, |_, v| (v / step).round() * step, &[]);
    }
    let mut held = Samples::default();
    held.set(Signal::Time, (0..400).map(|i| 0.01 * f64::from(i)).collect());
    held.set(Signal::ForceEx, (0..400).map(|i| 0.1 * f64::from(i.min(20))).collect());
    assert!(findings(&held).is_empty());
    let plateau = super::plateau(held.get(Signal::ForceEx).unwrap()).unwrap();
    assert!((plateau.value - 2.0).abs() < 1e-12 && plateau.first == 20);
}
