//! What is fixed about a session when it is laid down.

use crate::{EnvironmentId, Kind, ModeId, ParticipantId, SessionId, Source};
use serde::{Deserialize, Serialize};

/// `sessions/<participant>_<session>.json`: the session as it was set up.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SessionRecord {
    /// Version of this file's form.
    pub schema_version: u32,
    /// Who.
    pub participant: ParticipantId,
    /// Which session.
    pub session: SessionId,
    /// Measured, simulated or imported.
    pub source: Source,
    /// Software that wrote the session, with its version.
    pub software: String,
    /// BLAKE3 of the `study.toml` in force, hexadecimal.
    pub study_blake3: String,
    /// The trials, in order. A questionnaire has trials without samples.
    pub trials: Vec<PlannedTrial>,
}

/// One trial of a session, recorded or only asked about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedTrial {
    /// Number within the session, from 1.
    pub trial: u32,
    /// Repeat of the condition, from 1.
    pub repeat: u32,
    /// Experiment or familiarisation.
    pub kind: Kind,
    /// Environment.
    pub environment: EnvironmentId,
    /// Mode (its sealed code until the session is unsealed).
    pub mode: ModeId,
    /// Whether a file of samples belongs to it.
    pub samples: bool,
}

impl SessionRecord {
    /// The record as the text of its file.
    pub fn to_json(&self) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(self).map(|text| text + "\n")
    }
}
