//! A prepared region: its ladder of exponentials, its guards, and bounds that prove an interval
//! free of events.

use zwidth_numerics::expm::{self, Ladder, Matrix, ORDER};
use zwidth_numerics::roots;

use super::functionals::{Functionals, Sag, all_above};
use crate::error::in_bounds;

/// Events are located to this share of the piece they lie in: as finely as rounding lets, because
/// what is zero at an event is set to zero there. A piece is an eighth of the fastest time constant at
/// most.
const RESOLUTION: f64 = 1e-16;

/// Rounding of a functional, relative to the sum of its terms' sizes.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The first guard that fell below zero, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fall {
    /// Time from the start, s.
    pub(crate) after_s: f64,
    /// Its place among the guards.
    pub(crate) guard: usize,
}

/// The flow ż = A z of a region with its guards, ready for spans of any length; A is split after
/// `D` (see [`Matrix`]).
#[derive(Debug, Clone)]
pub(crate) struct ReadyFlow<const N: usize, const D: usize, const G: usize> {
    pub(crate) ladder: Ladder<N, D>,
    pub(crate) guards: Functionals<N, G>,
    /// Number of guards; in the places after them stands the constant 1.
    count: usize,
    /// How far the guards can sag over each rung.
    pub(crate) sags: Vec<Sag<N, G>>,
}

impl<const N: usize, const D: usize, const G: usize> ReadyFlow<N, D, G> {
    /// The flow with its guards, at most `G`.
    pub(crate) fn new(ladder: Ladder<N, D>, guards: impl IntoIterator<Item = [f64; N]>) -> Self {
        // Places without a guard hold the state's constant entry, which never falls below zero.
        let mut rows = [std::array::from_fn(|j| f64::from(u8::from(j == N - 1))); G];
        let mut count = 0;
        for (row, guard) in rows.iter_mut().zip(guards) {
            *row = guard;
            count += 1;
        }
        let guards = Functionals::from_rows(&rows);
        let sizes = guards.map(f64::abs);
        let rungs = ladder.rungs.iter();
        let sags = rungs.map(|rung| Sag::new::<D>(&sizes, &rung.envelope, rung.span)).collect();
        Self { ladder, guards, count, sags }
    }

    /// |w| of each guard.
    pub(crate) fn sizes(&self) -> Functionals<N, G> {
        self.guards.map(f64::abs)
    }

    /// ż at a state.
    #[inline]
    pub(crate) fn rate(&self, z: &[f64; N]) -> [f64; N] {
        self.ladder.a.apply_affine::<D>(z)
    }

    /// z̈ where the rate is ż.
    #[inline]
    pub(crate) fn bend(&self, rate: &[f64; N]) -> [f64; N] {
        self.ladder.a.apply_change::<D>(rate)
    }

    /// How far the guards can sag over `h` seconds.
    pub(crate) fn sag(&self, h: f64) -> Sag<N, G> {
        let envelope = &self.ladder.rungs[self.ladder.covering(h)].envelope;
        Sag::new::<D>(&self.sizes(), envelope, h)
    }

    /// True if no guard can fall below zero between two points that `sag` is for; false if in doubt
    /// or not a number. `rate` is ż and `bend` is z̈ at the first.
    #[inline]
    pub(crate) fn is_free(
        &self,
        sag: &Sag<N, G>,
        [rate, bend]: [&[f64; N]; 2],
        before: &[f64; G],
        after: &[f64; G],
    ) -> bool {
        let most = sag.most(bend);
        all_above(before, after, &most)
            || sag.doubtful(&most, &self.guards.apply_to_rate(rate), before, after) == [false; G]
    }

