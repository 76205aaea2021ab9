//! Several even steps at once: where no event can lie in a whole block, each of its samples costs
//! one product.

use zwidth_numerics::expm::{Ladder, Matrix};

use crate::affine::{Functionals, Sag};

/// Steps in a block.
pub(super) const BLOCK: usize = 8;

/// What proves a block of even steps free of events.
#[derive(Debug, Clone)]
pub(super) struct Block<const N: usize, const G: usize> {
    /// Guard values after the block.
    guards: Functionals<N, G>,
    sag: Sag<N, G>,
}

impl<const N: usize, const G: usize> Block<N, G> {
    /// The block of steps `h` with the given flow.
    ///
    /// A guard `w · z` moves by `w Ψ(t) ż(0)` with `Ψ(t) = ∫₀ᵗ exp(A s) ds`. How far each entry of
    /// `w Ψ` strays from its chord over the block is taken at every step; between two steps it
    /// strays from *their* chord by at most `|w A exp(A k h)| E h²/8`, with the envelope E of a
    /// step. So a fast mode that dies out within a step counts with what it moves a guard by,
    /// not with its initial curvature over the whole block.
    pub(super) fn new(
        guards: &Functionals<N, G>,
        ladder: &Ladder<N>,
        flow: &Matrix<N>,
        h: f64,
    ) -> Self {
        let moved = guards_moved(guards, flow, &integral(ladder, h));
        let whole = &moved[BLOCK];
        let envelope = &ladder.rungs[ladder.covering(h)].envelope;
        let mut sag = Functionals::ZERO;
        let mut bend = guards.after(&ladder.a);
        for k in 0..BLOCK {
            let between = Sag::new(&bend.map(f64::abs), envelope, h);
            let stray = [k, k + 1].map(|k| {
                moved[k].zip(whole, |at, end| (at - end * (k as f64 / BLOCK as f64)).abs())
            });
            let highest = stray[0].zip(&stray[1], f64::max).zip(&between.0, |at, more| at + more);
            sag = sag.zip(&highest, f64::max);
            bend = bend.after(flow);
        }
        let after = (0..BLOCK).fold(guards.clone(), |after, _| after.after(flow));
        Self { guards: after, sag: Sag(sag) }
    }

    /// True if no event can lie inside the block.
    #[inline]
    pub(super) fn is_free(&self, z: &[f64; N], rate: &[f64; N], guards: &[f64; G]) -> bool {
        self.sag.safe(rate, guards, &self.guards.apply(z))
    }
}

/// `w Ψ(k h)` for k = 0 … BLOCK: `Ψ((k+1) h) = Ψ(k h) + exp(A k h) Ψ(h)`.
fn guards_moved<const N: usize, const G: usize>(
    guards: &Functionals<N, G>,
    flow: &Matrix<N>,
    integral: &Matrix<N>,
) -> Vec<Functionals<N, G>> {
    let (mut at, mut sum) = (guards.clone(), Functionals::ZERO);
    let mut moved = vec![sum.clone()];
    for _ in 0..BLOCK {
        sum = sum.zip(&at.after(integral), |a, b| a + b);
        at = at.after(flow);
        moved.push(sum.clone());
    }
    moved
}

/// `∫₀ʰ exp(A s) ds`, by Simpson's rule on spans no longer than the ladder's lowest rung, doubled
/// up to `h`: `Ψ(2s) = Ψ(s) + exp(A s) Ψ(s)`.
fn integral<const N: usize>(ladder: &Ladder<N>, h: f64) -> Matrix<N> {
    let doublings =
        if h > ladder.rungs[0].span { libm::ilogb(h / ladder.rungs[0].span) + 1 } else { 0 };
    let span = libm::ldexp(h, -doublings);
    let (middle, mut flow) = (ladder.flow(0.5 * span), ladder.flow(span));
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
    fn a_free_block_has_no_dip_however_short_and_quiet_blocks_are_often_free() {
        let (guards, ladder, flow, h) = stiff();
        let block = Block::new(&guards, &ladder, &flow, h);
        let short = ladder.flow(h / 64.0);
        let (mut free, mut quiet) = (0, 0);
        for k in 0..2_000 {
            let (theta, omega) =
                (0.6 * libm::sin(f64::from(k)), 1.5 * libm::sin(0.7 * f64::from(k * k)));
            let mut z = [theta, omega, 1.0];
            let rate = ladder.a.apply(&z);
            let found = block.is_free(&z, &rate, &guards.apply(&z));
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
