//! The matrix exponential of small matrices, kept as a ladder of doubled spans.
//!
//! A linear system `z' = A z` is advanced by `z(t) = exp(A t) z(0)`. For a short span the Taylor
//! series converges at once; longer spans follow by squaring (Higham 2005, "The scaling and
//! squaring method for the matrix exponential revisited"). All rungs are kept: they reach any
//! span, even or uneven, and they bound what happens inside a span.
//! The series keeps structure that a rational approximation loses: a zero row of `A` gives exactly
//! a unit row, so a quantity at rest stays at rest, bit for bit.

mod condition;
mod matrix;
mod pair;
mod precise;

pub use condition::condition;
pub use matrix::{Matrix, dot};
pub use pair::Pair;

/// Highest power kept of the Taylor series. With `RADIUS` the next term is below 1e-19.
pub const ORDER: usize = 11;

/// The lowest rung spans `RADIUS / growth(A)`: 1/8, so that `ORDER` powers are exact to rounding.
const RADIUS: f64 = 0.125;

/// Powers kept of an envelope's series, and what covers the others: with `RADIUS` they are below
/// 1e-7 of the sum where it is not tiny, and the curvature an envelope bounds is passed by a factor
/// of two anyway.
const BOUND_ORDER: usize = 5;
const BOUND_MARGIN: f64 = 1.0 + 1e-6;

/// From this many radians (or time constants) on, a flow is computed in twice the precision: the
/// doublings would else magnify its rounding beyond 1e-14 of the largest signal.
const PRECISE_FROM: f64 = 16.0;

/// More rungs than this are never needed: 2^200 shortest spans exceed any span of interest.
const MOST_RUNGS: usize = 200;

/// `‖Aᵐ‖^(1/m)` for `m = 2^doublings`, largest-entry norm: tends to the spectral radius (Gelfand).
fn power_root<const N: usize>(matrix: &Matrix<N>, doublings: i32) -> f64 {
    let mut power = *matrix;
    let mut log2_scale = 0.0_f64;
    for _ in 0..=doublings {
        let size = power.largest();
        if size <= 0.0 || !size.is_finite() {
            return size;
        }
        // Powers of a fast matrix overflow. A power of two as scale costs no digit.
        let exponent = libm::ilogb(size);
        let scale = libm::ldexp(1.0, -exponent);
        power = power.map(|x| x * scale);
        log2_scale = 2.0 * (log2_scale + f64::from(exponent));
        power = power.product(&power);
    }
    let m = libm::ldexp(1.0, doublings + 1);
    let size = power.largest();
    if size <= 0.0 { 0.0 } else { libm::exp2((log2_scale + libm::log2(size)) / m) }
}

/// Spectral radius of `A`, to about 1e-9 of itself.
pub fn spectral_radius<const N: usize>(matrix: &Matrix<N>) -> f64 {
    /// After 2^40 products what is left of a Jordan block's polynomial growth is below 1e-10.
    const DOUBLINGS: i32 = 40;
    power_root(matrix, DOUBLINGS)
}

/// How fast the terms of `exp(A t)` can grow: an estimate of the spectral radius of `|A|`, 1/s.
pub fn growth<const N: usize>(matrix: &Matrix<N>) -> f64 {
    /// The 32nd root hides the scale of one-way couplings, which do not slow convergence.
    const DOUBLINGS: i32 = 4;
    power_root(&matrix.map(f64::abs), DOUBLINGS)
}

/// The same for a matrix split after `D`, whose last entry is constant: the faster of its two
/// diagonal blocks, for what one feeds to the other does not slow convergence.
fn growth_split<const N: usize, const D: usize>(matrix: &Matrix<N>) -> f64 {
    let head = Matrix::<D>::from_fn(|i, j| matrix.at(i, j).abs());
    let head = if D == 2 { spectral_radius_2(&head) } else { growth(&head) };
    // The entries of the tail move in pairs, such as x¨ = −ω² x: the root of the square is exact.
    let mut square: f64 = 0.0;
    for j in D..N.saturating_sub(1) {
        for i in D..N - 1 {
            let entry: f64 = (D..N - 1).map(|k| (matrix.at(i, k) * matrix.at(k, j)).abs()).sum();
            square = square.max(entry);
        }
    }
    if head.is_nan() { head } else { head.max(square.sqrt()) }
}

