//! The user's force over a whole recording.

use crate::MetricsError;
use crate::signals::Signals;
use serde::Serialize;
use zwidth_numerics::series::trapezoid;

/// The user's force over the recording: everything that a force alone shows, for a held load or a
/// grip.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct UserForce {
    /// ∫F dt / Δt, N; the value itself of a single sample.
    pub mean_n: Option<f64>,
    /// The F of the largest magnitude, with its sign, N.
    pub largest_n: Option<f64>,
}

pub(crate) fn user_force(signals: &Signals) -> Result<UserForce, MetricsError> {
    let Some(force) = signals.force() else { return Ok(UserForce::default()) };
    let t = signals.t()?;
    let span_s = t[t.len() - 1] - t[0];
    // A single sample has no duration to divide by.
    let mean_n = if span_s > 0.0 { trapezoid(&t, &force)? / span_s } else { force[0] };
    let largest_n = force.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs()));
    Ok(UserForce { mean_n: Some(mean_n), largest_n })
}

#[cfg(test)]
mod tests {
    use crate::testing::{in_spring, only, stroke, trial};
    use crate::trial_metrics;
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
        assert_eq!((found.mean_n, found.largest_n), (Some(2.5), Some(2.5)));
    }
}
