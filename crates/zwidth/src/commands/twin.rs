//! `zwidth twin`: a whole study on the simulated device, faster than real time. The same seed gives
//! the same bytes, on any machine and any number of threads.

use super::acquire::verdict;
use super::characterise::simulated_sweep;
use super::device::{Bench, bench, keys};
use super::recover::lock;
use crate::commands::device::Keys;
use crate::devices::{DeviceSpec, mixed, steps_alone, twin as device};
use crate::exit::Exit;
use crate::limits::{MOST_PARTICIPANTS, MOST_SCALE, MOST_SESSIONS, rate};
use crate::screen::Screen;
use crate::text::read_beside;
use anyhow::{Context as _, bail, ensure};
use jiff::{SignedDuration, Timestamp};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_acquire::{
    Auto, Careful, Front, Nobody, Options, Outcome, Parts, Plan, Session, Unsynced, number, run,
};
use zwidth_device::{Device as _, SimulatedClock};
use zwidth_store::{
    Files as _, Layout, Raw, RealFiles, check_study_id, hex_blake3, log_sweeps, sweep_bytes,
    write_new,
};
use zwidth_study::{ActuatorKind, ParticipantId, SessionId, StudyId, template};

#[derive(Debug, clap::Args)]
pub(crate) struct TwinArgs {
    /// The study; it is made with `zwidth new` if it is not there
    pub(crate) study: StudyId,
    /// Number of participants
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=MOST_PARTICIPANTS))]
    pub(crate) participants: u32,
    /// Sessions of each
    #[arg(long, value_name = "M", default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=MOST_SESSIONS))]
    pub(crate) sessions: u32,
    /// Seed of participants, devices and order: one seed, the same bytes
    #[arg(long, value_name = "K", default_value_t = 1)]
    pub(crate) seed: u64,
    /// Rate of the control loop, Hz [default: the study's]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    pub(crate) rate: Option<f64>,
    /// So many times the repeats of the design, in a study that is made: for data of any size
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=MOST_SCALE))]
    pub(crate) scale: u32,
    /// Participants now and then give a trial up, which is then done again, or leave a question
    /// open
    #[arg(long)]
    pub(crate) untidy: bool,
    #[command(flatten)]
    pub(crate) keys: Keys,
}

/// Version of what this command makes of a seed. Another version gives other bytes, and another
/// software in the files.
const VERSION: u32 = 4;
/// The software, as records, trials and sweeps of a simulated study name it.
const SOFTWARE: &str = "zwidth twin 4";
/// Sweeps of each actuator (thesis App. D).
const SWEEPS: [(ActuatorKind, u32); 2] = [(ActuatorKind::Motor, 15), (ActuatorKind::Brake, 30)];
/// When the calendar of a simulated study begins, s since 1970: 1 January 2026, 09:00 UTC. Session
/// n of a participant is n weeks later, participants a day apart; all later by as many years as
/// there were versions before.
const EPOCH_S: i64 = 1_767_258_000;
const DAY_S: i64 = 86_400;
const WEEK_DAYS: i64 = 7;
const YEAR_DAYS: i64 = 366;

