//! A run of the exact solver: sample after sample, from event to event.

use super::block::{BLOCK, CHAIN};
use super::compiled::{Compiled, Moment, Reach};
use super::work::Sums;
use super::{Exact, Prepared};
use crate::energy::EnergyBalance;
use crate::error::{Result, in_bounds};
use crate::solve::{Grid, shorten};
use crate::system::region::{Contact, Region};
use crate::system::row::MOST;
use crate::system::transition::EventKind;
use crate::system::{Cursor, System, THETA};
use crate::trajectory::{Event, Trajectory, WorkCounts};

/// A run that can also be moved from moment to moment.
pub(super) trait Stepped: Prepared + Send {
    /// Goes on from a state at a moment not before the last one, with the finger in a contact.
    fn take_up(&mut self, t_s: f64, z: &[f64], contact: Contact) -> Result<()>;
    /// Moves from one moment to another, not further than the reach.
    fn advance(&mut self, from_s: f64, to_s: f64) -> Result<()>;
    fn state(&self) -> &[f64];
    /// The region that holds.
    fn region(&self) -> &Region;
    /// Products with a flow matrix beside the moves, and exponentials.
    fn counts(&self) -> [u64; 2];
}

/// A run with the constants of a layout: entries, those before the inputs, and guards.
macro_rules! run_of {
    ($layout:expr, $arguments:tt, [$(($n:literal, $d:literal, $g:literal)),+]) => {
        match ($layout.n, $layout.dynamic, $layout.finger) {
            $(($n, $d, finger) if finger.is_some() == ($g == 6) => {
                Box::new(Run::<$n, $d, $g>::new $arguments)
            })+
            _ => Box::new(Run::<11, 6, 6>::new $arguments),
        }
    };
}

impl System {
    /// A run of the system. A region has at most four guards of the lever and actuators, and two
    /// of a finger.
    pub(super) fn stepped(&self, limits: Exact, reach: Reach) -> Box<dyn Stepped + '_> {
        run_of!(
            self.layout,
            (limits, self, reach),
            [
                (5, 2, 4),
                (6, 2, 4),
                (7, 2, 4),
                (6, 3, 4),
                (7, 3, 4),
                (8, 3, 4),
                (7, 4, 4),
                (8, 4, 4),
                (9, 4, 4),
                (7, 4, 6),
                (8, 4, 6),
                (9, 4, 6),
                (8, 5, 6),
                (9, 5, 6),
                (10, 5, 6),
                (9, 6, 6),
                (10, 6, 6)
            ]
        )
    }
}

/// The state with its rate and guard values, the counts, and the regions met so far.
struct Run<'a, const N: usize, const D: usize, const G: usize> {
    limits: Exact,
    system: &'a System,
    reach: Reach,
    regions: Vec<Compiled<N, D, G>>,
    current: usize,
    cursor: Cursor,
    now: Moment<N, G>,
    /// The state so many even steps ago (fewer than a chain), from which the next ones are taken
    /// too: one product each, none of which waits for another.
    base: [f64; N],
    steps: usize,
    /// Those after the steps of a block.
    states: [[f64; N]; BLOCK],
    events: Vec<Event>,
    pieces: u64,
    compiled: u64,
    sums: Sums,
    impacts_j: f64,
}

/// Sines are taken from their closed form again after so many samples, so that rounding cannot pile
/// up.
const FRESH_INPUT_SAMPLES: usize = 256;

/// Takes the samples of a run, one or several of a region at a time.
trait Record<const N: usize> {
    fn record<const K: usize>(&mut self, t_s: &[f64; K], states: &[[f64; N]; K], region: usize);
}

/// Keeps them.
struct Keep<'a>(&'a mut Trajectory);

impl<const N: usize> Record<N> for Keep<'_> {
    #[inline(always)]
    fn record<const K: usize>(&mut self, t_s: &[f64; K], states: &[[f64; N]; K], region: usize) {
        self.0.push(t_s, states, region as u16);
    }
}

