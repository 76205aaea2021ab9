//! `cargo xtask soak`: checks that take too long for the tests; CI runs a short version of them.

mod cable;
pub(crate) mod compared;
pub(crate) mod coverage;
pub(crate) mod extremes;
pub(crate) mod faults;
pub(crate) mod kill;
pub(crate) mod live;
pub(crate) mod loops;
pub(crate) mod mistakes;
pub(crate) mod properties;
pub(crate) mod simulate;
pub(crate) mod statistics;
#[cfg(unix)]
pub(crate) mod terminals;
pub(crate) mod thesis;
pub(crate) mod watchdog;
pub(crate) mod wire;

use anyhow::{Context as _, bail};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use zwidth_store::{Layout, RealFiles, hex_blake3, write_new};
use zwidth_study::{StudyId, template};

/// The study of every soak, and its one session.
const STUDY: &str = "soak";
const SESSION: [&str; 4] = ["-p", "P01", "-s", "S01"];

/// The program, built for release, as users run it.
pub(crate) fn program() -> anyhow::Result<PathBuf> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(&cargo)
        .args(["build", "--quiet", "--release", "--package", "zwidth"])
        .status()?;
    if !built.success() {
        bail!("the program does not build");
    }
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| PathBuf::from("target"), PathBuf::from);
    target
        .join("release/zwidth")
        .canonicalize()
        .context("the built program is not where cargo puts it")
}

/// The same soak in a program that is built for speed.
fn optimised(arguments: &[&str]) -> anyhow::Result<()> {
    let status = Command::new(env!("CARGO"))
        .args(["run", "--quiet", "--release", "--locked", "--package", "xtask", "--", "soak"])
        .args(arguments)
        .status()?;
    if !status.success() {
        bail!("soak {} failed", arguments.join(" "));
    }
    Ok(())
}

/// A fresh root with a study: the template with these replacements.
fn fresh(root: &Path, changes: &[(&str, &str)]) -> anyhow::Result<Layout> {
    if root.exists() {
        std::fs::remove_dir_all(root)?;
    }
    let id = StudyId::new(STUDY)?;
    let mut text = template(&id);
    for (from, to) in changes {
        if !text.contains(from) {
            bail!("the template of a study lost '{from}'");
        }
        text = text.replace(from, to);
    }
    let layout = Layout::new(root, id);
    write_new(&RealFiles, &layout.study_toml(), text.as_bytes())?;
    Ok(layout)
}

/// Runs the program on a root and returns what it said; an exit code that is not allowed is an
/// error.
fn run(program: &Path, root: &Path, arguments: &[&str], allowed: &[i32]) -> anyhow::Result<Output> {
    let output = Command::new(program).arg("--root").arg(root).args(arguments).output()?;
    let code = output.status.code();
    if !code.is_some_and(|code| allowed.contains(&code)) {
        let told = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        bail!(
            "zwidth {arguments:?} ended with {code:?}\n{}\n{}",
            told(&output.stdout),
            told(&output.stderr)
        );
    }
    Ok(output)
}

/// A number in [0, 1) that follows from words.
fn fraction(words: &str) -> anyhow::Result<f64> {
    let bits = u64::from_str_radix(&hex_blake3(words.as_bytes())[..13], 16)?;
    Ok(bits as f64 / 2_f64.powi(52))
}
