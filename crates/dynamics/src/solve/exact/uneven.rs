//! Flows over spans of any length: a table of multiples of short spans, eight to a level, as digits
//! of the span.
//!
//! The steps of a recorded signal keep changing in length. Each costs one product per digit and a
//! short series, instead of a matrix exponential.

use zwidth_numerics::expm::{Ladder, Matrix};

/// Multiples 1 to 7 of a level's span: three binary digits.
const MULTIPLES: usize = 7;
/// Binary digits per level.
const BITS: i32 = 3;
/// Levels below the ladder's lowest rung: two divide it by 64, which leaves five powers of the
/// series.
const LEVELS_BELOW: i32 = 2;
/// Powers of the series over what is left: (2^-3 / 64)^6 / 6! is below 1e-19.
const POWERS: usize = 5;

/// One digit: flows over 1, 2, …, 7 spans.
#[derive(Debug, Clone)]
struct Level<const N: usize> {
    span: f64,
    per_span: f64,
    flows: [Matrix<N>; MULTIPLES],
}

/// The table of a region.
#[derive(Debug, Clone)]
pub(super) struct Table<const N: usize, const D: usize> {
    levels: Vec<Level<N>>,
}

impl<const N: usize, const D: usize> Table<N, D> {
    /// A table for spans up to `reach` seconds.
    pub(super) fn new(ladder: &Ladder<N, D>, reach: f64) -> Self {
        let mut span = libm::ldexp(ladder.rungs[0].span, -BITS * LEVELS_BELOW);
        let mut levels = Vec::new();
        while span <= reach {
            levels.push(Level { span, per_span: 1.0 / span, flows: ladder.flows(span) });
            span = libm::ldexp(span, BITS);
        }
        levels.reverse();
        Self { levels }
    }

    /// `exp(A t) z`; `t` no longer than the table reaches.
    #[inline]
    pub(super) fn advance(&self, a: &Matrix<N>, z: &[f64; N], t: f64) -> [f64; N] {
        let mut z = *z;
        let mut rest = t;
        for level in &self.levels {
            // Rounding can make the digit 8, one more than the level has.
            let digit = (rest * level.per_span) as usize;
            if digit > 0 {
                z = level.flows[digit.min(MULTIPLES) - 1].apply_affine::<D>(&z);
                rest -= digit.min(MULTIPLES) as f64 * level.span;
            }
        }
        series::<N, D>(a, &z, rest)
    }
}

/// `Σ (A t)^k z / k!` by Horner's rule.
#[inline]
fn series<const N: usize, const D: usize>(a: &Matrix<N>, z: &[f64; N], t: f64) -> [f64; N] {
    /// Reciprocals 1/k.
    const INVERSE: [f64; POWERS + 1] = [0.0, 1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0];
    let mut sum = *z;
    for k in (1..=POWERS).rev() {
        let factor = t * INVERSE[k];
        let next = a.apply_split::<D>(&sum);
        sum = std::array::from_fn(|i| z[i] + factor * next[i]);
    }
    sum
}
