//! Averages over a stretch of time whose weights vanish at its ends: with them, averages of
//! derivatives are averages of the signal itself.

/// Half of a stretch, s: much shorter than a stroke of the hand or a slow motor, long enough for
/// the angle sensor's steps to average out.
pub(crate) const HALF_S: f64 = 0.1;

/// The samples strictly inside a stretch: one that lies at its end, but for rounding, has weight 0
/// and does not count.
const INSIDE: f64 = 1.0 - 1e-9;

/// The samples of a stretch, and their weights.
pub(crate) struct Stretch {
    /// First of them.
    pub(crate) first: usize,
    /// φ: weights that sum to 1.
    pub(crate) weights: Vec<f64>,
    /// −φ': Σ −φ'ᵢ yᵢ is the average of ẏ, 1/s.
    pub(crate) slope: Vec<f64>,
    /// φ'': Σ φ''ᵢ yᵢ is the average of ÿ, 1/s².
    pub(crate) curvature: Vec<f64>,
}

/// The stretch of 2 [`HALF_S`] about sample `centre` of the times `t`; `None` where the recording
/// does not cover it.
///
/// φ(s) = (1 − s²)⁵ with s = (t − t_centre) / [`HALF_S`]. φ and φ' vanish at both ends, so
/// integrating by parts twice gives ∫φ ÿ dt = ∫φ'' y dt, without a term at the ends (modulating
/// functions: Shinbrot 1957, Trans. ASME 79:547). Integrals are sums over the samples, times half
/// of the two intervals beside each; because φ'' and two more derivatives vanish at the ends as
/// well, these sums are integrals but for a share of (interval / [`HALF_S`])⁶.
pub(crate) fn stretch(t: &[f64], centre: usize) -> Option<Stretch> {
    let at = t[centre];
    let first = t.partition_point(|t| *t <= at - HALF_S * INSIDE);
    let end = t.partition_point(|t| *t < at + HALF_S * INSIDE);
    // The interval of a sample reaches to its neighbours on both sides.
    if first == 0 || end == t.len() {
        return None;
    }
    let parts: Vec<Part> =
        (first..end).map(|i| Part::of((t[i] - at) / HALF_S, (t[i + 1] - t[i - 1]) / 2.0)).collect();
    let whole: f64 = parts.iter().map(|p| p.weight).sum();
    Some(Stretch {
        first,
        weights: parts.iter().map(|p| p.weight / whole).collect(),
        slope: parts.iter().map(|p| -p.first / (whole * HALF_S)).collect(),
        curvature: parts.iter().map(|p| p.second / (whole * HALF_S * HALF_S)).collect(),
    })
}

/// φ and its derivatives with respect to s at one sample, times the sample's interval.
struct Part {
    weight: f64,
    first: f64,
    second: f64,
}

impl Part {
    fn of(s: f64, interval_s: f64) -> Self {
        let rest = 1.0 - s * s;
        let cube = rest * rest * rest;
        Self {
            weight: interval_s * cube * rest * rest,
            first: interval_s * -10.0 * s * cube * rest,
            second: interval_s * 10.0 * cube * (9.0 * s * s - 1.0),
        }
    }
}

/// Σ wᵢ yᵢ over the stretch.
pub(crate) fn average(weights: &[f64], y: &[f64]) -> f64 {
    weights.iter().zip(y).map(|(w, y)| w * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(n: u32, step_s: f64) -> Vec<f64> {
        (0..n).map(|i| f64::from(i) * step_s).collect()
    }

    #[test]
    fn of_a_parabola_the_averages_are_its_value_slope_and_curvature() {
        let t = even(201, 1e-3);
        let y: Vec<f64> =
            t.iter().map(|t| 2.0 + 3.0 * (t - 0.1) + 5.0 * (t - 0.1) * (t - 0.1)).collect();
        let s = stretch(&t, 100).unwrap();
        let of = |weights: &[f64]| average(weights, &y[s.first..]);
        assert!((of(&s.slope) - 3.0).abs() < 1e-6, "{}", of(&s.slope));
        assert!((of(&s.curvature) - 10.0).abs() < 1e-4, "{}", of(&s.curvature));
        // the variance of φ is HALF_S² / 13
        assert!((of(&s.weights) - 2.0 - 5.0 * HALF_S * HALF_S / 13.0).abs() < 1e-6);
    }

    /// ∫ sin'' = −ω² ∫ sin, whatever the weights.
    #[test]
    fn of_a_sine_the_average_curvature_is_minus_omega_squared_times_the_average() {
        let t = even(600, 5e-3);
        let y: Vec<f64> = t.iter().map(|t| (9.0 * t).sin()).collect();
        for centre in [40, 41, 300] {
            let s = stretch(&t, centre).unwrap();
            let (value, curvature) =
                (average(&s.weights, &y[s.first..]), average(&s.curvature, &y[s.first..]));
            assert!((curvature + 81.0 * value).abs() < 2e-2, "{curvature} {value}");
        }
    }

    #[test]
    fn a_stretch_that_the_recording_does_not_cover_is_none() {
        let t = even(100, 5e-3);
        assert!(stretch(&t, 19).is_none() && stretch(&t, 80).is_none());
        let inside = stretch(&t, 20).unwrap();
        assert_eq!((inside.first, inside.weights.len()), (1, 39));
    }
}
