//! Flows over doubled spans, and over multiples of a span, in twice the working precision.
//!
//! An exponential multiplies the rounding of its own computation by its condition number. Where
//! that number is large, the series and the squarings are done with each number held as an
//! unevaluated sum of two (Dekker 1971; Hida, Li & Bailey 2001), and only the flows are rounded:
//! one rounding per flow remains.

use super::matrix::Matrix;
use super::pair::Pair;

/// Powers of the series: (1/8)^19 / 19! is below 1e-34.
const POWERS: usize = 18;

/// A matrix as the sum of a rounded part and what rounding took away.
#[derive(Clone, Copy)]
struct Pairs<const N: usize> {
    high: Matrix<N>,
    low: Matrix<N>,
}

/// `exp((A + rest) span 2^k)` for `k = 0 … count - 1`, each rounded once. `span` is short:
/// `growth(A) span ≤ 1/8`.
pub(super) fn doublings<const N: usize>(
    a: &Matrix<N>,
    rest: &Matrix<N>,
    span: f64,
    count: usize,
) -> Vec<Matrix<N>> {
    let mut change = short(a, rest, span);
    let mut flows = Vec::with_capacity(count);
    for _ in 0..count {
        flows.push(change.plus_identity().high);
        change = change.followed_by(&change);
    }
    flows
}

/// `exp((A + rest) k t)` for `k = 1 … count`, each rounded once, by `halvings` of `t`, after which it
/// is short.
pub(super) fn multiples<const N: usize>(
    a: &Matrix<N>,
    rest: &Matrix<N>,
    t: f64,
    halvings: i32,
    count: usize,
) -> Vec<Matrix<N>> {
    let shortest = short(a, rest, libm::ldexp(t, -halvings));
    let one = (0..halvings).fold(shortest, |change, _| change.followed_by(&change));
    let all = std::iter::successors(Some(one), |all| Some(all.followed_by(&one)));
    all.take(count).map(|change| change.plus_identity().high).collect()
}

/// `exp((A + rest) t) - 1` over a short span.
fn short<const N: usize>(a: &Matrix<N>, rest: &Matrix<N>, t: f64) -> Pairs<N> {
    let whole = Pairs { high: *a, low: *rest };
    series(&Pairs::from_fn(|i, j| whole.at(i, j) * Pair::from(t)))
}

/// `exp(X) - 1` by Horner's rule.
fn series<const N: usize>(x: &Pairs<N>) -> Pairs<N> {
    let mut total = Pairs { high: Matrix::ZERO, low: Matrix::ZERO };
    for k in (1..=POWERS).rev() {
        let next = x.times(&total.plus_identity());
        total = Pairs::from_fn(|i, j| next.at(i, j) / Pair::from(k as f64));
    }
    total
}

impl<const N: usize> Pairs<N> {
    fn from_fn(entry: impl Fn(usize, usize) -> Pair) -> Self {
        let mut pairs = Self { high: Matrix::ZERO, low: Matrix::ZERO };
        for j in 0..N {
            for i in 0..N {
                let Pair { high, low } = entry(i, j);
                (pairs.high.columns[j][i], pairs.low.columns[j][i]) = (high, low);
            }
        }
        pairs
    }

    fn at(&self, i: usize, j: usize) -> Pair {
        Pair { high: self.high.at(i, j), low: self.low.at(i, j) }
    }

    /// The change over one span and then another: `exp(x + y) - 1` from `exp(x) - 1` and `exp(y) -
    /// 1`, which commute.
    fn followed_by(&self, other: &Self) -> Self {
        let product = self.times(other);
        Self::from_fn(|i, j| self.at(i, j) + other.at(i, j) + product.at(i, j))
    }

    fn plus_identity(&self) -> Self {
        Self::from_fn(|i, j| if i == j { self.at(i, j) + Pair::from(1.0) } else { self.at(i, j) })
    }

    fn times(&self, other: &Self) -> Self {
        Self::from_fn(|i, j| {
            (0..N).fold(Pair::ZERO, |total, k| total + self.at(i, k) * other.at(k, j))
        })
    }
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
        for (k, flow) in doublings(&turn(1.0), &Matrix::ZERO, 0.031_25, 26).iter().enumerate() {
            let angle = libm::ldexp(0.031_25, k as i32);
            let (cosine, sine) =
                (flow.at(0, 0) - libm::cos(angle), flow.at(0, 1) - libm::sin(angle));
            assert!(cosine.abs() <= 2.3e-16 && sine.abs() <= 2.3e-16, "{angle}: {cosine}, {sine}");
        }
    }

    #[test]
    fn a_stiff_decay_keeps_its_slow_part() {
        let rows = [[-1.0, 0.0], [0.0, -1e9]];
        let a = Matrix::<2>::from_fn(|i, j| rows[i][j]);
        let flows = doublings(&a, &Matrix::ZERO, libm::ldexp(1.0, -35), 36);
        let last = flows[35];
        assert!((last.at(0, 0) - libm::exp(-1.0)).abs() < 1e-16 && last.at(1, 1).abs() < 1e-300);
    }

    #[test]
    fn multiples_are_the_flows_over_so_many_spans() {
        let flows = multiples(&turn(1.0), &Matrix::ZERO, 5.0, 8, 7);
        for (k, flow) in (1..).zip(flows) {
            let angle = 5.0 * f64::from(k);
            let (cosine, sine) =
                (flow.at(0, 0) - libm::cos(angle), flow.at(0, 1) - libm::sin(angle));
            assert!(cosine.abs() <= 1.2e-16 && sine.abs() <= 1.2e-16, "{angle}: {cosine}, {sine}");
        }
    }

    #[test]
    fn what_rounding_took_from_the_matrix_is_not_lost() {
        // A rotation by 2^20 rad of which 2^-53 radians a radian stand in the rest: the angle is
        // 2^20 + 2^-33.
        let rest = turn(libm::ldexp(1.0, -53));
        let flows = doublings(&turn(1.0), &rest, 0.031_25, 26);
        let (turned, more) = (libm::ldexp(1.0, 20), libm::ldexp(1.0, -33));
        let expect = libm::cos(turned) - more * libm::sin(turned);
        assert!((flows[25].at(0, 0) - expect).abs() <= 2.3e-16);
    }
}
