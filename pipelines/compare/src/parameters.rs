//! What a comparison of one metric depends on besides the metrics.

use crate::{Preregistered, SessionOrder};
use serde::Serialize;
use zwidth_study::{Contrast, EnvironmentId, Families, ModeId};

/// What a comparison depends on.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameters {
    /// The metric's column in the table of metrics.
    pub metric: String,
    /// Whether it is the study's primary metric. The claims of every other one are exploratory.
    pub primary: bool,
    /// What the study's plan says of this analysis, where there is a plan.
    pub preregistered: Option<Preregistered>,
    /// Whether any of the data are simulated.
    pub simulated: bool,
    /// The environments, in the study's order.
    pub environments: Vec<EnvironmentId>,
    /// For each environment the size up to which differences are equivalent, in the metric's SI
    /// unit, where the study says so.
    pub bounds: Vec<Option<f64>>,
    /// The modes, in the study's order.
    pub modes: Vec<ModeId>,
    /// The contrasts.
    pub contrasts: Vec<Contrast>,
    /// Which of them are adjusted together.
    pub families: Families,
    /// What an adjusted p value must lie below for a claim.
    pub alpha: f64,
    /// Level of every interval, as a fraction.
    pub level: f64,
    /// How the orders of the sessions came about.
    pub orders: Vec<SessionOrder>,
}

impl Parameters {
    /// The places of an environment and a mode, where the study has them.
    pub(crate) fn condition(&self, environment: &str, mode: &str) -> Option<[usize; 2]> {
        let environment = self.environments.iter().position(|e| e.as_str() == environment)?;
        Some([environment, self.modes.iter().position(|m| m.as_str() == mode)?])
    }

    /// The places of the two modes of a contrast.
    pub(crate) fn modes_of(&self, contrast: &Contrast) -> Option<[usize; 2]> {
        let mode = self.modes.iter().position(|m| *m == contrast.mode)?;
        Some([mode, self.modes.iter().position(|m| *m == contrast.against)?])
    }
}