pub(crate) fn twin(root: &Path, command: &TwinArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let layout = Layout::new(root, command.study.clone());
    make_study(&layout, command)?;
    let bench = bench(root, command.study.clone(), command.rate)?;
    let lock = lock(&bench.layout, "zwidth twin")?;
    // P01 S01, P01 S02, …
    let mut sessions: Vec<(ParticipantId, SessionId)> = Vec::new();
    for participant in 1..=command.participants {
        for session in 1..=command.sessions {
            let participant = format!("P{participant:02}").parse()?;
            sessions.push((participant, format!("S{session:02}").parse()?));
        }
    }
    let mut paths = sessions.iter().map(|(p, s)| bench.layout.session(p, s));
    let sweeps = bench.layout.sweeps();
    if let Some(path) = paths.find(|p| p.exists()).or_else(|| sweeps.exists().then_some(sweeps)) {
        bail!(
            "{} exists already, and recorded data never changes; choose another study, or, if an interrupted `zwidth \
             twin` left it behind, remove all of {} if nothing else was recorded there",
            path.display(),
            bench.layout.raw().display()
        );
    }
    let keys = keys(&command.keys, bench.study.design.blinded)?;
    // Without waiting for the disk: what a power cut spoils can be simulated again.
    let raw = Raw::adds(&Unsynced, &bench.layout, &lock).with_vault(&keys);
    let bar = screen.bar(sessions.len());
    let outcomes: Vec<anyhow::Result<Outcome>> = sessions
        .par_iter()
        .map(|(participant, session)| {
            let outcome = one(&bench, &raw, command, participant, session, &keys);
            bar.inc(1);
            outcome.with_context(|| format!("{participant} {session}"))
        })
        .collect();
    let swept = sweep_all(&bench, &raw, command.seed);
    // Empty, unless a trial could not be made a file: `verify` tells of that.
    let _ = raw.remove_folder(&bench.layout.journals());
    bar.finish_and_clear();
    let outcome = tell(command, &sessions, outcomes, screen);
    outcome.and_then(|exit| swept.map(|()| exit)).with_context(|| {
        format!(
            "{} is not whole; if nothing but this simulation is in {}, remove all of it before `zwidth twin` makes it again",
            command.study,
            bench.layout.raw().display()
        )
    })
}

/// Writes `study.toml` where there is none.
fn make_study(layout: &Layout, command: &TwinArgs) -> anyhow::Result<()> {
    let path = layout.study_toml();
    if path.exists() && command.scale <= 1 {
        return Ok(());
    }
    let repeats = 6_u32.checked_mul(command.scale).with_context(|| {
        format!("--scale {} is too large; the largest is {MOST_SCALE}", command.scale)
    })?;
    // In the text, not in a parsed study, so that the template's comments stay.
    let mut text =
        template(layout.study()).replace("\nrepeats = 6\n", &format!("\nrepeats = {repeats}\n"));
    if let Some(rate_hz) = command.rate {
        // `{:?}`, because TOML takes a number without a decimal point for an integer.
        text = text.replace("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {rate_hz:?}\n"));
    }
    if path.exists() {
        // One that says the same is of a simulation that was interrupted.
        ensure!(
            read_beside(&path)?.is_some_and(|existing| existing == text),
            "--scale sets the repeats of a new study, and {} exists already; edit its repeats instead",
            path.display()
        );
        return Ok(());
    }
    check_study_id(&RealFiles, layout)?;
    Ok(write_new(&Raw::new_study(&RealFiles, layout), &path, text.as_bytes())?)
}

/// One session by the simulated participant.
fn one(
    bench: &Bench,
    raw: &Raw,
    command: &TwinArgs,
    participant: &ParticipantId,
    session: &SessionId,
    keys: &Path,
) -> anyhow::Result<Outcome> {
    let seed = command.seed;
    let mut device = device(bench, seed, participant, session, command.untidy)?;
    let plan = Plan {
        layout: bench.layout.clone(),
        study: bench.study.clone(),
        study_toml: bench.study_toml.clone(),
        accept_study_change: false,
        participant: participant.clone(),
        session: session.clone(),
        calibration: bench.calibration.clone(),
        software: SOFTWARE.to_owned(),
        rate_hz: bench.study.control.rate_hz.min(device.capabilities().rate_hz),
        seed: Some(seed),
        keys: PathBuf::from(keys),
        secret: secret(seed, participant, session)?,
    };
    let steps = steps_alone(&DeviceSpec::Twin);
    let options = Options { answers: true, steps, ..Options::default() };
    let laid = Session::open(&plan, device.capabilities(), raw)?;
    let mut clock =
        SimulatedClock::new(mixed(seed, &["clock", participant.as_str(), session.as_str()]));
    let begin = begin(participant, session)?;
    let mut auto = Auto::new(Nobody);
    let mut careful = Careful::new(Nobody);
    let front: &mut dyn Front = if command.untidy { &mut careful } else { &mut auto };
    let parts = Parts {
        device: &mut device,
        clock: &mut clock,
        files: raw,
        front,
        utc: &|now_s: f64| later(begin, now_s),
        judge: &|trial| verdict(&plan.study, trial),
    };
    Ok(run(&plan, laid, &options, parts)?)
}

