//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.

pub mod agreement;
pub mod aicc;
mod answers;
pub mod anova;
pub mod autocorrelation;
pub mod band;
pub mod bca;
pub mod bootstrap;
pub mod design_guard;
pub mod clm;
pub mod clmm;
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
mod logistic;
mod profile;
pub mod recording;
mod reference;
pub mod power;
pub mod recording;
pub mod rm_anova;
mod rounded;
pub mod sharp_null;
pub mod sign_flip;
pub mod signed_rank;
mod separation;
pub mod student_t;
pub mod superiority;
mod symmetric;
mod tested;
pub mod welch;

pub use error::StatsError;
pub use tested::{FTest, Tested, Unestimable};
