//! Figure 24: for each session and environment with a spring, one trial a mode beside the model
//! that is given its external force, by eye and fitted.

use super::figures::{Described, figure_job};
use super::replay::calibration;
use super::{JobError, Session, identify, paths, replay, sessions};
use std::path::PathBuf;
use zwidth_figures::{Motion, Replayed};
use zwidth_replay::{Causality, Course, Drive, Parameters, ReplayError};
use zwidth_runner::Job;
use zwidth_store::{Signal, StudyData, TrialEntry};
use zwidth_study::{Environment, Mode};
use zwidth_tables::Table;

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let mut trials = session.of(environment);
            trials.retain(|t| replay::is_replayable(data, t));
            let conditions =
                data.study.modes.iter().filter_map(|mode| session.repeats(environment, mode));
            let replays =
                conditions.map(|repeats| replay::of_condition(&data.layout, &repeats)).collect();
            if !trials.is_empty() {
                jobs.push(job(data, &session, environment, trials, replays));
            }
        }
    }
    jobs
}

fn job<'a>(
    data: &'a StudyData,
    session: &Session,
    environment: &'a Environment,
    trials: Vec<&'a TrialEntry>,
    replays: Vec<PathBuf>,
) -> Job<'a> {
    let (who, key) = (session.who(), session.key());
    let plant = identify::plant_of(&data.layout);
    let inputs =
        paths(&trials).into_iter().chain(replays.iter().cloned()).chain([plant.clone()]).collect();
    let name = format!("replay.{key}.{}", environment.id);
    let drawn = (&data.study.title, environment, &data.study.modes, zwidth_replay::VERSION);
    let parameters = format!("{}; {drawn:?}", replay::parameters(data, &trials));
    figure_job(data, &name, inputs, parameters, move || {
        let tables =
            replays.iter().map(|f| Table::from_parquet(f)).collect::<Result<Vec<_>, _>>()?;
        let replays = zwidth_replay::together(&tables)?.ok_or("there is no trial")?;
        let plant = identify::fitted(&Table::from_parquet(&plant)?)?;
        describe(data, environment, &who, &trials, (&replays, plant))
    })
}

fn describe(
    data: &StudyData,
    environment: &Environment,
    who: &str,
    trials: &[&TrialEntry],
    (replays, fitted): (&Table, Option<Parameters>),
) -> Described {
    let mut columns = Vec::new();
    for mode in &data.study.modes {
        let mine: Vec<_> = trials.iter().copied().filter(|t| t.meta.mode == mode.id).collect();
        if let Some(trial) = typical(replays, &mine)? {
            columns.extend(column(data, mode, trial, fitted)?);
        }
    }
    if columns.is_empty() {
        return Err("no trial could be replayed: the table 'replay' says why".into());
    }
    let notes: Vec<String> = [note("by eye", Parameters::BY_EYE)]
        .into_iter()
        .chain(fitted.map(|plant| note("fitted", plant)))
        .chain(["Of each mode the trial with the median error by eye.".to_owned()])
        .collect();
    Ok((zwidth_figures::replay(&data.study, environment, who, &columns, &notes), Vec::new()))
}

/// What a model's plant is made of.
fn note(how: &str, plant: Parameters) -> String {
    let Parameters {
        mass_kg,
        damping_ns_per_rad,
        friction_n,
        motor_lag_s,
        brake_on_s,
        brake_off_s,
    } = plant;
    let lags_ms = [motor_lag_s, brake_on_s, brake_off_s].map(|lag_s| 1e3 * lag_s);
    let lags = match lags_ms.iter().any(|lag| *lag > 0.0) {
        true => format!(
            ", lags {:.2} ms (motor), {:.1} and {:.1} ms (brake on, off)",
            lags_ms[0], lags_ms[1], lags_ms[2]
        ),
        false => String::new(),
    };
    format!(
        "Model, {how}: mass {mass_kg:.3} kg, damping {damping_ns_per_rad:.3} N·s/rad, friction {friction_n:.3} N{lags}."
    )
}

/// The trial with the median error of the angle, driven by force (the lower of two); `None` where
/// none was replayed.
fn typical<'a>(
    replays: &Table,
    trials: &[&'a TrialEntry],
) -> Result<Option<&'a TrialEntry>, JobError> {
    let words = |column| replays.texts(column);
    let (participants, sessions, causalities) =
        (words("participant")?, words("session")?, words("causality")?);
    let (numbers, errors) = (replays.integers("trial")?, replays.floats("nrmse")?);
    let error = |t: &TrialEntry| {
        let is = |i: &usize| {
            causalities[*i].as_deref() == Some(Causality::ForceDriven.as_str())
                && numbers[*i] == Some(i64::from(t.meta.trial))
                && participants[*i].as_deref() == Some(t.meta.participant.as_str())
                && sessions[*i].as_deref() == Some(t.meta.session.as_str())
        };
        (0..errors.len()).find(is).and_then(|i| errors[i])
    };
    let mut known: Vec<(f64, &TrialEntry)> =
        trials.iter().filter_map(|t| Some((error(t)?, *t))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = known.len().saturating_sub(1) / 2;
    Ok(known.get(middle).map(|(_, trial)| *trial))
}

/// One trial and its models, of which a fit that does not run on it is left out; `None` where the
/// replay does not apply.
fn column(
    data: &StudyData,
    mode: &Mode,
    entry: &TrialEntry,
    fitted: Option<Parameters>,
) -> Result<Option<Replayed>, JobError> {
    let trial = entry.read(Signal::all())?;
    let drive = match Drive::new(&trial, &data.study, calibration(data, &trial.meta)) {
        Err(ReplayError::WhyNot(_)) => return Ok(None),
        other => other?,
    };
    let run =
        |plant: Parameters| drive.run(Causality::ForceDriven, &plant).map(|course| motion(&course));
    Ok(Some(Replayed {
        title: format!("{}, trial {}", mode.label, trial.meta.trial),
        source: trial.meta.source,
        recorded: motion(drive.recorded()),
        by_eye: run(Parameters::BY_EYE)?,
        fitted: fitted.and_then(|plant| run(plant).ok()),
    }))
}

fn motion(course: &Course) -> Motion {
    Motion {
        t_s: course.t_s.clone(),
        theta_rad: course.theta_rad.clone(),
        theta_dot_rad_s: course.theta_dot_rad_s.clone(),
        force_ex_n: course.force_ex_n.clone(),
        feedback_n: course.feedback_n.clone().unwrap_or_default(),
    }
}
