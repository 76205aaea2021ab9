//! Whether a person can feel a swing. This is reported beside a verdict and never changes it.

use zwidth_study::VibrationCurve;

use super::swings::Swings;

/// Whether a swing can be felt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Felt {
    /// Above the threshold.
    Yes,
    /// Below it, or no swing at all.
    No,
    /// No swing exists, but one below what can be seen could be felt.
    BelowResolution,
}

/// Threshold of vibration: amplitude at the skin over frequency, straight lines between its points
/// in their logarithms.
#[derive(Debug, Clone, PartialEq)]
pub struct VibrationThreshold {
    /// Frequency (Hz, increasing) and amplitude (m, zero to peak), all above 0.
    pub points: Vec<(f64, f64)>,
}

impl VibrationThreshold {
    /// The threshold of a study.
    pub fn of(curve: &VibrationCurve) -> Self {
        Self { points: curve.points().iter().map(|[f, a]| (*f, *a)).collect() }
    }

    /// Amplitude that is just felt at a frequency, m; the nearest point's beyond the ends. Infinite
    /// without points: nothing is known to be felt.
    pub fn at_m(&self, frequency_hz: f64) -> f64 {
        let after = self.points.partition_point(|(f, _)| *f <= frequency_hz);
        match (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) {
            (Some((f0, a0)), Some(&(f1, a1))) => {
                let share = libm::log(frequency_hz / f0) / libm::log(f1 / f0);
                a0 * libm::pow(a1 / a0, share)
            }
            (Some((_, a)), None) | (None, Some(&(_, a))) => a,
            (None, None) => f64::INFINITY,
        }
    }
}

/// Whether swings can be felt at the end of a lever. `bound_rad` is half the peak-to-peak angle
/// below which none would be seen: 1e-9 rad and more in a simulation, a count or 4 σ of the noise
/// in a recording.
pub fn felt(swings: &Swings, bound_rad: f64, lever_m: f64, threshold: &VibrationThreshold) -> Felt {
    if swings.count == 0 {
        // At which frequency a swing would hide is not known: the most sensitive one decides.
        let lowest_m = threshold.points.iter().map(|(_, a)| *a).fold(f64::INFINITY, f64::min);
        let hidden = bound_rad * lever_m > lowest_m;
        return if hidden { Felt::BelowResolution } else { Felt::No };
    }
    let above = swings.amplitude_rad * lever_m > threshold.at_m(swings.frequency_hz);
    if above { Felt::Yes } else { Felt::No }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Round numbers, for arithmetic: no person's.
    fn threshold() -> VibrationThreshold {
        VibrationThreshold { points: vec![(10.0, 1e-5), (100.0, 1e-7)] }
    }

    #[test]
    fn the_threshold_is_straight_in_logarithms_and_flat_beyond_its_ends() {
        for (f, expect) in [(1.0, 1e-5), (10.0, 1e-5), (31.622_776_601_683_8, 1e-6), (1e3, 1e-7)] {
            assert!((threshold().at_m(f) / expect - 1.0).abs() < 1e-12, "{f}");
        }
    }

    #[test]
    fn a_swing_is_felt_above_the_threshold_and_none_is_unknown_where_it_could_hide() {
        let swings = |amplitude_rad| Swings { count: 9, amplitude_rad, frequency_hz: 100.0 };
        let of = |swings: &Swings, bound_rad| felt(swings, bound_rad, 0.1, &threshold());
        assert_eq!(of(&swings(2e-6), 1e-9), Felt::Yes);
        assert_eq!(of(&swings(0.5e-6), 1e-9), Felt::No);
        assert_eq!(of(&Swings::default(), 1e-9), Felt::No);
        assert_eq!(of(&Swings::default(), 2e-4), Felt::BelowResolution);
    }
}
