//! Sessions over a serial line: the program at one end, at the other a board with the twin behind
//! it, which remembers what it saw.

use crate::acquire::{Desk, Live, TRIALS};
use crate::binary::zwidth;
use crate::folders::files;
use std::fs;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use zwidth_device::{
    Capabilities, Cue, Device, DeviceError, Person, Reading, Twin, TwinParameters,
};
use zwidth_link::board::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use zwidth_link::{AngleAt, Board, Link, Pair, Settings, Wire as _};
use zwidth_store::{Signal, read_trial};
use zwidth_study::{Calibration, Study, Voltages};

/// Readings a second that the board gives: three of them may be late before safety stops a trial,
/// as in other tests in real time. Fewer would make the spring of a motor swing.
const RATE_HZ: f64 = 30.0;

/// The twin, and every reading that was asked of it.
pub(crate) struct Remembering {
    pub(crate) twin: Twin,
    pub(crate) capabilities: Capabilities,
    pub(crate) seen: Arc<Mutex<Vec<Reading>>>,
}

impl Device for Remembering {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.twin.home(now_s)
    }

    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        let reading = self.twin.read(now_s)?;
        self.seen.lock().unwrap().push(reading);
        Ok(reading)
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.twin.write(now_s, voltages)
    }

    fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
        self.twin.begin(now_s, cue);
    }
}

/// A board at the end of a line, until it is dropped or its cable is pulled.
struct OnDesk {
    port: String,
    seen: Arc<Mutex<Vec<Reading>>>,
    pulled: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnDesk {
    fn new(desk: &Desk) -> Self {
        let text = fs::read_to_string(desk.root().join("raw/small/study.toml")).unwrap();
        let environments = Study::from_toml(&text).unwrap().environments;
        let (line, seen) = (Pair::open().unwrap(), Arc::<Mutex<Vec<Reading>>>::default());
        let twin = Twin::new(TwinParameters::default(), Person::draw(3), 5).unwrap();
        let capabilities = Capabilities { rate_hz: RATE_HZ, ..twin.capabilities().clone() };
        let device = Remembering { twin, capabilities, seen: Arc::clone(&seen) };
        let mut board = Board::new(device, environments);
        let (port, pulled) = (line.port().to_string_lossy().into_owned(), Arc::default());
        let gone: Arc<AtomicBool> = Arc::clone(&pulled);
        let mut line = line;
        let run = move || {
            let began = Instant::now();
            while !gone.load(Ordering::Relaxed) {
                let (mut bytes, mut out) = ([0; 64], Vec::new());
                let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out).unwrap();
                line.send(&out).unwrap();
            }
        };
        let scale =
            format!("newtons_per_count = {NEWTONS_PER_COUNT:?}\nzero_counts = {ZERO_COUNTS:?}\n");
        fs::write(desk.root().join("raw/small/rig.toml"), scale).unwrap();
        Self { port, seen, pulled, thread: Some(thread::spawn(run)) }
    }

