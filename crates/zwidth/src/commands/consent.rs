//! Which programs of studies a person has allowed: a file for each study in the user's own state
//! folder, so that a study that somebody else made cannot bring it along.

use super::device::state_folder;
use anyhow::{Context as _, anyhow, bail};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_runner::Scripts;
use zwidth_store::{
    Files as _, Layout, RealFiles, StoreError, hex_blake3, read_regular, real_path, write_private,
};
use zwidth_study::StageId;

/// What was allowed of a study.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Consent {
    /// The folder that holds the study's data.
    pub(super) root: String,
    /// The study's id.
    pub(super) study: String,
    /// The digest of each stage that was allowed ([`zwidth_plan::ReadScript`]).
    pub(super) stages: BTreeMap<StageId, String>,
    /// That of the program that is its device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) device: Option<String>,
}

/// No file of ours has more bytes.
const MOST_BYTES: u64 = 1 << 20;
/// Digits of the names of files.
const DIGITS: usize = 32;

/// The folder that holds a study's data, as it is called whatever way leads to it.
pub(super) fn place(layout: &Layout) -> anyhow::Result<PathBuf> {
    let root = layout.root();
    let root = if root.as_os_str().is_empty() { Path::new(".") } else { root };
    real_path(root).with_context(|| format!("cannot find {}", root.display()))
}

/// Where the consent to a study is kept.
fn file(layout: &Layout) -> anyhow::Result<PathBuf> {
    let folder = state_folder().ok_or_else(|| {
        anyhow!("there is no state folder for this user, and so nothing is kept; run once with --allow-scripts")
    })?;
    let key = format!("{}\n{}", place(layout)?.display(), layout.study());
    let name = &hex_blake3(key.as_bytes())[..DIGITS];
    Ok(folder.join("allowed").join(format!("{name}.json")))
}

/// The programs of a study that a run may start. A user without a state folder has allowed none.
pub(super) fn scripts(layout: &Layout) -> anyhow::Result<Scripts> {
    let allowed = consent(layout)?;
    let digests = |consent: Consent| Scripts::Allowed(consent.stages.into_values().collect());
    Ok(allowed.map_or(Scripts::None, digests))
}

/// Whether the program that is a study's device, with that digest, may be started.
pub(crate) fn device_may_start(layout: &Layout, digest: &str) -> anyhow::Result<bool> {
    Ok(consent(layout)?.is_some_and(|consent| consent.device.as_deref() == Some(digest)))
}

/// What was allowed of a study.
fn consent(layout: &Layout) -> anyhow::Result<Option<Consent>> {
    if state_folder().is_none() {
        return Ok(None);
    }
    let file = file(layout)?;
    if RealFiles.kind(&file).is_none() {
        return Ok(None);
    }
    let bytes = read_regular(&file, MOST_BYTES).map_err(|e| StoreError::io(&file, "read", &e))?;
    let Ok(consent) = serde_json::from_slice::<Consent>(&bytes) else {
        let id = layout.study();
        bail!("{} cannot be read; remove it, then `zwidth allow {id}`", file.display());
    };
    Ok(Some(consent))
}

/// Keeps what was allowed, in place of what was before.
pub(super) fn keep(
    layout: &Layout,
    stages: BTreeMap<StageId, String>,
    device: Option<String>,
) -> anyhow::Result<()> {
    let file = file(layout)?;
    withdraw(layout)?;
    let root = place(layout)?.to_string_lossy().into_owned();
    let consent = Consent { root, study: layout.study().to_string(), stages, device };
    Ok(write_private(&RealFiles, &file, &serde_json::to_vec_pretty(&consent)?)?)
}

/// Takes back what was allowed; whether anything was.
pub(super) fn withdraw(layout: &Layout) -> anyhow::Result<bool> {
    let file = file(layout)?;
    if RealFiles.kind(&file).is_none() {
        return Ok(false);
    }
    RealFiles.remove(&file).map_err(|e| StoreError::io(&file, "remove", &e))?;
    Ok(true)
}
