//! Many frequencies at once of a long signal whose samples need not be even.
//!
//! The work of a Fourier sum, frequency by frequency, is the number of samples times the number of
//! frequencies, and both grow with a recording's length. Here the samples are spread onto an even
//! grid by a narrow Gaussian, the grid is transformed by a fast Fourier transform, and what the
//! Gaussian did to each frequency is divided out again (Greengard & Lee 2004, SIAM Rev. 46:443): n
//! log n, and the sum itself to about 1e-14 of ∫ |y| dt. Plain loops and `libm` give the same bits
//! on every processor.

use crate::wide::widest;
use core::f64::consts::{PI, TAU};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::OnceLock;

/// Cells to either side of a sample that its Gaussian reaches: e^(−π · 14 · 3/4) = 5e-15 is left
/// out.
const REACH: usize = 14;
/// Cells that are added to side by side, so that a compiler can keep them in one register.
const LANES: usize = 4;
/// Cells that a sample adds to.
const CELLS: usize = 2 * REACH;
/// Samples whose exponentials are worked out side by side.
const AT_ONCE: usize = 256;
/// Cells per period of the highest frequency, at least: half of that is by how much finer the grid
/// is than it must be.
const FINENESS: usize = 4;
/// The frequencies are those of so many transforms, at most, of a sixteenth of the grid's length: a
/// signal that fills no more than a sixteenth of it, as one that is padded with zeros 16 times, then
/// needs no more memory than itself. It is real, so that little more than half of them are made.
const PARTS: usize = 16;

/// A signal on the even grid: what is needed of it for its spectrum, in far less memory than a long
/// one takes itself.
///
/// The spectrum is |Y|² with Y(f) = ∫ y e^(−2πift) dt by the trapezoidal rule, at `count` frequencies
/// f = k `step_hz` from 0 on; unit of `y` squared times s². It is the sum itself within 1e-13 of (∫ |y|
/// dt)², in n log n.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    gaussian: Gaussian,
    grid: Vec<f64>,
}

impl Spread {
    /// `t` in s, increasing; `signal` makes y of `values`, of which there are as many.
    pub(crate) fn new(
        t: &[f64],
        values: &[f64],
        signal: impl Fn(f64) -> f64,
        step_hz: f64,
        count: usize,
    ) -> Self {
        let gaussian = Gaussian::new(count);
        let grid = gaussian.spread(t, values, signal, step_hz);
        Self { gaussian, grid }
    }

    /// |Y|² at its frequencies.
    pub(crate) fn squared(self) -> Vec<f64> {
        let Gaussian { length, count, .. } = self.gaussian;
        let parts = (length / self.grid.len()).next_power_of_two().min(PARTS);
        let turns = turns(length / parts);
        let mut power = vec![0.0; count];
        // A real signal has |Y(f)| = |Y(−f)|: the frequencies of one part are those of another one below 0.
        for part in 0..=parts / 2 {
            let spectrum = transform(folded(&self.grid, part, length, parts), &turns);
            let own = power.iter_mut().skip(part).step_by(parts);
            own.zip(&spectrum).for_each(|(power, y)| *power = squared(*y));
            if part > 0 {
                let others = power.iter_mut().skip(parts - part).step_by(parts);
                others.zip(spectrum.iter().rev()).for_each(|(power, y)| *power = squared(*y));
            }
        }
        self.gaussian.undo(&mut power);
        power
    }
}

/// The sum of the spectra of signals, each at its own times, as [`Spread`] has that of one.
pub(crate) fn summed_squares<'a>(
    signals: impl Iterator<Item = (&'a [f64], Vec<f64>)>,
    step_hz: f64,
    count: usize,
) -> Vec<f64> {
    let gaussian = Gaussian::new(count);
    let (length, turns) = (gaussian.length, turns(gaussian.length));
    let mut grids = signals.map(|(t, y)| gaussian.spread(t, &y, |y| y, step_hz));
    let mut power = vec![0.0; count];
    while let Some(one) = grids.next() {
        // Two real signals as the two parts of one that is complex: what they have in common in its |Z(f)|²
        // is gone from |Z(f)|² + |Z(−f)|².
        let mut both = vec![[0.0; 2]; length];
        for (part, grid) in [Some(one), grids.next()].into_iter().flatten().enumerate() {
            let cells = grid.chunks(length).flat_map(|cells| cells.iter().enumerate());
            cells.for_each(|(i, cell)| both[i][part] += cell);
        }
        let spectrum = transform(both, &turns);
        for (k, power) in power.iter_mut().enumerate() {
            *power += (squared(spectrum[k]) + squared(spectrum[(length - k) % length])) / 2.0;
        }
    }
    gaussian.undo(&mut power);
    power
}

