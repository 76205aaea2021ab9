//! Small closed-form repeats for the tests of this crate.

use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_study::{
    EnvironmentId, Kind, ModeId, ParticipantId, SessionId, Source, Status, Study, StudyId, TrialMeta,
};

pub(crate) const RATE_HZ: f64 = 1000.0;
/// One movement, there and back.
const PERIOD_S: f64 = 2.0;

/// Repeat `number`: rest, from `start_s` on one raised cosine of `stroke_rad` in two seconds, rest until `length_s`;
/// the force is 4 N/rad times the angle.
pub(crate) fn repeat(number: u32, start_s: f64, stroke_rad: f64, length_s: f64) -> Trial {
    let omega = core::f64::consts::TAU / PERIOD_S;
    let t: Vec<f64> = (0..=(length_s * RATE_HZ) as u32).map(|i| f64::from(i) / RATE_HZ).collect();
    let phase = |t: &f64| omega * (t - start_s).clamp(0.0, PERIOD_S);
    let theta: Vec<f64> = t.iter().map(|t| stroke_rad * (1.0 - libm::cos(phase(t))) / 2.0).collect();
    let velocity = t.iter().map(|t| stroke_rad * omega / 2.0 * libm::sin(phase(t))).collect();
    let mut samples = Samples::default();
    samples.set(Signal::ForceEx, theta.iter().map(|theta| 4.0 * theta).collect());
    samples.set(Signal::Theta, theta);
    samples.set(Signal::ThetaDot, velocity);
    samples.set(Signal::Time, t);
    Trial { meta: meta(number), file: TrialFile::new(), samples }
}

fn meta(number: u32) -> TrialMeta {
    TrialMeta {
        participant: ParticipantId::new("P01").unwrap(),
        session: SessionId::new("S01").unwrap(),
        trial: number,
        repeat: number,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: EnvironmentId::new("spring").unwrap(),
        mode: ModeId::new("hybrid").unwrap(),
        likert: None,
        source: Source::Twin,
    }
}

/// The template's study: its first environment is `spring`.
pub(crate) fn study() -> Study {
    Study::from_toml(&zwidth_study::template(&StudyId::new("demo").unwrap())).unwrap()
}