/// Spectral radius of a 2 × 2 matrix without negative entries: the larger root of its
/// characteristic polynomial, without overflow of a square.
fn spectral_radius_2<const D: usize>(matrix: &Matrix<D>) -> f64 {
    let difference = (matrix.at(0, 0) - matrix.at(1, 1)).abs();
    let coupling = 2.0 * matrix.at(0, 1).sqrt() * matrix.at(1, 0).sqrt();
    let [less, more] =
        if difference < coupling { [difference, coupling] } else { [coupling, difference] };
    let ratio = if more > 0.0 { less / more } else { 0.0 };
    0.5 * (matrix.at(0, 0) + matrix.at(1, 1) + more * (1.0 + ratio * ratio).sqrt())
}

/// Reciprocals 1/k; a multiplication costs a tenth of a division.
const INVERSE: [f64; ORDER + 1] = [
    0.0,
    1.0,
    1.0 / 2.0,
    1.0 / 3.0,
    1.0 / 4.0,
    1.0 / 5.0,
    1.0 / 6.0,
    1.0 / 7.0,
    1.0 / 8.0,
    1.0 / 9.0,
    1.0 / 10.0,
    1.0 / 11.0,
];

/// Taylor coefficients of `z(t) = exp(A t) z0`: `z(t) = Σ c[k] tᵏ`, for `A` split after `D`.
#[inline]
pub fn taylor<const N: usize, const D: usize>(
    a: &Matrix<N>,
    z0: &[f64; N],
) -> [[f64; N]; ORDER + 1] {
    let mut c = [*z0; ORDER + 1];
    let mut last = *z0;
    for k in 1..=ORDER {
        // What follows the first D entries is often constant, and has no higher powers.
        let change = match last[D..].iter().all(|x| *x == 0.0) {
            true => a.apply_head::<D>(&last),
            false => a.apply_split::<D>(&last),
        };
        last = change.map(|x| x * INVERSE[k]);
        c[k] = last;
    }
    c
}

/// Value at `t` of the vector polynomial `Σ c[k] tᵏ`: even and odd powers by Horner's rule in t²,
/// each without waiting for the other.
#[inline]
pub fn evaluate<const N: usize>(c: &[[f64; N]; ORDER + 1], t: f64) -> [f64; N] {
    let square = t * t;
    let mut sums = [[0.0; N]; 2];
    for (k, c) in c.iter().enumerate().rev() {
        for (sum, x) in sums[k % 2].iter_mut().zip(c) {
            *sum = *sum * square + x;
        }
    }
    let [even, odd] = sums;
    std::array::from_fn(|i| even[i] + t * odd[i])
}

/// One rung: the flow over `span` and a bound on all flows inside it.
#[derive(Debug, Clone)]
pub struct Rung<const N: usize> {
    /// Length of the span, s; the longest rung's over a power of two.
    pub span: f64,
    /// `exp(A span)`.
    pub flow: Matrix<N>,
    /// Entry by entry at least `|exp(A t)|` for every `t` in `[0, span]`.
    pub envelope: Matrix<N>,
}

/// The flows of `z' = A z` over doubled spans, for `A` split after `D` entries (see [`Matrix`]).
#[derive(Debug, Clone)]
pub struct Ladder<const N: usize, const D: usize = N> {
    /// The system's matrix, 1/s.
    pub a: Matrix<N>,
    /// How fast the terms of the exponential can grow, 1/s (see [`growth`]).
    pub rate: f64,
    /// Rungs, shortest span first; never empty.
    pub rungs: Vec<Rung<N>>,
    /// What rounding took from `a`, where it counts.
    rest: Option<Box<Matrix<N>>>,
}

impl<const N: usize, const D: usize> Ladder<N, D> {
    /// The ladder of `A` that reaches spans up to `reach` seconds (`reach` > 0, finite). Its spans
    /// are powers of two.
    pub fn new(a: Matrix<N>, reach: f64) -> Self {
        Self::with_rest(a, reach, || Matrix::ZERO)
    }

