//! `zwidth acquire`: records a session, or goes on with one.

use super::device::{Bench, bench, clock, keys, raised_by_signals, secret, warn_of_calibration};
use super::participant::{beside, way};
use super::recover::{lock, put_in_order_and_tell};
use super::resume::resume;
use crate::commands::device::Keys;
use crate::devices::{DEVICES, DeviceSpec, is_homed_by_hand, mixed, open, steps_alone};
use crate::exit::Exit;
use crate::limits::{positive, rate};
use crate::screen::Screen;
use crate::text::read_beside;
use anyhow::bail;
use std::io::{BufReader, stdin, stdout};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zwidth_acquire::{
    Auto, Front, Look, Options, Outcome, Parts, Plain, Plan, Screen as Terminal, Session, Target,
    own_study, run, seed_of,
};
use zwidth_device::check::steps;
use zwidth_store::{Raw, RealFiles, from_json};
use zwidth_study::{ExperimenterId, ParticipantId, SessionId, SessionRecord, Source, StudyId};

#[derive(Debug, Clone, PartialEq, clap::Args)]
pub(crate) struct AcquireArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The participant's code; the number at its end says which order, without one it is that of
    /// appearance
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// The device
    #[arg(long, default_value = "twin", value_name = DEVICES)]
    pub(crate) device: DeviceSpec,
    /// Lines in and out instead of the screen
    #[arg(long)]
    pub(crate) plain: bool,
    /// The screen in ASCII alone
    #[arg(long)]
    pub(crate) ascii: bool,
    /// Run without an experimenter: trials start by themselves, the simulated participant answers
    #[arg(long)]
    pub(crate) auto: bool,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// Seed of the order and of the simulated device [default: from the study's id; secret if it
    /// is blinded]
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// A simulated clock: as fast as the machine can (simulated devices only)
    #[arg(long)]
    pub(crate) fast: bool,
    /// Go through the whole device check: each step waits for what a hand must do, and what moves
    /// the lever for a yes
    #[arg(long, conflicts_with = "auto")]
    pub(crate) ask: bool,
    /// A known mass for the load cell, kg; asked for after the tare
    #[arg(long, value_name = "KG", value_parser = positive, requires = "ask")]
    pub(crate) mass: Option<f64>,
    #[command(flatten)]
    pub(crate) keys: Keys,
    /// Use the motor of a device without a watchdog; every trial is marked
    #[arg(long)]
    pub(crate) no_watchdog: bool,
    /// Your code, which stands beside everything that is kept in the session's log; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
    /// Who is told of each trial's start, contact, end and answer: programs, or the pins of the board
    /// (docs/acquire.md)
    #[arg(long, value_name = "tcp:HOST:PORT,osc:HOST:PORT,board", value_delimiter = ',')]
    pub(crate) markers: Vec<Target>,
    /// Go on with a session although study.toml has changed in what it records: by the session's
    /// own copy; its log says so
    #[arg(long)]
    pub(crate) accept_study_change: bool,
}

/// The software, as every record and trial names it.
pub(super) const SOFTWARE: &str = concat!("zwidth ", env!("CARGO_PKG_VERSION"));

