//! The loop that the adaptive methods share: error control, dense output at the grid's times,
//! events located on the dense output, and the same regions and transitions as the exact solver.

use zwidth_numerics::expm::dot;
use zwidth_numerics::roots;

use super::embedded::{Embedded, Field, dense};
use super::{Grid, shorten};
use crate::affine::sizes;
use crate::error::{Result, in_bounds, positive};
use crate::system::flow::Flow;
use crate::system::region::Region;
use crate::system::transition::EventKind;
use crate::system::{Cursor, System, THETA};
use crate::trajectory::{Event, Trajectory};

/// What an adaptive method aims for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Relative error per step.
    pub rtol: f64,
    /// Absolute error per step, in each quantity's own unit.
    pub atol: f64,
    /// More steps than this end the run in an error.
    pub most_steps: u64,
}

impl Tolerances {
    /// `tolerance` relative and a hundredth of it absolute.
    pub fn of(tolerance: f64) -> Self {
        /// Some seconds of work.
        const MOST_STEPS: u64 = 10_000_000;
        Self { rtol: tolerance, atol: 1e-2 * tolerance, most_steps: MOST_STEPS }
    }

    fn check(&self) -> Result<()> {
        positive("tolerances.rtol", self.rtol)?;
        positive("tolerances.atol", self.atol)
    }
}

/// Runs a system along a grid with a method.
pub(crate) fn run<const N: usize>(
    system: &System,
    grid: &Grid,
    tolerances: &Tolerances,
    method: &mut impl Embedded<N>,
) -> Result<Trajectory> {
    grid.check()?;
    tolerances.check()?;
    let mut state = State::<N>::new(system, grid, tolerances);
    let end = grid.time(grid.samples() - 1);
    while state.t < end {
        let limit = end.min(state.cursor.end_s);
        state.step(method, grid, limit)?;
        let is_over = state.t >= state.cursor.end_s && state.t < end;
        if is_over && system.pass(&mut state.cursor, state.t, &mut state.z) {
            state.happen(EventKind::Input);
        }
    }
    // The samples that are left stand at the end.
    while state.next_sample < grid.samples() {
        let z = state.z;
        state.record(grid.time(state.next_sample), &z);
    }
    Ok(state.out)
}

struct State<'a, const N: usize> {
    system: &'a System,
    tolerances: &'a Tolerances,
    cursor: Cursor,
    region: Region,
    flow: Flow,
    field: Field<'a, N>,
    t: f64,
    h: f64,
    z: [f64; N],
    next_sample: usize,
    out: Trajectory,
}

impl<'a, const N: usize> State<'a, N> {
    fn new(system: &'a System, grid: &Grid, tolerances: &'a Tolerances) -> Self {
        let (mut full, mut cursor) = system.start();
        let t = grid.time(0);
        system.pass(&mut cursor, t, &mut full);
        let region = system.first_region(&full);
        let flow = system.flow(&region);
        let field = Field::new(system, &flow);
        let out = Trajectory::new(system.layout, grid.samples());
        let z = shorten(&full);
        // Chosen below, from the slope of the finished state.
        let h = f64::NAN;
        let mut state =
            Self { system, tolerances, cursor, region, flow, field, t, h, z, next_sample: 0, out };
        state.note(EventKind::Input);
        state.choose_first_step();
        state
    }

    /// A hundredth of the time in which the state changes by its own size (Hairer, Nørsett &
    /// Wanner, II.4).
    fn choose_first_step(&mut self) {
        /// Hairer's cautious share.
        const SHARE: f64 = 0.01;
        /// Where a size is too small to say anything, s.
        const FALLBACK_S: f64 = 1e-6;
        let rate = self.norm(&self.field.slope(&self.z), &self.z);
        let size = self.norm(&self.z, &self.z);
        self.h = if rate > 1e-5 && size > 1e-5 { SHARE * size / rate } else { FALLBACK_S };
    }

    /// Root mean square in units of the tolerance. The inputs count too: while the lever rests
    /// nothing else moves, and the end of the rest is read off them.
    fn norm(&self, v: &[f64; N], z: &[f64; N]) -> f64 {
        let controlled = self.system.layout.one();
        let squares = (0..controlled).map(|i| {
            let scale =
                self.tolerances.atol + self.tolerances.rtol * self.z[i].abs().max(z[i].abs());
            (v[i] / scale) * (v[i] / scale)
        });
        (squares.sum::<f64>() / controlled as f64).sqrt()
    }

