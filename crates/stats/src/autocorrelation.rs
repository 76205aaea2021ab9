//! Whether residuals still have structure: similar neighbours mean that the model misses something.

/// First-order autocorrelation of `segments` (stretches recorded without a break, in order):
/// Σ (eᵢ − ē)(eᵢ₋₁ − ē) / Σ (eᵢ − ē)², ē over all of them; pairs across a break do not count.
/// No unit; `None` if all values are equal or there are fewer than two.
pub fn lag1(segments: &[&[f64]]) -> Option<f64> {
    let n: usize = segments.iter().map(|s| s.len()).sum();
    let mean = segments.iter().copied().flatten().sum::<f64>() / n as f64;
    let products: f64 = segments
        .iter()
        .map(|s| s.windows(2).map(|w| (w[0] - mean) * (w[1] - mean)).sum::<f64>())
        .sum();
    let squares: f64 = segments.iter().copied().flatten().map(|e| (e - mean) * (e - mean)).sum();
    (n > 1 && squares > 0.0).then(|| products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NumPy: d = r − mean(r); sum(d[1:] d[:-1]) / sum(d²).
    #[test]
    fn the_autocorrelation_agrees_with_numpy() {
        let r = [0.5, 0.75, 0.25, -0.5, -1.0, -0.25, 0.5];
        assert!((lag1(&[&r]).unwrap() - 0.44800420168067223).abs() < 1e-15);
    }

    #[test]
    fn alternating_residuals_are_anticorrelated() {
        let r = [1.0, -1.0, 1.0, -1.0];
        assert_eq!(lag1(&[&r]), Some(-0.75));
    }

    #[test]
    fn pairs_across_a_break_do_not_count() {
        assert_eq!(lag1(&[&[1.0, -1.0], &[1.0, -1.0]]), Some(-0.5));
    }

    #[test]
    fn nothing_to_correlate_is_none() {
        for segments in [&[][..], &[&[1.0][..]][..], &[&[2.0, 2.0][..]][..]] {
            assert_eq!(lag1(segments), None);
        }
    }
}
