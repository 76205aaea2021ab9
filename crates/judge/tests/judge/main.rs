//! The judge's own truth: right trajectories pass, and wrong ones, made by formula from the right
//! motion, are measured.

mod made;
mod refused;
mod right;
mod scenes;
mod soak;
mod wrong;