pub(crate) fn acquire(root: &Path, command: &AcquireArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let AcquireArgs { participant, session, .. } = command;
    let mut bench = bench(root, command.study.clone(), command.rate)?;
    let layout = bench.layout.clone();
    let lock = lock(&layout, "zwidth acquire")?;
    put_in_order_and_tell(&layout, &lock, screen);
    if let Some(own) = own_study(&RealFiles, &bench.layout, participant, session)? {
        bench = bench.by(own, command.rate)?;
    }
    let seed = device_seed(&bench, command);
    let by_hand = is_homed_by_hand(&command.device);
    if by_hand && command.fast {
        bail!("--fast: a rig runs in real time; leave it out");
    }
    let mut device = open(&command.device, &bench.occasion(seed, participant, session))?;
    warn_of_calibration(&bench, &command.device, screen);
    if by_hand && command.auto && device.capabilities().source != Source::Twin {
        bail!("--auto: nobody would hold the lever against its stop; leave it out");
    }
    let keys = keys(&command.keys, bench.study.design.blinded)?;
    let plan = Plan {
        rate_hz: bench.study.control.rate_hz.min(device.capabilities().rate_hz),
        layout: bench.layout,
        study: bench.study,
        study_toml: bench.study_toml,
        accept_study_change: command.accept_study_change,
        participant: participant.clone(),
        session: session.clone(),
        calibration: bench.calibration,
        software: SOFTWARE.to_owned(),
        seed: command.seed,
        keys,
        secret: secret()?,
    };
    let raw = Raw::adds(&RealFiles, &layout, &lock).with_vault(&plan.keys);
    let laid = Session::open(&plan, device.capabilities(), &raw)?;
    let options = Options {
        live: !command.fast,
        answers: command.auto,
        by_hand,
        steps: if command.ask { steps(command.mass) } else { steps_alone(&command.device) },
        ask: command.ask,
        no_watchdog: command.no_watchdog,
        by: command.by.clone(),
        markers: command.markers.clone(),
        stop: raised_by_signals()?,
        quit: raised_by_signals()?,
    };
    let mut clock =
        clock(command.fast, mixed(seed, &["clock", participant.as_str(), session.as_str()]));
    // Before the terminal is taken: what is told of it would not be seen there.
    let way = if command.auto { None } else { way(&layout, &lock, screen) };
    let mut front = beside(front(command, Arc::clone(&options.stop))?, way);
    let utc = |_: f64| super::recover::now();
    let parts = Parts {
        device: &mut *device,
        clock: &mut *clock,
        files: &raw,
        front: &mut *front,
        utc: &utc,
    };
    let outcome = run(&plan, laid, &options, parts);
    drop(front); // the terminal is given back before anything is printed on it
    Ok(tell(&plan, &outcome?, &resume(root, command, plan.study.design.blinded), screen))
}

/// The simulated device's seed: the one asked for, else the one the session began with, so that it
/// goes on with the same device and person. A blinded session's seed stands nowhere, so its device
/// has one of its own.
fn device_seed(bench: &Bench, command: &AcquireArgs) -> u64 {
    if bench.study.design.blinded {
        return mixed(0, &["device", command.study.as_str()]);
    }
    let path = bench.layout.session(&command.participant, &command.session);
    let begun = || from_json::<SessionRecord>(&read_beside(&path).ok()??).ok()?.seed;
    command.seed.or_else(begun).unwrap_or_else(|| seed_of(&bench.study))
}

/// Who sits before it.
fn front(command: &AcquireArgs, stop: Arc<AtomicBool>) -> anyhow::Result<Box<dyn Front>> {
    let plain = |stop| Plain::new(BufReader::new(stdin()), stdout(), stop, !command.auto);
    let terminal = |stop| Terminal::open(Look::from_env(command.ascii), stop);
    Ok(match (command.plain, command.auto) {
        (true, true) => Box::new(Auto::new(plain(stop))),
        (true, false) => Box::new(plain(stop)),
        (false, true) => Box::new(Auto::new(terminal(stop)?)),
        (false, false) => Box::new(terminal(stop)?),
    })
}

/// What became of the session, and how to go on with it.
fn tell(plan: &Plan, outcome: &Outcome, resume: &str, screen: &Screen) -> Exit {
    let Outcome { done, total, timing, .. } = outcome;
    if timing.ticks > 0 {
        let ms = |s: f64| s * 1e3;
        screen.say(format!(
            "{} ticks, {} missed; late by {:.3} ms (median), {:.3} ms (99 %), {:.3} ms (most)",
            timing.ticks,
            timing.missed,
            ms(timing.lateness.percentile_s(50.0)),
            ms(timing.lateness.percentile_s(99.0)),
            ms(timing.lateness.max_s()),
        ));
    }
    let session = format!("{} {} {}", plan.layout.study(), plan.participant, plan.session);
    if outcome.stays_on {
        screen.warn("the board did not take its last 0 V and has no watchdog: a voltage may stay on; switch its supply off");
    }
    if done == total && outcome.stays_on {
        screen.say(format!("{session}: all {total} trials are done"));
        return Exit::Failed;
    }
    if done == total {
        screen.say(format!(
            "{session}: all {total} trials are done. Check them with `zwidth verify {}`.",
            plan.study.id
        ));
        return Exit::Fine;
    }
    screen.warn(format!("{session}: {done} of {total} trials are done; go on with `{resume}`"));
    if let Some(why) = &outcome.gone {
        screen.warn(format!("the terminal is gone ({why}); what was recorded is safe"));
        return Exit::Failed;
    }
    match (&outcome.stopped, outcome.interrupted) {
        (Some(why), _) => {
            screen.warn(format!("it was stopped: {why}"));
            Exit::Failed
        }
        (None, true) => {
            screen.warn("a signal ended it; what was recorded is safe");
            Exit::Failed
        }
        (None, false) => Exit::Partly,
    }
}
