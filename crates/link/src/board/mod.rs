//! The board's end of each link, with a device behind it.
//!
//! It does what a firmware does in C, with the twin or any other device in the place of sensors and
//! drivers: bytes in, bytes out. A rig can be tested on it without a board. A board that speaks
//! frames has a watchdog; sketches that speak Firmata or print lines have none, so these boards
//! have none either.

pub(crate) mod device;

pub(crate) use device::{Behind, Speech, counts, force_counts};
pub use device::{NEWTONS_PER_COUNT, ZERO_COUNTS};

use crate::firmata::Uno;
use crate::framed::Asked;
use crate::framed::frame::Frames;
use crate::process::BoardLines;
use crate::{Drive, Firmata, Link, Settings};
use zwidth_device::{Device, DeviceError, Reading};
use zwidth_study::Environment;

/// A board.
pub struct Board {
    behind: Behind,
    speech: Box<dyn Speech>,
    /// When it sends the next reading unasked, s.
    due_s: f64,
    /// When the load cell's own port prints the next value, s, and what it has to print.
    weigh_s: f64,
    cell: Vec<u8>,
}

impl Board {
    /// A board that speaks frames; the host marks the environments by their places.
    pub fn new(device: impl Device + 'static, environments: Vec<Environment>) -> Self {
        let behind = Behind::new(Box::new(device), environments, true);
        Self::with(behind, Box::new(Asked::new(Frames::default())))
    }

    /// A board that speaks Firmata, with the device at these pins and an analog input of this many
    /// bits, up to 14.
    pub fn firmata(
        device: impl Device + 'static,
        environments: Vec<Environment>,
        pins: Firmata,
        bits: u8,
    ) -> Self {
        let behind = Behind::new(Box::new(device), environments, false);
        Self::with(behind, Box::new(Uno::new(pins, bits.min(14))))
    }

    /// A board that speaks the protocol of these settings; over Firmata with all of the sensor's 12
    /// bits.
    ///
    /// # Errors
    /// Settings that make no sense.
    pub fn by(
        settings: &Settings,
        device: impl Device + 'static,
        environments: Vec<Environment>,
    ) -> Result<Self, DeviceError> {
        if settings.link == Link::Process {
            let behind = Behind::new(Box::new(device), environments, true);
            return Ok(Self::with(behind, Box::new(Asked::new(BoardLines::new()))));
        }
        let Some(streams) = settings.streams()? else { return Ok(Self::new(device, environments)) };
        let behind = Behind::new(Box::new(device), environments, false);
        Ok(Self::with(behind, streams.board()?))
    }

    fn with(behind: Behind, speech: Box<dyn Speech>) -> Self {
        Self { behind, speech, due_s: 0.0, weigh_s: 0.0, cell: Vec::new() }
    }

    /// Gives `observer` every reading whose angle it sends, as it sends it.
    #[must_use]
    pub fn telling(mut self, observer: impl FnMut(&Reading) + Send + 'static) -> Self {
        self.behind.observer = Box::new(observer);
        self
    }

    /// Restarts, as after a press on its button: it goes to 0 V and identifies itself.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn reset(&mut self, now_s: f64) -> Result<(), DeviceError> {
        self.speech.reset(now_s);
        self.behind.off(now_s)
    }

    /// The voltages that are out.
    pub fn drive(&self) -> Drive {
        self.behind.drive
    }

    /// Takes bytes from the host; its reply is appended to `out`. Call it without bytes, too, as
    /// time passes.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn take(&mut self, now_s: f64, bytes: &[u8], out: &mut Vec<u8>) -> Result<(), DeviceError> {
        self.behind.watch(now_s)?;
        self.speech.take(&mut self.behind, now_s, bytes, out)?;
        let Some(period_s) = self.speech.period_s() else { return Ok(()) };
        let force_period_s = 1.0 / self.behind.capabilities().force_rate_hz;
        if !self.speech.prints_force() && is_due(&mut self.weigh_s, force_period_s, now_s) {
            let (force, _) = force_counts(&self.behind.read(now_s)?);
            self.cell.extend(format!("{force}\r\n").bytes());
        }
        if is_due(&mut self.due_s, period_s, now_s) {
            let reading = self.behind.tell(now_s)?;
            self.speech.print(now_s, &reading, out);
        }
        Ok(())
    }

    /// What the load cell's own port prints: the values since the last call.
    pub fn load_cell(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.cell)
    }
}

/// Whether something is due that comes at each period, and when it is next. Its average is kept,
/// unless time stood still: as StandardFirmata has it.
fn is_due(due_s: &mut f64, period_s: f64, now_s: f64) -> bool {
    let is_due = now_s >= *due_s;
    if is_due {
        let next_s = *due_s + period_s;
        *due_s = if next_s < now_s { now_s + period_s } else { next_s };
    }
    is_due
}
