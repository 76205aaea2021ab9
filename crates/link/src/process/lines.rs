//! The lines of a device by a process, both ends of them.
//!
//! The host counts what it is told: an angle in steps of [`STEP_RAD`], a force in steps of
//! [`STEP_N`], so that everything behind it, from homing at the stop to the recorded count, is as of a
//! board. A program whose sensor counts may give its counts instead.

use crate::board::device::{NEWTONS_PER_COUNT, ZERO_COUNTS};
use crate::framed::message::{Description, FromBoard, PROTOCOL, Seen, ToBoard, status};
use crate::framed::wording::{BoardWording, Wording};
use crate::text::Lines;
use crate::{Drive, mark};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::io::Write as _;
use std::time::Duration;
use zwidth_device::AWAY_S;
use zwidth_study::Voltages;

/// Longest line, bytes without its end.
pub(crate) const MOST_BYTES: usize = 512;
/// A program that gives angles is counted as a sensor with so many counts in a turn of a shaft…
const COUNTS_PER_TURN: u16 = 50_000;
/// …which turns so often in a turn of the lever. A turn of the shaft is then 30° of the lever: a step
/// from one reading to the next that is 7.5° off the expected one is refused.
const SHAFT_PER_LEVER: f64 = 12.0;
/// So one count is 10.5 µrad of the lever, or 0.0006°.
const STEP_RAD: f64 = TAU / (COUNTS_PER_TURN as f64 * SHAFT_PER_LEVER);
/// One count of a force, N.
pub(crate) const STEP_N: f64 = 1e-6;
/// An angle further from 0 is none of a lever, rad.
const MOST_RAD: f64 = 1e3;
/// A clock beyond this is none of a session, s: a thousand years.
const MOST_S: f64 = 3e10;
/// A program may take so long to begin, s: an interpreter loads its libraries.
const BEGIN: Duration = Duration::from_secs(10);
/// Of a line that is not understood so much is shown, characters.
const SHOWN: usize = 120;

/// The words of markers.
const MARKS: [(u8, &str); 4] = [
    (mark::ENVIRONMENT, "environment"),
    (mark::TRIAL, "trial"),
    (mark::HOMING, "homing"),
    (mark::MOMENT, "moment"),
];

/// What a program answers to "see".
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SeenLine {
    n: u16,
    t_s: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    angle_rad: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    counts: Option<u16>,
    force_n: f64,
    #[serde(default)]
    angle_age_s: f64,
    #[serde(default)]
    force_age_s: f64,
    /// Its watchdog has set the voltages to 0.
    #[serde(default)]
    tripped: bool,
}

/// What a program answers to "who".
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WhoLine {
    n: u16,
    protocol: u8,
    name: String,
    rate_hz: f64,
    force_rate_hz: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    counts_per_turn: Option<u16>,
    motor_max_v: f64,
    brake_max_v: f64,
    #[serde(default)]
    watchdog_s: Option<f64>,
    #[serde(default)]
    simulated: bool,
}

/// What a program says when it cannot go on.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ErrorLine<'a> {
    #[serde(borrow)]
    error: Cow<'a, str>,
}

/// What the host says.
#[derive(Debug, Serialize, Deserialize)]
struct HostLine<'a> {
    n: u16,
    say: &'a str,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    protocol: Option<u8>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    watchdog_s: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    motor_v: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    brake_v: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    what: Option<&'a str>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    number: Option<u16>,
}

impl<'a> HostLine<'a> {
    fn new(n: u16, say: &'a str) -> Self {
        Self {
            n,
            say,
            protocol: None,
            watchdog_s: None,
            motor_v: None,
            brake_v: None,
            what: None,
            number: None,
        }
    }
}

/// Writes a line. What is written here cannot fail: there is memory, and no number is NaN.
fn write(line: &impl Serialize, out: &mut Vec<u8>) {
    let _ = serde_json::to_writer(&mut *out, line);
    let _ = out.write_all(b"\n");
}

