//! First and second derivative of a sampled signal, by parabolas through its neighbourhoods.

use crate::error::{NumericsError, same_length};

/// Fewest samples to either side of a neighbourhood's middle, where the signal has them.
const LEAST_BESIDE: usize = 2;

/// Derivatives at every sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Derivatives {
    /// dy/dt, unit of y per unit of t.
    pub first: Vec<f64>,
    /// d²y/dt², unit of y per square of the unit of t.
    pub second: Vec<f64>,
}

/// dy/dt and d²y/dt² at every sample of an uneven grid: those of the parabola by least squares
/// through the samples within `half` of it, and through two to either side at least (Savitzky &
/// Golay 1964, Anal. Chem. 36:1627, on any grid). Exact for a parabola, and without lag inside; at
/// an end the parabola goes through what there is. A neighbourhood of fewer than three samples has
/// 0 for both.
///
/// # Errors
/// Unequal lengths.
pub fn derivatives(t: &[f64], y: &[f64], half: f64) -> Result<Derivatives, NumericsError> {
    same_length("y", t.len(), y.len())?;
    let (first, second) = (0..t.len()).map(|i| derivatives_at(t, y, half, i)).unzip();
    Ok(Derivatives { first, second })
}

/// [`derivatives`] at sample `i` alone: dy/dt and d²y/dt². `t` and `y` are of one length, and `i` is
/// one of them.
pub fn derivatives_at(t: &[f64], y: &[f64], half: f64, i: usize) -> (f64, f64) {
    let before = t[..i].iter().rev().take_while(|at| **at >= t[i] - half).count();
    let after = t[i..].iter().take_while(|at| **at <= t[i] + half).count();
    let low = i - before.max(LEAST_BESIDE.min(i));
    let high = (i + after).max((i + LEAST_BESIDE + 1).min(t.len()));
    let [slope, bend] = parabola(&t[low..high], &y[low..high], i - low);
    (slope, 2.0 * bend)
}

/// Slope, and half of the second derivative, of the parabola by least squares through samples, at
/// the one in the `middle`.
fn parabola(t: &[f64], y: &[f64], middle: usize) -> [f64; 2] {
    let reach = t.iter().map(|at| (at - t[middle]).abs()).fold(0.0, f64::max);
    let scale = reach.recip();
    if t.len() < 3 || !scale.is_finite() {
        return [0.0; 2];
    }
    let (mut sums, mut moments) = ([0.0; 5], [0.0; 3]);
    for (at, value) in t.iter().zip(y) {
        let x = (at - t[middle]) * scale;
        let powers = [1.0, x, x * x, x * x * x, x * x * x * x];
        sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += power);
        moments.iter_mut().zip(powers).for_each(|(m, power)| *m += power * (value - y[middle]));
    }
    let [slope, bend] = solved(sums, moments);
    [slope * scale, bend * scale * scale]
}

/// The second and third of the three unknowns of the normal equations, by Cramer's rule; 0 where
/// samples at fewer than three places leave them open.
fn solved([s0, s1, s2, s3, s4]: [f64; 5], [m0, m1, m2]: [f64; 3]) -> [f64; 2] {
    let determinant =
        s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
    if determinant <= f64::EPSILON {
        return [0.0; 2];
    }
    let slope = s0 * (m1 * s4 - s3 * m2) - m0 * (s1 * s4 - s3 * s2) + s2 * (s1 * m2 - m1 * s2);
    let bend = s0 * (s2 * m2 - m1 * s3) - s1 * (s1 * m2 - m1 * s2) + m0 * (s1 * s3 - s2 * s2);
    [slope / determinant, bend / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_own_derivatives_on_any_grid_and_at_its_ends() {
        let t = [0.0, 0.5, 2.0, 3.0, 3.5, 5.0, 5.25];
        let found = derivatives(&t, &t.map(|t| 3.0 * t * t - 2.0 * t + 7.0), 0.6).unwrap();
        for (i, t) in t.iter().enumerate() {
            assert!((found.first[i] - (6.0 * t - 2.0)).abs() < 1e-10, "{found:?}");
            assert!((found.second[i] - 6.0).abs() < 1e-10, "{found:?}");
        }
    }

    /// Values every 1 ms with a step of 2 π / 4096 · 11 / 75, the prototype's count: half of it is
    /// the most an angle is off.
    #[test]
    fn counts_of_a_sensor_leave_derivatives_of_a_sine_within_a_hundredth() {
        let count = core::f64::consts::TAU / 4096.0 * 11.0 / 75.0;
        let t: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1e-3).collect();
        let y: Vec<f64> = t.iter().map(|t| (libm::sin(3.0 * t) / count).round() * count).collect();
        let found = derivatives(&t, &y, 0.025).unwrap();
        for (i, t) in t.iter().enumerate().take(1970).skip(30) {
            assert!((found.first[i] - 3.0 * libm::cos(3.0 * t)).abs() < 0.01);
            assert!((found.second[i] + 9.0 * libm::sin(3.0 * t)).abs() < 0.6);
        }
    }

    #[test]
    fn too_few_samples_have_no_derivatives_and_unequal_lengths_are_refused() {
        let found = derivatives(&[0.0, 1.0], &[0.0, 1.0], 1.0).unwrap();
        assert_eq!(found, Derivatives { first: vec![0.0; 2], second: vec![0.0; 2] });
        assert_eq!(derivatives(&[], &[], 1.0).unwrap(), Derivatives::default());
        assert!(derivatives(&[0.0], &[], 1.0).is_err());
    }
}
