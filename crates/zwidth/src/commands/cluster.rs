//! `zwidth run --cluster`: the program `zwidth-cluster`, a workspace of its own, makes the results
//! that are derived from trials, and merges them; then the run continues here and finds them up to
//! date.

use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::io::ErrorKind;
use std::path::Path;
use std::process::Command;
use zwidth_store::Layout;

/// The program that knows clusters.
const PROGRAM: &str = "zwidth-cluster";

/// Has the parts of a study made on the cluster with this scheduler. `raw` is where its executors
/// find the recordings, if not in the same folder as here.
///
/// # Errors
/// The program is not on the path, cannot be started, or has failed.
pub(super) fn run_on(
    scheduler: &str,
    layout: &Layout,
    raw: Option<&str>,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let study = layout.study();
    let mut command = Command::new(PROGRAM);
    command.args(["run", study.as_str(), "--scheduler", scheduler]);
    // Where no folder is named, it is the one that both programs are in.
    let root = layout.root();
    command.arg("--root").arg(if root.as_os_str().is_empty() { Path::new(".") } else { root });
    command.args(raw.iter().flat_map(|raw| ["--raw", raw]));
    let switches = [("--quiet", screen.quiet), ("--verbose", screen.verbose)];
    command.args(switches.iter().filter_map(|(option, is_on)| is_on.then_some(option)));
    let ended = match command.status() {
        Err(error) if error.kind() == ErrorKind::NotFound => bail!(
            "--cluster needs the program {PROGRAM}, and it is not on the path; build it with \
             `cargo build --release --locked --manifest-path cluster/Cargo.toml`, and put \
             cluster/target/release on the path (docs/scale.md)"
        ),
        ended => ended.with_context(|| format!("{PROGRAM} cannot be started"))?,
    };
    match ended.code() {
        Some(0) => Ok(Exit::Fine),
        // The program has the exit codes of this one.
        Some(3) => Ok(Exit::Partly),
        _ => bail!(
            "{study}: {PROGRAM} failed ({ended}); without a cluster, `zwidth run {study}` makes the same"
        ),
    }
}
