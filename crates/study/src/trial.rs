//! The facts about a trial besides its samples.

use crate::words::words;
use crate::{Condition, EnvironmentId, ModeId, ParticipantId, Presented, SessionId};
use serde::{Deserialize, Serialize};

words! {
    /// Whether a trial belongs to the experiment.
    Kind {
        /// Counts.
        Trial = "trial",
        /// Practice before the experiment: kept, marked, left out of every analysis.
        Familiarisation = "familiarisation",
    }

    /// Whether a trial was recorded to its end.
    Status {
        /// Recorded to its end.
        Complete = "complete",
        /// Cut short (recovered from a journal): kept, marked, left out of every analysis.
        Incomplete = "incomplete",
    }

    /// Where the numbers come from. A figure made from `twin` or `simulated` data says so on its
    /// face.
    Source {
        /// Measured by this software on a device.
        Recorded = "recorded",
        /// Computed by a simulated device.
        Twin = "twin",
        /// Measured by others, converted by `import`.
        Imported = "imported",
        /// Computed by somebody else's simulation, converted by `import`.
        Simulated = "simulated",
    }
}

impl Source {
    /// Whether nothing was measured.
    pub fn is_simulated(self) -> bool {
        matches!(self, Self::Twin | Self::Simulated)
    }

    /// Whether `import` made it.
    pub fn is_imported(self) -> bool {
        matches!(self, Self::Imported | Self::Simulated)
    }
}

/// The facts about a trial besides its samples.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrialMeta {
    /// Who.
    pub participant: ParticipantId,
    /// In which session.
    pub session: SessionId,
    /// Number within the session, from 1; the file's name carries it.
    pub trial: u32,
    /// Repeat of the condition, from 1.
    pub repeat: u32,
    /// Experiment or familiarisation.
    pub kind: Kind,
    /// Complete or cut short.
    pub status: Status,
    /// The environment that was rendered.
    pub environment: EnvironmentId,
    /// The mode (its sealed code until the session is unsealed).
    pub mode: ModeId,
    /// The answer given before the file was finished, a number of the question's scale.
    pub likert: Option<i16>,
    /// Measured, simulated or imported.
    pub source: Source,
    /// What it presented, if it is of a task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub presented: Option<Presented>,
}

impl TrialMeta {
    /// The condition: environment × mode.
    pub fn condition(&self) -> Condition {
        Condition { environment: self.environment.clone(), mode: self.mode.clone() }
    }

    /// Whether another trial is of the same session.
    pub fn is_of_session_of(&self, other: &Self) -> bool {
        (&self.participant, &self.session) == (&other.participant, &other.session)
    }
}
