//! A spring whose far end is moved: it pulls the lever with K (d(t) − θ).

use serde::{Deserialize, Serialize};

use super::term::{Affine, Term};
use crate::scene::input::Input;
use crate::scene::parameter::Parameter;
use crate::scene::plant::Plant;

/// A spring between the lever and a point at the angle d(t).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pull {
    /// K, N at the lever's end per rad.
    pub stiffness_n_per_rad: f64,
    /// d(t), rad; the input's magnitudes are read as angles.
    pub displacement: Input,
}

impl Term for Pull {
    fn name(&self) -> &'static str {
        "pull"
    }

    fn about(&self) -> &'static str {
        "force of the moved spring"
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::not_negative("stiffness_n_per_rad", self.stiffness_n_per_rad, 1.0)]
    }

    fn affine(&self, _: &Plant) -> Affine {
        let k = self.stiffness_n_per_rad;
        Affine { per_rad_n: -k, per_input_n: k, ..Affine::default() }
    }

    fn input(&self) -> Option<(&'static str, &Input)> {
        Some(("displacement", &self.displacement))
    }
}
