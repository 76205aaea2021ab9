//! A board that prints lines as a link that streams.

use super::Field;
use super::board::Sketch;
use super::host::Host;
use super::settings::Text;
use crate::board::Speech;
use crate::check::{not_below_0, positive, require};
use crate::streams::Streams;
use crate::talk::Talk;
use zwidth_device::DeviceError;

impl Streams for Text {
    fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    fn check(&self) -> Result<(), DeviceError> {
        positive("text.rate_hz", self.rate_hz)?;
        positive("text.pwm_full", self.pwm_full.into())?;
        not_below_0("text.motor_max_v", self.motor_max_v)?;
        not_below_0("text.brake_max_v", self.brake_max_v)?;
        let counts = self.counts_per_turn;
        require(counts >= 2, "text.counts_per_turn", counts.into(), "2 or more")?;
        self.templates().map(drop)
    }

    fn brings_force(&self) -> Result<bool, DeviceError> {
        Ok(self.templates()?.line.has(Field::Hx711))
    }

    fn host(&self, baud: u32) -> Result<Box<dyn Talk>, DeviceError> {
        Ok(Box::new(Host::new(self, baud)?))
    }

    fn board(&self) -> Result<Box<dyn Speech>, DeviceError> {
        Ok(Box::new(Sketch::new(self)?))
    }
}
