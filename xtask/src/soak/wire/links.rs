//! The links that are tried, and what each may believe.

use zwidth_link::simulated::Trouble;
use zwidth_link::{AngleAt, Link};

/// A link as it is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Over {
    pub(crate) name: &'static str,
    pub(crate) link: Link,
    pub(crate) angle: AngleAt,
}

impl Over {
    /// Each link.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        zwidth_link::LINKS.into_iter().map(|(name, link, angle)| Self { name, link, angle })
    }

    /// Readings of a trial that may be wrong after this happened to a message. Frames have a check, and
    /// half a line of a program never makes another line of its with the next one.
    /// Without one a turned bit may make another number, and half a message joined to the next one
    /// another message.
    pub(super) fn believes(self, trouble: Trouble) -> usize {
        match trouble {
            Trouble::Half if self.link == Link::Process => 0,
            Trouble::Corrupt | Trouble::Half if self.link != Link::Framed => 1,
            _ => 0,
        }
    }
}
