//! Figures of model scenes that a study shows beside its data.

use crate::SceneFigureId;
use serde::{Deserialize, Serialize};

/// What is drawn of scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SceneDrawing {
    /// Forces against angle and time, and the angle against time, one column per scene.
    #[default]
    Runs,
    /// The external force against time, side by side.
    Inputs,
    /// Forces of the actuators along the way there and back.
    BowTie,
}

impl SceneDrawing {
    /// How many scenes it takes.
    pub(crate) fn most(self) -> usize {
        match self {
            Self::Runs => 3,
            Self::Inputs => 6,
            Self::BowTie => 1,
        }
    }
}

/// A figure of runs of the model: an entry of `[[scenes]]` in study.toml.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneFigure {
    /// What the figure's files are called after.
    pub id: SceneFigureId,
    /// Scene files, from the study's folder on, with `/`.
    pub files: Vec<String>,
    /// What is drawn of them.
    #[serde(default)]
    pub draw: SceneDrawing,
    /// The solver; if it is not named, the exact one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<String>,
    /// The step, s, in place of the scenes' own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_s: Option<f64>,
}
