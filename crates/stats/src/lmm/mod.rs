//! Linear mixed models: y = X β + Z b + ε with random effects within participants.
//!
//! A [`Model`] is fitted by [`fit()`] and tested by contrasts of its coefficients, after Kenward &
//! Roger ([`Fit::kenward_roger`]) or Satterthwaite. [`trials::fit_trials`] does all of this for
//! trials of participants in modes and sessions.
//!
//! | file | mathematics |
//! |---|---|
//! | `model` | X, Z, y |
//! | `design` | Zᵀ Z, Zᵀ X, … per design of a participant |
//! | `profile` | the profiled criterion and its gradient |
//! | `search` | its minimum over the relative Cholesky factor θ |
//! | `information` | Pᵣ, Qᵣₛ and the information on the variances |
//! | `kenward_roger`, `satterthwaite` | degrees of freedom, adjusted covariance |
//! | `contrast` | L β |
//! | `trials` | the largest structure that the trials of a study support |

mod contrast;
mod design;
mod fit;
mod information;
mod kenward_roger;
mod model;
mod profile;
mod satterthwaite;
mod search;
#[cfg(test)]
mod tests;
pub mod trials;

pub use crate::answers::Column;
pub use fit::{Criterion, Fit, TermCovariance, Tests, fit};
pub use model::{Model, RandomTerm};