    /// One accepted step, or up to the first event inside it.
    fn step(&mut self, method: &mut impl Embedded<N>, grid: &Grid, limit: f64) -> Result<()> {
        /// Most a step may grow or shrink at once, and the safety factor of its choice.
        const GROW: f64 = 5.0;
        const SHRINK: f64 = 0.2;
        const SAFETY: f64 = 0.9;
        loop {
            let whole = self.t + self.h >= limit;
            let h = if whole { limit - self.t } else { self.h };
            self.out.work.steps += 1;
            if self.out.work.steps > self.tolerances.most_steps {
                return Err(self.system.too_much(self.tolerances.most_steps, "steps", self.t));
            }
            let attempt = method.attempt(&self.field, &self.z, h);
            self.out.work.evaluations += attempt.evaluations;
            self.out.work.factorisations += attempt.factorisations;
            let error = self.norm(&attempt.error, &attempt.z);
            // Without a number for its error a step is tried again much shorter.
            let factor = match error.is_nan() {
                true => SHRINK,
                false => SAFETY * libm::pow(error.max(f64::MIN_POSITIVE), -1.0 / method.power()),
            };
            if error <= 1.0 {
                // A step that the limit cut short says little of the length that the next may have.
                self.h = if whole {
                    self.h.max(h * factor.clamp(SHRINK, GROW))
                } else {
                    h * factor.clamp(SHRINK, GROW)
                };
                let end = if whole { limit } else { self.t + h };
                if !in_bounds(&attempt.z) {
                    return Err(self.system.not_finite(end));
                }
                let event = self.first_event(&attempt.dense, h);
                let (t, z) = match event {
                    Some((share, _)) => (self.t + share * h, dense(&attempt.dense, share)),
                    None => (end, attempt.z),
                };
                while self.next_sample < grid.samples() && grid.time(self.next_sample) < t {
                    let share = (grid.time(self.next_sample) - self.t) / h;
                    self.record(grid.time(self.next_sample), &dense(&attempt.dense, share));
                }
                (self.t, self.z) = (t, z);
                // From their closed forms: the method would let its error in the inputs pile up.
                self.system.write_inputs(&self.cursor, self.t, &mut self.z);
                if let Some((_, kind)) = event {
                    self.happen(kind);
                }
                return Ok(());
            }
            self.out.work.rejected += 1;
            self.h = h * if factor.is_finite() { factor.clamp(SHRINK, 1.0) } else { SHRINK };
            if self.t + self.h <= self.t || !self.h.is_finite() {
                return Err(self.system.not_finite(self.t));
            }
        }
    }

    fn record(&mut self, t: f64, z: &[f64; N]) {
        let number = self.out.region_number(&self.region);
        self.out.push(&[t], &[*z], number);
        self.next_sample += 1;
    }

    /// The first guard to fall below zero on the dense output, as a share of the step.
    fn first_event(&self, coefficients: &[[f64; N]; 5], h: f64) -> Option<(f64, EventKind)> {
        /// Located to this share of the step.
        const RESOLUTION: f64 = 1e-14;
        /// A guard counts as zero within this share of its terms' sizes, or of the tolerance.
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        let slack = ROUNDING.max(1e-3 * self.tolerances.rtol);
        let sizes = sizes(&self.field.a.map(f64::abs), &self.z, h);
        let mut first: Option<(f64, EventKind)> = None;
        for guard in &self.flow.guards {
            let row = shorten::<N>(&guard.value.row.0);
            let mut p = coefficients.map(|c| dot(&row, &c));
            if self.system.curved {
                // The terms' curved force as the quadratic through its values at 0, 1/2 and 1.
                let [a, b, c] = [0.0, 0.5, 1.0].map(|share| {
                    let curve = self.system.curve(&dense(coefficients, share)).unwrap_or_default();
                    guard.value.curved * curve.force_n
                });
                p[0] += a;
                p[1] += 4.0 * b - 3.0 * a - c;
                p[2] += 2.0 * (a + c) - 4.0 * b;
            }
            // A guard that is zero but for rounding has not fallen.
            p[0] += slack * dot(&row.map(f64::abs), &sizes);
            let until = first.map_or(1.0, |(share, _)| share);
            if let Some(share) = roots::first_descent(&p, until, RESOLUTION) {
                first = Some((share, guard.kind));
            }
        }
        first
    }

    fn happen(&mut self, kind: EventKind) {
        self.region = self.system.transit(&self.region, kind, &mut self.z);
        self.flow = self.system.flow(&self.region);
        self.field = Field::new(self.system, &self.flow);
        self.note(kind);
        // The slope jumps at an event: the length of the last step means nothing after it.
        self.choose_first_step();
    }

    fn note(&mut self, kind: EventKind) {
        self.out.events.push(Event {
            t_s: self.t,
            kind,
            theta_rad: self.z[THETA],
            region: self.region,
        });
    }
}
