//! A run of the exact solver: sample after sample, from event to event.

use super::block::BLOCK;
use super::compiled::Compiled;
use super::work::Sums;
use super::{Exact, Prepared};
use crate::energy::EnergyBalance;
use crate::error::{DynamicsError, Result, in_bounds};
use crate::solve::{Grid, shorten};
use crate::system::region::Region;
use crate::system::transition::EventKind;
use crate::system::{Cursor, System, THETA};
use crate::trajectory::{Event, Trajectory, WorkCounts};

/// The state with its rate and guard values, the counts, and the regions met so far.
pub(super) struct Run<'a, const N: usize, const G: usize> {
    limits: Exact,
    system: &'a System,
    reach_s: f64,
    regions: Vec<Compiled<N, G>>,
    current: usize,
    cursor: Cursor,
    z: [f64; N],
    rate: [f64; N],
    guards: [f64; G],
    events: Vec<Event>,
    pieces: u64,
    compiled: u64,
    sums: Sums,
    impacts_j: f64,
}

/// Sines are taken from their closed form again after so many samples, so that rounding cannot pile
/// up.
const FRESH_INPUT_SAMPLES: usize = 256;

impl<const N: usize, const G: usize> Prepared for Run<'_, N, G> {
    fn run_into(
        &mut self,
        grid: &Grid,
        out: &mut Trajectory,
    ) -> std::result::Result<(), DynamicsError> {
        out.clear(self.system.layout, grid.samples());
        self.along(grid, &mut |t, z: &[f64; N], region| out.push(t, z, region))?;
        self.finish(grid, out);
        Ok(())
    }

    fn visit(
        &mut self,
        grid: &Grid,
        visit: &mut dyn FnMut(f64, &[f64]),
    ) -> std::result::Result<Trajectory, DynamicsError> {
        let mut out = Trajectory::new(self.system.layout, 0);
        self.along(grid, &mut |t, z: &[f64; N], _| visit(t, z))?;
        self.finish(grid, &mut out);
        Ok(out)
    }
}

impl<'a, const N: usize, const G: usize> Run<'a, N, G> {
    pub(super) fn new(limits: Exact, system: &'a System, reach_s: f64) -> Self {
        let (full, cursor) = system.start();
        Self {
            limits,
            system,
            reach_s,
            regions: Vec::new(),
            current: 0,
            cursor,
            z: shorten(&full),
            rate: [0.0; N],
            guards: [0.0; G],
            events: Vec::new(),
            pieces: 0,
            compiled: 0,
            sums: Sums::default(),
            impacts_j: 0.0,
        }
    }

    fn restart(&mut self, t: f64) -> Result<()> {
        let (mut full, mut cursor) = self.system.start();
        self.system.pass(&mut cursor, t, &mut full);
        let region = self.system.first_region(&full);
        (self.z, self.cursor) = (shorten(&full), cursor);
        self.events.clear();
        (self.pieces, self.compiled) = (0, 0);
        (self.sums, self.impacts_j) = (Sums::default(), 0.0);
        self.enter(&region, t)?;
        self.note(t, EventKind::Input);
        Ok(())
    }

    fn along(&mut self, grid: &Grid, record: &mut impl FnMut(f64, &[f64; N], u16)) -> Result<()> {
        self.restart(grid.time(0))?;
        let swings = self.system.swings();
        record(grid.time(0), &self.z, self.current as u16);
        let mut i = 0;
        while i + 1 < grid.samples() {
            if i.is_multiple_of(BLOCK) && self.cross_block(grid, i, swings, record) {
                i += BLOCK;
                continue;
            }
            i += 1;
            let (from, to) = (grid.time(i - 1), grid.time(i));
            if self.cursor.end_s >= to {
                self.cross(from, grid.step(i - 1))?;
            } else {
                self.cross_spans(from, to)?;
            }
            // What begins at the last sample lies beyond the run.
            if self.cursor.end_s <= to && i + 1 < grid.samples() {
                self.pass_input(to)?;
            } else if swings && i.is_multiple_of(FRESH_INPUT_SAMPLES) {
                self.system.write_inputs(&self.cursor, to, &mut self.z);
                self.refresh();
            }
            record(to, &self.z, self.current as u16);
        }
        Ok(())
    }

