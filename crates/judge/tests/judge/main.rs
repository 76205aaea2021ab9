//! The judge's own truth: right trajectories pass, and wrong ones, made by formula from the right
//! motion, are measured.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod made;
mod refused;
mod right;
mod scenes;
mod soak;
mod wrong;
