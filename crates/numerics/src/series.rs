//! Sampled signals: interpolation, integrals, derivatives, threshold crossings, loop area.
//!
//! `t` (or `x`) is strictly increasing unless stated otherwise; its unit and that of `y` are the
//! caller's.

use crate::error::{NumericsError, same_length};
use crate::wide::widest;

/// Value of the polyline through (tᵢ, yᵢ) at `at`; `None` outside [t₀, tₙ₋₁] or for an empty series
/// (there is no extrapolation). At a sample it is that sample, exactly.
pub fn interpolate(t: &[f64], y: &[f64], at: f64) -> Option<f64> {
    interpolate_by(t.len().min(y.len()), |i| t[i], |i| y[i], at)
}

/// [`interpolate`] with times and values that a rule gives for each of this many samples: only
/// values beside `at` are requested.
pub fn interpolate_by(
    samples: usize,
    t: impl Fn(usize) -> f64,
    y: impl Fn(usize) -> f64,
    at: f64,
) -> Option<f64> {
    // The first sample that is not before `at`, by halving.
    let mut after = 0;
    let mut end = samples;
    while after < end {
        let middle = after + (end - after) / 2;
        if t(middle) < at { after = middle + 1 } else { end = middle }
    }
    (after < samples).then(|| interpolated(t, y, at, after)).flatten()
}

/// The polyline's value at `at`, of which `after` is the first sample that is not before it.
fn interpolated(
    t: impl Fn(usize) -> f64,
    y: impl Fn(usize) -> f64,
    at: f64,
    after: usize,
) -> Option<f64> {
    let t1 = t(after);
    let y1 = y(after);
    if t1 <= at {
        // A sample's own time: arithmetic would blur its value.
        return Some(y1);
    }
    let before = after.checked_sub(1)?;
    let t0 = t(before);
    let y0 = y(before);
    Some(y0 + (at - t0) / (t1 - t0) * (y1 - y0))
}

/// So many even points over all that every one of these rising courses covers; `None` if that is nothing. The last is
/// never beyond the shortest course, where rounding could put it. Unit as theirs.
pub fn common_grid<'a>(
    courses: impl Iterator<Item = &'a [f64]>,
    points: usize,
) -> Option<Vec<f64>> {
    let [mut low, mut high] = [f64::NEG_INFINITY, f64::INFINITY];
    for course in courses {
        low = low.max(*course.first()?);
        high = high.min(*course.last()?);
    }
    let at = |i: usize| (low + (high - low) * (i as f64 / (points - 1) as f64)).min(high);
    (low < high && low.is_finite()).then(|| (0..points).map(at).collect())
}

/// [`interpolate`] at every point of `grid`, in its order; it is faster if fewer samples lie
/// between successive points.
pub fn interpolate_all(t: &[f64], y: &[f64], grid: &[f64]) -> Vec<Option<f64>> {
    // Samples that are compared one by one before halving, which pays only where points are far
    // apart.
    const STEPS: usize = 8;
    let samples = t.len().min(y.len());
    let mut after = 0;
    let mut values = Vec::with_capacity(grid.len());
    for &at in grid {
        // A point before the one of the last round lies behind: search from the first sample again.
        let is_ahead = after == 0 || t[after - 1] < at;
        after = if is_ahead { after } else { 0 };
        // The first sample that is not before the point: nearby, or by halving what is left.
        let near = t[after..samples].iter().take(STEPS).take_while(|t| **t < at).count();
        after += near;
        if near == STEPS {
            after += t[after..samples].partition_point(|t| *t < at);
        }
        let is_within = after < samples;
        values.push(is_within.then(|| interpolated(|i| t[i], |i| y[i], at, after)).flatten());
    }
    values
}

/// ∫ y dt by the trapezoidal rule, unit of `y` times unit of `t`; 0 for fewer than two samples.
///
/// # Errors
/// Unequal lengths.
pub fn trapezoid(t: &[f64], y: &[f64]) -> Result<f64, NumericsError> {
    same_length("y", t.len(), y.len())?;
    let steps = t.windows(2).zip(y.windows(2));
    Ok(steps.fold(0.0, |sum, (t, y)| sum + (t[1] - t[0]) * (y[0] + y[1]) / 2.0))
}

