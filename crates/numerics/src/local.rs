//! First and second derivative of a sampled signal, by parabolas through its neighbourhoods, as far
//! as a sensor's counts show them. [`crate::series::central_differences`] gives the derivative of
//! the samples as they are; the two differ in definition, and results of both are stored.

use crate::error::{NumericsError, same_length};

/// Fewest samples to either side of a neighbourhood's middle, where the signal has them.
const LEAST_BESIDE: usize = 2;

/// Derivatives at every sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Derivatives {
    /// dy/dt, unit of y per unit of t.
    pub first: Vec<f64>,
    /// d²y/dt², unit of y per square of the unit of t.
    pub second: Vec<f64>,
}

/// dy/dt and d²y/dt² at every sample of an uneven grid: those of the parabola by least squares
/// through the samples within `half` of it, and through two to either side at least (Savitzky &
/// Golay 1964, Anal. Chem. 36:1627, on any grid). Exact for a parabola, and without lag inside; at
/// an end the parabola goes through what there is. A neighbourhood of fewer than three samples has
/// 0 for both.
///
/// # Errors
/// Unequal lengths.
pub fn derivatives(t: &[f64], y: &[f64], half: f64) -> Result<Derivatives, NumericsError> {
    same_length("y", t.len(), y.len())?;
    let mut derivator = Derivator::new(t, y, half);
    let (first, second) = (0..t.len()).map(|i| derivator.at(i)).unzip();
    Ok(Derivatives { first, second })
}

/// [`derivatives`] at sample `i` alone: dy/dt and d²y/dt². `t` and `y` are of one length, and `i` is
/// one of them.
fn derivatives_at(t: &[f64], y: &[f64], half: f64, i: usize) -> (f64, f64) {
    let before = t[..i].iter().rev().take_while(|at| **at >= t[i] - half).count();
    let after = t[i..].iter().take_while(|at| **at <= t[i] + half).count();
    let (low, high) = neighbourhood(i, i - before, i + after, t.len());
    let [slope, bend] = parabola(&t[low..high], &y[low..high], i - low);
    (slope, 2.0 * bend)
}

/// A neighbourhood with two samples to either side at least, where the signal has them.
fn neighbourhood(i: usize, low: usize, high: usize, samples: usize) -> (usize, usize) {
    (low.min(i.saturating_sub(LEAST_BESIDE)), high.max((i + LEAST_BESIDE + 1).min(samples)))
}

/// [`derivatives`] at single samples, in any order. Those of samples that are near each other share
/// their sums: neighbourhoods overlap, and the powers of their times are added up once, about one
/// origin, for every few samples.
pub struct Derivator<'a> {
    t: &'a [f64],
    y: &'a [f64],
    half: f64,
    /// Of times: 1 / half.
    scale: f64,
    stretch: Stretch,
    /// How many samples of the last neighbourhood came before its middle, and how many not: those of
    /// the next are about as many.
    reach: (usize, usize),
    /// The derivatives computed last, each after its sample; a sample's place is `i % KEPT`.
    recent: [(usize, (f64, f64)); KEPT],
}

/// Samples whose neighbourhoods share their sums: about as long as one of these of 1 kHz.
const STRETCH: usize = 48;

/// Samples whose derivatives are kept: a caller often needs a sample's again for its neighbour.
const KEPT: usize = 4;

/// No sample.
const NONE: usize = usize::MAX;

/// Sums about one origin over the neighbourhoods of a stretch of samples.
struct Stretch {
    number: usize,
    origin: (f64, f64),
    /// The first sample of the first neighbourhood.
    first: usize,
    /// Σ 1, x, x², x³, x⁴, y, x y, x² y of the samples before each, from that one on; none where the
    /// samples are not so dense that the sums keep their digits about another origin.
    sums: Vec<[f64; 8]>,
}

impl<'a> Derivator<'a> {
    /// Of `y` at the times `t`, of one length.
    pub fn new(t: &'a [f64], y: &'a [f64], half: f64) -> Self {
        let stretch = Stretch { number: NONE, origin: (0.0, 0.0), first: 0, sums: Vec::new() };
        let recent = [(NONE, (0.0, 0.0)); KEPT];
        Self { t, y, half, scale: half.recip(), stretch, reach: (0, 0), recent }
    }

    /// dy/dt and d²y/dt² at sample `i`, one of those that are there.
    pub fn at(&mut self, i: usize) -> (f64, f64) {
        let (sample, recent) = self.recent[i % KEPT];
        if sample == i {
            return recent;
        }
        if self.stretch.number != i / STRETCH {
            self.begin(i / STRETCH);
        }
        let derivatives = match self.stretch.sums.is_empty() {
            true => derivatives_at(self.t, self.y, self.half, i),
            false => self.by_sums(i),
        };
        self.recent[i % KEPT] = (i, derivatives);
        derivatives
    }

