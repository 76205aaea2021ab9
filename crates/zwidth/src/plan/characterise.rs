//! Stage `characterise`: candidate models, parameters and curve of each actuator or sensor; the
//! calibration.

use super::{JobError, derived, made, split};
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_characterise::{
    Settings, Subject, calibrated, chosen_from, curve_table, models_table, parameters_table,
};
use zwidth_runner::{Job, Made};
use zwidth_store::{Layout, StudyData, Sweep, read_sweep};
use zwidth_study::{ActuatorId, Calibration, Characteristic};
use zwidth_tables::Table;

/// Bootstrap resamples: the ends of a 95 % interval rest on 10 resamples each.
const RESAMPLES: usize = 400;
/// Seed of the bootstrap; part of the result.
const SEED: u64 = 1;

/// Tables of an actuator: models, parameters, curve.
pub(super) fn tables_of(layout: &Layout, actuator: &ActuatorId) -> Vec<PathBuf> {
    let name = |what: &str| derived(layout, format!("characterise/{what}.{actuator}.parquet"));
    vec![name("characteristic"), name("parameters"), name("curve")]
}

/// The calibration: the file whose content trials name by its hash.
pub(crate) fn calibration_of(layout: &Layout) -> PathBuf {
    derived(layout, "characterise/calibration.toml")
}

/// Every actuator or sensor with sweeps, and their files.
pub(super) fn actuators(data: &StudyData) -> Vec<(&ActuatorId, Vec<PathBuf>)> {
    let ids: BTreeSet<&ActuatorId> = data.sweeps.iter().map(|s| &s.actuator).collect();
    let files = |id: &ActuatorId| {
        data.sweeps.iter().filter(|s| s.actuator == *id).map(|s| s.path.clone()).collect::<Vec<_>>()
    };
    ids.into_iter().map(|id| (id, files(id))).collect()
}

/// Reads sweeps; one of other quantities than the first is left out and told.
pub(super) fn read_sweeps(files: &[PathBuf]) -> (Vec<Sweep>, Vec<String>) {
    let (sweeps, mut problems) = split(files.iter().map(|f| read_sweep(f)).collect());
    let Some(first) = sweeps.first().cloned() else { return (sweeps, problems) };
    let fits = |s: &Sweep| s.command == first.command && s.response == first.response;
    for other in sweeps.iter().filter(|s| !fits(s)) {
        problems.push(format!(
            "sweep {} of the {}: {} ({}) against {} ({}) does not go with the first sweep's {} ({}) against {} ({})",
            other.sweep, other.actuator, other.response.name, other.response.unit, other.command.name,
            other.command.unit, first.response.name, first.response.unit, first.command.name, first.command.unit,
        ));
    }
    (sweeps.into_iter().filter(fits).collect(), problems)
}

/// The study's own calibration file, where motor and brake were both swept.
pub(super) fn calibration(data: &StudyData) -> Option<PathBuf> {
    let swept = |name: &str| actuators(data).iter().any(|(id, _)| id.as_str() == name);
    (swept("motor") && swept("brake")).then(|| calibration_of(&data.layout))
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let actuators = actuators(data);
    let tables = |name: &str| {
        let (actuator, _) = actuators.iter().find(|(id, _)| id.as_str() == name)?;
        Some(tables_of(&data.layout, actuator))
    };
    let calibration = tables("motor").zip(tables("brake"));
    let calibration = calibration.map(|(motor, brake)| calibration_job(data, motor, brake));
    actuators
        .into_iter()
        .map(|(actuator, files)| job(data, actuator, files))
        .chain(calibration)
        .collect()
}

/// The calibration, where motor and brake were both swept.
fn calibration_job(data: &StudyData, motor: Vec<PathBuf>, brake: Vec<PathBuf>) -> Job<'_> {
    Job {
        stage: "characterise",
        name: "calibration".to_owned(),
        version: zwidth_characterise::VERSION,
        parameters: String::new(),
        inputs: motor.iter().chain(&brake).cloned().collect(),
        outputs: vec![calibration_of(&data.layout)],
        tolerant: false,
        make: Box::new(move |_| {
            let (motor, brake) =
                (characteristic("motor", &motor)?, characteristic("brake", &brake)?);
            // No comment, no provenance: the same curves give the same hash, whoever writes them.
            let text = Calibration { motor, brake }.to_toml()?;
            Calibration::from_toml(&text)?;
            Ok(Made { outputs: vec![text.into_bytes()], ..Made::default() })
        }),
    }
}

/// The characteristic by knots, from an actuator's tables.
fn characteristic(actuator: &'static str, tables: &[PathBuf]) -> Result<Characteristic, JobError> {
    let [models, parameters, curve] = [0, 1, 2].map(|i| Table::from_parquet(&tables[i]));
    Ok(calibrated(actuator, &chosen_from(actuator, &models?, &parameters?, &curve?)?)?)
}

fn job<'a>(data: &'a StudyData, actuator: &'a ActuatorId, inputs: Vec<PathBuf>) -> Job<'a> {
    let outputs = tables_of(&data.layout, actuator);
    let level = data.study.analysis.confidence;
    let (files, out) = (inputs.clone(), outputs.clone());
    Job {
        stage: "characterise",
        name: format!("characteristic of {actuator}"),
        version: zwidth_characterise::VERSION,
        parameters: format!("level {level}, {RESAMPLES} resamples, seed {SEED}"),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (sweeps, problems) = read_sweeps(&files);
            let first = sweeps
                .first()
                .ok_or_else(|| format!("no sweep could be read: {}", problems.join("; ")))?;
            let (command_unit, response_unit) = (&first.command.unit, &first.response.unit);
            let settings = Settings {
                resamples: RESAMPLES,
                seed: SEED,
                level,
                command_unit: command_unit.clone(),
                response_unit: response_unit.clone(),
            };
            let samples: Vec<_> = sweeps.iter().map(samples).collect();
            let of = Subject { actuator: actuator.as_str(), command_unit, response_unit };
            let found = zwidth_characterise::characterise(&samples, &settings)?;
            let tables = [
                models_table(of, &found)?,
                parameters_table(of, &found)?,
                curve_table(of, &samples, &found, level)?,
            ];
            made(&tables, &out, from, problems)
        }),
    }
}

fn samples(sweep: &Sweep) -> zwidth_characterise::Sweep<'_> {
    zwidth_characterise::Sweep { command: &sweep.command_values, response: &sweep.response_values }
}
