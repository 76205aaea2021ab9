//! What a check found.

use zwidth_study::Check;

/// One thing found.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// What, how much, and whether that is good enough: kept with the session.
    pub check: Check,
    /// What it means, and what to do if it is not good enough.
    pub about: &'static str,
}

impl Finding {
    pub(super) fn new(name: &str, value: f64, unit: &str, ok: bool, about: &'static str) -> Self {
        Self { check: Check { name: name.to_owned(), value, unit: unit.to_owned(), ok }, about }
    }
}
