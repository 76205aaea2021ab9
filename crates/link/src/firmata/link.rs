//! A board that speaks Firmata as a link that streams.

use super::board::Uno;
use super::host::Host;
use super::settings::Firmata;
use crate::board::Speech;
use crate::check::{not_below_0, positive};
use crate::streams::Streams;
use crate::talk::Talk;
use zwidth_device::DeviceError;

/// Bits of an AS5600's angle, which a board in software gives whole.
const SENSOR_BITS: u8 = 12;

impl Streams for Firmata {
    fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    fn check(&self) -> Result<(), DeviceError> {
        positive("firmata.rate_hz", self.rate_hz)?;
        not_below_0("firmata.motor_max_v", self.motor_max_v)?;
        not_below_0("firmata.brake_max_v", self.brake_max_v)
    }

    fn brings_force(&self) -> Result<bool, DeviceError> {
        Ok(false)
    }

    fn host(&self, baud: u32) -> Result<Box<dyn Talk>, DeviceError> {
        Ok(Box::new(Host::new(self, baud)?))
    }

    fn board(&self) -> Result<Box<dyn Speech>, DeviceError> {
        Ok(Box::new(Uno::new(self.clone(), SENSOR_BITS)))
    }
}
