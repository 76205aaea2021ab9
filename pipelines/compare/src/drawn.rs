//! How the order of a session's trials was drawn.

use serde::Serialize;
use zwidth_study::order::Rules;
use zwidth_study::{EnvironmentId, ModeId, ParticipantId, SessionId};

/// The order of one session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SessionOrder {
    /// The participant.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// How this program drew the order; `None` for an order from elsewhere.
    pub drawn: Option<DrawnOrder>,
}

/// An order that [`zwidth_study::order::draw`] drew.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct DrawnOrder {
    /// The rules of the draw.
    pub rules: Rules,
    /// The seed: sessions of one seed are balanced against each other. None if it is not known
    /// (sealed sessions); these are assumed to have one seed.
    pub seed: Option<u64>,
    /// Trials before the first block.
    pub familiarisation: u32,
    /// The environments as the rules number them.
    pub environments: Vec<EnvironmentId>,
    /// The modes as the rules number them.
    pub modes: Vec<ModeId>,
    /// Trials that were done in the place of another: the number of each, and the number that the
    /// order gave the place.
    pub repeated: Vec<[u32; 2]>,
}

impl DrawnOrder {
    /// The number that the order gave the place of a trial.
    pub(crate) fn place(&self, trial: u32) -> u32 {
        let repeated = self.repeated.iter().find(|[number, _]| *number == trial);
        repeated.map_or(trial, |[_, place]| *place)
    }

    /// The number of the first trial of the block in which a place is.
    pub(crate) fn first_of_block(&self, place: u32) -> u32 {
        let length = u32::try_from(self.rules.trials_per_block()).unwrap_or(u32::MAX).max(1);
        let first = self.familiarisation.saturating_add(1);
        first.saturating_add(place.saturating_sub(first) / length * length)
    }
}
