//! What recording needs: the study as it is to be run, the device, seeds, and the folder of seals.

use super::{study, together};
use crate::args::{DeviceSpec, Keys};
use crate::text::beside;
use anyhow::{Context as _, anyhow, bail};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zwidth_device::check::Step;
use zwidth_device::{
    Clock, Device, Person, Playback, RealClock, SimulatedClock, Twin, TwinParameters,
    stop_on_signals,
};
use zwidth_store::{
    Layout, MOST_BYTES, Samples, Signal, hex_blake3, read_regular, read_study, read_trial,
};
use zwidth_study::{
    Calibration, Control, Flags, ParticipantId, Sample, SessionId, Study, StudyId, Voltages,
};

/// A study, ready to be recorded.
pub(super) struct Bench {
    pub(super) layout: Layout,
    pub(super) study: Study,
    pub(super) study_toml: Vec<u8>,
    pub(super) calibration: Calibration,
    pub(super) twin: TwinParameters,
}

/// The study, with the rate asked for, and what two files beside its `study.toml` say where they
/// are there: `calibration.toml` (else the prototype's nominal one) and `twin.toml`, the simulated
/// device's parameters.
pub(super) fn bench(root: &Path, id: StudyId, rate_hz: Option<f64>) -> anyhow::Result<Bench> {
    let layout = study(root, id)?;
    let mut study = read_study(&layout).map_err(|findings| together(&findings))?;
    study.control.rate_hz = rate_hz.unwrap_or(study.control.rate_hz);
    let path = layout.raw().join("calibration.toml");
    let calibration = match beside(&path)? {
        Some(text) => {
            Calibration::from_toml(&text).map_err(|e| anyhow!("{}: {e}", path.display()))?
        }
        None => Calibration::thesis(),
    };
    let study_toml = read_regular(&layout.study_toml(), MOST_BYTES)?;
    let twin = twin_parameters(&layout, study.device.lever_m)?;
    Ok(Bench { layout, study, study_toml, calibration, twin })
}

impl Bench {
    /// The same for a session that goes on by the study it began with, at the rate asked for.
    pub(super) fn by(self, own: Study, rate_hz: Option<f64>) -> anyhow::Result<Self> {
        let rate_hz = rate_hz.unwrap_or(own.control.rate_hz);
        let study = Study { control: Control { rate_hz, ..own.control }, ..own };
        let twin = twin_parameters(&self.layout, study.device.lever_m)?;
        Ok(Self { study, twin, ..self })
    }
}

/// The simulated device's parameters: the defaults, with the study's lever and what
/// `raw/<study>/twin.toml` names.
fn twin_parameters(layout: &Layout, lever_m: Option<f64>) -> anyhow::Result<TwinParameters> {
    let path = layout.raw().join("twin.toml");
    let mut twin = TwinParameters::default();
    twin.lever_m = lever_m.unwrap_or(twin.lever_m);
    let Some(text) = beside(&path)? else { return Ok(twin) };
    let named: toml::Table = text.parse().map_err(|e| anyhow!("{}: {e}", path.display()))?;
    if named.contains_key("lever_m") {
        bail!(
            "{}: lever_m belongs in study.toml, as device.lever_m; take it out here",
            path.display()
        );
    }
    let read: TwinParameters =
        toml::from_str(&text).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    let twin = TwinParameters { lever_m: twin.lever_m, ..read };
    twin.check().with_context(|| path.display().to_string())?;
    Ok(twin)
}

/// The device, and who is at it where it is the simulated one.
pub(super) fn open(
    spec: &DeviceSpec,
    bench: &Bench,
    seed: u64,
    participant: &ParticipantId,
    session: &SessionId,
) -> anyhow::Result<Box<dyn Device>> {
    match spec {
        DeviceSpec::Twin => Ok(Box::new(twin(&bench.twin, seed, participant, session)?)),
        DeviceSpec::Playback(path) => {
            let trial = read_trial(path, Signal::all())?;
            let stop_rad = bench
                .study
                .device
                .theta_min_rad
                .context("study.toml: device.theta_min_deg is missing")?;
            Ok(Box::new(Playback::new(rows(path, &trial.samples)?, stop_rad)?))
        }
    }
}

