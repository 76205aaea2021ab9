//! Third-octave levels of a motion: amplitude of vibration by frequency band.

use std::f64::consts::{SQRT_2, TAU};

use zwidth_numerics::wide::dot;

/// No window of time in which a level is taken is shorter, s.
pub(super) const SHORTEST_S: f64 = 0.1;
/// Lengths of a window in inverse bandwidths: the lines of a Hann window then lie within a band.
const BANDWIDTHS: f64 = 2.0;
/// Exponents of the lowest and highest centre, 10^(n/10) Hz: 10 and 794 Hz. Below lies the slow
/// part.
const EXPONENTS: std::ops::RangeInclusive<i32> = 10..=29;

/// A third of an octave: centre 10^(n/10) Hz, edges a twentieth of a decade on both sides (IEC
/// 61260-1, base ten).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Band {
    pub(super) centre_hz: f64,
    from_hz: f64,
    to_hz: f64,
}

impl Band {
    pub(super) fn all() -> impl Iterator<Item = Self> {
        EXPONENTS.map(|n| {
            let n = f64::from(n);
            let [from_hz, centre_hz, to_hz] =
                [n - 0.5, n, n + 0.5].map(|n| libm::pow(10.0, n / 10.0));
            Self { centre_hz, from_hz, to_hz }
        })
    }

    /// Length of a window, in steps; a multiple of four, so that a quarter of a turn is a whole
    /// number of them.
    pub(super) fn window(&self, step_s: f64) -> usize {
        let length_s = SHORTEST_S.max(BANDWIDTHS / (self.to_hz - self.from_hz));
        4 * (length_s / (4.0 * step_s)).ceil().max(1.0) as usize
    }
}

/// Amplitudes in the bands whose windows are of one length.
pub(super) struct Levels {
    /// Length of a window, in steps.
    pub(super) length: usize,
    /// Hann's, over the root of its mean square.
    hann: Vec<f64>,
    pub(super) bands: Vec<BandLines>,
}

/// The lines of a band.
pub(super) struct BandLines {
    pub(super) centre_hz: f64,
    lines: Vec<Line>,
}

/// A line of a discrete Fourier transform, of what is symmetric about the middle of a window and of
/// what is not.
struct Line {
    cosine: Vec<f64>,
    sine: Vec<f64>,
    /// From its square in the differences to the mean square of the position.
    scale: f64,
}

impl Levels {
    /// All bands, those with windows of the same length together.
    pub(super) fn all(step_s: f64) -> Vec<Self> {
        let bands: Vec<Band> = Band::all().collect();
        let alike = bands.chunk_by(|a, b| a.window(step_s) == b.window(step_s));
        alike.map(|bands| Self::new(bands, step_s)).collect()
    }

    fn new(bands: &[Band], step_s: f64) -> Self {
        let n = bands[0].window(step_s);
        let cosine: Vec<f64> = (0..n).map(|i| libm::cos(TAU * i as f64 / n as f64)).collect();
        // The mean square of (1 − cos)/2 over a period is 3/8.
        let hann = cosine.iter().map(|c| 0.5 * (1.0 - c) / libm::sqrt(3.0 / 8.0)).collect();
        let line = |k: usize| {
            let frequency_hz = k as f64 / (n as f64 * step_s);
            let per_step = 2.0 * libm::sin(0.5 * TAU * frequency_hz * step_s);
            // sin x = cos(x + 3/4 of a turn)
            let turned = |quarters: usize| {
                (0..=n / 2).map(|i| cosine[(k * i + quarters * n / 4) % n]).collect()
            };
            let scale = 2.0 / (n as f64 * n as f64 * per_step * per_step);
            Line { cosine: turned(0), sine: turned(3), scale }
        };
        let lines = |band: &Band| {
            let [from, to] = [band.from_hz, band.to_hz]
                .map(|hz| ((hz * n as f64 * step_s).ceil() as usize).min(n.div_ceil(2)));
            BandLines { centre_hz: band.centre_hz, lines: (from.max(1)..to).map(line).collect() }
        };
        Self { length: n, hann, bands: bands.iter().map(lines).collect() }
    }

