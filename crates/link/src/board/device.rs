//! What every board has: a device behind it, voltages, a watchdog, markers, and a protocol.

use crate::{Drive, mark};
use zwidth_device::{Angle, Capabilities, Cue, Device, DeviceError, Reading};
use zwidth_study::{Environment, Voltages};

/// Force of one count of its load cell, N: 5 kg over the positive half of 24 bits is 5.8e-6 N; of
/// that the noise takes the last bits.
pub const NEWTONS_PER_COUNT: f64 = 1e-4;
/// What its load cell counts without a force.
pub const ZERO_COUNTS: f64 = 8123.0;
/// The ends of the load cell's range, counts.
pub(crate) const MOST_COUNTS: f64 = 8_388_607.0;
/// A trial's longest time where the host does not tell it, s.
const LIMIT_S: f64 = 4.0;

/// A device at a board.
pub(crate) struct Behind {
    device: Box<dyn Device>,
    environments: Vec<Environment>,
    /// Full scale, V.
    pub(crate) full: Voltages,
    /// The place of the environment that the host marked last.
    environment: usize,
    pub(crate) drive: Drive,
    /// Without a write for so long it goes to 0 V, s.
    pub(crate) watchdog_s: Option<f64>,
    /// When it was written to last, s.
    written_s: f64,
    /// The watchdog took the voltages away.
    pub(crate) tripped: bool,
    /// Gets every reading whose angle is sent.
    pub(crate) observer: Box<dyn FnMut(&Reading) + Send>,
}

impl Behind {
    pub(crate) fn new(
        device: Box<dyn Device>,
        environments: Vec<Environment>,
        has_watchdog: bool,
    ) -> Self {
        let can = device.capabilities();
        let full = Voltages { motor_v: can.motor_max_v, brake_v: can.brake_max_v };
        let watchdog_s = can.watchdog_s.filter(|_| has_watchdog);
        Self {
            device,
            environments,
            full,
            environment: 0,
            drive: Drive::default(),
            watchdog_s,
            written_s: 0.0,
            tripped: false,
            observer: Box::new(|_| {}),
        }
    }

    pub(crate) fn capabilities(&self) -> &Capabilities {
        self.device.capabilities()
    }

    pub(crate) fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.device.read(now_s)
    }

    /// A reading whose angle is sent.
    pub(crate) fn tell(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let reading = self.read(now_s)?;
        (self.observer)(&reading);
        Ok(reading)
    }

    /// Without a write for its time it goes to 0 V. Without a watchdog the voltages stay, whatever
    /// the device behind has of its own.
    pub(crate) fn watch(&mut self, now_s: f64) -> Result<(), DeviceError> {
        if self.drive == Drive::default() {
            return Ok(());
        }
        // Written again and again, so that a watchdog of the device behind finds nothing to do.
        let Some(limit_s) = self.watchdog_s else { return self.write(now_s, self.drive) };
        if now_s - self.written_s <= limit_s {
            return Ok(());
        }
        self.off(now_s)?;
        self.tripped = true;
        Ok(())
    }

    pub(crate) fn off(&mut self, now_s: f64) -> Result<(), DeviceError> {
        self.drive = Drive::default();
        self.device.write(now_s, Voltages::OFF)
    }

    pub(crate) fn write(&mut self, now_s: f64, drive: Drive) -> Result<(), DeviceError> {
        (self.written_s, self.tripped) = (now_s, false);
        self.drive = Drive { motor: drive.motor, brake: drive.brake.max(0) };
        self.device.write(now_s, self.drive.voltages(self.full))
    }

    /// Where a firmware sets its marker line, the device here learns what its participant knows.
    pub(crate) fn mark(&mut self, now_s: f64, code: u8, number: u16) -> Result<(), DeviceError> {
        match code {
            mark::HOMING => drop(self.device.home(now_s)?),
            mark::ENVIRONMENT => self.environment = usize::from(number),
            mark::TRIAL => {
                let environment = self.environments.get(self.environment);
                if let Some(environment) = environment {
                    let cue = Cue { trial: number.into(), environment, limit_s: LIMIT_S };
                    self.device.begin(now_s, &cue);
                }
            }
            mark::MOMENT => {
                if let Some(moment) = mark::moment(number) {
                    self.device.mark(moment);
                }
            }
            _ => {}
        }
        Ok(())
    }
}

/// What a board does with bytes: its end of a link.
pub(crate) trait Speech: Send {
    /// Begins anew, as after a press on its button.
    fn reset(&mut self, now_s: f64);

    /// Takes bytes of the host; what it says to them goes behind `out`.
    fn take(
        &mut self,
        behind: &mut Behind,
        now_s: f64,
        bytes: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), DeviceError>;

    /// Time from one reading to the next that it sends unasked, s; none where each is asked for.
    fn period_s(&self) -> Option<f64>;

    /// Whether a reading has the force; else the load cell prints it at a port of its own.
    fn prints_force(&self) -> bool;

    /// Sends a reading unasked.
    fn print(&mut self, now_s: f64, reading: &Reading, out: &mut Vec<u8>);
}

/// The angle sensor's count of a reading.
pub(crate) fn counts(reading: &Reading) -> u16 {
    match reading.angle {
        Angle::Counts(counts) => counts,
        Angle::Lever(_) => 0,
    }
}

/// The load cell's count of a reading, and whether it is at the end of its range.
pub(crate) fn force_counts(reading: &Reading) -> (i32, bool) {
    let force = (reading.force_n / NEWTONS_PER_COUNT + ZERO_COUNTS).round();
    (force.clamp(-MOST_COUNTS, MOST_COUNTS) as i32, force.abs() > MOST_COUNTS)
}
