//! Several even steps at once: if no event can lie in a whole block, each of its samples costs one
//! product, and these products do not wait for each other.

use zwidth_numerics::expm::{Ladder, Matrix};

use crate::affine::{Functionals, Sag, all_above};

/// Steps in a block.
pub(super) const BLOCK: usize = 8;

/// What proves a block of even steps free of events, and rate and guards after it.
#[derive(Debug, Clone)]
pub(super) struct Block<const N: usize, const G: usize> {
    /// Rate after the block.
    rate: Matrix<N>,
    /// Guard values after the block.
    guards: Functionals<N, G>,
    /// How far the guards can stray from their chord over the block, per |ż| at its start.
    stray: Functionals<N, G>,
}

impl<const N: usize, const G: usize> Block<N, G> {
    /// The block of steps `h` with the flows over 1 … [`BLOCK`] of them.
    ///
    /// A guard `w · z` moves by `w Ψ(t) ż(0)` with `Ψ(t) = ∫₀ᵗ exp(A s) ds`. How far each entry of
    /// `w Ψ` strays from its chord over the block is taken at every step; between two steps it
    /// strays from *their* chord by at most `|w A exp(A k h)| E h²/8`, with the envelope E of a
    /// step. So a fast mode that dies out within a step counts with what it moves a guard by,
    /// not with its initial curvature over the whole block.
    pub(super) fn new(
        guards: &Functionals<N, G>,
        ladder: &Ladder<N>,
        flows: &[Matrix<N>],
        h: f64,
    ) -> Self {
        let flow = &flows[0];
        let last = &flows[BLOCK - 1];
        // `w Ψ(k h)` for k = 0 … BLOCK: `Ψ((k+1) h) = Ψ(k h) + exp(A k h) Ψ(h)`.
        let integral = integral(ladder, h);
        let mut at = guards.clone();
        let mut sum = Functionals::ZERO;
        let mut moved = vec![sum.clone()];
        for _ in 0..BLOCK {
            sum = sum.zip(&at.after(&integral), |a, b| a + b);
            at = at.after(flow);
            moved.push(sum.clone());
        }
        let whole = &moved[BLOCK];
        let envelope = &ladder.rungs[ladder.covering(h)].envelope;
        let mut most = Functionals::ZERO;
        let mut bend = guards.after(&ladder.a);
        for k in 0..BLOCK {
            let between = Sag::new(&bend.map(f64::abs), envelope, h);
            let stray = [k, k + 1].map(|k| {
                moved[k].zip(whole, |at, end| (at - end * (k as f64 / BLOCK as f64)).abs())
            });
            let highest =
                stray[0].zip(&stray[1], f64::max).zip(between.most(), |at, more| at + more);
            most = most.zip(&highest, f64::max);
            bend = bend.after(flow);
        }
        Self { guards: guards.after(last), rate: ladder.a.product(last), stray: most }
    }

    /// Rate and guard values after the block, if no event can lie inside.
    #[inline]
    pub(super) fn free(
        &self,
        z: &[f64; N],
        rate: &[f64; N],
        guards: &[f64; G],
    ) -> Option<([f64; N], [f64; G])> {
        let after = self.guards.apply(z);
        let stray = self.stray.apply_to_rate(&rate.map(f64::abs));
        all_above(guards, &after, &stray).then(|| (self.rate.apply_affine(z), after))
    }
}

/// The next power of a flow, of which the first powers are given, at least one. It is made of its
/// halves, so that few roundings are behind any, and of the changes `X = Φ − 1`, which keep their
/// leading digits: `X(s + t) = X(s) + X(t) + X(s) X(t)`.
pub(super) fn power<const N: usize>(flows: &[Matrix<N>]) -> Matrix<N> {
    let half = flows.len().div_ceil(2);
    let [a, b] = [half, flows.len() + 1 - half]
        .map(|k| flows[k - 1].zip(&Matrix::identity(), |x, unit| x - unit));
    let sum = a.zip(&b, |x, y| x + y).zip(&a.product(&b), |sum, product| sum + product);
    sum.zip(&Matrix::identity(), |x, unit| x + unit)
}

/// `∫₀ʰ exp(A s) ds`, by Simpson's rule on spans no longer than the ladder's lowest rung, doubled
/// up to `h`: `Ψ(2s) = Ψ(s) + exp(A s) Ψ(s)`.
fn integral<const N: usize>(ladder: &Ladder<N>, h: f64) -> Matrix<N> {
    let doublings =
        if h > ladder.rungs[0].span { libm::ilogb(h / ladder.rungs[0].span) + 1 } else { 0 };
    let span = libm::ldexp(h, -doublings);
    let middle = ladder.flow(0.5 * span);
    let mut flow = ladder.flow(span);
    let ends = flow.zip(&Matrix::identity(), |a, b| a + b);
    let mut sum = ends.zip(&middle, |a, b| (a + 4.0 * b) * span / 6.0);
    for _ in 0..doublings {
        sum = sum.zip(&flow.product(&sum), |a, b| a + b);
        flow = flow.product(&flow);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stiff, forced lever (θ, θ̇, 1) with guards on θ̇ and on θ, its step and its ladder.
    fn stiff() -> (Functionals<3, 2>, Ladder<3>, Matrix<3>, f64) {
        let rows = [[0.0, 1.0, 0.0], [-800.0, -200.0, 430.0], [0.0, 0.0, 0.0]];
        let ladder = Ladder::new(Matrix::from_fn(|i, j| rows[i][j]), 0.0083);
        let guards = Functionals::from_rows(&[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.5]]);
        let flow = ladder.flow(0.0083);
        (guards, ladder, flow, 0.0083)
    }

    #[test]
    fn powers_are_the_flows_over_so_many_steps() {
        let (_, _, flow, h) = stiff();
        let ladder = Ladder::new(stiff().1.a, 8.0 * h);
        let mut flows = vec![flow];
        (1..BLOCK).for_each(|_| flows.push(power(&flows)));
        for (k, flow) in flows.iter().enumerate() {
            let apart = flow.zip(&ladder.flow((k + 1) as f64 * h), |x, y| (x - y).abs());
            let largest = apart.columns.iter().flatten().fold(0.0, |m: f64, x| m.max(*x));
            assert!(largest < 1e-14, "{k}: {largest}");
        }
    }

    #[test]
    fn a_free_block_has_no_dip_however_short_and_quiet_blocks_are_often_free() {
        let (guards, ladder, flow, h) = stiff();
        let mut flows = vec![flow];
        (1..BLOCK).for_each(|_| flows.push(power(&flows)));
        let block = Block::new(&guards, &ladder, &flows, h);
        let short = ladder.flow(h / 64.0);
        let (mut free, mut quiet) = (0, 0);
        for k in 0..2_000 {
            let (theta, omega) =
                (0.6 * libm::sin(f64::from(k)), 1.5 * libm::sin(0.7 * f64::from(k * k)));
            let mut z = [theta, omega, 1.0];
            let rate = ladder.a.apply(&z);
            let found = block.free(&z, &rate, &guards.apply(&z)).is_some();
            let mut least = f64::INFINITY;
            for _ in 0..=64 * BLOCK {
                least = guards.apply(&z).iter().fold(least, |m, g| m.min(*g));
                z = short.apply(&z);
            }
            assert!(!found || least >= 0.0, "{theta} {omega}: {least}");
            quiet += u32::from(least >= 0.0);
            free += u32::from(found);
        }
        assert!(quiet > 300 && 5 * free > quiet, "{free} of {quiet}");
    }
}
