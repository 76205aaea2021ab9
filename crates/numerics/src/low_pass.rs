//! A low-pass without lag, and times at which unevenly sampled values can go through it.
//!
//! The filter is the usual one for recorded movements: Butterworth's of second order, once forwards
//! and once backwards, so that it is of fourth order and moves nothing in time (Winter 2009,
//! *Biomechanics and Motor Control of Human Movement*, 4th ed., on digital filtering). Each pass takes its share
//! of the cut-off, so both together are 3 dB down there.

use crate::order::median;
use crate::series::interpolate_all;

/// Winter's correction for two passes, (√2 − 1)^¼: each alone is cut off at 1/C times the cut-off.
const CORRECTION: f64 = 0.802_243_262_923_150_2;
/// Periods of the cut-off by which values are continued at both ends: what the filter does at its
/// beginning has then died away to 10⁻¹⁴.
const PERIODS: f64 = 6.0;
/// Even times are no closer than this share of the cut-off's period: more add nothing.
const FINEST: f64 = 0.01;
/// Between samples farther apart than this share of that period a curve is not known …
const GAP: f64 = 0.25;
/// … nor where they are farther apart than so many even times.
const GAP_STEPS: f64 = 5.0;

/// A low-pass without lag for values at a constant rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Of the numerator: b₀, b₁, b₂.
    b: [f64; 3],
    /// Of the denominator: a₁, a₂; a₀ is 1.
    a: [f64; 2],
    /// Values by which both ends are continued.
    padding: usize,
    /// tan(π f / rate) at which one pass is cut off.
    cut_off: f64,
}

impl LowPass {
    /// The filter that is 3 dB down at `cut_off_hz`, for values at `rate_hz`. `None` where the values
    /// come too slowly for it: then they hold nothing that it would take away.
    pub fn new(cut_off_hz: f64, rate_hz: f64) -> Option<Self> {
        // Half of the rate is where the tangent ends; one pass is cut off at a quarter more than both.
        let is_fast = cut_off_hz > 0.0 && rate_hz.is_finite() && 4.0 * cut_off_hz <= rate_hz;
        if !is_fast {
            return None;
        }
        let cut_off = libm::tan(core::f64::consts::PI * cut_off_hz / rate_hz) / CORRECTION;
        let squared = cut_off * cut_off;
        let gain = squared / (1.0 + core::f64::consts::SQRT_2 * cut_off + squared);
        let a1 = 2.0 * gain * (1.0 - 1.0 / squared);
        let a2 = 4.0 * gain - 1.0 - a1;
        let padding = (PERIODS * rate_hz / cut_off_hz).ceil() as usize;
        Some(Self { b: [gain, 2.0 * gain, gain], a: [a1, a2], padding, cut_off })
    }

    /// What both passes leave of a sine, as a share of its amplitude: 1 / (1 + (tan(π f / rate) / c)⁴).
    pub fn gain(&self, hz: f64, rate_hz: f64) -> f64 {
        let ratio = libm::tan(core::f64::consts::PI * hz / rate_hz) / self.cut_off;
        1.0 / (1.0 + ratio * ratio * ratio * ratio)
    }

    /// The values, filtered. Both ends are continued by their mirror image through the end value, so a
    /// straight line stays one to its ends.
    pub fn apply(&self, values: &[f64]) -> Vec<f64> {
        let (Some(first), Some(last)) = (values.first(), values.last()) else { return Vec::new() };
        let n = values.len();
        let padding = self.padding.min(n - 1);
        let before = values[1..=padding].iter().rev().map(|x| 2.0 * first - x);
        let after = values[n - 1 - padding..n - 1].iter().rev().map(|x| 2.0 * last - x);
        let mut all: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
        self.pass(all.iter_mut());
        self.pass(all.iter_mut().rev());
        all.drain(padding..padding + n).collect()
    }

