//! How steadily the device behaved: switching, oscillation.

use crate::MetricsError;
use crate::oscillation::{Swings, force_band, swings, velocity_band};
use crate::signals::Signals;
use zwidth_numerics::phases::Phases;
use zwidth_numerics::spectrum::BandPower;

/// How steadily the device behaved between onset and end. All null without a movement.
///
/// **Verdict.** A model run is judged by the model's own motion, which tells chattering of the
/// method from what the model does (`zwidth_dynamics::RunVerdict`). A recording cannot be run
/// again, so it is `smooth` or `oscillating` by the same count of fast swings, and no more is
/// claimed.
///
/// **Band.** Power and dominant frequency from 5 to 50 Hz, by Welch's method ([`band_power`]),
/// never above the channel's own Nyquist frequency: for θ̇ half of the rate of samples; for the
/// force half of the rate at which its sensor gives new values (by `force_age_s`, or else
/// `device.force_rate_hz` if that is less than the rate of samples): 40 Hz for 80 per second. The
/// highest included frequency is a column of its own. Null if nothing of the band is left, and for
/// a movement shorter than 1 s.
///
/// [`band_power`]: zwidth_numerics::spectrum::band_power
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stability {
    /// How often the motor goes on or off from one sample to the next, by `flags` or a voltage
    /// that is not 0. Null where the recording has neither.
    pub motor_switches: Option<i64>,
    /// How often the brake goes on or off, likewise.
    pub brake_switches: Option<i64>,
    /// How often the set of actuators that are on changes: a handover in one sample is one switch.
    /// Null where neither is known.
    pub actuator_switches: Option<i64>,
    /// Turns of the lever and their verdict.
    pub swings: Swings,
    /// What the user's force does from 5 to 50 Hz.
    pub force_band: Option<BandPower>,
    /// What θ̇ does from 5 to 50 Hz.
    pub velocity_band: Option<BandPower>,
}

pub(crate) fn stability(
    signals: &Signals,
    force_rate_hz: Option<f64>,
) -> Result<Stability, MetricsError> {
    let Some(phases) = signals.phases else {
        return Ok(Stability::default());
    };
    let [motor_switches, brake_switches] = [&signals.motor_on, &signals.brake_on].map(|on| {
        let moving = &on.as_ref()?[phases.onset..=phases.end];
        Some(moving.windows(2).map(|w| i64::from(w[0] != w[1])).sum())
    });
    Ok(Stability {
        motor_switches,
        brake_switches,
        actuator_switches: actuator_switches(signals, phases),
        swings: swings(signals)?,
        force_band: force_band(signals, force_rate_hz)?,
        velocity_band: velocity_band(signals)?,
    })
}

