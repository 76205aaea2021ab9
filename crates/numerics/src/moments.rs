//! Mean and variance of values.

/// Mean of values, and their squares about it, in two passes in the order of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// How many; of weighted values the sum of the weights.
    pub n: f64,
    /// Σ w x / n, unit as the values; NaN without values.
    pub mean: f64,
    /// Σ w (x − mean)², square of their unit.
    pub squares: f64,
}

impl Moments {
    /// Of values that count once each. A value that is not finite gives NaN: check before.
    pub fn of(values: &[f64]) -> Self {
        Self::about(values.len() as f64, values.iter().map(|x| (*x, 1.0)))
    }

    /// Of values with how often each is there.
    pub fn of_weighted(values: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        Self::about(values.clone().map(|(_, weight)| weight).sum(), values)
    }

    fn about(n: f64, values: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let mean = values.clone().map(|(x, weight)| x * weight).sum::<f64>() / n;
        let squares = values.map(|(x, weight)| weight * (x - mean) * (x - mean)).sum();
        Self { n, mean, squares }
    }

    /// The variance of the population that the values are a sample of, Σ w (x − mean)² / (n − 1);
    /// `None` for fewer than two.
    pub fn variance(&self) -> Option<f64> {
        (self.n > 1.0).then(|| self.squares / (self.n - 1.0))
    }

    /// The standard deviation, the root of [`Moments::variance`].
    pub fn sd(&self) -> Option<f64> {
        self.variance().map(f64::sqrt)
    }

    /// The variance of the values themselves, Σ w (x − mean)² / n; NaN without values.
    pub fn mean_square(&self) -> f64 {
        self.squares / self.n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// NumPy: `np.mean(v)`, `np.std(v, ddof=1)`, `np.var(v)`.
    #[test]
    fn mean_and_variances_are_those_of_numpy() {
        let found = Moments::of(&[4.1, 3.9, 4.4, 4.0, 4.6, 4.3]);
        assert!((found.mean - 4.216666666666667).abs() < 1e-15);
        assert!((found.sd().unwrap() - 0.26394443859772204).abs() < 1e-15);
        assert!((found.mean_square() - 0.05805555555555555).abs() < 1e-15);
    }

    #[test]
    fn a_weight_is_how_often_a_value_is_there() {
        let weighted = Moments::of_weighted([(3.0, 2.0), (-1.0, 1.0), (5.0, 1.0)].into_iter());
        assert_eq!(weighted, Moments::of(&[3.0, 3.0, -1.0, 5.0]));
    }

    #[test]
    fn one_value_has_no_variance_and_none_no_mean() {
        let one = Moments::of(&[2.5]);
        assert_eq!((one.mean, one.variance(), one.sd()), (2.5, None, None));
        assert!(Moments::of(&[]).mean.is_nan() && Moments::of(&[]).sd().is_none());
    }
}
