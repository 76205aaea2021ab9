//! Stage `characterise`: candidate models, parameters and curve of each actuator or sensor; the
//! calibration.

use crate::shared::handle::{Derived, Written};
use crate::shared::making::derived;
use crate::shared::trials::{Found, readable};
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
use zwidth_study::{ActuatorId, Calibration, Characteristic};
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
        fn table<R: Row>(layout: &Layout, actuator: &ActuatorId) -> Derived<R> {
            let name = format!("characterise/{}.{actuator}.parquet", R::NAME);
            Derived::at(derived(layout, name))
        }
        Self {
            models: table(layout, actuator),
            parameters: table(layout, actuator),
            curve: table(layout, actuator),
        }
    }

    /// What was found.
    ///
    /// # Errors
    /// A file that cannot be read, or has other rows.
    pub(crate) fn read(&self) -> Result<Fit, TableError> {
        let curve = Table::from_parquet(self.curve.path())?;
        let unit = |open| curve.unit_for::<CurvePoint>(open).unwrap_or_default().to_owned();
        Ok(Fit {
            models: self.models.read()?,
            parameters: self.parameters.read()?,
            curve: curve.to_rows()?,
            command_unit: unit(UNIT_OF_COMMAND),
            response_unit: unit(UNIT_OF_RESPONSE),
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
    let swept = data.sweeps.iter().map(|s| &s.actuator);
    let ids: BTreeSet<&ActuatorId> = swept.filter(|id| id.as_str() != ACTUATOR).collect();
    ids.into_iter().map(|id| (id, files_of(data, id))).collect()
}

/// The sweeps of one actuator or sensor.
fn files_of(data: &StudyData, id: &ActuatorId) -> Vec<PathBuf> {
    data.sweeps.iter().filter(|s| s.actuator == *id).map(|s| s.path.clone()).collect()
}

/// Reads sweeps. A sweep of other quantities than the first one is left out and reported.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_sweeps(files: &[PathBuf]) -> Result<Found<Sweep>, StoreError> {
    let (sweeps, mut problems) = readable(files.iter().map(|f| read_sweep(f)).collect())?;
    let Some(first) = sweeps.first().cloned() else { return Ok((sweeps, problems)) };
    let others = sweeps.iter().filter(|s| !s.is_like(&first));
    problems.extend(others.map(|other| other.unlike(&first)));
    Ok((sweeps.into_iter().filter(|s| s.is_like(&first)).collect(), problems))
}

/// The study's own calibration, where motor and brake were both swept: the file whose content
/// trials name by its hash.
pub(crate) fn calibration(data: &StudyData) -> Option<PathBuf> {
    let swept = |name: &str| data.sweeps.iter().any(|s| s.actuator.as_str() == name);
    let both = swept("motor") && swept("brake");
    both.then(|| derived(&data.layout, "characterise/calibration.toml"))
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
    let characteristic = |(actuator, files): (&ActuatorId, Vec<PathBuf>)| {
        let outputs = Characterisation::of(&data.layout, actuator).files();
        let name = format!("characteristic of {actuator}");
        let of = OfActuator { actuator: actuator.clone(), level, resamples: RESAMPLES, seed: SEED };
        Job::new(STAGE, name, of, files, outputs, make_characteristic)
    };
    let tables = |name: &str| {
        let (actuator, _) = actuators(data).into_iter().find(|(id, _)| id.as_str() == name)?;
        Some(Characterisation::of(&data.layout, actuator))
    };
    let both = tables("motor").zip(tables("brake")).zip(calibration(data));
    let calibration = both
        .map(|(tables, file)| Job::new(STAGE, "calibration", (), tables, vec![file], calibrate));
    actuators(data).into_iter().map(characteristic).chain(calibration).collect()
}

fn make_characteristic(
    of: &OfActuator,
    files: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let (sweeps, problems) = read_sweeps(files)?;
    let first =
        sweeps.first().ok_or_else(|| format!("no sweep could be read: {}", problems.join("; ")))?;
    let command_unit = &first.command.unit;
    let response_unit = &first.response.unit;
    let settings = Settings {
        resamples: of.resamples,
        seed: of.seed,
        level: of.level,
        command_unit: command_unit.clone(),
        response_unit: response_unit.clone(),
    };
    let samples: Vec<_> = sweeps.iter().map(samples).collect();
    let subject = Subject { actuator: of.actuator.as_str(), command_unit, response_unit };
    let found = zwidth_characterise::characterise(&samples, &settings)?;
    let curve = curve_points(&samples, &found, of.level)?;
    // What is swept on a simulated device is marked where it is printed.
    let made = Written::begin(making, false)
        .table(subject.models_table(&found)?)?
        .table(subject.parameters_table(&found)?)?
        .table(subject.curve_table(&curve)?)?
        .end()?;
    Ok(Made { problems, ..made })
}

fn samples(sweep: &Sweep) -> zwidth_characterise::Sweep<'_> {
    zwidth_characterise::Sweep { command: &sweep.command_values, response: &sweep.response_values }
}

/// The calibration, if motor and brake were both swept. It has no comment and no provenance, so
/// that the same curves give the same hash, whoever writes them.
fn calibrate(
    (): &(),
    (motor, brake): &(Characterisation, Characterisation),
    _: &Making,
) -> Result<Made, JobError> {
    let motor = characteristic("motor", motor)?;
    let brake = characteristic("brake", brake)?;
    let text = Calibration { motor, brake }.to_toml()?;
    Calibration::from_toml(&text)?;
    Ok(Made::of(vec![text.into_bytes()]))
}

/// The characteristic by knots, from what was found of an actuator.
fn characteristic(
    actuator: &'static str,
    found: &Characterisation,
) -> Result<Characteristic, JobError> {
    Ok(calibrated(actuator, &found.read()?.chosen(actuator)?)?)
}
