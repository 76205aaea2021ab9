//! Several even steps at once: if no event can lie in a whole block, each of its samples costs one
//! product, and these products do not wait for each other.

use zwidth_numerics::expm::Matrix;

use crate::affine::{Functionals, ReadyFlow, all_above};

/// Steps that are taken from one state, one product each, before the next state is taken instead.
pub(super) const CHAIN: usize = 4;
/// Steps in a block: two chains.
pub(super) const BLOCK: usize = 2 * CHAIN;
/// Steps after which the guards of a block are looked at: the first ones singly, for there a fast
/// mode may not have died out.
pub(super) const KNOTS: [usize; 4] = [1, 2, CHAIN, BLOCK];

/// What proves a block of even steps free of events.
///
/// Between two knots a guard `g = w · z` sags below its chord by at most `max|g''| width²/8`, and in
/// the step that begins at `k h`, `|g''| ≤ |w| |exp(A k h)| E |z̈(0)|` with the envelope E of a step;
/// in the second chain `|exp(A (k + 4) h)| ≤ |exp(A k h)| |exp(4 A h)|`. So a fast mode counts for the
/// first knots with its curvature, and for the later ones with what is left of it.
#[derive(Debug, Clone)]
pub(super) struct Block<const N: usize, const G: usize> {
    /// How far the guards can sag between any two knots, per |z̈| at the block's start.
    sag: Functionals<N, G>,
}

impl<const N: usize, const G: usize> Block<N, G> {
    /// The block of steps `h` with the flows over 1 … [`CHAIN`] of them, split after `D`.
    pub(super) fn new<const D: usize>(
        region: &ReadyFlow<N, D, G>,
        flows: &[Matrix<N>; CHAIN],
        h: f64,
    ) -> Self {
        /// Of the chord bound width²/8, for widths of one, two and four steps.
        const SAGS: [f64; 3] = [0.125, 0.5, 2.0];
        let larger = |a: &Matrix<N>, b: &Matrix<N>| a.zip(b, |x, y| if x > y { x } else { y });
        let [one, two, three, four] = flows.each_ref().map(|flow| flow.map(f64::abs));
        let early = larger(&Matrix::ZERO.shifted(1.0), &one);
        let late = larger(&two, &three);
        let second = larger(&early, &late).product_split::<D>(&four);
        let scaled = |matrix: &Matrix<N>, sag: f64| matrix.map(|x| x * sag * h * h);
        let most = larger(&scaled(&early, SAGS[0]), &scaled(&late, SAGS[1]));
        let most = larger(&most, &scaled(&second, SAGS[2]));
        let envelope = &region.ladder.rungs[region.ladder.covering(h)].envelope;
        Self { sag: region.sizes().after::<D>(&most.product_split::<D>(envelope)) }
    }

    /// True if no event can lie inside a block; `bend` is z̈ at its start, where the guards are
    /// `before`; at the knots they are `after`.
    #[inline]
    pub(super) fn is_free(
        &self,
        bend: &[f64; N],
        before: &[f64; G],
        after: &[[f64; G]; KNOTS.len()],
    ) -> bool {
        let sag = self.sag.apply_to_rate(&bend.map(f64::abs));
        let [first, second, third, last] = after;
        // The smaller of two, and the second if one is not a number: the last counts then.
        let least = |a: &[f64; G], b: &[f64; G]| -> [f64; G] {
            std::array::from_fn(|i| if a[i] < b[i] { a[i] } else { b[i] })
        };
        all_above(&least(before, first), &least(&least(second, third), last), &sag)
    }
}

/// The next power of a flow, of which the first powers are given, at least one. It is made of its
/// halves, so that few roundings are behind any, and of the changes `X = Φ − 1`, which keep their
/// leading digits: `X(s + t) = X(s) + X(t) + X(s) X(t)`.
pub(super) fn power<const N: usize, const D: usize>(flows: &[Matrix<N>]) -> Matrix<N> {
    let half = flows.len().div_ceil(2);
    let [a, b] = [half, flows.len() + 1 - half].map(|k| flows[k - 1].shifted(-1.0));
    let product = a.product_split::<D>(&b);
    a.zip(&b, |x, y| x + y).zip(&product, |sum, product| sum + product).shifted(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_numerics::expm::Ladder;

    /// Step, s.
    const H: f64 = 0.0083;

    /// A stiff, forced lever (θ, θ̇, 1) with guards on θ̇ and on θ, and the flows of a chain.
    fn stiff() -> (ReadyFlow<3, 2, 2>, Vec<Matrix<3>>) {
        let rows = [[0.0, 1.0, 0.0], [-800.0, -200.0, 430.0], [0.0, 0.0, 0.0]];
        let ladder = Ladder::new(Matrix::from_fn(|i, j| rows[i][j]), H);
        let mut flows = vec![ladder.flow(H)];
        (1..CHAIN).for_each(|_| flows.push(power::<3, 2>(&flows)));
        (ReadyFlow::new(ladder, [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.5]]), flows)
    }

    #[test]
    fn powers_are_the_flows_over_so_many_steps() {
        let (region, flows) = stiff();
        let ladder = Ladder::<3>::new(region.ladder.a, CHAIN as f64 * H);
        for (k, flow) in flows.iter().enumerate() {
            let apart = flow.zip(&ladder.flow((k + 1) as f64 * H), |x, y| (x - y).abs());
            let largest = apart.columns.iter().flatten().fold(0.0, |m: f64, x| m.max(*x));
            assert!(largest < 1e-14, "{k}: {largest}");
        }
    }

    #[test]
    fn a_free_block_has_no_dip_however_short_and_quiet_blocks_are_often_free() {
        let (region, flows) = stiff();
        let block = Block::new(&region, flows.first_chunk().unwrap(), H);
        let short = region.ladder.flow(H / 64.0);
        let (mut free, mut quiet) = (0, 0);
        for k in 0..2_000 {
            let (theta, omega) =
                (0.6 * libm::sin(f64::from(k)), 1.5 * libm::sin(0.7 * f64::from(k * k)));
            let mut z = [theta, omega, 1.0];
            let bend = region.bend(&region.rate(&z));
            let middle = flows[CHAIN - 1].apply(&z);
            let after = KNOTS.map(|k| {
                let (from, k) = if k > CHAIN { (&middle, k - CHAIN) } else { (&z, k) };
                region.guards.apply(&flows[k - 1].apply(from))
            });
            let found = block.is_free(&bend, &region.guards.apply(&z), &after);
            let mut least = f64::INFINITY;
            for _ in 0..=64 * BLOCK {
                least = region.guards.apply(&z).iter().fold(least, |m, g| m.min(*g));
                z = short.apply(&z);
            }
            assert!(!found || least >= 0.0, "{theta} {omega}: {least}");
            quiet += u32::from(least >= 0.0);
            free += u32::from(found);
        }
        assert!(quiet > 300 && 5 * free > quiet, "{free} of {quiet}");
    }
}
