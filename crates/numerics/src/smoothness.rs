//! How smooth a movement is, from the spectrum of its speed.

use crate::fourier::Spread;

/// Nothing of a hand's movement is sought above this, Hz (Balasubramanian 2015: ω_c,max = 20π
/// rad/s).
const CUTOFF_HZ: f64 = 10.0;
/// The spectrum ends where it stays below this share of its value at 0 Hz (there: V̄ = 0.05).
const AMPLITUDE: f64 = 0.05;
/// Zero padding: the spectrum is evaluated on 2⁴ times as many frequencies as the samples' own, as
/// the authors do.
const PADDING: usize = 16;
/// Fewest samples of a speed profile that has a shape.
const LEAST_SAMPLES: usize = 3;

/// Spectral arc length of a speed profile, SPARC: −∫₀^ωc √((1/ωc)² + (dV̂/dω)²) dω, V̂(ω) = |V(ω)|
/// /
/// |V(0)|, ωc the last frequency up to 10 Hz at which V̂ ≥ 0.05. Dimensionless and negative; the
/// nearer to −1 the smoother. It depends neither on the movement's size nor on its duration.
///
/// Balasubramanian, Melendez-Calderon, Roby-Brami & Burdet (2015), J. NeuroEng. Rehabil. 12:112.
/// The arc is that of the polyline through V̂ at steps of rate / (16 · 2^⌈log₂ n⌉), as in the
/// authors' own program. V by the trapezoidal rule at the recorded times; n log n. (Their program
/// sums the samples, the first and the last as whole ones, and takes their times for even. Of 1,000
/// made-up speeds 999 agree to 1 %; where a lobe of the spectrum peaks at about 0.05, ωc is another
/// one, and the values differ by up to 7 %.)
///
/// `t` in s, increasing, as long as `speed` (≥ 0, in any unit). `None` for fewer than 3 samples,
/// for samples that come slower than 20 a second (10 Hz is then beyond them), and for a speed that
/// is 0 throughout.
pub fn spectral_arc_length(t: &[f64], speed: &[f64]) -> Option<f64> {
    Smoothness::of(t, speed)?.spectral_arc_length()
}

/// What the smoothness of a movement rests on: far less than the movement itself, which can be
/// forgotten before its spectrum is made.
#[derive(Debug, Clone)]
pub struct Smoothness(Spread);

impl Smoothness {
    /// Of a velocity, whose sign does not count; `None` where [`spectral_arc_length`] has none for
    /// want of samples.
    pub fn of(t: &[f64], velocity: &[f64]) -> Option<Self> {
        let n = t.len().min(velocity.len());
        if n < LEAST_SAMPLES {
            return None;
        }
        let rate_hz = (n - 1) as f64 / (t[n - 1] - t[0]);
        if rate_hz < 2.0 * CUTOFF_HZ {
            return None;
        }
        let step_hz = rate_hz / (PADDING * n.next_power_of_two()) as f64;
        let count = (CUTOFF_HZ / step_hz) as usize + 1;
        Some(Self(Spread::new(&t[..n], &velocity[..n], f64::abs, step_hz, count)))
    }

    /// As [`spectral_arc_length`].
    pub fn spectral_arc_length(self) -> Option<f64> {
        arc_length(self.0.squared()).map(|arc| -arc)
    }
}

