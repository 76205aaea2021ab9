//! The samples of a short trial that was read, for a caller that needs some of them.

use crate::form::columns::{Columns, Values};
use crate::{Samples, Signal};
use std::sync::Arc;
use zwidth_study::ChannelId;

/// The requested samples of a trial.
pub(crate) struct Shown {
    samples: Arc<Samples>,
    device_s: Option<f64>,
    signals: Vec<Signal>,
    channels: Vec<ChannelId>,
}

impl Shown {
    /// `device_s`: how long the device's clock ran, which the file says without its column.
    pub(crate) fn new(
        samples: Arc<Samples>,
        device_s: Option<f64>,
        signals: &[Signal],
        channels: &[ChannelId],
    ) -> Self {
        Self { samples, device_s, signals: signals.to_vec(), channels: channels.to_vec() }
    }
}

impl Columns for Shown {
    fn rows(&self) -> usize {
        self.samples.rows()
    }

    fn column(&self, signal: Signal) -> Option<Values<'_>> {
        self.samples.column(signal).filter(|_| self.has(signal))
    }

    fn has(&self, signal: Signal) -> bool {
        self.signals.contains(&signal) && self.samples.has(signal)
    }

    fn channel(&self, name: &str) -> Option<Values<'_>> {
        let is_shown = self.channels.iter().any(|channel| channel.as_str() == name);
        Columns::channel(&*self.samples, name).filter(|_| is_shown)
    }

    fn reach(&self, signal: Signal) -> Option<f64> {
        match signal {
            Signal::DeviceTime => self.device_s,
            _ => self.samples.reach(signal).filter(|_| self.has(signal)),
        }
    }
}
