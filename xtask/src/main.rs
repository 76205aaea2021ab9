//! Chores of the workspace: `cargo xtask NAME`.
#![allow(clippy::print_stdout)] // a chore tells what it did

mod demo;
mod encodings;

use anyhow::bail;
use std::path::Path;

const CHORES: &str =
    "cargo xtask demo             write raw/demo anew (closed form, the same bytes every time)
cargo xtask encodings STUDY  measure column encodings on a study under raw/: size and speed";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["demo"] => demo::write(Path::new(".")),
        ["encodings", study] => encodings::measure(Path::new("."), study),
        _ => bail!("the chores are\n{CHORES}"),
    }
}