/// e^(−a u²), u in cells.
#[derive(Debug, Clone)]
struct Gaussian {
    /// a = π (R − ½) / (R · reach), R the grid's fineness over what it must be: what is cut off and
    /// what other frequencies leak are then equally small.
    a: f64,
    /// Its values in the middles between whole cells, from −(reach − ½) to reach − ½.
    at_cells: [[f64; LANES]; CELLS / LANES],
    /// Cells of the whole grid.
    length: usize,
    /// How many frequencies are requested.
    count: usize,
}

/// Some samples on the grid, one after the other.
struct Placed {
    /// The cell that a sample lies behind, by less than one.
    cells: [u32; AT_ONCE],
    /// What it adds to the first cell that it reaches, less that cell's share of the Gaussian.
    first: [f64; AT_ONCE],
    /// How many times as much it adds to each next one.
    ratio: [f64; AT_ONCE],
}

impl Gaussian {
    fn new(count: usize) -> Self {
        let length = (FINENESS * count).max(PARTS * 2).next_power_of_two();
        let finer = length as f64 / (2 * count) as f64;
        let a = PI * (finer - 0.5) / (finer * REACH as f64);
        // The same to either side.
        let side: [f64; REACH] = std::array::from_fn(|i| libm::exp(-a * square_of(i as f64 + 0.5)));
        let at_cells = std::array::from_fn(|i| {
            std::array::from_fn(|lane| {
                let cell = LANES * i + lane;
                side[if cell < REACH { REACH - 1 - cell } else { cell - REACH }]
            })
        });
        Self { a, at_cells, length, count }
    }

    /// Σ yⱼ wⱼ e^(−a (l − uⱼ)²) at each cell l, from as far before the first sample as it reaches
    /// to as far after the last; uⱼ the sample's time in cells and wⱼ its trapezoidal weight;
    /// `signal` makes yⱼ of each of `values`.
    fn spread(
        &self,
        t: &[f64],
        values: &[f64],
        signal: impl Fn(f64) -> f64,
        step_hz: f64,
    ) -> Vec<f64> {
        widest(
            #[inline(always)]
            || self.spread_by(t, values, signal, step_hz),
        )
    }

    #[inline(always)]
    fn spread_by(
        &self,
        t: &[f64],
        values: &[f64],
        signal: impl Fn(f64) -> f64,
        step_hz: f64,
    ) -> Vec<f64> {
        let cells_a_s = step_hz * self.length as f64;
        let start = t.first().copied().unwrap_or(0.0);
        let last = t.last().map_or(0.0, |last| (last - start) * cells_a_s);
        let mut grid = vec![0.0; last as usize + CELLS];
        let cells = [0; AT_ONCE];
        let first = [0.0; AT_ONCE];
        let ratio = [0.0; AT_ONCE];
        let mut placed = Placed { cells, first, ratio };
        for from in (0..t.len()).step_by(AT_ONCE) {
            let samples = from..t.len().min(from + AT_ONCE);
            let some = samples.len();
            trapezoidal_weights(t, samples.clone(), &mut placed.first);
            let weighted = placed.first.iter_mut().zip(&values[samples.clone()]);
            weighted.for_each(|(first, value)| *first *= signal(*value));
            self.place(t[samples].iter().map(|t| (t - start) * cells_a_s), &mut placed);
            let samples = placed.cells.iter().zip(&placed.first).zip(&placed.ratio);
            for ((cell, first), ratio) in samples.take(some) {
                let two = ratio * ratio;
                let mut values = [1.0, *ratio, two, two * ratio];
                let next = two * two;
                values.iter_mut().for_each(|v| *v *= first);
                let cells = grid.get_mut(*cell as usize..);
                let cells = cells.and_then(|cells| cells.first_chunk_mut());
                let Some(cells): Option<&mut [f64; CELLS]> = cells else { continue };
                let cells = cells.as_chunks_mut::<LANES>().0;
                for (cells, fixed) in cells.iter_mut().zip(&self.at_cells) {
                    for lane in 0..LANES {
                        cells[lane] += values[lane] * fixed[lane];
                        values[lane] *= next;
                    }
                }
            }
        }
        grid
    }

