//! The Z-width of a device: which stiffness and damping of a virtual wall it renders without
//! oscillation that goes on.
//!
//! A [`Probe`] is a mode, a push, a damping and a repeat. [`search`] raises the stiffness until the
//! lever keeps swinging after a push, or an actuator saturates, and closes in on the boundary;
//! [`regions`] joins the repeats of all probes to boundaries with intervals, and sums them up.
//! Colgate & Brown 1994 call an impedance achievable if it is passive; here it is one without
//! oscillation. [`response`] has beside it what recordings say of impedance against frequency.

mod frequency;
mod region;
mod search;
mod tables;
#[cfg(test)]
mod tests;

/// What the searches of a Z-width test go by among a study's sweeps: no actuator, so that no
/// characteristic is fitted to them.
pub const ACTUATOR: &str = "impedance";

pub use frequency::{Recording, Response, ResponsePoint, response};
pub use region::{Bound, Region, regions};
pub use search::{Ending, Found, Probe, Tried, probes, search};
pub use tables::{bounds, impedance_points, z_widths, z_widths_table};
