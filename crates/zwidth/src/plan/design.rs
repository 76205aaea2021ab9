//! Figures of what was planned: the environments, and the forces that each mode can render.

use super::characterise;
use super::figures::figure_job;
use super::{JobError, split};
use std::path::{Path, PathBuf};
use zwidth_runner::Job;
use zwidth_store::{StudyData, read_sweep};
use zwidth_study::{Calibration, Environment, Source};

/// What is said of forces where no sweep gave them.
const NOT_SWEPT: &str =
    "Forces by the thesis' nominal characteristics: motor and brake of this study were not both swept.";
/// What is said of forces that the study's own sweeps gave.
const SWEPT: &str = "Forces by the calibration from this study's sweeps of motor and brake.";
/// The same where a sweep is simulated.
const SIMULATED: &str = "Forces by the calibration from this study's simulated sweeps of motor and brake.";

/// The calibration of a study's forces, whether it is its own, and what the sweeps behind it are.
pub(super) struct Forces {
    pub(super) calibration: Calibration,
    pub(super) footnote: &'static str,
    pub(super) sources: Vec<Source>,
}

/// Files that [`forces`] reads.
pub(super) fn inputs(data: &StudyData) -> Vec<PathBuf> {
    let sweeps = || data.sweeps.iter().map(|s| s.path.clone());
    characterise::calibration(data).map_or_else(Vec::new, |file| sweeps().chain([file]).collect())
}

/// The calibration of a study's forces: its own, or else the thesis'.
pub(super) fn forces(data: &StudyData) -> Result<(Forces, Vec<String>), JobError> {
    let Some(file) = characterise::calibration(data) else {
        let thesis = Calibration::thesis();
        return Ok((Forces { calibration: thesis, footnote: NOT_SWEPT, sources: Vec::new() }, Vec::new()));
    };
    let (sweeps, problems) = split(data.sweeps.iter().map(|s| read_sweep(&s.path)).collect());
    let sources: Vec<Source> = sweeps.iter().map(|s| s.source).collect();
    let footnote = if sources.contains(&Source::Twin) { SIMULATED } else { SWEPT };
    Ok((Forces { calibration: read(&file)?, footnote, sources }, problems))
}

fn read(file: &Path) -> Result<Calibration, JobError> {
    Ok(Calibration::from_toml(&std::fs::read_to_string(file)?)?)
}

/// Whether any mode drives an actuator of known voltage.
pub(super) fn has_actuators(data: &StudyData) -> bool {
    data.study.modes.iter().any(|m| m.motor_max_v.or(m.brake_max_v).is_some())
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let study = &data.study;
    let drawn = |e: &&Environment| zwidth_figures::environment(study, e).is_some();
    let mut jobs: Vec<Job> =
        study.environments.iter().filter(drawn).map(|e| environment_job(data, e)).collect();
    if has_actuators(data) {
        jobs.push(range_job(data));
    }
    jobs
}

fn environment_job<'a>(data: &'a StudyData, environment: &'a Environment) -> Job<'a> {
    let parameters = format!("{:?}", (&data.study.device, data.study.coordinate, environment));
    figure_job(data, &format!("environment.{}", environment.id), Vec::new(), parameters, move || {
        let figure = zwidth_figures::environment(&data.study, environment);
        Ok((figure.ok_or("the environment cannot be drawn")?, Vec::new()))
    })
}

fn range_job(data: &StudyData) -> Job<'_> {
    let parameters = format!("{:?}", (&data.study.title, &data.study.modes));
    figure_job(data, "rendering_range", inputs(data), parameters, move || {
        let (forces, problems) = forces(data)?;
        let Forces { calibration, footnote, sources } = &forces;
        let figure = zwidth_figures::rendering_range(&data.study, calibration, footnote, sources);
        Ok((figure.ok_or("no mode has an actuator")?, problems))
    })
}
