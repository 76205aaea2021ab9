//! Does an interval of a comparison contain the truth 95 times in a hundred, and is nothing found
//! where there is no effect? Studies of twelve simulated people are drawn from many whose truth is
//! known.
//!
//! A separate study for each seed would simulate hundreds of trials to learn one fact. So many
//! people are simulated once, by the program as users run it: two sessions of every environment and
//! mode each. They are the population; its truth is the mean over all of them. A seed draws twelve
//! of them, each from all, and their trials go through the comparison's own code. Beside the
//! thesis' modes there is a copy of the last one, which can differ only by chance.

mod judge;
mod people;
mod studies;

use super::RATE;
use crate::shell::{program, scratch, words};
use crate::tried;
use anyhow::ensure;
use people::{COPY, METRICS, PARTICIPANTS, People, REPEATS};
use std::path::{Path, PathBuf};
use std::time::Instant;
use zwidth_tables::Measured;

/// Where the people come from.
pub(crate) enum From {
    /// So many are simulated.
    Simulated(u32),
    /// The table of metrics of those that an earlier run simulated.
    Table(PathBuf),
}

/// Compares so many studies and tells how often they are right; fails where that is not as often as
/// they say.
pub(crate) fn compared(seeds: u64, from: &From) -> anyhow::Result<()> {
    ensure!(seeds > 0, "no seeds");
    let began = Instant::now();
    let people = match from {
        From::Simulated(people) => simulate(&program()?, &scratch("compared"), *people)?,
        From::Table(file) => People::of(&Measured::read(file, &METRICS)?)?,
    };
    let simulated = began.elapsed().as_secs_f64();
    println!("{} people in {simulated:.0} s", people.len());
    let found = studies::all(&people, seeds)?;
    println!(
        "{seeds} studies of {PARTICIPANTS} of them in {:.0} s\n",
        began.elapsed().as_secs_f64() - simulated
    );
    judge::tell(&people, &found)?;
    let what = "studies drawn from simulated people: intervals, claims and power as often right as they say";
    tried::held(what, format!("cargo xtask soak compared {seeds} {}", people.len()), seeds, began)
}

/// Simulates people as users do it.
fn simulate(program: &Path, folder: &Path, people: u32) -> anyhow::Result<People> {
    let hybrid = "motor_max_v = 8.0\nbrake_max_v = 8.0\n";
    let copied = format!("{hybrid}\n[[modes]]\nid = \"{COPY}\"\nlabel = \"Copy\"\n{hybrid}");
    let changes = [
        ("\nrate_hz = 1000.0\n", format!("\nrate_hz = {RATE}.0\n")),
        ("\nrepeats = 6\n", format!("\nrepeats = {REPEATS}\n")),
        ("\nfamiliarisation = 3\n", "\nfamiliarisation = 0\n".to_owned()),
        (hybrid, copied),
    ];
    let layout = super::fresh(folder, &changes.each_ref().map(|(from, to)| (*from, to.as_str())))?;
    let study = super::STUDY;
    let twin = format!("--quiet twin {study} --participants {people} --sessions 2 --seed 1");
    super::run(program, folder, &words(&twin), &[0])?;
    super::run(program, folder, &["--quiet", "run", study, "--only", "metrics"], &[0])?;
    let metrics = layout.derived().join("metrics.parquet");
    let people = People::of(&Measured::read(&metrics, &METRICS)?)?;
    std::fs::remove_dir_all(folder)?;
    Ok(people)
}