/// The simulated device with a participant. One seed: one device, the same person in each session,
/// other noise.
pub(super) fn twin(
    parameters: &TwinParameters,
    seed: u64,
    participant: &ParticipantId,
    session: &SessionId,
) -> anyhow::Result<Twin> {
    let person = Person::draw(mixed(seed, &["person", participant.as_str()]));
    let board = mixed(seed, &["board", participant.as_str(), session.as_str()]);
    Ok(Twin::new(parameters.clone(), person, board)?)
}

/// A seed from a seed and what it is for.
pub(super) fn mixed(seed: u64, purpose: &[&str]) -> u64 {
    /// Hexadecimal digits of 64 bits.
    const DIGITS: usize = 16;
    let text = format!("{seed}\n{}", purpose.join("\n"));
    u64::from_str_radix(&hex_blake3(text.as_bytes())[..DIGITS], 16).unwrap_or(seed)
}

/// Whether the device goes through a step of the check by itself: the simulated one has its
/// participant, a recording has nothing to check, and neither has a mass to hang on.
pub(super) fn checks_itself(spec: &DeviceSpec) -> fn(Step) -> bool {
    match spec {
        DeviceSpec::Twin => |step| !matches!(step, Step::Load(_)),
        DeviceSpec::Playback(_) => |_| false,
    }
}

/// The machine's clock, or a simulated one.
pub(super) fn clock(fast: bool, seed: u64) -> Box<dyn Clock> {
    if fast { Box::new(SimulatedClock::new(seed)) } else { Box::new(RealClock::new()) }
}

/// A flag that Ctrl-C, SIGTERM, SIGHUP and SIGQUIT raise.
pub(super) fn raised_by_signals() -> anyhow::Result<Arc<AtomicBool>> {
    stop_on_signals().context("cannot take signals, so nothing would stop a trial; try again")
}

/// The folder of seals: the one asked for, else `zwidth/` in the user's state folder (XDG:
/// `~/.local/state`). A user without one needs none for a study that is not `blinded`.
pub(super) fn keys(asked: &Keys, blinded: bool) -> anyhow::Result<PathBuf> {
    let variable = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let home = || variable("HOME").map(|home| home.join(".local").join("state"));
    let state = || variable("XDG_STATE_HOME").or_else(home).or_else(|| variable("LOCALAPPDATA"));
    let folder = asked.folder.clone().or_else(|| state().map(|state| state.join("zwidth")));
    let folder = folder.or_else(|| (!blinded).then(PathBuf::new));
    folder.context(
        "there is no state folder for this user; name a folder for the seals with --key DIR",
    )
}

/// 32 random bytes of the system's.
pub(super) fn secret() -> anyhow::Result<[u8; 32]> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)
        .map_err(|e| anyhow!("the system gives no random numbers: {e}; try again"))?;
    Ok(bytes)
}

/// A trial's rows.
fn rows(path: &Path, samples: &Samples) -> anyhow::Result<Vec<Sample>> {
    let needed = |signal: Signal| {
        let missing = || {
            anyhow!("{}: {signal:?} was not recorded; choose a trial that has it", path.display())
        };
        samples.get(signal).ok_or_else(missing)
    };
    let or_zero = |signal: Signal, i: usize| samples.get(signal).map_or(0.0, |v| v[i]);
    let (t, theta, force) =
        (needed(Signal::Time)?, needed(Signal::Theta)?, needed(Signal::ForceEx)?);
    let row = |i: usize| Sample {
        t_s: t[i],
        t_device_s: samples.get(Signal::DeviceTime).map(|v| v[i]),
        theta_rad: theta[i],
        theta_dot_rad_s: or_zero(Signal::ThetaDot, i),
        force_ex_n: force[i],
        voltages: Voltages::OFF,
        force_age_s: samples.get(Signal::ForceAge).map(|v| v[i]),
        theta_raw: None,
        force_cmd_n: 0.0,
        flags: Flags::default(),
        extra: zwidth_study::Extra::default(),
    };
    Ok((0..t.len()).map(row).collect())
}
