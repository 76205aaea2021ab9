//! How far a model's signal departs from the recorded one.

use crate::ReplayError;
use crate::lag::lag_s;

/// A model's signal y against the recorded one. Errors are model less recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Comparison {
    /// √mean (ŷ − y)², unit of y.
    pub rmse: f64,
    /// That over the recording's range, max y − min y; `None` for a constant recording.
    pub nrmse: Option<f64>,
    /// Variance accounted for, 1 − var(ŷ − y) / var(y): 1 for a perfect model, and for one that is
    /// off by a constant; below 0 for one that is worse than the recording's mean. `None` for
    /// a constant recording.
    pub vaf: Option<f64>,
    /// By how much the model comes later, s: where the cross-correlation is highest within ±0.5 s.
    /// `None` where there is no highest.
    pub lag_s: Option<f64>,
    /// Largest y of the recording, unit of y.
    pub peak_recorded: f64,
    /// Largest ŷ less it.
    pub peak_error: f64,
    /// Time of the first sample with the recording's largest y, s.
    pub peak_time_recorded_s: f64,
    /// Time of the first sample with the model's largest ŷ, less it, s.
    pub peak_time_error_s: f64,
}

/// Compares two signals at times `t`; all three of one length, with at least one sample.
pub(crate) fn compare(
    t: &[f64],
    recorded: &[f64],
    model: &[f64],
) -> Result<Comparison, ReplayError> {
    let n = t.len() as f64;
    let errors: Vec<f64> = model.iter().zip(recorded).map(|(m, r)| m - r).collect();
    let rmse = (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt();
    let range = recorded.iter().copied().fold(f64::MIN, f64::max)
        - recorded.iter().copied().fold(f64::MAX, f64::min);
    let spread = variance(recorded);
    let (peak, model_peak) = (peak(recorded), peak(model));
    Ok(Comparison {
        rmse,
        nrmse: (range > 0.0).then(|| rmse / range),
        vaf: (spread > 0.0).then(|| 1.0 - variance(&errors) / spread),
        lag_s: lag_s(t, recorded, model)?,
        peak_recorded: recorded[peak],
        peak_error: model[model_peak] - recorded[peak],
        peak_time_recorded_s: t[peak],
        peak_time_error_s: t[model_peak] - t[peak],
    })
}

/// The first sample of the largest value.
fn peak(y: &[f64]) -> usize {
    let mut peak = 0;
    for i in 0..y.len() {
        if y[i] > y[peak] {
            peak = i;
        }
    }
    peak
}

/// Mean square about the mean.
fn variance(y: &[f64]) -> f64 {
    let n = y.len() as f64;
    let mean = y.iter().sum::<f64>() / n;
    y.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [f64; 4] = [0.0, 1.0, 2.0, 3.0];
    const Y: [f64; 4] = [0.0, 2.0, 4.0, 2.0];

    #[test]
    fn a_model_that_is_off_by_a_constant_has_an_error_and_accounts_for_all_variance() {
        let found = compare(&T, &Y, &Y.map(|y| y + 1.0)).unwrap();
        assert_eq!((found.rmse, found.nrmse, found.vaf), (1.0, Some(0.25), Some(1.0)));
        assert_eq!(
            (found.peak_recorded, found.peak_error, found.peak_time_error_s),
            (4.0, 1.0, 0.0)
        );
    }

    #[test]
    fn the_mean_accounts_for_nothing_and_half_of_a_signal_for_three_quarters() {
        assert_eq!(compare(&T, &Y, &[2.0; 4]).unwrap().vaf, Some(0.0));
        assert_eq!(compare(&T, &Y, &Y.map(|y| y / 2.0)).unwrap().vaf, Some(0.75));
    }

    #[test]
    fn a_constant_recording_has_an_error_only() {
        let found = compare(&T, &[3.0; 4], &Y).unwrap();
        assert_eq!((found.nrmse, found.vaf, found.lag_s), (None, None, None));
        assert!(found.rmse > 0.0);
    }
}
