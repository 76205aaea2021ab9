//! Piecewise affine motion, whatever it describes.
//!
//! In a region the state moves as ż = A z, whose last entry is 1, and functionals of it, the
//! guards, are not below zero. [`ReadyFlow`] is a region made ready: its exponentials, bounds that
//! prove a span free of events, and the search for the first event where they do not. The exact
//! solver of scenes and the driven plant are both made of it. What the rows say, and what an event
//! does, is theirs.

mod functionals;
mod ready;
mod row;

pub(crate) use functionals::{Functionals, Sag, all_above};
pub(crate) use ready::{Fall, ReadyFlow};
pub(crate) use row::{Number, Row};