    /// A block of even steps from sample `i` on, one product a sample; false, with nothing done, if
    /// an event or the end of an input's span may lie inside.
    #[inline]
    fn cross_block(
        &mut self,
        grid: &Grid,
        i: usize,
        swings: bool,
        record: &mut impl FnMut(f64, &[f64; N], u16),
    ) -> bool {
        let Grid::Even { step_s, steps } = grid else { return false };
        let last = i + BLOCK;
        if last > *steps || self.cursor.end_s <= grid.time(last) {
            return false;
        }
        let free =
            self.regions[self.current].free_block(*step_s, &self.z, &self.rate, &self.guards);
        let Some(flow) = free else { return false };
        let mut z = self.z;
        for k in i + 1..last {
            z = flow.apply_affine(&z);
            record(grid.time(k), &z, self.current as u16);
        }
        self.z = flow.apply_affine(&z);
        if swings && last.is_multiple_of(FRESH_INPUT_SAMPLES) {
            self.system.write_inputs(&self.cursor, grid.time(last), &mut self.z);
        }
        self.refresh();
        record(grid.time(last), &self.z, self.current as u16);
        true
    }

    /// Everything but the samples.
    fn finish(&self, grid: &Grid, out: &mut Trajectory) {
        let steps = grid.samples() as u64 - 1;
        let evaluations = steps + self.pieces;
        out.work = WorkCounts { steps, rejected: 0, evaluations, factorisations: self.compiled };
        out.events.extend_from_slice(&self.events);
        out.regions.extend(self.regions.iter().map(|compiled| compiled.region));
        out.energy = self.limits.energy.then(|| self.balance());
    }

    /// An interval inside which inputs go over to their next spans.
    fn cross_spans(&mut self, from: f64, to: f64) -> Result<()> {
        let mut at = from;
        while self.cursor.end_s < to {
            let end = self.cursor.end_s;
            self.pieces += 1;
            if self.pieces > self.limits.most_pieces {
                return Err(self.too_much(self.limits.most_pieces, "pieces", at));
            }
            self.cross(at, end - at)?;
            self.pass_input(end)?;
            at = end;
        }
        self.cross(at, to - at)
    }

    /// From one span of the inputs to the next; only a jump can change the region.
    #[inline]
    fn pass_input(&mut self, t: f64) -> Result<()> {
        let jump = self.system.pass(&mut self.cursor, t, &mut self.z);
        if jump {
            return self.happen(t, EventKind::Input);
        }
        self.refresh();
        Ok(())
    }

    /// Over `h` seconds from `t` on, within one span of the inputs.
    #[inline]
    fn cross(&mut self, t: f64, h: f64) -> Result<()> {
        let compiled = &mut self.regions[self.current];
        if compiled.is_ready(h) {
            if let Some(step) = compiled.even_step()
                && let Some((next, guards)) = step.free(&self.z, &self.rate, &self.guards)
            {
                self.rate = step.rate.apply_affine(&self.z);
                if let Some(work) = &compiled.work {
                    work.add(&self.z, h, &mut self.sums);
                }
                (self.z, self.guards) = (next, guards);
                return Ok(());
            }
        } else if self.cross_uneven(h) {
            return Ok(());
        }
        self.search(t, h)
    }

    /// The same for a step of any length; false, with nothing done, if an event may lie inside.
    #[inline]
    fn cross_uneven(&mut self, h: f64) -> bool {
        self.pieces += 1;
        let compiled = &self.regions[self.current];
        let (next, cover) = compiled.far(&self.z, h);
        let guards = compiled.flow.guards.apply(&next);
        if !compiled.flow.sags[cover].safe(&self.rate, &self.guards, &guards) {
            return false;
        }
        if let Some(work) = &compiled.work {
            work.add(&self.z, h, &mut self.sums);
        }
        self.rate = compiled.flow.rate(&next);
        (self.z, self.guards) = (next, guards);
        true
    }

