//! Impedance against frequency of every condition of a study, from its recorded trials: `zwidth
//! characterise STUDY impedance` puts it beside the Z-width.

use crate::shared::trials::{files, label_trials, read_all};
use zwidth_runner::JobError;
use zwidth_stability::impedance::{Recording, Response, response};
use zwidth_store::{Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Scene, Source};

/// Impedance from the trials of a study.
#[derive(Debug)]
pub struct Responses {
    /// By environment and mode, as the study calls them.
    pub responses: Vec<([String; 2], Response)>,
    /// Where the trials come from.
    pub sources: Vec<Source>,
    /// Trials that could not be read, and why.
    pub problems: Vec<String>,
}

/// Impedance against frequency by condition, over all participants: what they feel is the device's.
/// A condition that was recorded for too short a time is left out. The list is empty if the lever's
/// length is not known.
///
/// # Errors
/// A recording that the system does not give.
pub fn responses(data: &StudyData) -> Result<Responses, JobError> {
    let mut all = Responses { responses: Vec::new(), sources: Vec::new(), problems: Vec::new() };
    let Some(lever_m) = data.study.device.lever_m else { return Ok(all) };
    // A questionnaire has no impedance.
    for environment in data.study.environments.iter().filter(|e| e.scene != Scene::None) {
        for mode in &data.study.modes {
            let entries: Vec<&TrialEntry> = data
                .counting()
                .filter(|t| t.meta.environment == environment.id && t.meta.mode == mode.id)
                .collect();
            let signals = [Signal::Time, Signal::Theta, Signal::ForceEx, Signal::ForceAge];
            let (trials, problems) =
                read_all(&files(&entries), &label_trials(&entries), signals.into_iter())?;
            all.problems.extend(problems);
            let recordings: Vec<Recording> = trials.iter().filter_map(recording).collect();
            let level = data.study.analysis.confidence;
            if let Some(response) = response(&recordings, lever_m, level)? {
                all.responses.push(([environment.label.clone(), mode.label.clone()], response));
                all.sources.extend(trials.iter().map(|trial| trial.meta.source));
            }
        }
    }
    Ok(all)
}

/// Angle and force of a trial; `None` where one was not recorded, or a column is of another length.
fn recording(trial: &Trial) -> Option<Recording<'_>> {
    let t_s = trial.samples.get(Signal::Time)?;
    let column = |signal| trial.samples.get(signal).filter(|values| values.len() == t_s.len());
    Some(Recording {
        t_s,
        theta_rad: column(Signal::Theta)?,
        force_n: column(Signal::ForceEx)?,
        force_age_s: column(Signal::ForceAge),
    })
}
