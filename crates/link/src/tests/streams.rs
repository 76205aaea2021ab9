//! Boards that send readings unasked: the host at one end, the twin's board at the other.

use super::{environments, twin};
use crate::Drive;
use crate::board::NEWTONS_PER_COUNT;
use crate::stream::{Cell, Stream};
use crate::{AngleAt, Board, Firmata, Link, Settings, Wire};
use proptest::prelude::*;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;
use zwidth_device::{Cue, Device, DeviceError, Reading};
use zwidth_study::Voltages;

/// One step of the time between the two ends, s.
const STEP_S: f64 = 1e-3;

fn firmata(angle: AngleAt) -> Settings {
    Settings::of_board(Link::Firmata, angle, 100.0, twin().capabilities(), "/dev/cell".as_ref())
}

fn text(line: &str) -> Settings {
    let angle = AngleAt::I2c;
    let cell = "/dev/cell".as_ref();
    let mut settings = Settings::of_board(Link::Text, angle, 200.0, twin().capabilities(), cell);
    let sketch = settings.text.as_mut().unwrap();
    (sketch.line, sketch.pwm_full) = (line.to_owned(), 1000);
    settings
}

fn every() -> [Settings; 4] {
    let with_cell = Settings { hx711: firmata(AngleAt::I2c).hx711, ..text("{counts}") };
    let lines = text("{t_us},{counts},{hx711}");
    [firmata(AngleAt::Analog(0)), firmata(AngleAt::I2c), lines, with_cell]
}

/// Both ends, and the time between them.
struct Between {
    board: Board,
    now_s: f64,
    come: Vec<u8>,
    weighed: Vec<u8>,
}

impl Between {
    fn step(&mut self, bytes: &[u8]) {
        self.board.take(self.now_s, bytes, &mut self.come).unwrap();
        self.weighed.extend(self.board.load_cell());
    }
}

/// One end of a line without any length; of the board or of its load cell.
#[derive(Clone)]
struct Line(Arc<Mutex<Between>>, bool);

impl Line {
    fn at(&self, now_s: f64) {
        let mut between = self.0.lock().unwrap();
        while between.now_s < now_s {
            between.now_s = (between.now_s + STEP_S).min(now_s);
            between.step(&[]);
        }
    }

    fn now_s(&self) -> f64 {
        self.0.lock().unwrap().now_s
    }

    fn drive(&self) -> Drive {
        self.0.lock().unwrap().board.drive()
    }
}

impl Wire for Line {
    /// Time goes by for a wait alone.
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let mut between = self.0.lock().unwrap();
        let until_s = between.now_s + wait.as_secs_f64();
        while between.come.is_empty() && between.now_s < until_s {
            between.now_s += STEP_S;
            between.step(&[]);
        }
        let come = if self.1 { &mut between.weighed } else { &mut between.come };
        let n = into.len().min(come.len());
        into[..n].copy_from_slice(&come[..n]);
        come.drain(..n);
        Ok(n)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.lock().unwrap().step(bytes);
        Ok(())
    }
}

fn made(settings: &Settings, seen: &Arc<Mutex<Vec<Reading>>>) -> Board {
    let seen = Arc::clone(seen);
    let board = Board::by(settings, twin(), environments()).unwrap();
    board.telling(move |reading| seen.lock().unwrap().push(*reading))
}

type Connected = (Line, Stream<Line>, Arc<Mutex<Vec<Reading>>>);

fn try_connect(board_has: &Settings, host_has: &Settings) -> Result<Connected, DeviceError> {
    let seen = Arc::default();
    let between = Between {
        board: made(board_has, &seen),
        now_s: 0.0,
        come: Vec::new(),
        weighed: Vec::new(),
    };
    let line = Line(Arc::new(Mutex::new(between)), false);
    host_has.check()?;
    let talk = host_has.host()?.expect("a link that streams");
    let cell = host_has.hx711.as_ref();
    let cell = cell.map(|cell| Cell::new(Line(Arc::clone(&line.0), true), cell)).transpose()?;
    let ids = environments().into_iter().map(|environment| environment.id).collect();
    let stream = Stream::connect(line.clone(), cell, talk, host_has.clone(), ids)?;
    Ok((line, stream, seen))
}

fn connect(settings: &Settings) -> Connected {
    try_connect(settings, settings).unwrap()
}

