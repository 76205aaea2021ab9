//! Sessions over real serial lines that are long, or whose cable is pulled and plugged in again.

use crate::acquire::{Desk, Live};
use crate::folders::files;
use crate::rig::Remembering;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use zwidth_device::{Capabilities, Device as _, Person, Reading, Twin, TwinParameters};
use zwidth_link::{AngleAt, Board, Link, Pair, Settings, Wire as _};
use zwidth_store::{Signal, read_trial};
use zwidth_study::Study;

/// A reading as a board sent it: its clock, µs, and the angle's count.
type Sent = (i64, u16);

fn sent_as(reading: &Reading) -> Sent {
    let micros = reading.t_device_s.map_or(0, |t_s| (t_s * 1e6).round() as i64);
    (micros, reading.raw().unwrap_or_default())
}

/// A board that is plugged in, until it is dropped.
struct Plugged {
    port: PathBuf,
    sent: Arc<Mutex<Vec<Sent>>>,
    out: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Plugged {
    /// The twin behind a link, so many readings a second; what the host must be told lies in the
    /// study's folder.
    fn new(desk: &Desk, link: Link, angle: AngleAt, rate_hz: f64) -> Self {
        let text = fs::read_to_string(desk.root().join("raw/small/study.toml")).unwrap();
        let environments = Study::from_toml(&text).unwrap().environments;
        let twin = Twin::new(TwinParameters::default(), Person::draw(3), 5).unwrap();
        let capabilities = Capabilities { rate_hz, ..twin.capabilities().clone() };
        let (mut line, mut cell) = (Pair::open().unwrap(), Pair::open().unwrap());
        let settings = Settings::of_board(link, angle, rate_hz, &capabilities, cell.port());
        let settings = Settings { baud: (link == Link::Framed).then_some(1_000_000), ..settings };
        let rig = toml::to_string(&settings).unwrap();
        fs::write(desk.root().join("raw/small/rig.toml"), rig).unwrap();
        let device = Remembering { twin, capabilities, seen: Arc::default() };
        let (sent, out) = (Arc::<Mutex<Vec<Sent>>>::default(), Arc::<AtomicBool>::default());
        let (telling, pulled) = (Arc::clone(&sent), Arc::clone(&out));
        let board = Board::by(&settings, device, environments).unwrap();
        let mut board = board.telling(move |r| telling.lock().unwrap().push(sent_as(r)));
        let port = line.port().to_owned();
        let thread = thread::spawn(move || {
            let began = Instant::now();
            while !pulled.load(Ordering::Relaxed) {
                let (mut bytes, mut said) = ([0; 64], Vec::new());
                let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut said).unwrap();
                // What nobody reads is gone.
                let _ = line.send(&said);
                let _ = cell.send(&board.load_cell());
            }
        });
        Self { port, sent, out, thread: Some(thread) }
    }

    /// Calls its port so, as a system does with one that is plugged in.
    fn called(self, name: &Path) -> Self {
        let _ = fs::remove_file(name);
        symlink(&self.port, name).unwrap();
        self
    }
}