    /// The ladder of a matrix whose entries are not doubles, given as rounded entries (`a`) and
    /// their rounding errors (`rest`, requested where they count). Flows that are computed in twice
    /// the precision are those of the sum.
    pub fn with_rest(a: Matrix<N>, reach: f64, rest: impl FnOnce() -> Matrix<N>) -> Self {
        let below = libm::ldexp(1.0, libm::ilogb(reach));
        Self::below(a, if below < reach { 2.0 * below } else { below }, reach, rest)
    }

    /// The same with the reach itself and its halves as spans, for pieces of a step that is
    /// repeated.
    pub fn halving(a: Matrix<N>, reach: f64, rest: impl FnOnce() -> Matrix<N>) -> Self {
        Self::below(a, reach, reach, rest)
    }

    /// The ladder whose longest rung is `top`, not below the reach.
    fn below(a: Matrix<N>, top: f64, reach: f64, rest: impl FnOnce() -> Matrix<N>) -> Self {
        let rate = growth_split::<N, D>(&a);
        let angle = rate * top / RADIUS;
        let halvings = if angle > 1.0 { libm::ilogb(angle).saturating_add(1) } else { 0 };
        let span = libm::ldexp(top, -halvings);
        let mut change = series::<N, D>(&a, span, ORDER);
        let bound = series::<N, D>(&a.map(f64::abs), span, BOUND_ORDER).map(|x| BOUND_MARGIN * x);
        let mut rungs = Vec::with_capacity(halvings.clamp(0, MOST_RUNGS as i32) as usize + 1);
        rungs.push(Rung { span, flow: change.shifted(1.0), envelope: bound.shifted(1.0) });
        while let Some(last) = rungs.last().filter(|rung| rung.span < top)
            && rungs.len() <= MOST_RUNGS
        {
            change = joined::<N, D>(&change, &change);
            // |Φ(s + t)| ≤ |Φ(s)| |Φ(t)| entry by entry carries the envelope over.
            let second = last.flow.map(f64::abs).product_split::<D>(&last.envelope);
            rungs.push(Rung {
                span: 2.0 * last.span,
                flow: change.shifted(1.0),
                envelope: last.envelope.zip(&second, f64::max),
            });
        }
        let mut ladder = Self { a, rate, rungs, rest: None };
        if ladder.is_long(reach) {
            let rest = rest();
            let flows = precise::doublings(&a, &rest, span, ladder.rungs.len());
            ladder.rest = Some(Box::new(rest));
            for (rung, flow) in ladder.rungs.iter_mut().zip(flows) {
                // Splitting a number in halves overflows a little before the number itself does.
                if flow.is_finite() {
                    rung.flow = flow;
                }
            }
        }
        ladder
    }

    /// True if flows over `t` seconds are computed in twice the precision.
    #[inline]
    pub fn is_long(&self, t: f64) -> bool {
        self.rate * t >= PRECISE_FROM
    }

    /// False if the matrix is not finite or so fast that no ladder of useful length reaches as far.
    pub fn reaches(&self, t: f64) -> bool {
        let top = &self.rungs[self.rungs.len() - 1];
        self.rungs[0].span > 0.0 && top.span >= t && top.flow.largest().is_finite()
    }

    /// `exp(A t) z`, for `0 ≤ t ≤ reach`.
    #[inline]
    pub fn advance(&self, z: &[f64; N], t: f64) -> [f64; N] {
        let mut z = *z;
        let mut rest = t;
        for rung in self.rungs.iter().rev() {
            if rung.span <= rest {
                z = rung.flow.apply_split::<D>(&z);
                rest -= rung.span;
            }
        }
        // What is left is shorter than the lowest rung, where the series converges at once.
        if rest > 0.0 { evaluate(&taylor::<N, D>(&self.a, &z), rest) } else { z }
    }

