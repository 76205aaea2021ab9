//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.

pub mod agreement;
pub mod aicc;
mod anova;
mod answers;
pub mod autocorrelation;
pub mod band;
pub mod bca;
pub mod bootstrap;
pub mod clm;
pub mod clmm;
pub mod curve;
pub mod curve_power;
pub mod design_guard;
pub mod effect;
mod error;
pub mod f_distribution;
pub mod friedman;
pub mod groups;
pub mod hac;
pub mod heterogeneity;
pub mod holm;
pub mod hotelling;
pub mod incomplete;
pub mod interval;
pub mod line;
pub mod lmm;
mod logistic;
pub mod null;
pub mod over_doses;
pub mod over_trials;
pub mod paired;
pub mod peers;
pub mod power;
mod profile;
pub mod psychometric;
pub mod recording;
mod reference;
pub mod reliability;
pub mod repeated_correlation;
pub mod rm_anova;
mod rounded;
pub mod sensitivity;
mod separation;
pub mod sharp_null;
pub mod sign_flip;
pub mod signed_rank;
pub mod student_t;
pub mod studentised_range;
pub mod superiority;
mod tested;
pub mod welch;

pub use error::StatsError;
pub use tested::{FTest, Tested, Unestimable};
