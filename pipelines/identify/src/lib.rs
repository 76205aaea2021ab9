//! Stage: the plant's parameters that fit recorded trials best, how well they are known, and
//! whether the fit beats a choice by eye on trials it has not seen.
//!
//! [`identify`] takes observations from recordings and any model that explains them by parameters;
//! it does not know what the model consists of. It fits every other repeat of each participant,
//! session and condition, beginning with the first; the others are held out and only judged.
//!
//! * **Fit**: least squares over the observations of all fitted trials, within bounds, by a
//!   projected Levenberg–Marquardt method from several starts; the best result counts. Slopes are
//!   central differences. The noise must be in the dependent variable, not in the explanatory ones.
//! * **Intervals**: the values for which the profile's likelihood ratio stays below t². The ratio
//!   is scaled by the standard error from leaving out each trial in turn, because errors within a
//!   trial are correlated, and t has Satterthwaite's degrees of freedom, because a parameter may
//!   affect only a few of the trials.
//! * **Left out**: a trial's error with the parameters that the other fitted trials give, by one
//!   Gauss–Newton step.
//! * **Identifiability**: see [`Identifiability`](zwidth_results::Identifiability).
//! * **Threshold**: see [`Bracket`].
//!
//! Pure: recordings in memory, rows out; the same bits with any number of threads.

mod bracket;
mod error;
mod estimate;
mod fit;
mod identify;
mod profile;
mod slopes;
mod table;
#[cfg(test)]
mod testing;
mod verdict;

pub use bracket::{Bracket, Switching};
pub use error::IdentifyError;
pub use estimate::Estimate;
pub use identify::{Identified, Recording, Task, identify};
pub use slopes::Parameter;
pub use table::{covariances, estimates_table, held_out, nothing_fitted, profiles, threshold};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 11;
