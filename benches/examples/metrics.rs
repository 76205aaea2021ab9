//! All metrics of every trial of a study, read with all checks and put into no table: what the stage
//! `metrics` takes without planning, tables and records. `cargo run --release -p zwidth-benches
//! --example metrics -- ROOT STUDY`
#![allow(clippy::print_stdout)] // it is run by hand, or by benches/scale

use anyhow::Context as _;
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;
use zwidth_metrics::{Parameters, Plant, SIGNALS, plant_metrics, trial_metrics};
use zwidth_store::{Layout, OpenTrial, StoreError, read_study};
use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, ChannelId, REFERENCE, Study};

/// Somebody's: no metric takes another time for another plant.
const PLANT: Plant = Plant {
    mass_kg: 0.4,
    damping_ns_per_rad: 0.15,
    friction_n: 0.2,
    covariance: [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]],
    df: 100.0,
};

fn main() -> anyhow::Result<()> {
    let mut words = std::env::args().skip(1);
    let (root, study) =
        (words.next().context("which root?")?, words.next().context("which study?")?);
    let begun = Instant::now();
    let layout = Layout::new(Path::new(&root), study.parse()?);
    let study = read_study(&layout).map_err(|errors| said(&errors))?;
    let channels = [CURRENT_MOTOR, CURRENT_BRAKE, REFERENCE];
    let channels = channels.into_iter().map(str::parse).collect::<Result<Vec<ChannelId>, _>>()?;
    let mut files = Vec::new();
    zwidth_benches::gather(&layout.trials(), &mut files)?;
    let found = files.par_iter().map(|file| metrics(&study, &channels, file));
    let sum = found.try_reduce(|| [0.0; 2], |a, b| Ok([a[0] + b[0], a[1] + b[1]]))?;
    let [sparc, loops] = sum;
    println!(
        "{} trials, sums {sparc:.6e} {loops:.6e}, {:.3} s",
        files.len(),
        begun.elapsed().as_secs_f64()
    );
    Ok(())
}

/// Two of a trial's metrics, of which all are made.
fn metrics(study: &Study, channels: &[ChannelId], file: &Path) -> anyhow::Result<[f64; 2]> {
    let trial = OpenTrial::open(file, &SIGNALS, channels)?;
    let condition = study.environment(&trial.meta.environment).zip(study.mode(&trial.meta.mode));
    let (environment, mode) = condition.context("a trial of no condition")?;
    let parameters = Parameters::of(study, environment, mode);
    let row = trial_metrics(&trial, &parameters)?;
    let with_plant = plant_metrics(&trial, &parameters, Some(&PLANT))?;
    if let Some(error) = trial.columns().failure() {
        return Err(error.into());
    }
    let loops = with_plant.energy.closed_loops.unwrap_or(0);
    Ok([row.movement.sparc_forward.unwrap_or(0.0), loops as f64])
}

fn said(errors: &[StoreError]) -> anyhow::Error {
    anyhow::anyhow!(errors.iter().map(|error| format!("{error}\n")).collect::<String>())
}
