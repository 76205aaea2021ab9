//! A rig at one end, a board with the twin at the other, and the faults between them.

mod slow;
mod streams;
mod unplugged;

use crate::board::NEWTONS_PER_COUNT;
use crate::framed::frame::Frames;
use crate::framed::message::ToBoard;
use crate::framed::patience::wire_rate_hz;
use crate::mark;
use crate::{AngleAt, Board, Link, Pair, Rig, Serial, Settings, Turning, Wire};
use std::io;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use zwidth_device::{Angle, Cue, Device, DeviceError, Person, Reading, Twin, TwinParameters};
use zwidth_study::{Environment, Moment, Study, Voltages};

fn settings() -> Settings {
    let (cell, can) = ("/dev/cell".as_ref(), twin().capabilities().clone());
    Settings::of_board(Link::Framed, AngleAt::I2c, 100.0, &can, cell)
}

fn study() -> Study {
    zwidth_testing::study()
}

fn environments() -> Vec<Environment> {
    study().environments
}

fn twin() -> Twin {
    Twin::new(TwinParameters::default(), Person::draw(7), 11).unwrap()
}

/// A wire without any length: what is sent is answered at once, at the time that the test sets.
#[derive(Clone)]
struct Near(Arc<Inside>);

struct Inside {
    board: Mutex<Board>,
    come: Mutex<Vec<u8>>,
    now: AtomicU64,
    /// Nothing comes through any more.
    cut: AtomicBool,
    /// What the host sent.
    sent: Mutex<Vec<u8>>,
    /// This byte of what the board says is spoilt next.
    spoil: AtomicBool,
}

impl Near {
    fn new() -> Self {
        Self(Arc::new(Inside {
            board: Mutex::new(Board::new(twin(), environments())),
            come: Mutex::default(),
            now: AtomicU64::default(),
            cut: AtomicBool::default(),
            sent: Mutex::default(),
            spoil: AtomicBool::default(),
        }))
    }

    fn at(&self, now_s: f64) {
        self.0.now.store(now_s.to_bits(), Ordering::Relaxed);
        let mut out = Vec::new();
        self.board(|board, now_s| board.take(now_s, &[], &mut out)).unwrap();
        self.0.come.lock().unwrap().extend(out);
    }

    fn board<T>(&self, ask: impl FnOnce(&mut Board, f64) -> T) -> T {
        let now_s = f64::from_bits(self.0.now.load(Ordering::Relaxed));
        ask(&mut self.0.board.lock().unwrap(), now_s)
    }
}

impl Wire for Near {
    fn receive(&mut self, into: &mut [u8], _wait: Duration) -> io::Result<usize> {
        let mut come = self.0.come.lock().unwrap();
        let n = into.len().min(come.len());
        into[..n].copy_from_slice(&come[..n]);
        come.drain(..n);
        Ok(n)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.0.cut.load(Ordering::Relaxed) {
            return Ok(());
        }
        self.0.sent.lock().unwrap().extend(bytes);
        let mut out = Vec::new();
        self.board(|board, now_s| board.take(now_s, bytes, &mut out)).unwrap();
        if !out.is_empty() && self.0.spoil.swap(false, Ordering::Relaxed) {
            out[3] ^= 1;
        }
        self.0.come.lock().unwrap().extend(out);
        Ok(())
    }
}

fn connect(wire: &Near) -> Rig<Near> {
    let ids = environments().into_iter().map(|environment| environment.id).collect();
    Rig::connect(wire.clone(), settings(), ids).unwrap()
}

fn counts(reading: &Reading) -> u16 {
    reading.raw().unwrap()
}

