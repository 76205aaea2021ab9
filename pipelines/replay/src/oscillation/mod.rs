//! Was this oscillation real? The answer for one recorded trial, from its recording and its model.
//!
//! 1. **What was recorded** ([`RecordedSwings`]): the way from one turn of θ to the next is a
//!    swing, which exists where half of it is more than one count and more than 4 σ of the angle's
//!    noise at rest. Six existing swings in a row, none more than three times as long as the next,
//!    are an oscillation.
//! 2. **The loop again**: the plant, the controller of the study with its counts and filter, its
//!    ticks where they were recorded, and the recorded force of the user. It is run once with that
//!    force as it is, and once with only its *slow part* from when the swings begin: its mean over
//!    a period of the swing, taken twice, which removes everything that fast. Each by `exact`; the
//!    second judged by [`Reference`] too, with `moreau_jean` at a quarter of a tick, half and a
//!    quarter of that.
//! 3. **Who feeds it**: cos φ, the mean power of the fast part of the user's force into the lever,
//!    divided by the product of both root mean squares.
//!
//! | without the force's fast part it swings | the user's force feeds it | answer |
//! |---|---|---|
//! | yes | no | real: the loop of device and controller keeps it up |
//! | no, but with it | no matter, or yes | the user's: forced |
//! | else | | cannot tell, and why |
//!
//! A recording has no solver, so no solver step can have caused a recorded swing. Halved steps only
//! show whether the *model's* swing is the model's.

mod course;
mod judge;
mod recorded;
mod table;
#[cfg(test)]
mod tests;

pub use course::SwingCourse;
pub use judge::{Origin, Oscillation, SwingAnswer, oscillation};
pub use recorded::RecordedSwings;
pub use table::trial_oscillation;
