//! Stage `identify`: the plant that fits half of the trials best, judged on the other half. The fit
//! balances the forces of the recorded motion, and the replay driven by force judges it. Stages do
//! not know each other; they meet here.

use crate::replay::replayable::{rendering, replayable};
use crate::shared::conditions::spread;
use crate::shared::handle::{file_within, write_named};
use crate::shared::making::split;
use crate::shared::trials::{OfTrials, Recordings, files, name, read_all};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_identify::{Bracket, IdentifyError, Parameter, Recording, Switching, Task};
use zwidth_metrics::Plant;
use zwidth_replay::{Balance, Drive, Judged, Parameters, Rendering, ReplayError};
use zwidth_results::{
    HeldOutError, PlantCovariance, PlantEstimate, PlantParameter, PlantProfile, PlantTrialError,
    Row, ThresholdBracket,
};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StoreError, StudyData, Trial, TrialEntry};
use zwidth_study::TrialMeta;
use zwidth_tables::{Table, TableError};

const STAGE: Stage = Stage { name: "identify", version: zwidth_identify::VERSION };

/// Parameters of the plant.
const P: usize = 6;

/// The parameters, in the order in which a fit has them. Bounds: what a lever moved by a finger can
/// have at all.
const PLANT: [Parameter; P] = [
    parameter(PlantParameter::Mass, "kg", Parameters::BY_EYE.mass_kg, [1e-3, 2.0]),
    parameter(
        PlantParameter::Damping,
        "N·s/rad",
        Parameters::BY_EYE.damping_ns_per_rad,
        [0.0, 10.0],
    ),
    parameter(PlantParameter::Friction, "N", Parameters::BY_EYE.friction_n, [0.0, 2.0]),
    parameter(PlantParameter::MotorLag, "s", Parameters::BY_EYE.motor_lag_s, [0.0, 0.05]),
    parameter(PlantParameter::BrakeOn, "s", Parameters::BY_EYE.brake_on_s, [0.0, 0.2]),
    parameter(PlantParameter::BrakeOff, "s", Parameters::BY_EYE.brake_off_s, [0.0, 0.2]),
];

const fn parameter(
    name: PlantParameter,
    unit: &'static str,
    by_eye: f64,
    [lower, upper]: [f64; 2],
) -> Parameter {
    Parameter { name, unit, by_eye, lower, upper }
}

/// Where else the fit begins: a light lever and a quick brake, and a heavy one and a slow brake.
const STARTS: [[f64; P]; 2] =
    [[0.05, 0.1, 0.1, 1e-4, 0.01, 0.01], [0.3, 0.3, 0.2, 1e-3, 0.05, 0.05]];

/// The tables of the stage, empty where no trial can be replayed: the parameters, their profiles, the
/// threshold's bracket, by eye against fitted on trials held out, the errors trial by trial, and the
/// parameters' covariance.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    if replayable(data).next().is_none() {
        return Vec::new();
    }
    let names = [
        PlantEstimate::NAME,
        PlantProfile::NAME,
        ThresholdBracket::NAME,
        HeldOutError::NAME,
        PlantTrialError::NAME,
        PlantCovariance::NAME,
    ];
    names.map(|name| file_within(&data.layout.derived(), name)).to_vec()
}

/// The parameters.
pub(crate) fn plant_of(layout: &Layout) -> PathBuf {
    file_within(&layout.derived(), PlantEstimate::NAME)
}

/// The parameters and their covariance, where a trial can be replayed.
pub(crate) fn known_plant(data: &StudyData) -> Option<[PathBuf; 2]> {
    let covariances = file_within(&data.layout.derived(), PlantCovariance::NAME);
    replayable(data).next().map(|_| [plant_of(&data.layout), covariances])
}

