//! Angles from counts.

mod motions;

use super::*;
use crate::mock;
use proptest::prelude::*;

const PER_TURN: u32 = 4096;
const HALF_TURN: i64 = 2048;

fn wrapped(total: i64) -> u16 {
    u16::try_from(total.rem_euclid(i64::from(PER_TURN))).unwrap()
}

#[test]
fn a_count_between_readings_that_lie_microseconds_apart_is_no_speed() {
    let mut unwrap = Unwrap::start(4096, 0.0, 100).unwrap();
    assert_eq!(unwrap.follow(1.0 / 120.0, 120), Ok(120));
    assert_eq!(unwrap.follow(1.0 / 120.0 + 5e-6, 121), Ok(121)); // 48 turns a second, if it were one
    assert_eq!(unwrap.follow(2.0 / 120.0 + 5e-6, 140), Ok(140));
}

proptest! {
    #[test]
    fn steps_below_half_a_turn_that_change_by_less_than_a_quarter_unwrap_exactly(
        start in 0..4096_i64,
        changes in prop::collection::vec(-1023..1024_i64, 1..200),
    ) {
        let mut unwrap = Unwrap::start(PER_TURN, 0.0, wrapped(start)).unwrap();
        let (mut step, mut total) = (0_i64, start);
        for (i, change) in changes.iter().enumerate() {
            step = (step + change).clamp(1 - HALF_TURN, HALF_TURN - 1);
            total += step;
            let t_s = 0.0083 * (i + 1) as f64;
            prop_assert_eq!(unwrap.follow(t_s, wrapped(total)), Ok(total));
        }
    }

    #[test]
    fn any_swing_of_the_prototypes_lever_below_its_limit_unwraps_exactly_at_uneven_times(
        start in 0..4096_i64,
        amplitude_deg in 1.0..45.0_f64,
        share_of_limit in 0.01..0.35_f64,
        late in prop::collection::vec(0.0..1.0_f64, 100),
    ) {
        // Speed A·w stays below the limit of 3,180°/s, and the change of a step below a quarter
        // turn.
        let w = share_of_limit * 3180.0 / amplitude_deg;
        prop_assume!(amplitude_deg * w * w * 0.0083 * 0.0083 < 10.0);
        let counts = |t_s: f64| {
            let lever_deg = amplitude_deg * (1.0 - (w * t_s).cos());
            start + (lever_deg * 75.0 / 11.0 / 360.0 * 4096.0).floor() as i64
        };
        let mut unwrap = Unwrap::start(PER_TURN, 0.0, wrapped(start)).unwrap();
        for (i, late) in late.iter().enumerate() {
            let t_s = 0.0083 * (i as f64 + 0.3 * late) + 0.004;
            prop_assert_eq!(unwrap.follow(t_s, wrapped(counts(t_s))), Ok(counts(t_s)));
        }
    }
}

#[test]
fn more_than_a_quarter_turn_from_the_expected_step_is_refused_and_forgotten() {
    let mut unwrap = Unwrap::start(PER_TURN, 0.0, 4000).unwrap();
    let fault = unwrap.follow(0.001, wrapped(4000 + 1025)).unwrap_err();
    assert!(matches!(fault, AngleFault::Jump { step_turns, .. } if step_turns > 0.25));
    assert_eq!(unwrap.follow(0.001, wrapped(4000 + 1024)), Ok(5024));
}

#[test]
fn the_expected_step_grows_with_the_gap() {
    let mut unwrap = Unwrap::start(PER_TURN, 0.0, 0).unwrap();
    unwrap.follow(0.001, 500).unwrap();
    assert_eq!(unwrap.follow(0.004, 2000), Ok(2000)); // three steps at once, at the same speed
    assert!(unwrap.follow(0.010, 2000 + 3000 - 4096 + 4096).is_err()); // six would be 0.73 turn
}

#[test]
fn a_code_the_sensor_does_not_have_is_refused() {
    let fault = Unwrap::start(PER_TURN, 0.0, 0).unwrap().follow(0.001, 4096).unwrap_err();
    assert_eq!(fault.to_string(), "the angle sensor gave 4096, and its largest code is 4095");
}

#[test]
fn half_a_turn_of_the_prototypes_shaft_is_26_4_degrees_of_lever() {
    let half_turn_deg =
        (f64::from(PER_TURN / 2) * rad_per_count(PER_TURN, 75.0 / 11.0)).to_degrees();
    assert!((half_turn_deg - 26.4).abs() < 1e-9);
    assert!((half_turn_deg / 0.0083 - 3180.7).abs() < 0.1);
    assert!((unwrap_margin(-512, PER_TURN) - 0.75).abs() < 1e-12);
}

#[test]
fn homing_puts_the_stop_where_it_is_whatever_the_count_there() {
    let capabilities = mock::capabilities();
    for at_stop in [0_u16, 1234, 4095] {
        let reading = mock::reading(Angle::Counts(at_stop));
        let mut homed = Homed::at_stop(&capabilities, -0.785, 0.0, &reading).unwrap();
        let theta_rad = homed.follow(0.001, Angle::Counts((at_stop + 100) % 4096)).unwrap();
        assert!((theta_rad - (-0.785 + 100.0 * TAU / 4096.0 * 11.0 / 75.0)).abs() < 1e-12);
    }
}

#[test]
fn an_angle_that_is_not_at_the_stop_does_not_home() {
    let capabilities = Capabilities { counts_per_turn: None, ..mock::capabilities() };
    let reading = mock::reading(Angle::Lever(0.0));
    let error = Homed::at_stop(&capabilities, -0.785, 0.0, &reading).unwrap_err().to_string();
    assert!(error.contains("at 0.0 degrees") && error.contains("home again"), "{error}");
}
