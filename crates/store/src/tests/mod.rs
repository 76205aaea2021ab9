//! What tests of several files share: folders with recordings cut short, and a disk that fails.

pub(crate) mod crashes;
pub(crate) mod faulty;
