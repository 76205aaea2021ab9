//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.

pub mod aicc;
pub mod autocorrelation;
pub mod band;
pub mod bca;
pub mod bootstrap;
pub mod design_guard;
mod error;
pub mod f_distribution;
pub mod friedman;
pub mod hac;
pub mod holm;
pub mod interval;
pub mod line;
pub mod lmm;
mod matrix;
pub mod null;
pub mod paired;
pub mod recording;
mod rounded;
pub mod sharp_null;
pub mod sign_flip;
pub mod signed_rank;
pub mod student_t;
mod tested;
pub mod welch;

pub use error::StatsError;
pub use tested::{FTest, Tested, Unestimable};