    /// Moves `z` over `span` seconds or to the first event: piece by piece, each as long as can be
    /// proved free of events; at the lowest rung by polynomials. A guard named `blind` is not
    /// looked at.
    pub(crate) fn scan(
        &self,
        z: &mut [f64; N],
        span: f64,
        blind: Option<usize>,
        pieces: &mut u64,
        most_pieces: u64,
    ) -> Option<Fall> {
        let top = self.ladder.rungs.len() - 1;
        let mut rate = self.rate(z);
        let mut bend = self.bend(&rate);
        let mut guards = self.values(z, blind);
        let mut elapsed = 0.0;
        let mut rest = span;
        let mut level = top;
        // Where a guard was seen below zero, from here on: no piece that reaches it is free.
        let mut below = f64::INFINITY;
        while rest > 0.0 && *pieces <= most_pieces && in_bounds(z) {
            while level > 0
                && (self.ladder.rungs[level].span > rest || self.ladder.rungs[level].span >= below)
            {
                level -= 1;
            }
            *pieces += 1;
            let rung = &self.ladder.rungs[level];
            let piece = rung.span.min(rest);
            let next = rung.flow.apply_affine::<D>(z);
            let after = self.values(&next, blind);
            let sag = &self.sags[level];
            if rung.span <= rest && self.is_free(sag, [&rate, &bend], &guards, &after) {
                (*z, guards) = (next, after);
            } else if level > 0 {
                if after.iter().any(|&value| value < 0.0) {
                    below = rung.span;
                }
                level -= 1;
                continue;
            } else {
                let slope = self.guards.apply_to_rate(&rate);
                let doubtful = sag.doubtful(&sag.most(&bend), &slope, &guards, &after);
                if let Some(Fall { after_s, guard }) = self.first_event(z, piece, &doubtful) {
                    return Some(Fall { after_s: elapsed + after_s, guard });
                }
                guards = self.values(z, blind);
            }
            elapsed += piece;
            rest -= piece;
            if rest <= 0.0 {
                break;
            }
            rate = self.rate(z);
            bend = self.bend(&rate);
            below = if below > piece { below - piece } else { f64::INFINITY };
            // A piece twice as long may be free again, now that this one is passed.
            level = (level + 1).min(top);
        }
        None
    }

    /// Guard values, without the blind one.
    #[inline]
    fn values(&self, z: &[f64; N], blind: Option<usize>) -> [f64; G] {
        let mut values = self.guards.apply(z);
        if let Some(at) = blind {
            values[at] = f64::INFINITY;
        }
        values
    }

    /// The first event of the doubtful guards within a piece no longer than the lowest rung, by
    /// Taylor polynomials; `z` is moved to it or to the piece's end.
    fn first_event(&self, z: &mut [f64; N], piece: f64, doubtful: &[bool; G]) -> Option<Fall> {
        let series = expm::taylor::<N, D>(&self.ladder.a, z);
        let size = sizes(&self.ladder.a.map(f64::abs), z, piece);
        let mut first: Option<Fall> = None;
        for guard in (0..self.count).filter(|guard| doubtful[*guard]) {
            let w = self.guards.row(guard);
            let mut p: [f64; ORDER + 1] = series.map(|c| expm::dot(&w, &c));
            // A guard that is zero but for rounding has not fallen: it is lifted by as much.
            p[0] += ROUNDING * expm::dot(&w.map(f64::abs), &size);
            // Only an earlier fall takes its place: of guards that fall at one instant the first
            // counts.
            let until = first.map_or(piece, |fall| fall.after_s);
            if let Some(after_s) = roots::first_descent(&p, until, piece * RESOLUTION)
                && (first.is_none() || after_s < until)
            {
                first = Some(Fall { after_s, guard });
            }
        }
        *z = expm::evaluate(&series, first.map_or(piece, |fall| fall.after_s));
        first
    }
}

/// Size of each entry of the state and of its change over a time, of a rate matrix with these
/// absolute values: what its rounding is relative to.
pub(crate) fn sizes<const N: usize>(absolute: &Matrix<N>, z: &[f64; N], over_s: f64) -> [f64; N] {
    let size = z.map(f64::abs);
    let change = absolute.apply(&size);
    std::array::from_fn(|i| size[i] + over_s * change[i])
}