#[test]
fn a_trial_over_each_link_is_every_reading_that_the_board_sent() {
    for settings in every() {
        let (line, mut rig, seen) = connect(&settings);
        let can = rig.capabilities().clone();
        rig.home(line.now_s()).unwrap();
        // Homing takes real time, of which this line knows nothing: what came then is left behind.
        line.at(line.now_s() + 1.0);
        rig.read(line.now_s()).unwrap();
        let begin_s = line.now_s();
        rig.begin(begin_s, &Cue { trial: 1, environment: &environments()[0], limit_s: 4.0 });
        seen.lock().unwrap().clear();
        let mut fresh = Vec::new();
        for tick in 0_u32..500 {
            let now_s = begin_s + f64::from(tick + 1) / can.rate_hz;
            line.at(now_s);
            let reading = rig.read(now_s).unwrap();
            if reading.angle_age_s == 0.0 {
                fresh.push(reading);
            }
            let share = f64::from(tick % 7) / 20.0;
            let voltages = Voltages { motor_v: -share * can.motor_max_v, brake_v: 0.0 };
            rig.write(now_s, voltages).unwrap();
        }
        let seen = seen.lock().unwrap();
        assert_eq!(fresh.len(), seen.len(), "{settings:?}");
        assert!(seen.len() > 395 && rig.damaged() == 0, "{} readings", seen.len());
        for (i, (ours, theirs)) in fresh.iter().zip(seen.iter()).enumerate() {
            assert_eq!(ours.angle, theirs.angle, "{i}");
            // At a port of its own the force is told by itself: one of the angle's neighbours had
            // it.
            let by = if settings.hx711.is_some() { 2 } else { 0 };
            let differs_n = |known: &Reading| (ours.force_n - known.force_n).abs();
            let near = &seen[i.saturating_sub(by)..(i + by + 1).min(seen.len())];
            let same = |known| differs_n(known) <= 0.51 * NEWTONS_PER_COUNT;
            assert!(i < by || near.iter().any(same), "{i}: {} N", differs_n(&seen[i]));
        }
        assert!(seen.iter().any(|reading| reading.angle != seen[0].angle), "it did not move");
        assert_eq!(can.source, zwidth_study::Source::Twin);
    }
}

#[test]
fn what_is_commanded_goes_out_in_the_boards_own_steps_and_never_above() {
    for settings in every() {
        let (line, mut rig, _) = connect(&settings);
        let (can, full) = (rig.capabilities().clone(), f64::from(i16::MAX));
        for share in [0.0, 0.3, -0.3, 1.0, -1.0, 0.0041, 0.002] {
            let (motor_v, brake_v) = (share * can.motor_max_v, share * can.brake_max_v);
            rig.write(line.now_s(), Voltages { motor_v, brake_v }).unwrap();
            let Drive { motor, brake } = line.drive();
            let steps = settings.text.as_ref().map_or(255.0, |text| text.pwm_full.into());
            for (out, asked) in [(motor, share), (brake, share.max(0.0))] {
                let out = f64::from(out) / full;
                let below = asked.abs() - out.abs();
                assert!((-2.0 / full..1.0 / steps + 2.0 / full).contains(&below), "{asked}: {out}");
                assert!(out * asked >= 0.0, "{asked}: {out}");
            }
        }
    }
}

#[test]
fn readings_that_piled_up_come_one_after_another_with_their_ages() {
    let settings = text("{t_us},{counts},{hx711}");
    let (line, mut rig, seen) = connect(&settings);
    rig.home(line.now_s()).unwrap();
    let mut now_s = line.now_s();
    rig.read(now_s).unwrap();
    seen.lock().unwrap().clear();
    // The loop stands still for ten readings.
    now_s += 0.0501;
    line.at(now_s);
    let first = rig.read(now_s).unwrap();
    assert!((0.039..0.046).contains(&first.angle_age_s), "{}", first.angle_age_s);
    let mut times = vec![first.t_device_s.unwrap()];
    for _ in 0..60 {
        now_s += 1.0 / rig.capabilities().rate_hz;
        line.at(now_s);
        times.push(rig.read(now_s).unwrap().t_device_s.unwrap());
    }
    times.dedup();
    let micros = |s: f64| (s * 1e6).round();
    let seen = seen.lock().unwrap();
    let sent: Vec<f64> = seen.iter().map(|reading| micros(reading.t_device_s.unwrap())).collect();
    assert_eq!(times.into_iter().map(micros).collect::<Vec<_>>(), sent);
}

#[test]
fn what_came_while_nobody_looked_for_long_is_dropped() {
    for settings in every() {
        let (line, mut rig, _) = connect(&settings);
        rig.home(line.now_s()).unwrap();
        line.at(line.now_s() + 10.0);
        let reading = rig.read(line.now_s()).unwrap();
        assert!(reading.angle_age_s < 0.02, "{}", reading.angle_age_s);
    }
}

#[test]
fn a_board_that_begins_anew_is_lost_until_it_is_homed() {
    for settings in [firmata(AngleAt::I2c), text("{t_ms} {counts} {hx711}")] {
        let (line, mut rig, _) = connect(&settings);
        rig.home(line.now_s()).unwrap();
        {
            let mut between = line.0.lock().unwrap();
            let now_s = between.now_s;
            between.board.reset(now_s).unwrap();
        }
        line.at(line.now_s() + 0.02);
        let error = rig.read(line.now_s()).unwrap_err().to_string();
        assert!(error.contains("begun anew") && error.contains("home again"), "{error}");
        rig.home(line.now_s()).unwrap();
        rig.read(line.now_s()).unwrap();
    }
}

