//! The Studentised range: the largest less the smallest of k means that do not differ, divided by an error with
//! its own degrees of freedom. Tukey's comparisons of all pairs rest on it.

use crate::error::{StatsError, check_level};
use core::f64::consts::{PI, SQRT_2};

/// The distribution for a number of means and degrees of freedom.
#[derive(Debug, Clone)]
pub struct StudentisedRange {
    means: f64,
    /// S and its share, node by node.
    errors: Vec<[f64; 2]>,
}

impl StudentisedRange {
    /// That of `means` independent means with `df` degrees of freedom, which may be infinite.
    ///
    /// # Errors
    /// Fewer than two means; degrees of freedom that are not positive.
    pub fn new(means: usize, df: f64) -> Result<Self, StatsError> {
        /// From here on S is 1 to 1e-8.
        const MANY: f64 = 1e8;
        if means < 2 || df.is_nan() || df <= 0.0 {
            return Err(StatsError::DegreesOfFreedom { df });
        }
        let errors = if df < MANY { errors(df) } else { vec![[1.0, 1.0]] };
        Ok(Self { means: means as f64, errors })
    }

    /// P(Q ≥ `q`) = E P(R ≥ q S) with S² = χ²(df) / df: of a difference of two means divided by its
    /// standard error, t, q is √2 |t|.
    pub fn upper_p(&self, q: f64) -> f64 {
        let tail = self.errors.iter().map(|[s, share]| share * self.range_beyond(q.abs() * s));
        tail.sum::<f64>().min(1.0)
    }

    /// The q with P(Q < q) = `level`.
    ///
    /// # Errors
    /// `level` outside (0, 1).
    pub fn critical_value(&self, level: f64) -> Result<f64, StatsError> {
        /// Shares of q that are left open.
        const OPEN: f64 = 1e-10;
        check_level(level)?;
        let mut low = 0.0;
        let mut high = 1.0;
        while self.upper_p(high) > 1.0 - level && high < f64::MAX / 2.0 {
            low = high;
            high *= 2.0;
        }
        while high - low > OPEN * high {
            let middle = f64::midpoint(low, high);
            match self.upper_p(middle) > 1.0 - level {
                true => low = middle,
                false => high = middle,
            }
        }
        Ok(f64::midpoint(low, high))
    }

    /// P(R ≥ r) of the range R of normal values with the largest at z: k ∫ φ(z) (Φ(z)^(k−1) − (Φ(z) −
    /// Φ(z − r))^(k−1)) dz, by the trapezoidal rule, which converges faster than any power of its
    /// step (Trefethen & Weideman 2014, SIAM Review 56:385).
    fn range_beyond(&self, r: f64) -> f64 {
        const STEP: f64 = 0.2;
        /// No density is left beyond.
        const FAR: f64 = 9.0;
        // Beyond 2 FAR nothing counts, whatever r is.
        let nodes = ((2.0 * FAR + r.min(2.0 * FAR)) / STEP) as u32;
        let parts = (0..=nodes).map(|node| {
            let z = f64::from(node) * STEP - FAR;
            let below = normal_below(z);
            let others = self.means - 1.0;
            // As a product, because the difference of powers has no digits far out.
            let beyond = -libm::expm1(others * libm::log1p(-normal_below(z - r) / below));
            libm::exp(-z * z / 2.0) * libm::pow(below, others) * beyond
        });
        self.means * STEP * parts.sum::<f64>() / (2.0 * PI).sqrt()
    }
}

/// The lattice of ln S, S² = χ²(df) / df: its density is exp(df (u − (e^{2u} − 1) / 2)) of its largest.
fn errors(df: f64) -> Vec<[f64; 2]> {
    /// Density, against its largest, that no longer counts: exp of this.
    const NOTHING: f64 = -100.0;
    let step = 0.2 / df.max(1.0).sqrt();
    let mut nodes = Vec::new();
    // 0 is on the right side alone.
    for (sign, first) in [(1.0, 0_u32), (-1.0, 1)] {
        for i in first.. {
            let u = sign * f64::from(i) * step;
            let log_density = df * (u - libm::expm1(2.0 * u) / 2.0);
            if log_density.is_nan() || log_density <= NOTHING {
                break;
            }
            nodes.push([libm::exp(u), libm::exp(log_density)]);
        }
    }
    let all: f64 = nodes.iter().map(|[_, share]| share).sum();
    nodes.iter_mut().for_each(|[_, share]| *share /= all);
    nodes
}

/// Φ(z).
fn normal_below(z: f64) -> f64 {
    libm::erfc(-z / SQRT_2) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::student_t::two_sided_p;

    /// SciPy 1.17: `studentized_range.sf(q, means, df)`, `ppf(0.95, means, df)`; that of infinitely many by R 4.2. R's
    /// `ptukey` has 7.424e-5 for the last of these, and loses its digits further out.
    #[test]
    fn tails_and_critical_values_are_those_of_scipy() {
        for (q, means, df, p, critical) in [
            (3.5, 3, 10.0, 0.0771033108386604, 3.87677674919156),
            (1.0, 3, 10.0, 0.764890810578798, 3.87677674919156),
            (9.0, 3, 10.0, 0.00021946634715663826, 3.876776750013158),
            (4.0, 6, 7.31, 0.15791059930594753, 5.2930289152750944),
            (5.2, 4, f64::INFINITY, 0.00134874088678727, 3.63315958179585),
            (20.0, 3, 5.0, 7.537024629367117e-05, 4.601726054362549),
        ] {
            let range = StudentisedRange::new(means, df).unwrap();
            let found = range.upper_p(q);
            assert!((found / p - 1.0).abs() < 1e-6, "{q} {means} {df}: {found}");
            let found = range.critical_value(0.95).unwrap();
            assert!((found / critical - 1.0).abs() < 1e-6, "{means} {df}: {found}");
        }
    }

    #[test]
    fn two_means_are_students_t() {
        for df in [1.0, 2.5, 10.0, 105.0, 20_000.0] {
            let range = StudentisedRange::new(2, df).unwrap();
            for t in [0.0, 0.3, 1.9, 6.0, 12.0, 21.2] {
                let p = two_sided_p(t, df).unwrap();
                let found = range.upper_p(t * SQRT_2);
                assert!((found - p).abs() <= 1e-8 * p, "{t} {df}: {found} {p}");
            }
        }
    }

    #[test]
    fn requests_that_cannot_be_meant_are_refused() {
        assert!(StudentisedRange::new(1, 5.0).is_err());
        for df in [0.0, -1.0, f64::NAN] {
            assert!(StudentisedRange::new(3, df).is_err());
        }
        assert!(StudentisedRange::new(3, 5.0).unwrap().critical_value(95.0).is_err());
    }
}
