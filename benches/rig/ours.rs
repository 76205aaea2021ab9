//! Our end of `benches/rig`: `rig-bench board` is a board with the twin behind it at a
//! pseudo-terminal, which prints its port; `rig-bench loop PORT RATE TICKS` is the loop of a
//! session on it, and prints when each tick began after its deadline and how long its answer and
//! command took, µs, a tick in a line. `rig-bench program RATE TICKS COMMAND…` is the same with a program as
//! the device. `rig-bench clock RATE TICKS` does the same without a line: it
//! looks at the clock and does nothing else, so what is late there the machine itself made late.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program of one page that tells what it measured

use std::path::Path;
use std::time::{Duration, Instant};
use zwidth_device::{Clock, Device, Priority, RealClock};
#[cfg(unix)]
use zwidth_device::{Person, Twin, TwinParameters};
#[cfg(unix)]
use zwidth_link::{Board, Pair, Wire as _};
use zwidth_link::{Process, Serial, Settings, open, over};
use zwidth_study::Voltages;

/// Each answer comes in its own tick at 1 kHz.
const RIG: &str = "newtons_per_count = 1e-4\nbaud = 1000000";

/// The program is named on the command line.
const PROGRAM: &str = "link = \"process\"\n[process]\ncommand = [\"\"]";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        #[cfg(unix)]
        ["board"] => board(),
        ["loop", port, rate_hz, ticks] => {
            hold(Path::new(port), rate_hz.parse().unwrap(), ticks.parse().unwrap());
        }
        ["program", rate_hz, ticks, command @ ..] => {
            ask(command, rate_hz.parse().unwrap(), ticks.parse().unwrap());
        }
        ["clock", rate_hz, ticks] => {
            watch(rate_hz.parse().unwrap(), ticks.parse().unwrap());
        }
        _ => println!(
            "rig-bench board | loop PORT RATE TICKS | program RATE TICKS COMMAND… | clock RATE TICKS"
        ),
    }
}

/// Until it is stopped.
#[cfg(unix)]
fn board() {
    let twin = Twin::new(TwinParameters::default(), Person::draw(3), 5).unwrap();
    let mut board = Board::new(twin, zwidth_testing::study().environments);
    let mut line = Pair::open().unwrap();
    println!("{}", line.port().display());
    // What runs at a host does not slow a board.
    Priority::raise();
    let began = Instant::now();
    loop {
        let (mut bytes, mut out) = ([0; 256], Vec::new());
        let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
        board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out).unwrap();
        // What nobody reads is gone.
        let _ = line.send(&out);
    }
}

fn hold(port: &Path, rate_hz: f64, ticks: u64) {
    let settings: Settings = toml::from_str(RIG).unwrap();
    let wire = Serial::open(port, settings.baud()).unwrap();
    let rig = over(wire, None, &settings, Vec::new()).unwrap();
    session(rig, rate_hz, ticks);
}

/// A program is its device.
fn ask(command: &[&str], rate_hz: f64, ticks: u64) {
    let command = command.iter().map(|word| (*word).to_owned()).collect();
    let mut settings: Settings = toml::from_str(PROGRAM).unwrap();
    settings.process = Some(Process { command, folder: ".".into(), ..Process::default() });
    session(open(None, &settings, Vec::new()).unwrap(), rate_hz, ticks);
}

/// The loop of a session.
fn session(mut rig: Box<dyn Device>, rate_hz: f64, ticks: u64) {
    let mut clock = RealClock::new();
    rig.home(clock.now_s()).unwrap();
    told(&in_time(&mut clock, rate_hz, ticks, |clock, woke_s| {
        rig.read(woke_s).unwrap();
        rig.write(clock.now_s(), Voltages::OFF).unwrap();
    }));
}

/// Never sleeps.
fn watch(rate_hz: f64, ticks: u64) {
    told(&in_time(&mut Watched(RealClock::new()), rate_hz, ticks, |_, _| ()));
}

/// A clock that is looked at all the time.
struct Watched(RealClock);

impl Clock for Watched {
    fn now_s(&mut self) -> f64 {
        self.0.now_s()
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        loop {
            let now_s = self.now_s();
            if now_s >= deadline_s {
                return now_s;
            }
        }
    }
}

/// Lateness and work of each tick that was not left out, s.
fn in_time<C: Clock>(
    clock: &mut C,
    rate_hz: f64,
    ticks: u64,
    mut work: impl FnMut(&mut C, f64),
) -> Vec<(f64, f64)> {
    Priority::raise();
    let (begin_s, mut looks) = (clock.now_s(), Vec::with_capacity(ticks as usize));
    let mut tick = 1;
    while tick <= ticks {
        let deadline_s = begin_s + tick as f64 / rate_hz;
        let woke_s = clock.wait_until(deadline_s);
        work(clock, woke_s);
        let done_s = clock.now_s();
        looks.push((woke_s - deadline_s, done_s - woke_s));
        tick = (tick + 1).max(((done_s - begin_s) * rate_hz).ceil() as u64);
    }
    looks
}

fn told(looks: &[(f64, f64)]) {
    for (late_s, took_s) in looks {
        println!("{:.1} {:.1}", late_s * 1e6, took_s * 1e6);
    }
}