/// The host's end.
pub(crate) struct HostLines {
    lines: Lines<MOST_BYTES>,
    /// Full scale, V.
    full: Voltages,
    /// The program said how many counts a turn of its sensor has.
    counts: bool,
    /// Lines that were too long, as far as they were told.
    overlong: u64,
}

impl HostLines {
    pub(crate) fn new() -> Self {
        Self { lines: Lines::whole(), full: Voltages::OFF, counts: false, overlong: 0 }
    }
}

/// A number of a line within a range; what is wrong with it.
fn number(name: &str, value: f64, least: f64, most: f64) -> Result<f64, String> {
    if (least..=most).contains(&value) {
        return Ok(value);
    }
    Err(format!("{name} is {value}; it must be {least} to {most}"))
}

/// A time in whole microseconds.
fn micros(time_s: f64) -> f64 {
    (time_s * 1e6).round()
}

impl WhoLine {
    fn description(self) -> Result<Description, String> {
        let rate_hz = number("rate_hz", self.rate_hz, 1.0, 1e5)?;
        let force_rate_hz = number("force_rate_hz", self.force_rate_hz, 0.001, 1e5)?;
        let motor_v = number("motor_max_v", self.motor_max_v, 0.0, 1e3)?;
        let brake_v = number("brake_max_v", self.brake_max_v, 0.0, 1e3)?;
        let watchdog_s = match self.watchdog_s {
            Some(watchdog_s) => number("watchdog_s", watchdog_s, 0.001, AWAY_S)?,
            None => 0.0,
        };
        Ok(Description {
            protocol: self.protocol,
            period_us: micros(1.0 / rate_hz) as u32,
            force_period_us: micros(1.0 / force_rate_hz) as u32,
            counts_per_turn: self.counts_per_turn.unwrap_or(COUNTS_PER_TURN),
            motor_mv: (motor_v * 1e3).floor() as u32,
            brake_mv: (brake_v * 1e3).floor() as u32,
            watchdog_ms: (watchdog_s * 1e3).round() as u16,
            simulated: self.simulated,
            name: self.name,
        })
    }
}

impl SeenLine {
    /// `counts`: whether it gives the counts of its sensor.
    fn seen(&self, counts: bool) -> Result<Seen, String> {
        let counted = match (self.counts, self.angle_rad) {
            (Some(count), None) if counts => count,
            (None, Some(angle_rad)) if !counts => {
                let angle_rad = number("angle_rad", angle_rad, -MOST_RAD, MOST_RAD)?;
                let steps = (angle_rad / STEP_RAD).round() as i64;
                steps.rem_euclid(i64::from(COUNTS_PER_TURN)) as u16
            }
            _ if counts => return Err("it said counts_per_turn, so it must give counts".to_owned()),
            _ => {
                return Err(
                    "it must give angle_rad, or counts and before them counts_per_turn".to_owned()
                );
            }
        };
        let t_s = number("t_s", self.t_s, 0.0, MOST_S)?;
        let angle_age_s = number("angle_age_s", self.angle_age_s, 0.0, MOST_S)?;
        let force_age_s = number("force_age_s", self.force_age_s, 0.0, MOST_S)?;
        Ok(Seen {
            // As of a board: a clock of 32 bits that turns over after 71.6 minutes.
            t_us: (micros(t_s) as u64 & u64::from(u32::MAX)) as u32,
            counts: counted,
            // Ages beyond what a message can say are far beyond what safety allows.
            angle_age_us: micros(angle_age_s) as u16,
            force: (self.force_n / STEP_N).round() as i32,
            force_age_us: micros(force_age_s) as u32,
            status: if self.tripped { status::WATCHDOG } else { 0 },
            drive: Drive::default(),
        })
    }
}

/// A line that is not understood, as it is told.
fn not_understood(line: &[u8], why: &str) -> String {
    let text = String::from_utf8_lossy(line);
    let shown: String = text.chars().take(SHOWN).collect();
    let more = if text.chars().count() > SHOWN { "…" } else { "" };
    format!("it sent a line that is not understood: {why}: {shown}{more}")
}

