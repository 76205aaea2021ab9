//! One session over one link, on a disk in memory.

use super::lever::{Counted, Remembering, Seen, Told, counted, lever};
use super::links::Over;
use crate::played::{Person, WIRE, plan, play, short_study};
use anyhow::{Context as _, ensure};
use std::sync::{Arc, PoisonError};
use zwidth_acquire::Plan;
use zwidth_device::mock;
use zwidth_device::{Capabilities, Device};
use zwidth_link::Drive;
use zwidth_link::simulated::{Bench, Trouble, Way};
use zwidth_link::{Board, Link, Settings, over};
use zwidth_store::{Layout, Memory};

/// Readings a second of a link that streams; its loop is 1.25 times as fast.
const STREAM_HZ: f64 = 100.0;
/// Ticks a second over frames.
const FRAMED_HZ: f64 = 120.0;
/// A line that is slow enough for few messages while homing, baud.
const FRAMED_BAUD: u32 = 115_200;
const CELL_BAUD: u32 = 115_200;
/// What a board needs for an answer, s.
const THINKS_S: f64 = 0.2e-3;
/// Longest trial, s.
const LIMIT_S: f64 = 0.4;
/// A program that found no board is started again so often, after so long, s.
const STARTS: u32 = 3;
const AGAIN_S: f64 = 1.5;
/// The board's watchdog has run out by then, s.
const LATER_S: f64 = 1.0;

/// What a session left.
pub(super) struct Ended {
    pub(super) disk: Memory,
    pub(super) layout: Layout,
    pub(super) done: usize,
    pub(super) total: usize,
    /// How often it was stopped.
    pub(super) stops: u32,
    /// What went wrong was the host's very last word.
    pub(super) was_last: bool,
    /// The session said that a voltage may stay on.
    pub(super) warned: bool,
    /// What was out after all, and whether a voltage stayed on without a cable.
    pub(super) drive: Drive,
    pub(super) left_on: bool,
    /// Readings that the board sent in their order, and all that it saw.
    pub(super) told: Vec<Counted>,
    pub(super) seen: Vec<Counted>,
    /// Messages of each way.
    pub(super) said: [u64; 3],
}

/// The short session of three trials over a link, of which this message goes wrong; an error if it
/// does not come to its end.
pub(super) fn record(link: Over, trouble: Option<(Way, u64, Trouble)>) -> anyhow::Result<Ended> {
    let rate_hz = if link.link.is_asked() { FRAMED_HZ } else { 1.25 * STREAM_HZ };
    let baud = (link.link == Link::Framed).then_some(FRAMED_BAUD);
    let rig = settings(link, STREAM_HZ, &mock::capabilities(), baud);
    // A pipe has no rate; its lines are about four times as long as frames.
    let line_baud = if link.link == Link::Process { 4 * FRAMED_BAUD } else { rig.baud() };
    let study = short_study(rate_hz, LIMIT_S)?;
    played(&study, &rig, line_baud, lever(), trouble, false)
}

/// Plays a session to its end over a line of so many bits a second; `answers` where the device has a
/// participant.
pub(super) fn played<D: Device + Told + 'static>(
    study_toml: &str,
    rig: &Settings,
    line_baud: u32,
    device: D,
    trouble: Option<(Way, u64, Trouble)>,
    answers: bool,
) -> anyhow::Result<Ended> {
    let (disk, plan) = plan(WIRE, study_toml)?;
    let seen = Seen::default();
    let told_to = Seen::default();
    let telling = Arc::clone(&told_to);
    let device = Remembering::new(device, &seen);
    let board = Board::by(rig, device, plan.study.environments.clone())?;
    let last = Arc::clone(&seen);
    let board = board.telling(move |reading| {
        // What the board tells is what it has just seen; its clock is the device's own.
        let seen = last.lock().unwrap_or_else(PoisonError::into_inner);
        let Some((t_us, _, _)) = seen.last() else { return };
        let counted = counted(*t_us as f64 * 1e-6, reading);
        telling.lock().unwrap_or_else(PoisonError::into_inner).push(counted);
    });
    let bench = Bench::new(board, line_baud, CELL_BAUD, THINKS_S);
    if let Some((way, nth, trouble)) = trouble {
        bench.trouble(way, nth, trouble);
    }
    let mut device = connected(&bench, rig, &plan)?;
    let waits = bench.clone();
    let mut person = Person::new(move |wait_s| waits.wait(wait_s));
    let mut clock = bench.clone();
    let outcome = play(&plan, &disk, &mut *device, &mut clock, &mut person, answers)?;
    drop(device);
    bench.wait(LATER_S);
    ensure!(trouble.is_none() || bench.happened(), "nothing happened to its message");
    let own = |list: &Seen| list.lock().unwrap_or_else(PoisonError::into_inner).clone();
    Ok(Ended {
        disk,
        layout: plan.layout,
        done: outcome.done,
        total: outcome.total,
        stops: person.stops,
        was_last: trouble.is_some_and(|(way, nth, _)| {
            way == Way::ToBoard && nth + 1 == bench.said(Way::ToBoard)
        }),
        warned: outcome.stays_on,
        drive: bench.drive(),
        left_on: bench.left_on(),
        told: own(&told_to),
        seen: own(&seen),
        said: Way::ALL.map(|way| bench.said(way)),
    })
}

/// The rig, if need be at another start of the program.
fn connected(bench: &Bench, rig: &Settings, plan: &Plan) -> anyhow::Result<Box<dyn Device>> {
    let start = || {
        let ids = plan.study.environments.iter().map(|e| e.id.clone()).collect();
        let cell = rig.hx711.is_some().then(|| bench.cell());
        over(bench.wire(), cell, rig, ids)
    };
    for _ in 1..STARTS {
        if let Ok(device) = start() {
            return Ok(device);
        }
        bench.wait(AGAIN_S);
    }
    start().context("no board is found")
}

/// What a device of this link can do at so many readings a second.
pub(super) fn settings(
    link: Over,
    rate_hz: f64,
    can: &Capabilities,
    baud: Option<u32>,
) -> Settings {
    let rig = Settings::of_board(link.link, link.angle, rate_hz, can, "/dev/cell".as_ref());
    Settings { baud, ..rig }
}