#[test]
fn a_moment_of_a_trial_is_told_by_its_number() {
    let wire = Near::new();
    let mut rig = connect(&wire);
    assert!(rig.capabilities().shows_moments);
    wire.0.sent.lock().unwrap().clear();
    Moment::ALL.into_iter().for_each(|moment| rig.mark(moment));
    let (sent, mut frames) = (wire.0.sent.lock().unwrap().clone(), Frames::default());
    let frames = sent.into_iter().filter_map(|byte| frames.push(byte));
    let told: Vec<ToBoard> = frames.filter_map(|frame| ToBoard::read(&frame)).collect();
    let mark = |number| ToBoard::Mark { code: mark::MOMENT, number };
    assert_eq!(told, [1, 2, 3, 4].map(mark));
    assert_eq!([1, 2, 3, 4].map(mark::moment), Moment::ALL.map(Some));
    assert_eq!([0, 5, u16::MAX].map(mark::moment), [None; 3]);
}

#[test]
fn a_rig_says_of_itself_what_its_board_said() {
    let rig = connect(&Near::new());
    let (rig, twin) = (rig.capabilities().clone(), twin().capabilities().clone());
    assert_eq!((rig.counts_per_turn, rig.watchdog_s), (twin.counts_per_turn, twin.watchdog_s));
    assert_eq!((rig.motor_max_v, rig.brake_max_v), (twin.motor_max_v, twin.brake_max_v));
    assert_eq!(
        (rig.rate_hz, rig.force_rate_hz, rig.source),
        (twin.rate_hz, twin.force_rate_hz, twin.source)
    );
    assert!(rig.name.contains(&twin.name), "{}", rig.name);
}

#[test]
fn a_slow_line_carries_fewer_ticks() {
    // An answer is 31 bytes on the wire, of ten bits each.
    assert!((wire_rate_hz(115_200) - 115_200.0 / 310.0).abs() < 1e-9);
    let slow = Settings { baud: Some(57_600), ..settings() };
    let rig = Rig::connect(Near::new(), slow, Vec::new()).unwrap();
    assert!((rig.capabilities().rate_hz - 57_600.0 / 310.0).abs() < 1e-9);
}

/// Drives a device through a trial of one environment as a loop would; what it saw.
fn drive(
    device: &mut dyn Device,
    environment: &Environment,
    at: &dyn Fn(f64),
) -> Vec<(Reading, Voltages)> {
    at(0.0);
    device.write(0.0, Voltages::OFF).unwrap();
    device.home(0.0).unwrap();
    let begin_s = 1.0;
    at(begin_s);
    device.begin(begin_s, &Cue { trial: 3, environment, limit_s: 4.0 });
    (0..4000)
        .map(|tick| {
            let now_s = begin_s + 0.001 * f64::from(tick);
            at(now_s);
            let reading = device.read(now_s).unwrap();
            // Some command that is a whole number of steps of the wire.
            let step = f64::from(tick % 7) * 100.0 / f64::from(i16::MAX);
            let can = device.capabilities();
            let voltages =
                Voltages { motor_v: -step * can.motor_max_v, brake_v: step * can.brake_max_v };
            device.write(now_s, voltages).unwrap();
            (reading, voltages)
        })
        .collect()
}

#[test]
fn a_trial_over_the_wire_is_the_twins_own_sample_by_sample() {
    let environment = &environments()[0];
    let mut own = twin();
    let direct = drive(&mut own, environment, &|_| {});
    let wire = Near::new();
    let mut rig = connect(&wire);
    let over = drive(&mut rig, environment, &|now_s| wire.at(now_s));
    assert_eq!((over.len(), rig.faults()), (direct.len(), [0, 0]));
    let mut moved = false;
    for (i, ((far, _), (near, _))) in over.iter().zip(&direct).enumerate() {
        assert_eq!(far.angle, near.angle, "tick {i}");
        assert!((far.force_n - near.force_n).abs() <= 0.51 * NEWTONS_PER_COUNT, "tick {i}");
        let (far_s, near_s) = (far.t_device_s.unwrap(), near.t_device_s.unwrap());
        assert!((far_s - near_s).abs() < 1e-6, "tick {i}: {far_s} {near_s}");
        assert!((far.angle_age_s - near.angle_age_s).abs() < 1e-6, "tick {i}");
        assert!((far.force_age_s.unwrap() - near.force_age_s.unwrap()).abs() < 1e-6, "tick {i}");
        moved |= counts(near) != counts(&direct[0].0);
    }
    assert!(moved, "the participant did not move");
}

