//! `cargo xtask firmware COMMAND…`: our host at a microcontroller that runs our firmware in an
//! emulator (`tests/interop/avr/board.js`) with its own time.

mod session;

pub(crate) use session::sessions;

use crate::emulator::Emulator;
use anyhow::ensure;
use std::io;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use zwidth_device::Device as _;
use zwidth_link::{Drive, Rig, Settings, Wire};
use zwidth_study::Voltages;

/// Readings of a run.
const READINGS: u32 = 2000;
/// What a message and its answer take at 500,000 baud, µs: no longer than the board says itself.
const MESSAGE_US: u32 = 2000;
/// The angle sensor's count at the stop.
const STOP: i32 = 300;
/// Steps of the sketch's pulses.
const STEPS: u16 = 255;
/// The newest values of the load cell that it may say: it takes one in 12.5 ms.
const FORCES: u32 = 10;

/// Its serial line: a message is sent, and its answer has come.
#[derive(Clone)]
struct Line(Arc<Mutex<Emulator>>);

impl Line {
    fn now_s(&self) -> f64 {
        self.board().us as f64 * 1e-6
    }

    fn out(&self) -> [u16; 3] {
        self.board().out
    }

    fn board(&self) -> MutexGuard<'_, Emulator> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Wire for Line {
    fn receive(&mut self, into: &mut [u8], _wait: Duration) -> io::Result<usize> {
        Ok(self.board().receive(into))
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.board().run(MESSAGE_US, bytes)
    }
}

/// Readings, voltages, noise and the watchdog.
pub(crate) fn run(command: &[&str]) -> anyhow::Result<()> {
    let line = Line(Arc::new(Mutex::new(Emulator::start(command)?)));
    let settings: Settings = toml::from_str("newtons_per_count = 1")?;
    line.board().set("angle", STOP)?;
    let mut rig = Rig::connect(line.clone(), settings, Vec::new())?;
    let can = rig.capabilities().clone();
    println!("{} at {} Hz, watchdog {:?} s", can.name, can.rate_hz, can.watchdog_s);
    ensure!(can.watchdog_s == Some(0.05) && can.counts_per_turn == Some(1024), "{can:?}");
    // By then it has said who it is a second time, because it has just begun.
    line.board().run(10 * MESSAGE_US, &[])?;
    rig.home(line.now_s())?;
    // Homing goes by real time: the host's clock is past it.
    line.board().us += 1_000_000;
    let full = Voltages { motor_v: can.motor_max_v, brake_v: can.brake_max_v };
    readings(&line, &mut rig, full)?;
    noise(&line, &mut rig)?;
    watchdog(&line, &mut rig, full)?;
    println!("{READINGS} readings, none lost; noise is dropped; without a write for 50 ms: 0 V");
    Ok(())
}

/// Every reading is what the sensors saw, and every command goes out.
fn readings(line: &Line, rig: &mut Rig<Line>, full: Voltages) -> anyhow::Result<()> {
    let force = |i: u32| i as i32 * 7919 % 0x80_0000 - 0x40_0000;
    for i in 0..READINGS {
        let counts = (300 + i * 3) % 1024;
        line.board().set("angle", counts as i32)?;
        line.board().set("force", force(i))?;
        let now_s = line.now_s();
        let reading = rig.read(now_s)?;
        ensure!(reading.raw() == Some(counts as u16), "reading {i}: {reading:?}, not {counts}");
        ensure!(reading.angle_age_s == 0.0, "reading {i} is {} s old", reading.angle_age_s);
        let seen = |by: u32| {
            i.checked_sub(by).is_some_and(|j| (f64::from(force(j)) - reading.force_n).abs() < 0.5)
        };
        ensure!(i < FORCES || (0..FORCES).any(seen), "reading {i}: {} counts", reading.force_n);
        let share = f64::from(i % 201) / 100.0 - 1.0;
        let voltages =
            Voltages { motor_v: share * full.motor_v, brake_v: share.abs() * full.brake_v };
        rig.write(now_s, voltages)?;
        let [motor, brake] = Drive::of(voltages, full).steps(STEPS, STEPS);
        let out = [motor.unsigned_abs() as u16, brake as u16, u16::from(motor >= 0)];
        let is = line.out();
        // Below one step there is no direction.
        ensure!(
            is[..2] == out[..2] && (is[2] == out[2] || motor == 0),
            "command {i}: {is:?}, not {out:?}"
        );
    }
    ensure!(rig.faults() == [0, 0], "{:?} late, damaged", rig.faults());
    Ok(())
}

/// Bytes that are no frame are dropped, and the next answer is right.
fn noise(line: &Line, rig: &mut Rig<Line>) -> anyhow::Result<()> {
    rig.write(line.now_s(), Voltages::OFF)?;
    let mut seed = 1_u32;
    for length in 0..100 {
        let noise: Vec<u8> = (0..length)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (seed >> 24) as u8
            })
            .chain([0])
            .collect();
        line.board().run(2 * MESSAGE_US, &noise)?;
        line.board().set("angle", length)?;
        let now_s = line.now_s();
        ensure!(rig.read(now_s)?.raw() == Some(length as u16), "after {length} bytes of noise");
    }
    Ok(())
}

/// Without a write for its time the board goes to 0 V, says so, and runs again once it is homed.
fn watchdog(line: &Line, rig: &mut Rig<Line>, full: Voltages) -> anyhow::Result<()> {
    rig.write(0.0, full)?;
    line.board().run(45_000, &[])?;
    ensure!(line.out() == [STEPS, STEPS, 1], "{:?} before its time", line.out());
    line.board().run(5_000, &[])?;
    ensure!(line.out()[..2] == [0, 0], "{:?} after its time", line.out());
    let now_s = line.now_s();
    let told = rig.read(now_s).err().map(|e| e.to_string()).unwrap_or_default();
    ensure!(told.contains("watchdog"), "the host says '{told}'");
    rig.write(now_s, Voltages::OFF)?;
    line.board().set("angle", STOP)?;
    rig.home(now_s)?;
    rig.write(0.0, full)?;
    ensure!(line.out() == [STEPS, STEPS, 1], "{:?} after homing", line.out());
    Ok(())
}
