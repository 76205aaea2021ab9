//! Minutes of trials in real time at 1 kHz on the simulated device, or on a board with this device
//! at the other end of a serial line, written as users write them. No sample is lost, jitter and
//! missed deadlines are reported, and every missed deadline is flagged in the data.

use super::{SESSION, STUDY, fresh, run};
#[cfg(unix)]
use crate::board::Plugged;
use crate::shell::{program, scratch, words};
use crate::tried::held;
use anyhow::{Context as _, ensure};
use std::time::Instant;
use zwidth_store::{Layout, Signal, StudyData, read_trial};
use zwidth_study::Flags;

/// A trial of the simulated participant takes about this long, s.
const TRIAL_S: f64 = 3.0;
/// Conditions of the template's design.
const CONDITIONS: f64 = 6.0;
/// More stops than this say that the machine cannot do it at all.
const MOST_STOPS: u32 = 50;
/// Between samples at 1 kHz, s.
const TICK_S: f64 = 1e-3;

/// At this rate an answer of the framed link comes in the tick that asked for it.
#[cfg(unix)]
const BAUD: u32 = 1_000_000;

/// A board at the end of a line, until this process ends; what `acquire` calls it.
#[cfg(unix)]
fn plugged(layout: &Layout, link: &str) -> anyhow::Result<String> {
    let mut board = Plugged::new(&layout.study_toml(), link, 1)?;
    board.settings.baud = Some(BAUD);
    std::fs::write(layout.raw().join("rig.toml"), toml::to_string(&board.settings)?)?;
    let device = format!("rig:{}", board.port().display());
    // A session at a board that fails says so.
    std::thread::spawn(|| board.serve());
    Ok(device)
}

/// A line of a board in software is a pseudo-terminal.
#[cfg(not(unix))]
fn plugged(_layout: &Layout, _link: &str) -> anyhow::Result<String> {
    anyhow::bail!("this system has no pseudo-terminals; leave the link out")
}

/// `link`: of the board, where the device is one.
pub(crate) fn live(minutes: f64, link: Option<&str>) -> anyhow::Result<()> {
    let program = program()?;
    let began = Instant::now();
    let repeats = (minutes * 60.0 / (TRIAL_S * CONDITIONS)).ceil().max(1.0);
    let layout = fresh(
        &scratch("live").join("live"),
        &[
            ("\nrepeats = 6\n", &format!("\nrepeats = {repeats}\n")),
            ("\nfamiliarisation = 3\n", "\nfamiliarisation = 0\n"),
            ("\npause_s = 5.0\n", "\npause_s = 2.0\n"),
        ],
    )?;
    let mut line = format!("acquire {STUDY} {SESSION} --plain --auto --seed 1");
    if let Some(link) = link {
        line += &format!(" --device {}", plugged(&layout, link)?);
    }
    // A machine that has no time for the loop is stopped by safety, as it should be; the session
    // then goes on.
    let mut ticks = 0;
    let mut stops = 0;
    let mut timings = Vec::new();
    loop {
        let output = run(&program, layout.root(), &words(&line), &[0, 1])?;
        let [out, err] = [&output.stdout, &output.stderr]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        let told = out + &err;
        if let Some(timing) = told.lines().find(|line| line.contains(" ticks, ")) {
            let number = timing.split(' ').next().unwrap_or_default();
            ticks += number.parse::<usize>().context("the number of ticks")?;
            timings.push(timing.to_owned());
        }
        if output.status.success() {
            break;
        }
        stops += 1;
        ensure!(stops <= MOST_STOPS, "stopped {stops} times, the last time so:\n{told}");
    }
    run(&program, layout.root(), &["verify", STUDY], &[0])?;

    let data = StudyData::load(&layout).map_err(|errors| anyhow::anyhow!("{errors:?}"))?;
    let mut rows = 0;
    let mut flagged = 0;
    let mut stale = 0;
    let mut passed = 0.0;
    for trial in &data.trials {
        let read = read_trial(&trial.path, [Signal::Time, Signal::StateBits])?;
        let column = |signal| read.samples.get(signal).unwrap_or_default();
        rows += trial.rows;
        let count = |flag| {
            column(Signal::StateBits).iter().filter(|flags| Flags(**flags as u16).has(flag)).count()
        };
        flagged += count(Flags::DROPOUT);
        stale += count(Flags::STALE_ANGLE);
        passed += column(Signal::Time).last().copied().unwrap_or(0.0);
    }
    ensure!(rows == ticks, "{ticks} samples were taken and {rows} are stored");
    println!(
        "{} trials, {passed:.0} s at {:.0} Hz, no sample lost: {rows} stored",
        data.trials.len(),
        1.0 / TICK_S
    );
    timings.iter().for_each(|timing| println!("{timing}"));
    println!(
        "{flagged} samples are flagged as coming after a gap, {stale} repeat an angle; safety stopped \
         the session {stops} times"
    );
    let mut what = "samples at 1 kHz in real time, none lost".to_owned();
    let mut command = format!("cargo xtask soak live {minutes}");
    if let Some(link) = link {
        what += &format!(", over the {link} link");
        command += &format!(" {link}");
    }
    held(&what, command, rows as u64, began)
}