    fn begin(&mut self, number: usize) {
        let from = number * STRETCH;
        let to = (from + STRETCH).min(self.t.len());
        let middle = from + (to - from) / 2;
        let origin = (self.t[middle], self.y[middle]);
        self.stretch.number = number;
        self.stretch.origin = origin;
        self.stretch.sums.clear();
        // Sums that reach far beyond one neighbourhood are large, and their differences would lose
        // digits.
        let is_dense = self.t[to - 1] - self.t[from] <= 2.0 * self.half && to - from > 1;
        if is_dense {
            // Each neighbourhood's ends lie at or after those of the one before.
            let first = self.window(from).0;
            let last = self.window(to - 1).1;
            let scale = self.scale;
            let mut sum = [0.0; 8];
            self.stretch.first = first;
            self.stretch.sums.push(sum);
            let samples = self.t[first..last].iter().zip(&self.y[first..last]);
            self.stretch.sums.extend(samples.map(|(t, y)| {
                let x = (t - origin.0) * scale;
                let y = y - origin.1;
                let xx = x * x;
                let xy = x * y;
                let terms = [1.0, x, xx, x * xx, xx * xx, y, xy, x * xy];
                sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
                sum
            }));
        }
    }

    /// From which sample to which (exclusive) the neighbourhood of one goes.
    fn window(&mut self, i: usize) -> (usize, usize) {
        let t = self.t;
        let (before, after) = self.reach;
        let from = t[i] - self.half;
        let to = t[i] + self.half;
        // A sample is in its own, even where times do not rise.
        let low = end_of(t, |at| at < from, i.saturating_sub(before)).min(i);
        let high = end_of(t, |at| at <= to, i + after).max(i);
        self.reach = (i - low, high - i);
        neighbourhood(i, low, high, t.len())
    }

    fn by_sums(&mut self, i: usize) -> (f64, f64) {
        let (low, high) = self.window(i);
        let Stretch { origin, first, sums, .. } = &self.stretch;
        let [before, until] =
            [low, high].map(|end| sums[end.saturating_sub(*first).min(sums.len() - 1)]);
        let [n, s1, s2, s3, s4, m0, m1, m2] = std::array::from_fn(|k| until[k] - before[k]);
        let scale = self.scale;
        // The parabola about the origin, and its derivatives where the sample lies.
        let [slope, bend] = solved([n, s1, s2, s3, s4], [m0, m1, m2]);
        let at = (self.t[i] - origin.0) * scale;
        ((slope + 2.0 * bend * at) * scale, 2.0 * bend * scale * scale)
    }
}

/// How many times come before an end of them all: near a guess, or by halving.
fn end_of(t: &[f64], is_before: impl Fn(f64) -> bool, guess: usize) -> usize {
    let near = [guess, guess + 1, guess.saturating_sub(1)].into_iter().find(|end| {
        let last = end.checked_sub(1).map(|last| t.get(last).is_some_and(|at| is_before(*at)));
        last.unwrap_or(true) && t.get(*end).is_none_or(|at| !is_before(*at))
    });
    near.unwrap_or_else(|| t.partition_point(|at| is_before(*at)))
}

/// Samples that are added up side by side, so that a compiler can keep them in one register.
const LANES: usize = 4;

/// Slope, and half of the second derivative, of the parabola by least squares through samples, at
/// the one in the `middle`.
fn parabola(t: &[f64], y: &[f64], middle: usize) -> [f64; 2] {
    let t0 = t[middle];
    let y0 = y[middle];
    let reach = (t0 - t[0]).max(t[t.len() - 1] - t0);
    let scale = reach.recip();
    if t.len() < 3 || !scale.is_finite() {
        return [0.0; 2];
    }
    // x, x², x³, x⁴, then y, x y, x² y. Times are divided by the reach: powers of milliseconds
    // would make the determinant vanish.
    let mut sums = [[0.0; LANES]; 7];
    let mut add = |t: &[f64; LANES], y: &[f64; LANES]| {
        for lane in 0..LANES {
            let x = (t[lane] - t0) * scale;
            let y = y[lane] - y0;
            let xx = x * x;
            let xy = x * y;
            let terms = [x, xx, x * xx, xx * xx, y, xy, x * xy];
            (0..terms.len()).for_each(|i| sums[i][lane] += terms[i]);
        }
    };
    let (t_whole, t_rest) = t.as_chunks::<LANES>();
    let (y_whole, y_rest) = y.as_chunks::<LANES>();
    t_whole.iter().zip(y_whole).for_each(|(t, y)| add(t, y));
    // What fills the last ones up lies in the middle: it adds 0.
    let mut t_last = [t0; LANES];
    let mut y_last = [y0; LANES];
    t_last[..t_rest.len()].copy_from_slice(t_rest);
    y_last[..y_rest.len()].copy_from_slice(y_rest);
    add(&t_last, &y_last);
    let [s1, s2, s3, s4, m0, m1, m2] = sums.map(|[a, b, c, d]| (a + b) + (c + d));
    let [slope, bend] = solved([t.len() as f64, s1, s2, s3, s4], [m0, m1, m2]);
    [slope * scale, bend * scale * scale]
}

