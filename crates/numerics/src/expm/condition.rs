//! How much the exponential magnifies a relative error of its matrix.

use super::{Matrix, ORDER, growth, series};

/// The matrix is halved to this size, so that three powers of its derivative are enough.
const RADIUS: f64 = 0.031_25;

/// Relative condition number of the exponential in the Frobenius norm,
/// `κ(A) = ‖L(A)‖ ‖A‖ / ‖exp(A)‖`, with the Fréchet derivative `L(A, E) = ∫₀¹ exp(A (1-s)) E exp(A
/// s) ds` (Van Loan 1977; Higham, Functions of Matrices, 2008, §10.2). A rotation by `φ` has `φ`, a
/// decay over `t` time constants about `t`; it depends on the units of the state, as the norms do.
///
/// `‖L(A)‖` by the power method (Higham 2008, algorithm 3.20), to about 1e-3 of itself; `L` by
/// scaling and doubling, `L(2A, 2E) = exp(A) L(A, E) + L(A, E) exp(A)` (Kenney & Laub 1998).
/// Infinite if it overflows.
pub fn condition<const N: usize>(a: &Matrix<N>) -> f64 {
    /// The estimate seldom changes after the fifth; singular values that nearly agree do no harm to
    /// it.
    const MOST_ROUNDS: usize = 50;
    /// Relative change at which the estimate is good enough.
    const SETTLED: f64 = 1e-4;
    let Some(halved) = Halved::new(a) else { return f64::INFINITY };
    // The adjoint of L(A, ·) is L(Aᵀ, ·).
    let adjoint = halved.transposed();
    let mut direction = Matrix::from_fn(|_, _| 1.0 / N as f64);
    let mut norm = 0.0;
    for _ in 0..MOST_ROUNDS {
        let image = halved.derivative(&direction);
        let back = adjoint.derivative(&image);
        let size = frobenius(&back);
        let last = norm;
        let estimate = size.sqrt();
        if !size.is_finite() || size <= 0.0 {
            return f64::INFINITY;
        }
        direction = back.map(|x| x / size);
        norm = estimate;
        if (norm - last).abs() <= SETTLED * norm {
            break;
        }
    }
    let whole = halved.flows.last().map_or(1.0, frobenius);
    let kappa = norm * frobenius(a) / whole;
    if kappa.is_nan() { f64::INFINITY } else { kappa }
}

/// A matrix halved until its series converges at once, and the flows on the way back up.
struct Halved<const N: usize> {
    /// `A / 2^k`.
    lowest: Matrix<N>,
    /// `exp(A / 2^k)`, …, `exp(A)`.
    flows: Vec<Matrix<N>>,
}

impl<const N: usize> Halved<N> {
    /// `None` if the matrix is not finite or has no exponential of finite size.
    fn new(a: &Matrix<N>) -> Option<Self> {
        let rate = growth(a);
        if !rate.is_finite() {
            return None;
        }
        let halvings = if rate > RADIUS { libm::ilogb(rate / RADIUS) + 1 } else { 0 };
        let lowest = a.map(|x| libm::ldexp(x, -halvings));
        let mut change = series::<N, N>(&lowest, 1.0, ORDER);
        let mut flows = vec![change.shifted(1.0)];
        for _ in 0..halvings {
            change = change.zip(&change.product(&change), |x, square| 2.0 * x + square);
            flows.push(change.shifted(1.0));
        }
        change.largest().is_finite().then_some(Self { lowest, flows })
    }

    fn transposed(&self) -> Self {
        let flows = self.flows.iter().map(Matrix::transposed).collect();
        Self { lowest: self.lowest.transposed(), flows }
    }

    /// `L(A, E)`. Below, the series `E + (XE + EX)/2 + (X²E + XEX + EX²)/6`: the next term is below
    /// 2e-6.
    fn derivative(&self, e: &Matrix<N>) -> Matrix<N> {
        let x = &self.lowest;
        // One flow more than halvings: `E` is halved as often as the matrix was.
        let scale = libm::ldexp(1.0, 1 - self.flows.len() as i32);
        let e = e.map(|entry| entry * scale);
        let first = x.product(&e).plus(&e.product(x));
        let second = x.product(&first).plus(&e.product(&x.product(x)));
        let mut out = e.plus(&first.map(|p| p / 2.0).plus(&second.map(|p| p / 6.0)));
        for flow in &self.flows[..self.flows.len() - 1] {
            out = flow.product(&out).plus(&out.product(flow));
        }
        out
    }
}

/// Square root of the sum of squares of the entries, without overflow.
fn frobenius<const N: usize>(m: &Matrix<N>) -> f64 {
    let largest = m.largest();
    if largest > 0.0 && largest.is_finite() {
        largest
            * m.columns.iter().flatten().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
    } else {
        largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against `scipy.linalg.expm_cond` (SciPy 1.17.1), which forms the derivative's whole matrix.
    fn check<const N: usize>(rows: [[f64; N]; N], expect: f64) {
        let found = condition(&Matrix::<N>::from_fn(|i, j| rows[i][j]));
        assert!((found / expect - 1.0).abs() < 2e-3, "{found} instead of {expect}");
    }

    #[test]
    fn scipys_example_has_scipys_condition_number() {
        check([[-0.3, 0.2, 0.6], [0.6, 0.3, -0.1], [-0.7, 1.2, 0.9]], 1.778_780_586_446_966_6);
    }

    #[test]
    fn a_device_scene_over_a_step_of_8_3_ms_is_well_conditioned() {
        // Table 3, brake engaged, with the sine (7): (θ, θ̇, F, Ḟ, 1).
        let h = 0.008_3;
        let (k, w) = (800.0 * h, std::f64::consts::FRAC_PI_2);
        let rows = [
            [0.0, h, 0.0, 0.0, 0.0],
            [-k, -200.0 * h, 200.0 * h, 0.0, -k * std::f64::consts::FRAC_PI_4],
            [0.0, 0.0, 0.0, h, 0.0],
            [0.0, 0.0, -w * w * h, 0.0, 2.15 * w * w * h],
            [0.0; 5],
        ];
        check(rows, 13.681_745_716_087_528);
        check([[0.0, h], [-k, -200.0 * h]], 9.832_698_856_549_552);
    }

    #[test]
    fn a_rotation_has_its_angle_a_decay_its_rate_and_bad_units_more() {
        check([[0.0, 3.0], [-3.0, 0.0]], 3.0);
        check([[-1.0, 0.0], [0.0, -1000.0]], 1_000.000_5);
        check([[0.0, 1.0], [-100.0, 0.0]], 711.273_515_352_758_7);
    }

    #[test]
    fn an_exponential_that_overflows_has_an_infinite_one() {
        assert_eq!(condition(&Matrix::<1>::from_fn(|_, _| 1e9)).to_bits(), f64::INFINITY.to_bits());
        assert_eq!(
            condition(&Matrix::<1>::from_fn(|_, _| f64::NAN)).to_bits(),
            f64::INFINITY.to_bits()
        );
        assert_eq!(condition(&Matrix::<2>::ZERO).to_bits(), 0.0_f64.to_bits());
    }
}
