//! The wire to a board.
//!
//! At the host's end stands a [`zwidth_device::Device`] over a [`Wire`], by one of three links: a
//! [`Rig`] asks a board by [`frame`]s with [`message`]s in them; a board that speaks [`firmata`],
//! or prints lines of [`text`], sends its readings unasked. What goes over the wire are pure
//! functions of bytes: any split of them reads alike, and what is no message is dropped. The page
//! `docs/rig.md` has the frames byte by byte, so that a sketch of a hundred lines can speak them.
//! [`Board`] is the other end of each with any device behind it, as the twin: what a rig is tried
//! on without a board.

pub mod board;
pub mod discover;
pub mod firmata;
pub mod frame;
pub mod hostile;
pub mod message;
mod open;
mod patience;
mod rate;
mod rig;
mod serial;
mod settings;
mod shaft;
pub mod simulated;
mod stream;
mod talk;
#[cfg(test)]
mod tests;
pub mod text;
#[cfg(unix)]
mod window;
mod wire;

pub use board::Board;
pub use open::{open, over};
pub use rig::Rig;
#[cfg(unix)]
pub use serial::Pair;
pub use serial::Serial;
pub use settings::{AngleAt, Firmata, Hx711, Link, Settings, Templates, Text, Turning};
#[cfg(unix)]
pub use window::Window;
pub use wire::Wire;
