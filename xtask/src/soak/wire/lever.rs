//! The device behind the board: it remembers the commands that it received.

use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::{Arc, Mutex, PoisonError};
use zwidth_device::mock::Mock;
use zwidth_device::{Capabilities, Cue, Device, DeviceError, Reading};
use zwidth_link::board::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use zwidth_study::{AnswerScale, Voltages};

/// The lever goes forward for so long, and back for so long, s.
const FORWARD_S: f64 = 0.5;
const BACK_S: f64 = 0.2;
/// By so much, rad.
const SWING_RAD: f64 = 20.0 * PI / 180.0;
/// The force at its end, N.
const MOST_N: f64 = 3.0;

/// A reading as it stands on a wire: the board's clock, µs, and the counts of angle and force.
pub(super) type Counted = (u64, u16, i32);
/// What was seen, in its order.
pub(super) type Seen = Arc<Mutex<Vec<Counted>>>;

/// A device that remembers every reading.
pub(super) struct Remembering<D> {
    device: D,
    seen: Seen,
}

impl<D> Remembering<D> {
    pub(super) fn new(device: D, seen: &Seen) -> Self {
        Self { device, seen: Arc::clone(seen) }
    }
}

/// Whether a device's participant moves the lever by themselves, or by this.
pub(super) trait Told {
    /// The lever is at its stop; or a trial begins.
    fn told(&mut self, begins: bool);
}

impl Told for Mock {
    fn told(&mut self, begins: bool) {
        self.motion = if begins { swing } else { rest };
    }
}

impl Told for zwidth_device::Twin {
    fn told(&mut self, _: bool) {}
}

fn rest(_: f64) -> (f64, f64) {
    (-FRAC_PI_4, 0.0)
}

/// Forward and back, each of its angles once on each way.
fn swing(t_s: f64) -> (f64, f64) {
    let back = ((t_s - FORWARD_S) / BACK_S).clamp(0.0, 1.0);
    let phase = (t_s / FORWARD_S).clamp(0.0, 1.0) + back;
    let there = 0.5 * (1.0 - (PI * phase).cos());
    (-FRAC_PI_4 + SWING_RAD * there, MOST_N * there)
}

/// A device that rests until a trial begins.
pub(super) fn lever() -> Mock {
    Mock::new(rest)
}

/// A reading as a board with this device would put it on its wire.
pub(super) fn counted(now_s: f64, reading: &Reading) -> Counted {
    let t_us = (reading.t_device_s.unwrap_or(now_s) * 1e6).round() as u64;
    (t_us, reading.raw().unwrap_or_default(), force_counts(reading.force_n))
}

/// A force as the load cell's count.
pub(super) fn force_counts(force_n: f64) -> i32 {
    (force_n / NEWTONS_PER_COUNT + ZERO_COUNTS).round() as i32
}

impl<D: Device + Told> Device for Remembering<D> {
    fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.device.told(false);
        self.device.home(now_s)
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let reading = self.device.read(now_s)?;
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        seen.push(counted(now_s, &reading));
        Ok(reading)
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.device.write(now_s, voltages)
    }

    fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
        self.device.told(true);
        self.device.begin(now_s, cue);
    }

    fn answer(&mut self, on: &AnswerScale) -> Option<i16> {
        self.device.answer(on)
    }
}
