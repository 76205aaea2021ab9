//! Stage `identify`: the plant that fits half of the trials best, judged on the other half. The fit
//! balances the forces of the recorded motion, the judge is the replay driven by force; here stages
//! meet, because they do not know each other.

use super::replay::{calibration, is_replayable, named, parameters};
use super::{JobError, derived, made, paths, read_all, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_identify::{Bracket, IdentifyError, Parameter, Recording, Switching, Task};
use zwidth_replay::{Balance, Drive, Parameters, ReplayError};
use zwidth_runner::Job;
use zwidth_store::{Layout, Signal, StudyData, Trial};
use zwidth_tables::{Table, TableError};

/// Parameters of the plant.
const P: usize = 6;

/// The parameters, in the order in which a fit has them. Bounds: what a lever moved by a finger can
/// have at all.
const PLANT: [Parameter; P] = [
    parameter("mass", "kg", Parameters::BY_EYE.mass_kg, [1e-3, 2.0]),
    parameter("damping", "N·s/rad", Parameters::BY_EYE.damping_ns_per_rad, [0.0, 10.0]),
    parameter("friction", "N", Parameters::BY_EYE.friction_n, [0.0, 2.0]),
    parameter("motor_lag", "s", Parameters::BY_EYE.motor_lag_s, [0.0, 0.05]),
    parameter("brake_on", "s", Parameters::BY_EYE.brake_on_s, [0.0, 0.2]),
    parameter("brake_off", "s", Parameters::BY_EYE.brake_off_s, [0.0, 0.2]),
];

const fn parameter(
    name: &'static str,
    unit: &'static str,
    by_eye: f64,
    [lower, upper]: [f64; 2],
) -> Parameter {
    Parameter { name, unit, by_eye, lower, upper }
}

/// Where else the fit begins: a light lever and a quick brake, and a heavy one and a slow brake.
const STARTS: [[f64; P]; 2] =
    [[0.05, 0.1, 0.1, 1e-4, 0.01, 0.01], [0.3, 0.3, 0.2, 1e-3, 0.05, 0.05]];

/// The parameters, their profiles, the threshold's bracket, by eye against fitted on trials held
/// out, and the errors trial by trial.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    ["identify", "identify.profile", "identify.threshold", "identify.held_out", "identify.trials"]
        .iter()
        .map(|name| derived(layout, format!("{name}.parquet")))
        .collect()
}

/// The parameters.
pub(super) fn plant_of(layout: &Layout) -> PathBuf {
    derived(layout, "identify.parquet")
}

/// The plant of a table of parameters; `None` where nothing was fitted.
pub(super) fn fitted(table: &Table) -> Result<Option<Parameters>, TableError> {
    let values: Vec<f64> = table.floats("fitted")?.into_iter().flatten().collect();
    Ok(<[f64; P]>::try_from(values).ok().map(|values| plant(&values)))
}