impl Wording for HostLines {
    fn push(&mut self, byte: u8) -> Option<Result<(u16, FromBoard), String>> {
        // Of the byte before this one: what is handed out below is still in there.
        if self.lines.damaged() > self.overlong {
            self.overlong = self.lines.damaged();
            return Some(Err(format!("it sent a line of more than {MOST_BYTES} bytes")));
        }
        let line = self.lines.push(byte)?;
        // Most lines are readings: for one of them no memory is taken.
        let why = match serde_json::from_slice::<SeenLine>(line) {
            Ok(told) => {
                let seen = told.seen(self.counts).map_err(|why| not_understood(line, &why));
                return Some(seen.map(|seen| (told.n, FromBoard::Seen(seen))));
            }
            Err(why) => why,
        };
        if let Ok(told) = serde_json::from_slice::<ErrorLine<'_>>(line) {
            return Some(Err(format!("it says: {}", told.error)));
        }
        let told = match serde_json::from_slice::<WhoLine>(line) {
            Ok(told) => told,
            Err(other) => {
                // The fault is shown of the kind of line that was meant.
                let who = line.windows(10).any(|part| part == b"\"protocol\"");
                let why = if who { other } else { why };
                return Some(Err(not_understood(line, &why.to_string())));
            }
        };
        let (n, counts) = (told.n, told.counts_per_turn.is_some());
        Some(told.description().map_err(|why| not_understood(line, &why)).map(|board| {
            self.full = Voltages {
                motor_v: f64::from(board.motor_mv) * 1e-3,
                brake_v: f64::from(board.brake_mv) * 1e-3,
            };
            self.counts = counts;
            (n, FromBoard::Description(board))
        }))
    }

    fn say(&mut self, message: &ToBoard, number: u16, out: &mut Vec<u8>) {
        let new = |say| HostLine::new(number, say);
        let line = match *message {
            ToBoard::Hello => {
                HostLine { protocol: Some(PROTOCOL), watchdog_s: Some(AWAY_S), ..new("who") }
            }
            ToBoard::Poll => new("see"),
            ToBoard::Write(drive) => {
                let Voltages { motor_v, brake_v } = drive.voltages(self.full);
                HostLine { motor_v: Some(motor_v), brake_v: Some(brake_v), ..new("drive") }
            }
            ToBoard::Mark { code, number } => {
                let what = MARKS.iter().find(|(known, _)| *known == code).map(|(_, what)| *what);
                HostLine { what, number: Some(number), ..new("mark") }
            }
        };
        write(&line, out);
    }

    fn begin_anew(&mut self) {
        (self.lines, self.overlong) = (Lines::whole(), 0);
    }

    fn damaged(&self) -> u64 {
        self.lines.damaged()
    }

    fn shaft_per_lever(&self) -> Option<f64> {
        (!self.counts).then_some(SHAFT_PER_LEVER)
    }

    fn begins_within(&self) -> Duration {
        BEGIN
    }

    fn silent(&self, _: u32) -> (String, &'static str) {
        let what = format!("it does not say within {} s who it is", BEGIN.as_secs());
        (
            what,
            "start the program by hand, type {\"n\":1,\"say\":\"who\"}, and look at what it prints; does it flush each line?",
        )
    }
}

/// The board's end, in software: a program whose sensor counts.
pub(crate) struct BoardLines {
    lines: Lines<MOST_BYTES>,
    full: Voltages,
}

impl BoardLines {
    pub(crate) fn new() -> Self {
        Self { lines: Lines::whole(), full: Voltages::OFF }
    }
}

