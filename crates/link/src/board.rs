//! The board's end of the wire, with a device behind it.
//!
//! What a firmware does in C, here with the twin or any other device in the place of sensors and
//! drivers: bytes in, bytes out, a watchdog. A rig is tried on it without a board.

use crate::frame::Frames;
use crate::message::{Description, Drive, FromBoard, PROTOCOL, Seen, ToBoard, mark, status};
use zwidth_device::{Angle, Cue, Device, DeviceError, Reading};
use zwidth_study::{Environment, Source, Voltages};

/// Force of one count of its load cell, N: 5 kg over the positive half of 24 bits is 5.8e-6 N; of
/// that the noise takes the last bits.
pub const NEWTONS_PER_COUNT: f64 = 1e-4;
/// What its load cell counts without a force.
pub const ZERO_COUNTS: f64 = 8123.0;
/// The ends of the load cell's range, counts.
const MOST_COUNTS: f64 = 8_388_607.0;
/// A trial's longest time where the host does not tell it, s.
const LIMIT_S: f64 = 4.0;

/// A board.
pub struct Board<D> {
    device: D,
    environments: Vec<Environment>,
    /// Full scale, V.
    full: Voltages,
    frames: Frames,
    /// The place of the environment that the host marked last.
    environment: usize,
    drive: Drive,
    /// When it was written to last, s.
    written_s: f64,
    /// The watchdog took the voltages away.
    tripped: bool,
    /// What is said when it has begun: of a board that was reset unasked.
    begins: bool,
}

impl<D: Device> Board<D> {
    /// With a device behind it; the host marks the environments by their places.
    pub fn new(device: D, environments: Vec<Environment>) -> Self {
        let can = device.capabilities();
        let full = Voltages { motor_v: can.motor_max_v, brake_v: can.brake_max_v };
        Self {
            device,
            environments,
            full,
            frames: Frames::default(),
            environment: 0,
            drive: Drive::default(),
            written_s: 0.0,
            tripped: false,
            begins: false,
        }
    }

    /// Begins anew, as after a press on its button: 0 V, and it says who it is.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn reset(&mut self, now_s: f64) -> Result<(), DeviceError> {
        (self.frames, self.begins) = (Frames::default(), true);
        self.off(now_s)
    }

    /// The voltages that are out.
    pub fn drive(&self) -> Drive {
        self.drive
    }

    /// Takes bytes of the host; what it says to them goes behind `out`. To be called without bytes,
    /// too, as time goes by.
    ///
    /// # Errors
    /// A device that is lost.
    pub fn take(&mut self, now_s: f64, bytes: &[u8], out: &mut Vec<u8>) -> Result<(), DeviceError> {
        if std::mem::take(&mut self.begins) {
            send(&FromBoard::Description(self.description()), 0, out);
        }
        self.watch(now_s)?;
        for byte in bytes {
            let Some(frame) = self.frames.push(*byte) else { continue };
            match ToBoard::read(&frame) {
                Some(ToBoard::Hello) => {
                    send(&FromBoard::Description(self.description()), frame.sequence, out);
                }
                Some(ToBoard::Poll) => {
                    let reading = self.device.read(now_s)?;
                    send(&FromBoard::Seen(self.seen(now_s, &reading)), frame.sequence, out);
                }
                Some(ToBoard::Write(drive)) => self.write(now_s, drive)?,
                Some(ToBoard::Mark { code, number }) => self.mark(now_s, code, number)?,
                None => {}
            }
        }
        Ok(())
    }

    /// Without a write for its time it goes to 0 V.
    fn watch(&mut self, now_s: f64) -> Result<(), DeviceError> {
        let limit_s = self.device.capabilities().watchdog_s.unwrap_or(f64::INFINITY);
        if now_s - self.written_s <= limit_s || self.drive == Drive::default() {
            return Ok(());
        }
        self.off(now_s)?;
        self.tripped = true;
        Ok(())
    }

    fn off(&mut self, now_s: f64) -> Result<(), DeviceError> {
        self.drive = Drive::default();
        self.device.write(now_s, Voltages::OFF)
    }

    fn write(&mut self, now_s: f64, drive: Drive) -> Result<(), DeviceError> {
        (self.written_s, self.tripped) = (now_s, false);
        self.drive = Drive { motor: drive.motor, brake: drive.brake.max(0) };
        let share = |part: i16| f64::from(part) / f64::from(i16::MAX);
        let voltages = Voltages {
            motor_v: share(self.drive.motor) * self.full.motor_v,
            brake_v: share(self.drive.brake) * self.full.brake_v,
        };
        self.device.write(now_s, voltages)
    }

    /// Where a firmware sets its marker line, the device here learns what its participant knows.
    fn mark(&mut self, now_s: f64, code: u8, number: u16) -> Result<(), DeviceError> {
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
            _ => {}
        }
        Ok(())
    }

    fn description(&self) -> Description {
        let can = self.device.capabilities();
        let micros = |hz: f64| (1e6 / hz).round() as u32;
        let millivolts = |volts: f64| (volts * 1e3).floor() as u32;
        Description {
            protocol: PROTOCOL,
            period_us: micros(can.rate_hz),
            force_period_us: micros(can.force_rate_hz),
            counts_per_turn: can.counts_per_turn.map_or(0, |counts| counts as u16),
            motor_mv: millivolts(can.motor_max_v),
            brake_mv: millivolts(can.brake_max_v),
            watchdog_ms: can.watchdog_s.map_or(0, |s| (s * 1e3).round() as u16),
            simulated: can.source == Source::Twin,
            name: format!("board with {}", can.name),
        }
    }

    fn seen(&self, now_s: f64, reading: &Reading) -> Seen {
        let counts = match reading.angle {
            Angle::Counts(counts) => counts,
            Angle::Lever(_) => 0,
        };
        let force = (reading.force_n / NEWTONS_PER_COUNT + ZERO_COUNTS).round();
        let saturated = if force.abs() > MOST_COUNTS { status::FORCE_SATURATED } else { 0 };
        let watchdog = if self.tripped { status::WATCHDOG } else { 0 };
        let micros = |s: f64| (s * 1e6).round();
        Seen {
            t_us: (micros(reading.t_device_s.unwrap_or(now_s)) as u64 & u64::from(u32::MAX)) as u32,
            counts,
            angle_age_us: micros(reading.angle_age_s) as u16,
            force: force.clamp(-MOST_COUNTS, MOST_COUNTS) as i32,
            force_age_us: micros(reading.force_age_s.unwrap_or(0.0)) as u32,
            status: saturated | watchdog,
            drive: self.drive,
        }
    }
}

fn send(message: &FromBoard, sequence: u16, out: &mut Vec<u8>) {
    let (bytes, length) = message.frame(sequence).encode();
    out.extend(&bytes[..length]);
}
