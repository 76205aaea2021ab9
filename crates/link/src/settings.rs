//! What a host must be told of a rig: no board can know it.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use zwidth_device::DeviceError;

/// Which way the angle sensor counts while the lever is pushed into the object (+θ).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Turning {
    /// Up.
    #[default]
    Up,
    /// Down.
    Down,
}

/// What stands in `rig.toml`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// The serial port, as the system calls it.
    pub port: Option<PathBuf>,
    /// Bits a second on the wire.
    #[serde(default = "usual_baud")]
    pub baud: u32,
    /// Force of one count of the load cell, N; below 0 where a push into the object counts down.
    pub newtons_per_count: f64,
    /// What the load cell counts without a force.
    #[serde(default)]
    pub zero_counts: f64,
    /// Turns of the angle sensor's shaft in one turn of the lever.
    #[serde(default = "prototype_turns")]
    pub shaft_per_lever: f64,
    /// Which way the angle sensor counts.
    #[serde(default)]
    pub turning: Turning,
}

/// Enough for 1 kHz, and what an Arduino's clock divides without an error.
fn usual_baud() -> u32 {
    500_000
}

fn prototype_turns() -> f64 {
    zwidth_device::SHAFT_PER_LEVER
}

impl Settings {
    /// Whether they make sense.
    ///
    /// # Errors
    /// The first that does not.
    pub fn check(&self) -> Result<(), DeviceError> {
        let bad = |name, value, allowed| Err(DeviceError::Parameter { name, value, allowed });
        if !(self.newtons_per_count.is_finite() && self.newtons_per_count != 0.0) {
            return bad("newtons_per_count", self.newtons_per_count, "finite and not 0");
        }
        if !self.zero_counts.is_finite() {
            return bad("zero_counts", self.zero_counts, "finite");
        }
        if !(self.shaft_per_lever.is_finite() && self.shaft_per_lever > 0.0) {
            return bad("shaft_per_lever", self.shaft_per_lever, "above 0 and finite");
        }
        if self.baud == 0 {
            return bad("baud", 0.0, "above 0");
        }
        Ok(())
    }
}
