//! Stage `characterise`: candidate models, parameters and curve of each actuator or sensor; the
//! calibration.

use crate::shared::handle::{Derived, write_named};
use crate::shared::making::derived;
use crate::shared::trials::{WithProblems, readable};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_characterise::{Fit, Settings, Subject, calibrated, curve_points};
use zwidth_results::{
    CurvePoint, FittedModel, FittedParameter, Row, UNIT_OF_COMMAND, UNIT_OF_RESPONSE,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_stability::impedance::ACTUATOR;
use zwidth_store::{Layout, StoreError, StudyData, Sweep, read_sweep};
use zwidth_study::{ActuatorId, Calibration};
use zwidth_tables::{Table, TableError};

const STAGE: Stage = Stage { name: "characterise", version: zwidth_characterise::VERSION };
/// Bootstrap resamples: the ends of a 95 % interval rest on 10 resamples each.
const RESAMPLES: usize = 400;
/// Seed of the bootstrap; part of the result.
const SEED: u64 = 1;

/// What the stage finds of an actuator.
#[derive(Clone)]
pub(crate) struct Characterisation {
    pub(crate) models: Derived<FittedModel>,
    pub(crate) parameters: Derived<FittedParameter>,
    pub(crate) curve: Derived<CurvePoint>,
}

impl Characterisation {
    pub(crate) fn of(layout: &Layout, actuator: &ActuatorId) -> Self {
        let file = |name: &str| derived(layout, format!("characterise/{name}.{actuator}.parquet"));
        Self {
            models: Derived::at(file(FittedModel::NAME)),
            parameters: Derived::at(file(FittedParameter::NAME)),
            curve: Derived::at(file(CurvePoint::NAME)),
        }
    }

    /// What was found.
    ///
    /// # Errors
    /// A file that cannot be read, or has other rows.
    pub(crate) fn read(&self) -> Result<Fit, TableError> {
        let curve = Table::from_parquet(self.curve.path())?;
        let [command_unit, response_unit] = [UNIT_OF_COMMAND, UNIT_OF_RESPONSE]
            .map(|open| curve.unit_for::<CurvePoint>(open).unwrap_or_default().to_owned());
        Ok(Fit {
            models: self.models.read()?,
            parameters: self.parameters.read()?,
            curve: curve.to_rows()?,
            command_unit,
            response_unit,
        })
    }
}

impl Inputs for Characterisation {
    fn files(&self) -> Vec<PathBuf> {
        let Self { models, parameters, curve } = self;
        [models.files(), parameters.files(), curve.files()].concat()
    }
}

/// Every actuator or sensor with sweeps, and their files.
pub(crate) fn actuators(data: &StudyData) -> Vec<(&ActuatorId, Vec<PathBuf>)> {
    // The searches of a Z-width test lie among the sweeps, and are of no actuator.
    let swept = data.sweeps.iter().map(|s| &s.actuator);
    let ids: BTreeSet<&ActuatorId> = swept.filter(|id| id.as_str() != ACTUATOR).collect();
    let of_actuators = ids.into_iter().map(|id| {
        let own = data.sweeps.iter().filter(|s| s.actuator == *id);
        (id, own.map(|s| s.path.clone()).collect())
    });
    of_actuators.collect()
}

/// Reads sweeps. A sweep of other quantities than the first one is left out and reported.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_sweeps(files: &[PathBuf]) -> Result<WithProblems<Sweep>, StoreError> {
    let (sweeps, mut problems) = readable(files.iter().map(|f| read_sweep(f)).collect())?;
    let Some(first) = sweeps.first().cloned() else { return Ok((sweeps, problems)) };
    let others = sweeps.iter().filter(|s| !s.is_like(&first));
    problems.extend(others.map(|other| other.unlike(&first)));
    Ok((sweeps.into_iter().filter(|s| s.is_like(&first)).collect(), problems))
}

/// The study's own calibration, where motor and brake were both swept: the file whose content
/// trials name by its hash.
pub(crate) fn calibration(data: &StudyData) -> Option<PathBuf> {
    let are_both_swept = ["motor", "brake"]
        .iter()
        .all(|name| data.sweeps.iter().any(|s| s.actuator.as_str() == *name));
    are_both_swept.then(|| derived(&data.layout, "characterise/calibration.toml"))
}

/// What the characteristic of an actuator depends on besides its sweeps.
#[derive(Serialize)]
struct OfActuator {
    actuator: ActuatorId,
    level: f64,
    resamples: usize,
    seed: u64,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let level = data.study.analysis.confidence;
    let mut jobs = Vec::new();
    let (mut motor, mut brake) = (None, None);
    for (actuator, files) in actuators(data) {
        let tables = Characterisation::of(&data.layout, actuator);
        let outputs = tables.files();
        let name = format!("characteristic of {actuator}");
        let parameters =
            OfActuator { actuator: actuator.clone(), level, resamples: RESAMPLES, seed: SEED };
        jobs.push(Job::new(STAGE, name, parameters, files, outputs, make_characteristic));
        match actuator.as_str() {
            "motor" => motor = Some(tables),
            "brake" => brake = Some(tables),
            _ => {}
        }
    }
    if let Some((tables, file)) = motor.zip(brake).zip(calibration(data)) {
        jobs.push(Job::new(STAGE, "calibration", (), tables, vec![file], calibrate));
    }
    jobs
}

fn make_characteristic(
    parameters: &OfActuator,
    files: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let (sweeps, problems) = read_sweeps(files)?;
    let first =
        sweeps.first().ok_or_else(|| format!("no sweep could be read: {}", problems.join("; ")))?;
    let command_unit = &first.command.unit;
    let response_unit = &first.response.unit;
    let settings = Settings {
        resamples: parameters.resamples,
        seed: parameters.seed,
        level: parameters.level,
        command_unit: command_unit.clone(),
        response_unit: response_unit.clone(),
    };
    let mut samples = Vec::new();
    for Sweep { command_values: command, response_values: response, .. } in &sweeps {
        samples.push(zwidth_characterise::Sweep { command, response });
    }
    let subject = Subject { actuator: parameters.actuator.as_str(), command_unit, response_unit };
    let fits = zwidth_characterise::characterise(&samples, &settings)?;
    let curve = curve_points(&samples, &fits, parameters.level)?;
    // What is swept on a simulated device is marked where it is printed.
    let tables = vec![
        subject.models_table(&fits)?,
        subject.parameters_table(&fits)?,
        subject.curve_table(&curve)?,
    ];
    Ok(Made { problems, ..write_named(tables, making, false)? })
}

/// The calibration, if motor and brake were both swept. It has no comment and no provenance, so
/// that the same curves give the same hash, whoever writes them.
fn calibrate(
    (): &(),
    (motor, brake): &(Characterisation, Characterisation),
    _: &Making,
) -> Result<Made, JobError> {
    // By knots, from the tables of an actuator.
    let characteristic = |actuator, tables: &Characterisation| -> Result<_, JobError> {
        Ok(calibrated(actuator, &tables.read()?.chosen(actuator)?)?)
    };
    let motor = characteristic("motor", motor)?;
    let brake = characteristic("brake", brake)?;
    let text = Calibration { motor, brake }.to_toml()?;
    // Sessions will refuse a calibration that cannot be read: it is an error here, not there.
    Calibration::from_toml(&text)?;
    Ok(Made::of(vec![text.into_bytes()]))
}
