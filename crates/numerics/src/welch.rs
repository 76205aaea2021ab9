//! Cross spectra of two signals over even samples, by Welch's method (1967, IEEE Trans. Audio
//! Electroacoust. 15:70).

use crate::fourier::{squared, transform, turns};
use core::f64::consts::TAU;

/// ρ²: squared correlation of the periodograms of two segments that overlap by half under a Hann
/// window; ρ = Σ wᵢ wᵢ₊ₙ⸝₂ / Σ wᵢ² = 1/6. Further segments share nothing.
const OVERLAP: f64 = 1.0 / 36.0;

/// Spectral densities of two signals, x and y, and between them: means over Hann windows of records
/// that overlap by half, each without its mean. One-sided, as SciPy's `welch` and `csd` have them.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossSpectra {
    rate_hz: f64,
    window: Vec<f64>,
    turns: Vec<[f64; 2]>,
    segments: usize,
    /// Σ over records of n + 2 (n − 1) ρ².
    spread: f64,
    xx: Vec<f64>,
    yy: Vec<f64>,
    xy: Vec<[f64; 2]>,
}

/// One frequency of [`CrossSpectra`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossPoint {
    /// f, Hz.
    pub frequency_hz: f64,
    /// S_xx, unit of x squared per Hz.
    pub xx: f64,
    /// S_yy.
    pub yy: f64,
    /// S_xy = mean of conj(X) Y: real and imaginary part.
    pub xy: [f64; 2],
}

impl CrossPoint {
    /// γ² = |S_xy|² / (S_xx S_yy): how much of y follows linearly from x, 0 to 1; 0 where either is
    /// 0.
    pub fn coherence(&self) -> f64 {
        let both = self.xx * self.yy;
        if both > 0.0 { (squared(self.xy) / both).min(1.0) } else { 0.0 }
    }
}

impl CrossSpectra {
    /// Segments of this many samples at a rate, Hz; none if the number is not a power of two of at
    /// least 8.
    pub fn new(rate_hz: f64, length: usize) -> Option<Self> {
        const LEAST: usize = 8;
        let bins = length / 2 + 1;
        // Periodic: the sample after the last would be the first again.
        let window = (0..length).map(|i| 0.5 - 0.5 * libm::cos(TAU * (i as f64 / length as f64)));
        (length.is_power_of_two() && length >= LEAST && rate_hz > 0.0).then(|| Self {
            rate_hz,
            window: window.collect(),
            turns: turns(length).into_owned(),
            segments: 0,
            spread: 0.0,
            xx: vec![0.0; bins],
            yy: vec![0.0; bins],
            xy: vec![[0.0; 2]; bins],
        })
    }

    /// Samples of a segment.
    pub fn length(&self) -> usize {
        self.window.len()
    }

    /// Adds the segments of a record: even samples of x and y, equally many. The remainder at its
    /// end does not count; a record shorter than a segment adds nothing.
    pub fn add(&mut self, x: &[f64], y: &[f64]) {
        let length = self.length();
        let pairs = x.windows(length).zip(y.windows(length)).step_by(length / 2);
        let mut n = 0;
        for (x, y) in pairs {
            let [x, y] = [x, y].map(|signal| {
                let mean = signal.iter().sum::<f64>() / signal.len() as f64;
                let windowed = signal.iter().zip(&self.window).map(|(y, w)| [(y - mean) * w, 0.0]);
                transform(windowed.collect(), &self.turns)
            });
            for (k, (x, y)) in x.iter().zip(&y).enumerate().take(self.xx.len()) {
                self.xx[k] += squared(*x);
                self.yy[k] += squared(*y);
                self.xy[k][0] += x[0] * y[0] + x[1] * y[1];
                self.xy[k][1] += x[0] * y[1] - x[1] * y[0];
            }
            n += 1;
        }
        self.segments += n;
        if n > 0 {
            self.spread += n as f64 + 2.0 * (n - 1) as f64 * OVERLAP;
        }
    }

    /// Segments so far.
    pub fn segments(&self) -> usize {
        self.segments
    }

