//! Stage `trade`: speed against accuracy of a study's conditions as scenes, in counts alone; the
//! effect of fewer recorded data on the metrics; and their figures.

use crate::figures::drawing::{Drawing, Figured};
use crate::replay::rendered;
use crate::shared::conditions::{Repeats, spread, trial_sources};
use crate::shared::handle::{Derived, write_named};
use crate::shared::making::{derived, join_sessions, write_tables};
use crate::shared::measured::{measured, model_samples};
use crate::shared::trials::{OfTrials, Recordings, files as trial_files, read_and_make};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_figures::{LESS, WORK_PRECISION};
use zwidth_results::{MetricShift, Row, TradeChoice, TradeSetting};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialFile};
use zwidth_study::{Calibration, Kind, Measured, Perception, Source, Status, TrialMeta};
use zwidth_tables::Table;
use zwidth_trade::{
    Bounds, Course, LONGEST, Less, Metrics, ModelScene, Parameters, Trade, TradeError, choice,
    choices_table, condition_scene, less_shifts, lessened, recordings_table, settings,
    settings_table, trade,
};

const STAGE: Stage = Stage { name: "trade", version: zwidth_trade::VERSION };

/// A condition of a study as a scene, and what its metrics depend on.
#[derive(Debug, Clone, Serialize)]
pub struct Traded {
    /// The scene.
    pub scene: ModelScene,
    metrics: zwidth_metrics::Parameters,
    metrics_version: u32,
}

impl Traded {
    /// The study's own metrics of a run, as if it had been recorded; empty if they cannot be
    /// computed.
    pub fn measure(&self, course: &Course) -> Vec<Measured> {
        let Course { t_s, theta_rad, theta_dot_rad_s, force_ex_n, feedback_n } = course;
        let samples = model_samples([t_s, theta_rad, theta_dot_rad_s, force_ex_n, feedback_n]);
        let trial = model_meta().map(|meta| Trial { meta, file: TrialFile::new(), samples });
        trial.map_or_else(Vec::new, |trial| measured(&trial, &self.metrics))
    }

    /// The trade of its scene, with its metrics.
    ///
    /// # Errors
    /// As [`trade`].
    pub fn trade(
        &self,
        scene: &ModelScene,
        parameters: &Parameters,
        progress: &(dyn Fn() + Sync),
    ) -> Result<Trade, TradeError> {
        let metrics =
            Metrics { measure: &|course| self.measure(course), bounds: &parameters.perception };
        trade(scene, parameters, Some(&metrics), progress)
    }
}

/// What stands for the trial of a model run: metrics carry it along and do not use it.
fn model_meta() -> Option<TrialMeta> {
    Some(TrialMeta {
        participant: "model".parse().ok()?,
        session: "model".parse().ok()?,
        trial: 1,
        repeat: 1,
        kind: Kind::Trial,
        status: Status::Complete,
        environment: "model".parse().ok()?,
        mode: "model".parse().ok()?,
        likert: None,
        source: Source::Twin,
        presented: None,
    })
}

/// The forces of a study's scenes: those of the first calibrated session, or else the thesis'.
pub(crate) fn scenes_calibration(data: &StudyData) -> Calibration {
    data.sessions
        .iter()
        .find_map(|session| session.record.calibration.clone())
        .unwrap_or_else(Calibration::thesis)
}

/// Every condition of a study that a model can be made of, as a scene.
pub fn scenes(data: &StudyData) -> Vec<Traded> {
    let study = &data.study;
    let calibration = scenes_calibration(data);
    let mut scenes = Vec::new();
    for environment in &study.environments {
        for mode in &study.modes {
            let scene = condition_scene(study, environment, mode, &calibration);
            scenes.extend(scene.map(|scene| Traded {
                scene,
                metrics: zwidth_metrics::Parameters::of(study, environment, mode),
                metrics_version: zwidth_metrics::VERSION,
            }));
        }
    }
    scenes
}

/// The results on the scenes: settings and choices.
type OfScenes = (Derived<TradeSetting>, Derived<TradeChoice>);

