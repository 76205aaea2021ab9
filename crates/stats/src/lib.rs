//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.

pub mod aicc;
mod answers;
pub mod autocorrelation;
pub mod band;
pub mod bootstrap;
pub mod clm;
pub mod clmm;
mod error;
pub mod hac;
pub mod interval;
mod logistic;
mod profile;
pub mod recording;
mod reference;
mod rounded;
mod separation;
pub mod student_t;
pub mod superiority;
mod symmetric;
mod tested;

pub use error::StatsError;
pub use tested::{FTest, Tested, Unestimable};