/// The second and third of the three unknowns of the normal equations, by Cramer's rule; 0 where
/// samples at fewer than three places leave them open.
fn solved([s0, s1, s2, s3, s4]: [f64; 5], [m0, m1, m2]: [f64; 3]) -> [f64; 2] {
    let determinant =
        s0 * (s2 * s4 - s3 * s3) - s1 * (s1 * s4 - s2 * s3) + s2 * (s1 * s3 - s2 * s2);
    if determinant <= f64::EPSILON {
        return [0.0; 2];
    }
    let slope = s0 * (m1 * s4 - s3 * m2) - m0 * (s1 * s4 - s3 * s2) + s2 * (s1 * m2 - m1 * s2);
    let bend = s0 * (s2 * m2 - m1 * s3) - s1 * (s1 * m2 - m1 * s2) + m0 * (s1 * s3 - s2 * s2);
    [slope / determinant, bend / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parabola_has_its_own_derivatives_on_any_grid_and_at_its_ends() {
        let t = [0.0, 0.5, 2.0, 3.0, 3.5, 5.0, 5.25];
        let found = derivatives(&t, &t.map(|t| 3.0 * t * t - 2.0 * t + 7.0), 0.6).unwrap();
        for (i, t) in t.iter().enumerate() {
            assert!((found.first[i] - (6.0 * t - 2.0)).abs() < 1e-10, "{found:?}");
            assert!((found.second[i] - 6.0).abs() < 1e-10, "{found:?}");
        }
    }

    /// Values every 1 ms with a step of 2 π / 4096 · 11 / 75, the prototype's count: half of it is
    /// the most an angle is off.
    #[test]
    fn counts_of_a_sensor_leave_derivatives_of_a_sine_within_a_hundredth() {
        let count = core::f64::consts::TAU / 4096.0 * 11.0 / 75.0;
        let t: Vec<f64> = (0..2000).map(|i| f64::from(i) * 1e-3).collect();
        let y: Vec<f64> = t.iter().map(|t| (libm::sin(3.0 * t) / count).round() * count).collect();
        let found = derivatives(&t, &y, 0.025).unwrap();
        for (i, t) in t.iter().enumerate().take(1970).skip(30) {
            assert!((found.first[i] - 3.0 * libm::cos(3.0 * t)).abs() < 0.01);
            assert!((found.second[i] + 9.0 * libm::sin(3.0 * t)).abs() < 0.6);
        }
    }

    /// In any order, and with gaps in the clock.
    #[test]
    fn samples_that_share_their_sums_have_the_derivatives_of_their_own_parabolas() {
        let jitter = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 20) * 1e-7;
        let gap = |i: u32| if i > 900 { 0.4 } else { 0.0 } + if i > 1500 { 0.03 } else { 0.0 };
        for step_s in [1e-3, 3e-4, 1.0 / 120.0] {
            let t: Vec<f64> =
                (0..3000).map(|i| 3.0 + f64::from(i) * step_s + jitter(i) + gap(i)).collect();
            let y: Vec<f64> =
                t.iter().zip(0..).map(|(t, i)| libm::sin(7.0 * t) + jitter(i)).collect();
            let mut derivator = Derivator::new(&t, &y, 0.025);
            for i in (0..3000).map(|i| i * 1009 % 3000).chain(0..3000).chain((0..3000).rev()) {
                let (found, expect) = (derivator.at(i), derivatives_at(&t, &y, 0.025, i));
                assert!((found.0 - expect.0).abs() < 1e-10, "{step_s}, {i}: {found:?}, {expect:?}");
                assert!((found.1 - expect.1).abs() < 1e-8, "{step_s}, {i}: {found:?}, {expect:?}");
            }
        }
    }

    #[test]
    fn times_that_do_not_rise_end_in_numbers_not_in_a_panic() {
        let falling: Vec<f64> = (0..200).map(|i| -f64::from(i) * 1e-3).collect();
        let wild: Vec<f64> = (0..200).map(|i| f64::from(i * 7919 % 200) * 1e-3).collect();
        for t in [falling, wild, vec![f64::NAN; 200]] {
            assert_eq!(derivatives(&t, &[1.0; 200], 0.025).unwrap().first.len(), 200);
        }
    }

    #[test]
    fn too_few_samples_have_no_derivatives_and_unequal_lengths_are_refused() {
        let found = derivatives(&[0.0, 1.0], &[0.0, 1.0], 1.0).unwrap();
        assert_eq!(found, Derivatives { first: vec![0.0; 2], second: vec![0.0; 2] });
        assert_eq!(derivatives(&[], &[], 1.0).unwrap(), Derivatives::default());
        assert!(derivatives(&[0.0], &[], 1.0).is_err());
    }
}
