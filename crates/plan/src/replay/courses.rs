//! The trials of Figure 24 and their models against time, for each environment with a spring: a
//! table of the stage `replay`, which the figure draws.

use crate::replay::STAGE;
use crate::replay::replayable::{is_replayable, rendering};
use crate::shared::conditions::{Repeats, Session, sessions};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, read_shared, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, read_all};
use crate::{identify, replay};
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering};
use zwidth_results::CourseSample;
use zwidth_runner::{Job, JobError, Made, Making};
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
    let key = [session.ids().as_slice(), &[environment.id.to_string()]].concat().join(".");
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

/// What is asked of typical trials of an environment, and the files that it takes.
pub(crate) fn asked(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
) -> (OfTrials<Typical>, Files) {
    let of_modes = data.study.modes.iter().filter_map(|m| session.repeats(environment, m));
    let conditions: Vec<Repeats> = of_modes.collect();
    let mut trials = session.of(environment);
    trials.retain(|t| is_replayable(data, t));
    let rendered = conditions.iter().filter_map(|r| {
        let meta = &r.trials.first()?.meta;
        Some((r.mode.id.clone(), rendering(data, meta, environment, r.mode)))
    });
    let typical = Typical { modes: rendered.collect(), plant: Parameters::BY_EYE };
    let replays = conditions.iter().map(|r| replay::of_condition(&data.layout, r)).collect();
    let files = (files(&trials), replays, identify::plant_of(&data.layout));
    (OfTrials::new(typical, &trials), files)
}

/// The courses of typical trials of each environment with a spring.
pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let Some(output) = file(data, &session, environment) else { continue };
            let (of, inputs) = asked(data, &session, environment);
            let name = format!("courses {} {}", session.who(), environment.id);
            let part = format!("{}.{}", session.ids().join("."), environment.id);
            let output = vec![output.path().to_owned()];
            jobs.push(Job::new(STAGE, name, of, inputs, output, make).of_part(part));
        }
    }
    jobs
}

/// The typical trial of each mode that has one, and how it was rendered.
pub(crate) fn typical_trials<'a>(
    of: &'a OfTrials<Typical>,
    files: &Recordings,
    replays: &[PathBuf],
) -> Result<Vec<(Trial, &'a Rendering)>, JobError> {
    let replays = replay::join_rows(replays)?;
    let mut trials = Vec::new();
    for (mode, rendering) in &of.stage.modes {
        let Some(number) = zwidth_replay::typical(&replays, mode) else { continue };
        let Some(at) = of.trials.iter().position(|known| known.trial == number) else { continue };
        let (read, problems) = read_all(&files[at..=at], &of.trials[at..=at], Signal::all())?;
        let trial = read.into_iter().next().ok_or_else(|| problems.join("; "))?;
        trials.push((trial, rendering));
    }
    Ok(trials)
}

fn make(
    of: &OfTrials<Typical>,
    (files, replays, plant): &Files,
    making: &Making,
) -> Result<Made, JobError> {
    let fitted = identify::fitted(&*read_shared(plant, making)?)?;
    let trials = typical_trials(of, files, replays)?;
    let by_eye = &of.stage.plant;
    let fitted = fitted.as_ref();
    let courses = zwidth_replay::courses(&trials, by_eye, fitted)?;
    if courses.is_empty() {
        return Err("no trial could be replayed: the table 'replay' says why".into());
    }
    let notes = zwidth_replay::course_notes(&trials, by_eye, fitted);
    let table = notes.into_iter().fold(Table::of_rows(&courses)?, Table::with_note);
    write_tables(&[table], making, Vec::new())
}
