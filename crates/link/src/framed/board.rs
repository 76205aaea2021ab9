//! The board's end of a link whose host asks.

use super::message::{Description, FromBoard, PROTOCOL, Seen, ToBoard, UNASKED, status};
use super::wording::BoardWording;
use crate::board::{Behind, Speech, counts, force_counts};
use zwidth_device::{DeviceError, Reading};
use zwidth_study::Source;

/// What it hears, and whether it has just begun.
pub(crate) struct Asked<W> {
    wording: W,
    /// What is said when it has begun: of a board that was reset unasked.
    begins: bool,
}

impl<W> Asked<W> {
    pub(crate) fn new(wording: W) -> Self {
        Self { wording, begins: false }
    }
}

impl<W: BoardWording> Speech for Asked<W> {
    fn reset(&mut self, _: f64) {
        self.wording.reset();
        self.begins = true;
    }

    fn take(
        &mut self,
        behind: &mut Behind,
        now_s: f64,
        bytes: &[u8],
        out: &mut Vec<u8>,
    ) -> Result<(), DeviceError> {
        if std::mem::take(&mut self.begins) {
            self.wording.answer(&FromBoard::Description(description(behind)), UNASKED, out);
        }
        for byte in bytes {
            let Some((number, message)) = self.wording.hear(*byte) else { continue };
            match message {
                ToBoard::Hello => {
                    let board = FromBoard::Description(description(behind));
                    self.wording.answer(&board, number, out);
                }
                ToBoard::Poll => {
                    let reading = behind.tell(now_s)?;
                    let seen = FromBoard::Seen(seen(behind, now_s, &reading));
                    self.wording.answer(&seen, number, out);
                }
                ToBoard::Write(drive) => behind.write(now_s, drive)?,
                ToBoard::Mark { code, number } => behind.mark(now_s, code, number)?,
            }
        }
        Ok(())
    }

    fn period_s(&self) -> Option<f64> {
        None
    }

    fn prints_force(&self) -> bool {
        true
    }

    fn print(&mut self, _: f64, _: &Reading, _: &mut Vec<u8>) {}
}

fn description(behind: &Behind) -> Description {
    let can = behind.capabilities();
    Description {
        protocol: PROTOCOL,
        period_us: (1e6 / can.rate_hz).round() as u32,
        force_period_us: (1e6 / can.force_rate_hz).round() as u32,
        counts_per_turn: can.counts_per_turn.map_or(0, |counts| counts as u16),
        motor_mv: (can.motor_max_v * 1e3).floor() as u32,
        brake_mv: (can.brake_max_v * 1e3).floor() as u32,
        watchdog_ms: behind.watchdog_s.map_or(0, |s| (s * 1e3).round() as u16),
        simulated: can.source == Source::Twin,
        name: format!("board with {}", can.name),
    }
}

fn seen(behind: &Behind, now_s: f64, reading: &Reading) -> Seen {
    let (force, is_saturated) = force_counts(reading);
    let saturated = if is_saturated { status::FORCE_SATURATED } else { 0 };
    let watchdog = if behind.tripped { status::WATCHDOG } else { 0 };
    Seen {
        // A clock of 32 bits, as a board's is: it turns over after 71.6 minutes.
        t_us: (micros(reading.t_device_s.unwrap_or(now_s)) as u64 & u64::from(u32::MAX)) as u32,
        counts: counts(reading),
        angle_age_us: micros(reading.angle_age_s) as u16,
        force,
        force_age_us: micros(reading.force_age_s.unwrap_or(0.0)) as u32,
        status: saturated | watchdog,
        drive: behind.drive,
    }
}

/// A time in whole microseconds.
fn micros(time_s: f64) -> f64 {
    (time_s * 1e6).round()
}