impl BoardWording for BoardLines {
    fn hear(&mut self, byte: u8) -> Option<(u16, ToBoard)> {
        let line = self.lines.push(byte)?;
        let told = serde_json::from_slice::<HostLine<'_>>(line).ok()?;
        let message = match told.say {
            "who" => ToBoard::Hello,
            "see" => ToBoard::Poll,
            "drive" => {
                let volts = Voltages { motor_v: told.motor_v?, brake_v: told.brake_v? };
                ToBoard::Write(Drive::of(volts, self.full))
            }
            "mark" => {
                let (code, _) = MARKS.iter().find(|(_, what)| Some(*what) == told.what)?;
                ToBoard::Mark { code: *code, number: told.number? }
            }
            _ => return None,
        };
        Some((told.n, message))
    }

    fn answer(&mut self, message: &FromBoard, number: u16, out: &mut Vec<u8>) {
        match message {
            FromBoard::Description(board) => {
                let volts = |millivolts: u32| f64::from(millivolts) * 1e-3;
                self.full =
                    Voltages { motor_v: volts(board.motor_mv), brake_v: volts(board.brake_mv) };
                let watchdog_s = f64::from(board.watchdog_ms) * 1e-3;
                let line = WhoLine {
                    n: number,
                    protocol: board.protocol,
                    name: board.name.clone(),
                    rate_hz: 1e6 / f64::from(board.period_us),
                    force_rate_hz: 1e6 / f64::from(board.force_period_us),
                    counts_per_turn: Some(board.counts_per_turn),
                    motor_max_v: self.full.motor_v,
                    brake_max_v: self.full.brake_v,
                    watchdog_s: (board.watchdog_ms > 0).then_some(watchdog_s),
                    simulated: board.simulated,
                };
                write(&line, out);
            }
            FromBoard::Seen(seen) => {
                let force = f64::from(seen.force) - ZERO_COUNTS;
                let line = SeenLine {
                    n: number,
                    t_s: f64::from(seen.t_us) * 1e-6,
                    angle_rad: None,
                    counts: Some(seen.counts),
                    force_n: force * NEWTONS_PER_COUNT,
                    angle_age_s: f64::from(seen.angle_age_us) * 1e-6,
                    force_age_s: f64::from(seen.force_age_us) * 1e-6,
                    tripped: seen.status & status::WATCHDOG != 0,
                };
                write(&line, out);
            }
        }
    }

