//! Files, whatever they contain: written whole or not at all, held, locked, walked.

pub(crate) mod atomic;
pub(crate) mod content;
pub(crate) mod hash;
pub(crate) mod held;
pub(crate) mod layout;
pub(crate) mod lock;
#[cfg(any(test, feature = "testing"))]
pub(crate) mod memory;
pub(crate) mod port;
pub(crate) mod raw;
pub(crate) mod real_path;
pub(crate) mod regular;
#[cfg(any(test, feature = "testing"))]
mod sectors;
pub(crate) mod stamp;
pub(crate) mod walk;

/// Bytes of a sector: what a disk writes whole or not at all.
pub(crate) const SECTOR: usize = 512;
