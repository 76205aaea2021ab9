//! SIGKILL and a pulled cable while the actuators have voltage: the control loop runs in a process
//! of its own, the board in this one, in real time, with a cable between them. Nobody tells the
//! board: its watchdog removes the voltages.

use super::cable::{Board, Remote};
use super::{STUDY, fraction};
use crate::shell::scratch;
use crate::tried::held;
use anyhow::{Context as _, bail, ensure};
use std::ops::ControlFlow;
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};
use zwidth_device::{
    Controller, Device as _, Guard, Limits, Person, RealClock, TrialPlan, Twin, TwinParameters,
    run_live,
};
use zwidth_study::{Calibration, Mode, Study, StudyId, template};

/// What the host says when the cable was pulled.
const LOST: &str = "Lost";
/// What it says when its loop was away for too long, and went to 0 V of itself.
const LATE: &str = "Deadlines";
/// A host is up, homed and has voltage within this time, s.
const UP_S: f64 = 10.0;
/// It is cut off at most so long after its first voltage, s.
const LONGEST_S: f64 = 1.5;
/// For so long afterwards the voltages must stay away, s.
const QUIET_S: f64 = 0.2;
/// The board looks at its line so often.
const POLL: Duration = Duration::from_micros(100);

#[derive(Debug, Clone, Copy, PartialEq)]
enum Cut {
    Kill,
    Cable,
}

/// Cuts hosts off, by turns by SIGKILL and by the cable, and tells how long the voltages outlived
/// them.
pub(crate) fn watchdog(cuts: u32, seed: u64) -> anyhow::Result<()> {
    let folder = scratch("watchdog");
    let began = Instant::now();
    std::fs::create_dir_all(&folder)?;
    let study = study()?;
    let mut longest_s = [0.0_f64; 2];
    let mut done = [0; 2];
    let mut tries = 0;
    while done.iter().sum::<u32>() < cuts {
        tries += 1;
        ensure!(tries <= 10 * cuts, "the actuators had no voltage in most of {tries} tries");
        let cut = if done[0] <= done[1] { Cut::Kill } else { Cut::Cable };
        let after_s = LONGEST_S * fraction(&format!("watchdog {seed} {tries}"))?;
        let on_s = round(&folder, &study, cut, after_s).with_context(|| {
            format!("try {tries} of seed {seed}, {cut:?} {after_s} s after the first voltage")
        })?;
        if let Some(on_s) = on_s {
            done[cut as usize] += 1;
            longest_s[cut as usize] = longest_s[cut as usize].max(on_s);
        }
    }
    let [killed_ms, unplugged_ms] = longest_s.map(|s| 1e3 * s);
    println!(
        "{} hosts were killed and {} cables pulled while there was voltage: 0 V after at most {killed_ms:.1} ms and \
         {unplugged_ms:.1} ms",
        done[0], done[1]
    );
    let what = "hosts killed and cables pulled under voltage: the board goes to 0 V";
    held(what, format!("cargo xtask soak watchdog {cuts}"), cuts.into(), began)
}

/// How long the voltages outlived the host, s; none if there were none when it was cut off.
fn round(folder: &Path, study: &Study, cut: Cut, after_s: f64) -> anyhow::Result<Option<f64>> {
    let socket = folder.join("board");
    let _ = std::fs::remove_file(&socket); // of the round before
    let listener = UnixListener::bind(&socket)?;
    let mut host = Command::new(std::env::current_exe()?)
        .args(["soak", "host"])
        .arg(&socket)
        .stdout(Stdio::piped())
        .spawn()?;
    let board = Board::new(study, twin()?, listener.accept()?.0)?;
    let outlived = cut_off(board, &mut host, cut, after_s);
    host.kill()?; // of one that is gone already too
    let said = String::from_utf8(host.wait_with_output()?.stdout)?;
    let outlived = outlived?;
    // A loop that this machine gave no time went to 0 V in the instant of the cut: nothing is
    // learned of the cable, neither for nor against the board's watchdog.
    if cut == Cut::Cable && said.contains(LATE) {
        return Ok(None);
    }
    let told = outlived.is_none() || cut == Cut::Kill || said.contains(LOST);
    ensure!(told, "the host does not say that the cable is out: '{said}'");
    Ok(outlived)
}

