//! A rig that is characterised over a serial line: the program at one end, at the other a board with
//! the simulated rig behind it, and at the bench hands that do what the program asks for.

use crate::acquire::{Desk, ended_after_all};
use crate::binary::binary;
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::fd::AsFd as _;
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use zwidth_device::{Device as _, Faults, Fixture, Hands, HandsHandle, TwinParameters};
use zwidth_link::board::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use zwidth_link::{Board, Drive, Pair, Wire as _};
use zwidth_store::{Layout, read_sweep};
use zwidth_study::{CalibrationFile, Study};

/// What waits for longer than this waits for ever.
const FOR_EVER: Duration = Duration::from_secs(300);

/// A board with the simulated rig at the end of a line, until it is dropped.
struct OnBench {
    port: String,
    hands: HandsHandle,
    drive: Arc<Mutex<Drive>>,
    gone: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl OnBench {
    fn new(desk: &Desk) -> Self {
        let text = fs::read_to_string(desk.root().join("raw/small/study.toml")).unwrap();
        let environments = Study::from_toml(&text).unwrap().environments;
        let (fixture, hands) =
            Fixture::new(TwinParameters::default(), Faults::default(), 5).unwrap();
        assert!(fixture.capabilities().watchdog_s.is_some());
        let mut board = Board::new(fixture, environments);
        let mut line = Pair::open().unwrap();
        let port = line.port().to_string_lossy().into_owned();
        let (drive, gone) = (Arc::new(Mutex::new(Drive::default())), Arc::<AtomicBool>::default());
        let (seen, stop) = (Arc::clone(&drive), Arc::clone(&gone));
        let thread = thread::spawn(move || {
            let began = Instant::now();
            while !stop.load(Ordering::Relaxed) {
                let (mut bytes, mut out) = ([0; 64], Vec::new());
                let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out).unwrap();
                line.send(&out).unwrap();
                *seen.lock().unwrap() = board.drive();
            }
        });
        let rig = format!(
            "newtons_per_count = {NEWTONS_PER_COUNT:?}\nzero_counts = {ZERO_COUNTS:?}\n[heat]\ncooling_s = 1e-3\n"
        );
        fs::write(desk.root().join("raw/small/rig.toml"), rig).unwrap();
        Self { port, hands, drive, gone, thread: Some(thread) }
    }

    fn is_on(&self) -> bool {
        *self.drive.lock().unwrap() != Drive::default()
    }

    /// Waits until a voltage is on, or off.
    fn until_on(&self, on: bool) {
        let began = Instant::now();
        while self.is_on() != on {
            assert!(
                began.elapsed() < FOR_EVER,
                "a voltage stays {}",
                if on { "off" } else { "on" }
            );
            thread::yield_now();
        }
    }
}

impl Drop for OnBench {
    fn drop(&mut self) {
        self.gone.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // Its panic is told already.
            let _ = thread.join();
        }
    }
}

/// The program, its questions, and the hands that answer them.
struct Characterising<'a> {
    bench: &'a OnBench,
    child: Child,
    told: BufReader<ChildStderr>,
    all: String,
    _waiting: Sender<()>,
}

impl<'a> Characterising<'a> {
    fn new(desk: &Desk, bench: &'a OnBench, more: &str) -> Self {
        let mut command = Command::new(binary());
        command.arg("--root").arg(desk.root()).args(["characterise", "small"]);
        command.args(more.split(' ')).args(["--device", &format!("rig:{}", bench.port)]);
        command.args(["--mass", "0.1", "--mass", "0.2"]).env_remove("ZWIDTH_ROOT");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let told = BufReader::new(child.stderr.take().unwrap());
        let _waiting = ended_after_all(child.id());
        Self { bench, child, told, all: String::new(), _waiting }
    }

    fn say(&mut self, text: &str) {
        writeln!(self.child.stdin.as_mut().unwrap(), "{text}").unwrap();
    }

