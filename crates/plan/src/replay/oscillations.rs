//! Were the swings in recorded trials real? `zwidth stability --study` asks for this, a run does
//! not: a trial's loop is run again half a dozen times.

use crate::identify;
use crate::replay::replayable::rendering;
use crate::shared::trials::{files, name, read_all};
use rayon::prelude::*;
use zwidth_replay::{Oscillation, Parameters};
use zwidth_runner::JobError;
use zwidth_store::{Signal, StudyData, TrialEntry};
use zwidth_study::TrialMeta;
use zwidth_tables::Table;

/// What became of the trials that were asked about.
#[derive(Debug)]
pub struct Oscillations {
    /// One row per trial.
    pub trials: Vec<(TrialMeta, Oscillation)>,
    /// Whether the plant is the study's own, as `zwidth run` fitted it; else it is the thesis', by
    /// eye.
    pub is_fitted: bool,
    /// Trials that could not be read or run, and why.
    pub problems: Vec<String>,
}

/// Asks of each trial that counts and is wanted whether its oscillation is the device's own.
///
/// # Errors
/// A table of fitted parameters that cannot be read; a recording that the system does not give.
pub fn oscillations(
    data: &StudyData,
    wanted: &(dyn Fn(&TrialMeta) -> bool + Sync),
    progress: &(dyn Fn() + Sync),
) -> Result<Oscillations, JobError> {
    let fitted = identify::tables(data).into_iter().next().filter(|path| path.exists());
    let fitted = fitted.map(|path| Table::from_parquet(&path)).transpose()?;
    let fitted = fitted.map(|table| identify::fitted(&table)).transpose()?.flatten();
    let plant = fitted.unwrap_or(Parameters::BY_EYE);
    let entries: Vec<&TrialEntry> = data.counting().filter(|t| wanted(&t.meta)).collect();
    let known = crate::shared::trials::describe_trials(&entries);
    let (trials, mut problems) = read_all(&files(&entries), &known, Signal::all())?;
    let one = |trial: &zwidth_store::Trial| {
        progress();
        let (Some(environment), Some(mode)) =
            (data.study.environment(&trial.meta.environment), data.study.mode(&trial.meta.mode))
        else {
            return Err(format!("{}: its condition is not in study.toml", name(&trial.meta)));
        };
        let rendering = rendering(data, &trial.meta, environment, mode);
        zwidth_replay::oscillation(trial, &data.study, &rendering, &plant)
            .map(|found| (trial.meta.clone(), found))
            .map_err(|error| format!("{}: {error}", name(&trial.meta)))
    };
    let (trials, more) = crate::shared::making::split(trials.par_iter().map(one).collect());
    problems.extend(more);
    Ok(Oscillations { trials, is_fitted: fitted.is_some(), problems })
}
