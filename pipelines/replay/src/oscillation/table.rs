//! Oscillations as rows.

use super::judge::Oscillation;
use zwidth_results::TrialOscillation;
use zwidth_study::TrialMeta;

/// The row of a trial.
pub fn trial_oscillation(meta: &TrialMeta, oscillation: &Oscillation) -> TrialOscillation {
    let Oscillation { origin, recorded, with_force, alone, nature, .. } = oscillation;
    let [amplitude_rad, with_force_amplitude_rad, alone_amplitude_rad] =
        [recorded, with_force, alone].map(|swings| swings.map(|swings| swings.amplitude_rad));
    let [frequency_hz, with_force_frequency_hz, alone_frequency_hz] =
        [recorded, with_force, alone].map(|swings| swings.map(|swings| swings.frequency_hz));
    let stepped_rad = nature.map(|_| oscillation.stepped_rad);
    TrialOscillation {
        participant: meta.participant.clone(),
        session: meta.session.clone(),
        trial: meta.trial,
        environment: meta.environment.clone(),
        mode: meta.mode.clone(),
        source: meta.source,
        answer: origin.answer().as_str().to_owned(),
        why: origin.why().into(),
        bound_rad: oscillation.bound_rad,
        swings: recorded.map(|swings| swings.swings),
        from_s: recorded.map(|swings| swings.from_s),
        to_s: recorded.map(|swings| swings.to_s),
        amplitude_rad,
        frequency_hz,
        with_force_amplitude_rad,
        with_force_frequency_hz,
        alone_amplitude_rad,
        alone_frequency_hz,
        stepped_amplitude_rad: stepped_rad.map(|[whole, _, _]| whole),
        half_step_amplitude_rad: stepped_rad.map(|[_, half, _]| half),
        quarter_step_amplitude_rad: stepped_rad.map(|[_, _, quarter]| quarter),
        nature: nature.map(|nature| nature.as_str().to_owned()),
        power_factor: oscillation.power_factor,
    }
}
