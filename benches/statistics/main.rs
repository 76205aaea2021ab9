//! The statistics beside R's, and a study of a thousand people: `run.sh` says how.
#![allow(clippy::print_stdout)] // what it prints is what it is for

mod cases;
mod draws;
mod ours;
mod peers;
mod thousand;

use anyhow::bail;
use std::path::Path;

fn main() -> anyhow::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        ["peers", script, folder] => peers::measure(Path::new(script), Path::new(folder)),
        ["thousand", folder] => thousand::measure(Path::new(folder)),
        _ => bail!("statistics peers PEER.R FOLDER, or statistics thousand FOLDER"),
    }
}
