//! The digits that a recording keeps. The counts of sensors and clocks are multiplied and divided
//! until all 53 bits of a number vary, and no compression removes the meaningless ones: they would
//! be a quarter of a trial's file.

/// A clock's ticks per second: one is 0.93 ns, so that counts of nanoseconds differ in it.
const TICKS_PER_S: f64 = (1_u64 << 30) as f64;

/// Steps per unit (rad, rad/s, N): one is 0.9 · 10⁻¹², and a count of the finest sensors 10⁶ of
/// them.
const STEPS_PER_UNIT: f64 = (1_u64 << 40) as f64;

/// A time, s, in whole ticks of 2⁻³⁰ s: sums and differences of such times are exact for 97 days.
pub(crate) fn on_ticks(time_s: f64) -> f64 {
    (time_s * TICKS_PER_S).round() / TICKS_PER_S
}

/// The first tick that is no earlier than a time, s.
pub(crate) fn next_tick(time_s: f64) -> f64 {
    (time_s * TICKS_PER_S).ceil() / TICKS_PER_S
}

/// An angle, a velocity or a force in whole steps of 2⁻⁴⁰ of its unit; what is too large to have
/// steps is as it was.
pub(crate) fn on_steps(value: f64) -> f64 {
    let kept = (value * STEPS_PER_UNIT).round() / STEPS_PER_UNIT;
    if kept.is_finite() { kept } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn nanoseconds_differ_in_ticks() {
        for from in [0_u64, 123_456_789, 10_000_000_000, 86_400_000_000_000] {
            for ns in from..from + 1000 {
                let time_s = on_ticks(Duration::from_nanos(ns).as_secs_f64());
                assert_eq!((time_s * 1e9).round() as u64, ns);
                assert_eq!(next_tick(time_s).to_bits(), time_s.to_bits());
                assert!(next_tick(time_s.next_up()) > time_s);
            }
        }
    }

    #[test]
    fn a_step_is_smaller_than_anything_measured_and_no_number_is_lost() {
        for value in [0.0, -0.0, 1.0 / 3.0, -2.5e-7, 1e9 / 7.0, 1e300, f64::INFINITY] {
            let kept = on_steps(value);
            let is_near = (kept - value).abs() < 0.5e-12;
            assert!(is_near || kept.to_bits() == value.to_bits(), "{kept} {value}");
            assert_eq!(kept.is_sign_negative(), value.is_sign_negative());
            assert_eq!(on_steps(kept).to_bits(), kept.to_bits());
        }
        assert!(on_steps(f64::NAN).is_nan());
    }
}