fn plant(
    &[mass_kg, damping_ns_per_rad, friction_n, motor_lag_s, brake_on_s, brake_off_s]: &[f64; P],
) -> Parameters {
    Parameters { mass_kg, damping_ns_per_rad, friction_n, motor_lag_s, brake_on_s, brake_off_s }
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let trials: Vec<_> = data.counting().filter(|t| is_replayable(data, t)).collect();
    if trials.is_empty() {
        return Vec::new();
    }
    let (inputs, outputs) = (paths(&trials), tables_of(&data.layout));
    let (out, parameters) = (outputs.clone(), parameters(data, &trials));
    let make = move |from: &_| {
        let (trials, mut problems) = read_all(&trials, Signal::all());
        let (fitted, more) = fitted_trials(data, &trials);
        problems.extend(more);
        let mut tables = tables(&fitted, data.study.analysis.confidence)?;
        let bracket = Bracket::of(trials.iter().filter_map(|trial| switching(data, trial)));
        tables.insert(2, zwidth_identify::threshold(&bracket, data.study.control.let_go_n)?);
        made(&tables, &out, from, problems)
    };
    vec![Job {
        stage: "identify",
        name: "identify".to_owned(),
        version: zwidth_identify::VERSION,
        parameters: format!(
            "{parameters}; {:?}",
            (PLANT, STARTS, LEAST_STEP_S, zwidth_replay::VERSION)
        ),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}

/// A trial that can be fitted and replayed.
struct Fitted<'t> {
    trial: &'t Trial,
    balance: Balance,
    drive: Drive,
    /// Where the replay is judged, s, and the recorded angle there, rad.
    t_s: Vec<f64>,
    theta_rad: Vec<f64>,
}

/// Samples at least this far apart are judged, s: those between say nothing new of a movement of
/// the hand.
const LEAST_STEP_S: f64 = 0.004;

impl<'t> Fitted<'t> {
    fn new(trial: &'t Trial, balance: Balance, drive: Drive) -> Self {
        let (mut t_s, mut theta_rad) = (Vec::new(), Vec::new());
        let recorded = drive.recorded();
        for (t, theta) in recorded.t_s.iter().zip(&recorded.theta_rad) {
            if t_s.last().is_none_or(|last| t - last >= LEAST_STEP_S) {
                t_s.push(*t);
                theta_rad.push(*theta);
            }
        }
        Self { trial, balance, drive, t_s, theta_rad }
    }

    /// Root mean square error of θ, rad, of the replay driven by force; `None` where the model does
    /// not run.
    fn rmse_rad(&self, plant: &Parameters) -> Option<f64> {
        let replayed = self.drive.theta_at(&self.t_s, plant).ok()?;
        let squares: f64 =
            replayed.iter().zip(&self.theta_rad).map(|(r, o)| (r - o) * (r - o)).sum();
        Some((squares / self.theta_rad.len() as f64).sqrt())
    }
}

/// Every trial that can be fitted and replayed; those to which that does not apply are no problem.
fn fitted_trials<'t>(data: &StudyData, trials: &'t [Trial]) -> (Vec<Fitted<'t>>, Vec<String>) {
    let both = |trial: &Trial| {
        let calibration = calibration(data, &trial.meta);
        let balance = Balance::new(trial, &data.study, calibration)?;
        Ok((balance, Drive::new(trial, &data.study, calibration)?))
    };
    let one = |trial: &'t Trial| match both(trial) {
        Ok((balance, drive)) => Ok(Some(Fitted::new(trial, balance, drive))),
        Err(ReplayError::WhyNot(_)) => Ok(None),
        Err(error) => Err(format!("{}: {error}", named(&trial.meta))),
    };
    let (found, problems) = split(trials.par_iter().map(one).collect());
    (found.into_iter().flatten().collect(), problems)
}

/// What the controller saw and did; `None` where that was not recorded, or the mode has not both
/// motor and brake.
fn switching<'t>(data: &StudyData, trial: &'t Trial) -> Option<Switching<'t>> {
    let column = |signal| trial.samples.get(signal);
    let mode = data.study.mode(&trial.meta.mode)?;
    mode.motor_max_v.zip(mode.brake_max_v).filter(|(motor, brake)| *motor > 0.0 && *brake > 0.0)?;
    Some(Switching {
        theta_dot_rad_s: column(Signal::ThetaDot)?,
        force_n: column(Signal::ForceEx)?,
        motor_v: column(Signal::VoltageMotor)?,
        brake_v: column(Signal::VoltageBrake)?,
    })
}

/// The tables of a fit; empty ones that say why where there is too little to fit.
fn tables(trials: &[Fitted], level: f64) -> Result<Vec<Table>, JobError> {
    let recordings: Vec<Recording> = trials
        .iter()
        .map(|t| Recording { meta: &t.trial.meta, observed: t.balance.measured_ns() })
        .collect();
    let task = Task { parameters: &PLANT, starts: &STARTS, level };
    let explain = |i: usize, p: &[f64; P]| Some(trials[i].balance.needed_ns(&plant(p)));
    let judge = |i: usize, p: &[f64; P]| trials[i].rmse_rad(&plant(p));
    match zwidth_identify::identify(&recordings, &task, explain, judge) {
        Ok(found) => Ok(vec![
            zwidth_identify::estimates(&found)?,
            zwidth_identify::profiles(&found.estimates)?,
            zwidth_identify::against_eye(&found.trials)?,
            zwidth_identify::trials(&found.trials)?,
        ]),
        Err(why @ IdentifyError::TooFew { .. }) => Ok(vec![
            zwidth_identify::nothing_fitted(&why.to_string())?,
            zwidth_identify::profiles(&[])?,
            zwidth_identify::against_eye(&[])?,
            zwidth_identify::trials(&[])?,
        ]),
        Err(error) => Err(error.into()),
    }
}

#[cfg(test)]
mod tests;
