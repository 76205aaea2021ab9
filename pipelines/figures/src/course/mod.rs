//! Figures of recorded trials: against time and angle, with means of the repeats and models beside them.

pub(crate) mod data;
pub(crate) mod loaded;
pub(crate) mod loops;
pub(crate) mod modes;
pub(crate) mod oscillation;
pub(crate) mod panels;
pub(crate) mod people;
pub(crate) mod repeats;
pub(crate) mod replay;

pub use data::{EnvironmentData, ModeData, Repeat, SIGNALS, average_columns, loop_columns};
pub use loaded::{Averages, Loaded, Of};
pub use loops::{LOOPS, loops};
pub use modes::{MODES, modes};
pub use oscillation::oscillation;
pub use people::{EnvironmentOfPeople, MEAN_LOOPS, ModeOfPeople, draws_each, mean_loops};
pub use repeats::{REPEATS, repeats};
pub use replay::{REPLAY, replay};
