//! `zwidth acquire`: records a session, or continues one.

use super::device::{Bench, bench, clock, keys, raised_by_signals, secret};
use super::participant::{beside, way};
use super::recover::{lock, put_in_order_and_tell};
use crate::commands::device::Keys;
use crate::devices::{
    DEVICES, DeviceSpec, is_homed_by_hand, mixed, open, steps_alone, warn_of_calibration,
};
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
    Auto, Front, Look, Options, Outcome, Parts, Plain, Plan, Screen as Terminal, Session,
    StreamName, Target, Verdict, own_study, run, seed_of,
};
use zwidth_device::check::steps;
use zwidth_metrics::{Parameters, compliance_of};
use zwidth_store::{Raw, RealFiles, Trial, from_json, shell_line, shell_option};
use zwidth_study::{
    ExperimenterId, ParticipantId, SessionId, SessionRecord, Source, Study, StudyId,
};

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
    /// Begin no trial before this stream of the LabStreamingLayer is there, by its name; may be given again
    /// (docs/acquire.md)
    #[arg(long, value_name = "STREAM")]
    pub(crate) wait_for: Vec<StreamName>,
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
    // The plan takes the bench apart, and `raw` is opened after that.
    let layout = bench.layout.clone();
    let lock = lock(&layout, "zwidth acquire")?;
    // Before the session is looked at: what a kill left in its journal becomes trials first.
    put_in_order_and_tell(&layout, &lock, screen);
    if let Some(own) = own_study(&RealFiles, &bench.layout, participant, session)? {
        bench = bench.by(own, command.rate)?;
    }
    let seed = device_seed(&bench, command);
    let by_hand = is_homed_by_hand(&command.device);
    if by_hand && command.fast {
        bail!("--fast: a rig runs in real time; leave it out");
    }
    let mut device = open(&command.device, &bench, seed, participant, session)?;
    warn_of_calibration(&bench, &command.device, &device.capabilities().name, screen);
    if by_hand && command.auto && device.capabilities().source != Source::Twin {
        bail!("--auto: nobody would hold the lever against its stop; leave it out");
    }
    let keys = keys(&command.keys, bench.study.design.blinded)?;
    let plan = Plan {
        // A device that is slower than the study's loop sets the rate.
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
        streams: command.wait_for.clone(),
        stop: raised_by_signals()?,
        quit: raised_by_signals()?,
    };
    let mut clock =
        clock(command.fast, mixed(seed, &["clock", participant.as_str(), session.as_str()]));
    // Before the terminal is taken: what is told of it would not be seen there.
    let way = if command.auto { None } else { way(&layout, &lock, screen) };
    let mut front = beside(front(command, Arc::clone(&options.stop))?, way);
    let parts = Parts {
        device: &mut *device,
        clock: &mut *clock,
        files: &raw,
        front: &mut *front,
        utc: &|_: f64| super::recover::now(),
        judge: &|trial: &Trial| verdict(&plan.study, trial),
    };
    let outcome = run(&plan, laid, &options, parts);
    drop(front); // the terminal is given back before anything is printed on it
    Ok(tell(&plan, &outcome?, &resume(root, command, plan.study.design.blinded), screen))
}

/// Whether a trial met the protocol. A blinded one is judged as one of a brake, which may stay where it was pushed to: what
/// is said must not tell its mode.
pub(super) fn verdict(study: &Study, trial: &Trial) -> Option<Verdict> {
    let environment = study.environment(&trial.meta.environment)?;
    let mode = study.mode(&trial.meta.mode).or(study.modes.first())?;
    let mut parameters = Parameters::of(study, environment, mode);
    if study.design.blinded {
        (parameters.uses_motor, parameters.uses_brake) = (false, true);
    }
    let compliance = compliance_of(trial, &parameters).ok()?;
    let unmet = compliance.unmet(study.design.trial_limit_s);
    let unmet = (!unmet.is_empty()).then(|| unmet.join("; "));
    Some(Verdict { trial: trial.meta.trial, unmet })
}

