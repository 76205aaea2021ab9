//! What recording needs: the study as it is to be run, the device, seeds, and the folder of seals.

use super::{join_findings, study};
use crate::text::read_beside;
use anyhow::{Context as _, anyhow, bail};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use zwidth_device::{Clock, RealClock, SimulatedClock, TwinParameters, stop_on_signals};
use zwidth_link::{Process, Settings};
use zwidth_plan::{ReadScript, read_program};
use zwidth_store::{Layout, MOST_BYTES, read_regular, read_study};
use zwidth_study::{Calibration, CalibrationFile, CalibrationOrigin, Control, Study, StudyId};

/// Where seals lie.
#[derive(Debug, Clone, PartialEq, Eq, clap::Args)]
pub(crate) struct Keys {
    /// Folder of the seals of blinded sessions [default: zwidth/ in the user's state folder]
    #[arg(long = "key", value_name = "DIR")]
    pub(crate) folder: Option<PathBuf>,
}

/// A study, ready to be recorded.
pub(crate) struct Bench {
    pub(crate) layout: Layout,
    pub(crate) study: Study,
    pub(crate) study_toml: Vec<u8>,
    pub(crate) calibration: Calibration,
    /// Where and when it was made, where its file says so.
    pub(crate) calibration_origin: Option<CalibrationOrigin>,
    pub(crate) twin: TwinParameters,
    pub(crate) rig: Option<Settings>,
}

/// The study, with this rate if there is one, and what two files beside its `study.toml` say where
/// they are there: `calibration.toml` (else the prototype's nominal one), `twin.toml`, the
/// simulated device's parameters, and `rig.toml`, what a host must be told of a rig.
pub(super) fn bench(root: &Path, id: StudyId, rate_hz: Option<f64>) -> anyhow::Result<Bench> {
    let layout = study(root, id)?;
    let mut study = read_study(&layout).map_err(|findings| join_findings(&findings))?;
    study.control.rate_hz = rate_hz.unwrap_or(study.control.rate_hz);
    let path = layout.raw().join("calibration.toml");
    let (calibration, calibration_origin) = match read_beside(&path)? {
        Some(text) => {
            let file = CalibrationFile::from_toml(&text)
                .map_err(|e| anyhow!("{}: {e}", path.display()))?;
            let origin = file.origin.clone();
            (file.calibration(), origin)
        }
        None => (Calibration::thesis(), None),
    };
    // As bytes: their hash goes into what is recorded.
    let study_toml = read_regular(&layout.study_toml(), MOST_BYTES)?;
    let twin = twin_parameters(&layout, study.device.lever_m)?;
    let rig = rig(&layout)?;
    Ok(Bench { layout, study, study_toml, calibration, calibration_origin, twin, rig })
}

/// What a host must be told of the study's rig.
pub(super) fn rig(layout: &Layout) -> anyhow::Result<Option<Settings>> {
    let path = layout.raw().join("rig.toml");
    let Some(text) = read_beside(&path)? else { return Ok(None) };
    let mut settings: Settings =
        toml::from_str(&text).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    settings.check().with_context(|| path.display().to_string())?;
    if let Some(program) = &mut settings.process {
        program.folder = layout.analysis();
    }
    Ok(Some(settings))
}

/// The program that is the study's device, and its files as they are read now, if it is one.
pub(crate) fn device_program<'a>(
    layout: &Layout,
    rig: Option<&'a Settings>,
) -> anyhow::Result<Option<(&'a Process, ReadScript)>> {
    /// No stage has such an id.
    const NAME: &str = "[process]";
    let Some(program) = rig.map(Settings::program).transpose()?.flatten() else { return Ok(None) };
    let Process { command, files, .. } = program;
    let script = read_program(layout.root(), layout.study(), NAME, command, files)?;
    Ok(Some((program, script)))
}

impl Bench {
    /// The same for a session that goes on by the study it began with, at this rate if there is
    /// one.
    pub(super) fn by(self, own: Study, rate_hz: Option<f64>) -> anyhow::Result<Self> {
        let rate_hz = rate_hz.unwrap_or(own.control.rate_hz);
        let study = Study { control: Control { rate_hz, ..own.control }, ..own };
        // Its lever may be another one than that of the present study.toml.
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
    let Some(text) = read_beside(&path)? else { return Ok(twin) };
    let named: toml::Table = text.parse().map_err(|e| anyhow!("{}: {e}", path.display()))?;
    // The device has one lever: two files that name it could disagree.
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

/// The machine's clock, or a simulated one.
pub(super) fn clock(fast: bool, seed: u64) -> Box<dyn Clock> {
    if fast { Box::new(SimulatedClock::new(seed)) } else { Box::new(RealClock::new()) }
}

/// A flag that Ctrl-C, SIGTERM, SIGHUP and SIGQUIT raise.
pub(super) fn raised_by_signals() -> anyhow::Result<Arc<AtomicBool>> {
    stop_on_signals()
        .context("cannot set up Ctrl-C, so a trial could not be stopped; start the program again")
}

/// The folder of seals: the one that is named, else `zwidth/` in the user's state folder (XDG:
/// `~/.local/state`). A user without one needs none for a study that is not `blinded`.
pub(super) fn keys(keys: &Keys, blinded: bool) -> anyhow::Result<PathBuf> {
    if let Some(folder) = &keys.folder {
        return Ok(folder.clone());
    }
    match state_folder() {
        Some(folder) => Ok(folder),
        None if !blinded => Ok(PathBuf::new()),
        None => bail!(
            "there is no state folder for this user; name a folder for the seals with --key DIR"
        ),
    }
}

/// `zwidth/` in the user's state folder (XDG), if this user has one.
pub(super) fn state_folder() -> Option<PathBuf> {
    let state = variable("XDG_STATE_HOME")
        .or_else(|| Some(variable("HOME")?.join(".local").join("state")))
        .or_else(|| variable("LOCALAPPDATA"));
    Some(state?.join("zwidth"))
}

/// The folder that an environment variable names.
fn variable(name: &str) -> Option<PathBuf> {
    // One that is set to nothing counts as not set (XDG Base Directory Specification).
    std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// 32 random bytes of the system's.
pub(super) fn secret() -> anyhow::Result<[u8; 32]> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)
        .map_err(|e| anyhow!("the system gives no random numbers: {e}; try again"))?;
    Ok(bytes)
}
