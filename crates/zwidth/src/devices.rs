//! The devices by the names that they have on the command line: the one list.

use crate::commands::consent::device_may_start;
use crate::commands::device::{Bench, device_program};
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use jiff::Timestamp;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::SystemTime;
use zwidth_acquire::number;
use zwidth_device::check::{Step, steps};
use zwidth_device::{Device, Person, Playback, Twin};
use zwidth_store::{Samples, Signal, hex_blake3, read_trial};
use zwidth_study::{Flags, ParticipantId, Sample, SessionId, Voltages, command_line};

/// How devices are written on the command line.
pub(crate) const DEVICES: &str = "twin|rig[:PORT]|playback:FILE";

/// A device by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DeviceSpec {
    /// The simulated device.
    Twin,
    /// A board at a serial port: the one named, else that of `rig.toml`.
    Rig(Option<PathBuf>),
    /// A recorded trial.
    Playback(PathBuf),
}

impl fmt::Display for DeviceSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Twin => f.write_str("twin"),
            Self::Rig(None) => f.write_str("rig"),
            Self::Rig(Some(port)) => write!(f, "rig:{}", port.display()),
            Self::Playback(file) => write!(f, "playback:{}", file.display()),
        }
    }
}

impl FromStr for DeviceSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            None if text == "twin" => Ok(Self::Twin),
            None if text == "rig" => Ok(Self::Rig(None)),
            Some(("rig", port)) if !port.is_empty() => Ok(Self::Rig(Some(port.into()))),
            Some(("playback", file)) if !file.is_empty() => Ok(Self::Playback(file.into())),
            _ => Err(format!("it must be {DEVICES}")),
        }
    }
}

/// Refuses to start a program that is the study's device, if this person has not allowed it: a study
/// may come from anybody.
fn check_allowed(bench: &Bench) -> anyhow::Result<()> {
    let Some((program, script)) = device_program(&bench.layout, bench.rig.as_ref())? else {
        return Ok(());
    };
    if device_may_start(&bench.layout, &script.digest)? {
        return Ok(());
    }
    let id = bench.layout.study();
    bail!(
        "the device of {id} is a program that you have not allowed, or that has changed since: {}; look at it, \
         then `zwidth allow {id}`",
        command_line(&program.command)
    );
}

/// The device of a study, for a session; `seed` is what the simulated one's participant and noise
/// are drawn from.
pub(crate) fn open(
    spec: &DeviceSpec,
    bench: &Bench,
    seed: u64,
    participant: &ParticipantId,
    session: &SessionId,
) -> anyhow::Result<Box<dyn Device>> {
    let study = &bench.study;
    match spec {
        DeviceSpec::Twin => Ok(Box::new(twin(bench, seed, participant, session, false)?)),
        DeviceSpec::Rig(port) => {
            let settings = bench.rig.as_ref().context(
                "a rig needs its load cell's scale: write newtons_per_count = … into rig.toml beside study.toml (docs/rig.md)",
            )?;
            settings.check_loop(study.control.rate_hz)?;
            check_allowed(bench)?;
            let environments = study.environments.iter().map(|e| e.id.clone()).collect();
            Ok(zwidth_link::open(port.as_deref(), settings, environments)?)
        }
        DeviceSpec::Playback(path) => {
            let trial = read_trial(path, Signal::all())?;
            let stop_rad = study.device.theta_min_rad;
            let stop_rad = stop_rad.context("study.toml: device.theta_min_deg is missing")?;
            Ok(Box::new(Playback::new(rows(path, &trial.samples)?, stop_rad)?))
        }
    }
}

/// Warns of a rig that is about to be used with another device's calibration, or an old one: forces
/// would be wrong. `name` is what the device calls itself.
pub(crate) fn warn_of_calibration(bench: &Bench, device: &DeviceSpec, name: &str, screen: &Screen) {
    if !matches!(device, DeviceSpec::Rig(_)) {
        return;
    }
    let path = bench.layout.raw().join("calibration.toml");
    let file = path.display();
    if !path.exists() {
        screen.warn(format!(
            "{file} is missing, so the nominal calibration of the thesis' prototype is used: forces of another rig come out \
             wrong; make one with `zwidth characterise` (docs/session.md)"
        ));
        return;
    }
    // One that was imported or written by hand does not say where it comes from.
    let Some(origin) = &bench.calibration_origin else { return };
    if origin.device != name {
        screen.warn(format!(
            "{file} was made with {}, and this is {name}: forces may come out wrong; characterise this rig (docs/session.md)",
            origin.device
        ));
    }
    let days = days_since(&origin.utc);
    let most = bench.rig.as_ref().map_or(f64::INFINITY, |rig| rig.calibration_days);
    if days.is_none_or(|days| days > most) {
        let age = days.map_or("of an unknown day".to_owned(), |days| format!("{days:.0} days old"));
        screen.warn(format!(
            "{file} is {age}, and rig.toml allows {most} days (calibration_days): characterise the rig again"
        ));
    }
}

