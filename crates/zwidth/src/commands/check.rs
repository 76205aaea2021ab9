//! `zwidth check`: the device check before a session.

use super::device::{bench, clock, raised_by_signals};
use super::recover::lock;
use crate::args::Check;
use crate::devices::{checks_itself, open};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::path::Path;
use zwidth_device::check::{Finding, check_device};
use zwidth_device::{Guard, Limits};

/// Seed of the simulated device and its clock.
const SEED: u64 = 1;

#[derive(Serialize)]
struct Line {
    name: String,
    value: f64,
    unit: String,
    ok: bool,
    about: &'static str,
}

pub(crate) fn check(root: &Path, command: &Check, screen: &Screen) -> anyhow::Result<Exit> {
    let bench = bench(root, command.study.clone(), command.rate)?;
    let _lock = lock(&bench.layout, "zwidth check")?;
    let (nobody, none) = ("check".parse()?, "check".parse()?);
    let mut device = open(&command.device, &bench.occasion(SEED, &nobody, &none))?;
    let capabilities = device.capabilities().clone();
    let rate_hz = bench.study.control.rate_hz.min(capabilities.rate_hz);
    let mut guard = Guard::new(&capabilities, Limits::of(&bench.study)?, false);
    let mut able = checks_itself(&command.device);
    let stop = raised_by_signals()?;
    let mut clock = clock(command.fast, SEED);
    let found = check_device(
        &mut *device,
        &mut *clock,
        &mut guard,
        &bench.calibration,
        rate_hz,
        None,
        &stop,
        &mut able,
    )?;
    if found.is_empty() {
        bail!("{}: there is nothing to check; use a device that can be asked", capabilities.name);
    }
    let lines: Vec<Line> = found.into_iter().map(line).collect();
    if screen.json {
        screen.listing(&lines)?;
    } else {
        screen.result(&capabilities.name);
        lines.iter().for_each(|l| screen.result(text(l)));
    }
    Ok(if lines.iter().all(|l| l.ok) { Exit::Fine } else { Exit::Failed })
}

fn line(Finding { check, about }: Finding) -> Line {
    Line { name: check.name, value: check.value, unit: check.unit, ok: check.ok, about }
}

fn text(l: &Line) -> String {
    let unit = if l.unit == "1" { "" } else { &l.unit };
    let verdict = if l.ok { "ok" } else { "NOT GOOD ENOUGH" };
    let about = if l.ok { String::new() } else { format!("\n      {}", l.about) };
    format!("  {:<20} {:>10.4} {unit:<4} {verdict}{about}", l.name, l.value)
}