/// ∫ y dt from the first sample to each sample, by the trapezoidal rule; as long as `t`, starting
/// with 0.
///
/// # Errors
/// Unequal lengths.
pub fn cumulative_trapezoid(t: &[f64], y: &[f64]) -> Result<Vec<f64>, NumericsError> {
    same_length("y", t.len(), y.len())?;
    let mut sum = 0.0;
    let mut integral = Vec::with_capacity(t.len());
    integral.extend(t.first().map(|_| 0.0));
    for (t, y) in t.windows(2).zip(y.windows(2)) {
        sum += (t[1] - t[0]) * (y[0] + y[1]) / 2.0;
        integral.push(sum);
    }
    Ok(integral)
}

/// dy/dt at every sample of an uneven grid: [`central_slope`] inside, the slope of the end segment
/// at either end (first order). As long as `t`; a single sample has no slope and gives an empty
/// vector.
///
/// This is the derivative of samples as they are. If they are counts of a sensor, whose steps it
/// would show, [`crate::local`] gives the derivative of parabolas through many samples.
///
/// # Errors
/// Unequal lengths.
pub fn central_differences(t: &[f64], y: &[f64]) -> Result<Vec<f64>, NumericsError> {
    same_length("y", t.len(), y.len())?;
    if t.len() < 2 {
        return Ok(Vec::new());
    }
    let last = t.len() - 1;
    let mut slopes = Vec::with_capacity(t.len());
    slopes.push(slope(t, y, 0));
    slopes.extend((1..last).map(|i| central_slope(t, y, i)));
    slopes.push(slope(t, y, last - 1));
    Ok(slopes)
}

/// (yᵢ₊₁ − yᵢ) / (tᵢ₊₁ − tᵢ), the slope of the segment from sample `i` to the next, of which there
/// must be one.
pub fn slope(t: &[f64], y: &[f64], i: usize) -> f64 {
    (y[i + 1] - y[i]) / (t[i + 1] - t[i])
}

/// dy/dt at sample `i`, which must have one to either side: that of the parabola through the three,
/// (h₋ s₊ + h₊ s₋) / (h₋ + h₊), with h₋, h₊ the steps to either side and s₋, s₊ the slopes of the two
/// segments (Fornberg 1988, Math. Comp. 51:699). Second order on uneven times too, exactly 0 where
/// the three are equal.
pub fn central_slope(t: &[f64], y: &[f64], i: usize) -> f64 {
    let before = t[i] - t[i - 1];
    let after = t[i + 1] - t[i];
    (before * slope(t, y, i) + after * slope(t, y, i - 1)) / (before + after)
}

/// Signed area ∮ y dx enclosed by the path (xᵢ, yᵢ), closed from its last point to its first
/// (shoelace formula): positive if run clockwise. With displacement and resisting force it is the
/// energy taken from the user over the loop. `x` need not be ordered.
///
/// # Errors
/// Unequal lengths.
pub fn loop_area(x: &[f64], y: &[f64]) -> Result<f64, NumericsError> {
    same_length("y", x.len(), y.len())?;
    let (Some(&x0), Some(&y0), Some(&xn), Some(&yn)) = (x.first(), y.first(), x.last(), y.last())
    else {
        return Ok(0.0);
    };
    Ok(trapezoid(x, y)? + (x0 - xn) * (yn + y0) / 2.0)
}

/// Smallest and largest value, computed for every fourth value separately, so that the steps do not
/// wait for each other. Infinite, the wrong way round, if there is none; NaN is skipped.
pub fn ends(values: &[f64]) -> (f64, f64) {
    widest(
        #[inline(always)]
        || ends_by(values),
    )
}

