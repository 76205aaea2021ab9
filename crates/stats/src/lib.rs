//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.

pub mod agreement;
pub mod aicc;
pub mod anova;
pub mod autocorrelation;
pub mod band;
pub mod bootstrap;
mod error;
pub mod f_distribution;
pub mod hac;
pub mod interval;
pub mod lmm;
mod matrix;
pub mod power;
pub mod recording;
pub mod rm_anova;
mod rounded;
pub mod student_t;
mod tested;

pub use error::StatsError;
pub use tested::{FTest, Tested, Unestimable};
