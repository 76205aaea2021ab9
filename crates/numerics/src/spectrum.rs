//! The content of a sampled signal in a band of frequencies; its samples need not be even.
//!
//! It uses the Fourier integral ∫ y e^(−2πift) dt at the recorded times ([`crate::fourier`]),
//! without resampling.

use crate::fourier::summed_squares;
use crate::wide::widest;
use core::f64::consts::PI;
use rayon::prelude::*;

/// Length of a segment of [`band_power`], s: its bins are 1 Hz wide.
const SEGMENT_S: f64 = 1.0;
/// Segments overlap by at least half, so that the window's weights add up nearly evenly (Welch
/// 1967).
const LARGEST_HOP_S: f64 = SEGMENT_S / 2.0;
/// Segments that are one core's: a short trial is not divided.
const TOGETHER: usize = 64;
/// ∫ w² dt of the Hann window over a segment of 1 s.
const HANN_POWER_S: f64 = 3.0 / 8.0;

/// What a signal does in a band of frequencies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandPower {
    /// Mean square of the signal's part in the band, unit of the signal squared.
    pub power: f64,
    /// Where the spectrum is highest in the band, Hz; `None` where it falls from the band's lower
    /// edge on: then the band holds the tail of something slower and no oscillation of its
    /// own.
    pub dominant_hz: Option<f64>,
    /// The highest frequency taken in, Hz: the band's upper end, or the last bin below the Nyquist
    /// frequency.
    pub top_hz: f64,
}

/// Power and dominant frequency of `y` (at the times `t`, s) from `low_hz` to `high_hz`, by Welch's
/// method (1967, IEEE Trans. Audio Electroacoust. 15:70).
///
/// Segments of 1 s, evenly spread with an overlap of at least half, each without its straight line
/// and under a Hann window; the mean of their one-sided periodograms, power = Σ 2 |Y|² / (⅜ s · 1
/// s) over the bins of 1 Hz. The dominant frequency lies between the highest bin and its higher
/// neighbour by the ratio of their amplitudes (Grandke 1983, IEEE Trans. Instrum. Meas. 32:350),
/// exact for a pure tone.
///
/// Frequencies at or above `nyquist_hz` are never looked at. `None` if that leaves nothing of the
/// band, if `t` spans less than 1 s, or where the signal is 0. `low_hz` and `high_hz` are whole
/// numbers of hertz.
pub fn band_power(
    t: &[f64],
    y: &[f64],
    nyquist_hz: f64,
    low_hz: usize,
    high_hz: usize,
) -> Option<BandPower> {
    let top = (low_hz..=high_hz).rfind(|f| (*f as f64) < nyquist_hz)?;
    // A bin more at either side, so that a peak at the band's edge has two neighbours.
    let below = low_hz.checked_sub(1)?;
    let bins = top + 3 - low_hz;
    let power = mean_periodogram(t, y, below, bins)?;
    let in_band = &power[1..bins - 1];
    let sum: f64 = in_band.iter().sum();
    let highest = (1..bins - 1).fold(1, |best, k| if power[k] > power[best] { k } else { best });
    // A spectrum that falls from the edge on has no peak of its own in the band.
    let is_peak = power[highest] > power[highest - 1];
    let peak_hz = (below + highest) as f64 + offset(&power, highest);
    (sum > 0.0).then(|| BandPower {
        power: sum,
        dominant_hz: is_peak.then(|| peak_hz.clamp(low_hz as f64, top as f64)),
        top_hz: top as f64,
    })
}

