//! Stage `trade`: speed against accuracy of a study's conditions as scenes, in counts alone; the
//! effect of fewer recorded data on the metrics; and their figures.

use crate::figures::drawing::{Drawing, Figured};
use crate::replay::rendered;
use crate::shared::conditions::{Repeats, spread};
use crate::shared::handle::{Derived, Written};
use crate::shared::making::{derived, join_sessions, split, write_tables};
use crate::shared::measured::measured;
use crate::shared::trials::{OfTrials, Recordings, files as trial_files, name, read_all};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_figures::{FigureKind, LESS, WORK_PRECISION};
use zwidth_results::{MetricShift, Row, TradeChoice, TradeSetting};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Samples, Signal, StudyData, Trial, TrialEntry, TrialFile};
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
        let mut samples = Samples::default();
        samples.set(Signal::Time, course.t_s.clone());
        samples.set(Signal::Theta, course.theta_rad.clone());
        samples.set(Signal::ThetaDot, course.theta_dot_rad_s.clone());
        samples.set(Signal::ForceEx, course.force_ex_n.clone());
        samples.set(Signal::ForceCmd, course.feedback_n.clone());
        let trial = nobody().map(|meta| Trial { meta, file: TrialFile::new(), samples });
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
        let measure = |course: &Course| self.measure(course);
        let metrics = Metrics { measure: &measure, bounds: &parameters.perception };
        trade(scene, parameters, Some(&metrics), progress)
    }
}

/// Who "recorded" a model run: metrics carry it along and do not look at it.
fn nobody() -> Option<TrialMeta> {
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
    })
}

/// The forces of a study's scenes: those of a session's calibration, or else the thesis'.
pub(crate) fn scenes_calibration(data: &StudyData) -> Calibration {
    let of_session = data.sessions.iter().find_map(|s| s.record.calibration.clone());
    of_session.unwrap_or_else(Calibration::thesis)
}

/// Every condition of a study that a model can be made of, as a scene.
pub fn scenes(data: &StudyData) -> Vec<Traded> {
    let study = &data.study;
    let calibration = scenes_calibration(data);
    let conditions =
        study.environments.iter().flat_map(|e| study.modes.iter().map(move |mode| (e, mode)));
    conditions
        .filter_map(|(e, m)| {
            Some(Traded {
                scene: condition_scene(study, e, m, &calibration)?,
                metrics: zwidth_metrics::Parameters::of(study, e, m),
                metrics_version: zwidth_metrics::VERSION,
            })
        })
        .collect()
}

/// What is found of the scenes, a table for each kind of row.
#[derive(Clone)]
struct OfScenes {
    settings: Derived<TradeSetting>,
    choices: Derived<TradeChoice>,
}

impl OfScenes {
    fn of(layout: &Layout) -> Self {
        let folder = layout.derived();
        Self { settings: Derived::within(&folder), choices: Derived::within(&folder) }
    }
}

impl Inputs for OfScenes {
    fn files(&self) -> Vec<PathBuf> {
        [self.settings.files(), self.choices.files()].concat()
    }
}

/// The derived tables, where there are scenes. What less of the recordings does has thousands of
/// rows: it is drawn, and read from its Parquet file.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    if scenes(data).is_empty() { Vec::new() } else { OfScenes::of(&data.layout).files() }
}

/// What is recommended for each scene, where there are any.
pub(crate) fn recommended(data: &StudyData) -> Option<Derived<TradeChoice>> {
    (!scenes(data).is_empty()).then(|| OfScenes::of(&data.layout).choices)
}

/// The conditions that were rendered and recorded with angle and force: others have no metric of
/// which anything is known to be felt.
pub(crate) fn measured_conditions(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    let has = |t: &TrialEntry| {
        [Signal::Theta, Signal::ForceEx].iter().all(|signal| t.said.signals.contains(signal))
    };
    rendered(data).filter(move |repeats| repeats.trials.iter().any(|t| has(t)))
}

/// The conditions of which less is taken, with the trials that are not too long for that: each of
/// them is measured a dozen times, and so in a large study those of some participants stand for
/// all. How many trials that leaves, and of how many, where it is not all.
fn lessened_conditions(data: &StudyData) -> (Vec<Repeats<'_>>, Option<Share>) {
    let of_short = measured_conditions(data).map(|mut repeats| {
        repeats.trials.retain(|trial| trial.rows <= LONGEST);
        repeats
    });
    let mut conditions: Vec<_> = of_short.filter(|repeats| !repeats.trials.is_empty()).collect();
    let trials = |conditions: &[Repeats]| conditions.iter().map(|r| r.trials.len()).sum();
    let of: usize = trials(&conditions);
    let each = conditions.iter().flat_map(|r| &r.trials);
    let rows: Vec<_> = each.map(|trial| (&trial.meta.participant, trial.rows)).collect();
    let people = spread(&rows);
    conditions.retain(|r| r.trials.iter().all(|trial| people.contains(&trial.meta.participant)));
    let taken = trials(&conditions);
    (conditions, (taken < of).then_some(Share { taken, of }))
}

/// How many of a study's trials stand for all of them.
#[derive(Serialize)]
struct Share {
    taken: usize,
    of: usize,
}

/// What less of the recordings does, where there are any.
fn shifts_of(data: &StudyData) -> Option<Derived<MetricShift>> {
    let is_any = measured_conditions(data).any(|r| r.trials.iter().any(|t| t.rows <= LONGEST));
    is_any.then(|| Derived::within(&data.layout.derived()))
}

