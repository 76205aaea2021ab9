//! The method with its limits, and a system prepared for it.

use crate::error::Result;
use crate::solve::Grid;
use crate::trajectory::Trajectory;

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
    /// As [`crate::Solver::run`].
    fn run_into(&mut self, grid: &Grid, out: &mut Trajectory) -> Result<()>;

    /// The same without keeping samples: `visit(t, state)` sees each of them. Memory does not grow
    /// with the grid.
    ///
    /// # Errors
    /// As [`crate::Solver::run`].
    fn visit(&mut self, grid: &Grid, visit: &mut dyn FnMut(f64, &[f64])) -> Result<Trajectory>;
}
