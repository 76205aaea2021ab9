//! Stage: model runs of scenes, as rows.
//!
//! [`simulate`] runs a scene with a solver chosen by name and judges the run.
//! [`model_run`], [`model_events`] and [`Summary`] give the results; [`chattering`] sets solvers
//! and steps side by side, and [`bow_tie`] moves the lever there and back whatever the forces
//! (thesis Fig. 7 and 31). Nothing here is measured, and every table says so.
//!
//! Pure: a scene in memory, rows out; the same scene gives the same bits.

mod bow_tie;
mod chattering;
mod error;
mod others;
mod run;
#[cfg(test)]
mod scenes;
mod solvers;
mod summary;
mod trajectory;

pub use bow_tie::{BOW_TIE_NOTE, bow_tie};
pub use chattering::{CHATTERING_NOTE, CHATTERING_STEPS_S, chattering};
pub use error::SimulateError;
pub use others::{OtherFile, OtherFormat, OtherScene, write_as};
pub use run::{MOST_SAMPLES, Run, highest, simulate, unjudged};
pub use solvers::{DEFAULT_SOLVER, DEFAULT_TOLERANCE, SOLVERS, solver};
pub use summary::{Energy, KnownMotion, StepSwings, Summary, Work};
pub use trajectory::{model_events, model_run};
pub use zwidth_dynamics::{DynamicsError, ModelScene};

/// Version of the tables' form: raised when the same scene would give another table. The solvers
/// have their own tests.
pub const VERSION: u32 = 5;