    /// `exp(A t)` as a matrix, for a step that is repeated: over a long one in twice the precision.
    pub fn flow(&self, t: f64) -> Matrix<N> {
        let top = &self.rungs[self.rungs.len() - 1];
        if top.span.to_bits() == t.to_bits() {
            return top.flow;
        }
        let precise = self.precise_multiples(t, 1).into_iter().find(Matrix::is_finite);
        precise.unwrap_or_else(|| self.change(t).shifted(1.0))
    }

    /// `exp(A k t)` for `k = 1 … count`, each rounded a few times at most: where the last of these is
    /// long in twice the precision, which takes little more than the last one alone.
    pub fn multiples(&self, t: f64, count: usize) -> Vec<Matrix<N>> {
        let mut changes = Vec::with_capacity(count);
        changes.push(self.change(t));
        while changes.len() < count {
            let half = changes.len().div_ceil(2);
            let (a, b) = (&changes[half - 1], &changes[changes.len() - half]);
            changes.push(joined::<N, D>(a, b));
        }
        let mut flows: Vec<_> = changes.iter().map(|change| change.shifted(1.0)).collect();
        for (flow, precise) in flows.iter_mut().zip(self.precise_multiples(t, count)) {
            if precise.is_finite() {
                *flow = precise;
            }
        }
        flows
    }

    /// `exp(A t) - 1` in the working precision.
    fn change(&self, t: f64) -> Matrix<N> {
        let angle = self.rate * t;
        let halvings = if angle > RADIUS { libm::ilogb(angle / RADIUS) + 1 } else { 0 };
        let shortest = series::<N, D>(&self.a, libm::ldexp(t, -halvings), ORDER);
        (0..halvings).fold(shortest, |change, _| joined::<N, D>(&change, &change))
    }

    /// The multiples in twice the precision; none if that is not needed, or the angle is too large
    /// for a number.
    fn precise_multiples(&self, t: f64, count: usize) -> Vec<Matrix<N>> {
        let angle = self.rate * t;
        if !self.is_long(count as f64 * t) || !angle.is_finite() {
            return Vec::new();
        }
        let halvings = if angle > RADIUS { libm::ilogb(angle / RADIUS) + 1 } else { 0 };
        let rest = self.rest.as_deref().copied().unwrap_or(Matrix::ZERO);
        precise::multiples(&self.a, &rest, t, halvings, count)
    }

    /// Index of the shortest rung whose span is at least `t` (the longest if none is).
    pub fn covering(&self, t: f64) -> usize {
        self.rungs.iter().position(|rung| rung.span >= t).unwrap_or(self.rungs.len() - 1)
    }
}

/// `exp(A t) - 1`. The rungs are doubled in this form, `X(2s) = 2 X(s) + X(s)²`, because the change
/// over a short span keeps its leading digits where the flow itself would lose them to the
/// identity: the error grows with the number of doublings, not with their product. `A` is split
/// after `D`.
fn series<const N: usize, const D: usize>(a: &Matrix<N>, t: f64, order: usize) -> Matrix<N> {
    let scaled = a.map(|x| x * t);
    let mut sum = Matrix::ZERO;
    for k in (1..=order).rev() {
        sum = scaled.product_split::<D>(&sum.shifted(1.0)).map(|x| x * INVERSE[k]);
    }
    sum
}

