//! A spring whose far end is moved: it pulls the lever with K (d(t) − θ).

use serde::{Deserialize, Serialize};

use super::input::Input;
use crate::error::{Result, not_negative};

/// A spring between the lever and a point at the angle d(t).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pull {
    /// K, N at the lever's end per rad.
    pub stiffness_n_per_rad: f64,
    /// d(t), rad; the input's magnitudes are read as angles.
    pub displacement: Input,
}

impl Pull {
    pub(crate) fn check(&self, duration_s: f64) -> Result<()> {
        not_negative("pull.stiffness_n_per_rad", self.stiffness_n_per_rad)?;
        self.displacement.check("pull.displacement", duration_s)
    }
}
