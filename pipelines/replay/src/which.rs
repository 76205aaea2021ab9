//! Whose plant a model has.

use serde::Serialize;

/// Whose plant a model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Which {
    /// The thesis', chosen by eye.
    ByEye,
    /// The study's, fitted to half of its trials.
    Fitted,
    /// That of the terms which the condition needs, as the ladder found, fitted by it.
    Auto,
}

impl Which {
    /// All, the thesis' first.
    pub const ALL: [Self; 3] = [Self::ByEye, Self::Fitted, Self::Auto];

    /// The word in tables.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::ByEye => "by_eye",
            Self::Fitted => "fitted",
            Self::Auto => "auto",
        }
    }
}
