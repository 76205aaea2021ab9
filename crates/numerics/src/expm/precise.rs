//! Flows over doubled spans in twice the working precision.
//!
//! An exponential multiplies the rounding of its own computation by its condition number. Where that is large
//! the series and the squarings are done with each number held as an unevaluated sum of two (Dekker 1971;
//! Hida, Li & Bailey 2001), and only the flows are rounded: what remains is one rounding a flow.

use super::Matrix;

/// Powers of the series: (1/32)^15 / 15! is below 1e-34.
const POWERS: usize = 14;

/// A matrix as the sum of a rounded part and what rounding took away.
#[derive(Clone, Copy)]
struct Pair<const N: usize> {
    high: Matrix<N>,
    low: Matrix<N>,
}

/// `exp(A span 2^k)` for `k = 0 … count - 1`, each rounded once. `span` is short: `growth(A) span ≤ 1/32`.
pub(super) fn doublings<const N: usize>(a: &Matrix<N>, span: f64, count: usize) -> Vec<Matrix<N>> {
    let mut change = series(&Pair::of(|i, j| product(a.at(i, j), span)));
    let mut flows = Vec::with_capacity(count);
    for _ in 0..count {
        flows.push(change.plus_identity().high);
        // exp(2x) - 1 = 2 (exp(x) - 1) + (exp(x) - 1)².
        let square = change.times(&change);
        change = Pair::of(|i, j| {
            let twice = [2.0 * change.high.at(i, j), 2.0 * change.low.at(i, j)];
            sum(twice, [square.high.at(i, j), square.low.at(i, j)])
        });
    }
    flows
}

/// `exp(X) - 1` by Horner's rule.
fn series<const N: usize>(x: &Pair<N>) -> Pair<N> {
    let mut total = Pair { high: Matrix::ZERO, low: Matrix::ZERO };
    for k in (1..=POWERS).rev() {
        let next = x.times(&total.plus_identity());
        total = Pair::of(|i, j| divide(next.at(i, j), k as f64));
    }
    total
}

impl<const N: usize> Pair<N> {
    fn of(entry: impl Fn(usize, usize) -> [f64; 2]) -> Self {
        let mut pair = Self { high: Matrix::ZERO, low: Matrix::ZERO };
        for j in 0..N {
            for i in 0..N {
                [pair.high.columns[j][i], pair.low.columns[j][i]] = entry(i, j);
            }
        }
        pair
    }

    fn at(&self, i: usize, j: usize) -> [f64; 2] {
        [self.high.at(i, j), self.low.at(i, j)]
    }

    fn plus_identity(&self) -> Self {
        Self::of(|i, j| if i == j { sum(self.at(i, j), [1.0, 0.0]) } else { self.at(i, j) })
    }

    fn times(&self, other: &Self) -> Self {
        Self::of(|i, j| {
            (0..N).fold([0.0; 2], |total, k| {
                let ([a, a_low], [b, b_low]) = (self.at(i, k), other.at(k, j));
                let [high, low] = product(a, b);
                sum(total, [high, low + (a * b_low + a_low * b)])
            })
        })
    }
}

/// `a + b` and its rounding error (Knuth).
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let s = a + b;
    let from_b = s - a;
    [s, (a - (s - from_b)) + (b - from_b)]
}

/// Sum of two pairs.
fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    let [high, error] = two_sum(a[0], b[0]);
    let low = error + (a[1] + b[1]);
    let total = high + low;
    [total, low - (total - high)]
}

/// `a b` and its rounding error (Dekker, Veltkamp).
fn product(a: f64, b: f64) -> [f64; 2] {
    /// 2^27 + 1 splits 53 digits in two halves.
    const SPLITTER: f64 = 134_217_729.0;
    let split = |x: f64| {
        let c = SPLITTER * x;
        let high = c - (c - x);
        [high, x - high]
    };
    let (p, [ah, al], [bh, bl]) = (a * b, split(a), split(b));
    [p, ((ah * bh - p) + ah * bl + al * bh) + al * bl]
}

/// A pair over a number.
fn divide(a: [f64; 2], k: f64) -> [f64; 2] {
    let quotient = a[0] / k;
    let [back, error] = product(quotient, k);
    let rest = ((a[0] - back) - error + a[1]) / k;
    let total = quotient + rest;
    [total, rest - (total - quotient)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(omega: f64) -> Matrix<2> {
        let rows = [[0.0, omega], [-omega, 0.0]];
        Matrix::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn a_million_radians_of_rotation_are_exact_to_rounding() {
        // From 2^-5 rad on, 25 doublings: 2^20 rad.
        for (k, flow) in doublings(&turn(1.0), 0.031_25, 26).iter().enumerate() {
            let angle = libm::ldexp(0.031_25, k as i32);
            let (cosine, sine) = (flow.at(0, 0) - libm::cos(angle), flow.at(0, 1) - libm::sin(angle));
            assert!(cosine.abs() <= 2.3e-16 && sine.abs() <= 2.3e-16, "{angle}: {cosine}, {sine}");
        }
    }

    #[test]
    fn a_stiff_decay_keeps_its_slow_part() {
        let rows = [[-1.0, 0.0], [0.0, -1e9]];
        let flows = doublings(&Matrix::<2>::from_fn(|i, j| rows[i][j]), libm::ldexp(1.0, -35), 36);
        let last = flows[35];
        assert!((last.at(0, 0) - libm::exp(-1.0)).abs() < 1e-16 && last.at(1, 1).abs() < 1e-300);
    }

    #[test]
    fn what_a_product_loses_is_kept() {
        // By rational arithmetic: the square of the double nearest to 0.1, less that square as a double.
        assert_eq!(product(0.1, 0.1)[1].to_bits(), (-8.326_672_684_688_674e-19_f64).to_bits());
    }
}
