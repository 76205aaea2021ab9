//! What tests of several files share: folders with recordings cut short, and a disk that fails; and
//! answers from journal to log.

mod answers;
mod beside;
mod commits;
pub(crate) mod crashes;
pub(crate) mod faulty;
mod outside;