    /// Does what it asks for up to a line that has one of these words, which is not answered;
    /// whether there was one before the program's end.
    fn until(&mut self, word: &str) -> bool {
        loop {
            let mut line = String::new();
            if self.told.read_line(&mut line).unwrap() == 0 {
                return false;
            }
            self.all.push_str(&line);
            if line.contains(word) {
                return true;
            }
            let hands = [
                ("Hold the lever", Hands::Back),
                ("Let nothing touch", Hands::Away),
                ("Hang 0.1", Hands::Hang(0.1)),
                ("Hang 0.2", Hands::Hang(0.2)),
                ("Move the lever", Hands::Clamp(0.0)),
                ("Bring the lever", Hands::Back),
                ("Carry the lever", Hands::Clamp(0.0)),
                ("Take your hands off the lever: it moves", Hands::Away),
                ("the brake goes", Hands::Push),
                ("the motor goes to", Hands::Clamp(0.0)),
                ("Mend it", Hands::Away),
            ];
            if let Some((_, hands)) = hands.iter().find(|(asked, _)| line.contains(asked)) {
                self.bench.hands.set(*hands);
                self.say("");
            }
        }
    }

    /// How it ends.
    fn end(&mut self) -> Option<i32> {
        self.child.wait().unwrap().code()
    }
}

fn sweeps(desk: &Desk, actuator: &str) -> usize {
    let layout = Layout::new(desk.root(), "small".parse().unwrap());
    let id = actuator.parse().unwrap();
    let paths = (1..).map(|number| layout.sweep(&id, number)).take_while(|path| path.exists());
    // Each of them reads.
    paths.inspect(|path| _ = read_sweep(path).unwrap()).count()
}

#[test]
fn a_brake_is_swept_at_a_rig_and_a_kill_under_voltage_loses_nothing_and_leaves_0_v() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let more = "brake --sweeps 2 --to 8 --seconds 4";
    let mut killed = Characterising::new(&desk, &bench, more);
    assert!(killed.until("Sweep 2 of 2"), "{}", killed.all);
    bench.hands.set(Hands::Push);
    killed.say("");
    bench.until_on(true);
    killed.child.kill().unwrap();
    killed.end();
    // By the board's own watchdog.
    bench.until_on(false);
    assert_eq!(sweeps(&desk, "brake"), 1);
    let mut again = Characterising::new(&desk, &bench, more);
    assert!(!again.until("no such words"));
    assert_eq!(again.end(), Some(0), "{}", again.all);
    assert!(again.all.contains("1 sweeps of the brake are there"), "{}", again.all);
    assert!(again.all.contains("sweep the motor too"), "{}", again.all);
    // On a machine that stood still meanwhile two may not agree, and a third decides.
    assert!(sweeps(&desk, "brake") >= 2 && !bench.is_on());
    crate::binary::zwidth(desk.root(), &["verify", "small"]).exits(0);
}

#[test]
fn a_motor_that_nobody_watches_goes_to_0_v_and_its_sweep_is_not_kept() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let mut alone = Characterising::new(&desk, &bench, "motor --sweeps 1 --seconds 8");
    // One press of Enter begins it, and nobody holds the key down.
    assert!(alone.until("nobody held Enter"), "{}", alone.all);
    bench.until_on(false);
    alone.say("q");
    assert_eq!(alone.end(), Some(3), "{}", alone.all);
    assert_eq!(sweeps(&desk, "motor"), 0);
}

#[test]
fn walls_that_nobody_watches_go_to_0_v_and_their_search_is_not_kept() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let mut alone = Characterising::new(&desk, &bench, "impedance --sweeps 1");
    assert!(alone.until("nobody held Enter"), "{}", alone.all);
    assert!(alone.all.contains("Search 1 of 16: active with B = 0 N s/m"), "{}", alone.all);
    bench.until_on(false);
    alone.say("q");
    assert_eq!(alone.end(), Some(3), "{}", alone.all);
    assert_eq!(sweeps(&desk, "impedance"), 0);
}