    /// One pass, which begins as if its first value had stood there for ever (transposed direct form II).
    fn pass<'v>(&self, mut values: impl Iterator<Item = &'v mut f64>) {
        let [b0, b1, b2] = self.b;
        let [a1, a2] = self.a;
        let Some(value) = values.next() else { return };
        // The state in which a constant leaves the filter as it came.
        let mut z2 = (b2 - a2) * *value;
        let mut z1 = (b1 - a1) * *value + z2;
        let rest = std::iter::once(value).chain(values);
        for value in rest {
            let x = *value;
            let y = b0 * x + z1;
            z1 = b1 * x - a1 * y + z2;
            z2 = b2 * x - a2 * y;
            *value = y;
        }
    }
}

/// Even times within a series of samples, in stretches without a gap.
#[derive(Debug, Clone, PartialEq)]
pub struct EvenTimes {
    /// Times of each stretch, in the unit of `t`.
    stretches: Vec<Vec<f64>>,
    /// The first and the last sample of each stretch.
    samples: Vec<[usize; 2]>,
    /// From one even time to the next.
    step: f64,
}

impl EvenTimes {
    /// The even times for values at the rising times `t`, which a low-pass with that cut-off is to go
    /// through: as far apart as the samples usually are, but no closer than a hundredth of the
    /// cut-off's period. Where samples are farther apart than a quarter of that period, and than five
    /// of these steps, a stretch ends. `None` for fewer than two samples.
    pub fn of(t: &[f64], cut_off_hz: f64) -> Option<Self> {
        let intervals: Vec<f64> = t.windows(2).map(|t| t[1] - t[0]).collect();
        let step = median(intervals)?.max(FINEST / cut_off_hz);
        if !(step.is_finite() && step > 0.0) {
            return None;
        }
        let widest = (GAP / cut_off_hz).max(GAP_STEPS * step);
        let mut stretches = Vec::new();
        let mut samples = Vec::new();
        let mut first = 0;
        for i in 1..=t.len() {
            if i < t.len() && t[i] - t[i - 1] <= widest {
                continue;
            }
            // A hair more, so that rounding does not lose the last sample of an even series.
            let steps = ((t[i - 1] - t[first]) / step + 1e-6) as usize;
            let even = (0..=steps).map(|k| (t[first] + k as f64 * step).min(t[i - 1]));
            stretches.push(even.collect());
            samples.push([first, i - 1]);
            first = i;
        }
        Some(Self { stretches, samples, step })
    }

    /// All of them.
    pub fn times(&self) -> Vec<f64> {
        self.stretches.concat()
    }

    /// How long the gaps between the stretches are together, within the times `from` and `to`.
    pub fn gaps(&self, from: f64, to: f64) -> f64 {
        let pairs = self.stretches.windows(2).filter_map(|pair| {
            let (ends, begins) = (pair[0].last()?, pair[1].first()?);
            Some((begins.min(to) - ends.max(from)).max(0.0))
        });
        pairs.sum()
    }