#[test]
fn a_rate_beyond_what_the_line_carries_is_refused_with_the_reason() {
    let refused = |settings: &Settings, says: &[&str]| {
        let error = try_connect(settings, settings).err().unwrap().to_string();
        assert!(says.iter().all(|say| error.contains(say)), "{error}");
    };
    let at = |angle, rate_hz, baud| {
        let mut settings = Settings { baud, ..firmata(angle) };
        settings.firmata.as_mut().unwrap().rate_hz = rate_hz;
        settings
    };
    // Commands of 12 bytes at 1.25 times the readings' rate: 57,600 / 10 / 12 / 1.25 = 384 Hz.
    connect(&at(AngleAt::Analog(0), 333.0, None));
    refused(&at(AngleAt::Analog(0), 400.0, None), &["57600 baud carry at most 384", "raise baud"]);
    refused(&at(AngleAt::I2c, 600.0, None), &["384"]);
    refused(&at(AngleAt::I2c, 1001.0, Some(1_000_000)), &["firmata.rate_hz", "sampling interval"]);
    let mut lines = text("{t_us},{counts},{hx711}");
    lines.text.as_mut().unwrap().rate_hz = 500.0;
    refused(&lines, &["115200 baud carry at most 426", "raise baud"]);
    let mut cell = firmata(AngleAt::I2c);
    cell.hx711.as_mut().unwrap().baud = 300;
    refused(&cell, &["load cell", "hx711.baud"]);
    let error = lines.check_loop(500.0).unwrap_err().to_string();
    assert!(error.contains("625"), "{error}");
    assert_eq!(lines.check_loop(625.0), Ok(()));
}

#[test]
fn what_a_board_cannot_do_is_named_with_what_it_can() {
    let board_has = firmata(AngleAt::Analog(0));
    let change = |change: fn(&mut Firmata)| {
        let mut settings = board_has.clone();
        change(settings.firmata.as_mut().unwrap());
        try_connect(&board_has, &settings).err().unwrap().to_string()
    };
    let motor = change(|pins| pins.motor_pwm = 7);
    assert!(
        motor.contains("pin 7 cannot be Pwm") && motor.contains("3, 5, 6, 9, 10, 11"),
        "{motor}"
    );
    let angle = change(|pins| pins.angle = AngleAt::Analog(9));
    assert!(angle.contains("A9") && angle.contains("A0, A1, A2, A3, A4, A5"), "{angle}");
    let way = change(|pins| pins.motor_direction = 0);
    assert!(way.contains("pin 0 cannot be Output"), "{way}");
}

#[test]
fn settings_of_a_link_are_checked() {
    let refused = |toml: &str, says: &str| {
        let settings: Result<Settings, _> =
            toml::from_str(&format!("newtons_per_count = 1\n{toml}"));
        let error = settings
            .map_or_else(|e| e.to_string(), |settings| settings.check().unwrap_err().to_string());
        assert!(error.contains(says), "{toml}: {error}");
    };
    let pins = "[firmata]\nangle = \"A0\"\nmotor_pwm = 5\nmotor_direction = 4\nbrake_pwm = 6\nmotor_max_v = 1\nbrake_max_v = 1";
    refused("link = \"firmata\"", "no table [firmata]");
    refused("link = \"text\"", "no table [text]");
    refused(&format!("link = \"firmata\"\n{pins}"), "where the force comes from");
    refused(&pins.replace("A0", "A16"), "A0");
    refused(&pins.replace("brake_max_v = 1", "brake_max_v = -1"), "firmata.brake_max_v");
    let lines = "link = \"text\"\n[text]\nrate_hz = 10\ncounts_per_turn = 4096\nmotor_max_v = 1\nbrake_max_v = 1\n";
    let with = |line: &str, command: &str| format!("{lines}line = {line:?}\ncommand = {command:?}");
    refused(&with("{counts}", "{motor_pwm} {brake_pwm}"), "where the force comes from");
    refused(&with("{hx711}", "{motor_pwm} {brake_pwm}"), "{counts} is missing");
    refused(&with("{counts} {hx711}", "{motor_pwm}"), "command: {brake_pwm} is missing");
    refused(&with("{counts} {hx711}", "{motor_pwm} {brake_pwm}").replace("4096", "1"), "2 or more");
}

#[test]
fn steps_of_an_output_are_the_same_ones_again() {
    for full in [255, 1000, 4095, 16_383] {
        for steps in 0..=i32::from(full) {
            let drive = Drive::of_steps([-steps, steps], full, full);
            assert_eq!(drive.steps(full, full), [-steps, steps]);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_bytes_do_a_host_and_a_board_no_harm(
        bytes in prop::collection::vec(prop_oneof![any::<u8>(), prop::sample::select(
            &[0xF0, 0xF7, 0x6C, 0x6A, 0x77, 0x76, 0xE0, 0xF9, 0xC0, b'\n', b',', b'1'][..])], 0..400),
    ) {
        for settings in every() {
            let mut host = settings.host().unwrap().unwrap();
            for byte in &bytes {
                let _ = host.push(*byte);
            }
            let mut out = Vec::new();
            if host.facts().is_none_or(|facts| facts.is_ok()) {
                host.begin(&mut out);
            }
            let mut board = made(&settings, &Arc::default());
            board.take(0.0, &bytes, &mut out).unwrap();
            prop_assert!(out.len() < 200 * (bytes.len() + 10), "{} bytes said", out.len());
        }
    }
}