fn cut_off(
    mut board: Board<'_>,
    host: &mut Child,
    cut: Cut,
    after_s: f64,
) -> anyhow::Result<Option<f64>> {
    let gone = |host: &mut Child| matches!(host.try_wait(), Ok(Some(_)));
    let (on_s, _) = until(&mut board, UP_S, |board, _| board.is_on() || gone(host))?
        .context("no voltage came")?;
    until(&mut board, UP_S, |_, now_s| now_s >= on_s + after_s)?;
    if !board.is_on() {
        return Ok(None); // safety ended the trial, as it does where a machine has no time for the loop; or it was over
    }
    let cut_s = board.turn()?;
    // A process under SIGKILL still runs, and commands, until the kernel has ended it.
    let silent_s = match cut {
        Cut::Kill => {
            host.kill()?;
            until(&mut board, UP_S, |_, _| gone(host))?.context("the host outlives SIGKILL")?;
            board.turn()? // hears the last of it
        }
        Cut::Cable => {
            board.unplug();
            cut_s
        }
    };
    let (off_s, away_s) =
        until(&mut board, UP_S, |board, _| !board.is_on())?.context("there still is voltage")?;
    let watchdog_s = twin()?.capabilities().watchdog_s.context("the board has no watchdog")?;
    ensure!(
        off_s - silent_s <= watchdog_s + away_s,
        "0 V came {} s after the host's end; the watchdog has {watchdog_s} s, and this machine was away for {away_s} s",
        off_s - silent_s
    );
    ensure!(
        until(&mut board, QUIET_S, |board, _| board.is_on())?.is_none(),
        "the voltage came back"
    );
    if cut == Cut::Cable {
        let noticed = until(&mut board, UP_S, |_, _| gone(host))?;
        ensure!(noticed.is_some(), "the host does not notice that the cable is out");
    }
    Ok(Some(off_s - cut_s))
}

/// Lets the board run until something holds: when that was, and the longest time between two looks
/// at it, s. None if it does not within `limit_s`.
fn until(
    board: &mut Board<'_>,
    limit_s: f64,
    mut holds: impl FnMut(&Board<'_>, f64) -> bool,
) -> anyhow::Result<Option<(f64, f64)>> {
    let begin_s = board.turn()?;
    let mut last_s = begin_s;
    let mut away_s = 0.0_f64;
    while last_s < begin_s + limit_s {
        std::thread::sleep(POLL);
        let now_s = board.turn()?;
        (last_s, away_s) = (now_s, away_s.max(now_s - last_s));
        if holds(board, now_s) {
            return Ok(Some((now_s, away_s)));
        }
    }
    Ok(None)
}

/// The host: one trial with the motor in real time, on the board behind a socket. Says how it
/// ended.
pub(crate) fn host(socket: &Path) -> anyhow::Result<()> {
    let study = study()?;
    let motor: Option<&Mode> = study.modes.iter().find(|mode| mode.motor_max_v.is_some());
    let (Some(environment), Some(mode)) = (study.environments.first(), motor) else {
        bail!("the template of a study has no environment, or no mode with a motor");
    };
    let mut device = Remote::connect(socket, twin()?.capabilities().clone())?;
    let mut clock = RealClock::new();
    let calibration = Calibration::thesis();
    let mut controller = Controller::new(&study.control, environment, mode, &calibration);
    let mut guard = Guard::new(device.capabilities(), Limits::of(&study)?, false);
    guard.home(&mut device, 0.0)?;
    guard.arm(mode, &calibration)?;
    let plan = TrialPlan::new(&study, environment, 1, device.capabilities())?;
    let mut forget = |_: &[_]| ControlFlow::Continue(());
    let stop = AtomicBool::new(false);
    let live =
        run_live(&mut device, &mut clock, &mut controller, &mut guard, &plan, &stop, &mut forget);
    println!("{:?}", live.run.end);
    Ok(())
}

fn study() -> anyhow::Result<Study> {
    let text = template(&StudyId::new(STUDY)?);
    Study::from_toml(&text).map_err(|errors| anyhow::anyhow!("{errors:?}"))
}

fn twin() -> anyhow::Result<Twin> {
    Ok(Twin::new(TwinParameters::default(), Person::typical(1), 1)?)
}