/// A simulated study's secret follows from its seed, so that its bytes do.
fn secret(seed: u64, participant: &ParticipantId, session: &SessionId) -> anyhow::Result<[u8; 32]> {
    let hex = hex_blake3(format!("secret {seed} {participant} {session}").as_bytes());
    let mut secret = [0; 32];
    for (byte, digits) in secret.iter_mut().zip(hex.as_bytes().chunks(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(digits)?, 16)?;
    }
    Ok(secret)
}

/// When a simulated session begins: no clock is looked at.
fn begin(participant: &ParticipantId, session: &SessionId) -> anyhow::Result<Timestamp> {
    // Each id of a simulated study has a number.
    let [participant, session] =
        [participant.as_str(), session.as_str()].map(|id| i64::from(number(id).unwrap_or(1)) - 1);
    let days = participant + WEEK_DAYS * session + YEAR_DAYS * i64::from(VERSION - 1);
    Ok(Timestamp::from_second(EPOCH_S + DAY_S * days)?)
}

fn later(begin: Timestamp, now_s: f64) -> String {
    // To the millisecond: what a person reads; the samples have their own time.
    let since = SignedDuration::from_millis((now_s * 1e3) as i64);
    begin.checked_add(since).unwrap_or(begin).to_string()
}

fn sweep_all(bench: &Bench, raw: &Raw, seed: u64) -> anyhow::Result<()> {
    let all: Vec<(ActuatorKind, u32)> = SWEEPS
        .iter()
        .flat_map(|(actuator, n)| (1..=*n).map(|number| (*actuator, number)))
        .collect();
    let sweeps = all.par_iter().map(|(actuator, number)| {
        let sweep = simulated_sweep(bench, *actuator, seed, *number, SOFTWARE)?;
        let path = bench.layout.sweep(&sweep.actuator, *number);
        let bytes = sweep_bytes(&sweep, &path)?;
        write_new(raw, &path, &bytes)?;
        Ok((sweep.actuator, *number, hex_blake3(&bytes)))
    });
    let sweeps = sweeps.collect::<anyhow::Result<Vec<_>>>()?;
    // In one go after all are written: the order of threads must not show in the log.
    let utc = Timestamp::from_second(EPOCH_S)?.to_string();
    Ok(log_sweeps(raw, &bench.layout, &utc, &sweeps)?)
}

/// What was made, and what was not.
fn tell(
    command: &TwinArgs,
    sessions: &[(ParticipantId, SessionId)],
    outcomes: Vec<anyhow::Result<Outcome>>,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let mut trials = 0;
    let mut exit = Exit::Fine;
    for ((participant, session), outcome) in sessions.iter().zip(outcomes) {
        let outcome = outcome?;
        trials += outcome.done;
        if let Some(why) = outcome.stopped {
            screen.warn(format!(
                "{participant} {session} stopped at {} of {} trials: {why}",
                outcome.done, outcome.total
            ));
            exit = Exit::Partly;
        }
    }
    screen.say(format!(
        "{}: {} sessions, {trials} trials, 15 motor and 30 brake sweeps; look at them with `zwidth run {}`",
        command.study,
        sessions.len(),
        command.study
    ));
    Ok(exit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::{MOST_PARTICIPANTS, MOST_SESSIONS};

    #[test]
    fn the_last_session_of_the_largest_study_has_a_date() {
        let (participant, session) =
            (format!("P{MOST_PARTICIPANTS}").parse().unwrap(), format!("S{MOST_SESSIONS}"));
        let begin = begin(&participant, &session.parse().unwrap()).unwrap();
        assert!(later(begin, 86_400.0).starts_with("20"), "{begin}");
    }

    #[test]
    fn a_time_past_the_last_date_is_the_beginning() {
        let millisecond_before = Timestamp::MAX - SignedDuration::from_millis(1);
        for begin in [Timestamp::MIN, Timestamp::UNIX_EPOCH, millisecond_before, Timestamp::MAX] {
            for now_s in [0.0, 0.001, 1e6, 1e12, f64::MAX, f64::INFINITY, f64::NAN, -1e300] {
                let text = later(begin, now_s);
                assert!(text.ends_with('Z') && text.parse::<Timestamp>().is_ok(), "{text}");
            }
        }
    }
}
