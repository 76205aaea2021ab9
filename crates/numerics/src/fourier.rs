//! Many frequencies of a long signal at once, whose samples need not be even.
//!
//! A Fourier sum frequency by frequency takes the number of samples times that of frequencies, and
//! both grow with a recording's length. Here the samples are spread onto an even grid by a narrow
//! Gaussian, the grid is transformed by a fast Fourier transform, and what the Gaussian did to each
//! frequency is divided out again (Greengard & Lee 2004, SIAM Rev. 46:443): n log n, and the sum
//! itself to about 1e-14 of ∫ |y| dt. Plain loops and `libm`, so that it is the same bits on every
//! processor.

use crate::spectrum::trapezoidal_weights;
use core::f64::consts::{PI, TAU};

/// Cells to either side of a sample that its Gaussian reaches: e^(−π · 12 · 7/8) = 5e-15 is left
/// out.
const REACH: usize = 12;
/// Cells a period of the highest frequency, at least: half of that is by how much finer the grid is
/// than it must be.
const FINENESS: usize = 8;
/// The frequencies are those of this many transforms of a sixteenth of the grid's length: a signal
/// that fills no more than a sixteenth of it, as one that is padded with zeros 16 times, then needs
/// no more memory than itself.
const PARTS: usize = 16;

/// |Y|² with Y(f) = ∫ y e^(−2πift) dt by the trapezoidal rule, at the `count` frequencies f = k `step_hz` from 0 on; unit of
/// `y` squared times s². As [`crate::spectrum::squared_fourier`] within 1e-13 of (∫ |y| dt)², in n
/// log n. `t` in s, increasing, as long as `y`.
pub fn squared_fourier_from_zero(t: &[f64], y: &[f64], step_hz: f64, count: usize) -> Vec<f64> {
    Spread::of(t, y.iter().copied(), step_hz, count).squared()
}

/// A signal on the even grid: what is needed of it for its spectrum, in far less memory than a long
/// one takes itself.
#[derive(Debug, Clone)]
pub(crate) struct Spread {
    gaussian: Gaussian,
    grid: Vec<f64>,
    count: usize,
}

impl Spread {
    /// As [`squared_fourier_from_zero`] takes them; `y` gives as many values as `t` has.
    pub(crate) fn of(t: &[f64], y: impl Iterator<Item = f64>, step_hz: f64, count: usize) -> Self {
        let length = (FINENESS * count).max(PARTS * 2).next_power_of_two();
        let gaussian = Gaussian::new(length, count);
        let grid = gaussian.spread(t, y, step_hz * length as f64);
        Self { gaussian, grid, count }
    }

    /// |Y|² at its frequencies.
    pub(crate) fn squared(self) -> Vec<f64> {
        let length = self.gaussian.length;
        let turns = turns(length / PARTS);
        let mut power = vec![0.0; self.count];
        for part in 0..PARTS.min(self.count) {
            let spectrum = transform(folded(&self.grid, part, length), &turns);
            for (power, [re, im]) in power[part..].iter_mut().step_by(PARTS).zip(spectrum) {
                *power = re * re + im * im;
            }
        }
        power.iter_mut().enumerate().for_each(|(k, power)| *power *= self.gaussian.undone(k));
        power
    }
}

/// e^(−a u²), u in cells.
#[derive(Debug, Clone)]
struct Gaussian {
    /// a = π (R − ½) / (R · reach), R the grid's fineness over what it must be: what is cut off and
    /// what other frequencies leak are then equally small.
    a: f64,
    /// Its values at whole cells, from −(reach − 1) to reach.
    at_cells: Vec<f64>,
    /// Cells of the whole grid.
    length: usize,
}

impl Gaussian {
    fn new(length: usize, count: usize) -> Self {
        let finer = length as f64 / (2 * count) as f64;
        let a = PI * (finer - 0.5) / (finer * REACH as f64);
        let at = |i: usize| libm::exp(-a * square(i as f64 - (REACH - 1) as f64));
        Self { a, at_cells: (0..2 * REACH).map(at).collect(), length }
    }