/// The simulated device's seed: that of the command line, else the one the session began with, so
/// that it goes on with the same device and person. A blinded session's seed stands nowhere, so its
/// device has one of its own.
fn device_seed(bench: &Bench, command: &AcquireArgs) -> u64 {
    if bench.study.design.blinded {
        return mixed(0, &["device", command.study.as_str()]);
    }
    let path = bench.layout.session(&command.participant, &command.session);
    command
        .seed
        .or_else(|| from_json::<SessionRecord>(&read_beside(&path).ok()??).ok()?.seed)
        .unwrap_or_else(|| seed_of(&bench.study))
}

/// What the experimenter sees and types into, or what acts in their place.
fn front(command: &AcquireArgs, stop: Arc<AtomicBool>) -> anyhow::Result<Box<dyn Front>> {
    if command.plain {
        let plain = Plain::new(BufReader::new(stdin()), stdout(), stop, !command.auto);
        return Ok(if command.auto { Box::new(Auto::new(plain)) } else { Box::new(plain) });
    }
    let terminal = Terminal::open(Look::from_env(command.ascii), stop)?;
    Ok(if command.auto { Box::new(Auto::new(terminal)) } else { Box::new(terminal) })
}

/// What became of the session, and how to go on with it.
fn tell(plan: &Plan, outcome: &Outcome, resume: &str, screen: &Screen) -> Exit {
    let Outcome { done, total, timing, .. } = outcome;
    if timing.ticks > 0 {
        screen.say(format!(
            "{} ticks, {} missed; late by {:.3} ms (median), {:.3} ms (99 %), {:.3} ms (most)",
            timing.ticks,
            timing.missed,
            timing.lateness.percentile_s(50.0) * 1e3,
            timing.lateness.percentile_s(99.0) * 1e3,
            timing.lateness.max_s() * 1e3,
        ));
    }
    let session = format!("{} {} {}", plan.layout.study(), plan.participant, plan.session);
    if outcome.stays_on {
        screen.warn("the board did not take its last 0 V and has no watchdog: a voltage may stay on; switch its supply off");
    }
    if done == total {
        let check = format!(". Check them with `zwidth verify {}`.", plan.study.id);
        let (check, exit) =
            if outcome.stays_on { ("", Exit::Failed) } else { (check.as_str(), Exit::Fine) };
        screen.say(format!("{session}: all {total} trials are done{check}"));
        return exit;
    }
    screen.warn(format!("{session}: {done} of {total} trials are done; go on with `{resume}`"));
    screen.warn(match (&outcome.gone, &outcome.stopped) {
        (Some(why), _) => format!("the terminal is gone ({why}); what was recorded is safe"),
        (None, Some(why)) => format!("it was stopped: {why}"),
        (None, None) if outcome.interrupted => {
            "a signal ended it; what was recorded is safe".to_owned()
        }
        (None, None) => return Exit::Partly,
    });
    Exit::Failed
}

