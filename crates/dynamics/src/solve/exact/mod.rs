//! The exact solver: in every region the flow is one matrix exponential; events are roots of linear
//! functionals of it; a lever held by a set-valued force is a region of its own.
//!
//! Piecewise affine systems: Sontag 1981; sliding and sticking: Filippov 1988, Acary & Brogliato
//! 2008. The exponential: see `zwidth_numerics::expm`.

mod block;
mod compiled;
#[cfg(test)]
mod condition;
mod run;
mod uneven;
mod work;

use super::{Grid, Solver, with_length};
use crate::error::{DynamicsError, Result};
use crate::system::System;
use crate::trajectory::Trajectory;
use run::Run;

/// Exact in every region, up to rounding. Refuses models that are not piecewise affine.
///
/// How exact is a matter of κ, the largest condition number of a step's exponential over the
/// regions met, relative and in the Frobenius norm (see [`zwidth_numerics::expm::condition`]). The
/// error of a run against the exact motion of the very numbers that were given, over the largest
/// signal, is at most 1e-12 where κ < 1e6, and at most 1e-12 + 2 ε κ above (ε = 2.2e-16). This
/// holds for up to 10⁴ samples and radians of swing that no damping forgets; each further one may
/// add ε. Sample `i` of an even grid stands at exactly `i` steps, of which its `t_s` is the rounded
/// value.
///
/// A step of 16 radians and more has its flow computed in twice the precision, from coefficients
/// such as K_O/(M_O L) in twice the precision, so that a step without events is rounded once
/// whatever κ is: 3e-14 was measured up to κ = 2.6e11. What is left is the rounding of each sample
/// and of each piece in which an event is found. Flows and states in twice the precision would mend
/// that too, for ten times the time of a region's first step and twice that of a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exact {
    /// A run with more events ends in an error: a lever may bounce without end.
    pub most_events: u64,
    /// A run that must look at more pieces of its intervals for events ends in an error.
    pub most_pieces: u64,
    /// Whether to integrate the work of every part; exact too, and several times the cost.
    pub energy: bool,
}

impl Default for Exact {
    fn default() -> Self {
        /// A thousand times what a device scene needs; a tenth of a second of work.
        const MOST_EVENTS: u64 = 200_000;
        /// Half a second of work.
        const MOST_PIECES: u64 = 5_000_000;
        Self { most_events: MOST_EVENTS, most_pieces: MOST_PIECES, energy: false }
    }
}

/// A system made ready: regions that were met are kept, so that later runs start at full speed.
pub trait Prepared {
    /// Runs from the system's start over a grid whose steps are no longer than those it was
    /// prepared for, into a trajectory that is emptied first and keeps its memory.
    ///
    /// # Errors
    /// As [`Solver::run`].
    fn run_into(
        &mut self,
        grid: &Grid,
        out: &mut Trajectory,
    ) -> std::result::Result<(), DynamicsError>;

    /// The same without keeping samples: `visit(t, state)` sees each of them. Memory does not grow
    /// with the grid.
    ///
    /// # Errors
    /// As [`Solver::run`].
    fn visit(
        &mut self,
        grid: &Grid,
        visit: &mut dyn FnMut(f64, &[f64]),
    ) -> std::result::Result<Trajectory, DynamicsError>;
}

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
        let reach_s = if longest_s > 0.0 { longest_s } else { 1.0 };
        Ok(match system.layout.finger {
            Some(_) => Box::new(Run::<N, 6>::new(*self, system, reach_s)),
            None => Box::new(Run::<N, 4>::new(*self, system, reach_s)),
        })
    }
}

#[cfg(test)]
mod accuracy;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;
