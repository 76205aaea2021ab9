//! What other programs print of the same contrast of modes, computed here: by the calls that are usual, with
//! their own defaults. `tests/interop/peers.py` holds every number against the programs themselves.
//!
//! | file | whose |
//! |---|---|
//! | `observed` | statsmodels' standard errors |
//! | `within` | pyfixest's estimates |
//! | `printed` | all programs, by name |
//!
//! What lme4, lmerTest, pbkrtest and emmeans share are the mixed models of [`crate::lmm`]. None of these
//! programs knows sessions, groups of people or lines over trials unless it is told.

mod observed;
mod printed;
#[cfg(test)]
mod tests;
mod trials;
mod within;

pub use printed::{EMMEANS_LIMIT, Fitted, Peer, Printed, Reference};
pub use trials::Trials;
