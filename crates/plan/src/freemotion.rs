//! Stage `freemotion`: in a free environment, the plane fit of every trial that has an
//! acceleration, and the plant of every other trial that has an angle.

use crate::shared::handle::{Derived, Written};
use crate::shared::making::split;
use crate::shared::trials::{Found, OfTrials, Recordings, files, name, read_all};
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
    (!trials(data).1.is_empty()).then(|| Derived::within(&data.layout.derived()))
}

/// The plants of the study, if any trial has one.
fn plants(data: &StudyData) -> Option<Derived<FreePlant>> {
    (!trials(data).0.is_empty()).then(|| Derived::within(&data.layout.derived()))
}

/// The tables of the stage.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    let planes = planes(data).into_iter().flat_map(|table| table.files());
    planes.chain(plants(data).into_iter().flat_map(|table| table.files())).collect()
}

/// Trials of free motion that count: those for a plant, and those for a plane fit.
fn trials(data: &StudyData) -> (Vec<&TrialEntry>, Vec<&TrialEntry>) {
    data.counting().filter(|trial| is_free(data, trial)).partition(|trial| {
        trial.said.signals.contains(&Signal::Theta)
            && !trial.said.signals.contains(&Signal::ThetaDdot)
    })
}

/// Whether nothing was rendered in a trial.
fn is_free(data: &StudyData, trial: &TrialEntry) -> bool {
    let environment = data.study.environment(&trial.meta.environment);
    environment.is_some_and(|e| matches!(e.scene, Scene::Free))
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let (with_plant, with_plane) = trials(data);
    let of = |trials: &[&TrialEntry]| OfTrials::new(Parameters::of(&data.study), trials);
    let plane = planes(data).map(|output| {
        let of = of(&with_plane);
        let files = files(&with_plane);
        Job::new(STAGE, "plane fits of free motion", of, files, output.files(), make_planes)
    });
    let plant = plants(data).map(|output| {
        let of = of(&with_plant);
        let files = files(&with_plant);
        Job::new(STAGE, "plant in free motion", of, files, output.files(), make_plants)
    });
    plane.into_iter().chain(plant).collect()
}

fn make_planes(
    of: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (fits, problems) = fit_all(of, files, zwidth_freemotion::plane_fit)?;
    let table = zwidth_freemotion::plane_table(&fits)?;
    Ok(Made { problems, ..Written::begin(making, false).table(table)?.end()? })
}

fn make_plants(
    of: &OfTrials<Parameters>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (fits, problems) = fit_all(of, files, zwidth_freemotion::plant_fit)?;
    let table = zwidth_freemotion::plant_table(&fits)?;
    Ok(Made { problems, ..Written::begin(making, false).table(table)?.end()? })
}

/// The fits of the trials that can be read and fitted, and what is wrong with the others.
fn fit_all<F: Send>(
    of: &OfTrials<Parameters>,
    files: &Recordings,
    fit: fn(&Trial, &Parameters) -> Result<F, FreeMotionError>,
) -> Result<Found<F>, StoreError> {
    let (trials, mut problems) = read_all(files, &of.trials, Signal::all())?;
    let fits = trials
        .par_iter()
        .map(|trial| fit(trial, &of.stage).map_err(|e| format!("{}: {e}", name(&trial.meta))));
    let (fits, more) = split(fits.collect());
    problems.extend(more);
    Ok((fits, problems))
}
