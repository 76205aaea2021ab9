//! Stage: what can be felt, from the answers to tasks.
//!
//! [`thresholds`] fits the answers of every person in each session and mode: a psychometric function where levels were
//! constant stimuli, the mean of the last reversals of staircases, the posterior means of QUEST+, mean and spread of what
//! people set. Each has a verdict ([`FitVerdict`](zwidth_results::FitVerdict)); only what is `estimated` goes on. The
//! points of subjective equality, thresholds and ln JNDs then are metrics like others, with one value of everybody in each
//! session and mode: [`values`] gives them to the stage `compare`, which tests them over people (repeats are not people).
//! [`over_people`] says what it found in units of the levels, of JNDs as ratios, and beside it the two-level model, which
//! weighs people by the errors of their own.
//!
//! Pure: answers that count in, rows out.

mod answered;
mod fits;
mod levels;
mod notes;
mod over_people;
#[cfg(test)]
mod tests;
mod values;

pub use answered::{Answered, Response};
pub use fits::{Found, Parameters, thresholds};
pub use notes::notes;
pub use over_people::{Means, measured, over_people};
pub use values::{value, values};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 2;
