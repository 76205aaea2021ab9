//! Frames of our own: the host asks, the board answers. `docs/rig.md` describes them byte by byte;
//! a sketch of a hundred lines can speak them.

mod board;
pub mod frame;
pub mod message;
pub(crate) mod patience;
mod rig;
pub(crate) mod wording;

pub(crate) use board::Asked;
pub use rig::Rig;
