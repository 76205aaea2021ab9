//! Stage: which terms of the model a scene needs ("model only what a scene requires").
//!
//! [`ladder`] runs a scene with every set of eight terms ([`zwidth_results::LadderTerm`]: 2⁸ models) at points of
//! Sobol's sequence over the ranges of the twin's parameters, and compares each with the fullest
//! model at the same point. [`Ladder::choice`] is the cheapest set whose difference nobody could
//! feel at any point; total effects and interactions measure the effect of each term. Proper
//! modelling: B. H. Wilson & J. L. Stein, ASME Winter Annual Meeting, DSC 41 (1992) 47–58; T. Ersal
//! et al., J. Dyn. Syst. Meas. Control 130 (2008) 061008.
//!
//! Pure: scenes in memory, rows out; the same scene gives the same bits on any number of
//! threads.

mod borne_out;
mod error;
mod held_out;
mod ladder;
mod model;
mod quantities;
mod ranges;
mod reason;
mod run;
mod sensors;
mod table;
mod terms;
#[cfg(test)]
mod tests;

pub use borne_out::{choices, fitted, held_out_models, held_out_table};
pub use error::LadderError;
pub use held_out::{
    HeldOut, Knobs, Plant, Recorded, Tried, fit, held_out, plant, predict, rmse_rad, tried,
};
pub use ladder::{
    DEFAULT_POINTS, Ladder, MOST_PERIODS, MOST_POINTS, Quantity, Rung, Settings, ladder,
};
pub use model::Loop;
pub use quantities::own;
pub use ranges::{Point, Range, ranges};
pub use reason::{reason, told};
pub use run::{Cost, Course};
pub use table::*;
pub use terms::possible;

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 4;
