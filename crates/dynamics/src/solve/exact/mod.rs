//! The exact solver: in every region the flow is one matrix exponential; events are roots of linear
//! functionals of it; a lever held by a set-valued force is a region of its own.
//!
//! Piecewise affine systems: Sontag 1981; sliding and sticking: Filippov 1988, Acary & Brogliato
//! 2008. The exponential: see `zwidth_numerics::expm`.

mod block;
mod compiled;
pub(crate) mod held;
mod method;
mod run;
mod uneven;
mod work;

use super::{Grid, Solver};
use crate::error::{DynamicsError, Result};
use crate::system::System;
use crate::trajectory::Trajectory;
use compiled::Reach;
pub use method::{Exact, Prepared};

impl Solver for Exact {
    fn name(&self) -> String {
        "exact".to_owned()
    }

    fn run(&self, system: &System, grid: &Grid) -> Result<Trajectory> {
        let mut out = Trajectory::new(system.layout, grid.samples());
        self.prepare(system, grid)?.run_into(grid, &mut out)?;
        Ok(out)
    }
}

impl Exact {
    /// Makes a system ready for runs over grids with steps up to those of `grid`.
    ///
    /// # Errors
    /// A bad grid, or a model that is not piecewise affine.
    pub fn prepare<'a>(&self, system: &'a System, grid: &Grid) -> Result<Box<dyn Prepared + 'a>> {
        if let Some(term) = system.nonlinear_term() {
            return Err(DynamicsError::NotPiecewiseAffine { term });
        }
        grid.check()?;
        let longest_s = grid.longest_step();
        let longest_s = if longest_s > 0.0 { longest_s } else { 1.0 };
        let reach = Reach { longest_s, even: grid.even_part().is_some() };
        Ok(system.stepped(*self, reach))
    }
}

#[cfg(test)]
mod tests;
