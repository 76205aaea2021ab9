//! How far a model's signal departs from the recorded one.

use crate::ReplayError;
use crate::lag::lag_s;
use zwidth_numerics::local::derivatives;
use zwidth_numerics::moments::Moments;

/// Velocities are those of parabolas through the angles of this time to either side, s, of
/// recording and model alike: what a controller's filter delays is not the model's error.
const HALF_S: f64 = 0.025;

/// The departure of the model's θ̇.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VelocityError {
    /// √mean (θ̇_model − θ̇)², rad/s.
    pub(crate) rmse_rad_s: f64,
    /// The RMSE over the recording's range, max θ̇ − min θ̇; `None` for a lever that never moves.
    pub(crate) nrmse: Option<f64>,
    /// Standard deviation of the model's θ̇ over that of the recorded one: above 1 the model's
    /// velocity varies more (thesis §4.3). `None` for a lever that never moves.
    pub(crate) sd_ratio: Option<f64>,
}

/// Compares the velocities of two courses of θ at times `t`; all three of one length.
pub(crate) fn compare_velocities(
    t: &[f64],
    recorded: &[f64],
    model: &[f64],
) -> Result<VelocityError, ReplayError> {
    let [recorded, model] = [derivatives(t, recorded, HALF_S)?, derivatives(t, model, HALF_S)?];
    let recorded = recorded.first;
    let model = model.first;
    let squares: f64 = model.iter().zip(&recorded).map(|(m, r)| (m - r) * (m - r)).sum();
    let rmse_rad_s = (squares / t.len() as f64).sqrt();
    let range = range(&recorded);
    let spread = Moments::of(&recorded).mean_square();
    Ok(VelocityError {
        rmse_rad_s,
        nrmse: (range > 0.0).then(|| rmse_rad_s / range),
        sd_ratio: (spread > 0.0).then(|| (Moments::of(&model).mean_square() / spread).sqrt()),
    })
}

/// A model's signal y against the recorded one. Errors are model less recording.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Comparison {
    /// √mean (ŷ − y)², unit of y.
    pub(crate) rmse: f64,
    /// The RMSE over the recording's range, max y − min y; `None` for a constant recording.
    pub(crate) nrmse: Option<f64>,
    /// Variance accounted for, 1 − var(ŷ − y) / var(y): 1 for a perfect model, and for one that is
    /// off by a constant; below 0 for one that is worse than the recording's mean. `None` for
    /// a constant recording.
    pub(crate) vaf: Option<f64>,
    /// The delay of the model, s: where the cross-correlation is highest within ±0.5 s. `None` if
    /// there is no highest value.
    pub(crate) lag_s: Option<f64>,
    /// Largest y of the recording, unit of y.
    pub(crate) peak_recorded: f64,
    /// Largest ŷ less it.
    pub(crate) peak_error: f64,
    /// Time of the first sample with the recording's largest y, s.
    pub(crate) peak_time_recorded_s: f64,
    /// Time of the first sample with the model's largest ŷ, less it, s.
    pub(crate) peak_time_error_s: f64,
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
    let range = range(recorded);
    let spread = Moments::of(recorded).mean_square();
    let (peak, model_peak) = (peak(recorded), peak(model));
    Ok(Comparison {
        rmse,
        nrmse: (range > 0.0).then(|| rmse / range),
        vaf: (spread > 0.0).then(|| 1.0 - Moments::of(&errors).mean_square() / spread),
        lag_s: lag_s(t, recorded, model)?,
        peak_recorded: recorded[peak],
        peak_error: model[model_peak] - recorded[peak],
        peak_time_recorded_s: t[peak],
        peak_time_error_s: t[model_peak] - t[peak],
    })
}

fn range(y: &[f64]) -> f64 {
    y.iter().copied().fold(f64::MIN, f64::max) - y.iter().copied().fold(f64::MAX, f64::min)
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

    /// θ = sin t against sin t + ¼ sin 2t: θ̇ is off by ½ cos 2t, and varies √(1 + ¼) as much.
    #[test]
    fn a_velocity_that_varies_more_has_a_ratio_above_one() {
        let t: Vec<f64> =
            (0..4000).map(|i| core::f64::consts::TAU * f64::from(i) / 4000.0).collect();
        let recorded: Vec<f64> = t.iter().map(|t| libm::sin(*t)).collect();
        let model: Vec<f64> = t.iter().map(|t| libm::sin(*t) + libm::sin(2.0 * t) / 4.0).collect();
        let found = compare_velocities(&t, &recorded, &model).unwrap();
        assert!((found.rmse_rad_s - 0.5 / 2_f64.sqrt()).abs() < 1e-3, "{found:?}");
        assert!((found.nrmse.unwrap() - 0.25 / 2_f64.sqrt()).abs() < 1e-3, "{found:?}");
        assert!((found.sd_ratio.unwrap() - 1.25_f64.sqrt()).abs() < 1e-3, "{found:?}");
        let same = compare_velocities(&t, &recorded, &recorded).unwrap();
        assert_eq!((same.rmse_rad_s, same.sd_ratio), (0.0, Some(1.0)));
        let still = compare_velocities(&t, &vec![1.0; t.len()], &model).unwrap();
        assert_eq!((still.nrmse, still.sd_ratio), (None, None));
    }

    #[test]
    fn a_constant_recording_has_an_error_only() {
        let found = compare(&T, &[3.0; 4], &Y).unwrap();
        assert_eq!((found.nrmse, found.vaf, found.lag_s), (None, None, None));
        assert!(found.rmse > 0.0);
    }
}
