//! Stage: how an actuator or sensor responds to its command: candidate models, the chosen one, and
//! why.
//!
//! [`characterise`] takes sweeps (command against response, in the caller's units) and gives every
//! candidate of [`models`] with its parameters, their bootstrap intervals, its errors, a verdict and
//! its reason in words, and the one that is chosen. No files and no clock: the same sweeps, settings and seed
//! give the same bits.
//!
//! # What is fitted
//! Each curve of [`models`] is fitted once to all samples, and, if the command went up and down,
//! once to each way ([`branches`]). Fits are made on the means of at most 256 steps of the command,
//! one mean per sweep, way and step. They are exact if there are no more commands than that (the
//! sum of squares depends on the samples through these means alone), and otherwise off by less than
//! a hundredth of the interval. Errors are those of the samples themselves.
//!
//! A sweep has only samples that show the response: a brake gives no force of its own unless
//! someone pushes the lever past slip, so the recorder leaves out samples that do not slip. Gaps do
//! no harm.
//!
//! # How a candidate is chosen
//! The criterion is the root mean square error on data left out of the fit. The simplest candidate
//! is chosen that is within one standard error of the smallest (Hastie, Tibshirani & Friedman, *The
//! Elements of Statistical Learning*, 2nd ed., §7.10) and not consistently worse: its mean square
//! is within two standard errors of the difference, taken part by part. (By the first rule alone,
//! sweeps whose gains differ by 5 % hide a hysteresis of a fifth of a volt, although every one of
//! them shows it.) One sweep at a time is left out; if there is only one, one of its ten contiguous
//! blocks (fewer if a block would be shorter than two points), because neighbouring samples are too
//! similar to test each other. AICc is computed on per-command bins and is only reported, because
//! it assumes independent samples, and these are not. The spline is not a law: it takes part only
//! if every law lacks fit.
//!
//! # What else is said of each
//! * intervals: percentile bootstrap over whole sweeps, expanded for their small number
//!   ([`expanded_level`](zwidth_stats::bootstrap::expanded_level)); for a single sweep, over blocks
//!   of residuals a tenth of its length, put back on the fitted curve (its commands are a design,
//!   not a random draw: leaving out a tenth of them would leave out the break). Searches start from
//!   the fit to the data;
//! * lack of fit: RMS over the noise ([`Characteristic::noise`]; above 1.5 the curve is wrong), and
//!   how similar neighbouring residuals are;
//! * a break or plateau with fewer than two commands to one side of it is reported as lying at the
//!   edge of the data, not identifiable.
//!
//! # What comes of it
//! [`calibrated`] turns the chosen curves of motor and brake into the knots of a
//! [`zwidth_study::Calibration`].

mod calibrate;
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
pub mod shape;
mod steps;
mod table;
mod uncertainty;
mod verdict;

pub use calibrate::{Chosen, calibrated};
pub use characterise::characterise;
pub use characteristic::{Candidate, Characteristic, Quality, Settings};
pub use curve::{CurveAt, curve};
pub use error::CharacteriseError;
pub use first_order::{FirstOrder, first_order};
pub use samples::Sweep;
pub use table::{Fit, Subject, curve_points, fitted_models, fitted_parameters};
pub use zwidth_numerics::branch::{Branch, branches};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 6;
