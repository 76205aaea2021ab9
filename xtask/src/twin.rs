//! `raw/thesis-twin`: the study that comes along, made by the program itself from a seed.

use crate::soak;
use anyhow::{Context as _, bail};
use std::path::Path;
use std::process::Command;

/// One participant, one session, at the thesis' 120 Hz.
const ARGUMENTS: [&str; 10] = [
    "twin",
    "thesis-twin",
    "--participants",
    "1",
    "--sessions",
    "1",
    "--seed",
    "1",
    "--rate",
    "120",
];

/// Writes `raw/thesis-twin` under `root`, replacing what stands there.
pub(crate) fn write(root: &Path) -> anyhow::Result<()> {
    let program = soak::program()?;
    let folder = root.join("raw/thesis-twin");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).context("cannot remove the old raw/thesis-twin")?;
    }
    let status = Command::new(program).arg("--root").arg(root).args(ARGUMENTS).status()?;
    if !status.success() {
        bail!("the study could not be made");
    }
    Ok(())
}