/// Shows each of them to a function.
struct Show<'a>(&'a mut dyn FnMut(f64, &[f64]));

impl<const N: usize> Record<N> for Show<'_> {
    fn record<const K: usize>(&mut self, t_s: &[f64; K], states: &[[f64; N]; K], _: usize) {
        for (t, z) in t_s.iter().zip(states) {
            (self.0)(*t, z);
        }
    }
}

impl<const N: usize, const D: usize, const G: usize> Prepared for Run<'_, N, D, G> {
    fn run_into(&mut self, grid: &Grid, out: &mut Trajectory) -> Result<()> {
        out.clear(self.system.layout, grid.samples());
        self.along(grid, &mut Keep(out))?;
        self.finish(grid, out);
        Ok(())
    }

    fn visit(&mut self, grid: &Grid, visit: &mut dyn FnMut(f64, &[f64])) -> Result<Trajectory> {
        let mut out = Trajectory::new(self.system.layout, 0);
        self.along(grid, &mut Show(visit))?;
        self.finish(grid, &mut out);
        Ok(out)
    }
}

impl<const N: usize, const D: usize, const G: usize> Stepped for Run<'_, N, D, G> {
    fn take_up(&mut self, t_s: f64, z: &[f64], contact: Contact) -> Result<()> {
        let mut full = [0.0; MOST];
        full[..N].copy_from_slice(&z[..N]);
        self.system.pass(&mut self.cursor, t_s, &mut full);
        let region = self.system.settle(&full, contact, None);
        self.now.z = shorten(&full);
        self.enter(&region, t_s)
    }

    fn advance(&mut self, from_s: f64, to_s: f64) -> Result<()> {
        self.events.clear();
        if self.cursor.end_s >= to_s {
            self.cross(from_s, to_s - from_s, false)?;
        } else {
            self.cross_spans(from_s, to_s)?;
        }
        if self.cursor.end_s <= to_s { self.pass_input(to_s) } else { Ok(()) }
    }

    fn state(&self) -> &[f64] {
        &self.now.z
    }

    fn region(&self) -> &Region {
        &self.regions[self.current].region
    }

    fn counts(&self) -> [u64; 2] {
        [self.pieces, self.compiled]
    }
}

impl<'a, const N: usize, const D: usize, const G: usize> Run<'a, N, D, G> {
    fn new(limits: Exact, system: &'a System, reach: Reach) -> Self {
        let (full, cursor) = system.start();
        Self {
            limits,
            system,
            reach,
            // As many as a device scene meets; a list that grows would move them.
            regions: Vec::with_capacity(8),
            current: 0,
            cursor,
            now: Moment { z: shorten(&full), rate: [0.0; N], guards: [0.0; G] },
            base: [0.0; N],
            steps: 0,
            states: [[0.0; N]; BLOCK],
            events: Vec::new(),
            pieces: 0,
            compiled: 0,
            sums: Sums::default(),
            impacts_j: 0.0,
        }
    }

    /// From the system's start along a grid.
    fn along(&mut self, grid: &Grid, out: &mut impl Record<N>) -> Result<()> {
        let start = grid.time(0);
        let (mut full, mut cursor) = self.system.start();
        self.system.pass(&mut cursor, start, &mut full);
        let region = self.system.first_region(&full);
        (self.now.z, self.cursor) = (shorten(&full), cursor);
        // Regions stay as they are: they are what a prepared system saves.
        self.events.clear();
        (self.pieces, self.compiled) = (0, 0);
        (self.sums, self.impacts_j) = (Sums::default(), 0.0);
        self.enter(&region, start)?;
        self.note(start, EventKind::Input);
        let swings = self.system.swings();
        out.record(&[start], &[self.now.z], self.current);
        let even = grid.even_part().map_or(0, |(_, steps)| steps);
        let mut i = 0;
        while i + 1 < grid.samples() {
            if self.steps == 0 && self.cross_block(grid, i, swings, out) {
                i += BLOCK;
                continue;
            }
            i += 1;
            let from = grid.time(i - 1);
            let to = grid.time(i);
            if self.cursor.end_s >= to {
                self.cross(from, grid.step(i - 1), i <= even)?;
            } else {
                self.cross_spans(from, to)?;
            }
            // What begins at the last sample lies beyond the run.
            if self.cursor.end_s <= to && i + 1 < grid.samples() {
                self.pass_input(to)?;
            } else if swings && i.is_multiple_of(FRESH_INPUT_SAMPLES) {
                self.system.write_inputs(&self.cursor, to, &mut self.now.z);
                self.refresh();
            }
            out.record(&[to], &[self.now.z], self.current);
        }
        Ok(())
    }

