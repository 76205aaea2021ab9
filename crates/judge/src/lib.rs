//! Runs and trajectories beside the right answer of a scene.
//!
//! The right answer is the [`Yardstick`]. [`errors()`] says how far a run of ours is from it, and
//! [`judge`] what is wrong with a trajectory of which nothing is known but times, angles and
//! velocities, whatever program computed it ([`Candidate`]): the lever creeps, an event is missed
//! or late, the state is reset, energy is made. `docs/judge.md` has the definitions.
//!
//! A fault is what shows in the trajectory's own samples beside the right motion's at the same
//! times. Both are read in the same way, so that what the sampling hides or makes is in both.
//!
//! Pure: a scene and numbers in memory, rows out. Nothing here reads a file or the clock.

mod candidate;
mod changes;
mod creep;
mod energy;
mod error;
mod errors;
mod growth;
mod judgement;
mod jumps;
mod resolution;
mod sides;
mod story;
mod yardstick;

pub use candidate::Candidate;
pub use error::JudgeError;
pub use errors::{Errors, Size, errors, places};
pub use judgement::{Allowed, Judged, judge};
pub use story::{Story, What};
pub use yardstick::{EXACT, SAMPLE_S, Yardstick};
