//! Trajectories of random scenes, right and wrong by formula: none may be misjudged.

use crate::shell::cargo;
use crate::tried::held;
use std::time::Instant;

/// Scenes of a full turn.
pub(crate) const SCENES: u64 = 10_000;

/// Runs the suite; a trajectory that is misjudged is named by its scene's number.
pub(crate) fn judge(scenes: u64) -> anyhow::Result<()> {
    println!("{scenes} scenes");
    let began = Instant::now();
    cargo(
        "test --release --locked --package zwidth-judge --test judge -- --ignored",
        &[],
        &[("ZWIDTH_JUDGED", scenes.to_string())],
        "a trajectory is misjudged: keep it as a test with a name",
    )?;
    let what = "random scenes, of each right trajectories and wrong ones by formula, which the judge tells apart";
    held(what, format!("cargo xtask soak judge {scenes}"), scenes, began)
}
