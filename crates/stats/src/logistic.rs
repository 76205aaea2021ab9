//! The cumulative logistic model of one set of answers that share their linear predictor η:
//! P(Y ≤ k) = F(θₖ − η), F(z) = 1 / (1 + e^(−z)).
//!
//! The probability of category k is F(a) − F(b) with a = θₖ − η, b = θₖ₋₁ − η. Its logarithm is
//! ln(1 − e^(b − a)) − ln(1 + e^(−a)) − ln(1 + e^b): no difference of nearly equal numbers, and η
//! in the last two terms only. So the log-likelihood of counts nₖ is, with Nⱼ = nⱼ + nⱼ₊₁,
//!
//! Σₖ nₖ ln(1 − e^(−(θₖ − θₖ₋₁))) + Σⱼ (nⱼ zⱼ − Nⱼ ln(1 + e^(zⱼ))), zⱼ = θⱼ − η,
//!
//! the first sum over the inner categories (of width θₖ − θₖ₋₁), the second over thresholds.

/// ln(1 + e^z) and F(z), exact to rounding for any z.
pub(crate) fn softplus_and_share(z: f64) -> (f64, f64) {
    // Of −|z|: of z it would overflow.
    let e = libm::exp(-z.abs());
    let share = if z >= 0.0 { 1.0 / (1.0 + e) } else { e / (1.0 + e) };
    (z.max(0.0) + libm::log1p(e), share)
}

/// ln(p / (1 − p)).
pub(crate) fn logit(p: f64) -> f64 {
    libm::log(p) - libm::log1p(-p)
}

/// Per threshold: nⱼ, answers in the category just below it, and Nⱼ, answers on either side.
pub(crate) fn by_threshold(counts: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let below = counts[..counts.len() - 1].to_vec();
    let beside = counts.windows(2).map(|w| w[0] + w[1]).collect();
    (below, beside)
}

/// n ln(1 − e^(−width)) of an inner category, with its first two derivatives by the width.
pub(crate) fn inner(count: f64, width: f64) -> [f64; 3] {
    // expm1, because neighbouring thresholds may be close.
    let odds = 1.0 / libm::expm1(width);
    [count * libm::log(-libm::expm1(-width)), count * odds, -count * odds * (1.0 + odds)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ln(F(a) − F(b)) by the sum over thresholds.
    fn log_probability(theta: &[f64], eta: f64, category: usize) -> f64 {
        let mut counts = vec![0.0; theta.len() + 1];
        counts[category] = 1.0;
        let (below, beside) = by_threshold(&counts);
        let thresholds: f64 = (0..theta.len())
            .map(|j| {
                let z = theta[j] - eta;
                below[j] * z - beside[j] * softplus_and_share(z).0
            })
            .sum();
        let widths: f64 = theta
            .windows(2)
            .zip(&counts[1..])
            .map(|(t, &n)| if n > 0.0 { inner(n, t[1] - t[0])[0] } else { 0.0 })
            .sum();
        thresholds + widths
    }

    #[test]
    fn probabilities_are_differences_of_shares_and_sum_to_one() {
        let theta = [-1.3, 0.2, 1.9];
        for eta in [-2.0, 0.0, 0.7] {
            let share = |j: usize| 1.0 / (1.0 + libm::exp(eta - theta[j]));
            let expect = [share(0), share(1) - share(0), share(2) - share(1), 1.0 - share(2)];
            for (k, p) in expect.iter().enumerate() {
                assert!((libm::exp(log_probability(&theta, eta, k)) - p).abs() < 1e-15);
            }
        }
    }

    /// F(a) − F(b) ≈ e^(−b) − e^(−a) far in the tail, where both shares round to 1.
    #[test]
    fn far_in_the_tails_logarithms_keep_their_digits() {
        let theta = [50.0, 51.0];
        let exact = -50.0 + libm::log1p(-libm::exp(-1.0));
        assert!((log_probability(&theta, 0.0, 1) - exact).abs() < 1e-13);
        assert!((log_probability(&theta, 1000.0, 0) + 950.0).abs() < 1e-12);
        assert!((log_probability(&[0.0, 1e-9], 0.0, 1) - libm::log(0.25e-9)).abs() < 1e-8);
    }

    #[test]
    fn the_slopes_of_an_inner_category_agree_with_differences() {
        for width in [0.01, 1.0, 20.0] {
            let h = 1e-5 * width;
            let [_, slope, bend] = inner(3.0, width);
            let (low, high) = (inner(3.0, width - h), inner(3.0, width + h));
            assert!(((high[0] - low[0]) / (2.0 * h) - slope).abs() < 1e-7 * (1.0 + slope.abs()));
            assert!(((high[1] - low[1]) / (2.0 * h) - bend).abs() < 1e-7 * (1.0 + bend.abs()));
        }
    }

    #[test]
    fn a_logit_is_undone_by_its_share() {
        for p in [1e-12, 0.3, 0.999] {
            assert!((softplus_and_share(logit(p)).1 / p - 1.0).abs() < 1e-14);
        }
    }
}
