//! Stage `freemotion`: in a free environment, the plane fit of every trial that has an
//! acceleration, and the plant of every other trial that has an angle.

use crate::shared::handle::{Derived, Written};
use crate::shared::making::split;
use crate::shared::trials::{OfTrials, Recordings, WithProblems, files, name, read_all};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_freemotion::{FreeMotionError, Parameters};
use zwidth_results::{FreePlane, FreePlant};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Signal, StoreError, StudyData, Trial, TrialEntry};
use zwidth_study::Scene;

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
            environment.is_some_and(|e| matches!(e.scene, Scene::Free))
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
        jobs.push(Job::new(STAGE, name, parameters, files, output.files(), make_planes));
    }
    if let Some(output) = plants(data) {
        let parameters = OfTrials::new(Parameters::of(&data.study), &for_plant);
        let (name, files) = ("plant in free motion", files(&for_plant));
        jobs.push(Job::new(STAGE, name, parameters, files, output.files(), make_plants));
    }
    jobs
}

fn make_planes(
    parameters: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (fits, problems) = fit_all(parameters, files, zwidth_freemotion::plane_fit)?;
    let table = zwidth_freemotion::plane_table(&fits)?;
    Ok(Made { problems, ..Written::begin(making, false).table(table)?.end()? })
}

fn make_plants(
    parameters: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (fits, problems) = fit_all(parameters, files, zwidth_freemotion::plant_fit)?;
    let table = zwidth_freemotion::plant_table(&fits)?;
    Ok(Made { problems, ..Written::begin(making, false).table(table)?.end()? })
}

/// The fits of the trials that can be read and fitted, and what is wrong with the others.
fn fit_all<F: Send>(
    parameters: &OfTrials<Parameters>,
    files: &Recordings,
    fit: fn(&Trial, &Parameters) -> Result<F, FreeMotionError>,
) -> Result<WithProblems<F>, StoreError> {
    let (trials, mut problems) = read_all(files, &parameters.trials, Signal::all())?;
    let fits = trials.par_iter().map(|trial| {
        fit(trial, &parameters.stage).map_err(|e| format!("{}: {e}", name(&trial.meta)))
    });
    let (fits, more) = split(fits.collect());
    problems.extend(more);
    Ok((fits, problems))
}
