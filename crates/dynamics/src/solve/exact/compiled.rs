//! A prepared region of a system, with its prepared steps.

use zwidth_numerics::expm::{Ladder, Matrix};

use super::block::{self, BLOCK, Block, CHAIN};
use super::uneven::Table;
use super::work::Work;
use crate::affine::{ReadyFlow, Sag};
use crate::solve::shorten;
use crate::system::System;
use crate::system::region::Region;
use crate::system::transition::EventKind;

/// A step of fixed length, ready to use.
#[derive(Debug, Clone)]
pub(super) struct EvenStep<const N: usize, const D: usize, const G: usize> {
    h: f64,
    /// Flows over 1, 2, … steps, up to as many as were asked for.
    flows: Vec<Matrix<N>>,
    sag: Sag<N, G>,
    /// What proves a block of steps free, once enough of them were taken.
    block: Option<Block<N, G>>,
    /// Blocks asked for.
    asked: u32,
}

impl<const N: usize, const D: usize, const G: usize> EvenStep<N, D, G> {
    /// The flow over `k` steps, from 1 to [`CHAIN`].
    #[inline]
    pub(super) fn flow(&mut self, k: usize) -> &Matrix<N> {
        while self.flows.len() < k {
            self.flows.push(block::power::<N, D>(&self.flows));
        }
        &self.flows[k - 1]
    }
}

/// State, its rate and the guard values at a moment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moment<const N: usize, const G: usize> {
    pub(super) z: [f64; N],
    pub(super) rate: [f64; N],
    pub(super) guards: [f64; G],
}

/// The steps that regions are made ready for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// The longest, s.
    pub(super) longest_s: f64,
    /// Whether all are equally long; then pieces are halves of one, and leave nothing over.
    pub(super) even: bool,
}

/// A region ready for exact steps.
#[derive(Debug, Clone)]
pub(super) struct Compiled<const N: usize, const D: usize, const G: usize> {
    pub(super) region: Region,
    pub(super) flow: ReadyFlow<N, D, G>,
    kinds: [EventKind; G],
    pub(super) work: Option<Work<N, D>>,
    step: Option<Box<EvenStep<N, D, G>>>,
    table: Option<Table<N, D>>,
    uneven: u32,
    /// Whether it is prepared for an even grid.
    even: bool,
    reach_s: f64,
    /// Whether its flow over the reach is finite.
    pub(super) reaches: bool,
    /// Length of the last interval without a prepared step; the second of its kind gets one.
    wanted_h: f64,
}

impl<const N: usize, const D: usize, const G: usize> Compiled<N, D, G> {
    pub(super) fn new(system: &System, region: &Region, reach: Reach, energy: bool) -> Self {
        let flow = system.flow(region);
        let a = Matrix::from_fn(|i, j| flow.rows[i].0[j]);
        let reach_s = reach.longest_s;
        // What rounding took from the matrix.
        let rest = || {
            let rest = system.rest(region);
            Matrix::from_fn(|i, j| rest[i][j])
        };
        let ladder = match reach.even {
            true => Ladder::halving(a, reach_s, rest),
            false => Ladder::with_rest(a, reach_s, rest),
        };
        let guards = flow.guards.iter().map(|guard| shorten(&guard.value.row.0));
        Self {
            reaches: ladder.reaches(reach_s),
            region: *region,
            flow: ReadyFlow::new(ladder, guards),
            // Places without a guard never fall.
            kinds: std::array::from_fn(|i| {
                flow.guards.get(i).map_or(EventKind::Input, |guard| guard.kind)
            }),
            work: energy.then(|| Work::new(system, region, &a, reach_s)),
            step: None,
            table: None,
            uneven: 0,
            even: reach.even,
            reach_s,
            wanted_h: f64::NAN,
        }
    }

    /// Whether a step of this length is prepared. The first of an even grid is at once; another
    /// when the same length is asked for twice in a row, so that uneven steps, which never are, do
    /// not pay for it.
    #[inline]
    pub(super) fn is_ready(&mut self, h: f64, even: bool) -> bool {
        /// Steps that have to be uneven before the table for them, which costs some tens of them,
        /// is worth it; thousands of them where its flows are computed in twice the precision.
        const WORTH: [u32; 2] = [32, 4096];
        if self.step.as_ref().is_some_and(|step| step.h.to_bits() == h.to_bits()) {
            return true;
        }
        let first = even && self.step.is_none();
        // Once there is a table, a step of its own is not worth making: others follow it.
        let again = self.wanted_h.to_bits() == h.to_bits() && self.table.is_none();
        // What is left over at an even grid's end is the same in every run, and not worth it
        // either.
        let wanted = first || again && (even || !self.even);
        self.wanted_h = h;
        if wanted {
            self.step = Some(Box::new(self.prepare(h)));
        } else {
            self.uneven += 1;
            if self.uneven == WORTH[usize::from(self.flow.ladder.is_long(self.reach_s))] {
                self.table = Table::new(&self.flow.ladder, self.reach_s);
            }
        }
        wanted
    }

