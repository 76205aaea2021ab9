//! What sessions are recorded with, and the counts of their events.

use std::collections::BTreeMap;

/// Which device the sessions are recorded with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum With {
    /// The mock, which fails as it is told.
    Mock,
    /// The simulated device and its participant.
    Twin,
}

impl With {
    /// What the chore is called.
    pub(super) fn chore(self) -> &'static str {
        if self == Self::Twin { "simulate-twin" } else { "simulate" }
    }

    /// How long its machine sleeps at times, s: longer than any trial. The twin moves on for all of
    /// it, so its is short.
    pub(super) fn nap_s(self) -> f64 {
        if self == Self::Twin { 30.0 } else { 3600.0 }
    }
}

/// How often each thing happened.
pub(super) type Counts = BTreeMap<&'static str, u64>;
