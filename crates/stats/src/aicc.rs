//! Akaike's information criterion with the small-sample correction.

/// AICc = n ln(rss / n) + 2k + 2k(k + 1) / (n − k − 1) for a least-squares fit to n independent
/// points (Hurvich & Tsai 1989, Biometrika 76:297), up to a constant of the data; smaller is
/// better.
///
/// `parameters` counts those of the curve; k adds one for the error variance. `None` where the
/// correction does not exist (n ≤ k + 1) or the fit is exact.
pub fn aicc(points: usize, rss: f64, parameters: usize) -> Option<f64> {
    let n = points as f64;
    let k = parameters as f64 + 1.0;
    let room = n - k - 1.0;
    (room > 0.0 && rss > 0.0).then(|| n * libm::log(rss / n) + 2.0 * k + 2.0 * k * (k + 1.0) / room)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_with_rss_equal_to_n_has_only_the_penalty() {
        assert_eq!(aicc(10, 10.0, 2), Some(6.0 + 24.0 / 6.0));
    }

    #[test]
    fn a_parameter_that_explains_nothing_costs() {
        assert!(aicc(20, 3.0, 3).unwrap() > aicc(20, 3.0, 2).unwrap());
    }

    #[test]
    fn too_few_points_or_an_exact_fit_have_none() {
        assert_eq!((aicc(4, 1.0, 2), aicc(9, 0.0, 2)), (None, None));
    }
}
