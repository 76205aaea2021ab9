//! The unit of analysis: what n counts, and whom a sentence may speak of.

use crate::cells::Cells;

/// What n counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Unit {
    /// Participants: repeats and sessions are averaged within each.
    Participants,
    /// The trials of the only participant: nothing is said of anybody else.
    Trials {
        /// The participant's code.
        of: String,
    },
}

impl Unit {
    /// That of cells of one participant or of several.
    pub(crate) fn of(cells: &Cells) -> Self {
        match cells.participants.as_slice() {
            [only] => Self::Trials { of: only.clone() },
            _ => Self::Participants,
        }
    }

    /// `participants`, `trials of P01`.
    pub(crate) fn words(&self) -> String {
        match self {
            Self::Participants => "participants".to_owned(),
            Self::Trials { of } => format!("trials of {of}"),
        }
    }
}
