//! Third-octave levels of a motion: amplitude of vibration by frequency band.

use std::f64::consts::{SQRT_2, TAU};

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

/// Amplitudes in one band, for windows of one length.
pub(super) struct Levels {
    step_s: f64,
    /// Hann's, over the root of its mean square.
    hann: Vec<f64>,
    cosine: Vec<f64>,
    /// The lines of the band, from and to.
    lines: (usize, usize),
}

impl Levels {
    pub(super) fn new(band: &Band, step_s: f64) -> Self {
        let n = band.window(step_s);
        let cosine: Vec<f64> = (0..n).map(|i| libm::cos(TAU * i as f64 / n as f64)).collect();
        // The mean square of (1 − cos)/2 over a period is 3/8.
        let hann = cosine.iter().map(|c| 0.5 * (1.0 - c) / libm::sqrt(3.0 / 8.0)).collect();
        let [from, to] = [band.from_hz, band.to_hz]
            .map(|hz| ((hz * n as f64 * step_s).ceil() as usize).min(n.div_ceil(2)));
        Self { step_s, hann, cosine, lines: (from.max(1), to) }
    }

    /// Amplitude (zero to peak of a sine of the same power) of the position in the window that
    /// begins at the first step. Positions stand at the edges of the steps: one more than steps.
    ///
    /// The lines are those of the differences, of which one of a sine of amplitude a at f is
    /// 2 a sin(π f h): a slow motion leaks less of itself into them.
    pub(super) fn amplitude(&self, position: &[f64]) -> f64 {
        let mut steps: Vec<f64> = position.windows(2).map(|pair| pair[1] - pair[0]).collect();
        // Less the straight line that fits best, whose ends would leak into every band.
        let n = steps.len() as f64;
        let middle = 0.5 * (n - 1.0);
        let mean = steps.iter().sum::<f64>() / n;
        let square = n * (n * n - 1.0) / 12.0;
        let slope = steps.iter().enumerate().map(|(i, x)| (i as f64 - middle) * x).sum::<f64>()
            / square.max(1.0);
        for (i, x) in steps.iter_mut().enumerate() {
            *x -= mean + slope * (i as f64 - middle);
        }
        let windowed: Vec<f64> = steps.iter().zip(&self.hann).map(|(x, w)| x * w).collect();
        let n = self.cosine.len();
        let turned = |at: usize, by: usize| if at + by < n { at + by } else { at + by - n };
        // Mean square of the position on each line.
        let squares = (self.lines.0..self.lines.1).map(|k| {
            let mut re = 0.0;
            let mut im = 0.0;
            let mut at = 0;
            for x in &windowed {
                re += x * self.cosine[at];
                im += x * self.cosine[turned(at, 3 * n / 4)]; // sin x = cos(x + 3/4 of a turn)
                at = turned(at, k);
            }
            let frequency_hz = k as f64 / (n as f64 * self.step_s);
            let per_step = 2.0 * libm::sin(0.5 * TAU * frequency_hz * self.step_s);
            2.0 * (re * re + im * im) / (n as f64 * n as f64 * per_step * per_step)
        });
        SQRT_2 * libm::sqrt(squares.sum::<f64>())
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
        let band = band(near_hz);
        let n = band.window(STEP_S);
        let positions: Vec<f64> = (0..=n).map(|i| position(i as f64 * STEP_S)).collect();
        Levels::new(&band, STEP_S).amplitude(&positions)
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