    /// A block of even steps from sample `i` on, one product per sample; false, with nothing done,
    /// if an event or the end of an input's span may lie inside.
    #[inline]
    fn cross_block(
        &mut self,
        grid: &Grid,
        i: usize,
        swings: bool,
        out: &mut impl Record<N>,
    ) -> bool {
        let Some((step_s, steps)) = grid.even_part() else { return false };
        let last = i + BLOCK;
        let inputs_until = i - i % FRESH_INPUT_SAMPLES + FRESH_INPUT_SAMPLES;
        if last > steps || last > inputs_until || self.cursor.end_s <= grid.time(last) {
            return false;
        }
        let free = self.regions[self.current].free_block(step_s, &self.now, &mut self.states);
        let Some(after) = free else { return false };
        self.now = after;
        self.base = self.now.z;
        if swings && last == inputs_until {
            self.system.write_inputs(&self.cursor, grid.time(last), &mut self.now.z);
            self.states[BLOCK - 1] = self.now.z;
            self.refresh();
        }
        let t_s = std::array::from_fn(|k| (i + 1 + k) as f64 * step_s);
        out.record::<BLOCK>(&t_s, &self.states, self.current);
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
                return Err(self.system.too_much(self.limits.most_pieces, "pieces", at));
            }
            self.cross(at, end - at, false)?;
            self.pass_input(end)?;
            at = end;
        }
        self.cross(at, to - at, false)
    }

    /// From one span of the inputs to the next; only a jump can change the region.
    #[inline]
    fn pass_input(&mut self, t: f64) -> Result<()> {
        let jump = self.system.pass(&mut self.cursor, t, &mut self.now.z);
        if jump {
            return self.happen(t, EventKind::Input);
        }
        self.refresh();
        Ok(())
    }

    /// Over `h` seconds from `t` on, within one span of the inputs; `even` if it is a step of an
    /// even grid.
    #[inline]
    fn cross(&mut self, t: f64, h: f64, even: bool) -> Result<()> {
        let compiled = &mut self.regions[self.current];
        let ready = compiled.is_ready(h, even);
        if ready {
            if let Some(after) = compiled.free_step(&self.base, self.steps + 1, &self.now) {
                if let Some(work) = &compiled.work {
                    work.add(&self.now.z, h, &mut self.sums);
                }
                self.now = after;
                self.count_step();
                return Ok(());
            }
        } else if self.cross_uneven(h) {
            return Ok(());
        }
        self.search(t, h, ready)
    }

    /// One more prepared step from the base.
    #[inline]
    fn count_step(&mut self) {
        self.steps += 1;
        if self.steps == CHAIN {
            (self.base, self.steps) = (self.now.z, 0);
        }
    }

    /// The same for a step of any length; false, with nothing done, if an event may lie inside.
    #[inline]
    fn cross_uneven(&mut self, h: f64) -> bool {
        self.pieces += 1;
        let compiled = &self.regions[self.current];
        let bend = compiled.flow.bend(&self.now.rate);
        let (next, cover) = compiled.far(&self.now, &bend, h);
        let after = compiled.look(next);
        let sag = &compiled.flow.sags[cover];
        let now = &self.now;
        if !compiled.flow.is_free(sag, [&now.rate, &bend], &now.guards, &after.guards) {
            return false;
        }
        if let Some(work) = &compiled.work {
            work.add(&self.now.z, h, &mut self.sums);
        }
        self.now = after;
        (self.base, self.steps) = (next, 0);
        true
    }

    /// Piece by piece where an event may lie inside; `ready` if a step of this length is prepared.
    fn search(&mut self, t: f64, h: f64, ready: bool) -> Result<()> {
        let events = self.events.len();
        // Compensated (Kahan): thousands of events in one interval must not add up their rounding.
        let mut elapsed = 0.0;
        let mut excess = 0.0;
        let mut rest = h;
        while rest > 0.0 {
            let compiled = &self.regions[self.current];
            let before = self.now.z;
            let limit = self.limits.most_pieces;
            let event = compiled.scan(&mut self.now.z, rest, &mut self.pieces, limit);
            if let Some(work) = &compiled.work {
                work.add(&before, event.map_or(rest, |(after, _)| after), &mut self.sums);
            }
            if self.pieces > limit {
                return Err(self.system.too_much(limit, "pieces", t));
            }
            let Some((after, kind)) = event else {
                if compiled.flow.ladder.is_long(rest) {
                    // The many short pieces that proved it free of events were rounded as often;
                    // some long ones are not.
                    self.now.z = compiled.flow.ladder.advance(&before, rest);
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
        if ready && self.events.len() == events {
            // Nothing happened: the state is that of the prepared step, which is rounded once,
            // whatever pieces it took to prove it.
            let next = self.regions[self.current].stepped(&self.base, self.steps + 1);
            self.now.z = next.unwrap_or(self.now.z);
            self.look();
            self.count_step();
        } else {
            self.refresh();
        }
        if !in_bounds(&self.now.z) {
            return Err(self.system.not_finite(t + h));
        }
        Ok(())
    }

    /// Carries an event out and enters the region that follows.
    fn happen(&mut self, t: f64, kind: EventKind) -> Result<()> {
        if self.events.len() as u64 > self.limits.most_events {
            return Err(self.system.too_much(self.limits.most_events, "events", t));
        }
        let region = self.regions[self.current].region;
        let before_j = self.system.stored_j(&self.now.z);
        let next = self.system.transit(&region, kind, &mut self.now.z);
        self.impacts_j += self.system.stored_j(&self.now.z) - before_j;
        self.enter(&next, t)?;
        self.note(t, kind);
        Ok(())
    }

    fn note(&mut self, t_s: f64, kind: EventKind) {
        let region = self.regions[self.current].region;
        self.events.push(Event { t_s, kind, theta_rad: self.now.z[THETA], region });
    }

    fn enter(&mut self, region: &Region, t: f64) -> Result<()> {
        let existing = self.regions.iter().position(|compiled| compiled.region.resembles(region));
        self.current = existing.unwrap_or(self.regions.len());
        if existing.is_none_or(|at| self.regions[at].region != *region) {
            self.compiled += 1;
            let compiled = Compiled::new(self.system, region, self.reach, self.limits.energy);
            match self.regions.get_mut(self.current) {
                // In place of the one that it differs from in numbers only: a lever may rest
                // anywhere.
                Some(slot) => *slot = compiled,
                None => self.regions.push(compiled),
            }
        }
        // A flow that is not finite would show as NaN in the states, long after its reason.
        if !self.regions[self.current].reaches {
            return Err(self.system.not_finite(t));
        }
        self.refresh();
        Ok(())
    }

    /// Rate and guard values of a state that does not come from a base.
    #[inline]
    fn refresh(&mut self) {
        (self.base, self.steps) = (self.now.z, 0);
        self.look();
    }

    /// Rate and guard values of the state.
    #[inline]
    fn look(&mut self) {
        self.now = self.regions[self.current].look(self.now.z);
    }

    fn balance(&self) -> EnergyBalance {
        let [external_j, motor_j, brake_j, friction_j, terms_j, tissue_j] = self.sums;
        let (start, _) = self.system.start();
        let stored_j = self.system.stored_j(&self.now.z) - self.system.stored_j(&start);
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
}