    /// Where samples lie, `at` each in cells, and what they are to begin with: e^(−a (l − u)²) = e^(−a
    /// (l − ½)²) e^(−a δ²) (e^(2aδ))^(l − ½), with δ from −½ to ½ where the sample lies behind the middle
    /// between two cells. The first factor is the cell's own, the others two series a sample and then
    /// products alone, which a processor works out for several samples at once.
    #[inline(always)]
    fn place(&self, at: impl Iterator<Item = f64>, placed: &mut Placed) {
        /// Added to a number it leaves no room for a fraction: it is rounded.
        const ROUNDS: f64 = 1.5 * (1_u64 << 52) as f64;
        let samples = placed.cells.iter_mut().zip(&mut placed.first).zip(&mut placed.ratio);
        for (((cell, first), ratio), at) in samples.zip(at) {
            let rounded = at - 0.5 + ROUNDS;
            *cell = rounded.to_bits() as u32;
            let off = at - 0.5 - (rounded - ROUNDS);
            let [less, more] = small_exps(self.a * off);
            let [square, _] = small_exps(self.a * off * off);
            // e^(−aδ) so many times as twice REACH − ½ is: 16 + 8 + 2 + 1.
            const { assert!(2 * REACH - 1 == 27) };
            let two = less * less;
            let eight = square_of(square_of(two));
            *first *= square * (less * two * (eight * square_of(eight)));
            *ratio = more * more;
        }
    }

    /// Undoes what the Gaussian did to the square of each frequency, by (a/π) e^(ω²/2a), ω = 2πk /
    /// length. Of every few frequencies the exponentials are those of the first, and products.
    fn undo(&self, power: &mut [f64]) {
        /// Frequencies whose exponentials are products.
        const TOGETHER: usize = 16;
        let step = TAU / self.length as f64;
        let exponent = step * step / (2.0 * self.a);
        let within: [f64; TOGETHER] =
            std::array::from_fn(|j| libm::exp(exponent * square_of(j as f64)));
        // (k + j)² = k² + 2 k j + j².
        for (k, power) in (0..).step_by(TOGETHER).zip(power.chunks_mut(TOGETHER)) {
            let mut factor = self.a / PI * libm::exp(exponent * square_of(k as f64));
            let next = libm::exp(2.0 * exponent * k as f64);
            for (power, within) in power.iter_mut().zip(within) {
                *power *= factor * within;
                factor *= next;
            }
        }
    }
}

/// What the transform of one of `parts` of the grid's `length` has to be taken of, so that it gives
/// the frequencies `part`, `part` + `parts`, …: each cell turned by its phase, and those a transform's
/// length apart together.
fn folded(grid: &[f64], part: usize, length: usize, parts: usize) -> Vec<[f64; 2]> {
    let folded_length = length / parts;
    let half = if length <= KEPT { turns(length) } else { Cow::Borrowed(&[][..]) };
    let mut folded = vec![[0.0; 2]; folded_length];
    for (round, cells) in grid.chunks(folded_length).enumerate() {
        for (i, (sum, cell)) in folded.iter_mut().zip(cells).enumerate() {
            let at = (round * folded_length + i) * part % length;
            // The second half of a turn is the first one with both signs changed.
            let [cos, sin] = match (half.get(at), half.get(at.wrapping_sub(length / 2))) {
                (Some(turn), _) => *turn,
                (_, Some([cos, sin])) => [-cos, -sin],
                _ => turn(at, length),
            };
            sum[0] += cell * cos;
            sum[1] += cell * sin;
        }
    }
    folded
}

/// Turns of transforms up to this length are kept: 1 MiB.
const KEPT: usize = 1 << 16;

/// e^(−2πij/n) for the first half of a turn, `n` a power of two.
pub(crate) fn turns(n: usize) -> Cow<'static, [[f64; 2]]> {
    type Turns = OnceLock<Vec<[f64; 2]>>;
    static TABLES: [Turns; KEPT.ilog2() as usize + 1] =
        [const { OnceLock::new() }; KEPT.ilog2() as usize + 1];
    let half_turn = || (0..n / 2).map(|j| turn(j, n)).collect();
    match n.checked_ilog2().and_then(|power| TABLES.get(power as usize)) {
        Some(table) => Cow::Borrowed(table.get_or_init(half_turn)),
        None => Cow::Owned(half_turn()),
    }
}

/// e^(−2πij/n).
fn turn(j: usize, n: usize) -> [f64; 2] {
    let (sin, cos) = libm::sincos(-TAU * (j as f64 / n as f64));
    [cos, sin]
}

