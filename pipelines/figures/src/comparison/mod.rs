//! Figures of comparisons: metrics by mode, participant, session and repeat; answers.

pub(crate) mod answers;
pub(crate) mod compared;
mod curves;
mod effects;
pub(crate) mod groups;
pub(crate) mod likert;
pub(crate) mod ratings;
mod thresholds;
pub(crate) mod verdicts;

pub use answers::*;
pub use compared::*;
pub use curves::*;
pub use effects::*;
pub use groups::*;
pub use likert::*;
pub use ratings::*;
pub use thresholds::*;
pub use verdicts::*;