    /// Σ yⱼ wⱼ e^(−a (l − uⱼ)²) at each cell l, from as far before the first sample as it reaches
    /// to as far after the last; uⱼ the sample's time in cells and wⱼ its trapezoidal weight.
    fn spread(&self, t: &[f64], y: impl Iterator<Item = f64>, cells_a_s: f64) -> Vec<f64> {
        let start = t.first().copied().unwrap_or(0.0);
        let last = t.last().map_or(0.0, |last| (last - start) * cells_a_s);
        let mut grid = vec![0.0; last as usize + 2 * REACH];
        for ((t, y), weight) in t.iter().zip(y).zip(trapezoidal_weights(t)) {
            let at = (t - start) * cells_a_s;
            let off = at - at.floor();
            // e^(−a (l − d)²) = e^(−a d²) (e^(2ad))^l e^(−a l²): two exponentials a sample.
            let ratio = libm::exp(2.0 * self.a * off);
            let first = -self.a * off * (off + 2.0 * (REACH - 1) as f64);
            let mut value = y * weight * libm::exp(first);
            for (cell, fixed) in grid.iter_mut().skip(at as usize).zip(&self.at_cells) {
                *cell += value * fixed;
                value *= ratio;
            }
        }
        grid
    }

    /// What undoes the Gaussian in the square of the `k`-th frequency: (a/π) e^(ω²/2a), ω = 2πk /
    /// length.
    fn undone(&self, k: usize) -> f64 {
        let omega = TAU * k as f64 / self.length as f64;
        self.a / PI * libm::exp(omega * omega / (2.0 * self.a))
    }
}

/// What the transform of a [`PARTS`]th of the grid's `length` has to be taken of, so that it gives
/// the frequencies `part`, `part` + 16, …: each cell turned by its phase, and those a transform's
/// length apart together.
fn folded(grid: &[f64], part: usize, length: usize) -> Vec<[f64; 2]> {
    let folded_length = length / PARTS;
    let mut folded = vec![[0.0; 2]; folded_length];
    for (round, cells) in grid.chunks(folded_length).enumerate() {
        for (i, (sum, cell)) in folded.iter_mut().zip(cells).enumerate() {
            let at = (round * folded_length + i) * part % length;
            let (sin, cos) = libm::sincos(-TAU * (at as f64 / length as f64));
            sum[0] += cell * cos;
            sum[1] += cell * sin;
        }
    }
    folded
}

/// e^(−2πij/n) for the first half of a turn, `n` a power of two.
pub(crate) fn turns(n: usize) -> Vec<[f64; 2]> {
    let turn = |j: usize| libm::sincos(-TAU * (j as f64 / n as f64));
    (0..n / 2).map(turn).map(|(sin, cos)| [cos, sin]).collect()
}

/// Σ zⱼ e^(−2πijk/n) for each k: Cooley & Tukey's transform (1965, Math. Comp. 19:297) of a power
/// of two of numbers, in place.
pub(crate) fn transform(mut z: Vec<[f64; 2]>, turns: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let n = z.len();
    reverse_bits(&mut z);
    let mut half = 1;
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

fn square(x: f64) -> f64 {
    x * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::squared_fourier;

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
            let scale = squared_fourier(&t, &absolute, step_hz, 0, 1)[0];
            let direct = squared_fourier(&t, &y, step_hz, 0, count);
            let found = squared_fourier_from_zero(&t, &y, step_hz, count);
            assert_eq!(found.len(), count);
            for (k, (found, direct)) in found.iter().zip(direct).enumerate() {
                assert!((found - direct).abs() < 1e-13 * scale, "{n}, {k}: {found}, {direct}");
            }
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
            let expect = square(kernel - libm::cos(PI * f64::from(n - 1) * f));
            assert!(
                (found - expect).abs() < 1e-13 * square(f64::from(n)),
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