/// Σ zⱼ e^(−2πijk/n) for each k: Cooley & Tukey's transform (1965, Math. Comp. 19:297) of a power
/// of two of numbers, in place.
pub(crate) fn transform(mut z: Vec<[f64; 2]>, turns: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = z.len();
    reverse_bits(&mut z);
    // The first two rounds turn by nothing or by a quarter.
    let (fours, rest) = z.as_chunks_mut::<4>();
    for [a, b, c, d] in fours {
        let [low, high] = [[*a, *b], [*c, *d]].map(sum_and_difference);
        let quarter = [high[1][1], -high[1][0]];
        [*a, *c] = sum_and_difference([low[0], high[0]]);
        [*b, *d] = sum_and_difference([low[1], quarter]);
    }
    if let [a, b] = rest {
        [*a, *b] = sum_and_difference([*a, *b]);
    }
    let mut half = 4;
    while half < n {
        for block in z.chunks_mut(2 * half) {
            let (low, high) = block.split_at_mut(half);
            for ((a, b), turn) in low.iter_mut().zip(high).zip(turns.iter().step_by(n / (2 * half)))
            {
                let turned = [b[0] * turn[0] - b[1] * turn[1], b[0] * turn[1] + b[1] * turn[0]];
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
    }
    z
}

/// |z|².
pub(crate) fn squared([re, im]: [f64; 2]) -> f64 {
    re * re + im * im
}

fn sum_and_difference([a, b]: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [[a[0] + b[0], a[1] + b[1]], [a[0] - b[0], a[1] - b[1]]]
}

/// Each number to the place whose index has its own's bits the other way round.
fn reverse_bits(z: &mut [[f64; 2]]) {
    let bits = z.len().trailing_zeros();
    for i in 0..z.len() {
        let j = i.reverse_bits() >> (usize::BITS - bits);
        if i < j {
            z.swap(i, j);
        }
    }
}

#[inline(always)]
fn square_of(x: f64) -> f64 {
    x * x
}

/// What each of some samples counts in ∫ y dt: half of the interval to either side.
#[inline(always)]
fn trapezoidal_weights(t: &[f64], samples: Range<usize>, weights: &mut [f64]) {
    let last = t.len().saturating_sub(1);
    // Those that have a neighbour on either side, and then the ends.
    let inner = samples.start.max(1)..samples.end.min(last);
    if let Some(before) = t.get(inner.start - 1..) {
        let weights = weights.iter_mut().skip(inner.start - samples.start).take(inner.len());
        let before = before.iter();
        let after = t.iter().skip(inner.start + 1);
        weights
            .zip(before.zip(after))
            .for_each(|(weight, (before, after))| *weight = (after - before) / 2.0);
    }
    for end in [0, last].into_iter().filter(|end| samples.contains(end)) {
        let before = t[end.saturating_sub(1)];
        let after = t[(end + 1).min(last)];
        weights[end - samples.start] = (after - before) / 2.0;
    }
}

/// [`Spread::squared`] by the sum itself, frequency by frequency.
#[cfg(test)]
pub(crate) fn squared_fourier(t: &[f64], y: &[f64], step_hz: f64, count: usize) -> Vec<f64> {
    let mut weighted = vec![0.0; t.len()];
    trapezoidal_weights(t, 0..t.len(), &mut weighted);
    weighted.iter_mut().zip(y).for_each(|(weight, y)| *weight *= y);
    // |Y|² does not depend on where time begins, and small angles keep their digits.
    let start = t.first().copied().unwrap_or(0.0);
    let at = |k: usize| {
        let turned = t.iter().zip(&weighted).map(|(t, y)| {
            let (sin, cos) = libm::sincos(-TAU * step_hz * k as f64 * (t - start));
            [y * cos, y * sin]
        });
        let [re, im] = turned.fold([0.0; 2], |[a, b], [re, im]| [a + re, b + im]);
        re * re + im * im
    };
    (0..count).map(at).collect()
}

/// e^(−x) and e^x for x within a ninth of 0: their series up to the terms that are below 1e-16, the
/// even ones and the odd ones apart.
#[inline(always)]
fn small_exps(x: f64) -> [f64; 2] {
    let xx = x * x;
    let even =
        1.0 + xx * (1.0 / 2.0 + xx * (1.0 / 24.0 + xx * (1.0 / 720.0 + xx * (1.0 / 40_320.0))));
    let odd = x
        * (1.0
            + xx * (1.0 / 6.0
                + xx * (1.0 / 120.0 + xx * (1.0 / 5_040.0 + xx * (1.0 / 362_880.0)))));
    [even - odd, even + odd]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squared_fourier_from_zero(t: &[f64], y: &[f64], step_hz: f64, count: usize) -> Vec<f64> {
        Spread::new(t, y, |y| y, step_hz, count).squared()
    }

    /// Uneven times about 1/200 s apart, and a signal with slow, fast and random parts.
    fn signal(n: u32) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> =
            (0..n).map(|i| 3.7 + f64::from(i) * 5e-3 + 1e-3 * f64::from(i * 7 % 5)).collect();
        let part = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24);
        let y = t
            .iter()
            .zip(0..)
            .map(|(t, i)| libm::sin(*t) + 0.3 * libm::cos(40.0 * t) + part(i))
            .collect();
        (t, y)
    }

    #[test]
    fn it_is_the_sum_itself_for_any_number_of_samples_and_frequencies() {
        for (n, step_hz, count) in
            [(3, 1.0, 1), (3, 4.0, 7), (50, 0.2, 40), (1000, 0.0125, 801), (4000, 0.003, 5000)]
        {
            let (t, y) = signal(n);
            let absolute: Vec<f64> = y.iter().map(|y| y.abs()).collect();
            let scale = squared_fourier(&t, &absolute, step_hz, 1)[0];
            let direct = squared_fourier(&t, &y, step_hz, count);
            let found = squared_fourier_from_zero(&t, &y, step_hz, count);
            assert_eq!(found.len(), count);
            for (k, (found, direct)) in found.iter().zip(direct).enumerate() {
                assert!((found - direct).abs() < 1e-13 * scale, "{n}, {k}: {found}, {direct}");
            }
        }
    }

    #[test]
    fn signals_two_by_two_have_the_sum_of_their_spectra() {
        let (t, y) = signal(1000);
        for ends in [vec![400], vec![300, 1000], vec![300, 640, 1000], vec![200, 400, 700, 1000]] {
            let mut begin = 0;
            let parts = ends.into_iter().map(|end| std::mem::replace(&mut begin, end)..end);
            let parts: Vec<_> = parts.map(|part| (&t[part.clone()], y[part].to_vec())).collect();
            let mut expect = vec![0.0; 70];
            for (t, y) in &parts {
                let squares = squared_fourier(t, y, 0.3, 70);
                expect.iter_mut().zip(squares).for_each(|(sum, square)| *sum += square);
            }
            let found = summed_squares(parts.into_iter(), 0.3, 70);
            for (found, expect) in found.iter().zip(&expect) {
                assert!((found - expect).abs() < 1e-13 * expect.max(10.0), "{found}, {expect}");
            }
        }
        assert_eq!(summed_squares(std::iter::empty(), 1.0, 2), [0.0; 2]);
        assert_eq!(summed_squares([(&[1.0][..], vec![1.0])].into_iter(), 1.0, 0), [0.0; 0]);
    }

    /// The box of 1 s: |Y|² = (sin πf / πf)²; the trapezoidal rule is within (πfh)² / 3 of it.
    #[test]
    fn the_spectrum_of_a_box_is_a_sinc() {
        let t: Vec<f64> = (0..=1000).map(|i| f64::from(i) / 1000.0).collect();
        let found = squared_fourier_from_zero(&t, &vec![1.0; t.len()], 0.25, 20);
        assert!((found[0] - 1.0).abs() < 1e-12);
        for (k, found) in found.iter().enumerate().skip(1) {
            let x = PI * 0.25 * k as f64;
            assert!((found - square_of(libm::sin(x) / x)).abs() < 1e-4);
        }
    }

    /// y = 1 at the times 0, 1, … n − 1 over its period: Dirichlet's kernel, (sin(πnf) / sin(πf))²
    /// but for the half weights of the two ends, which take cos(π(n − 1)f) from its amplitude.
    #[test]
    fn an_even_row_of_ones_has_dirichlets_kernel() {
        let n = 256_u32;
        let t: Vec<f64> = (0..n).map(f64::from).collect();
        let found = squared_fourier_from_zero(&t, &vec![1.0; t.len()], 1e-4, 900);
        for (k, found) in found.iter().enumerate().skip(1) {
            let f = 1e-4 * k as f64;
            let kernel = libm::sin(PI * f64::from(n) * f) / libm::sin(PI * f);
            let expect = square_of(kernel - libm::cos(PI * f64::from(n - 1) * f));
            assert!(
                (found - expect).abs() < 1e-13 * square_of(f64::from(n)),
                "{k}: {found}, {expect}"
            );
        }
    }

    #[test]
    fn times_that_are_none_and_no_samples_at_all_end_in_numbers_not_in_a_panic() {
        assert_eq!(squared_fourier_from_zero(&[], &[], 1.0, 3), [0.0; 3]);
        assert_eq!(squared_fourier_from_zero(&[1.0], &[1.0], 1.0, 0), [0.0; 0]);
        assert_eq!(squared_fourier_from_zero(&[2.0, 1.0, 0.0], &[1.0; 3], 1.0, 3).len(), 3);
    }
}
