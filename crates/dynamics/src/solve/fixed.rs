//! The loop that all fixed-step methods share: inputs at the stage times, one step per sample,
//! stops after it.

use super::{Grid, shorten};
use crate::error::{Result, in_bounds};
use crate::system::direct::{Law, direction};
use crate::system::{Cursor, System};
use crate::trajectory::Trajectory;

/// The inputs, read at times that do not run backwards, and whether the brake is kept on.
pub(crate) struct Reader<'a> {
    system: &'a System,
    cursor: Cursor,
    held: bool,
    /// Time of the last sample, s: what begins there lies beyond the run.
    last_s: f64,
}

impl Reader<'_> {
    /// The law of a velocity.
    #[inline]
    pub(crate) fn law(&self, omega: f64) -> Law {
        Law { direction: direction(omega), held: self.held }
    }

    /// Writes the inputs at `t` into the state.
    #[inline]
    pub(crate) fn read(&mut self, t: f64, z: &mut [f64]) {
        if t >= self.cursor.end_s {
            // Just before the last sample at most: a span that begins there is not entered.
            self.system.pass(&mut self.cursor, t.min(self.last_s.next_down()), z);
        }
        self.system.write_inputs(&self.cursor, t, z);
    }
}

/// Steps a system along a grid; `advance(reader, z, t, h)` is the method. `z` holds the inputs at
/// `t`.
pub(crate) fn run<const N: usize>(
    system: &System,
    grid: &Grid,
    evaluations_per_step: u64,
    mut advance: impl FnMut(&mut Reader, &mut [f64; N], f64, f64),
) -> Result<Trajectory> {
    grid.check()?;
    let (mut full, mut cursor) = system.start();
    system.pass(&mut cursor, grid.time(0), &mut full);
    let last_s = grid.time(grid.samples() - 1);
    let mut z = shorten::<N>(&full);
    let mut reader = Reader { system, cursor, held: false, last_s };
    let mut out = Trajectory::new(system.layout, grid.samples());
    record(system, &mut out, grid.time(0), &z);
    for i in 0..grid.samples() - 1 {
        let t = grid.time(i);
        advance(&mut reader, &mut z, t, grid.step(i));
        system.constrain(&mut z);
        reader.read(grid.time(i + 1), &mut z);
        reader.held = system.keeps_brake(reader.held, &z);
        if !in_bounds(&z) {
            return Err(system.not_finite(grid.time(i + 1)));
        }
        record(system, &mut out, grid.time(i + 1), &z);
    }
    out.work.steps = grid.samples() as u64 - 1;
    out.work.evaluations = evaluations_per_step * out.work.steps;
    Ok(out)
}

fn record<const N: usize>(system: &System, out: &mut Trajectory, t: f64, z: &[f64; N]) {
    let region = out.region_number(&system.sampled_region(z));
    out.push(&[t], &[*z], region);
}