    fn pull(&mut self) {
        self.pulled.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

impl Drop for OnDesk {
    fn drop(&mut self) {
        self.pulled.store(true, Ordering::Relaxed);
    }
}

/// Up to the first trial.
fn ready(desk: &Desk, board: &OnDesk) -> Live {
    let mut live = Live::new(desk, &["--device", &format!("rig:{}", board.port)]);
    live.on_to("ready 1 ");
    live
}

#[test]
fn ports_asks_the_board_at_a_port_who_it_is() {
    let desk = Desk::slow();
    let board = OnDesk::new(&desk);
    let asked = zwidth(desk.root(), &["ports", &board.port]);
    let told = asked.out;
    assert_eq!(asked.code, Some(0), "{told} {}", asked.err);
    for part in [&format!("{}: board with twin", board.port), "watchdog 50 ms", "link = \"framed\""]
    {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn every_sample_of_a_trial_over_a_serial_line_is_what_the_board_saw() {
    let desk = Desk::slow();
    let board = OnDesk::new(&desk);
    let mut live = ready(&desk, &board);
    live.say("start");
    live.on_to("question ");
    live.say("4");
    live.until("pause ");
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(3));
    desk.verify();
    let trials = files(&desk.root().join("raw/small/trials"), "parquet");
    let trial = read_trial(trials.last().unwrap(), Signal::all()).unwrap();
    assert_eq!(trial.meta.source.as_str(), "twin", "a simulated board's data are simulated");
    let times = trial.samples.get(Signal::DeviceTime).unwrap();
    let forces = trial.samples.get(Signal::ForceEx).unwrap();
    let seen = board.seen.lock().unwrap();
    assert!(seen.len() > times.len());
    let micros = |s: f64| (s * 1e6).round() as i64;
    let place = |s: f64| {
        seen.iter().position(|reading| micros(reading.t_device_s.unwrap()) == micros(s)).unwrap()
    };
    assert!(times.len() > 20, "{} samples", times.len());
    let places: Vec<usize> = times.iter().map(|t_s| place(*t_s)).collect();
    for (place, force_n) in places.iter().zip(forces) {
        assert!((force_n - seen[*place].force_n).abs() <= 0.51 * NEWTONS_PER_COUNT, "{place}");
    }
    // Where an answer is late on a busy machine, the one before stands; nothing comes out of turn.
    assert!(places.is_sorted(), "{places:?}");
    assert!(places[places.len() - 1] - places[0] >= places.len() / 2, "{places:?}");
}

#[test]
fn a_check_that_asks_keeps_tare_and_known_mass_with_the_session() {
    let desk = Desk::slow();
    let board = OnDesk::new(&desk);
    let device = format!("rig:{}", board.port);
    let more = ["--ask", "--mass", "0.2", "--device", &device];
    let mut live = Live::new(&desk, &more);
    for (asked, answer) in [
        ("step Lever against its lower stop, hands off. (start", "start"),
        ("step Hang 0.2 kg from the load cell", "start"),
        ("step Lever against its lower stop. Once this begins", "skip"),
        ("step Lever against its lower stop, hands off: motor and brake", "start"),
        ("the lever will move: yes lets it", "skip"),
    ] {
        live.until(asked);
        live.say(answer);
    }
    live.on_to("ready 1 ");
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(3));
    let checks = desk.record()["checks"].clone();
    let of = |name: &str| checks.as_array().unwrap().iter().find(|c| c["name"] == name).cloned();
    assert_eq!(of("known mass").unwrap()["value"], 0.2);
    assert_eq!(of("known mass").unwrap()["unit"], "kg");
    assert!(of("tare").is_some() && of("load cell scale").is_some(), "{checks}");
    assert!(of("stroke").is_none() && of("motor responds").is_none(), "{checks}");
    desk.verify();
}

#[test]
fn a_pulled_cable_stops_the_session_and_what_was_finished_stays() {
    let desk = Desk::slow();
    let mut board = OnDesk::new(&desk);
    let mut live = ready(&desk, &board);
    live.say("start");
    live.until("trial 1 ");
    board.pull();
    let stopped = live.until("stopped ");
    assert!(stopped.contains("cable") && stopped.contains("home again"), "{stopped}");
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(1));
    desk.verify();
}

#[test]
fn a_rig_that_cannot_be_used_is_refused_before_anything_is_written() {
    let desk = Desk::slow();
    let refused = |more: &[&str], says: &[&str]| {
        let ran = desk.acquire("", more).exits(1).one_error();
        ran.says(says);
    };
    refused(&["--device", "rig:/dev/no-such-port"], &["--fast"]);
    let live = |more: &[&str], says: &str| {
        let mut live = Live::new(&desk, more);
        let status = live.child.wait().unwrap();
        let mut told = String::new();
        std::io::Read::read_to_string(live.child.stderr.as_mut().unwrap(), &mut told).unwrap();
        assert!(status.code() == Some(1) && told.contains(says), "{told}");
    };
    live(&["--device", "rig:/dev/no-such-port"], "newtons_per_count");
    fs::write(desk.root().join("raw/small/rig.toml"), "newtons_per_count = 1e-4").unwrap();
    live(&["--device", "rig:/dev/no-such-port"], "/dev/no-such-port");
    live(&["--device", "rig"], "--device rig:PORT");
    fs::write(desk.root().join("raw/small/rig.toml"), "newtons_per_count = 0.0").unwrap();
    live(&["--device", "rig"], "newtons_per_count is 0");
    assert!(!desk.root().join("raw/small/sessions").exists());
}

#[test]
fn a_rig_without_a_calibration_of_its_own_is_warned_of() {
    const WARNING: &str = "calibration.toml is missing, so the nominal calibration";
    let desk = Desk::slow();
    let board = OnDesk::new(&desk);
    let device = format!("rig:{}", board.port);
    let told = || {
        let mut live = ready(&desk, &board);
        live.say("quit");
        live.child.wait().unwrap();
        let mut told = String::new();
        std::io::Read::read_to_string(live.child.stderr.as_mut().unwrap(), &mut told).unwrap();
        told
    };
    let twin = zwidth(desk.root(), &["check", "small", "--fast"]);
    assert!(!twin.err.contains(WARNING), "{twin:?}");
    let warned = told();
    assert!(warned.contains(WARNING), "{warned}");
    zwidth(desk.root(), &["check", "small", "--device", &device]).says(&[WARNING]);
    let own = Calibration::thesis().to_toml().unwrap();
    fs::write(desk.root().join("raw/small/calibration.toml"), own).unwrap();
    let silent = told();
    assert!(!silent.contains(WARNING), "{silent}");
}

/// A board at the end of a line that speaks any link, and the counts that it sent.
struct Speaking {
    port: String,
    sent: Arc<Mutex<Vec<u16>>>,
    unplugged: Arc<AtomicBool>,
}

impl Speaking {
    /// Of a link that streams, so many readings a second: the loop needs 1.25 times as many.
    fn new(desk: &Desk, link: Link, angle: AngleAt, rate_hz: f64) -> Self {
        let text = fs::read_to_string(desk.root().join("raw/small/study.toml")).unwrap();
        let environments = Study::from_toml(&text).unwrap().environments;
        let twin = Twin::new(TwinParameters::default(), Person::draw(3), 5).unwrap();
        let capabilities = Capabilities { rate_hz: RATE_HZ, ..twin.capabilities().clone() };
        let (mut line, mut cell) = (Pair::open().unwrap(), Pair::open().unwrap());
        let mut settings = Settings::of_board(link, angle, rate_hz, &capabilities, cell.port());
        if let Some(lines) = &mut settings.text {
            // Twenty forces a second are too few for a motor: they come at a port of their own.
            lines.line = "{t_us},{counts}".to_owned();
            settings.hx711 =
                Settings::of_board(Link::Firmata, angle, rate_hz, &capabilities, cell.port()).hx711;
        }
        let rig = toml::to_string(&settings).unwrap();
        fs::write(desk.root().join("raw/small/rig.toml"), rig).unwrap();
        let (sent, unplugged) = (Arc::<Mutex<Vec<u16>>>::default(), Arc::<AtomicBool>::default());
        let (telling, gone) = (Arc::clone(&sent), Arc::clone(&unplugged));
        let device = Remembering { twin, capabilities, seen: Arc::default() };
        let board = Board::by(&settings, device, environments).unwrap();
        let mut board = board.telling(move |reading| telling.lock().unwrap().extend(reading.raw()));
        let port = line.port().to_string_lossy().into_owned();
        thread::spawn(move || {
            let began = Instant::now();
            while !gone.load(Ordering::Relaxed) {
                let (mut bytes, mut out) = ([0; 64], Vec::new());
                let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out).unwrap();
                // What nobody reads is gone: the program looks at it from homing on.
                let _ = line.send(&out);
                let _ = cell.send(&board.load_cell());
            }
        });
        Self { port, sent, unplugged }
    }
}

