//! The Z-width of a device: which stiffness and damping of a virtual wall it renders without
//! sustained oscillation.
//!
//! A [`Probe`] is a mode, a push, a damping and a repeat. [`search`] raises the stiffness until the
//! lever keeps swinging after a push, or an actuator saturates, and brackets the boundary ever more
//! closely; [`regions`] joins the repeats of all probes to boundaries with intervals, and sums them
//! up. Colgate & Brown 1994 call an impedance achievable if it is passive; here it is achievable
//! without oscillation. [`response`] gives impedance against frequency from recordings beside it.

mod frequency;
mod region;
mod search;
mod tables;
#[cfg(test)]
mod tests;

/// The name of the searches of a Z-width test among a study's sweeps: it is not an actuator, so no
/// characteristic is fitted to them.
pub const ACTUATOR: &str = "impedance";

pub use frequency::{Recording, Response, ResponsePoint, response};
pub use region::{Region, regions};
pub use search::{Ending, Found, Probe, Search, Tried, probes, search};
pub use tables::{bounds, impedance_points, z_widths, z_widths_table};