/// Homed, and read at 1 kHz up to 2 s.
fn running() -> (Near, Rig<Near>) {
    let wire = Near::new();
    let mut rig = connect(&wire);
    wire.at(1.0);
    rig.home(1.0).unwrap();
    for tick in 0..1000 {
        let now_s = 1.0 + 0.001 * f64::from(tick);
        wire.at(now_s);
        rig.read(now_s).unwrap();
        rig.write(now_s, Voltages { motor_v: 1.0, brake_v: 0.0 }).unwrap();
    }
    (wire, rig)
}

#[test]
fn an_answer_that_does_not_come_leaves_the_one_before_with_its_age() {
    let (wire, mut rig) = running();
    wire.at(2.0);
    let before = rig.read(2.0).unwrap();
    wire.0.cut.store(true, Ordering::Relaxed);
    for tick in 1..=60 {
        let now_s = 2.0 + 0.001 * f64::from(tick);
        let reading = rig.read(now_s).unwrap();
        assert_eq!((reading.angle, reading.force_n), (before.angle, before.force_n));
        let grown_s = reading.angle_age_s - before.angle_age_s;
        assert!((grown_s - 0.001 * f64::from(tick)).abs() < 1e-9, "{grown_s}");
    }
    assert_eq!(rig.faults(), [60, 0]);
}

#[test]
fn without_a_write_for_its_time_the_board_takes_the_voltages_away_and_the_rig_says_so() {
    let (wire, mut rig) = running();
    assert!(wire.board(|board, _| board.drive().motor) > 0);
    let watchdog_s = rig.capabilities().watchdog_s.unwrap();
    wire.at(2.0 + watchdog_s + 0.002);
    assert_eq!(wire.board(|board, _| board.drive().motor), 0);
    let error = rig.read(2.0 + watchdog_s + 0.002).unwrap_err();
    assert!(error.to_string().contains("watchdog"), "{error}");
}

#[test]
fn a_spoilt_answer_is_dropped_and_counted_and_the_next_one_is_right() {
    let (wire, mut rig) = running();
    wire.at(2.0);
    wire.0.spoil.store(true, Ordering::Relaxed);
    assert!(rig.read(2.0).unwrap().angle_age_s > 0.0);
    assert_eq!(rig.faults(), [1, 1]);
    wire.at(2.001);
    assert!(rig.read(2.001).unwrap().angle_age_s < 1e-6);
}

#[test]
fn a_board_that_says_who_it_is_because_it_was_asked_has_not_begun_anew() {
    let (wire, mut rig) = running();
    wire.at(2.0);
    let mut told = Vec::new();
    let (hello, length) = ToBoard::Hello.frame(1).encode();
    wire.board(|board, now_s| board.take(now_s, &hello[..length], &mut told)).unwrap();
    assert!(!told.is_empty());
    wire.0.come.lock().unwrap().extend(told);
    assert!(rig.read(2.0).unwrap().angle_age_s < 1e-6);
}

#[test]
fn a_board_that_begins_anew_is_lost_until_it_is_homed() {
    let (wire, mut rig) = running();
    wire.board(|board, now_s| board.reset(now_s)).unwrap();
    wire.at(2.0);
    let error = rig.read(2.0).unwrap_err();
    assert!(error.to_string().contains("begun anew"), "{error}");
    assert!(error.to_string().contains("home again"), "{error}");
    rig.home(2.0).unwrap();
    wire.at(2.5);
    rig.read(2.5).unwrap();
}