#[test]
#[ignore = "a search takes more than a minute"]
fn a_search_of_walls_is_kept_and_the_next_life_goes_on_behind_it() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let mut held = Characterising::new(&desk, &bench, "impedance --sweeps 1");
    assert!(held.until("Search 1 of 16"), "{}", held.all);
    // Hands off, and Enter is held down until the search has ended.
    bench.hands.set(Hands::Away);
    let keys = held.child.stdin.as_ref().unwrap().as_fd().try_clone_to_owned().unwrap();
    let mut keys = fs::File::from(keys);
    // A held key repeats ten times a second, until it is let go of.
    let (let_go, held_down) = channel::<()>();
    let holding = thread::spawn(move || {
        let waits = Duration::from_millis(100);
        while held_down.recv_timeout(waits) == Err(RecvTimeoutError::Timeout) {
            writeln!(keys).unwrap();
        }
    });
    assert!(held.until("kept: the stiffest wall"), "{}", held.all);
    drop(let_go);
    holding.join().unwrap();
    // Each line of the held key answers a question where there is no terminal: nobody waits for all of them.
    held.child.kill().unwrap();
    held.end();
    bench.until_on(false);
    assert_eq!(sweeps(&desk, "impedance"), 1, "{}", held.all);
    crate::binary::zwidth(desk.root(), &["verify", "small"]).exits(0);
    // What was searched is not searched again, however many repeats there are to be now.
    let mut again = Characterising::new(&desk, &bench, "impedance --sweeps 2");
    assert!(again.until("Search 2 of 32: active with B = 0 N s/m"), "{}", again.all);
    assert!(again.all.contains("1 of 32 searches are there"), "{}", again.all);
    again.say("q");
    assert_eq!(again.end(), Some(3), "{}", again.all);
    assert!(desk.root().join("reports/small/impedance/impedance.svg").exists());
}

#[test]
fn what_a_rig_needs_for_it_is_asked_for_before_anything_is_on() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let device = format!("rig:{}", bench.port);
    let refused = |more: &[&str], word: &str| {
        let words = [&["characterise", "small", "motor", "--device", &device], more].concat();
        crate::binary::zwidth(desk.root(), &words).exits(1).says(&[word]);
    };
    refused(&["--mass", "0.1"], "two known masses");
    let masses = ["--mass", "0.1", "--mass", "0.2"];
    refused(&[&masses[..], &["--to", "30"]].concat(), "at most 16 V");
    refused(&[&masses[..], &["--seconds", "60"]].concat(), "would warm the winding");
    assert!(!bench.is_on());
}

#[test]
fn a_calibration_of_another_rig_or_of_long_ago_is_warned_of() {
    let desk = Desk::slow();
    let bench = OnBench::new(&desk);
    let device = format!("rig:{}", bench.port);
    let told = |utc: &str, made_with: &str| {
        let text = zwidth_study::Calibration::thesis().to_toml().unwrap();
        let interval = "sweeps = 1\nlow_n = [0.0, 1.0]\nhigh_n = [0.0, 2.0]\n";
        let text = format!(
            "{text}\n[origin]\nutc = \"{utc}\"\ndevice = \"{made_with}\"\nlevel = 0.95\n[origin.motor]\n{interval}[origin.brake]\n{interval}"
        );
        assert!(CalibrationFile::from_toml(&text).is_ok());
        fs::write(desk.root().join("raw/small/calibration.toml"), text).unwrap();
        crate::binary::zwidth(desk.root(), &["check", "small", "--device", &device]).err
    };
    let today = told("9000-01-01T00:00:00Z", "board with twin fixture 1");
    assert!(!today.contains("calibration.toml"), "{today}");
    let other = told("9000-01-01T00:00:00Z", "board with something else");
    assert!(other.contains("was made with board with something else"), "{other}");
    let old = told("2020-01-01T00:00:00Z", "board with twin fixture 1");
    assert!(old.contains("days old") && old.contains("allows 90 days"), "{old}");
}
