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

use super::{Grid, Solver, with_length};
use crate::error::{DynamicsError, Result};
use crate::system::System;
use crate::trajectory::Trajectory;
use compiled::Reach;
pub use method::{Exact, Prepared};
use run::Run;

impl Solver for Exact {
    fn name(&self) -> String {
        "exact".to_owned()
    }

    fn citation(&self) -> &'static str {
        "E. Sontag, IEEE Trans. Autom. Control 26 (1981) 346-358; A. F. Filippov (1988); N. Higham, SIAM J. \
         Matrix Anal. Appl. 26 (2005) 1179-1193"
    }

    fn run(&self, system: &System, grid: &Grid) -> std::result::Result<Trajectory, DynamicsError> {
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
    pub fn prepare<'a>(
        &self,
        system: &'a System,
        grid: &Grid,
    ) -> std::result::Result<Box<dyn Prepared + 'a>, DynamicsError> {
        if let Some(term) = system.nonlinear_term() {
            return Err(DynamicsError::NotPiecewiseAffine { term });
        }
        grid.check()?;
        with_length!(system.layout.n, self.prepare_n(system, grid))
    }

    /// A region has at most four guards of the lever and actuators, and two of a finger.
    fn prepare_n<'a, const N: usize>(
        &self,
        system: &'a System,
        grid: &Grid,
    ) -> Result<Box<dyn Prepared + 'a>> {
        let longest_s = grid.longest_step();
        let longest_s = if longest_s > 0.0 { longest_s } else { 1.0 };
        let reach = Reach { longest_s, even: grid.even_part().is_some() };
        Ok(match system.layout.finger {
            Some(_) => Box::new(Run::<N, 6>::new(*self, system, reach)),
            None => Box::new(Run::<N, 4>::new(*self, system, reach)),
        })
    }
}

#[cfg(test)]
mod tests;