/// What the trade of a study depends on. Recordings are not part of it.
#[derive(Serialize)]
struct OfStudy {
    scenes: Vec<Traded>,
    perception: Perception,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let of = OfStudy { scenes: scenes(data), perception: data.study.perception.clone() };
    let outputs = OfScenes::of(&data.layout).files();
    let scenes = (!of.scenes.is_empty())
        .then(|| Job::new(STAGE, "trade of the study's conditions", of, (), outputs, make));
    scenes.into_iter().chain(data_jobs(data)).collect()
}

/// What less of a condition's recordings does, and all of them joined.
fn data_jobs(data: &StudyData) -> Vec<Job> {
    let (conditions, share) = lessened_conditions(data);
    let table = |r: &Repeats| -> Derived<MetricShift> {
        Derived::at(derived(&data.layout, format!("trade/{}.parquet", r.key)))
    };
    let one = |r: &Repeats| {
        let metrics = zwidth_metrics::Parameters::of(&data.study, r.environment, r.mode);
        let of = OfTrials::new(
            OfData { condition: r.key.clone(), metrics, perception: data.study.perception.clone() },
            &r.trials,
        );
        let name = format!("less of {}", r.who);
        Job::new(STAGE, name, of, trial_files(&r.trials), table(r).files(), make_data)
    };
    let mut jobs: Vec<Job> = conditions.iter().map(one).collect();
    if !conditions.is_empty() {
        let tables: Vec<Vec<Derived<MetricShift>>> = conditions
            .chunk_by(Repeats::is_of_session_of)
            .map(|session| session.iter().map(table).collect())
            .collect();
        let output = Derived::<MetricShift>::within(&data.layout.derived()).files();
        jobs.push(Job::new(
            STAGE,
            "less of the study's recordings",
            share,
            tables,
            output,
            join_data,
        ));
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

fn make_data(of: &OfTrials<OfData>, files: &Recordings, making: &Making) -> Result<Made, JobError> {
    let (trials, mut problems) = read_all(files, &of.trials, Signal::all())?;
    let OfData { condition, metrics, perception } = &of.stage;
    let rows = |trial: &Trial| {
        let of = |trial: &Trial| zwidth_metrics::trial_metrics(trial, metrics);
        let less = Less::ALL.map(|less| of(&lessened(trial, less)));
        let all = std::iter::once(of(trial)).chain(less).collect::<Result<Vec<_>, _>>();
        all.map_err(|e| format!("{}: {e}", name(&trial.meta)))
    };
    let (rows, more) = split(trials.par_iter().map(rows).collect());
    problems.extend(more);
    let table = |k: usize| {
        zwidth_metrics::table(&rows.iter().map(|row: &Vec<_>| row[k].clone()).collect::<Vec<_>>())
    };
    let whole = table(0)?;
    let less = Less::ALL.into_iter().enumerate().map(|(k, less)| Ok((less, table(k + 1)?)));
    let less = less.collect::<Result<Vec<_>, zwidth_tables::TableError>>()?;
    let bounds = Bounds { perception, lever_m: metrics.lever_m.unwrap_or(0.0) };
    let shifts = less_shifts(condition, &whole, &less, &bounds);
    write_tables(&[recordings_table(&shifts)?], making, problems)
}

fn join_data(
    share: &Option<Share>,
    sessions: &Vec<Vec<Derived<MetricShift>>>,
    making: &Making,
) -> Result<Made, JobError> {
    let note = share.as_ref().map(|Share { taken, of }| {
        format!("Of {of} trials, those of participants evenly spread over the list were taken: {taken} trials.")
    });
    let join = move |conditions: &[Derived<MetricShift>]| {
        let shifts = conditions.iter().map(Derived::read).collect::<Result<Vec<_>, _>>()?;
        let joined = recordings_table(&shifts.concat())?;
        Ok(note.iter().fold(joined, Table::with_note))
    };
    Ok(join_sessions(sessions, join, making))
}

fn make(of: &OfStudy, (): &(), making: &Making) -> Result<Made, JobError> {
    let one = |traded: &Traded| {
        let scene = &traded.scene;
        traded.trade(scene, &Parameters::reduced(scene, &of.perception), &|| ())
    };
    let trades: Vec<Trade> = of.scenes.par_iter().map(one).collect::<Result<_, _>>()?;
    let choices: Vec<TradeChoice> = trades.iter().map(choice).collect();
    Written::begin(making, false)
        .table(settings_table(TradeSetting::TITLE, &settings(&trades))?)?
        .table(choices_table(TradeChoice::TITLE, &choices)?)?
        .end()
}

/// One figure per scene.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    const KIND: FigureKind = WORK_PRECISION;
    let found = OfScenes::of(&data.layout);
    let scenes = scenes(data).into_iter().map(|Traded { scene, .. }| {
        let inputs = found.clone();
        Drawing::new(data, KIND, [scene.name.replace('.', "_")], scene.name, inputs, draw)
    });
    let less = shifts_of(data).map(|table| {
        let sources: BTreeSet<Source> = data.counting().map(|t| t.meta.source).collect();
        let sources: Vec<Source> = sources.into_iter().collect();
        let all = || data.counting().filter(|t| t.rows <= LONGEST).count();
        let trials = lessened_conditions(data).1.map_or_else(all, |share| share.taken);
        Drawing::new(data, LESS, [""; 0], sources, table, draw_less).of(trials)
    });
    scenes.chain(less).collect()
}

fn draw_less(sources: &Vec<Source>, table: &Derived<MetricShift>) -> Figured {
    let notes = table.notes()?;
    let parts = table.parts()?;
    Ok((zwidth_figures::less(MetricShift::TITLE, &notes, parts, sources)?, Vec::new()))
}

fn draw(scene: &String, found: &OfScenes) -> Figured {
    let settings = found.settings.read()?;
    let choices = found.choices.read()?;
    Ok((zwidth_figures::work_precision_of(scene, &settings, &choices), Vec::new()))
}
