//! The fingertip between the user's force and the lever.

use serde::{Deserialize, Serialize};

use super::numbers;
use super::parameter::Parameter;
use zwidth_study::worded;

worded! {
    /// In which frame the finger's mass is accelerated.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    FingerLaw {
        /// (11) as printed, M_F ẍ2 = F_F + F_ex: the lever's acceleration is left out, so energy is
        /// not kept.
        Thesis = "thesis",
        /// M_F (ẍ2 + L θ̈) = F_F + F_ex. Bottoming is inelastic and keeps momentum.
        Consistent = "consistent",
    }
}

/// A mass on tissue: F_F = −K_F x2 − B_F ẋ2 (9), |x2| ≤ L_F0, where the tissue is a rigid stop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Finger {
    /// In which frame the mass is accelerated.
    pub law: FingerLaw,
    /// M_F, kg.
    pub mass_kg: f64,
    /// K_F, N/m.
    pub stiffness_n_per_m: f64,
    /// B_F, N s/m.
    pub damping_ns_per_m: f64,
    /// L_F0, m; without it the tissue never bottoms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_m: Option<f64>,
}

impl Finger {
    /// Every number of it.
    pub(super) fn parameters(&self) -> Vec<Parameter> {
        let (stiffness, damping) =
            (numbers::FINGER_STIFFNESS_N_PER_M, numbers::FINGER_DAMPING_NS_PER_M);
        let mut list = vec![
            Parameter::positive("finger.mass_kg", self.mass_kg, numbers::FINGER_MASS_KG),
            Parameter::not_negative("finger.stiffness_n_per_m", self.stiffness_n_per_m, stiffness),
            Parameter::not_negative("finger.damping_ns_per_m", self.damping_ns_per_m, damping),
        ];
        let length = self.length_m;
        let usual = numbers::FINGER_LENGTH_M;
        list.extend(length.map(|length| Parameter::positive("finger.length_m", length, usual)));
        list
    }
}
