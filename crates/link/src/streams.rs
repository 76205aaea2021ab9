//! The interface of a link that streams.

use crate::board::Speech;
use crate::talk::Talk;
use zwidth_device::DeviceError;

/// A link whose board sends readings unasked, by its table of `rig.toml`: all that the others ask
/// of it.
pub(crate) trait Streams {
    /// Readings a second.
    fn rate_hz(&self) -> f64;

    /// Whether what stands there makes sense.
    fn check(&self) -> Result<(), DeviceError>;

    /// Whether the force comes with the readings.
    fn brings_force(&self) -> Result<bool, DeviceError>;

    /// The host's end, at a line of so many bits a second.
    fn host(&self, baud: u32) -> Result<Box<dyn Talk>, DeviceError>;

    /// The board's end, in software.
    fn board(&self) -> Result<Box<dyn Speech>, DeviceError>;
}