/// The change over one span and then another, both split after `D`, which commute: `X + Y + X Y`.
fn joined<const N: usize, const D: usize>(x: &Matrix<N>, y: &Matrix<N>) -> Matrix<N> {
    x.zip(y, |x, y| x + y).zip(&x.product_split::<D>(y), |sum, product| sum + product)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn oscillator(k: f64, b: f64) -> Matrix<2> {
        let rows = [[0.0, 1.0], [-k, -b]];
        Matrix::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn a_rotation_is_cosine_and_sine() {
        let ladder = Ladder::<2>::new(oscillator(1.0, 0.0), 10.0);
        for t in [1e-6, 0.3, 1.0, 7.77] {
            let z = ladder.advance(&[1.0, 0.0], t);
            assert!((z[0] - libm::cos(t)).abs() < 1e-14, "{t}: {}", z[0] - libm::cos(t));
            assert!((z[1] + libm::sin(t)).abs() < 1e-14, "{t}: {}", z[1] + libm::sin(t));
        }
    }

    #[test]
    fn a_rate_that_is_no_double_keeps_its_phase_with_its_rest() {
        // A third of a radian a second, for 3 · 2^20 s: 2^20 rad. The third alone is off by 6e-11
        // rad.
        let third = Pair::from(1.0) / Pair::from(3.0);
        let turn =
            |omega: f64| Matrix::<2>::from_fn(|i, j| omega * [[0.0, 1.0], [-1.0, 0.0]][i][j]);
        let t = 3.0 * libm::ldexp(1.0, 20);
        let expect = libm::cos(libm::ldexp(1.0, 20));
        let error = |ladder: Ladder<2>| (ladder.flow(t).at(0, 0) - expect).abs();
        assert!(error(Ladder::<2>::with_rest(turn(third.high), t, || turn(third.low))) < 3e-16);
        assert!(error(Ladder::<2>::new(turn(third.high), t)) > 1e-12);
    }

    #[test]
    fn a_stiff_decay_is_exact_in_both_its_rates() {
        // z'' + 1001 z' + 1000 z = 0 from (1, 0): (1000 e^-t - e^-1000t) / 999.
        let ladder = Ladder::<2>::new(oscillator(1000.0, 1001.0), 1.0);
        for t in [1e-4, 1e-2, 1.0] {
            let exact = (1000.0 * libm::exp(-t) - libm::exp(-1000.0 * t)) / 999.0;
            assert!((ladder.advance(&[1.0, 0.0], t)[0] - exact).abs() < 1e-13);
        }
    }

    #[test]
    fn a_zero_row_stays_a_unit_row_bit_for_bit() {
        let rows = [[0.0, 0.0, 0.0], [3.0, -700.0, 2.0], [0.0, 0.0, 0.0]];
        let flow = Ladder::<3>::new(Matrix::from_fn(|i, j| rows[i][j]), 3.0).flow(2.9);
        for j in 0..3 {
            assert_eq!(flow.at(0, j).to_bits(), if j == 0 { 1.0_f64 } else { 0.0 }.to_bits());
        }
    }

    #[test]
    fn multiples_are_the_flows_one_by_one_though_the_last_of_them_is_too_large_for_a_number() {
        let ladder = Ladder::<1>::new(Matrix::from_fn(|_, _| 200.0), 10.0);
        let flows = ladder.multiples(1.0, 4);
        for (k, flow) in (1..=3).zip(&flows) {
            let exact = libm::exp(200.0 * f64::from(k));
            assert!((flow.at(0, 0) / exact - 1.0).abs() < 1e-13, "{k}: {}", flow.at(0, 0));
        }
        assert!(!flows[3].is_finite());
    }

    #[test]
    fn the_envelope_bounds_every_flow_inside_its_span() {
        let ladder = Ladder::<2>::new(oscillator(400.0, 3.0), 2.0);
        for rung in &ladder.rungs {
            for i in 0..=50 {
                let flow = ladder.flow(rung.span * f64::from(i) / 50.0);
                let inside = flow
                    .zip(&rung.envelope, |x, e| f64::from(u8::from(x.abs() <= e * (1.0 + 1e-12))));
                assert!(inside.columns.iter().flatten().all(|&ok| ok > 0.5), "{}", rung.span);
            }
        }
    }

    #[test]
    fn an_affine_product_is_the_product() {
        let rows = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [0.0, 0.0, 1.0]];
        let matrix = Matrix::<3>::from_fn(|i, j| rows[i][j]);
        let (quick, plain) =
            (matrix.apply_affine::<3>(&[7.0, 8.0, 1.0]), matrix.apply(&[7.0, 8.0, 1.0]));
        assert!(quick.iter().zip(plain).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    /// A lever with damping and spring that a sine pushes: (θ, θ̇, F, Ḟ, 1), split after 2.
    fn pushed() -> Matrix<5> {
        let rows = [
            [0.0, 1.0, 0.0, 0.0, 0.0],
            [-800.0, -200.0, 200.0, 0.0, -600.0],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, -2.5, 0.0, 5.0],
            [0.0; 5],
        ];
        Matrix::from_fn(|i, j| rows[i][j])
    }

    #[test]
    fn a_split_matrix_gives_the_products_of_any_other() {
        let a = pushed();
        let flow = Ladder::<5>::new(a, 0.0083).flow(0.0083);
        let v = [0.3, -2.0, 1.7, 0.4, 1.0];
        let change = [0.3, -2.0, 1.7, 0.4, 0.0];
        for (split, whole) in [
            (a.apply_split::<2>(&v), a.apply(&v)),
            (flow.apply_affine::<2>(&v), flow.apply(&v)),
            (a.apply_change::<2>(&change), a.apply(&change)),
        ] {
            assert!(split.iter().zip(whole).all(|(x, y)| (x - y).abs() < 1e-13), "{split:?}");
        }
        let apart = a.product_split::<2>(&flow).zip(&a.product(&flow), |x, y| x - y);
        assert!(apart.largest() < 1e-12);
    }

    #[test]
    fn the_ladder_of_a_split_matrix_has_the_same_flows_and_the_rate_of_its_faster_block() {
        let [split, whole] = [Ladder::<5, 2>::new(pushed(), 0.0083).flow(0.0083), {
            Ladder::<5>::new(pushed(), 0.0083).flow(0.0083)
        }];
        assert!(split.zip(&whole, |x, y| x - y).largest() < 1e-15);
        // λ² = 200 λ + 800 for the lever with its signs dropped, and ω of the sine alone.
        let lever = 100.0 + 10_800.0_f64.sqrt();
        assert!((growth_split::<5, 2>(&pushed()) - lever).abs() < 1e-12 * lever);
        let held = Matrix::from_fn(|i, j| if i < 2 { 0.0 } else { pushed().at(i, j) });
        assert!((growth_split::<5, 2>(&held) - 2.5_f64.sqrt()).abs() < 1e-15);
        assert!(growth_split::<5, 2>(&pushed().map(|_| f64::NAN)).is_nan());
    }

    #[test]
    fn the_radius_of_two_by_two_is_the_root_of_its_polynomial_at_any_size() {
        let radius = |[[a, b], [c, d]]: [[f64; 2]; 2]| {
            spectral_radius_2(&Matrix::<2>::from_fn(|i, j| [[a, b], [c, d]][i][j]))
        };
        for (matrix, expect) in [
            ([[0.0, 1.0], [400.0, 0.0]], 20.0),
            ([[2.0, 0.0], [5.0, 3.0]], 3.0),
            ([[1.0, 2.0], [3.0, 2.0]], 4.0),
            ([[0.0, 1e-300], [1e300, 0.0]], 1.0),
            ([[0.0, 1e300], [1e300, 0.0]], 1e300),
            ([[0.0; 2]; 2], 0.0),
        ] {
            assert!((radius(matrix) - expect).abs() <= 1e-15 * expect, "{matrix:?}");
        }
    }

    #[test]
    fn an_inverse_undoes_its_matrix_and_a_singular_matrix_has_none() {
        let rows = [[0.0, 2.0, 1.0], [1.0, 0.0, 3.0], [4.0, 1.0, 0.0]];
        let matrix = Matrix::<3>::from_fn(|i, j| rows[i][j]);
        let product = matrix.product(&matrix.inverse().unwrap());
        assert!(product.zip(&Matrix::identity(), |a, b| a - b).largest() < 1e-15);
        assert!(Matrix::<2>::from_fn(|_, _| 1.0).inverse().is_none());
    }

    #[test]
    fn the_spectral_radius_of_a_rotation_is_one_and_of_a_jordan_block_its_eigenvalue() {
        assert!((spectral_radius(&oscillator(1.0, 0.0)) - 1.0).abs() < 1e-9);
        let rows = [[2.0, 1.0], [0.0, 2.0]];
        assert!((spectral_radius(&Matrix::<2>::from_fn(|i, j| rows[i][j])) - 2.0).abs() < 1e-8);
        assert!(spectral_radius(&Matrix::<2>::ZERO).abs() < 1e-300);
    }
}
