//! Figures of what was planned: the environments, and the forces that each mode can render.

use super::JobError;
use super::characterise;
use super::figures::figure_job;
use crate::text::beside;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_runner::Job;
use zwidth_store::StudyData;
use zwidth_study::{Calibration, Environment, Source};

/// What is said of forces where no sweep gave them.
const NOT_SWEPT: &str = "Forces by the thesis' nominal characteristics: motor and brake of this study were not both swept.";
/// What is said of forces that the study's own sweeps gave.
const SWEPT: &str = "Forces by the calibration from this study's sweeps of motor and brake.";
/// The same where a sweep is simulated.
const SIMULATED: &str =
    "Forces by the calibration from this study's simulated sweeps of motor and brake.";

/// The calibration of a study's forces, whether it is its own, and what the sweeps behind it are.
pub(super) struct Forces {
    pub(super) calibration: Calibration,
    pub(super) footnote: &'static str,
    pub(super) sources: BTreeSet<Source>,
}

/// The file that [`forces`] reads, if the study has it.
pub(super) fn inputs(data: &StudyData) -> Vec<PathBuf> {
    characterise::calibration(data).into_iter().collect()
}

/// Where the forces come from: part of the parameters of every job that shows them.
pub(super) fn sources(data: &StudyData) -> BTreeSet<Source> {
    let own = characterise::calibration(data).is_some();
    data.sweeps.iter().filter(|_| own).map(|s| s.source).collect()
}

/// The calibration of a study's forces: its own, or else the thesis'.
pub(super) fn forces(data: &StudyData) -> Result<Forces, JobError> {
    let sources = sources(data);
    let Some(file) = characterise::calibration(data) else {
        return Ok(Forces { calibration: Calibration::thesis(), footnote: NOT_SWEPT, sources });
    };
    let footnote = if sources.contains(&Source::Twin) { SIMULATED } else { SWEPT };
    Ok(Forces { calibration: read(&file)?, footnote, sources })
}

fn read(file: &Path) -> Result<Calibration, JobError> {
    let text = beside(file)?.unwrap_or_default();
    Ok(Calibration::from_toml(&text)?)
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
    figure_job(
        data,
        &format!("environment.{}", environment.id),
        Vec::new(),
        parameters,
        move || {
            let figure = zwidth_figures::environment(&data.study, environment);
            Ok((figure.ok_or("the environment cannot be drawn")?, Vec::new()))
        },
    )
}

fn range_job(data: &StudyData) -> Job<'_> {
    let parameters = format!("{:?}", (&data.study.title, &data.study.modes, sources(data)));
    figure_job(data, "rendering_range", inputs(data), parameters, move || {
        let Forces { calibration, footnote, sources } = &forces(data)?;
        let sources: Vec<Source> = sources.iter().copied().collect();
        let figure = zwidth_figures::rendering_range(&data.study, calibration, footnote, &sources);
        Ok((figure.ok_or("no mode has an actuator")?, Vec::new()))
    })
}
