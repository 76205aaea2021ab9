//! Figures of actuators, plants and runs of the model.

pub(crate) mod bow_tie;
pub(crate) mod characteristic;
pub(crate) mod chattering;
pub(crate) mod finding;
pub(crate) mod freemotion;
pub(crate) mod frequency;
pub(crate) mod impedance;
pub(crate) mod ladder;
pub(crate) mod less;
pub(crate) mod others;
pub(crate) mod rendering_range;
pub(crate) mod simulation;
pub(crate) mod stability;
pub(crate) mod work_precision;

pub use bow_tie::*;
pub use characteristic::*;
pub use chattering::*;
pub use finding::*;
pub use freemotion::*;
pub use frequency::*;
pub use impedance::*;
pub use ladder::*;
pub use less::*;
pub use others::*;
pub use rendering_range::*;
pub use simulation::*;
pub use stability::*;
pub use work_precision::*;
