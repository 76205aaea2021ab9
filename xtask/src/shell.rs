//! What chores share: where things lie, folders, and the programs that they run.

use anyhow::{Context as _, ensure};
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use zwidth_store::file_blake3;

/// The folder of builds.
pub(crate) fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from)
}

/// A folder for what a chore makes, beside the system's other temporary ones.
pub(crate) fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("zwidth-soak-{name}-{}", std::process::id()))
}

/// The program, built for release, as users run it.
pub(crate) fn program() -> anyhow::Result<PathBuf> {
    cargo("build --quiet --release --package zwidth", &[], &[], "the program does not build")?;
    let built = target().join("release/zwidth").canonicalize();
    built.context("the built program is not where cargo puts it")
}

/// Runs cargo with the words of a line and some more, and with these settings in its environment;
/// fails with `why` where cargo does.
pub(crate) fn cargo(
    line: &str,
    more: &[&str],
    settings: &[(&str, String)],
    why: &str,
) -> anyhow::Result<()> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| env!("CARGO").into());
    let mut command = Command::new(cargo);
    command.args(line.split(' ')).args(more).envs(settings.iter().cloned());
    ensure!(command.status()?.success(), "{why}");
    Ok(())
}

/// The words of a command's line.
pub(crate) fn words(line: &str) -> Vec<&str> {
    line.split(' ').collect()
}

/// Removes a folder, if it is there.
pub(crate) fn remove(folder: &Path) -> io::Result<()> {
    if folder.exists() { std::fs::remove_dir_all(folder) } else { Ok(()) }
}

/// Every file below a folder.
pub(crate) fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else {
                found.push(path);
            }
        }
    }
    Ok(found)
}

/// Hash of each file below `derived/` and `reports/`, by its path.
pub(crate) type Hashes = BTreeMap<String, String>;

/// The hashes of what was made in a root.
pub(crate) fn hashed(root: &Path) -> anyhow::Result<Hashes> {
    let mut hashes = Hashes::new();
    for folder in ["derived", "reports"] {
        for file in files(&root.join(folder))? {
            let path = file.strip_prefix(root)?.to_string_lossy().into_owned();
            hashes.insert(path, file_blake3(&file)?);
        }
    }
    Ok(hashes)
}

/// The same folder at another place, each file by copying or linking it.
pub(crate) fn lay_down<T>(
    from: &Path,
    to: &Path,
    by: fn(PathBuf, PathBuf) -> io::Result<T>,
) -> io::Result<()> {
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let path = entry?.path();
        let other = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            lay_down(&path, &other, by)?;
        } else {
            by(path, other)?;
        }
    }
    Ok(())
}
