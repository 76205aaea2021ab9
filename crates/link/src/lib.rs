//! The wire to a board.
//!
//! At the host's end stands a [`Rig`]: a [`zwidth_device::Device`] that asks a board over a [`Wire`].
//! What goes over it are [`frame`]s with [`message`]s in them, pure functions of bytes: the page
//! `docs/rig.md` has them byte by byte, so that a sketch of a hundred lines can speak them.
//! [`Board`] is the other end with any device behind it, as the twin: what a rig is tried on without
//! a board.

pub mod board;
pub mod frame;
pub mod message;
mod rig;
mod serial;
mod settings;
#[cfg(test)]
mod tests;
mod wire;

pub use board::Board;
pub use rig::Rig;
#[cfg(unix)]
pub use serial::Pair;
pub use serial::Serial;
pub use settings::{Settings, Turning};
pub use wire::Wire;
