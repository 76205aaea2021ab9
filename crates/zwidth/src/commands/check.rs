//! `zwidth check`: the device check before a session.

use super::device::{bench, clock, raised_by_signals};
use super::recover::lock;
use crate::devices::{DEVICES, DeviceSpec, checks_itself, open, warn_of_calibration};
use crate::exit::Exit;
use crate::limits::{positive, rate};
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::io::{BufRead, Write, stderr, stdin};
use std::path::Path;
use zwidth_acquire::{check_value, step_words};
use zwidth_device::check::{Finding, Step, check_device};
use zwidth_device::{Guard, Limits};
use zwidth_study::{Check, StudyId};

#[derive(Debug, clap::Args)]
pub(crate) struct CheckArgs {
    /// The study, whose work space, rate and calibration the device is to fit
    pub(crate) study: StudyId,
    /// The device
    #[arg(long, default_value = "twin", value_name = DEVICES)]
    pub(crate) device: DeviceSpec,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// A simulated clock: as fast as the machine can (simulated devices only)
    #[arg(long)]
    pub(crate) fast: bool,
    /// Ask for what a hand must do before each step; without it only steps that need none are done
    #[arg(long)]
    pub(crate) ask: bool,
    /// A known mass for the load cell, kg; asked for after the tare
    #[arg(long, value_name = "KG", value_parser = positive, requires = "ask")]
    pub(crate) mass: Option<f64>,
}

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

pub(crate) fn check(root: &Path, command: &CheckArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let bench = bench(root, command.study.clone(), command.rate)?;
    // Held to the end, so that no session of the study is recorded meanwhile.
    let _lock = lock(&bench.layout, "zwidth check")?;
    // No session is recorded, and a device cannot be opened without the ids of one.
    let participant = "check".parse()?;
    let session = "check".parse()?;
    let mut device = open(&command.device, &bench, SEED, &participant, &session)?;
    warn_of_calibration(&bench, &command.device, &device.capabilities().name, screen);
    let capabilities = device.capabilities().clone();
    let rate_hz = bench.study.control.rate_hz.min(capabilities.rate_hz);
    let mut guard = Guard::new(&capabilities, Limits::of(&bench.study)?, false);
    // A question is no result: it goes where messages go.
    let alone = checks_itself(&command.device);
    let mut may_begin = |step| {
        if command.ask { confirmed(step, &mut stdin().lock(), &mut stderr()) } else { alone(step) }
    };
    let stop = raised_by_signals()?;
    let mut clock = clock(command.fast, SEED);
    let findings = check_device(
        &mut *device,
        &mut *clock,
        &mut guard,
        &bench.calibration,
        rate_hz,
        command.mass,
        &stop,
        &mut may_begin,
    )?;
    if findings.is_empty() {
        bail!(
            "{}: a recorded trial cannot be checked; use --device twin or rig",
            capabilities.name
        );
    }
    let lines: Vec<Line> = findings.into_iter().map(line).collect();
    screen.give(&lines, || {
        screen.result(&capabilities.name);
        for Line { name, value, unit, ok, about } in &lines {
            let check = Check { name: name.clone(), value: *value, unit: unit.clone(), ok: *ok };
            let verdict = if *ok { "ok" } else { "NOT GOOD ENOUGH" };
            let about = if *ok { String::new() } else { format!("\n      {about}") };
            screen.result(format!("  {name:<20} {:>12}  {verdict}{about}", check_value(&check)));
        }
    })?;
    Ok(if lines.iter().all(|l| l.ok) { Exit::Fine } else { Exit::Failed })
}

fn line(Finding { check, about }: Finding) -> Line {
    Line { name: check.name, value: check.value, unit: check.unit, ok: check.ok, about }
}

/// Says what a hand must do before a step, and waits for its answer: Enter when it is done, `s` to
/// leave the step out. What moves the lever needs a `y`, and the end of the input consents to
/// nothing.
fn confirmed(step: Step, answers: &mut dyn BufRead, out: &mut dyn Write) -> bool {
    let (what, consent) = step_words(step);
    let key = if consent { "y lets them" } else { "Enter begins" };
    // Who cannot be asked has not consented.
    if writeln!(out, "{what} ({key}, s leaves this step out)").is_err() {
        return false;
    }
    let mut line = String::new();
    let read = answers.read_line(&mut line).unwrap_or(0);
    match line.trim() {
        _ if read == 0 => false,
        "" => !consent,
        "y" | "Y" => true,
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_done_after_enter_and_one_that_moves_the_lever_after_a_yes_alone() {
        let says = |step, mut line: &[u8]| confirmed(step, &mut line, &mut std::io::sink());
        for step in [Step::Rest, Step::Load(0.2), Step::Hand] {
            assert!(says(step, b"\n") && says(step, b"y\n"), "{step:?}");
            assert!(!says(step, b"s\n") && !says(step, b""), "{step:?}");
        }
        assert!(says(Step::Actuators, b"y\n"));
        for line in [&b"\n"[..], b"s\n", b"n\n", b""] {
            assert!(!says(Step::Actuators, line), "{line:?}");
        }
    }
}
