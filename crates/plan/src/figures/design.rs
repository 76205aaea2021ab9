//! Figures of what was planned: the environments, and the forces that each mode can render.

use crate::characterise;
use crate::figures::drawing::{Drawing, Figured};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_figures::{About, ENVIRONMENT, Placement, RENDERING_RANGE};
use zwidth_runner::JobError;
use zwidth_store::{MOST_BYTES, StoreError, StudyData, read_regular};
use zwidth_study::{Basis, Calibration, Source};

/// Where the calibration of a study's forces comes from.
pub(crate) struct Forces {
    pub(crate) basis: Basis,
    /// What the sweeps behind it are.
    pub(crate) sources: BTreeSet<Source>,
    /// Its file; without one it is the thesis'.
    pub(crate) calibration: Option<PathBuf>,
}

impl Forces {
    /// The calibration: the study's own file, or else the thesis'.
    pub(crate) fn read(file: Option<&Path>) -> Result<Calibration, JobError> {
        let Some(path) = file else { return Ok(Calibration::thesis()) };
        let bytes = read_regular(path, MOST_BYTES).map_err(|e| StoreError::io(path, "read", &e))?;
        Ok(Calibration::from_toml(&String::from_utf8(bytes)?)?)
    }
}

/// Where the calibration of a study's forces comes from: its own sweeps, or else the thesis.
pub(crate) fn forces(data: &StudyData) -> Forces {
    let Some(calibration) = characterise::calibration(data) else {
        return Forces { basis: Basis::Thesis, sources: BTreeSet::new(), calibration: None };
    };
    let sources: BTreeSet<Source> = data.sweeps.iter().map(|s| s.source).collect();
    let simulated = sources.iter().any(|source| source.is_simulated());
    let basis = if simulated { Basis::Simulated } else { Basis::Swept };
    Forces { basis, sources, calibration: Some(calibration) }
}

/// Whether any mode drives an actuator of known voltage.
pub(crate) fn has_actuators(data: &StudyData) -> bool {
    data.study.modes.iter().any(|m| m.motor_max_v.or(m.brake_max_v).is_some())
}

/// What the figure of the forces depends on besides the calibration.
#[derive(Serialize)]
struct Range {
    about: About,
    basis: Basis,
    sources: BTreeSet<Source>,
}

pub(crate) fn all(data: &StudyData) -> Vec<Drawing> {
    let mut drawings = Vec::new();
    for environment in &data.study.environments {
        let placement = Placement::of(&data.study, environment);
        if zwidth_figures::environment(&placement).is_some() {
            let id = placement.environment.id.to_string();
            drawings.push(Drawing::new(data, ENVIRONMENT, [id], placement, (), draw_environment));
        }
    }
    if has_actuators(data) {
        let Forces { basis, sources, calibration } = forces(data);
        let range = Range { about: About::of(&data.study), basis, sources };
        let kind = RENDERING_RANGE;
        drawings.push(Drawing::new(data, kind, [""; 0], range, calibration, draw_range));
    }
    drawings
}

fn draw_environment(placement: &Placement, (): &()) -> Figured {
    let figure = zwidth_figures::environment(placement).ok_or("the environment cannot be drawn")?;
    Ok((figure, Vec::new()))
}

fn draw_range(Range { about, basis, sources }: &Range, calibration: &Option<PathBuf>) -> Figured {
    let calibration = Forces::read(calibration.as_deref())?;
    let sources: Vec<Source> = sources.iter().copied().collect();
    let figure = zwidth_figures::rendering_range(about, &calibration, basis.footnote(), &sources);
    Ok((figure.ok_or("no mode has an actuator")?, Vec::new()))
}
