//! The moving mass: M_O L θ̈ = sum of the forces at the lever's end (10).

use serde::{Deserialize, Serialize};

use crate::error::{Result, check, finite, positive};

/// Lever and mass. With `lever_m = 1` and no stops the equations are those of the linear model, and
/// every "rad" is a metre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plant {
    /// M_O: mass felt at the lever's end, kg.
    pub mass_kg: f64,
    /// L: lever length, m.
    pub lever_m: f64,
    /// Where the mechanical stops are, rad, lower first; inelastic. Without them the lever turns
    /// freely.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stops_rad: Option<[f64; 2]>,
}

impl Plant {
    pub(crate) fn check(&self) -> Result<()> {
        positive("plant.mass_kg", self.mass_kg)?;
        positive("plant.lever_m", self.lever_m)?;
        let Some([low, high]) = self.stops_rad else { return Ok(()) };
        finite("plant.stops_rad[0]", low)?;
        finite("plant.stops_rad[1]", high)?;
        check("plant.stops_rad[1]", high, low < high, "above plant.stops_rad[0]")
    }
}

/// State at t = 0; the finger and the actuators start at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// θ, rad; within the stops.
    pub theta_rad: f64,
    /// θ̇, rad/s.
    #[serde(default)]
    pub theta_dot_rad_s: f64,
}

impl Start {
    pub(crate) fn check(&self, plant: &Plant) -> Result<()> {
        finite("start.theta_rad", self.theta_rad)?;
        finite("start.theta_dot_rad_s", self.theta_dot_rad_s)?;
        let inside =
            plant.stops_rad.is_none_or(|[low, high]| (low..=high).contains(&self.theta_rad));
        check("start.theta_rad", self.theta_rad, inside, "between the stops")
    }
}
