//! Statistics a reviewer accepts: intervals, bootstraps, information criteria, residual checks.
//!
//! Pure functions on slices: no files, no clock, no hidden random state. A result that does not
//! exist (the interval of one value) is `None`, never NaN.
//!
//! Each takes plain columns, and can be called without a study. Where other programs do it differently, [`peers`] computes what they
//! print (docs/analysis.md, "What other programs print"); the versions are those named there.
//!
//! | question | function | beside other programs |
//! |---|---|---|
//! | do modes differ? trials of people | [`lmm::fit()`], [`lmm::trials::fit_trials`] | Kenward and Roger's degrees of freedom, also where a variance is zero: of six people, three modes and 108 trials 10, where lmerTest has 105 and statsmodels' `MixedLM` the normal distribution |
//! | the same of ordinal answers | [`clmm::fit()`], [`clmm::profile_interval`], [`clmm::compare_modes`] | two random terms by quadrature, which R's `ordinal` has by Laplace alone (wine, one term: 3.0619 by quadrature, 3.0630 by Laplace); statsmodels and pingouin have no random effects for answers |
//! | few people | [`sign_flip::test`], [`signed_rank::test`], [`friedman::test`] | exact also with ties |
//! | one person | [`sharp_null`] | over the orders that the design could have drawn |
//! | too small to matter? | [`paired::equivalence`] | two one-sided tests of any estimate with its error |
//! | sessions that agree | [`agreement::agreement`], [`agreement::bland_altman`] | intervals after McGraw and Wong |
//! | whole curves | [`curve::differences`], [`curve::groups`] | – |
//! | all pairs of means | [`studentised_range`] | R's `ptukey` is off by 1.5 % at p = 7.5·10⁻⁵ (three means, 5 degrees of freedom); SciPy's is as ours |

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