/// Power per bin, mean over the segments, from bin `first` on.
fn mean_periodogram(t: &[f64], y: &[f64], first: usize, count: usize) -> Option<Vec<f64>> {
    let start = *t.first()?;
    let length = t.last()? - t.first()?;
    if length < SEGMENT_S {
        return None;
    }
    let hops = ((length - SEGMENT_S) / LARGEST_HOP_S).ceil();
    let hop = if hops > 0.0 { (length - SEGMENT_S) / hops } else { 0.0 };
    let scale = 2.0 / (HANN_POWER_S * SEGMENT_S * (hops + 1.0));
    let mut mean = vec![0.0; count];
    let segments = hops as usize + 1;
    // Side by side, and added up in the order of time: the same bits on any number of cores.
    let groups = (0..segments.div_ceil(TOGETHER)).into_par_iter().map(|i| {
        let group = (i * TOGETHER..segments.min((i + 1) * TOGETHER)).map(|segment| {
            let from = start + segment as f64 * hop;
            let begin = t.partition_point(|t| *t < from);
            let end = t.partition_point(|t| *t <= from + SEGMENT_S);
            (&t[begin..end], windowed(&t[begin..end], &y[begin..end], from))
        });
        summed_squares(group, SEGMENT_S.recip(), first + count)
    });
    for squares in groups.collect::<Vec<_>>() {
        let squares = mean.iter_mut().zip(&squares[first..]);
        squares.for_each(|(mean, square)| *mean += scale * square);
    }
    Some(mean)
}

/// `y` without its least-squares line, under the Hann window of the segment that begins at `from`.
fn windowed(t: &[f64], y: &[f64], from: f64) -> Vec<f64> {
    widest(
        #[inline(always)]
        || windowed_by(t, y, from),
    )
}

#[inline(always)]
fn windowed_by(t: &[f64], y: &[f64], from: f64) -> Vec<f64> {
    let [t_mean, y_mean] = sums(t, y, |t, y| [t, y]).map(|sum| sum / t.len() as f64);
    let [tt, ty] = sums(t, y, |t, y| [(t - t_mean) * (t - t_mean), (t - t_mean) * (y - y_mean)]);
    let slope = if tt > 0.0 { ty / tt } else { 0.0 };
    let mut windowed = y.to_vec();
    for (y, t) in windowed.iter_mut().zip(t) {
        *y = (*y - y_mean - slope * (t - t_mean)) * hann(t - from);
    }
    windowed
}

/// The sums of some terms of all samples, of every fourth on their own: they do not wait for each
/// other.
#[inline(always)]
fn sums<const N: usize>(t: &[f64], y: &[f64], terms: impl Fn(f64, f64) -> [f64; N]) -> [f64; N] {
    let (t_whole, t_rest) = t.as_chunks::<4>();
    let (y_whole, y_rest) = y.as_chunks::<4>();
    let mut sums = [[0.0; 4]; N];
    for (t, y) in t_whole.iter().zip(y_whole) {
        for lane in 0..4 {
            let terms = terms(t[lane], y[lane]);
            (0..N).for_each(|i| sums[i][lane] += terms[i]);
        }
    }
    let rest = t_rest.iter().zip(y_rest).fold([0.0; N], |sum, (t, y)| {
        let terms = terms(*t, *y);
        std::array::from_fn(|i| sum[i] + terms[i])
    });
    std::array::from_fn(|i| {
        let [a, b, c, d] = sums[i];
        (a + b) + (c + d) + rest[i]
    })
}

/// The Hann window of a segment, `after_s` its beginning: 0 at both ends, 1 in the middle. It is
/// cos²(πu), u from −½ to ½, the cosine 1 − 2 sin²(πu/2), and that sine its series up to the term that
/// is below 1e-16.
#[inline(always)]
fn hann(after_s: f64) -> f64 {
    const TERMS: i32 = 8;
    let x = PI / 2.0 * (after_s / SEGMENT_S - 0.5);
    let xx = x * x;
    let sin = x
        * (1..=TERMS).rev().fold(1.0, |sum, n| {
            let share = f64::from(2 * n * (2 * n + 1)).recip();
            1.0 - xx * share * sum
        });
    let cos = 1.0 - 2.0 * sin * sin;
    cos * cos
}