    /// How many independent segments have the same variance of their mean: N² / Σ (n + 2 (n − 1)
    /// ρ²) over the records of n segments each, N together (Welch 1967).
    pub fn averages(&self) -> f64 {
        let n = self.segments as f64;
        if self.segments > 0 { n * n / self.spread } else { 0.0 }
    }

    /// The means, from frequency 0 to half the rate.
    pub fn points(&self) -> Vec<CrossPoint> {
        let power: f64 = self.window.iter().map(|w| w * w).sum();
        let whole = 1.0 / (self.rate_hz * power * self.segments.max(1) as f64);
        let last = self.xx.len() - 1;
        let points = (0..=last).map(|k| {
            // One-sided: every frequency but 0 and the highest has its negative twin's power too.
            let scale = if k == 0 || k == last { whole } else { 2.0 * whole };
            CrossPoint {
                frequency_hz: self.rate_hz * k as f64 / self.length() as f64,
                xx: scale * self.xx[k],
                yy: scale * self.yy[k],
                xy: self.xy[k].map(|part| scale * part),
            }
        });
        points.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(found: f64, expect: f64, tolerance: f64) {
        assert!((found - expect).abs() < tolerance, "{found} against {expect}");
    }

    /// x = cos, y = 3 cos a quarter of a turn later, on a bin: S_xy = 3 e^(−jπ/2) S_xx.
    #[test]
    fn a_tone_that_comes_later_turns_the_cross_spectrum_back() {
        let (rate_hz, length) = (128.0, 64);
        let mut spectra = CrossSpectra::new(rate_hz, length).unwrap();
        let angle = |i: u32| TAU * 10.0 * f64::from(i) / rate_hz;
        let x: Vec<f64> = (0..640).map(|i| libm::cos(angle(i))).collect();
        let y: Vec<f64> = (0..640).map(|i| 3.0 * libm::sin(angle(i))).collect();
        spectra.add(&x, &y);
        assert_eq!(spectra.segments(), 19);
        let at = spectra.points()[5];
        check(at.frequency_hz, 10.0, 1e-12);
        check(at.xy[0] / at.xx, 0.0, 1e-12);
        check(at.xy[1] / at.xx, -3.0, 1e-12);
        check(at.yy / at.xx, 9.0, 1e-12);
        check(at.coherence(), 1.0, 1e-12);
        // Its power, ½, lies in three bins.
        let power: f64 = spectra.points()[4..7].iter().map(|p| p.xx * rate_hz / 64.0).sum();
        check(power, 0.5, 1e-12);
    }

    /// SplitMix64, as numbers from −½ to ½: white, of variance 1/12.
    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = state;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        (0..n).map(|_| next()).collect()
    }

    #[test]
    fn white_noise_has_a_flat_density_and_its_mean_the_variance_that_averages_say() {
        let (rate_hz, length) = (100.0, 64);
        let mut ratio = 0.0;
        let runs = 400;
        for seed in 0..runs {
            let x = noise(seed + 1, 32 * 20);
            let mut spectra = CrossSpectra::new(rate_hz, length).unwrap();
            spectra.add(&x, &x);
            let points = spectra.points();
            // Away from the mean that is taken out, 1/12 / 50 Hz.
            let flat = 1.0 / 12.0 / 50.0;
            let inner = &points[3..30];
            let spread: f64 = inner.iter().map(|p| (p.xx / flat - 1.0) * (p.xx / flat - 1.0)).sum();
            ratio += spread / inner.len() as f64 * spectra.averages();
        }
        // 1 on average; each run tells it to a quarter.
        check(ratio / runs as f64, 1.0, 0.04);
    }

    #[test]
    fn what_is_no_power_of_two_and_what_is_too_short_is_none() {
        assert!(CrossSpectra::new(100.0, 100).is_none() && CrossSpectra::new(0.0, 64).is_none());
        let mut spectra = CrossSpectra::new(100.0, 64).unwrap();
        spectra.add(&[1.0; 63], &[1.0; 63]);
        assert_eq!((spectra.segments(), spectra.points()[3].coherence()), (0, 0.0));
    }
}
