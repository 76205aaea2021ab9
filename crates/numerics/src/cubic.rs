//! Cubics through neighbouring samples: a smooth signal between samples that are far apart, and its
//! integral.

use crate::series::slope;

/// Fewest samples a cubic takes.
pub const SAMPLES: usize = 4;

/// Value at `at` of the cubic through the four samples (tᵢ, yᵢ) around it, by Lagrange's formula;
/// at the ends through the outermost four, beyond which it is an extrapolation. Its error is at
/// most 3/128 h⁴ |y''''| between even samples h apart. `None` for fewer than four samples. `t` is
/// strictly increasing and as long as `y`.
pub fn value(t: &[f64], y: &[f64], at: f64) -> Option<f64> {
    let last = t.len().min(y.len()).checked_sub(SAMPLES)?;
    let first = t.partition_point(|t| *t < at).saturating_sub(2).min(last);
    let t = &t[first..first + SAMPLES];
    let y = &y[first..first + SAMPLES];
    let terms = (0..SAMPLES).map(|i| {
        let others = (0..SAMPLES).filter(|j| *j != i);
        let weight: f64 = others.map(|j| (at - t[j]) / (t[i] - t[j])).product();
        weight * y[i]
    });
    Some(terms.sum())
}

/// ∫ y dt over each interval between samples: the trapezoid less h³/12 times the mean of the second
/// derivatives at its two ends, which are divided differences. Fourth order; one value fewer than
/// samples. At the outermost samples the second derivative counts as 0. `t` is strictly increasing
/// and as long as `y`.
pub fn integrals(t: &[f64], y: &[f64]) -> Vec<f64> {
    let intervals = (0..t.len().saturating_sub(1)).map(|i| {
        let h = t[i + 1] - t[i];
        let bends = bend(t, y, i) + bend(t, y, i + 1);
        h * (y[i] + y[i + 1]) / 2.0 - h * h * h / 12.0 * bends / 2.0
    });
    intervals.collect()
}

/// The second derivative at sample `i`, by divided differences; 0 at either end.
fn bend(t: &[f64], y: &[f64], i: usize) -> f64 {
    if i == 0 || i + 1 == t.len() {
        return 0.0;
    }
    2.0 * (slope(t, y, i) - slope(t, y, i - 1)) / (t[i + 1] - t[i - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [f64; 6] = [0.0, 0.5, 1.5, 2.0, 3.0, 3.5];

    #[test]
    fn a_cubic_comes_back_between_samples_and_at_them() {
        let cubic = |t: f64| 2.0 - t + 0.5 * t * t - 0.25 * t * t * t;
        for at in [0.0, 0.2, 1.0, 1.5, 2.7, 3.3, 3.5] {
            assert!((value(&T, &T.map(cubic), at).unwrap() - cubic(at)).abs() < 1e-14, "{at}");
        }
        assert_eq!(value(&T[..3], &T[..3], 1.0), None);
    }

    #[test]
    fn the_integrals_of_a_parabola_are_exact_inside() {
        let found = integrals(&T, &T.map(|t| 3.0 * t * t));
        for i in 1..4 {
            let expect = T[i + 1].powi(3) - T[i].powi(3);
            assert!((found[i] - expect).abs() < 1e-13, "{} instead of {expect}", found[i]);
        }
        assert!(integrals(&[1.0], &[1.0]).is_empty() && integrals(&[], &[]).is_empty());
    }

    #[test]
    fn the_integrals_of_a_sine_are_of_fourth_order() {
        let error = |n: u32| {
            let t: Vec<f64> = (0..=n).map(|i| 3.0 * f64::from(i) / f64::from(n)).collect();
            let y: Vec<f64> = t.iter().map(|t| libm::sin(*t)).collect();
            let (from, to) = (n as usize / 3, 2 * n as usize / 3);
            let sum: f64 = integrals(&t, &y)[from..to].iter().sum();
            (sum - (libm::cos(t[from]) - libm::cos(t[to]))).abs()
        };
        let ratio = error(60) / error(120);
        assert!((ratio - 16.0).abs() < 0.5, "{ratio}");
    }
}
