//! The proportional-odds model with random effects, for answers of several people:
//! logit P(Y ≤ k) = θₖ − xβ − u − w, u normal per participant, w normal per participant and mode
//! (Hedeker & Gibbons 1994, Biometrics 50:933; Christensen 2022, R's ordinal).
//!
//! The effects are integrated out by Laplace's approximation or by sums over a lattice; the
//! likelihood is climbed by a quasi-Newton method with analytic gradients.

mod cell;
mod compare;
mod fit;
mod laplace;
mod likelihood;
mod model;
mod point;
mod profile;
mod quadrature;
mod ratio;
mod resample;
mod search;
#[cfg(test)]
mod tests;

pub use crate::answers::{Column, Scale};
pub use compare::{ModeComparison, ModeStudy, OddsRatio, compare_modes};
pub use fit::{Fit, fit};
pub use likelihood::Integral;
pub use model::{Model, Ratings, Terms};
pub use profile::{End, ProfileInterval, profile_interval};
pub use ratio::{RatioTest, test_columns};
pub use resample::{Bootstrap, bootstrap};