#[inline(always)]
fn ends_by(values: &[f64]) -> (f64, f64) {
    let mut low = [f64::INFINITY; 4];
    let mut high = [f64::NEG_INFINITY; 4];
    let (whole, rest) = values.as_chunks::<4>();
    // Comparisons rather than `f64::min` and `max`, whose care for NaN costs instructions; a NaN is
    // skipped here too, since it is neither below nor above.
    let mut take = |lane: usize, v: f64| {
        low[lane] = if v < low[lane] { v } else { low[lane] };
        high[lane] = if v > high[lane] { v } else { high[lane] };
    };
    whole.iter().for_each(|four| (0..4).for_each(|lane| take(lane, four[lane])));
    rest.iter().for_each(|v| take(0, *v));
    (
        low.into_iter().fold(f64::INFINITY, f64::min),
        high.into_iter().fold(f64::NEG_INFINITY, f64::max),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [f64; 5] = [0.0, 0.5, 2.0, 3.0, 3.5];

    #[test]
    fn interpolation_is_exact_on_samples_and_lines_and_absent_outside() {
        let y = T.map(|t| 2.0 * t - 1.0);
        for (at, expected) in
            [(0.0, Some(-1.0)), (2.0, Some(3.0)), (1.0, Some(1.0)), (3.5, Some(6.0))]
        {
            assert_eq!(interpolate(&T, &y, at), expected);
        }
        assert_eq!(interpolate_all(&T, &y, &[-1e-9, 3.6, f64::NAN]), [None, None, None]);
        let many: Vec<f64> = (0..100).map(f64::from).collect();
        let grid = [3.5, 3.6, 90.0, 90.25, f64::NAN, 2.0, 99.0, 99.1, -1.0, 0.0, 50.5, 49.0];
        let one_by_one = grid.map(|at| interpolate(&many, &many, at));
        assert_eq!(interpolate_all(&many, &many, &grid), one_by_one);
        assert_eq!(interpolate(&[], &[], 0.0), None);
        assert_eq!(interpolate(&[1.0], &[7.0], 1.0), Some(7.0));
    }

    #[test]
    fn the_trapezoidal_rule_is_exact_for_lines_and_second_order_for_a_sine() {
        assert_eq!(trapezoid(&T, &T), Ok(3.5 * 3.5 / 2.0));
        assert_eq!(cumulative_trapezoid(&T, &T).unwrap(), T.map(|t| t * t / 2.0));
        let error = |n: u32| {
            let t: Vec<f64> =
                (0..=n).map(|i| f64::from(i) * core::f64::consts::PI / f64::from(n)).collect();
            let y: Vec<f64> = t.iter().map(|&t| libm::sin(t)).collect();
            (trapezoid(&t, &y).unwrap() - 2.0).abs()
        };
        assert!((error(50) / error(100) - 4.0).abs() < 0.01);
        assert_eq!(trapezoid(&[], &[]), Ok(0.0));
    }

    #[test]
    fn central_differences_are_exact_for_a_parabola_on_an_uneven_grid() {
        let slope = central_differences(&T, &T.map(|t| t * t - 3.0 * t)).unwrap();
        for i in 1..4 {
            assert!((slope[i] - (2.0 * T[i] - 3.0)).abs() < 1e-14);
        }
        assert_eq!(central_differences(&T, &T).unwrap(), [1.0; 5]);
        assert!(central_differences(&[1.0], &[1.0]).unwrap().is_empty());
        assert!(central_differences(&T, &[1.0]).is_err());
    }

    #[test]
    fn loop_area_is_signed_and_closes_the_path() {
        let (x, y) = ([0.0, 0.0, 2.0, 2.0], [0.0, 3.0, 3.0, 0.0]);
        assert_eq!(loop_area(&x, &y), Ok(6.0));
        let reversed = |v: [f64; 4]| [v[3], v[2], v[1], v[0]];
        assert_eq!(loop_area(&reversed(x), &reversed(y)), Ok(-6.0));
        assert_eq!(loop_area(&[], &[]), Ok(0.0));
    }

    /// x = 2 cos φ, y = 0.5 sin φ encloses π; the inscribed polygon of n corners n/(2π) sin(2π/n)
    /// times that.
    #[test]
    fn the_area_of_an_ellipse_is_that_of_its_polygon() {
        let n = 360;
        let angle = |i: i32| f64::from(i) * core::f64::consts::TAU / f64::from(n);
        let (x, y): (Vec<_>, Vec<_>) =
            (0..n).map(|i| (2.0 * libm::cos(angle(i)), -0.5 * libm::sin(angle(i)))).unzip();
        assert!(
            (loop_area(&x, &y).unwrap() - f64::from(n) / 2.0 * libm::sin(angle(1))).abs() < 1e-12
        );
    }

    #[test]
    fn the_ends_of_a_series_are_found_wherever_they_stand() {
        for length in 1..=9 {
            for (lowest, highest) in (0..length).flat_map(|a| (0..length).map(move |b| (a, b))) {
                let mut values = vec![0.5; length];
                values[highest] = 2.0;
                values[lowest] = -3.0;
                let high =
                    if highest == lowest { if length == 1 { -3.0 } else { 0.5 } } else { 2.0 };
                assert_eq!(ends(&values), (-3.0, high), "{values:?}");
            }
        }
        assert_eq!(ends(&[]), (f64::INFINITY, f64::NEG_INFINITY));
        assert_eq!(ends(&[f64::NAN, 1.0]), (1.0, 1.0));
    }
}