fn actuator_switches(signals: &Signals, Phases { onset, end, .. }: Phases) -> Option<i64> {
    let recorded: Vec<&Vec<bool>> =
        [&signals.motor_on, &signals.brake_on].into_iter().flatten().collect();
    (!recorded.is_empty()).then(|| {
        (onset..end).filter(|i| recorded.iter().any(|on| on[*i] != on[*i + 1])).count() as i64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, check, in_spring, stroke, trial};
    use crate::trial_metrics;
    use core::f64::consts::TAU;
    use zwidth_results::RecordedStability;
    use zwidth_store::{Signal, Trial};

    fn of(trial: &Trial) -> Stability {
        trial_metrics(trial, &in_spring(4.0, REST_RAD)).unwrap().stability
    }

    /// A stroke of 1.2 rad in 3 s on which θ swings by ±0.02 rad at 12 Hz from 1.25 s to 2.75 s,
    /// whole periods.
    fn shaken() -> Vec<(f64, f64, f64)> {
        let shake = |(t, theta, v): (f64, f64, f64)| {
            let (omega, on) = (TAU * 12.0, (1.25..2.75).contains(&t));
            let (swing, speed) = (0.02 * libm::sin(omega * t), 0.02 * omega * libm::cos(omega * t));
            if on { (t, theta + swing, v + speed) } else { (t, theta, v) }
        };
        stroke(1.2, 3.0).into_iter().map(shake).collect()
    }

    #[test]
    fn a_smooth_stroke_is_smooth_and_turns_once() {
        let found = of(&trial(&stroke(1.2, 3.0), |theta, _| 4.0 * (theta - REST_RAD)));
        let expect = Swings {
            reversals: Some(1),
            fast: Some(0),
            verdict: Some(RecordedStability::Smooth),
            ..Swings::default()
        };
        assert_eq!(found.swings, expect);
        assert_eq!(found.velocity_band.unwrap().dominant_hz, None);
        // 2.4 N at a third of a hertz, a thousandth of which leaks through the window
        assert!(found.force_band.unwrap().power.sqrt() < 2.4e-3, "{:?}", found.force_band);
        assert_eq!(found.force_band.unwrap().dominant_hz, None);
    }

    #[test]
    fn a_shaken_stroke_oscillates_at_its_frequency() {
        let found = of(&trial(&shaken(), |_, v| 0.5 * v));
        assert_eq!(found.swings.verdict, Some(RecordedStability::Oscillating));
        assert!((33..=35).contains(&found.swings.fast.unwrap()), "{:?}", found.swings);
        check(found.swings.frequency_hz, 12.0, 0.3); // the first and last swing are cut
        check(found.swings.amplitude_rad, 0.04, 0.01);
        check(found.velocity_band.unwrap().dominant_hz, 12.0, 0.2);
        check(found.force_band.unwrap().dominant_hz, 12.0, 0.2);
    }

    /// The user's force shakes by 0.1 N at 30 Hz, or at 60 Hz, and its sensor gives 80 values a
    /// second.
    #[test]
    fn a_slow_force_sensor_is_heard_below_its_own_nyquist_frequency() {
        let taken = |t: f64| (t * 80.0).floor() / 80.0;
        let held = |hz: f64| {
            let points = stroke(1.2, 3.0);
            let mut trial = trial(&points, |_, _| 0.0);
            let force =
                points.iter().map(|p| 2.0 + 0.1 * libm::sin(TAU * hz * taken(p.0))).collect();
            trial.samples.set(Signal::ForceEx, force);
            trial.samples.set(Signal::ForceAge, points.iter().map(|p| p.0 - taken(p.0)).collect());
            of(&trial).force_band.unwrap()
        };
        let found = held(30.0);
        check(found.dominant_hz, 30.0, 0.05);
        check(Some(found.power.sqrt()), 0.1 / 2_f64.sqrt(), 5e-4);
        check(Some(found.top_hz), 39.0, 1e-12);
    }

    #[test]
    fn without_an_age_the_devices_force_rate_bounds_the_band() {
        let mut parameters = in_spring(4.0, REST_RAD);
        let trial = trial(&shaken(), |_, v| 0.5 * v);
        let mut top = |rate: Option<f64>| {
            parameters.force_rate_hz = rate;
            trial_metrics(&trial, &parameters).unwrap().stability.force_band.map(|b| b.top_hz)
        };
        assert_eq!((top(Some(80.0)), top(None), top(Some(10.0))), (Some(39.0), Some(50.0), None));
    }

    #[test]
    fn a_movement_shorter_than_a_second_has_no_band_but_a_verdict() {
        let found = of(&trial(&stroke(1.0, 0.8), |_, _| 1.0));
        assert_eq!((found.force_band, found.velocity_band), (None, None));
        assert_eq!(found.swings.verdict, Some(RecordedStability::Smooth));
    }

    /// Brake on the way in, motor on the way out.
    #[test]
    fn a_handover_is_one_switch_of_the_set_and_one_of_each_actuator() {
        let points = stroke(1.2, 2.0);
        let mut trial = trial(&points, |_, _| 1.0);
        let volts =
            |on: fn(f64) -> bool| points.iter().map(|p| f64::from(u8::from(on(p.0)))).collect();
        trial.samples.set(Signal::VoltageBrake, volts(|t| t < 1.5));
        trial.samples.set(Signal::VoltageMotor, volts(|t| t >= 1.5));
        let found = of(&trial);
        assert_eq!((found.motor_switches, found.brake_switches), (Some(1), Some(1)));
        assert_eq!(found.actuator_switches, Some(1));
        assert_eq!(of(&crate::testing::trial(&points, |_, _| 1.0)).actuator_switches, None);
    }
}
