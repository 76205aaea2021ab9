//! The wire to a board.
//!
//! At the host's end is a [`zwidth_device::Device`] over a [`Wire`], by one of three links, each a
//! folder with the host's end, the board's end and its settings: a [`Rig`] asks a board by
//! [`framed`] messages, or a program by lines of JSON ([`process`]); a board that speaks [`firmata`], or prints lines of [`text`], sends its
//! readings unasked. The protocols are pure functions of bytes: the bytes read the same however
//! they are split, and whatever is not a message is dropped. [`Board`] is the other end of each
//! link, with any device behind it, such as the twin: a rig can be tested on it without a board.

pub mod board;
mod check;
pub mod discover;
mod drive;
pub mod firmata;
pub mod framed;
#[cfg(any(test, feature = "testing"))]
pub mod hostile;
mod open;
pub mod process;
mod rate;
mod serial;
mod settings;
mod shaft;
#[cfg(any(test, feature = "testing"))]
pub mod simulated;
mod stream;
mod streams;
mod talk;
#[cfg(test)]
mod tests;
pub mod text;
#[cfg(unix)]
mod window;
mod wire;

pub use board::Board;
pub use drive::{Drive, mark};
pub use firmata::{AngleAt, Firmata};
pub use framed::Rig;
pub use open::{open, over};
pub use process::Process;
#[cfg(unix)]
pub use serial::Pair;
pub use serial::Serial;
pub use settings::{Hx711, LINKS, Link, Settings, Turning, Windings};
pub use text::{Templates, Text};
#[cfg(unix)]
pub use window::Window;
pub use wire::Wire;