    fn reset(&mut self) {
        self.lines = Lines::whole();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What the host makes of a text.
    fn heard(host: &mut HostLines, text: &str) -> Vec<Result<(u16, FromBoard), String>> {
        text.bytes().filter_map(|byte| host.push(byte)).collect()
    }

    fn seen(text: &str) -> Result<Seen, String> {
        match heard(&mut HostLines::new(), &format!("{text}\n")).remove(0)? {
            (7, FromBoard::Seen(seen)) => Ok(seen),
            other => panic!("{other:?}"),
        }
    }

    const WHO: &str = r#"{"n":3,"protocol":1,"name":"lever","rate_hz":1000,"force_rate_hz":500,"motor_max_v":12,"brake_max_v":24.5,"watchdog_s":0.05,"simulated":true}"#;

    #[test]
    fn an_angle_and_a_force_are_counted_finely() {
        let told = seen(r#"{"n":7,"t_s":1.5,"angle_rad":0.1,"force_n":-2.5}"#).unwrap();
        // 0.1 rad of 2π/600,000 each are 9,549.3.
        assert_eq!((told.t_us, told.counts, told.force), (1_500_000, 9_549, -2_500_000));
        let back = seen(r#"{"n":7,"t_s":0,"angle_rad":-1e-5,"force_n":1e300}"#).unwrap();
        assert_eq!((back.counts, back.force), (49_999, i32::MAX));
    }

    #[test]
    fn a_program_says_who_it_is() {
        let mut host = HostLines::new();
        let told = heard(&mut host, &format!("{WHO}\n")).remove(0).unwrap();
        let (3, FromBoard::Description(board)) = told else { panic!("{told:?}") };
        assert_eq!((board.period_us, board.force_period_us), (1_000, 2_000));
        assert_eq!((board.motor_mv, board.brake_mv, board.watchdog_ms), (12_000, 24_500, 50));
        assert!(board.simulated);
        assert_eq!(host.shaft_per_lever(), Some(12.0));
        let mut out = Vec::new();
        host.say(&ToBoard::Write(Drive { motor: -32_767, brake: 0 }), 9, &mut out);
        host.say(&ToBoard::Mark { code: mark::TRIAL, number: 4 }, 10, &mut out);
        let said = String::from_utf8(out).unwrap();
        assert_eq!(
            said,
            "{\"n\":9,\"say\":\"drive\",\"motor_v\":-12.0,\"brake_v\":0.0}\n\
             {\"n\":10,\"say\":\"mark\",\"what\":\"trial\",\"number\":4}\n"
        );
    }

    #[test]
    fn a_line_that_is_not_understood_says_what_is_wrong_with_it() {
        for (line, why) in [
            (r#"{"n":7,"t_s":1,"angle_rad":NaN,"force_n":0}"#, "expected value"),
            (r#"{"n":7,"t_s":1,"angle_rad":1e999,"force_n":0}"#, "number out of range"),
            (r#"{"n":7,"t_s":1,"angle_rad":1e9,"force_n":0}"#, "angle_rad is 1000000000"),
            (r#"{"n":7,"t_s":-1,"angle_rad":0,"force_n":0}"#, "t_s is -1"),
            (r#"{"n":7,"t_s":1,"force_n":0}"#, "it must give angle_rad"),
            (r#"{"n":7,"t_s":1,"counts":3,"force_n":0}"#, "before them counts_per_turn"),
            (r#"{"n":7,"t_s":1,"angle":0,"force_n":0}"#, "unknown field `angle`"),
            (r#"{"n":7,"protocol":1}"#, "missing field `name`"),
            ("hello", "not understood"),
            (r#"{"error":"the handle is off"}"#, "it says: the handle is off"),
            (&WHO.replace("0.05", "0.2"), "watchdog_s is 0.2; it must be 0.001 to 0.05"),
            (&"x".repeat(600), "more than 512 bytes"),
        ] {
            let told = heard(&mut HostLines::new(), &format!("{line}\n")).remove(0).unwrap_err();
            assert!(told.contains(why), "{line}: {told}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_message_a_fault_or_nothing(
            bytes in prop::collection::vec(prop_oneof![Just(b'\n'), Just(b'{'), Just(b'"'), any::<u8>()], 0..2_000),
        ) {
            let mut host = HostLines::new();
            let mut board = BoardLines::new();
            for byte in bytes {
                let _ = host.push(byte);
                let _ = board.hear(byte);
            }
        }

        #[test]
        fn what_the_host_says_is_read_as_it_was_meant(
            motor in any::<i16>(), brake in 0..i16::MAX, number in any::<u16>(),
        ) {
            let mut host = HostLines::new();
            heard(&mut host, &format!("{WHO}\n"));
            let mut board = BoardLines { full: host.full, ..BoardLines::new() };
            let all = [
                ToBoard::Hello,
                ToBoard::Poll,
                ToBoard::Mark { code: mark::MOMENT, number },
                ToBoard::Write(Drive { motor, brake }),
            ];
            for message in all {
                let mut out = Vec::new();
                host.say(&message, 65_535, &mut out);
                let read = out.into_iter().find_map(|byte| board.hear(byte));
                match (message, read) {
                    // Rounded towards 0 a second time: never more than the command.
                    (ToBoard::Write(meant), Some((65_535, ToBoard::Write(read)))) => {
                        prop_assert!((0..=1).contains(&(meant.motor.unsigned_abs() - read.motor.unsigned_abs())));
                        prop_assert!((0..=1).contains(&(meant.brake - read.brake)));
                    }
                    (meant, read) => prop_assert_eq!(read, Some((65_535, meant))),
                }
            }
        }
    }
}
