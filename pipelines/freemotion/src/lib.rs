//! Stage: what free motion reveals about the device: plane fits, and the plant.
//!
//! If nothing is rendered, the user feels the device itself. [`plane_fit`] describes one recording
//! by
//!
//! τ = c + I θ̈ + b θ̇,
//!
//! fitted by least squares to all its samples: c is an offset (N·m), I the inertia felt (kg·m²), b
//! the damping felt (N·m·s/rad); smaller is more transparent. A time average of free motion means
//! nothing (no two movements follow the same course), but these three can be compared between
//! controllers and sessions.
//!
//! If the angle was recorded but no acceleration, [`plant_fit`] estimates more of the device, and
//! never differentiates twice:
//!
//! τ = c + I θ̈ + b θ̇ + τ_c sgn θ̇ + κ θ,
//!
//! averaged over stretches in which the device slips, with weights that turn θ̈ into an average of
//! θ.
//!
//! # Intervals
//! Samples taken hundreds of times a second are not independent: what the plane leaves out
//! (friction that turns with the direction, the sensor's delay, the hand) changes over tenths of a
//! second, so a residual resembles its neighbours, and the usual standard errors are several times
//! too small. Standard errors are Newey and West's with a tenth of the recording as bandwidth, and
//! intervals are t with 9 degrees of freedom ([`zwidth_stats::recording`]). They describe one
//! recording; sessions differ by more than that.
//!
//! Pure: samples in memory, rows out; the same samples give the same bits. Only trials that count
//! may come in (`StudyData::counting`): the caller filters.

mod average;
mod fit;
mod plant;
#[cfg(test)]
mod real_data;
mod table;

pub use fit::{FreeMotionError, Parameters, plane_fit};
pub use plant::plant_fit;
pub use table::{plane_table, plant_table};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 4;