fn tables_of(layout: &Layout) -> OfScenes {
    (Derived::within(&layout.derived()), Derived::within(&layout.derived()))
}

/// The derived tables, if there are scenes. The effect of fewer recorded data has thousands of rows:
/// it is drawn, and read from its Parquet file.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    if scenes(data).is_empty() { Vec::new() } else { tables_of(&data.layout).files() }
}

/// What is recommended for each scene, where there are any.
pub(crate) fn recommended(data: &StudyData) -> Option<Derived<TradeChoice>> {
    (!scenes(data).is_empty()).then(|| tables_of(&data.layout).1)
}

/// The conditions that were rendered and recorded with angle and force: of the metrics of others it
/// is not known from which difference on they are felt.
pub(crate) fn measured_conditions(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    rendered(data).filter(|repeats| {
        repeats.trials.iter().any(|trial| {
            [Signal::Theta, Signal::ForceEx].iter().all(|s| trial.said.signals.contains(s))
        })
    })
}

/// The conditions of which fewer data are taken, with the trials that are not too long for that: each
/// of them is measured a dozen times, so in a large study those of some participants stand for all.
/// The share says how many trials that leaves if it is not all.
fn lessened_conditions(data: &StudyData) -> (Vec<Repeats<'_>>, Option<Share>) {
    let mut conditions: Vec<Repeats> = measured_conditions(data).collect();
    for repeats in &mut conditions {
        repeats.trials.retain(|trial| trial.rows <= LONGEST);
    }
    conditions.retain(|repeats| !repeats.trials.is_empty());
    let trials = conditions.iter().flat_map(|repeats| &repeats.trials);
    let rows: Vec<_> = trials.map(|trial| (&trial.meta.participant, trial.rows)).collect();
    let people = spread(&rows);
    // A condition is of one session, and so all of its trials are taken, or none.
    conditions.retain(|r| r.trials.iter().all(|trial| people.contains(&trial.meta.participant)));
    let taken: usize = conditions.iter().map(|repeats| repeats.trials.len()).sum();
    let of = rows.len();
    (conditions, (taken < of).then_some(Share { taken, of }))
}

/// How many of a study's trials stand for all of them.
#[derive(Serialize)]
struct Share {
    taken: usize,
    of: usize,
}

/// What the trade of a study depends on. Recordings are not part of it.
#[derive(Serialize)]
struct OfStudy {
    scenes: Vec<Traded>,
    perception: Perception,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    let parameters =
        OfStudy { scenes: scenes(data), perception: crate::thresholds::perception(data) };
    if !parameters.scenes.is_empty() {
        let outputs = tables_of(&data.layout).files();
        let name = "trade of the study's conditions";
        jobs.push(Job::new(STAGE, name, parameters, (), outputs, make));
    }
    let (conditions, share) = lessened_conditions(data);
    let mut sessions: Vec<Vec<Derived<MetricShift>>> = Vec::new();
    for session in conditions.chunk_by(Repeats::is_of_session_of) {
        let mut tables = Vec::new();
        for repeats in session {
            let Repeats { who, key, environment, mode, trials } = repeats;
            let condition = OfData {
                condition: key.clone(),
                metrics: zwidth_metrics::Parameters::of(&data.study, environment, mode),
                perception: crate::thresholds::perception(data),
            };
            let parameters = OfTrials::new(condition, trials);
            let table = Derived::at(derived(&data.layout, format!("trade/{key}.parquet")));
            let (name, files) = (format!("less of {who}"), trial_files(trials));
            jobs.push(Job::new(STAGE, name, parameters, files, table.files(), make_data));
            tables.push(table);
        }
        sessions.push(tables);
    }
    if !sessions.is_empty() {
        let output = Derived::<MetricShift>::within(&data.layout.derived()).files();
        let name = "less of the study's recordings";
        jobs.push(Job::new(STAGE, name, share, sessions, output, |share, sessions, making| {
            let note = share.as_ref().map(|Share { taken, of }| {
                format!("Of {of} trials, those of participants evenly spread over the list were taken: {taken} trials.")
            });
            let join = move |conditions: &[Derived<MetricShift>]| -> Result<Table, JobError> {
                let shifts = conditions.iter().map(Derived::read).collect::<Result<Vec<_>, _>>()?;
                let joined = recordings_table(&shifts.concat())?;
                Ok(note.iter().fold(joined, Table::with_note))
            };
            Ok(join_sessions(sessions, join, making))
        }));
    }
    jobs
}

