//! The trials of Figure 24 and their models against time, for each environment with a spring: a
//! table of the stage `replay`, which the figure draws.

use crate::replay::STAGE;
use crate::replay::replayable::{is_replayable, rendering};
use crate::shared::conditions::{Session, sessions};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, read_shared, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, read_all};
use crate::{identify, replay};
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering};
use zwidth_results::{CourseSample, ModelPlant};
use zwidth_runner::{Inputs as _, Job, JobError, Made, Making};
use zwidth_store::{Signal, StudyData, Trial};
use zwidth_study::{Environment, ModeId};
use zwidth_tables::Table;

/// The courses of typical trials of one environment of a session, if one can be replayed.
pub(crate) fn file(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
) -> Option<Derived<CourseSample>> {
    let is_any = session.of(environment).iter().any(|t| is_replayable(data, t));
    let key = session.ids_with(environment).join(".");
    is_any.then(|| Derived::at(derived(&data.layout, format!("courses/{key}.parquet"))))
}

/// What the results on typical trials depend on besides files.
#[derive(Serialize)]
pub(crate) struct Typical {
    /// In the order of the study, each with how it was rendered.
    modes: Vec<(ModeId, Rendering)>,
    pub(crate) plant: Parameters,
}

/// The trials of an environment, their conditions' tables of replays, and the identified plant.
pub(crate) type Files = (Recordings, Vec<PathBuf>, PathBuf);

/// Parameters and files of the results on typical trials of an environment.
pub(crate) fn typical_inputs(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
) -> (OfTrials<Typical>, Files) {
    let mut trials = session.of(environment);
    trials.retain(|t| is_replayable(data, t));
    let mut modes = Vec::new();
    let mut replays = Vec::new();
    for mode in &data.study.modes {
        let Some(repeats) = session.repeats(environment, mode) else { continue };
        replays.push(replay::of_condition(&data.layout, &repeats, ModelPlant::ByEye));
        if let Some(first) = repeats.trials.first() {
            modes.push((mode.id.clone(), rendering(data, &first.meta, environment, mode)));
        }
    }
    let typical = Typical { modes, plant: Parameters::BY_EYE };
    let files = (files(&trials), replays, identify::plant_of(&data.layout));
    (OfTrials::new(typical, &trials), files)
}

/// The courses of typical trials of each environment with a spring.
pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let Some(output) = file(data, &session, environment) else { continue };
            let (parameters, inputs) = typical_inputs(data, &session, environment);
            let name = format!("courses {} {}", session.who(), environment.id);
            let job = Job::new(STAGE, name, parameters, inputs, output.files(), make);
            jobs.push(job.of_part(session.ids_with(environment).join(".")));
        }
    }
    jobs
}

/// The typical trial of each mode that has one, and how it was rendered.
pub(crate) fn typical_trials<'a>(
    parameters: &'a OfTrials<Typical>,
    files: &Recordings,
    replays: &[PathBuf],
) -> Result<Vec<(Trial, &'a Rendering)>, JobError> {
    let OfTrials { stage: typical, trials: labels } = parameters;
    let replays = replay::join_rows(replays)?;
    let mut trials = Vec::new();
    for (mode, rendering) in &typical.modes {
        let Some(number) = zwidth_replay::typical(&replays, mode) else { continue };
        let Some(at) = labels.iter().position(|label| label.trial == number) else { continue };
        // This trial alone: of the others the table of replays has all that is needed.
        let (read, problems) = read_all(&files[at..=at], &labels[at..=at], Signal::all())?;
        let trial = read.into_iter().next().ok_or_else(|| problems.join("; "))?;
        trials.push((trial, rendering));
    }
    Ok(trials)
}

fn make(
    parameters: &OfTrials<Typical>,
    (files, replays, plant): &Files,
    making: &Making,
) -> Result<Made, JobError> {
    let fitted = identify::fitted(&*read_shared(plant, making)?)?;
    let trials = typical_trials(parameters, files, replays)?;
    let by_eye = &parameters.stage.plant;
    let fitted = fitted.as_ref();
    let courses = zwidth_replay::courses(&trials, by_eye, fitted)?;
    if courses.is_empty() {
        return Err("no trial could be replayed: the table 'replay' says why".into());
    }
    let notes = zwidth_replay::course_notes(&trials, by_eye, fitted);
    let table = notes.into_iter().fold(Table::of_rows(&courses)?, Table::with_note);
    write_tables(&[table], making, Vec::new())
}
