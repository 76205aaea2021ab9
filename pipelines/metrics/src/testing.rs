//! Small closed-form trials and studies for the tests of this crate.

use crate::Parameters;
use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_study::{Scene, TrialMeta};

pub(crate) const RATE_HZ: f64 = 1000.0;
pub(crate) const REST_RAD: f64 = -core::f64::consts::FRAC_PI_4;
pub(crate) const LEVER_M: f64 = 0.045;

/// (t, θ, θ̇): half a second of rest, one raised cosine of `stroke_rad` in `period_s`, half a
/// second of rest.
pub(crate) fn stroke(stroke_rad: f64, period_s: f64) -> Vec<(f64, f64, f64)> {
    let omega = core::f64::consts::TAU / period_s;
    let samples = ((period_s + 1.0) * RATE_HZ) as u32;
    (0..=samples)
        .map(|i| {
            let t = f64::from(i) / RATE_HZ;
            let phase = omega * (t - 0.5).clamp(0.0, period_s);
            let theta = REST_RAD + stroke_rad * (1.0 - libm::cos(phase)) / 2.0;
            (t, theta, stroke_rad * omega / 2.0 * libm::sin(phase))
        })
        .collect()
}

/// A trial in the environment `spring` with the given motion and F(θ, θ̇).
pub(crate) fn trial(points: &[(f64, f64, f64)], force: impl Fn(f64, f64) -> f64) -> Trial {
    let mut samples = Samples::default();
    samples.set(Signal::Time, points.iter().map(|p| p.0).collect());
    samples.set(Signal::Theta, points.iter().map(|p| p.1).collect());
    samples.set(Signal::ThetaDot, points.iter().map(|p| p.2).collect());
    samples.set(Signal::ForceEx, points.iter().map(|p| force(p.1, p.2)).collect());
    Trial { meta: meta(), file: TrialFile::new(), samples }
}

/// The trial with no other signals than these.
pub(crate) fn only(trial: &Trial, signals: impl IntoIterator<Item = Signal>) -> Trial {
    let mut samples = Samples::default();
    for signal in signals {
        if let Some(values) = trial.samples.get(signal) {
            samples.set(signal, values.to_vec());
        }
    }
    Trial { samples, ..trial.clone() }
}

#[track_caller]
pub(crate) fn check(found: Option<f64>, expect: f64, tolerance: f64) {
    let found = found.unwrap();
    assert!((found - expect).abs() < tolerance, "{found} against {expect}");
}

pub(crate) fn meta() -> TrialMeta {
    zwidth_testing::meta(1, "hybrid")
}

/// The parameters of the template's hybrid mode, in a spring K (θ − rest).
pub(crate) fn in_spring(stiffness_n_per_rad: f64, rest_rad: f64) -> Parameters {
    let study = zwidth_testing::study();
    let hybrid = study.mode(&meta().mode).unwrap();
    let parameters = Parameters::of(&study, &study.environments[0], hybrid);
    let scene = Scene::Spring(zwidth_study::Spring { stiffness_n_per_rad, rest_rad });
    Parameters { scene, ..parameters }
}

/// The same with a wall.
pub(crate) fn at_wall(stiffness_n_per_rad: f64, rest_rad: f64, wall_rad: f64) -> Parameters {
    let mut parameters = in_spring(stiffness_n_per_rad, rest_rad);
    let spring = zwidth_study::Spring { stiffness_n_per_rad, rest_rad };
    parameters.scene = Scene::SpringWall { spring, wall_rad };
    parameters
}