    /// The values `x` at the times `t` of which these are the even ones: by straight lines between
    /// samples, then through the low-pass, each stretch by itself.
    pub fn filtered(&self, t: &[f64], x: &[f64], cut_off_hz: f64) -> Vec<f64> {
        let low_pass = LowPass::new(cut_off_hz, 1.0 / self.step);
        let stretches = self.stretches.iter().zip(&self.samples);
        let filtered = stretches.flat_map(|(even, [first, last])| {
            let at = interpolate_all(&t[*first..=*last], &x[*first..=*last], even);
            // No even time lies outside of its stretch.
            let at: Vec<f64> = at.into_iter().flatten().collect();
            low_pass.map_or_else(|| at.clone(), |low_pass| low_pass.apply(&at))
        });
        filtered.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn close(found: f64, expect: f64, tolerance: f64) {
        assert!((found - expect).abs() <= tolerance, "{found} against {expect}");
    }

    /// `scipy.signal.butter(2, 2 / π · atan(tan(π 10 / 1000) / 0.80224…))` of SciPy 1.17.
    #[test]
    fn its_coefficients_are_butterworths() {
        let low_pass = LowPass::new(10.0, 1000.0).unwrap();
        let scipy = [
            0.001_451_863_366,
            0.002_903_726_733,
            0.001_451_863_366,
            -1.889_362_920,
            0.895_170_374,
        ];
        for (found, expect) in low_pass.b.into_iter().chain(low_pass.a).zip(scipy) {
            close(found, expect, 1e-8);
        }
        // A constant leaves it as it came.
        close(low_pass.b.iter().sum::<f64>() / (1.0 + low_pass.a[0] + low_pass.a[1]), 1.0, 1e-12);
    }

    #[test]
    fn a_sine_keeps_its_phase_and_the_stated_share_of_its_amplitude() {
        let (rate_hz, n) = (1000.0, 4000_u32);
        let low_pass = LowPass::new(10.0, rate_hz).unwrap();
        close(low_pass.gain(10.0, rate_hz), core::f64::consts::FRAC_1_SQRT_2, 1e-12);
        for hz in [1.0, 5.0, 10.0, 40.0] {
            let sine = |i: u32| libm::sin(core::f64::consts::TAU * hz * f64::from(i) / rate_hz);
            let filtered = low_pass.apply(&(0..n).map(sine).collect::<Vec<_>>());
            let gain = low_pass.gain(hz, rate_hz);
            for i in 1000..3000_u32 {
                close(filtered[i as usize], gain * sine(i), 1e-9);
            }
        }
    }

    #[test]
    fn a_straight_line_stays_one_to_its_ends() {
        let line: Vec<f64> = (0..500).map(|i| 3.0 + 0.01 * f64::from(i)).collect();
        for (cut_off_hz, rate_hz) in [(10.0, 100.0), (10.0, 1000.0), (2.0, 100.0)] {
            let filtered = LowPass::new(cut_off_hz, rate_hz).unwrap().apply(&line);
            for (found, expect) in filtered.iter().zip(&line) {
                close(*found, *expect, if cut_off_hz < 5.0 { 1e-9 } else { 1e-7 });
            }
        }
    }

    #[test]
    fn values_that_come_too_slowly_are_not_filtered() {
        assert_eq!(LowPass::new(10.0, 39.0), None);
        assert_eq!(LowPass::new(10.0, f64::INFINITY), None);
        let t = [0.0, 0.1, 0.2, 0.3];
        let even = EvenTimes::of(&t, 10.0).unwrap();
        assert_eq!(even.filtered(&t, &[1.0, 0.0, 5.0, 2.0], 10.0).len(), 4);
    }

    #[test]
    fn a_gap_ends_a_stretch_and_a_missing_sample_does_not() {
        let t: Vec<f64> = (0..300)
            .filter(|i| *i != 20 && !(100..=150).contains(i))
            .map(|i| f64::from(i) / 100.0)
            .collect();
        let even = EvenTimes::of(&t, 10.0).unwrap();
        assert_eq!(even.stretches.len(), 2);
        assert_eq!(even.times().len(), 100 + 149);
        close(even.gaps(0.0, 3.0), 0.52, 1e-9);
        close(even.gaps(0.0, 1.2), 0.21, 1e-9);
        close(even.gaps(2.0, 3.0), 0.0, 0.0);
        assert_eq!(EvenTimes::of(&[1.0], 10.0), None);
    }

    /// Few even times, whatever the samples' own.
    #[test]
    fn microseconds_beside_long_intervals_do_not_make_millions_of_times() {
        let mut t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-6).collect();
        t.extend((1..900).map(|i| f64::from(i) * 0.024));
        let even = EvenTimes::of(&t, 10.0).unwrap();
        assert!(even.times().len() < 25 * t.len());
        assert_eq!(even.times().len(), even.filtered(&t, &t, 10.0).len());
    }

    proptest! {
        #[test]
        fn every_series_gives_as_many_filtered_values_as_even_times_and_none_beyond_all_measure(
            steps in proptest::collection::vec(1e-6_f64..2.0, 1..80),
            values in proptest::collection::vec(-1.0_f64..1.0, 80),
            cut_off_hz in 0.1_f64..1000.0,
        ) {
            let mut t = vec![0.0];
            for step in steps {
                t.push(t[t.len() - 1] + step);
            }
            let even = EvenTimes::of(&t, cut_off_hz).unwrap();
            let filtered = even.filtered(&t, &values[..t.len()], cut_off_hz);
            prop_assert_eq!(filtered.len(), even.times().len());
            // The ends are continued by up to three times the range, and the filter overshoots by a few per cent.
            prop_assert!(filtered.iter().all(|value| value.abs() < 5.0));
        }
    }
}