/// How many days ago a moment was, RFC 3339; none of what is no moment.
pub(crate) fn days_since(utc: &str) -> Option<f64> {
    const DAY_S: f64 = 86_400.0;
    let then: Timestamp = utc.parse().ok()?;
    let now = Timestamp::try_from(SystemTime::now()).unwrap_or(Timestamp::MAX);
    Some(now.duration_since(then).as_secs_f64() / DAY_S)
}

/// Whether a device's lever needs a hand to get to its stop.
pub(crate) fn is_homed_by_hand(spec: &DeviceSpec) -> bool {
    matches!(spec, DeviceSpec::Rig(_))
}

/// The simulated device with a participant. One seed: one device, the same person in each session
/// with what a day brings, other noise. An untidy person gives trials up and leaves questions open.
pub(crate) fn twin(
    bench: &Bench,
    seed: u64,
    participant: &ParticipantId,
    session: &SessionId,
    untidy: bool,
) -> anyhow::Result<Twin> {
    let [participant_id, session_id] = [participant.as_str(), session.as_str()];
    let lasting = Person::draw(mixed(seed, &["person", participant_id]));
    let conditions = u32::try_from(bench.study.conditions().len()).unwrap_or(u32::MAX);
    let design = &bench.study.design;
    let trials = conditions.saturating_mul(design.repeats).saturating_add(design.familiarisation);
    // If the sessions before this one were whole; none before one without a number.
    let sessions_before = number(session_id).unwrap_or(1).saturating_sub(1);
    let day_seed = mixed(seed, &["day", participant_id, session_id]);
    let person = lasting.in_session(day_seed, sessions_before.saturating_mul(trials));
    let person = if untidy { person.untidy() } else { person };
    Ok(Twin::new(bench.twin.clone(), person, mixed(seed, &["board", participant_id, session_id]))?)
}

/// A seed from a seed and what it is for.
pub(crate) fn mixed(seed: u64, purpose: &[&str]) -> u64 {
    /// Hexadecimal digits of 64 bits.
    const DIGITS: usize = 16;
    let text = format!("{seed}\n{}", purpose.join("\n"));
    u64::from_str_radix(&hex_blake3(text.as_bytes())[..DIGITS], 16).unwrap_or(seed)
}

/// Whether the device goes through a step of the check by itself: the simulated one has its
/// participant, a recording has nothing to check, and neither has a mass to hang on.
pub(crate) fn checks_itself(spec: &DeviceSpec) -> fn(Step) -> bool {
    match spec {
        DeviceSpec::Twin => |step| !matches!(step, Step::Load(_)),
        // At rest there is nothing for a hand to do.
        DeviceSpec::Rig(_) => |step| step == Step::Rest,
        DeviceSpec::Playback(_) => |_| false,
    }
}

/// The steps of the check that a device goes through by itself.
pub(crate) fn steps_alone(spec: &DeviceSpec) -> Vec<Step> {
    steps(None).into_iter().filter(|step| checks_itself(spec)(*step)).collect()
}

/// A trial's rows.
fn rows(path: &Path, samples: &Samples) -> anyhow::Result<Vec<Sample>> {
    let recorded = |signal: Signal| {
        samples.get(signal).ok_or_else(|| {
            anyhow!("{}: {signal:?} was not recorded; choose a trial that has it", path.display())
        })
    };
    let t = recorded(Signal::Time)?;
    let theta = recorded(Signal::Theta)?;
    let force = recorded(Signal::ForceEx)?;
    let rows = (0..t.len()).map(|i| Sample {
        t_s: t[i],
        t_device_s: samples.get(Signal::DeviceTime).map(|v| v[i]),
        theta_rad: theta[i],
        theta_dot_rad_s: samples.get(Signal::ThetaDot).map_or(0.0, |v| v[i]),
        force_ex_n: force[i],
        voltages: Voltages::OFF,
        force_age_s: samples.get(Signal::ForceAge).map(|v| v[i]),
        theta_raw: None,
        force_cmd_n: 0.0,
        flags: Flags::default(),
        extra: zwidth_study::Extra::default(),
    });
    Ok(rows.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_is_named_by_its_kind_and_what_belongs_to_it() {
        assert_eq!("twin".parse(), Ok(DeviceSpec::Twin));
        assert_eq!("playback:a:b".parse(), Ok(DeviceSpec::Playback("a:b".into())));
        assert_eq!("rig".parse(), Ok(DeviceSpec::Rig(None)));
        assert_eq!("rig:/dev/x".parse(), Ok(DeviceSpec::Rig(Some("/dev/x".into()))));
        for bad in ["", "twin:1", "playback", "playback:", "rig:", "rigs", "Twin"] {
            assert!(bad.parse::<DeviceSpec>().unwrap_err().contains("playback:FILE"), "{bad}");
        }
    }
}
