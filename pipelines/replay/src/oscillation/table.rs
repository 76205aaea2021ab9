//! Oscillations as rows.

use super::judge::Oscillation;
use super::recorded::RecordedSwings;
use zwidth_results::TrialOscillation;
use zwidth_study::TrialMeta;

/// The row of a trial.
pub fn trial_oscillation(meta: &TrialMeta, of: &Oscillation) -> TrialOscillation {
    let amplitude = |swings: &Option<RecordedSwings>| swings.map(|swings| swings.amplitude_rad);
    let frequency = |swings: &Option<RecordedSwings>| swings.map(|swings| swings.frequency_hz);
    let stepped_rad = of.nature.map(|_| of.stepped_rad);
    TrialOscillation {
        participant: meta.participant.clone(),
        session: meta.session.clone(),
        trial: meta.trial,
        environment: meta.environment.clone(),
        mode: meta.mode.clone(),
        source: meta.source,
        answer: of.origin.answer().as_str().to_owned(),
        why: of.origin.why().into(),
        bound_rad: of.bound_rad,
        swings: of.recorded.map(|swings| swings.swings),
        from_s: of.recorded.map(|swings| swings.from_s),
        to_s: of.recorded.map(|swings| swings.to_s),
        amplitude_rad: amplitude(&of.recorded),
        frequency_hz: frequency(&of.recorded),
        with_force_amplitude_rad: amplitude(&of.with_force),
        with_force_frequency_hz: frequency(&of.with_force),
        alone_amplitude_rad: amplitude(&of.alone),
        alone_frequency_hz: frequency(&of.alone),
        stepped_amplitude_rad: stepped_rad.map(|of| of[0]),
        half_step_amplitude_rad: stepped_rad.map(|of| of[1]),
        quarter_step_amplitude_rad: stepped_rad.map(|of| of[2]),
        nature: of.nature.map(|nature| nature.as_str().to_owned()),
        power_factor: of.power_factor,
    }
}
