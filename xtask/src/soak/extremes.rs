//! Scenes, answers and paths at the extremes, more than a test has time for, and the page of the scenes' results.

use crate::shell::cargo;
use crate::tried::held;
use std::time::Instant;

/// Scenes of a full turn.
pub(crate) const SCENES: u64 = 1_000_000;
/// Scenes for each set of answers that a psychometric function is fitted to.
const SCENES_PER_FIT: u64 = 50;
/// Fewer sets do not have every kind of answers in them.
const LEAST_FITS: u64 = 200;

/// Scenes for each recording in several axes.
const SCENES_PER_PATH: u64 = 100;

/// Runs all suites, of which that of scenes writes docs/extremes.md. A scene, a set of answers or a recording that ends as
/// none may fails its suite by its number.
pub(crate) fn extremes(scenes: u64) -> anyhow::Result<()> {
    let command = || format!("cargo xtask soak extremes {scenes}");
    println!("{scenes} scenes");
    let began = Instant::now();
    cargo(
        "test --release --locked --package zwidth-dynamics --test extremes -- --ignored",
        &[],
        &[("ZWIDTH_EXTREMES", scenes.to_string())],
        "a scene at the extremes ends as none may: keep it as a test with a name",
    )?;
    let what = "scenes at the extremes, which end in numbers or in errors that say what is wrong";
    held(what, command(), scenes, began)?;
    let fits = (scenes / SCENES_PER_FIT).max(LEAST_FITS);
    println!("{fits} sets of answers");
    let began = Instant::now();
    cargo(
        "test --release --locked --package zwidth-stats --test extremes",
        &[],
        &[("ZWIDTH_EXTREMES_FITS", fits.to_string())],
        "answers at the extremes end as none may: keep them as a test with a name",
    )?;
    let what = "sets of answers at the extremes, which end in verdicts or in errors that say what is wrong";
    held(what, command(), fits, began)?;
    let paths = (scenes / SCENES_PER_PATH).max(LEAST_FITS);
    println!("{paths} recordings in several axes");
    let began = Instant::now();
    cargo(
        "test --release --locked --package zwidth-metrics --test extremes",
        &[],
        &[("ZWIDTH_EXTREMES_PATHS", paths.to_string())],
        "the metrics of a recording in several axes at the extremes are none: keep it as a test with a name",
    )?;
    let what =
        "recordings in several axes at the extremes, whose metrics are numbers that can be or null";
    held(what, command(), paths, began)
}
