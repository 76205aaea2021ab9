//! Our end of `benches/rig`: `rig-bench board` is a board with the twin behind it at a
//! pseudo-terminal, which prints its port; `rig-bench loop PORT RATE TICKS` is the loop of a
//! session on it, and prints when each tick began after its deadline and how long its answer and
//! command took, µs, a tick in a line.
#![allow(clippy::print_stdout, clippy::unwrap_used)] // a program of one page that tells what it measured

use std::path::Path;
use std::time::{Duration, Instant};
use zwidth_device::{Clock as _, Person, Priority, RealClock, Twin, TwinParameters};
use zwidth_link::{Board, Pair, Serial, Settings, Wire as _, over};
use zwidth_study::Voltages;

/// Each answer comes in its own tick at 1 kHz.
const RIG: &str = "newtons_per_count = 1e-4\nbaud = 1000000";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["board"] => board(),
        ["loop", port, rate_hz, ticks] => {
            tick(Path::new(port), rate_hz.parse().unwrap(), ticks.parse().unwrap());
        }
        _ => println!("rig-bench board | loop PORT RATE TICKS"),
    }
}

/// Until it is stopped.
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

fn tick(port: &Path, rate_hz: f64, ticks: u64) {
    let settings: Settings = toml::from_str(RIG).unwrap();
    let wire = Serial::open(port, settings.baud()).unwrap();
    let mut rig = over(wire, None, &settings, Vec::new()).unwrap();
    let mut clock = RealClock::new();
    rig.home(clock.now_s()).unwrap();
    Priority::raise();
    let (begin_s, mut looks) = (clock.now_s(), Vec::with_capacity(ticks as usize));
    let mut tick = 1;
    while tick <= ticks {
        let deadline_s = begin_s + tick as f64 / rate_hz;
        let woke_s = clock.wait_until(deadline_s);
        rig.read(woke_s).unwrap();
        rig.write(clock.now_s(), Voltages::OFF).unwrap();
        let done_s = clock.now_s();
        looks.push((woke_s - deadline_s, done_s - woke_s));
        tick = (tick + 1).max(((done_s - begin_s) * rate_hz).ceil() as u64);
    }
    for (late_s, took_s) in looks {
        println!("{:.1} {:.1}", late_s * 1e6, took_s * 1e6);
    }
}