impl Drop for Speaking {
    fn drop(&mut self) {
        self.unplugged.store(true, Ordering::Relaxed);
    }
}

/// Every trial of a session that goes by itself, as counts without those that repeat the one
/// before, and those that the board sent.
fn session_over(link: Link, angle: AngleAt) -> (Vec<Vec<u16>>, Vec<u16>) {
    let desk = Desk::slow();
    desk.edit_study("pause_s = 3.0", "pause_s = 0.5");
    desk.edit_study("trial_limit_s = 4.0", "trial_limit_s = 2.0");
    let board = Speaking::new(&desk, link, angle, 20.0);
    let device = format!("rig:{}", board.port);
    // A machine that stands still for so long that safety stops a trial goes on as often as it
    // takes.
    let session = || {
        let mut live = Live::new(&desk, &["--auto", "--no-watchdog", "--device", &device]);
        let is_done = live.until_any(&["done 7 of 7", "left "]).starts_with("done");
        // Until it has ended the study is its own, and the next session would be refused.
        let status = live.child.wait().unwrap();
        is_done && status.success()
    };
    while !session() {}
    desk.verify();
    let trials = files(&desk.root().join("raw/small/trials"), "parquet");
    assert!(trials.len() >= TRIALS, "{} trials", trials.len());
    let counts = |path: &std::path::PathBuf| {
        let trial = read_trial(path, Signal::all()).unwrap();
        assert_eq!(trial.meta.source.as_str(), "twin", "a simulated board's data are simulated");
        let raw = trial.samples.get(Signal::ThetaRaw).unwrap();
        let mut counts: Vec<u16> = raw.iter().map(|raw| *raw as u16).collect();
        counts.dedup();
        counts
    };
    let mut sent = board.sent.lock().unwrap().clone();
    sent.dedup();
    (trials.iter().map(counts).collect(), sent)
}

/// Nothing is lost, nothing changed, nothing out of turn.
fn every_reading_of_a_session_arrives(link: Link, angle: AngleAt) {
    let (trials, sent) = session_over(link, angle);
    for trial in &trials {
        assert!(sent.windows(trial.len()).any(|window| window == trial), "{trial:?} of {sent:?}");
    }
    assert!(trials.iter().any(|trial| trial.len() > 10), "{trials:?}");
}

#[test]
fn a_session_over_firmata_with_an_analog_sensor_has_every_reading_that_was_sent() {
    every_reading_of_a_session_arrives(Link::Firmata, AngleAt::Analog(0));
}

#[test]
fn a_session_over_firmata_with_an_i2c_sensor_has_every_reading_that_was_sent() {
    every_reading_of_a_session_arrives(Link::Firmata, AngleAt::I2c);
}

#[test]
fn a_session_over_lines_of_text_has_every_reading_that_was_sent() {
    every_reading_of_a_session_arrives(Link::Text, AngleAt::I2c);
}

#[test]
fn a_session_over_frames_has_what_the_board_sent_in_its_order() {
    let (trials, sent) = session_over(Link::Framed, AngleAt::I2c);
    for trial in &trials {
        // Where an answer is late on a busy machine, the one before stands.
        let mut rest = sent.iter();
        assert!(
            trial.iter().all(|count| rest.any(|known| known == count)),
            "{trial:?} of {sent:?}"
        );
    }
    assert!(trials.iter().any(|trial| trial.len() > 10), "{trials:?}");
}
