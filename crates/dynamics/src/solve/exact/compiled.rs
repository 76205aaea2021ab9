//! A region made ready for exact steps: its ladder of exponentials, its guards, and bounds that
//! prove an interval free of events.

use zwidth_numerics::expm::{self, Ladder, Matrix, ORDER};
use zwidth_numerics::roots;

use super::block::Block;
use super::functionals::{Functionals, Sag};
use super::uneven::Table;
use super::work::Work;
use crate::error::in_bounds;
use crate::solve::shorten;
use crate::system::System;
use crate::system::region::Region;
use crate::system::transition::EventKind;

/// Events are located to this share of the piece they lie in: as finely as rounding lets, because
/// what is zero at an event is set to zero there. A piece is a thirty-second of the fastest time
/// constant at most.
const RESOLUTION: f64 = 1e-16;

/// Rounding of a functional, relative to the sum of its terms' sizes.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A step of fixed length, ready to use.
#[derive(Debug, Clone)]
pub(super) struct EvenStep<const N: usize, const G: usize> {
    h: f64,
    flow: Matrix<N>,
    /// Guard values after the step.
    guards: Functionals<N, G>,
    /// Rate after the step.
    pub(super) rate: Matrix<N>,
    sag: Sag<N, G>,
    /// What proves a block of steps free, once enough of them were taken.
    block: Option<Block<N, G>>,
    taken: u32,
}

impl<const N: usize, const G: usize> EvenStep<N, G> {
    /// State and guard values after the step, if no event can lie inside.
    #[inline]
    pub(super) fn free(
        &self,
        z: &[f64; N],
        rate: &[f64; N],
        guards: &[f64; G],
    ) -> Option<([f64; N], [f64; G])> {
        let after = self.guards.apply(z);
        self.sag.safe(rate, guards, &after).then(|| (self.flow.apply_affine(z), after))
    }
}

/// A region ready for exact steps.
#[derive(Debug, Clone)]
pub(super) struct Compiled<const N: usize, const G: usize> {
    pub(super) region: Region,
    pub(super) ladder: Ladder<N>,
    pub(super) guards: Functionals<N, G>,
    kinds: Vec<EventKind>,
    bend: Functionals<N, G>,
    /// |A|.
    absolute: Matrix<N>,
    pub(super) sags: Vec<Sag<N, G>>,
    pub(super) work: Option<Work<N>>,
    step: Option<Box<EvenStep<N, G>>>,
    table: Option<Table<N>>,
    uneven: u32,
    reach_s: f64,
    /// Length of the last interval without a prepared step; the second of its kind gets one.
    wanted_h: f64,
}

/// What rounding took from the matrix of a region.
fn rest<const N: usize>(system: &System, region: &Region) -> Matrix<N> {
    let rest = system.rest(region);
    Matrix::from_fn(|i, j| rest[i][j])
}

impl<const N: usize, const G: usize> Compiled<N, G> {
    pub(super) fn new(system: &System, region: &Region, reach_s: f64, energy: bool) -> Self {
        let flow = system.flow(region);
        let a = Matrix::from_fn(|i, j| flow.rows[i].0[j]);
        let ladder = Ladder::with_rest(a, reach_s, || rest(system, region));
        // Places without a guard hold the state's constant entry, which never falls below zero.
        let mut rows = [std::array::from_fn(|j| f64::from(u8::from(j == N - 1))); G];
        for (row, guard) in rows.iter_mut().zip(&flow.guards) {
            *row = shorten(&guard.value.row.0);
        }
        let guards = Functionals::from_rows(&rows);
        let bend = guards.after(&ladder.a).map(f64::abs);
        let sags =
            ladder.rungs.iter().map(|rung| Sag::new(&bend, &rung.envelope, rung.span)).collect();
        let kinds = flow.guards.iter().map(|guard| guard.kind).collect();
        let work = energy.then(|| Work::new(system, region, &ladder.a, reach_s));
        Self {
            region: *region,
            absolute: ladder.a.map(f64::abs),
            ladder,
            guards,
            kinds,
            bend,
            sags,
            work,
            step: None,
            table: None,
            uneven: 0,
            reach_s,
            wanted_h: f64::NAN,
        }
    }

    /// Whether a step of this length is prepared. One is when the same length is asked for twice in
    /// a row, so that uneven steps, which never are, do not pay for it.
    #[inline]
    pub(super) fn is_ready(&mut self, h: f64) -> bool {
        if self.step.as_ref().is_some_and(|step| step.h.to_bits() == h.to_bits()) {
            return true;
        }
        let wanted = self.wanted_h.to_bits() == h.to_bits();
        self.wanted_h = h;
        if wanted {
            self.step = Some(Box::new(self.prepare(h)));
        } else {
            self.count_uneven();
        }
        wanted
    }