/// Mass, damping and friction of both tables, as metrics take them; `None` where nothing was fitted
/// or a fit has no covariance.
pub(crate) fn plant_with_spread(
    estimates: &Table,
    covariances: &Table,
) -> Result<Option<Plant>, TableError> {
    let Some(fitted) = fitted(estimates)? else { return Ok(None) };
    let names = [PlantParameter::Mass, PlantParameter::Damping, PlantParameter::Friction];
    let estimates: Vec<PlantEstimate> = estimates.to_rows()?;
    let own = estimates.iter().filter(|row| names.contains(&row.parameter));
    // The fewest degrees of freedom give the widest intervals: one number stands for all three.
    let Some(df) = own.filter_map(|row| row.df).reduce(f64::min) else { return Ok(None) };
    let pairs: Vec<PlantCovariance> = covariances.to_rows()?;
    let mut covariance = [[0.0; 3]; 3];
    for (j, row) in covariance.iter_mut().enumerate() {
        for (k, value) in row.iter_mut().enumerate() {
            // Each pair stands once, in the order of the names.
            let pair = (names[j.min(k)], names[j.max(k)]);
            let row = pairs.iter().find(|row| (row.parameter, row.other) == pair);
            let Some(row) = row else { return Ok(None) };
            *value = row.covariance;
        }
    }
    let Parameters { mass_kg, damping_ns_per_rad, friction_n, .. } = fitted;
    Ok(Some(Plant { mass_kg, damping_ns_per_rad, friction_n, covariance, df }))
}

/// The plant of a table of parameters; `None` where nothing was fitted.
pub(crate) fn fitted(table: &Table) -> Result<Option<Parameters>, TableError> {
    let rows: Vec<PlantEstimate> = table.to_rows()?;
    let values: Vec<f64> = rows.iter().map(|row| row.fitted).collect();
    Ok(<[f64; P]>::try_from(values).ok().map(|values| plant(&values)))
}

fn plant(
    &[mass_kg, damping_ns_per_rad, friction_n, motor_lag_s, brake_on_s, brake_off_s]: &[f64; P],
) -> Parameters {
    Parameters { mass_kg, damping_ns_per_rad, friction_n, motor_lag_s, brake_on_s, brake_off_s }
}

/// What the fit depends on besides the trials.
#[derive(Serialize)]
struct Fit {
    /// How each trial was rendered.
    renderings: Vec<Rendering>,
    /// How many trials the study has for it, if not all of them are taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    of_trials: Option<usize>,
    level: f64,
    let_go_n: f64,
    plant: [Parameter; P],
    starts: [[f64; P]; 2],
    /// The stage that judges.
    replay_version: u32,
}

/// The trials that the plant is fitted to, of all that it could be; and how many these are.
pub(crate) fn taken(data: &StudyData) -> (Vec<&TrialEntry>, usize) {
    let mut trials: Vec<_> = replayable(data).collect();
    let all = trials.len();
    let rows: Vec<_> = trials.iter().map(|trial| (&trial.meta.participant, trial.rows)).collect();
    let people = spread(&rows);
    trials.retain(|trial| people.contains(&trial.meta.participant));
    (trials, all)
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let (trials, all) = taken(data);
    if trials.is_empty() {
        return Vec::new();
    }
    let study = &data.study;
    let renderings = trials.iter().filter_map(|TrialEntry { meta, .. }| {
        let condition = study.environment(&meta.environment).zip(study.mode(&meta.mode));
        condition.map(|(environment, mode)| rendering(data, meta, environment, mode))
    });
    let fit = Fit {
        renderings: renderings.collect(),
        of_trials: (trials.len() < all).then_some(all),
        level: study.analysis.confidence,
        let_go_n: study.control.let_go_n,
        plant: PLANT,
        starts: STARTS,
        replay_version: zwidth_replay::VERSION,
    };
    let parameters = OfTrials::new(fit, &trials);
    vec![Job::new(STAGE, "identify", parameters, files(&trials), tables(data), make)]
}

