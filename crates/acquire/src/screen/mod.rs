//! The screen of a session: a terminal, drawn by ratatui, that works over ssh, at 80 × 24 and
//! larger, with or without colour.
//!
//! [`render`](render::render) turns a [`View`](crate::View) into a frame and [`press`](keys::press)
//! a key into an [`Input`](crate::Input); both are pure. [`Screen`] binds them to the terminal on
//! two threads of its own, so that neither a slow line nor a stalled window holds up the session,
//! nor the stop key.

mod felt;
mod foot;
mod keys;
pub(crate) mod look;
mod panel;
mod place;
mod render;
mod terminal;
pub(crate) mod text;
mod trace;
pub(crate) mod window;

#[cfg(test)]
mod tests;

pub use look::Look;
pub use terminal::{Screen, terminal_width};