    /// The flow over one step, if a block of these is prepared and free of events, and no work is
    /// integrated.
    #[inline]
    pub(super) fn free_block(
        &mut self,
        h: f64,
        z: &[f64; N],
        rate: &[f64; N],
        guards: &[f64; G],
    ) -> Option<&Matrix<N>> {
        /// Blocks asked for before the proof of one, which costs as much as the steps of some tens,
        /// is worth it.
        const WORTH: u32 = 32;
        let step = self
            .step
            .as_mut()
            .filter(|step| step.h.to_bits() == h.to_bits() && self.work.is_none())?;
        step.taken += u32::from(step.block.is_none());
        if step.taken == WORTH && step.block.is_none() {
            step.block = Some(Block::new(&self.guards, &self.ladder, &step.flow, h));
        }
        step.block
            .as_ref()
            .is_some_and(|block| block.is_free(z, rate, guards))
            .then_some(&step.flow)
    }

    /// The prepared step.
    #[inline]
    pub(super) fn even_step(&self) -> Option<&EvenStep<N, G>> {
        self.step.as_deref()
    }

    /// State after a span of any length up to the reach, and the number of the bound that covers
    /// it.
    #[inline]
    pub(super) fn far(&self, z: &[f64; N], span: f64) -> ([f64; N], usize) {
        let shorter = self.ladder.rungs.iter().rposition(|rung| rung.span < span);
        let cover = shorter.map_or(0, |at| at + 1).min(self.ladder.rungs.len() - 1);
        let next = match &self.table {
            Some(table) => table.advance(&self.ladder.a, z, span),
            None => self.ladder.advance(z, span),
        };
        (next, cover)
    }

    /// Counts a step of a new length; after some the table for them is made.
    #[inline]
    fn count_uneven(&mut self) {
        /// Steps that have to be uneven before the table, which costs some tens of them, is worth
        /// it.
        const WORTH: u32 = 32;
        self.uneven += 1;
        if self.uneven == WORTH {
            self.table = Some(Table::new(&self.ladder, self.reach_s));
        }
    }

    fn prepare(&self, h: f64) -> EvenStep<N, G> {
        let flow = self.ladder.flow(h);
        let cover = self.ladder.covering(h);
        let envelope = &self.ladder.rungs[cover].envelope;
        EvenStep {
            h,
            flow,
            guards: self.guards.after(&flow),
            rate: self.ladder.a.product(&flow),
            sag: Sag::new(&self.bend, envelope, h),
            block: None,
            taken: 0,
        }
    }

    /// Moves `z` over `span` seconds or to the first event, whose time from the start and kind are
    /// returned: piece by piece, each as long as can be proved free of events; at the lowest
    /// rung by polynomials.
    pub(super) fn scan(
        &self,
        z: &mut [f64; N],
        span: f64,
        pieces: &mut u64,
        most_pieces: u64,
    ) -> Option<(f64, EventKind)> {
        let top = self.ladder.rungs.len() - 1;
        let (mut rate, mut guards) = (self.ladder.a.apply_affine(z), self.guards.apply(z));
        let (mut elapsed, mut rest, mut level) = (0.0, span, top);
        while rest > 0.0 && *pieces <= most_pieces && in_bounds(z) {
            while level > 0 && self.ladder.rungs[level].span > rest {
                level -= 1;
            }
            *pieces += 1;
            let rung = &self.ladder.rungs[level];
            let piece = rung.span.min(rest);
            let next = rung.flow.apply_affine(z);
            let after = self.guards.apply(&next);
            if rung.span <= rest && self.sags[level].safe(&rate, &guards, &after) {
                (*z, guards) = (next, after);
            } else if level > 0 {
                level -= 1;
                continue;
            } else {
                let doubtful = self.sags[level].doubtful(&rate, &guards, &after);
                if let Some((after, kind)) = self.first_event(z, piece, &doubtful) {
                    return Some((elapsed + after, kind));
                }
                guards = self.guards.apply(z);
            }
            rate = self.ladder.a.apply_affine(z);
            elapsed += piece;
            rest -= piece;
            level = (level + 1).min(top);
        }
        None
    }

    /// The first event of the doubtful guards within a piece no longer than the lowest rung, by
    /// Taylor polynomials; `z` is moved to it or to the piece's end.
    fn first_event(
        &self,
        z: &mut [f64; N],
        piece: f64,
        doubtful: &[bool; G],
    ) -> Option<(f64, EventKind)> {
        let series = expm::taylor(&self.ladder.a, z);
        let size = self.sizes(z, piece);
        let mut first: Option<(f64, EventKind)> = None;
        for (i, kind) in self.kinds.iter().enumerate().filter(|(i, _)| doubtful[*i]) {
            let w = self.guards.row(i);
            let mut p: [f64; ORDER + 1] = series.map(|c| expm::dot(&w, &c));
            p[0] += ROUNDING * expm::dot(&w.map(f64::abs), &size);
            let until = first.map_or(piece, |(t, _)| t);
            if let Some(t) = roots::first_descent(&p, until, piece * RESOLUTION)
                && (first.is_none() || t < until)
            {
                first = Some((t, *kind));
            }
        }
        *z = expm::evaluate(&series, first.map_or(piece, |(t, _)| t));
        first
    }

    /// Size of each entry of the state and of its change over the piece: what its rounding is
    /// relative to.
    fn sizes(&self, z: &[f64; N], piece: f64) -> [f64; N] {
        let absolute = z.map(f64::abs);
        let change = self.absolute.apply(&absolute);
        std::array::from_fn(|i| absolute[i] + piece * change[i])
    }
}
