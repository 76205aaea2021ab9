//! Stage `characterise`: candidate models, parameters and curve of each actuator or sensor; the
//! calibration.

use crate::making::{derived, write_tables};
use crate::trials::{Found, readable};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_characterise::{
    Settings, Subject, calibrated, chosen_from, curve_table, models_table, parameters_table,
};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_stability::impedance::ACTUATOR;
use zwidth_store::{Layout, StoreError, StudyData, Sweep, read_sweep};
use zwidth_study::{ActuatorId, Calibration, Characteristic};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "characterise", version: zwidth_characterise::VERSION };
/// Bootstrap resamples: the ends of a 95 % interval rest on 10 resamples each.
const RESAMPLES: usize = 400;
/// Seed of the bootstrap; part of the result.
const SEED: u64 = 1;

/// Tables of an actuator: models, parameters, curve.
pub(crate) fn tables_of(layout: &Layout, actuator: &ActuatorId) -> [PathBuf; 3] {
    ["characteristic", "parameters", "curve"]
        .map(|what| derived(layout, format!("characterise/{what}.{actuator}.parquet")))
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
        let outputs = tables_of(&data.layout, actuator).to_vec();
        let name = format!("characteristic of {actuator}");
        let of = OfActuator { actuator: actuator.clone(), level, resamples: RESAMPLES, seed: SEED };
        Job::new(STAGE, name, of, files, outputs, make_characteristic)
    };
    let tables = |name: &str| {
        let (actuator, _) = actuators(data).into_iter().find(|(id, _)| id.as_str() == name)?;
        Some(tables_of(&data.layout, actuator))
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
    let (command_unit, response_unit) = (&first.command.unit, &first.response.unit);
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
    let tables = [
        models_table(subject, &found)?,
        parameters_table(subject, &found)?,
        curve_table(subject, &samples, &found, of.level)?,
    ];
    write_tables(&tables, making, problems)
}

fn samples(sweep: &Sweep) -> zwidth_characterise::Sweep<'_> {
    zwidth_characterise::Sweep { command: &sweep.command_values, response: &sweep.response_values }
}

/// The calibration, if motor and brake were both swept. It has no comment and no provenance, so
/// that the same curves give the same hash, whoever writes them.
fn calibrate(
    (): &(),
    (motor, brake): &([PathBuf; 3], [PathBuf; 3]),
    _: &Making,
) -> Result<Made, JobError> {
    let (motor, brake) = (characteristic("motor", motor)?, characteristic("brake", brake)?);
    let text = Calibration { motor, brake }.to_toml()?;
    Calibration::from_toml(&text)?;
    Ok(Made::of(vec![text.into_bytes()]))
}

/// The characteristic by knots, from an actuator's tables.
fn characteristic(
    actuator: &'static str,
    tables: &[PathBuf; 3],
) -> Result<Characteristic, JobError> {
    let [models, parameters, curve] = tables.each_ref().map(|file| Table::from_parquet(file));
    Ok(calibrated(actuator, &chosen_from(actuator, &models?, &parameters?, &curve?)?)?)
}
