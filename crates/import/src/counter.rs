//! Columns that count samples or time, and the samples that they pass over.

use super::convert::median;
use zwidth_numerics::series::ends;

/// Fewest rows that show what a column counts.
const LEAST: usize = 20;
/// A column counts if it goes on by one and the same step in this share of its rows at least.
const STEADY: f64 = 0.8;
/// Times are steady within this share of their step.
const JITTER: f64 = 0.5;
/// A gap is told of so many samples, …
const LEAST_GAP: f64 = 5.0;
/// … or where this share of all samples is missing.
const LEAST_SHARE: f64 = 0.01;

/// From where to where counters of boards and clocks of a day count; the last two are micros() of an
/// Arduino in milliseconds and in seconds.
const COUNTERS: [[f64; 2]; 8] = [
    [0.0, 65_536.0],
    [-32_768.0, 32_768.0],
    [0.0, 16_777_216.0],
    [0.0, 4_294_967_296.0],
    [-2_147_483_648.0, 2_147_483_648.0],
    [0.0, 86_400.0],
    [0.0, 4_294_967.296],
    [0.0, 4_294.967_296],
];

/// Where a time starts over that falls from the end of a counter to its beginning: another trial would begin
/// anywhere.
pub(super) fn wrap_of(times: &[f64]) -> Option<f64> {
    let falls: Vec<&[f64]> = times.windows(2).filter(|t| t[1] < t[0]).collect();
    if falls.is_empty() {
        return None;
    }
    let near = 5.0 * median(times.windows(2).map(|t| (t[1] - t[0]).abs()).collect());
    let fits = |[low, high]: &[f64; 2]| {
        falls.iter().all(|fall| {
            let (before, after) = (high - fall[0], fall[1] - low);
            before >= 0.0 && after >= 0.0 && before + after <= near
        })
    };
    COUNTERS.iter().find(|ends| fits(ends)).map(|[low, high]| high - low)
}

/// Samples that a counter passes over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Gaps {
    /// In how many places.
    pub(super) places: usize,
    /// How many samples, if none of the gaps is longer than the counter counts.
    pub(super) samples: f64,
    longest: f64,
    all: f64,
}

impl Gaps {
    /// Whether there are so many that a result may depend on it.
    pub(super) fn matter(self) -> bool {
        self.longest >= LEAST_GAP || self.samples >= LEAST_SHARE * self.all
    }
}

/// The samples that unwrapped counts pass over, where one is `step`.
pub(super) fn gaps(counts: &[f64], step: f64) -> Gaps {
    let steps = counts.windows(2).map(|pair| ((pair[1] - pair[0]) / step).round() - 1.0);
    let missing: Vec<f64> = steps.filter(|missing| *missing > 0.0).collect();
    let samples: f64 = missing.iter().sum();
    let longest = missing.iter().copied().fold(0.0, f64::max);
    Gaps { places: missing.len(), samples, longest, all: counts.len() as f64 + samples }
}

/// What a column counts that the mapping does not take the time from: the samples it passes over, if it
/// counts samples or time at all.
pub(super) fn counted(values: &[f64]) -> Option<Gaps> {
    if values.len() < LEAST {
        return None;
    }
    let unwrapped = unwrapped(values)?;
    let mut steps: Vec<f64> = unwrapped.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let middle = steps.len() / 2;
    let step = *steps.select_nth_unstable_by(middle, f64::total_cmp).1;
    let is_steady = |s: &&f64| (**s - step).abs() <= JITTER * step;
    let steady = steps.iter().filter(is_steady).count() as f64;
    let counts =
        step > 0.0 && steps.iter().all(|s| *s > 0.0) && steady >= STEADY * steps.len() as f64;
    counts.then(|| gaps(&unwrapped, step))
}

/// A column that only grows, or starts over at 0 after a power of two.
fn unwrapped(values: &[f64]) -> Option<Vec<f64>> {
    let falls = values.windows(2).filter(|pair| pair[1] < pair[0]).count();
    if falls == 0 {
        return Some(values.to_vec());
    }
    let (low, high) = ends(values);
    let wrap = high + 1.0;
    let is_counter = low == 0.0
        && values.iter().all(|value| value.fract() == 0.0)
        && wrap.log2().fract() == 0.0
        && falls as f64 <= 2.0 * values.len() as f64 / wrap + 1.0;
    if !is_counter {
        return None;
    }
    let mut turns = 0.0;
    let mut before = values[0];
    Some(Vec::from_iter(values.iter().map(|value| {
        turns += f64::from(u8::from(*value < before));
        before = *value;
        value + turns * wrap
    })))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_or_a_clock_shows_what_is_missing_and_other_columns_show_nothing() {
        let counter = |lost: std::ops::Range<u32>| -> Vec<f64> {
            (0..300).filter(|n| !lost.contains(n)).map(|n| f64::from(n % 16)).collect()
        };
        let found = counted(&counter(100..110)).unwrap();
        assert!((found.places, found.samples) == (1, 10.0) && found.matter());
        assert!(!counted(&counter(100..101)).unwrap().matter());
        let clock: Vec<f64> = counter(0..0)
            .iter()
            .enumerate()
            .map(|(i, n)| 0.01 * i as f64 + 1e-4 * n + if i > 200 { 1.0 } else { 0.0 })
            .collect();
        assert!(counted(&clock).unwrap().matter());
        let swing: Vec<f64> = (0..300).map(|i| libm::sin(0.1 * f64::from(i))).collect();
        assert_eq!(counted(&swing), None);
        let ramp: Vec<f64> = (0..300).map(|i| f64::from(i.min(300 - i))).collect();
        assert_eq!(counted(&ramp), None);
    }
}
