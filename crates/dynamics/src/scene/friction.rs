//! Friction of the drive train, felt at the lever's end.

use serde::{Deserialize, Serialize};

use super::numbers;
use super::parameter::Parameter;
use crate::error::{Result, check};

/// Dry friction with a level at rest and a level in motion, and a viscous part:
/// F = −F_k sgn(θ̇) − b θ̇ in motion, |F| ≤ F_s at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// F_s: largest force at rest, N; not below the kinetic level.
    pub static_n: f64,
    /// F_k: force in motion, N.
    pub kinetic_n: f64,
    /// b: viscous part, N s/rad.
    pub viscous_ns_per_rad: f64,
}

impl Friction {
    /// Every number of it.
    pub(super) fn parameters(&self) -> [Parameter; 3] {
        let dry = numbers::FRICTION_N;
        let viscous = self.viscous_ns_per_rad;
        let usual = numbers::VISCOUS_NS_PER_RAD;
        [
            Parameter::not_negative("friction.static_n", self.static_n, dry),
            Parameter::not_negative("friction.kinetic_n", self.kinetic_n, dry),
            Parameter::not_negative("friction.viscous_ns_per_rad", viscous, usual),
        ]
    }

    pub(crate) fn check(&self) -> Result<()> {
        self.parameters().iter().try_for_each(Parameter::checked)?;
        let ordered = self.static_n >= self.kinetic_n;
        check("friction.static_n", self.static_n, ordered, "at least friction.kinetic_n")
    }
}
