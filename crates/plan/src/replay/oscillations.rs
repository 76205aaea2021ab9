//! Were the swings in recorded trials real? `zwidth stability --study` asks for this, a run does
//! not: a trial's loop is run again half a dozen times.

use crate::identify;
use crate::replay::replayable::rendering;
use crate::shared::trials::{files, label_trials, read_and_make};
use zwidth_replay::{Oscillation, Parameters};
use zwidth_runner::JobError;
use zwidth_store::{StudyData, TrialEntry};
use zwidth_study::TrialMeta;
use zwidth_tables::Table;

/// The oscillations of trials.
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

/// Whether the oscillation of each wanted trial that counts is the device's own.
///
/// # Errors
/// A table of fitted parameters that cannot be read; a recording that the system does not give.
pub fn oscillations(
    data: &StudyData,
    wanted: &(dyn Fn(&TrialMeta) -> bool + Sync),
    progress: &(dyn Fn() + Sync),
) -> Result<Oscillations, JobError> {
    // Before the first run there is no fitted plant.
    let fitted = identify::tables(data).into_iter().next().filter(|path| path.exists());
    let fitted = fitted.map(|path| Table::from_parquet(&path)).transpose()?;
    let fitted = fitted.map(|table| identify::fitted(&table)).transpose()?.flatten();
    let plant = fitted.unwrap_or(Parameters::BY_EYE);
    let entries: Vec<&TrialEntry> = data.counting().filter(|t| wanted(&t.meta)).collect();
    let labels = label_trials(&entries);
    let (trials, problems) = read_and_make(&files(&entries), &labels, |trial| {
        progress();
        let (Some(environment), Some(mode)) =
            (data.study.environment(&trial.meta.environment), data.study.mode(&trial.meta.mode))
        else {
            return Err("its condition is not in study.toml".to_owned());
        };
        let rendering = rendering(data, &trial.meta, environment, mode);
        zwidth_replay::oscillation(trial, &data.study, &rendering, &plant)
            .map(|oscillation| (trial.meta.clone(), oscillation))
            .map_err(|error| error.to_string())
    })?;
    Ok(Oscillations { trials, is_fitted: fitted.is_some(), problems })
}