#[test]
fn a_board_that_begins_when_its_port_is_opened_says_twice_who_it_is_and_can_be_homed() {
    let wire = Near::new();
    wire.board(|board, now_s| board.reset(now_s)).unwrap();
    let mut rig = connect(&wire);
    rig.home(0.0).unwrap();
    rig.read(0.5).unwrap();
}

#[test]
fn homing_again_where_the_stop_is_not_is_refused() {
    let (wire, mut rig) = running();
    // The twin's board brings its lever to the stop; a rig whose memory has another stop refuses
    // it.
    wire.at(3.0);
    rig.write(3.0, Voltages::OFF).unwrap();
    let stop = counts(&rig.home(3.0).unwrap());
    rig.forget_stop(stop.wrapping_add(400) % 4096);
    let error = rig.home(3.1).unwrap_err();
    assert!(error.to_string().contains("not where its stop was before"), "{error}");
}

#[test]
fn a_board_that_counts_down_is_turned_round() {
    let down = Settings { turning: Turning::Down, ..settings() };
    let (wire, again) = (Near::new(), Near::new());
    let (mut up, mut down) =
        (connect(&wire), Rig::connect(again.clone(), down, Vec::new()).unwrap());
    let (a, b) = (counts(&up.home(0.0).unwrap()), counts(&down.home(0.0).unwrap()));
    assert_eq!((a + b) % 4096, 0);
}

#[test]
fn settings_and_boards_that_make_no_sense_are_refused() {
    let bad = [
        (Settings { newtons_per_count: 0.0, ..settings() }, "newtons_per_count"),
        (Settings { zero_counts: f64::NAN, ..settings() }, "zero_counts"),
        (Settings { shaft_per_lever: -1.0, ..settings() }, "shaft_per_lever"),
        (Settings { baud: Some(0), ..settings() }, "baud"),
    ];
    for (settings, name) in bad {
        let error = Rig::connect(Near::new(), settings, Vec::new()).err().unwrap();
        assert!(error.to_string().contains(name), "{error}");
    }
    let read: Settings = toml::from_str("newtons_per_count = 2e-5").unwrap();
    assert_eq!((read.baud(), read.turning), (500_000, Turning::Up));
    assert!(toml::from_str::<Settings>("newtons_per_count = 2e-5\nbuad = 3").is_err());
}

#[test]
fn over_a_real_line_every_question_has_its_answer() {
    let mut line = Pair::open().unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let port = line.port().to_owned();
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let (began, mut board) = (Instant::now(), Board::new(twin(), environments()));
            while !stop.load(Ordering::Relaxed) {
                let mut bytes = [0; 64];
                let came = line.receive(&mut bytes, Duration::from_millis(1)).unwrap();
                let mut out = Vec::new();
                board.take(began.elapsed().as_secs_f64(), &bytes[..came], &mut out).unwrap();
                line.send(&out).unwrap();
            }
        });
        let wire = Serial::open(&port, 500_000).unwrap();
        let mut rig = Rig::connect(wire, settings(), Vec::new()).unwrap();
        let began = Instant::now();
        rig.home(began.elapsed().as_secs_f64()).unwrap();
        let readings: Vec<Reading> =
            (0..200).map(|_| rig.read(began.elapsed().as_secs_f64()).unwrap()).collect();
        stop.store(true, Ordering::Relaxed);
        assert!(readings.iter().all(|reading| matches!(reading.angle, Angle::Counts(_))));
        let times = readings.iter().filter_map(|reading| reading.t_device_s);
        assert!(times.clone().zip(times.skip(1)).all(|(before, after)| after >= before));
        assert_eq!(rig.faults()[1], 0);
    });
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let error = Serial::open("/dev/no-such-port".as_ref(), 500_000).err().unwrap();
    assert!(matches!(error, DeviceError::Unable { .. }));
    let text = error.to_string();
    assert!(text.contains("/dev/no-such-port") && text.contains("--device rig:PORT"), "{text}");
}
