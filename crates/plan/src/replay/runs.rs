//! The model over its parameters on typical trials, for the page's sliders: tables of the stage
//! `replay`, of the first session that has such trials. A table for every session would cost hours
//! in a large study, and would show the same.

use crate::identify;
use crate::replay::STAGE;
use crate::replay::courses::{self, Files, Typical, typical_inputs, typical_trials};
use crate::shared::conditions::{Session, sessions};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, read_shared, write_tables};
use crate::shared::trials::OfTrials;
use zwidth_results::PlantRun;
use zwidth_runner::{Inputs as _, Job, JobError, Made, Making};
use zwidth_store::StudyData;
use zwidth_study::Environment;
use zwidth_tables::Table;

/// One environment of the session whose model has sliders on the page.
pub(crate) struct Turned<'a> {
    pub(crate) environment: &'a Environment,
    pub(crate) file: Derived<PlantRun>,
}

/// The session, and its environments with trials that can be replayed.
pub(crate) fn turned(data: &StudyData) -> Option<(Session<'_>, Vec<Turned<'_>>)> {
    sessions(data).into_iter().find_map(|session| {
        let environments = data.study.environments.iter();
        let turned: Vec<Turned> = environments
            .filter(|environment| courses::file(data, &session, environment).is_some())
            .map(|environment| {
                let key = session.ids_with(environment).join(".");
                let file = Derived::at(derived(&data.layout, format!("runs/{key}.parquet")));
                Turned { environment, file }
            })
            .collect();
        (!turned.is_empty()).then_some((session, turned))
    })
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some((session, turned)) = turned(data) else { return Vec::new() };
    let jobs = turned.into_iter().map(|Turned { environment, file }| {
        let (parameters, inputs) = typical_inputs(data, &session, environment);
        let name = format!("runs {} {}", session.who(), environment.id);
        Job::new(STAGE, name, parameters, inputs, file.files(), make)
    });
    jobs.collect()
}

fn make(
    parameters: &OfTrials<Typical>,
    (files, replays, plant): &Files,
    making: &Making,
) -> Result<Made, JobError> {
    let fitted = identify::fitted(&*read_shared(plant, making)?)?;
    let trials = typical_trials(parameters, files, replays)?;
    let runs = zwidth_replay::runs(&trials, &parameters.stage.plant, fitted.as_ref())?;
    write_tables(&[Table::of_rows(&runs)?], making, Vec::new())
}
