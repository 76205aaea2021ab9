//! While this value lives, actuators may be on; when it is dropped, for whatever reason, they are
//! off.

use super::Moments;
use crate::timing::Tick;
use crate::{Cue, Device, Guard, Reading, Seen, Trip};
use zwidth_study::{Sample, Voltages};

/// A device whose actuators may be on, and its guard. Dropped by a normal end, an error or a panic
/// alike, it writes 0 V and disarms the guard. (A device that is lost cannot be written to; its own
/// watchdog turns it off.)
pub(crate) struct Output<'a> {
    device: &'a mut dyn Device,
    guard: &'a mut Guard,
    /// When it last looked, host time, s.
    looked_s: f64,
    /// When it last looked or wrote, host time, s: a device's time never runs back.
    now_s: f64,
    /// When the trial began, host time, s.
    pub(super) begun_s: f64,
    /// What the device has shown of the trial, where it is to show anything: its moments, and its
    /// end when this goes.
    pub(super) shown: Option<Moments>,
}

impl<'a> Output<'a> {
    pub(crate) fn new(device: &'a mut dyn Device, guard: &'a mut Guard, now_s: f64) -> Self {
        Self { device, guard, looked_s: now_s, now_s, begun_s: now_s, shown: None }
    }

    /// Shows the moments that this sample is.
    pub(crate) fn show(&mut self, sample: &Sample) {
        if let Some(shown) = &mut self.shown {
            shown.of(sample.flags).for_each(|moment| self.device.mark(moment));
        }
    }

    /// Tells the device that a trial begins, if a voltage may be written at all.
    pub(crate) fn begin(&mut self, now_s: f64, cue: &Cue<'_>) -> Result<(), Trip> {
        self.begun_s = now_s;
        self.guard.permit(Voltages::OFF)?;
        self.device.begin(now_s, cue);
        Ok(())
    }

    /// Reads, and has the reading judged.
    pub(crate) fn look(&mut self, tick: &Tick) -> Result<(Reading, Seen), Trip> {
        let elapsed_s = tick.now_s - self.looked_s;
        (self.looked_s, self.now_s) = (tick.now_s, tick.now_s);
        // A device that was not read was not followed either: its turn may be lost.
        let reading = self.device.read(tick.now_s).inspect_err(|_| self.guard.lose())?;
        let seen = self.guard.see(tick.now_s, elapsed_s, tick.missed_s, &reading)?;
        Ok((reading, seen))
    }

    /// The same without a voltage, where a late tick does no harm.
    pub(crate) fn look_unhurried(&mut self, tick: &Tick) -> Result<(Reading, Seen), Trip> {
        self.look(&Tick { missed_s: 0.0, ..*tick })
    }

    /// Reads a device whose turn is not known.
    pub(crate) fn read(&mut self, tick: &Tick) -> Result<Reading, Trip> {
        self.now_s = tick.now_s;
        Ok(self.device.read(tick.now_s)?)
    }

    /// Whether the loop came to this tick in time: one that slept through the rest of a trial has
    /// not recorded it.
    pub(crate) fn in_time(&mut self, tick: &Tick) -> Result<(), Trip> {
        self.guard.keep_time(tick.now_s - self.looked_s, tick.missed_s)
    }

    /// Writes what the guard permits of the voltages; these, and whether that is less.
    pub(crate) fn command(
        &mut self,
        now_s: f64,
        commanded: Voltages,
    ) -> Result<(Voltages, bool), Trip> {
        let (voltages, clipped) = self.guard.permit(commanded)?;
        self.write(now_s, voltages)?;
        Ok((voltages, clipped))
    }

    /// Writes 0 V: a board's watchdog wants to hear of it.
    pub(crate) fn off(&mut self, now_s: f64) -> Result<(), Trip> {
        self.write(now_s, Voltages::OFF)
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), Trip> {
        self.now_s = now_s;
        let written = self.device.write(now_s, voltages);
        Ok(written.inspect_err(|_| self.guard.lose())?)
    }
}

impl Drop for Output<'_> {
    fn drop(&mut self) {
        // First, so that nothing is allowed any more even if the device panics.
        self.guard.disarm();
        // There is nobody left to tell: a device that cannot be written to has been reported by the
        // tick.
        let _ = self.device.write(self.now_s, Voltages::OFF);
        let end = self.shown.as_ref().and_then(Moments::end);
        end.into_iter().for_each(|end| self.device.mark(end));
    }
}
