//! Piecewise affine motion of any system.
//!
//! In a region the state moves as ż = A z, whose last entry is 1, and functionals of it, the
//! guards, are not below zero. [`ReadyFlow`] is a prepared region: its exponentials, bounds that
//! prove a span free of events, and the search for the first event where they do not. The exact
//! solver of scenes and the driven plant both use it. They define the meaning of the rows and the
//! effect of an event.

mod functionals;
mod ready;
mod row;

pub(crate) use functionals::{Functionals, Sag, all_above};
pub(crate) use ready::{Fall, ReadyFlow, sizes};
pub(crate) use row::{Number, Row};
