//! Thresholds beside PsychoPy's handlers and psignifit: `run.sh` says how.
#![allow(clippy::print_stdout)] // what it prints is what it is for

mod fits;
mod people;
mod trials;

use anyhow::bail;
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["fits", python, peer, folder] => fits::measure([python, peer], Path::new(folder)),
        ["trials", python, peer] => trials::measure([python, peer]),
        _ => bail!("thresholds fits PYTHON PEER.py FOLDER, or thresholds trials PYTHON PEER.py"),
    }
}

/// What the peer prints, a line each, in columns.
fn ask([python, peer]: [&str; 2], words: &[&str]) -> anyhow::Result<Vec<Vec<String>>> {
    let output = std::process::Command::new(python).arg(peer).args(words).output()?;
    if !output.status.success() {
        bail!("{peer}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let text = String::from_utf8(output.stdout)?;
    Ok(text.lines().map(|line| line.split('\t').map(str::to_owned).collect()).collect())
}
