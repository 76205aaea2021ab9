//! The lever's weight. θ = 0 is upright, so it pulls away from there: a force (m g r / L) sin θ at the end.

use serde::{Deserialize, Serialize};

use crate::error::{Result, not_negative};

/// Standard gravity, m/s² (CGPM 1901).
const STANDARD_GRAVITY: f64 = 9.806_65;

/// A mass at a radius. Not affine in θ: the exact solver refuses it, the adaptive ones run it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gravity {
    /// m: the lever's mass, kg.
    pub mass_kg: f64,
    /// r: distance of its centre from the axis, m.
    pub radius_m: f64,
}

impl Gravity {
    pub(crate) fn check(&self) -> Result<()> {
        not_negative("gravity.mass_kg", self.mass_kg)?;
        not_negative("gravity.radius_m", self.radius_m)
    }

    /// Torque amplitude m g r, N m.
    pub(crate) fn torque_nm(&self) -> f64 {
        self.mass_kg * STANDARD_GRAVITY * self.radius_m
    }
}
