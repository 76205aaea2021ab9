//! The lever's velocity from its angles.
//!
//! A difference of two counted angles at 1 kHz is a velocity in steps of 0.22 rad/s (one count of
//! the prototype's sensor in 1 ms), so its sign in slow motion is noise. The differentiator avoids
//! this at the price of a stated delay.

use crate::DeviceError;
use crate::error::positive;
use std::f64::consts::TAU;
use zwidth_study::VelocityFilter;

/// A velocity filter. Causal: it knows only what has been read.
///
/// At 1 kHz on the prototype's sensor, a lever at rest whose count flickers by one shows velocities
/// of up to 0.021 rad/s with the default differentiator (40 Hz, 8.0 ms late) and 0.22 rad/s with
/// the difference (0.5 ms late).
#[derive(Debug, Clone, PartialEq)]
pub struct Velocity(Filter);

#[derive(Debug, Clone, PartialEq)]
enum Filter {
    /// The critically damped filter H(s) = s ω² / (s + ω)², whose velocity is 2/ω late at low
    /// frequencies; ω in 1/s.
    ///
    /// Solved exactly between the samples, the angle taken as joined by straight lines, so that
    /// uneven times do no harm and no step is too long.
    Differentiator { omega: f64, state: Option<Smooth> },
    /// The last step divided by its time: delay half a step, and all of the sensor's noise.
    Difference { last: Option<(f64, f64)>, v: f64 },
}

/// The last input, and the filtered angle and its rate there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Smooth {
    t_s: f64,
    x: f64,
    y: f64,
    v: f64,
}

impl Velocity {
    /// The filter a study asks for, at its beginning.
    ///
    /// # Errors
    /// A cut-off that is not above 0 and finite.
    pub fn new(filter: VelocityFilter) -> Result<Self, DeviceError> {
        Ok(Self(match filter {
            VelocityFilter::Difference => Filter::Difference { last: None, v: 0.0 },
            VelocityFilter::SecondOrder { cutoff_hz } => {
                positive("control.velocity_cutoff_hz", cutoff_hz)?;
                Filter::Differentiator { omega: TAU * cutoff_hz, state: None }
            }
        }))
    }

    /// The velocity at a new angle, rad/s; 0 at the first. An angle that is not newer than the last
    /// changes nothing.
    pub fn step(&mut self, t_s: f64, theta_rad: f64) -> f64 {
        match &mut self.0 {
            Filter::Differentiator { omega, state } => {
                let next = match *state {
                    None => Smooth { t_s, x: theta_rad, y: theta_rad, v: 0.0 },
                    Some(last) if t_s <= last.t_s => last,
                    Some(last) => advance(*omega, last, t_s, theta_rad),
                };
                *state = Some(next);
                next.v
            }
            Filter::Difference { last, v } => {
                match *last {
                    Some((last_s, _)) if t_s <= last_s => return *v,
                    Some((last_s, last_rad)) => *v = (theta_rad - last_rad) / (t_s - last_s),
                    None => {}
                }
                *last = Some((t_s, theta_rad));
                *v
            }
        }
    }

    /// How late a slowly changing velocity is shown when angles come every `period_s`, s.
    #[cfg(test)]
    pub(crate) fn delay_s(&self, period_s: f64) -> f64 {
        match self.0 {
            Filter::Differentiator { omega, .. } => 2.0 / omega,
            Filter::Difference { .. } => 0.5 * period_s,
        }
    }
}

