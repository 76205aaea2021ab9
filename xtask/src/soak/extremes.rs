//! Scenes at the extremes, more than a test has time for, and the page of their results.

use crate::shell::cargo;
use crate::tried::held;
use std::time::Instant;

/// Scenes of a full turn.
pub(crate) const SCENES: u64 = 1_000_000;

/// Runs the suite, which writes docs/extremes.md. A scene that ends as none may fails it by its
/// number.
pub(crate) fn extremes(scenes: u64) -> anyhow::Result<()> {
    println!("{scenes} scenes");
    let began = Instant::now();
    cargo(
        "test --release --locked --package zwidth-dynamics --test extremes -- --ignored",
        &[],
        &[("ZWIDTH_EXTREMES", scenes.to_string())],
        "a scene at the extremes ends as none may: keep it as a test with a name",
    )?;
    let what = "scenes at the extremes, which end in numbers or in errors that say what is wrong";
    held(what, format!("cargo xtask soak extremes {scenes}"), scenes, began)
}
