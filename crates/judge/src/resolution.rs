//! The smallest step between the values of a column, from the values alone.

use zwidth_numerics::order::sorted;

/// Fewer different values tell nothing.
const FEWEST: usize = 16;
/// Most decimals that are tried: of more digits a double has no more.
const DECIMALS: i32 = 12;
/// Relative rounding of a product of doubles.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Counts are looked for among so many values at most, and in steps of so many at most.
const MOST_COUNTED: usize = 100_000;
const MOST_STEPS: f64 = 1e6;

/// The smallest step between values, in their unit: that of their last decimal (as they are, or in
/// degrees), of a float of four bytes, of a sensor's counts, or else of a double. Fewer than 16
/// different values count as doubles: that a lever at rest has one angle says nothing about its
/// digits.
pub(crate) fn resolution(values: &[f64]) -> f64 {
    let largest = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
    let double = largest * f64::EPSILON;
    let mut different = sorted(values.iter().copied().take(MOST_COUNTED));
    different.dedup();
    if different.len() < FEWEST {
        return double;
    }
    let gaps = different.windows(2).map(|pair| pair[1] - pair[0]);
    // Different values are at least a step apart: small ones are no zeros.
    let most = gaps.fold(f64::INFINITY, f64::min) * (1.0 + 1e-3);
    let decimals = (0..=DECIMALS).find_map(|decimals| {
        let fine = libm::pow(10.0, f64::from(decimals));
        let mut scales = [1.0, 180.0 / std::f64::consts::PI].into_iter();
        let scale = scales.find(|scale| {
            1.0 / (fine * scale) <= most
                && values.iter().all(|value| is_whole(value * scale * fine))
        })?;
        Some(1.0 / (fine * scale))
    });
    #[allow(clippy::cast_possible_truncation, clippy::float_cmp)] // That is the question.
    let is_single = || values.iter().all(|value| f64::from(*value as f32) == *value);
    match decimals {
        Some(step) => step,
        None if is_single() => largest * f64::from(f32::EPSILON),
        None => counts(&different).unwrap_or(double),
    }
}

fn is_whole(value: f64) -> bool {
    (value - value.round()).abs() <= 1e-6 + ROUNDING * value.abs()
}

/// The step of which all steps between sorted values are multiples.
fn counts(sorted: &[f64]) -> Option<f64> {
    let steps = || sorted.windows(2).map(|pair| pair[1] - pair[0]);
    let step = steps().fold(f64::INFINITY, f64::min);
    let is_count = |more: f64| {
        let count = more / step;
        count <= MOST_STEPS && (count - count.round()).abs() < 1e-3 * count.sqrt()
    };
    steps().all(is_count).then_some(step)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn waves() -> Vec<f64> {
        (0..500).map(|i| 0.7 * (0.013 * f64::from(i)).sin()).collect()
    }

    fn check(change: impl Fn(f64) -> f64, expect: f64) {
        let values: Vec<f64> = waves().into_iter().map(change).collect();
        let found = resolution(&values);
        assert!((found / expect - 1.0).abs() < 0.01, "{found:e} for {expect:e}");
    }

    #[test]
    fn the_last_decimal_a_short_float_and_a_count_are_found() {
        check(|x| (x * 1e6).round() / 1e6, 1e-6);
        check(|x| (x * 1e3).round() / 1e3, 1e-3);
        check(|x| ((x.to_degrees() * 1e4).round() / 1e4).to_radians(), 1e-4_f64.to_radians());
        check(|x| f64::from(x as f32), 0.7 * f64::from(f32::EPSILON));
        let count = std::f64::consts::TAU / 4096.0 / 7.3;
        check(|x| (x / count).round() * count, count);
        check(|x| x, 0.7 * f64::EPSILON);
    }

    #[test]
    fn small_values_are_no_zeros() {
        let values: Vec<f64> = waves().into_iter().map(|x| 1e-16 * x).collect();
        assert!(resolution(&values) < 1e-30);
    }

    #[test]
    fn a_lever_at_rest_tells_nothing_about_its_digits() {
        assert!(resolution(&[0.5; 100]) < 1e-15);
        assert!(resolution(&[0.0; 100]) < 1e-300);
    }
}