/// ÿ + 2ω ẏ + ω² y = ω² x for x = x₀ + s τ: the ramp is followed 2 s/ω late, and what differs from
/// that, z, decays as z = (z₀ + (ż₀ + ω z₀) τ) e^(−ωτ).
fn advance(omega: f64, last: Smooth, t_s: f64, x: f64) -> Smooth {
    let h = t_s - last.t_s;
    let slope = (x - last.x) / h;
    let lag = 2.0 * slope / omega;
    let z0 = last.y - last.x + lag;
    let rate0 = last.v - slope;
    let a = rate0 + omega * z0;
    let decay = libm::exp(-omega * h);
    Smooth { t_s, x, y: x - lag + (z0 + a * h) * decay, v: slope + (rate0 - omega * a * h) * decay }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The velocities at the angles of `theta`, every millisecond for 300 ms.
    fn run(mut filter: Velocity, theta: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let times = (0..300).map(|i| f64::from(i) * 1e-3);
        times.map(|t_s| (t_s, filter.step(t_s, theta(t_s)))).collect()
    }

    const CUTOFF_HZ: f64 = 40.0;

    fn differentiator() -> Velocity {
        Velocity::new(VelocityFilter::SecondOrder { cutoff_hz: CUTOFF_HZ }).unwrap()
    }

    fn difference() -> Velocity {
        Velocity::new(VelocityFilter::Difference).unwrap()
    }

    #[test]
    fn a_lever_at_rest_has_no_velocity_from_the_first_sample_on() {
        for filter in [differentiator(), difference()] {
            assert!(run(filter, |_| -0.785).iter().all(|(_, v)| *v == 0.0));
        }
    }

    #[test]
    fn a_ramp_has_its_slope() {
        for filter in [differentiator(), difference()] {
            let (_, v) = *run(filter, |t| 0.3 + 1.5 * t).last().unwrap();
            assert!((v - 1.5).abs() < 1e-9, "{v}");
        }
    }

    #[test]
    fn a_parabola_has_its_velocity_of_one_delay_ago() {
        for filter in [differentiator(), difference()] {
            let delay_s = filter.delay_s(1e-3);
            let (t, v) = *run(filter, |t| 0.5 * 20.0 * t * t).last().unwrap();
            // Chords of a parabola: the sampled filter is off by less than a·h/6.
            assert!((v - 20.0 * (t - delay_s)).abs() < 20.0 * 1e-3 / 6.0, "{v} at {t}");
        }
    }

    #[test]
    fn a_sine_is_scaled_and_turned_as_the_transfer_function_says() {
        let (omega, w) = (TAU * CUTOFF_HZ, 30.0);
        let gain = w * omega * omega / (omega * omega + w * w);
        let phase = std::f64::consts::FRAC_PI_2 - 2.0 * (w / omega).atan();
        for (t, v) in run(differentiator(), |t| (w * t).sin()).into_iter().skip(100) {
            let expect = gain * (w * t + phase).sin();
            assert!((v - expect).abs() < 2e-4 * gain, "{v} instead of {expect} at {t}");
        }
    }

    #[test]
    fn uneven_times_do_no_harm_and_a_repeated_time_changes_nothing() {
        let mut filter = differentiator();
        let mut v = 0.0;
        for i in 0..300 {
            let t = 1e-3 * (f64::from(i) + 0.4 * (f64::from(i) * 1.7).sin());
            v = filter.step(t, 1.5 * t);
            assert_eq!(filter.step(t, 99.0).to_bits(), v.to_bits());
        }
        assert!((v - 1.5).abs() < 1e-9);
    }

    #[test]
    fn one_count_of_the_prototypes_sensor_moves_it_as_the_documentation_says() {
        let count = crate::angle::rad_per_count(4096, 75.0 / 11.0);
        let flicker = |t: f64| if t < 0.1 { 0.0 } else { count };
        let peak = |filter| run(filter, flicker).iter().map(|(_, v)| *v).fold(0.0, f64::max);
        assert!((peak(differentiator()) - 0.0206).abs() < 1e-4, "{}", peak(differentiator()));
        assert!((peak(difference()) - 0.225).abs() < 1e-3);
    }

    #[test]
    fn a_cut_off_that_is_none_is_refused() {
        for cutoff_hz in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error =
                Velocity::new(VelocityFilter::SecondOrder { cutoff_hz }).unwrap_err().to_string();
            assert!(error.contains("velocity_cutoff_hz"), "{error}");
        }
    }
}