    /// Amplitude (zero to peak of a sine of the same power) of the position in a window, by band.
    /// Positions stand at the edges of the steps: one more than steps.
    ///
    /// The lines are those of the differences, of which one of a sine of amplitude a at f is
    /// 2 a sin(π f h): a slow motion leaks less of itself into them.
    pub(super) fn amplitudes(&self, position: &[f64]) -> Vec<f64> {
        let mut steps: Vec<f64> = position.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Less the straight line that fits best, whose ends would leak into every band.
        let n = steps.len() as f64;
        let middle = 0.5 * (n - 1.0);
        let mean = steps.iter().sum::<f64>() / n;
        let square = n * (n * n - 1.0) / 12.0;
        let slope = steps.iter().enumerate().map(|(i, x)| (i as f64 - middle) * x).sum::<f64>()
            / square.max(1.0);
        for (i, (x, weight)) in steps.iter_mut().zip(&self.hann).enumerate() {
            *x = (*x - (mean + slope * (i as f64 - middle))) * weight;
        }
        // Cosines are the same on both sides of the middle, and sines are opposite.
        let half = steps.len() / 2;
        let mut even = steps[..=half].to_vec();
        let mut odd = vec![0.0; half + 1];
        for i in 1..half {
            let mirrored = steps[steps.len() - i];
            even[i] += mirrored;
            odd[i] = steps[i] - mirrored;
        }
        let amplitude = |band: &BandLines| {
            let squares = band.lines.iter().map(|line| {
                let (re, im) = (dot(&even, &line.cosine), dot(&odd, &line.sine));
                line.scale * (re * re + im * im)
            });
            SQRT_2 * libm::sqrt(squares.sum::<f64>())
        };
        self.bands.iter().map(amplitude).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.5e-3;

    fn band(near_hz: f64) -> Band {
        Band::all().find(|band| (band.from_hz..band.to_hz).contains(&near_hz)).unwrap()
    }

    /// The level of `position(t)` in the band around a frequency.
    fn level(near_hz: f64, position: impl Fn(f64) -> f64) -> f64 {
        let levels = Levels::new(&[band(near_hz)], STEP_S);
        let positions: Vec<f64> =
            (0..=levels.length).map(|i| position(i as f64 * STEP_S)).collect();
        levels.amplitudes(&positions)[0]
    }

    #[test]
    fn a_sine_in_the_middle_of_a_band_has_its_own_amplitude_and_a_band_further_off_none() {
        for centre_hz in Band::all().map(|band| band.centre_hz) {
            for phase in [0.0, 0.7, 2.0] {
                let sine = |t: f64| 3e-6 * (TAU * centre_hz * t + phase).sin();
                let found = level(centre_hz, sine);
                assert!((found / 3e-6 - 1.0).abs() < 0.04, "{centre_hz} Hz: {found}");
                let far = if centre_hz < 90.0 { 4.0 * centre_hz } else { 0.25 * centre_hz };
                let leak = level(far, sine);
                assert!(leak < 0.02 * 3e-6, "{centre_hz} Hz in {far} Hz: {leak}");
            }
        }
    }

    #[test]
    fn two_sines_of_a_band_add_their_powers() {
        let of = |a: f64, b: f64| {
            level(400.0, |t| a * (TAU * 370.0 * t).sin() + b * (TAU * 430.0 * t).sin())
        };
        assert!((of(3.0, 4.0) / 5.0 - 1.0).abs() < 0.05, "{}", of(3.0, 4.0));
    }

    #[test]
    fn a_movement_of_centimetres_leaves_less_than_a_tenth_of_a_micrometre_at_100_hz() {
        let slow = |t: f64| 0.02 * (TAU * 0.5 * t).sin();
        assert!(level(100.0, slow) < 1e-7, "{}", level(100.0, slow));
    }
}
