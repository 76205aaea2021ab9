//! Whole sessions of our host at our firmware in its emulator, by the emulator's time: undisturbed,
//! and with the cable pulled under voltage, where only the firmware's own watchdog can set 0 V.

use crate::emulator::Emulator;
use crate::played::{Person, WIRE, plan, play, short_study};
use anyhow::{Context as _, anyhow, bail, ensure};
use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::io;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;
use zwidth_acquire::Outcome;
use zwidth_device::Clock;
use zwidth_link::framed::frame::{Frame, Frames};
use zwidth_link::framed::message::{FromBoard, Seen, ToBoard};
use zwidth_link::mark;
use zwidth_link::{Rig, Settings, Wire};
use zwidth_store::{Memory, Signal, StudyData, read_trial_from, verify_kept};
use zwidth_study::{Moment, Status};

/// Trials of a repeat: three modes in one environment.
const MODES: usize = 3;
/// Ticks a second; the sketch reads 500 times a second at most.
const RATE_HZ: f64 = 400.0;
/// Longest trial, s.
const LIMIT_S: f64 = 1.0;
/// The sketch's supply, V: the study may not ask for more.
const SUPPLY_V: f64 = 12.0;
/// The lever goes forward by so many turns of the shaft (20° of it) and back, in so long, s.
const SWING_TURNS: f64 = 20.0 / 360.0 * 75.0 / 11.0;
const SWING_S: f64 = 0.9;
/// Counts of the angle's analog input in a turn of the shaft, and at the stop.
const PER_TURN: f64 = 1024.0;
const STOP: f64 = 300.0;
/// Counts of the load cell for a newton, and the force at the swing's end, N.
const COUNTS_PER_N: f64 = 20_000.0;
const MOST_N: f64 = 2.0;
/// The emulator runs no longer at a time, µs, with a trial under way and without.
const STEP_US: u64 = 100;
const IDLE_US: u64 = 2_000;
/// What the sensors saw is kept for so long, µs: the load cell's newest value is 12.5 ms old.
const KEPT_US: u64 = 40_000;
/// The cable is pulled in the second trial, when a voltage is out, and for so long, µs.
const PULLED_IN: u16 = 2;
const PULLED_US: u64 = 1_000_000;
/// The watchdog's time and a step of the emulator, µs.
const WATCHDOG_US: u64 = 50_000 + IDLE_US;
/// A moment is on the marker pins within so long after it was told, µs.
const SHOWN_US: u64 = 3_000;
/// Readings that the markers of a trial's begin hold back, or that come in one look with a newer
/// one.
const HELD_BACK: usize = 3;

/// When the cable was pulled, and when 0 V was out after it, µs.
#[derive(Debug, Clone, Copy)]
struct Pulled {
    at_us: u64,
    off_us: Option<u64>,
}

struct Bench {
    emulator: Emulator,
    to_board: Frames,
    from_board: Frames,
    /// The trial that began last, and when, µs.
    trial: Option<(u16, u64)>,
    /// What the sensors saw, by the emulator's time, µs.
    saw: VecDeque<(u64, u16, i32)>,
    /// What the board said that it saw, in its order.
    told: Vec<Seen>,
    /// The first reading that the sensors did not have.
    wrong: Option<Seen>,
    /// The moments that were told and are not on the marker pins yet, and when they were, µs.
    moments: VecDeque<(Moment, u64)>,
    /// How many were on them, and the longest that one took, µs.
    shown: usize,
    shown_us: u64,
    /// The cable is to be pulled once.
    pulls: bool,
    pulled: Option<Pulled>,
    /// The host found its cable pulled, and has not opened the port again.
    gone: bool,
}

/// Counts of angle and load cell so long after a trial began, s.
fn sensors(since_s: f64) -> (u16, i32) {
    let there = 0.5 * (1.0 - (TAU * (since_s / SWING_S).clamp(0.0, 1.0)).cos());
    let counts = (STOP + SWING_TURNS * PER_TURN * there).round() % PER_TURN;
    (counts as u16, (MOST_N * COUNTS_PER_N * there).round() as i32)
}

impl Bench {
    fn step(&mut self, until_us: u64) -> io::Result<()> {
        let now_us = self.emulator.us;
        let longest_us = if self.trial.is_some() { STEP_US } else { IDLE_US };
        let us = until_us.saturating_sub(now_us).min(longest_us);
        let since_s = self.trial.map_or(0.0, |(_, began_us)| (now_us - began_us) as f64 * 1e-6);
        let (counts, force) = sensors(since_s);
        self.saw.push_back((now_us, counts, force));
        self.saw.retain(|(at_us, ..)| at_us + KEPT_US >= now_us);
        self.emulator.set("angle", i32::from(counts))?;
        self.emulator.set("force", force)?;
        let before = self.emulator.said.len();
        self.emulator.run(us as u32, &[])?;
        let said = self.emulator.said[before..].to_vec();
        let frames: Vec<Frame> =
            said.iter().filter_map(|byte| self.from_board.push(*byte)).collect();
        for frame in &frames {
            if let Some(FromBoard::Seen(seen)) = FromBoard::read(frame) {
                self.take(seen);
            }
        }
        self.watch();
        self.look_at_pins();
        Ok(())
    }

