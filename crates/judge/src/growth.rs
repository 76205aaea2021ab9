//! Divergence: the error grows exponentially.

use crate::sides::Sides;

/// The last half of the trajectory is looked at, in so many windows.
const WINDOWS: usize = 8;
/// The error grows from the first of them to the last by this factor at least,
const LEAST: f64 = 30.0;
/// and from each to the next by factors whose logarithms are within these shares of their mean: a
/// jump of the error, or one that grows like a power of time, is no exponential.
const ALIKE: [f64; 2] = [0.5, 2.0];
/// In the end it is this share of the right motion's range at least.
const SHARE: f64 = 0.2;

/// The rate at which the error grows, 1/s, and when it exceeds the tolerance, s; none if it does
/// not grow exponentially, or stays below the tolerance.
pub(crate) fn growth(sides: &Sides<'_>, tolerance_rad: f64) -> Option<(f64, f64)> {
    let end_s = *sides.t_s.last()?;
    let edge = |k: usize| {
        let time = end_s * (0.5 + 0.5 * k as f64 / WINDOWS as f64);
        sides.t_s.partition_point(|t| *t < time)
    };
    let mut peaks = Vec::new();
    for k in 0..WINDOWS {
        let to = if k + 1 == WINDOWS { sides.len() } else { edge(k + 1) };
        let places = edge(k)..to;
        let largest = places.max_by(|a, b| sides.apart_rad(*a).total_cmp(&sides.apart_rad(*b)))?;
        peaks.push((sides.t_s[largest], sides.apart_rad(largest)));
    }
    let [first, last] = [peaks[0].1, peaks[WINDOWS - 1].1];
    let least_rad = tolerance_rad.max(SHARE * sides.right.range_rad());
    if last <= least_rad || first <= sides.unseen_rad() || last < LEAST * first {
        return None;
    }
    let steps: Vec<f64> = peaks.windows(2).map(|pair| libm::log(pair[1].1 / pair[0].1)).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    if !steps.iter().all(|step| (ALIKE[0] * mean..=ALIKE[1] * mean).contains(step)) {
        return None;
    }
    let n = WINDOWS as f64;
    let t_mean = peaks.iter().map(|(t, _)| t).sum::<f64>() / n;
    let products: f64 = peaks.iter().map(|(t, error)| (t - t_mean) * libm::log(*error)).sum();
    let squares: f64 = peaks.iter().map(|(t, _)| (t - t_mean) * (t - t_mean)).sum();
    let begin = (0..sides.len()).find(|i| sides.apart_rad(*i) > tolerance_rad)?;
    Some((products / squares, sides.t_s[begin]))
}
