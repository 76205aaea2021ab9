//! The lever's weight. θ = 0 is upright, so the weight pulls away from there, with a force (m g r /
//! L) sin θ at the end.

use serde::{Deserialize, Serialize};

use super::term::{Curve, Term};
use crate::scene::parameter::Parameter;
use crate::scene::plant::Plant;

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

impl Term for Gravity {
    fn name(&self) -> &'static str {
        "gravity"
    }

    fn about(&self) -> &'static str {
        "the lever's weight"
    }

    fn parameters(&self) -> Vec<Parameter> {
        /// A printed lever of a few centimetres: 20 g at 40 mm.
        const USUAL: (f64, f64) = (0.02, 0.04);
        vec![
            Parameter::not_negative("mass_kg", self.mass_kg, USUAL.0),
            Parameter::not_negative("radius_m", self.radius_m, USUAL.1),
        ]
    }

    fn curve(&self, plant: &Plant, theta_rad: f64, _: f64) -> Option<Curve> {
        let amplitude_n = self.mass_kg * STANDARD_GRAVITY * self.radius_m / plant.lever_m;
        let (sine, cosine) = libm::sincos(theta_rad);
        Some(Curve {
            force_n: amplitude_n * sine,
            per_rad_n: amplitude_n * cosine,
            per_rad_s_n: 0.0,
        })
    }
}