    /// State, rate and guard values at a state.
    #[inline]
    pub(super) fn look(&self, z: [f64; N]) -> Moment<N, G> {
        Moment { z, rate: self.flow.rate(&z), guards: self.flow.guards.apply(&z) }
    }

    /// What is after a block of steps, if one of this length is prepared and free of events, and no
    /// work is integrated; the states after each step are written into `states`.
    #[inline]
    pub(super) fn free_block(
        &mut self,
        h: f64,
        from: &Moment<N, G>,
        states: &mut [[f64; N]; BLOCK],
    ) -> Option<Moment<N, G>> {
        /// Blocks asked for before the proof of one, which costs as much as some steps, is worth it.
        const WORTH: u32 = 2;
        if !self.is_ready(h, true) || self.work.is_some() {
            return None;
        }
        let step = self.step.as_mut()?;
        step.asked += u32::from(step.block.is_none());
        if step.asked == WORTH && step.block.is_none() {
            step.flow(CHAIN);
            step.block = Some(Block::new(&self.flow, step.flows.first_chunk()?, h));
        }
        let block = step.block.as_ref()?;
        let [one, two, three, four]: &[Matrix<N>; CHAIN] = step.flows.first_chunk()?;
        states[0] = one.apply_affine::<D>(&from.z);
        states[1] = two.apply_affine::<D>(&from.z);
        states[3] = four.apply_affine::<D>(&from.z);
        states[7] = four.apply_affine::<D>(&states[3]);
        let guards = [0, 1, 3, 7].map(|at| self.flow.guards.apply(&states[at]));
        if !block.is_free(&self.flow.bend(&from.rate), &from.guards, &guards) {
            return None;
        }
        states[2] = three.apply_affine::<D>(&from.z);
        states[4] = one.apply_affine::<D>(&states[3]);
        states[5] = two.apply_affine::<D>(&states[3]);
        states[6] = three.apply_affine::<D>(&states[3]);
        let [.., guards] = guards;
        Some(Moment { z: states[7], rate: self.flow.rate(&states[7]), guards })
    }

    /// What is after the prepared step from `from`, the last of `k` from `base`, at most [`CHAIN`];
    /// none if an event may lie inside.
    #[inline]
    pub(super) fn free_step(
        &mut self,
        base: &[f64; N],
        k: usize,
        from: &Moment<N, G>,
    ) -> Option<Moment<N, G>> {
        let next = self.stepped(base, k)?;
        let after = self.look(next);
        let bend = self.flow.bend(&from.rate);
        let sag = &self.step.as_ref()?.sag;
        self.flow.is_free(sag, [&from.rate, &bend], &from.guards, &after.guards).then_some(after)
    }

    /// `k` prepared steps from `base` on, at most [`CHAIN`].
    #[inline]
    pub(super) fn stepped(&mut self, base: &[f64; N], k: usize) -> Option<[f64; N]> {
        self.step.as_mut().map(|step| step.flow(k).apply_affine::<D>(base))
    }

    /// State after a span of any length up to the reach, and the number of the bound that covers
    /// it; `bend` is z̈ now.
    #[inline]
    pub(super) fn far(&self, from: &Moment<N, G>, bend: &[f64; N], span: f64) -> ([f64; N], usize) {
        let ladder = &self.flow.ladder;
        let shorter = ladder.rungs.iter().rposition(|rung| rung.span < span);
        let cover = shorter.map_or(0, |at| at + 1).min(ladder.rungs.len() - 1);
        let next = match &self.table {
            Some(table) => table.advance(&ladder.a, [&from.z, &from.rate, bend], span),
            None => ladder.advance(&from.z, span),
        };
        (next, cover)
    }

    fn prepare(&self, h: f64) -> EvenStep<N, D, G> {
        let mut flows = Vec::with_capacity(CHAIN);
        flows.push(self.flow.ladder.flow(h));
        EvenStep { h, flows, sag: self.flow.sag(h), block: None, asked: 0 }
    }

    /// Moves `z` over `span` seconds or to the first event, whose time from the start and kind are
    /// returned.
    pub(super) fn scan(
        &self,
        z: &mut [f64; N],
        span: f64,
        pieces: &mut u64,
        most_pieces: u64,
    ) -> Option<(f64, EventKind)> {
        let fall = self.flow.scan(z, span, None, pieces, most_pieces)?;
        Some((fall.after_s, self.kinds[fall.guard]))
    }
}
