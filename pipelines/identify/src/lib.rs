//! Stage: the plant's parameters that fit recorded trials best, how well they are known, and whether the fit beats a
//! choice by eye on trials it has not seen.
//!
//! [`identify`] takes recordings of θ and any model that predicts them from parameters: what the model is made of it
//! does not know. Of each participant's repeats of a condition, by session, every other one, beginning with the first, is
//! fitted; the others are held out and only judged.
//!
//! * **Fit**: least squares of θ over the samples of all fitted trials, within bounds, by a projected
//!   Levenberg–Marquardt method from several starts, of which the best end counts. Slopes are central differences.
//! * **Intervals**: percentiles of a bootstrap over whole trials, because errors within a trial are alike; with few
//!   trials the percentiles lie further out (Hesterberg 2015). Each resample takes one Gauss–Newton step from the fit
//!   instead of a fit of its own, so that nothing is run again: right to first order.
//! * **Left out**: a trial's error with the parameters that the other fitted trials give, by such a step too.
//! * **Verdict**: see [`Verdict`].
//!
//! Pure: recordings in memory, tables out; the same bits with any number of threads.

mod error;
mod estimate;
mod fit;
mod identify;
mod slopes;
mod table;
#[cfg(test)]
mod testing;
mod verdict;

pub use error::IdentifyError;
pub use estimate::{Estimate, Profile};
pub use identify::{Identified, Part, Recording, TrialErrors, identify};
pub use slopes::Parameter;
pub use table::{against_eye, estimates, nothing_fitted, trials};
pub use verdict::Verdict;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 1;
