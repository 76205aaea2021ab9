//! The user's force over a whole recording.

use crate::MetricsError;
use crate::signals::Signals;
use serde::Serialize;
use zwidth_numerics::phases::Phases;
use zwidth_numerics::series::trapezoid;

/// The user's force over the recording: everything that a force alone shows, for a held load or a
/// grip.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct UserForce {
    /// ∫F dt / Δt, N; the value itself of a single sample.
    pub mean_n: Option<f64>,
    /// The F of the largest magnitude, with its sign, N.
    pub largest_n: Option<f64>,
    /// √(∫F² dt / Δt), N.
    pub rms_n: Option<f64>,
    /// Time to peak: from the movement's onset to the first F of the largest magnitude from there to
    /// its end, s. Null without a movement.
    pub peak_s: Option<f64>,
}

pub(crate) fn user_force(signals: &Signals) -> Result<UserForce, MetricsError> {
    let Some(force) = signals.force() else { return Ok(UserForce::default()) };
    let t = signals.t()?;
    let span_s = t[t.len() - 1] - t[0];
    // A single sample has no duration to divide by.
    let mean = |f: &[f64]| -> Result<f64, MetricsError> {
        Ok(if span_s > 0.0 { trapezoid(&t, f)? / span_s } else { f[0] })
    };
    let mean_n = mean(&force)?;
    let squares: Vec<f64> = force.iter().map(|f| f * f).collect();
    let rms_n = mean(&squares)?.sqrt();
    let largest_n = force.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    let peak_s = signals.phases.map(|Phases { onset, end, .. }| {
        let first = (onset..=end).rev().max_by(|i, j| force[*i].abs().total_cmp(&force[*j].abs()));
        t[first.unwrap_or(onset)] - t[onset]
    });
    Ok(UserForce { mean_n: Some(mean_n), largest_n, rms_n: Some(rms_n), peak_s })
}

#[cfg(test)]
mod tests {
    use crate::testing::{in_spring, only, stroke, trial};
    use crate::trial_metrics;
    use core::f64::consts::PI;
    use zwidth_store::{Signal, Trial};

    /// A trial of times alone.
    fn at(t: &[f64]) -> Trial {
        let mut trial = only(&trial(&stroke(1.0, 0.5), |_, _| 0.0), []);
        trial.samples.set(Signal::Time, t.to_vec());
        trial
    }

    /// A ramp from −1 to 3 N has the mean 1 N whenever it is sampled; NumPy's `trapezoid` says so too.
    #[test]
    fn a_force_alone_has_a_mean_over_time_and_a_largest_value() {
        let t = [0.0, 0.1, 0.5, 1.0];
        let mut held = at(&t);
        held.samples.set(Signal::ForceEx, t.map(|t| 4.0 * t - 1.0).to_vec());
        let found = trial_metrics(&held, &in_spring(4.0, 0.0)).unwrap().force;
        assert!((found.mean_n.unwrap() - 1.0).abs() < 1e-15, "{found:?}");
        assert_eq!(found.largest_n, Some(3.0));
        // ∫F² dt by the same rule: (0.1 · 1.36 + 0.4 · 1.36 + 0.5 · 10) / 2.
        assert!((found.rms_n.unwrap() - 2.84_f64.sqrt()).abs() < 1e-15, "{found:?}");
        assert_eq!(found.peak_s, None, "nothing moves");
        held.samples.set(Signal::ForceEx, t.map(|t| 1.0 - 4.0 * t).to_vec());
        let found = trial_metrics(&held, &in_spring(4.0, 0.0)).unwrap().force;
        assert_eq!(found.largest_n, Some(-3.0), "with its sign");
    }

    #[test]
    fn without_a_force_there_is_none_and_a_single_sample_is_its_own_mean() {
        let mut held = at(&[0.0]);
        let found = trial_metrics(&held, &in_spring(4.0, 0.0)).unwrap().force;
        assert_eq!((found.mean_n, found.largest_n), (None, None));
        held.samples.set(Signal::ForceEx, vec![2.5]);
        let found = trial_metrics(&held, &in_spring(4.0, 0.0)).unwrap().force;
        let found = (found.mean_n, found.largest_n, found.rms_n);
        assert_eq!(found, (Some(2.5), Some(2.5), Some(2.5)));
    }

    /// F = −sin(π t) for the first second from the onset on has its peak half a second after it, and an
    /// RMS of √½ over that second.
    #[test]
    fn a_force_has_a_time_from_the_onset_to_its_first_peak_and_an_rms() {
        let pushed = trial(&stroke(1.0, 2.0), |_, _| 0.0);
        let onset_s = trial_metrics(&pushed, &in_spring(4.0, 0.0)).unwrap().movement.onset_s;
        let onset_s = onset_s.unwrap();
        let t = pushed.samples.get(Signal::Time).unwrap().to_vec();
        let mut pushed = pushed;
        // For one second.
        let half = |s: f64| if (0.0..=1.0).contains(&s) { -libm::sin(PI * s) } else { 0.0 };
        pushed.samples.set(Signal::ForceEx, t.iter().map(|t| half(t - onset_s)).collect());
        let found = trial_metrics(&pushed, &in_spring(4.0, 0.0)).unwrap().force;
        assert!((found.peak_s.unwrap() - 0.5).abs() < 2e-3, "{found:?}");
        let share = 1.0 / (t[t.len() - 1] - t[0]);
        assert!((found.rms_n.unwrap() - (0.5 * share).sqrt()).abs() < 1e-4, "{found:?}");
        // Two peaks of one height: the first counts, and what is outside the movement does not.
        let mut force = vec![0.0; t.len()];
        let at = |s: f64| t.iter().position(|t| *t >= s).unwrap();
        (force[at(onset_s + 0.2)], force[at(onset_s + 0.7)], force[0]) = (3.0, -3.0, 9.0);
        pushed.samples.set(Signal::ForceEx, force);
        let found = trial_metrics(&pushed, &in_spring(4.0, 0.0)).unwrap().force;
        assert!((found.peak_s.unwrap() - 0.2).abs() < 2e-3, "{found:?}");
    }
}