impl Drop for Plugged {
    fn drop(&mut self) {
        self.out.store(true, Ordering::Relaxed);
        // A panic of it was told.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Up to a trial that has been answered.
fn answered(live: &mut Live) {
    live.on_to("question ");
    live.say("4");
    live.until("pause ");
}

#[test]
fn a_cable_that_is_plugged_in_again_goes_on_with_the_session_after_homing() {
    let desk = Desk::slow();
    let port = desk.root().join("port");
    let plug = || Plugged::new(&desk, Link::Framed, AngleAt::I2c, 30.0).called(&port);
    let board = plug();
    let device = format!("rig:{}", port.display());
    let mut live = Live::new(&desk, &["--device", &device]);
    answered(&mut live);
    live.until("ready ");
    live.say("start");
    live.until("trial ");
    drop(board);
    fs::remove_file(&port).unwrap();
    let stopped = live.until("stopped ");
    assert!(stopped.contains("home again"), "{stopped}");
    // Homing without it is refused, and the session still goes on.
    live.say("start");
    while !live.until("stopped ").contains("plug the board in") {
        live.say("start");
    }
    let _board = plug();
    live.say("start");
    answered(&mut live);
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(3));
    desk.verify();
    let complete = |path: &PathBuf| {
        read_trial(path, Signal::all()).unwrap().meta.status == zwidth_study::Status::Complete
    };
    let trials = files(&desk.root().join("raw/small/trials"), "parquet");
    assert!(trials.iter().filter(|path| complete(path)).count() >= 2, "{trials:?}");
}

/// 36 trials in real time over a link; its loop needs `loop_hz` for all of its readings.
fn session_of_36_trials(link: Link, angle: AngleAt, rate_hz: f64, loop_hz: f64) {
    let (desk, began) = (Desk::slow(), Instant::now());
    desk.edit_study("\nrate_hz = 30.0", &format!("\nrate_hz = {loop_hz:?}"));
    desk.edit_study("\nrepeats = 1\n", "\nrepeats = 6\n");
    desk.edit_study("\nfamiliarisation = 1\n", "\nfamiliarisation = 0\n");
    // A board's twin is not told when a trial ends: its lever is carried back after the 4 s that a
    // trial may take, in at most 1.6 s. One still on its way would leap when the next trial begins.
    desk.edit_study("pause_s = 3.0", "pause_s = 5.0");
    let board = Plugged::new(&desk, link, angle, rate_hz);
    let device = format!("rig:{}", board.port.display());
    let session = || {
        let mut live = Live::new(&desk, &["--auto", "--no-watchdog", "--device", &device]);
        let ended = live.until_any(&["done 36 of 36", "left "]);
        live.child.wait().unwrap().success() && ended.starts_with("done")
    };
    while !session() {}
    desk.verify();
    let mut sent = board.sent.lock().unwrap().clone();
    if link == Link::Firmata {
        // It has no clock that tells two readings of one angle apart.
        sent.iter_mut().for_each(|(micros, _)| *micros = 0);
        sent.dedup();
    }
    let trials = files(&desk.root().join("raw/small/trials"), "parquet");
    assert!(trials.len() >= 36, "{} trials", trials.len());
    let (mut samples, mut readings, mut passed_over) = (0, 0, 0);
    for path in &trials {
        let trial = read_trial(path, Signal::all()).unwrap();
        let raw = trial.samples.get(Signal::ThetaRaw).unwrap();
        let times = trial.samples.get(Signal::DeviceTime);
        let of = |i: usize| {
            let micros = times.map_or(0, |times| (times[i] * 1e6).round() as i64);
            (micros, raw[i] as u16)
        };
        let mut own: Vec<Sent> = (0..raw.len()).map(of).collect();
        own.dedup();
        (samples, readings) = (samples + raw.len(), readings + own.len());
        if link != Link::Framed {
            let whole = sent.windows(own.len()).any(|window| window == own);
            assert!(whole, "{}: not what the board sent", path.display());
            continue;
        }
        // Of two answers that come in one look the newer counts.
        let place = |sought: &Sent| sent.iter().position(|sent| sent == sought).unwrap();
        let places: Vec<usize> = own.iter().map(place).collect();
        assert!(places.is_sorted(), "{}: out of turn", path.display());
        passed_over += places[places.len() - 1] + 1 - places[0] - places.len();
    }
    println!(
        "{link:?} {angle:?}: {} trials, {samples} samples of {readings} readings, {passed_over} passed over for newer ones, {:.0} s",
        trials.len(),
        began.elapsed().as_secs_f64()
    );
}

#[test]
#[ignore = "minutes in real time; .ci/long"]
fn a_session_of_36_trials_over_frames_at_1_khz() {
    session_of_36_trials(Link::Framed, AngleAt::I2c, 1000.0, 1000.0);
}

#[test]
#[ignore = "minutes in real time; .ci/long"]
fn a_session_of_36_trials_over_firmata_at_100_hz() {
    session_of_36_trials(Link::Firmata, AngleAt::Analog(0), 100.0, 125.0);
}

#[test]
#[ignore = "minutes in real time; .ci/long"]
fn a_session_of_36_trials_over_lines_at_400_hz() {
    session_of_36_trials(Link::Text, AngleAt::I2c, 400.0, 500.0);
}
