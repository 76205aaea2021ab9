//! Whose plant a model has.

use serde::Serialize;

/// Whose plant a model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Which {
    /// The thesis', chosen by eye.
    ByEye,
    /// The study's, fitted to half of its trials.
    Fitted,
}

impl Which {
    /// Both, the thesis' first.
    pub const ALL: [Self; 2] = [Self::ByEye, Self::Fitted];

    /// The word in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::ByEye => "by_eye",
            Self::Fitted => "fitted",
        }
    }
}