/// The command that goes on with a session, with every option that it was begun with and needs again, as a
/// shell reads it. A blinded session needs no seed to go on, so its seed is not shown.
fn resume(root: &Path, command: &AcquireArgs, blinded: bool) -> String {
    let AcquireArgs { study, participant, session, device, .. } = command;
    let mut words = vec!["zwidth".to_owned(), "acquire".to_owned()];
    // What looks like an option comes last, where nothing is taken for one.
    let last = study.as_str().starts_with('-');
    words.extend((!last).then(|| study.to_string()));
    words.extend(shell_option("-p", "--participant", participant.as_str()));
    words.extend(shell_option("-s", "--session", session.as_str()));
    let markers: Vec<String> = command.markers.iter().map(ToString::to_string).collect();
    let options = [
        ("--device", (*device != DeviceSpec::Twin).then(|| device.to_string())),
        ("--rate", command.rate.map(|hz| hz.to_string())),
        ("--seed", command.seed.filter(|_| !blinded).map(|seed| seed.to_string())),
        ("--markers", (!markers.is_empty()).then(|| markers.join(","))),
        ("--by", command.by.as_ref().map(ToString::to_string)),
        ("--key", command.keys.folder.as_ref().map(|folder| folder.display().to_string())),
        ("--root", (root != Path::new("")).then(|| root.display().to_string())),
    ];
    for (name, value) in options {
        words.extend(value.into_iter().flat_map(|value| shell_option(name, name, &value)));
    }
    for stream in &command.wait_for {
        words.extend(shell_option("--wait-for", "--wait-for", &stream.to_string()));
    }
    let switches = [
        ("--plain", command.plain),
        ("--ascii", command.ascii),
        ("--auto", command.auto),
        ("--fast", command.fast),
        ("--no-watchdog", command.no_watchdog),
    ];
    words.extend(switches.into_iter().filter(|(_, on)| *on).map(|(name, _)| name.to_owned()));
    words.extend(last.then(|| ["--".to_owned(), study.to_string()]).into_iter().flatten());
    shell_line(words)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use crate::args::{Args, Command};
    use crate::commands::device::Keys;
    use clap::Parser as _;

    /// The words that a shell makes of a line.
    fn words(line: &str) -> Vec<String> {
        let output = std::process::Command::new("sh")
            .args(["-c", &format!("printf '%s\\0' {line}")])
            .output()
            .unwrap();
        assert!(output.status.success(), "{line}");
        let mut words: Vec<String> =
            String::from_utf8(output.stdout).unwrap().split('\0').map(str::to_owned).collect();
        words.pop();
        words
    }

    /// What the suggested command is read back as.
    fn read_back(root: &str, command: &AcquireArgs, blinded: bool) -> (String, AcquireArgs) {
        let line = resume(Path::new(root), command, blinded);
        let args = Args::try_parse_from(words(&line)).unwrap_or_else(|e| panic!("{line}: {e}"));
        let Command::Acquire(read) = args.command else { panic!("{line}") };
        (args.root.display().to_string(), read)
    }

    fn plain(study: &str) -> AcquireArgs {
        let typed = ["zwidth", "acquire", "-p", "P01", "-s", "S01", "--", study];
        let Command::Acquire(command) = Args::parse_from(typed).command else { panic!() };
        command
    }

    #[test]
    fn the_suggested_command_is_read_back_as_the_one_that_was_given() {
        let paths = ["a", "a b", "it's", "-x", "~/x", "$HOME`id`\"\\", "ä/new\nline", "*?[x]", "-"];
        let ids = ["P01", "-p", "--root", "_"];
        let ways = |command: &AcquireArgs, i: usize| {
            let path = paths[i % paths.len()];
            let id = ids[i % ids.len()];
            AcquireArgs {
                participant: id.parse().unwrap(),
                session: ids[(i / 2) % ids.len()].parse().unwrap(),
                device: match i % 3 {
                    0 => DeviceSpec::Twin,
                    _ => DeviceSpec::Playback(path.into()),
                },
                rate: [None, Some(120.0), Some(100.1 + 0.2), Some(1.0), Some(1e5)][i % 5],
                seed: [None, Some(u64::MAX), Some(0)][(i / 3) % 3],
                keys: Keys {
                    folder: (!i.is_multiple_of(4)).then(|| paths[(i / 4) % paths.len()].into()),
                },
                markers: ["tcp:[::1]:9000", "osc:localhost:57120", "board"][..i % 4]
                    .iter()
                    .map(|to| to.parse().unwrap())
                    .collect(),
                wait_for: ["EMG of the arm", "-x"][..i % 3]
                    .iter()
                    .map(|own| own.parse().unwrap())
                    .collect(),
                by: [None, Some("E1".parse().unwrap()), Some("-e".parse().unwrap())][(i / 4) % 3]
                    .clone(),
                plain: i & 1 > 0,
                ascii: i & 2 > 0,
                auto: i & 4 > 0,
                fast: i & 8 > 0,
                no_watchdog: i & 16 > 0,
                ..command.clone()
            }
        };
        for i in 0..96 {
            let command = ways(&plain(ids[(i / 5) % ids.len()]), i);
            let root = paths[(i / 7) % paths.len()];
            assert_eq!(read_back(root, &command, false), (root.to_owned(), command.clone()), "{i}");
            let unseeded = AcquireArgs { seed: None, ..command.clone() };
            assert_eq!(
                read_back(root, &command, true).1,
                unseeded,
                "a blinded session's seed is not shown"
            );
        }
    }

    #[test]
    fn what_was_not_given_is_not_suggested() {
        assert_eq!(
            resume(Path::new(""), &plain("small"), false),
            "zwidth acquire small -p P01 -s S01"
        );
        let accepts = AcquireArgs { accept_study_change: true, ..plain("small") };
        assert_eq!(
            resume(Path::new(""), &accepts, false),
            "zwidth acquire small -p P01 -s S01",
            "accepted once"
        );
    }
}