fn make(parameters: &OfTrials<Fit>, files: &Recordings, making: &Making) -> Result<Made, JobError> {
    let fit = &parameters.stage;
    // One by one: what the fit needs of a trial is a third of its samples.
    let read = (0..files.len()).into_par_iter().map(|i| {
        let (trial, problem) = read_all(&files[i..=i], &parameters.trials[i..=i], Signal::all())?;
        // Those that cannot be read keep the others with their own renderings.
        let Some((trial, rendering)) = trial.into_iter().next().zip(fit.renderings.get(i)) else {
            return Ok((Bracket::default(), Ok(None), problem));
        };
        let bracket = Bracket::of(switching(&trial, rendering));
        Ok((bracket, prepare_trial(trial, rendering), problem))
    });
    // Collected in the order of the trials, whichever thread read them: sums depend on it.
    let read: Result<Vec<_>, StoreError> = read.collect();
    let mut bracket = Bracket::default();
    let mut prepared = Vec::new();
    let mut problems = Vec::new();
    for (own_bracket, trial, problem) in read? {
        bracket = bracket.and(own_bracket);
        prepared.push(trial);
        problems.extend(problem);
    }
    let (prepared, more) = split(prepared);
    problems.extend(more);
    let prepared: Vec<Prepared> = prepared.into_iter().flatten().collect();
    let threshold = zwidth_identify::threshold(&bracket, fit.let_go_n);
    let recordings: Vec<Recording> = prepared
        .iter()
        .map(|t| Recording { meta: &t.meta, observed: t.balance.measured_ns() })
        .collect();
    let task = Task { parameters: &fit.plant, starts: &fit.starts, level: fit.level };
    let fitted = zwidth_identify::identify(
        &recordings,
        &task,
        |i, points| {
            let plants: Vec<Parameters> = points.iter().map(plant).collect();
            prepared[i].balance.needed_ns(&plants).into_iter().map(Some).collect()
        },
        |i, point| prepared[i].judged.rmse_rad(&plant(point)),
    );
    let mut tables = match fitted {
        Ok(fitted) => vec![
            zwidth_identify::estimates_table(&fitted)?,
            Table::of_rows(&zwidth_identify::profiles(&fitted.estimates))?,
            Table::of_rows(&zwidth_identify::held_out(&fitted.trials))?,
            Table::of_rows(&fitted.trials)?,
            Table::of_rows(&zwidth_identify::covariances(&fitted))?,
        ],
        // No rows, and a note that says why.
        Err(why @ IdentifyError::TooFew { .. }) => vec![
            zwidth_identify::nothing_fitted(&why.to_string())?,
            Table::of_rows::<PlantProfile>(&[])?,
            Table::of_rows(&zwidth_identify::held_out(&[]))?,
            Table::of_rows::<PlantTrialError>(&[])?,
            Table::of_rows::<PlantCovariance>(&[])?,
        ],
        Err(error) => return Err(error.into()),
    };
    tables.push(Table::of_rows(threshold.as_slice())?);
    if let Some(all) = fit.of_trials {
        let note = format!(
            "Of {all} trials that a plant can be fitted to, those of participants evenly spread over \
             the list were taken: {} trials.",
            files.len()
        );
        tables = tables.into_iter().map(|table| table.with_note(note.clone())).collect();
    }
    Ok(Made { problems, ..write_named(tables, making, false)? })
}

/// A trial that can be fitted and replayed.
struct Prepared {
    meta: TrialMeta,
    balance: Balance,
    judged: Judged,
}

/// Prepares a trial to be fitted and replayed; `None` for a trial of which neither can be expected,
/// which is no problem.
fn prepare_trial(trial: Trial, rendering: &Rendering) -> Result<Option<Prepared>, String> {
    let judged = Drive::new(&trial, rendering).map(Judged::new);
    match judged.and_then(|judged| Ok((Balance::new(&trial, rendering)?, judged))) {
        Ok((balance, judged)) => Ok(Some(Prepared { meta: trial.meta, balance, judged })),
        Err(ReplayError::WhyNot(_)) => Ok(None),
        Err(error) => Err(format!("{}: {error}", name(&trial.meta))),
    }
}

/// What the controller saw and did; `None` if that was not recorded, or the mode does not have both
/// motor and brake.
fn switching<'t>(trial: &'t Trial, rendering: &Rendering) -> Option<Switching<'t>> {
    (rendering.motor_max_v > 0.0 && rendering.brake_max_v > 0.0).then_some(())?;
    let samples = &trial.samples;
    Some(Switching {
        theta_dot_rad_s: samples.get(Signal::ThetaDot)?,
        force_n: samples.get(Signal::ForceEx)?,
        motor_v: samples.get(Signal::VoltageMotor)?,
        brake_v: samples.get(Signal::VoltageBrake)?,
    })
}

#[cfg(test)]
mod tests;
