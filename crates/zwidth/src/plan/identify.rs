//! Stage `identify`: the plant that fits half of the trials best, judged on the other half. The model is the replay's,
//! driven by force; here the two meet, because stages do not know each other.

use super::replay::{calibration, named, parameters, replayable};
use super::{JobError, derived, made, paths, read_all, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_identify::{IdentifyError, Parameter, Recording};
use zwidth_replay::{Drive, Parameters, ReplayError};
use zwidth_runner::Job;
use zwidth_store::{Layout, StudyData, Trial};
use zwidth_tables::{Table, TableError};

/// The plant's parameters, in the order in which a fit has them. Bounds: what a lever moved by a finger can have at all.
const PLANT: [Parameter; 3] = [
    Parameter { name: "mass", unit: "kg", by_eye: Parameters::BY_EYE.mass_kg, lower: 1e-3, upper: 2.0 },
    Parameter {
        name: "damping",
        unit: "N·s/rad",
        by_eye: Parameters::BY_EYE.damping_ns_per_rad,
        lower: 0.0,
        upper: 10.0,
    },
    Parameter { name: "friction", unit: "N", by_eye: Parameters::BY_EYE.friction_n, lower: 0.0, upper: 2.0 },
];

/// Where else the fit begins: less damping, and some friction; a light lever, and a heavy one.
const STARTS: [[f64; 3]; 2] = [[0.05, 0.1, 0.1], [0.3, 0.3, 0.2]];

/// The parameters, by eye against fitted on trials held out, and the errors trial by trial.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    ["identify", "identify.held_out", "identify.trials"]
        .iter()
        .map(|name| derived(layout, format!("{name}.parquet")))
        .collect()
}

/// The plant of a table of parameters; `None` where nothing was fitted.
pub(super) fn fitted(table: &Table) -> Result<Option<Parameters>, TableError> {
    let values: Vec<f64> = table.floats("fitted")?.into_iter().flatten().collect();
    Ok(<[f64; 3]>::try_from(values).ok().map(|values| plant(&values)))
}

fn plant([mass_kg, damping_ns_per_rad, friction_n]: &[f64; 3]) -> Parameters {
    Parameters { mass_kg: *mass_kg, damping_ns_per_rad: *damping_ns_per_rad, friction_n: *friction_n }
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let trials = replayable(data);
    if trials.is_empty() {
        return Vec::new();
    }
    let (inputs, outputs) = (paths(&trials), tables_of(&data.layout));
    let (out, parameters) = (outputs.clone(), parameters(data, &trials));
    let make = move |from: &_| {
        let (trials, mut problems) = read_all(&trials);
        let (fitted, more) = fitted_trials(data, &trials);
        problems.extend(more);
        made(&tables(&fitted, data.study.analysis.confidence)?, &out, from, problems)
    };
    vec![Job {
        stage: "identify",
        name: "identify".to_owned(),
        version: zwidth_identify::VERSION,
        parameters: format!("{parameters}; {:?}", (PLANT, STARTS, LEAST_STEP_S, zwidth_replay::VERSION)),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}

/// A trial that can be replayed, and what of its motion is fitted.
struct Fitted<'t> {
    trial: &'t Trial,
    drive: Drive,
    t_s: Vec<f64>,
    theta_rad: Vec<f64>,
}

/// Samples at least this far apart are fitted, s: those between say nothing new of a movement of the hand.
const LEAST_STEP_S: f64 = 0.004;

impl<'t> Fitted<'t> {
    fn new(trial: &'t Trial, drive: Drive) -> Self {
        let (mut t_s, mut theta_rad) = (Vec::new(), Vec::new());
        let recorded = drive.recorded();
        for (t, theta) in recorded.t_s.iter().zip(&recorded.theta_rad) {
            if t_s.last().is_none_or(|last| t - last >= LEAST_STEP_S) {
                t_s.push(*t);
                theta_rad.push(*theta);
            }
        }
        Self { trial, drive, t_s, theta_rad }
    }
}

/// Every trial that can be replayed; those to which a replay does not apply are no problem.
fn fitted_trials<'t>(data: &StudyData, trials: &'t [Trial]) -> (Vec<Fitted<'t>>, Vec<String>) {
    let one = |trial: &'t Trial| match Drive::new(trial, &data.study, calibration(data, &trial.meta)) {
        Ok(drive) => Ok(Some(Fitted::new(trial, drive))),
        Err(ReplayError::WhyNot(_)) => Ok(None),
        Err(error) => Err(format!("{}: {error}", named(&trial.meta))),
    };
    let (found, problems) = split(trials.par_iter().map(one).collect());
    (found.into_iter().flatten().collect(), problems)
}

/// The three tables; empty ones that say why where there is too little to fit.
fn tables(trials: &[Fitted], level: f64) -> Result<Vec<Table>, JobError> {
    let recordings: Vec<Recording> =
        trials.iter().map(|t| Recording { meta: &t.trial.meta, theta_rad: &t.theta_rad }).collect();
    let predict = |i: usize, p: &[f64; 3]| trials[i].drive.theta_at(&trials[i].t_s, &plant(p)).ok();
    match zwidth_identify::identify(&recordings, &PLANT, &STARTS, level, predict) {
        Ok(found) => Ok(vec![
            zwidth_identify::estimates(&found)?,
            zwidth_identify::against_eye(&found.trials)?,
            zwidth_identify::trials(&found.trials)?,
        ]),
        Err(why @ IdentifyError::TooFew { .. }) => Ok(vec![
            zwidth_identify::nothing_fitted(&why.to_string())?,
            zwidth_identify::against_eye(&[])?,
            zwidth_identify::trials(&[])?,
        ]),
        Err(error) => Err(error.into()),
    }
}
