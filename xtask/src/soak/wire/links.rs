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

/// The links.
pub(crate) const LINKS: [Over; 4] = [
    Over { name: "framed", link: Link::Framed, angle: AngleAt::I2c },
    Over { name: "firmata", link: Link::Firmata, angle: AngleAt::Analog(0) },
    Over { name: "firmata-i2c", link: Link::Firmata, angle: AngleAt::I2c },
    Over { name: "text", link: Link::Text, angle: AngleAt::I2c },
];

impl Over {
    /// Readings of a trial that may be wrong after this happened to a message. Frames have a check.
    /// Without one a turned bit may make another number, and half a message joined to the next one
    /// another message.
    pub(super) fn believes(self, trouble: Trouble) -> usize {
        match trouble {
            Trouble::Corrupt | Trouble::Half if self.link != Link::Framed => 1,
            _ => 0,
        }
    }
}