/// How far a tone lies from its highest bin `k`, in bins: with r the amplitude of the higher
/// neighbour over that of the bin, ±(2r − 1) / (1 + r) for a Hann window.
fn offset(power: &[f64], k: usize) -> f64 {
    let before = power[k - 1];
    let after = power[k + 1];
    let ratio = (before.max(after) / power[k]).sqrt();
    let size = ((2.0 * ratio - 1.0) / (1.0 + ratio)).max(0.0);
    if after > before { size } else { -size }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(rate_hz: f64, length_s: f64) -> Vec<f64> {
        (0..=(rate_hz * length_s) as u32).map(|i| f64::from(i) / rate_hz).collect()
    }

    fn tone(t: &[f64], amplitude: f64, hz: f64) -> Vec<f64> {
        t.iter().map(|t| amplitude * libm::sin(core::f64::consts::TAU * hz * t + 0.3)).collect()
    }

    fn check(found: f64, expect: f64, tolerance: f64) {
        assert!((found - expect).abs() < tolerance, "{found} against {expect}");
    }

    #[test]
    fn the_window_is_that_of_hann() {
        for i in 0..=1000 {
            let u = f64::from(i) / 1000.0;
            check(hann(u), 0.5 - 0.5 * libm::cos(core::f64::consts::TAU * u), 5e-16);
        }
    }

    #[test]
    fn a_tone_has_half_its_squared_amplitude_and_its_own_frequency() {
        let t = times(1000.0, 3.0);
        for hz in [7.0, 12.3, 24.5, 48.0] {
            let found = band_power(&t, &tone(&t, 0.2, hz), 500.0, 5, 50).unwrap();
            check(found.power, 0.02, 2e-4);
            check(found.dominant_hz.unwrap(), hz, 0.02);
            check(found.top_hz, 50.0, 1e-12);
        }
    }

    #[test]
    fn uneven_samples_of_a_tone_tell_the_same() {
        let t: Vec<f64> = times(200.0, 2.4)
            .iter()
            .zip(0u32..)
            .map(|(t, i)| t + 1e-3 * f64::from(i * 7 % 5))
            .collect();
        let found = band_power(&t, &tone(&t, 1.0, 17.0), 100.0, 5, 50).unwrap();
        check(found.power, 0.5, 0.02);
        check(found.dominant_hz.unwrap(), 17.0, 0.02);
    }

    /// NumPy and SciPy: `welch(x, 100, window="hann", nperseg=100, noverlap=50, detrend="linear")`
    /// on the samples below, summed over 5 … 49 Hz. SciPy's line is that of 100 samples, ours
    /// of 101.
    #[test]
    fn the_power_is_that_of_scipys_welch() {
        let t = times(100.0, 2.0);
        let y: Vec<f64> =
            (0..201u32).map(|i| f64::from(i * i * 7 % 31) / 31.0 + f64::from(i) * 0.01).collect();
        let found = band_power(&t, &y, 50.0, 5, 50).unwrap();
        check(found.power, SCIPY_POWER, 2e-3 * SCIPY_POWER);
        check(found.top_hz, 49.0, 1e-12);
    }

    const SCIPY_POWER: f64 = 0.07021488104370745;

    #[test]
    fn a_smooth_movement_has_no_frequency_of_its_own_in_the_band() {
        let t = times(1000.0, 2.0);
        let y: Vec<f64> = t.iter().map(|t| 1.0 - libm::cos(core::f64::consts::PI * t)).collect();
        let found = band_power(&t, &y, 500.0, 5, 50).unwrap();
        assert_eq!(found.dominant_hz, None);
        assert!(found.power.sqrt() < 1e-3, "{}", found.power.sqrt());
    }

    #[test]
    fn nothing_is_said_above_the_nyquist_frequency_or_of_too_short_a_record() {
        let t = times(80.0, 2.0);
        let found = band_power(&t, &tone(&t, 1.0, 10.0), 40.0, 5, 50).unwrap();
        check(found.top_hz, 39.0, 1e-12);
        assert_eq!(band_power(&t, &tone(&t, 1.0, 10.0), 5.0, 5, 50), None);
        assert_eq!(band_power(&t[..80], &tone(&t, 1.0, 10.0)[..80], 40.0, 5, 50), None);
        assert_eq!(band_power(&t, &vec![0.0; t.len()], 40.0, 5, 50), None);
    }
}
