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
pub(crate) mod rendering_range;
pub(crate) mod simulation;
pub(crate) mod stability;
pub(crate) mod work_precision;

pub use bow_tie::{SCENE_BOW_TIE, bow_tie};
pub use characteristic::{CHARACTERISTIC, Characterised, characteristic};
pub use chattering::chattering;
pub use finding::{Felt, finding};
pub use freemotion::{FREE_MOTION, free_motion};
pub use frequency::impedance_frequency;
pub use impedance::impedance;
pub use ladder::{LADDER, LadderRows, ladder};
pub use less::{LESS, less};
pub use rendering_range::{RENDERING_RANGE, rendering_range};
pub use simulation::{MOST_SIDE_BY_SIDE, SCENE_INPUTS, SCENE_RUNS, inputs, simulation};
pub use stability::{BoundaryOf, Side, StabilityPanel, StableArea, boundaries, stability};
pub use work_precision::{WORK_PRECISION, work_precision, work_precision_of};