    /// The moments that are on the marker pins by now.
    fn look_at_pins(&mut self) {
        let Emulator { us, marker, trial, .. } = self.emulator;
        while let Some((moment, told_us)) = self.moments.front().copied() {
            let is_level = match moment {
                Moment::Start | Moment::Contact => trial == 1,
                Moment::End | Moment::Answer => trial == 0,
            };
            if !(is_level && marker == 1) {
                return;
            }
            self.moments.pop_front();
            (self.shown, self.shown_us) = (self.shown + 1, self.shown_us.max(us - told_us));
        }
    }

    /// A reading that the board sent: both sensors had these counts.
    fn take(&mut self, seen: Seen) {
        let angle = self.saw.iter().any(|(_, counts, _)| *counts == seen.counts);
        let force = self.saw.iter().any(|(.., force)| *force == seen.force);
        if !(angle && force) {
            self.wrong.get_or_insert(seen);
        }
        self.told.push(seen);
    }

    /// Pulls the cable under voltage, and looks when 0 V is out.
    fn watch(&mut self) {
        let now_us = self.emulator.us;
        let is_off = self.emulator.out[..2] == [0, 0];
        if let Some(pulled) = &mut self.pulled {
            if is_off {
                pulled.off_us.get_or_insert(now_us);
            }
            if now_us < pulled.at_us + PULLED_US {
                self.emulator.said.clear();
            }
        } else if self.pulls && !is_off && self.trial.is_some_and(|(n, _)| n >= PULLED_IN) {
            self.pulled = Some(Pulled { at_us: now_us, off_us: None });
        }
    }

    fn run_until(&mut self, until_us: u64) -> io::Result<()> {
        while self.emulator.us < until_us {
            self.step(until_us)?;
        }
        Ok(())
    }

    fn is_pulled(&self) -> bool {
        self.pulled.is_some_and(|pulled| self.emulator.us < pulled.at_us + PULLED_US)
    }

    fn check(&mut self) -> io::Result<()> {
        self.gone |= self.is_pulled();
        if self.gone { Err(io::ErrorKind::BrokenPipe.into()) } else { Ok(()) }
    }
}

/// The host's end of the line, and its clock.
#[derive(Clone)]
struct Line(Arc<Mutex<Bench>>);

impl Line {
    fn bench(&self) -> MutexGuard<'_, Bench> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait(&self, s: f64) {
        let mut bench = self.bench();
        let until_us = bench.emulator.us + (s * 1e6).ceil() as u64;
        // An emulator that is gone is told of by the next message.
        let _ = bench.run_until(until_us);
    }
}

impl Wire for Line {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let mut bench = self.bench();
        let until_us = bench.emulator.us + wait.as_micros() as u64;
        while bench.emulator.said.is_empty() && bench.emulator.us < until_us {
            bench.check()?;
            bench.step(until_us)?;
        }
        bench.check()?;
        Ok(bench.emulator.receive(into))
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let mut bench = self.bench();
        bench.check()?;
        let frames: Vec<Frame> =
            bytes.iter().filter_map(|byte| bench.to_board.push(*byte)).collect();
        for frame in &frames {
            let now_us = bench.emulator.us;
            match ToBoard::read(frame) {
                Some(ToBoard::Mark { code: mark::TRIAL, number }) => {
                    bench.trial = Some((number, now_us));
                }
                Some(ToBoard::Mark { code: mark::HOMING, .. }) => bench.trial = None,
                Some(ToBoard::Mark { code: mark::MOMENT, number }) => {
                    bench.moments.extend(mark::moment(number).map(|moment| (moment, now_us)));
                }
                _ => {}
            }
        }
        bench.emulator.run(0, bytes)
    }

    fn now(&self) -> Duration {
        Duration::from_micros(self.bench().emulator.us)
    }

    fn reopen(&mut self) -> io::Result<()> {
        let mut bench = self.bench();
        bench.gone = bench.is_pulled();
        bench.emulator.said.clear();
        if bench.gone { Err(io::ErrorKind::NotFound.into()) } else { Ok(()) }
    }
}

impl Clock for Line {
    fn now_s(&mut self) -> f64 {
        self.bench().emulator.us as f64 * 1e-6
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        // An emulator that is gone is told of by the next message.
        let _ = self.bench().run_until((deadline_s * 1e6).ceil() as u64);
        self.now_s()
    }
}

/// Two sessions of so many repeats, the second one with its cable pulled.
pub(crate) fn sessions(repeats: u32, command: &[&str]) -> anyhow::Result<()> {
    for pulls in [false, true] {
        let of = if pulls { "the cable pulled under voltage" } else { "undisturbed" };
        println!("{of}: {}", session(repeats, pulls, command).context(of)?);
    }
    Ok(())
}

