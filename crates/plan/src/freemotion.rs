//! Stage `freemotion`: in a free environment, the plane fit of every trial that has an
//! acceleration, and the plant of every other trial that has an angle.

use crate::shared::handle::{Derived, write_named};
use crate::shared::trials::{OfTrials, Recordings, files, read_and_make};
use std::path::PathBuf;
use zwidth_freemotion::{
    FreeMotionError, Parameters, plane_fit, plane_table, plant_fit, plant_table,
};
use zwidth_results::{FreePlane, FreePlant};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Signal, StudyData, Trial, TrialEntry};
use zwidth_study::Scene;
use zwidth_tables::{Table, TableError};

const STAGE: Stage = Stage { name: "freemotion", version: zwidth_freemotion::VERSION };

/// The plane fits of the study, if any trial has one.
pub(crate) fn planes(data: &StudyData) -> Option<Derived<FreePlane>> {
    (!trials(data).for_plane.is_empty()).then(|| Derived::within(&data.layout.derived()))
}

/// The plants of the study, if any trial has one.
fn plants(data: &StudyData) -> Option<Derived<FreePlant>> {
    (!trials(data).for_plant.is_empty()).then(|| Derived::within(&data.layout.derived()))
}

/// The tables of the stage.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    [planes(data).files(), plants(data).files()].concat()
}

/// Trials of free motion that count.
struct FreeTrials<'a> {
    for_plant: Vec<&'a TrialEntry>,
    for_plane: Vec<&'a TrialEntry>,
}

fn trials(data: &StudyData) -> FreeTrials<'_> {
    let (for_plant, for_plane) = data
        .counting()
        .filter(|trial| {
            let environment = data.study.environment(&trial.meta.environment);
            // A plane of one coordinate; of several axes the stage knows nothing.
            environment.is_some_and(|e| matches!(e.scene, Scene::Free)) && data.study.axes.is_none()
        })
        .partition(|trial| {
            trial.said.signals.contains(&Signal::Theta)
                && !trial.said.signals.contains(&Signal::ThetaDdot)
        });
    FreeTrials { for_plant, for_plane }
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let FreeTrials { for_plant, for_plane } = trials(data);
    let mut jobs = Vec::new();
    if let Some(output) = planes(data) {
        let parameters = OfTrials::new(Parameters::of(&data.study), &for_plane);
        let (name, files) = ("plane fits of free motion", files(&for_plane));
        jobs.push(Job::new(
            STAGE,
            name,
            parameters,
            files,
            output.files(),
            |trials, files, making| make(trials, files, making, plane_fit, plane_table),
        ));
    }
    if let Some(output) = plants(data) {
        let parameters = OfTrials::new(Parameters::of(&data.study), &for_plant);
        let (name, files) = ("plant in free motion", files(&for_plant));
        jobs.push(Job::new(
            STAGE,
            name,
            parameters,
            files,
            output.files(),
            |trials, files, making| make(trials, files, making, plant_fit, plant_table),
        ));
    }
    jobs
}

/// The fits of the trials that can be read and fitted.
fn make<F: Send>(
    parameters: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
    fit: fn(&Trial, &Parameters) -> Result<F, FreeMotionError>,
    table: fn(&[F]) -> Result<Table, TableError>,
) -> Result<Made, JobError> {
    let OfTrials { stage, trials } = parameters;
    let (fits, problems) = read_and_make(files, trials, |trial| fit(trial, stage))?;
    Ok(Made { problems, ..write_named(vec![table(&fits)?], making, false)? })
}
