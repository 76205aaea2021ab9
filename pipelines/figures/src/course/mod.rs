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
pub(crate) mod space;

pub use data::*;
pub use loaded::*;
pub use loops::*;
pub use modes::*;
pub use oscillation::*;
pub use people::*;
pub use repeats::*;
pub use replay::*;
pub use space::*;