fn session(repeats: u32, pulls: bool, command: &[&str]) -> anyhow::Result<String> {
    let study_toml = short_study(RATE_HZ, LIMIT_S)?
        .replace("\nrepeats = 1\n", &format!("\nrepeats = {repeats}\n"))
        .replace("\nmotor_max_v = 16.0\n", &format!("\nmotor_max_v = {SUPPLY_V:?}\n"));
    let (disk, plan) = plan(WIRE, &study_toml)?;
    let line = Line(Arc::new(Mutex::new(Bench {
        emulator: Emulator::start(command)?,
        to_board: Frames::default(),
        from_board: Frames::default(),
        trial: None,
        saw: VecDeque::new(),
        told: Vec::new(),
        wrong: None,
        moments: VecDeque::new(),
        shown: 0,
        shown_us: 0,
        pulls,
        pulled: None,
        gone: false,
    })));
    let settings: Settings =
        toml::from_str(&format!("newtons_per_count = {}", 1.0 / COUNTS_PER_N))?;
    let environments = plan.study.environments.iter().map(|e| e.id.clone()).collect();
    let mut rig = Rig::connect(line.clone(), settings, environments)?;
    let waits = line.clone();
    let mut person = Person::new(move |s| waits.wait(s));
    let mut clock = line.clone();
    let outcome = play(&plan, &disk, &mut rig, &mut clock, &mut person, false)?;
    line.wait(SHOWN_US as f64 * 1e-6);
    let bench = line.bench();
    let total = repeats as usize * MODES;
    let Outcome { done, total: planned, .. } = outcome;
    ensure!((done, planned) == (total, total), "{done} of {planned} trials are done");
    ensure!(person.stops == u32::from(pulls), "it was stopped {} times", person.stops);
    if let Some((moment, _)) = bench.moments.front() {
        bail!("no pin showed '{}'", moment.as_str());
    }
    let Bench { shown, shown_us, .. } = &*bench;
    ensure!(
        *shown >= 3 * total && *shown_us <= SHOWN_US,
        "{shown} markers were on the pins, one after {shown_us} µs"
    );
    if let Some(wrong) = bench.wrong {
        bail!("the board said what no sensor had: {wrong:?}");
    }
    if let Some(finding) = verify_kept(&disk, &plan.layout).first() {
        bail!("verify finds: {finding}");
    }
    let data = StudyData::load_from(&disk, &plan.layout).map_err(|e| anyhow!("{e:?}"))?;
    let whole = data.trials.iter().filter(|trial| trial.meta.status == Status::Complete).count();
    ensure!(whole == total, "{whole} of {total} trials are whole");
    let mut readings = 0;
    let mut passed_over = 0;
    for trial in &data.trials {
        let [own, over] = arrived(&disk, &trial.path, &bench.told)
            .with_context(|| trial.path.display().to_string())?;
        (readings, passed_over) = (readings + own, passed_over + over);
    }
    let off = match bench.pulled {
        Some(Pulled { at_us, off_us }) => {
            let took_us = off_us.context("the voltage stayed on")? - at_us;
            ensure!(took_us <= WATCHDOG_US, "0 V came {took_us} µs after the cable was pulled");
            let took_ms = took_us as f64 * 1e-3;
            format!(", 0 V {took_ms:.1} ms after the cable was pulled, by the watchdog")
        }
        None if pulls => bail!("no voltage was ever out"),
        None => String::new(),
    };
    Ok(format!(
        "{whole} trials in {:.1} s of the board's time, {readings} readings, each as its sensors \
         had it, {passed_over} passed over for a newer one; {} markers on the pins, each within \
         {:.1} ms{off}",
        bench.emulator.us as f64 * 1e-6,
        bench.shown,
        bench.shown_us as f64 * 1e-3
    ))
}

/// How many readings a trial has, and how many that the board sent meanwhile it has not. Each it has
/// is one that the board sent, in the board's order.
fn arrived(disk: &Memory, path: &Path, told: &[Seen]) -> anyhow::Result<[usize; 2]> {
    let trial = read_trial_from(disk, path, Signal::all())?;
    let column = |signal| trial.samples.get(signal).context("a column is missing");
    let raw = column(Signal::ThetaRaw)?;
    let times = column(Signal::DeviceTime)?;
    let mut own: Vec<(u32, u16)> = (raw.iter().zip(times))
        .map(|(counts, t_s)| ((t_s * 1e6).round() as u32, *counts as u16))
        .collect();
    own.dedup();
    let place = |(t_us, counts): &(u32, u16)| {
        told.iter().position(|seen| (seen.t_us, seen.counts) == (*t_us, *counts))
    };
    let places: Option<Vec<usize>> = own.iter().map(place).collect();
    let places = places.context("a reading that the board never sent")?;
    let [Some(first), Some(last)] = [places.first(), places.last()] else {
        bail!("it has no reading");
    };
    ensure!(places.is_sorted(), "readings are out of turn");
    let passed_over = last + 1 - first - places.len();
    ensure!(passed_over <= HELD_BACK, "{passed_over} readings of the board are missing");
    Ok([places.len(), passed_over])
}