/// Length of the arc below the share of 0 Hz, up to the last frequency that counts; `None` where
/// there is none above 0 Hz.
fn arc_length(power: Vec<f64>) -> Option<f64> {
    let whole = *power.first()?;
    let share: Vec<f64> = power.into_iter().map(|p| (p / whole).sqrt()).collect();
    // Without any speed the shares are NaN, which is at or above nothing: `None`.
    let last = share.iter().rposition(|share| *share >= AMPLITUDE).filter(|last| *last > 0)?;
    let width = (last as f64).recip();
    let arc: f64 = share[..=last]
        .windows(2)
        .map(|w| (width * width + (w[1] - w[0]) * (w[1] - w[0])).sqrt())
        .sum();
    Some(arc)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fourier::squared_fourier;
    use core::f64::consts::TAU;

    /// Speed of a minimum-jerk way from 0 to 1 in unit time.
    fn minimum_jerk(s: f64) -> f64 {
        if (0.0..=1.0).contains(&s) { 30.0 * s * s * (1.0 - s) * (1.0 - s) } else { 0.0 }
    }

    fn times(rate_hz: f64, length_s: f64) -> Vec<f64> {
        (0..=(rate_hz * length_s) as u32).map(|i| f64::from(i) / rate_hz).collect()
    }

    /// `expect`: NumPy, written from the paper's equations: each V(ω) by `np.trapezoid(v *
    /// np.exp(-1j*w*(t-t[0])), t)`, then the sum over `np.diff`; where the samples are even,
    /// `np.fft.rfft(v, 16 * 2**ceil(log2(n)))` gives the same.
    fn check(t: &[f64], speed: impl Fn(f64) -> f64, expect: f64) {
        let v: Vec<f64> = t.iter().map(|t| speed(*t).abs()).collect();
        let found = spectral_arc_length(t, &v).unwrap();
        assert!((found / expect - 1.0).abs() < 1e-9, "{found} against {expect}");
    }

    #[test]
    fn arc_lengths_agree_with_an_independent_program() {
        let slow: Vec<f64> = times(1000.0, 1.0).iter().map(|t| 1.5 * t).collect();
        check(&slow, |t| minimum_jerk(t / 1.5), -1.4024260629108702);
        let t = times(200.0, 1.5);
        let wobbling = |t: f64| minimum_jerk(t / 1.5) * (1.0 + 0.3 * libm::sin(TAU * 5.0 * t));
        check(&t, wobbling, -1.9424526338637178);
        check(&t, |t| minimum_jerk(t / 0.8) + minimum_jerk((t - 0.7) / 0.8), -2.131994898959485);
        let uneven: Vec<f64> =
            t.iter().zip(0u32..).map(|(t, i)| t + 1e-3 * f64::from(i * 7 % 5)).collect();
        check(
            &uneven,
            |t| minimum_jerk(t / 1.6) + 0.2 * libm::sin(TAU * 3.0 * t),
            -1.7633349926919184,
        );
    }

    #[test]
    fn it_does_not_depend_on_how_far_and_how_fast() {
        let of = |size: f64, length_s: f64| {
            let t = times(2000.0 / length_s, length_s);
            let v: Vec<f64> = t.iter().map(|t| size * minimum_jerk(t / length_s)).collect();
            spectral_arc_length(&t, &v).unwrap()
        };
        assert!((of(1.0, 1.0) - of(7.0, 1.0)).abs() < 1e-12);
        assert!((of(1.0, 1.0) - of(1.0, 2.0)).abs() < 5e-3);
    }

    /// V by the sum itself, term by term.
    fn term_by_term(t: &[f64], speed: &[f64]) -> f64 {
        let n = t.len();
        let step_hz = (n - 1) as f64 / (t[n - 1] - t[0]) / (PADDING * n.next_power_of_two()) as f64;
        let power = squared_fourier(t, speed, step_hz, (CUTOFF_HZ / step_hz) as usize + 1);
        -arc_length(power).unwrap()
    }

    #[test]
    fn long_uneven_recordings_have_the_arc_length_of_the_sum_term_by_term() {
        for n in [64_u32, 1000, 3000, 20_000] {
            let t: Vec<f64> =
                (0..n).map(|i| f64::from(i) * 5e-3 + 1e-3 * f64::from(i * 7 % 5)).collect();
            let speed: Vec<f64> =
                t.iter().map(|t| (libm::sin(*t) + 0.3 * libm::sin(31.0 * t)).abs()).collect();
            let (found, expect) =
                (spectral_arc_length(&t, &speed).unwrap(), term_by_term(&t, &speed));
            assert!((found / expect - 1.0).abs() < 1e-9, "{n}: {found} against {expect}");
        }
    }

    /// |V|² as the authors' program has it (smoothness.py of siva82kb/SPARC): the plain sum over
    /// samples, whose times it takes for even.
    fn as_the_authors(speed: &[f64], rate_hz: f64) -> Vec<f64> {
        let step_hz = rate_hz / (PADDING * speed.len().next_power_of_two()) as f64;
        let at = |k: usize| {
            let angle = |i: usize| TAU * k as f64 * step_hz * i as f64 / rate_hz;
            let sum = |wave: fn(f64) -> f64| {
                speed.iter().enumerate().map(|(i, v)| v * wave(angle(i))).sum::<f64>()
            };
            let (re, im) = (sum(libm::cos), sum(libm::sin));
            re * re + im * im
        };
        (0..=(CUTOFF_HZ / step_hz) as usize).map(at).collect()
    }

    fn last_that_counts(power: &[f64]) -> usize {
        let share = |p: &f64| (p / power[0]).sqrt();
        power.iter().rposition(|p| share(p) >= AMPLITUDE).unwrap()
    }

    /// Three overlapping ways at 120 Hz that begin and end at a tenth of a peak's speed, with times
    /// that scatter by a tenth of a step: what the authors' program takes for even, and begins and
    /// ends with whole samples.
    #[test]
    fn the_authors_program_differs_by_percents_only_where_its_cutoff_is_another_one() {
        let mut seed = 12_345_u64;
        let mut uniform = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (seed >> 11) as f64 / (1_u64 << 53) as f64
        };
        let rate_hz = 120.0;
        let (mut near, mut elsewhere) = (0, 0);
        for _ in 0..1000 {
            let length_s = 0.4 + 1.2 * uniform();
            let t: Vec<f64> = (0..(rate_hz * length_s) as u32)
                .map(|i| (f64::from(i) + 0.2 * (uniform() - 0.5)) / rate_hz)
                .collect();
            let ways = [1.0, 0.5, 0.5].map(|size| {
                let (begins_s, lasts_s) = (length_s * 0.4 * uniform(), length_s * 0.6);
                (size * uniform(), begins_s, lasts_s)
            });
            let speed: Vec<f64> = t
                .iter()
                .map(|t| {
                    let moving = ways.iter().map(|(a, b, l)| a * minimum_jerk((t - b) / l));
                    0.1 + moving.sum::<f64>()
                })
                .collect();
            let rate_hz = (t.len() - 1) as f64 / (t[t.len() - 1] - t[0]);
            let theirs = as_the_authors(&speed, rate_hz);
            let step_hz = rate_hz / (PADDING * t.len().next_power_of_two()) as f64;
            let ours = squared_fourier(&t, &speed, step_hz, theirs.len());
            let cutoffs = [&ours, &theirs].map(|power| last_that_counts(power));
            let apart = arc_length(ours).unwrap() / arc_length(theirs).unwrap() - 1.0;
            if apart.abs() < 0.01 {
                near += 1;
            } else {
                let width = cutoffs[0].abs_diff(cutoffs[1]) as f64 * step_hz;
                elsewhere += usize::from(width > 0.2);
            }
        }
        assert!(near >= 990 && near + elsewhere == 1000, "{near} {elsewhere}");
    }

    #[test]
    fn what_has_no_shape_has_no_smoothness() {
        assert_eq!(spectral_arc_length(&[0.0, 0.1], &[0.0, 1.0]), None);
        assert_eq!(spectral_arc_length(&times(100.0, 1.0), &[0.0; 101]), None);
        assert_eq!(spectral_arc_length(&times(19.0, 1.0), &[1.0; 20]), None);
    }
}
