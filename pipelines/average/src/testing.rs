//! Small closed-form repeats for the tests of this crate.

use crate::Parameters;
use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_testing::meta;

pub(crate) const RATE_HZ: f64 = 1000.0;
/// One movement, there and back.
const PERIOD_S: f64 = 2.0;

/// Repeat `number`: rest, from `start_s` on one raised cosine of `stroke_rad` in two seconds, rest
/// until `length_s`; the force is 4 N/rad times the angle.
pub(crate) fn repeat(number: u32, start_s: f64, stroke_rad: f64, length_s: f64) -> Trial {
    let omega = core::f64::consts::TAU / PERIOD_S;
    let t: Vec<f64> = (0..=(length_s * RATE_HZ) as u32).map(|i| f64::from(i) / RATE_HZ).collect();
    let phase = |t: &f64| omega * (t - start_s).clamp(0.0, PERIOD_S);
    let theta: Vec<f64> =
        t.iter().map(|t| stroke_rad * (1.0 - libm::cos(phase(t))) / 2.0).collect();
    let velocity = t.iter().map(|t| stroke_rad * omega / 2.0 * libm::sin(phase(t))).collect();
    let mut samples = Samples::default();
    samples.set(Signal::ForceEx, theta.iter().map(|theta| 4.0 * theta).collect());
    samples.set(Signal::Theta, theta);
    samples.set(Signal::ThetaDot, velocity);
    samples.set(Signal::Time, t);
    Trial { meta: meta(number, "hybrid"), file: TrialFile::new(), samples }
}

/// Repeat `number`: half a second of rest, a raised cosine of 1 rad there in `there_s` and back in
/// `back_s`, half a second of rest.
pub(crate) fn there_and_back(number: u32, there_s: f64, back_s: f64) -> Trial {
    let point = |t: f64| {
        let s = (t - 0.5).clamp(0.0, there_s + back_s);
        let (half, length_s) = if s <= there_s {
            (s / there_s, there_s)
        } else {
            (1.0 + (s - there_s) / back_s, back_s)
        };
        let phase = core::f64::consts::PI * half;
        let velocity = core::f64::consts::FRAC_PI_2 / length_s * libm::sin(phase);
        // a sine at a multiple of π is rounding
        ((1.0 - libm::cos(phase)) / 2.0, if velocity.abs() < 1e-12 { 0.0 } else { velocity })
    };
    let length_s = there_s + back_s + 1.0;
    let t: Vec<f64> = (0..=(length_s * RATE_HZ) as u32).map(|i| f64::from(i) / RATE_HZ).collect();
    let (theta, velocity): (Vec<f64>, Vec<f64>) = t.iter().map(|t| point(*t)).unzip();
    let mut samples = Samples::default();
    samples.set(Signal::Theta, theta);
    samples.set(Signal::ThetaDot, velocity);
    samples.set(Signal::Time, t);
    Trial { meta: meta(number, "hybrid"), file: TrialFile::new(), samples }
}

/// Those of the template's first environment, which is `spring`.
pub(crate) fn parameters() -> Parameters {
    let study = zwidth_testing::study();
    Parameters { analysis: study.analysis, scene: study.environments[0].scene }
}
