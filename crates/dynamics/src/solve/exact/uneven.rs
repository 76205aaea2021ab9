//! Flows over spans of any length: a short series, and a table of multiples of a short span.
//!
//! The steps of a recorded signal keep changing in length. Each costs a series, whose terms do not
//! wait for its length, and one product per digit of it, instead of a matrix exponential.

use zwidth_numerics::expm::{Ladder, Matrix};

/// Binary digits per level.
const BITS: i32 = 7;
/// Multiples of its span that a digit can be.
const MULTIPLES: usize = (1 << BITS) - 1;
/// The shortest span is the ladder's lowest over two to this power. What is left of a step is half
/// of it at most, to either side, so that five powers of the series are enough: (2^-3 / 32)^6 / 6!
/// is below 1e-17.
const FINER: i32 = 4;

/// The table of a region, for a matrix split after `D`.
#[derive(Debug, Clone)]
pub(super) struct Table<const N: usize, const D: usize> {
    /// The shortest span, s.
    span: f64,
    per_span: f64,
    /// For each digit, the last first, the flows over 1, 2, … of its spans.
    levels: Vec<Vec<Matrix<N>>>,
}

impl<const N: usize, const D: usize> Table<N, D> {
    /// A table for times up to `reach` seconds; none if they have too many digits.
    #[cold]
    #[inline(never)] // its arrays would make every step's frame a large one
    pub(super) fn new(ladder: &Ladder<N, D>, reach: f64) -> Option<Self> {
        /// Spans in the longest time: far fewer than a double can count.
        const MOST_SPANS: f64 = 1e12;
        let span = libm::ldexp(ladder.rungs[0].span, -FINER);
        if span <= 0.0 || reach / span > MOST_SPANS {
            return None;
        }
        let longest = reach + 0.5 * span;
        let mut levels = Vec::new();
        let mut digit = span;
        while digit <= longest {
            let count = ((longest / digit) as usize).min(MULTIPLES);
            levels.push(ladder.multiples(digit, count));
            digit = libm::ldexp(digit, BITS);
        }
        Some(Self { span, per_span: 1.0 / span, levels })
    }

    /// `exp(A t) z`, where z' and z'' are `rate` and `bend`; `t` no longer than the table reaches.
    #[inline]
    pub(super) fn advance(
        &self,
        a: &Matrix<N>,
        [z, rate, bend]: [&[f64; N]; 3],
        t: f64,
    ) -> [f64; N] {
        let mut spans = (t * self.per_span + 0.5) as u64;
        let mut z = series::<N, D>(a, [z, rate, bend], t - spans as f64 * self.span);
        for flows in &self.levels {
            let digit = spans as usize & MULTIPLES;
            if digit > 0 {
                // Rounding could make it one more than the level has.
                z = flows[digit.min(flows.len()) - 1].apply_affine::<D>(&z);
            }
            spans >>= BITS;
        }
        z
    }
}

/// `exp(A t) z` over a short time, of which five powers are kept: each is added as soon as it is
/// there, which for the last is the end of a chain of products.
#[inline]
fn series<const N: usize, const D: usize>(
    a: &Matrix<N>,
    [z, rate, bend]: [&[f64; N]; 3],
    t: f64,
) -> [f64; N] {
    let second = t * t / 2.0;
    let cubic = second * t / 3.0;
    let quartic = cubic * t / 4.0;
    let quintic = quartic * t / 5.0;
    let third = a.apply_change::<D>(bend);
    let fourth = a.apply_change::<D>(&third);
    let fifth = a.apply_change::<D>(&fourth);
    std::array::from_fn(|i| {
        let low = z[i] + (t * rate[i] + second * bend[i]);
        low + (cubic * third[i] + quartic * fourth[i]) + quintic * fifth[i]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lever with spring, damping and a push in a straight line: (θ, θ̇, F, Ḟ, 1).
    fn pushed(stiffness: f64, damping: f64) -> Matrix<5> {
        let rows = [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [-stiffness, -damping, 200.0, 0.0, 30.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0; 5],
            [0.0; 5],
        ];
        Matrix::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn a_step_by_the_table_is_that_of_the_exponential_at_any_length() {
        // From a fraction of a radian to a thousand of them: one, two and three digits.
        for (stiffness, damping, reach) in
            [(800.0, 200.0, 0.0083), (40.0, 0.3, 0.02), (4e4, 0.1, 5.0), (1e8, 3.0, 0.1)]
        {
            let a = pushed(stiffness, damping);
            let ladder = Ladder::<5, 2>::new(a, reach);
            let table = Table::new(&ladder, reach).unwrap();
            let z = [0.4, -1.3, 2.0, 0.7, 1.0];
            let rate = a.apply_affine::<2>(&z);
            let bend = a.apply_change::<2>(&rate);
            for k in 0..400 {
                let t = reach * (f64::from(k) * 0.618_033_988_749_894_9).fract();
                let found = table.advance(&a, [&z, &rate, &bend], t);
                let expect = ladder.flow(t).apply(&z);
                // θ̇ swings by the natural frequency times θ.
                let natural = stiffness.sqrt();
                let size = 2.0 + natural;
                for (i, (x, y)) in found.iter().zip(expect).enumerate() {
                    let bound = if i == 1 { 4e-14 * size } else { 4e-14 };
                    assert!((x - y).abs() < bound, "{stiffness} {t} {i}: {x} instead of {y}");
                }
            }
        }
    }
}
