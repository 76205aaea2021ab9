//! What can keep a scene from being simulated.

use crate::{MOST_SAMPLES, SOLVERS};
use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, thiserror::Error)]
pub enum SimulateError {
    /// A name that no solver has.
    #[error("there is no solver '{name}'; there are {}", SOLVERS.join(", "))]
    NoSolver {
        /// The name.
        name: String,
    },
    /// More samples than are kept in memory.
    #[error(
        "{duration_s} s in steps of {step_s} s are more than {MOST_SAMPLES} samples; make step_s larger or duration_s shorter"
    )]
    TooManySamples {
        /// Length of the run, s.
        duration_s: f64,
        /// The step, s.
        step_s: f64,
    },
    /// A bow tie has no ends.
    #[error(
        "plant.stops_rad is missing, but the bow tie is drawn from stop to stop; give the scene its stops"
    )]
    NoStops,
    /// A format that has no way to say a part of the scene.
    #[error("a scene with this cannot be written as {format}: {why}")]
    NotSaid {
        /// The format.
        format: &'static str,
        /// What it cannot say, and what to do.
        why: &'static str,
    },
    /// A term whose force no format can say.
    #[error(
        "the force of '{term}' cannot be written for other programs; leave it out of the scene"
    )]
    TermNotSaid {
        /// The term.
        term: &'static str,
    },
    /// The scene makes no sense, or the solver could not run it.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
}
