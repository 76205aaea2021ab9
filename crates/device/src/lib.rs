//! Devices behind one trait: the simulated one, playback, and what stands between them and the control of a trial.
//!
//! A [`Device`] is an instrument: it reads a sample and takes two voltages. It knows no scene and no study folder.
//! Time belongs to a [`Clock`]: the same loop runs in real time and faster than it.

mod clock;
mod device;
mod error;

pub use clock::Clock;
pub use device::{Angle, Capabilities, Cue, Device, Reading};
pub use error::DeviceError;