    /// Piece by piece where an event may lie inside.
    fn search(&mut self, t: f64, h: f64) -> Result<()> {
        // Compensated (Kahan): thousands of events in one interval must not add up their rounding.
        let (mut elapsed, mut excess, mut rest) = (0.0, 0.0, h);
        while rest > 0.0 {
            let compiled = &self.regions[self.current];
            let before = self.z;
            let limit = self.limits.most_pieces;
            let found = compiled.scan(&mut self.z, rest, &mut self.pieces, limit);
            if let Some(work) = &compiled.work {
                work.add(&before, found.map_or(rest, |(after, _)| after), &mut self.sums);
            }
            if self.pieces > limit {
                return Err(self.too_much(limit, "pieces", t));
            }
            let Some((after, kind)) = found else {
                if compiled.flow.ladder.is_long(rest) {
                    // The many short pieces that proved it free of events were rounded as often;
                    // some long ones are not.
                    self.z = compiled.flow.ladder.advance(&before, rest);
                }
                break;
            };
            let exact = after - excess;
            let sum = elapsed + exact;
            excess = (sum - elapsed) - exact;
            elapsed = sum;
            rest = (h - elapsed) + excess;
            self.happen(t + elapsed, kind)?;
            if self.cross_uneven(rest) {
                break;
            }
        }
        if !in_bounds(&self.z) {
            return Err(DynamicsError::NotFinite { t_s: t + h, suspect: self.system.suspect() });
        }
        self.refresh();
        Ok(())
    }

    /// Carries an event out and enters the region that follows.
    fn happen(&mut self, t: f64, kind: EventKind) -> Result<()> {
        if self.events.len() as u64 > self.limits.most_events {
            return Err(self.too_much(self.limits.most_events, "events", t));
        }
        let region = self.regions[self.current].region;
        let before_j = self.system.stored_j(&self.z);
        let next = self.system.transit(&region, kind, &mut self.z);
        self.impacts_j += self.system.stored_j(&self.z) - before_j;
        self.enter(&next, t)?;
        self.note(t, kind);
        Ok(())
    }

    fn note(&mut self, t_s: f64, kind: EventKind) {
        let region = self.regions[self.current].region;
        self.events.push(Event { t_s, kind, theta_rad: self.z[THETA], region });
    }

    fn enter(&mut self, region: &Region, t: f64) -> Result<()> {
        let known = self.regions.iter().position(|compiled| compiled.region.resembles(region));
        self.current = known.unwrap_or(self.regions.len());
        if known.is_none_or(|at| self.regions[at].region != *region) {
            self.compile(region);
        }
        if !self.regions[self.current].flow.ladder.reaches(self.reach_s) {
            return Err(DynamicsError::NotFinite { t_s: t, suspect: self.system.suspect() });
        }
        self.refresh();
        Ok(())
    }

    /// Makes a region ready, in place of the one it differs from in numbers only.
    fn compile(&mut self, region: &Region) {
        self.compiled += 1;
        let compiled = Compiled::new(self.system, region, self.reach_s, self.limits.energy);
        match self.regions.get_mut(self.current) {
            Some(slot) => *slot = compiled,
            None => self.regions.push(compiled),
        }
    }

    /// Rate and guard values of the state.
    #[inline]
    fn refresh(&mut self) {
        let compiled = &self.regions[self.current];
        self.rate = compiled.flow.rate(&self.z);
        self.guards = compiled.flow.guards.apply(&self.z);
    }

    fn balance(&self) -> EnergyBalance {
        let [external_j, motor_j, brake_j, friction_j, terms_j, tissue_j] = self.sums;
        let (start, _) = self.system.start();
        let stored_j = self.system.stored_j(&self.z) - self.system.stored_j(&start);
        let impacts_j = self.impacts_j;
        EnergyBalance {
            external_j,
            motor_j,
            brake_j,
            friction_j,
            terms_j,
            tissue_j,
            impacts_j,
            stored_j,
        }
    }

    fn too_much(&self, limit: u64, what: &'static str, t_s: f64) -> DynamicsError {
        DynamicsError::TooMuchWork { limit, what, t_s, suspect: self.system.suspect() }
    }
}