/// What the change of metrics depends on besides the trials.
#[derive(Serialize)]
struct OfData {
    condition: String,
    metrics: zwidth_metrics::Parameters,
    perception: Perception,
}

fn make_data(
    parameters: &OfTrials<OfData>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let OfData { condition, metrics, perception } = &parameters.stage;
    // Of each trial a row of the whole, then one of each way to take less, or none at all: all
    // tables below have the same trials.
    let (rows, problems) = read_and_make(files, &parameters.trials, |trial| {
        let less =
            Less::ALL.map(|less| zwidth_metrics::trial_metrics(&lessened(trial, less), metrics));
        std::iter::once(zwidth_metrics::trial_metrics(trial, metrics))
            .chain(less)
            .collect::<Result<Vec<_>, _>>()
    })?;
    let table = |k: usize| {
        let rows: Vec<_> = rows.iter().map(|row: &Vec<_>| row[k].clone()).collect();
        zwidth_metrics::table(&rows, &metrics.own, metrics.axes.is_some())
    };
    let whole = table(0)?;
    let less = Less::ALL.into_iter().enumerate().map(|(k, less)| Ok((less, table(k + 1)?)));
    let less = less.collect::<Result<Vec<_>, zwidth_tables::TableError>>()?;
    let bounds = Bounds { perception, lever_m: metrics.lever_m.unwrap_or(0.0) };
    let shifts = less_shifts(condition, &whole, &less, &bounds);
    write_tables(&[recordings_table(&shifts)?], making, problems)
}

fn make(parameters: &OfStudy, (): &(), making: &Making) -> Result<Made, JobError> {
    let OfStudy { scenes, perception } = parameters;
    let trades = scenes.par_iter().map(|traded| {
        traded.trade(&traded.scene, &Parameters::reduced(&traded.scene, perception), &|| ())
    });
    let trades: Vec<Trade> = trades.collect::<Result<_, _>>()?;
    let choices: Vec<TradeChoice> = trades.iter().map(choice).collect();
    let settings = settings_table(TradeSetting::TITLE, &settings(&trades))?;
    let choices = choices_table(TradeChoice::TITLE, &choices)?;
    write_named(vec![settings, choices], making, false)
}

/// One figure per scene, and one of fewer recorded data.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let tables = tables_of(&data.layout);
    let mut drawings = Vec::new();
    for Traded { scene, .. } in scenes(data) {
        // Dots part the words of a figure's id.
        let subject = [scene.name.replace('.', "_")];
        let tables = tables.clone();
        drawings.push(Drawing::new(data, WORK_PRECISION, subject, scene.name, tables, draw));
    }
    let (conditions, share) = lessened_conditions(data);
    if !conditions.is_empty() {
        let table = Derived::within(&data.layout.derived());
        let all = data.counting().filter(|t| t.rows <= LONGEST).count();
        let trials = share.map_or(all, |share| share.taken);
        let sources = trial_sources(data);
        drawings.push(Drawing::new(data, LESS, [""; 0], sources, table, draw_less).of(trials));
    }
    drawings
}

fn draw_less(sources: &Vec<Source>, table: &Derived<MetricShift>) -> Figured {
    let notes = table.notes()?;
    let parts = table.parts()?;
    Ok((zwidth_figures::less(MetricShift::TITLE, &notes, parts, sources)?, Vec::new()))
}

fn draw(scene: &String, (settings, choices): &OfScenes) -> Figured {
    let settings = settings.read()?;
    let choices = choices.read()?;
    Ok((zwidth_figures::work_precision_of(scene, &settings, &choices), Vec::new()))
}
