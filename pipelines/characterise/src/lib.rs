//! Stage: what an actuator or sensor does with its command: candidate models, the chosen one, why.
//!
//! [`characterise`] takes sweeps (command against response, in the caller's units) and gives every candidate of
//! [`models`] with its parameters, their bootstrap intervals, its errors and a verdict in words, and the one
//! that is chosen. No files and no clock: the same sweeps, settings and seed give the same bits.
//!
//! # How a candidate is chosen
//! The smallest root mean square error on data left out of the fit wins, unless a simpler candidate is within
//! one standard error of it: then the simplest of those (Hastie, Tibshirani & Friedman, *The Elements of
//! Statistical Learning*, 2nd ed., §7.10). One sweep at a time is left out; of a single sweep, one of ten
//! contiguous blocks (fewer if a block would be shorter than two points), because neighbouring samples are too
//! alike to test each other. AICc is computed on per-command bins and reported only: samples are not
//! independent, and it assumes that they are.
//!
//! # What else is said of each
//! * intervals: percentile bootstrap over whole sweeps; of a single sweep, over blocks of residuals a tenth of
//!   it long, put back on the fitted curve (its commands are a design, not a draw: leaving out a tenth of them
//!   would leave out the break);
//! * lack of fit: RMS over the noise ([`Characteristic::noise`]; above 1.5 the curve is wrong), and how alike
//!   neighbouring residuals are;
//! * a break with fewer than two commands below it (or above it) is reported as lying at the edge of the data,
//!   not identifiable.

mod characterise;
mod characteristic;
mod crossval;
mod curve;
mod error;
mod first_order;
pub mod models;
mod noise;
#[cfg(test)]
mod real_data;
mod samples;
mod table;
mod uncertainty;
mod verdict;

pub use characterise::characterise;
pub use characteristic::{Candidate, Characteristic, Grouping, Parameter, Quality, Settings};
pub use curve::{Curve, curve};
pub use error::CharacteriseError;
pub use first_order::{FirstOrder, first_order};
pub use samples::Sweep;
pub use table::{StageError, Subject, curve_table, models_table, parameters_table};
pub use verdict::Verdict;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 1;
