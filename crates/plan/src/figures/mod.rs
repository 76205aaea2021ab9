//! Stage `figures`: each figure as SVG, PDF and PNG, with its data beside it.

pub(crate) mod captions;
pub(crate) mod design;
pub(crate) mod drawing;
pub(crate) mod font;
pub(crate) mod schematics;

use crate::characterise::{self, Characterisation};
use crate::figures::drawing::{Drawing, Figured};
use crate::likert::figures as likert_figures;
use crate::replay::figures as replay_figures;
use crate::shared::conditions::{Repeats, Session, sessions};
use crate::shared::handle::Derived;
use crate::shared::trials::{MOST_DRAWN, Recordings, TrialLabel, files, label_trials, read_drawn};
use crate::{average, compare, curves, freemotion, ladder, metrics, scenes, thresholds, trade};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_characterise::Fit;
use zwidth_draw::Figure;
use zwidth_figures::{
    About, Averages, CHARACTERISTIC, Caption, Characterised, FORCE_MAGNITUDE, FREE_MOTION, Found,
    LOOPS, Loaded, MODES, REPEATS, SIGNALS, SPACE, SPACE_SIGNALS, with_care, with_push,
    with_thinned,
};
use zwidth_results::FreePlane;
use zwidth_runner::{Inputs, Job, JobError};
use zwidth_store::{Asked, Signal, StudyData, TrialEntry, check_trial};
use zwidth_study::{Alignment, Axes, Environment, ModeId, OwnFigures};
use zwidth_tables::{Measured, Table};

/// Every figure that a run makes.
pub(crate) fn of_run(data: &StudyData) -> Vec<Drawing> {
    let mut sessions = sessions(data);
    let n = sessions.len();
    sessions.retain(|session| data.study.figures.has_own(&session.ids(), n));
    let mut drawings = of_sessions(data, sessions);
    let n = data.sessions.len();
    let has_own = |ids: &[String; 2]| data.study.figures.has_own(ids, n);
    drawings.extend(thresholds::figures::all(data, has_own));
    drawings
}

/// How many sessions have figures that are made on demand alone.
pub(crate) fn without_own(data: &StudyData) -> usize {
    let all = sessions(data);
    all.iter().filter(|s| !data.study.figures.has_own(&s.ids(), all.len())).count()
}

/// Every figure that can be made, on demand or by a run.
fn all(data: &StudyData) -> Vec<Drawing> {
    let mut drawings = of_sessions(data, sessions(data));
    drawings.extend(thresholds::figures::all(data, |_| true));
    drawings
}

/// The job of a figure that is made on demand.
pub fn on_demand(data: &StudyData, stem: &str) -> Option<Job> {
    all(data).into_iter().find(|drawing| drawing.caption.stem() == stem).map(|drawing| drawing.job)
}

/// Every figure of these sessions and of the study as a whole.
fn of_sessions(data: &StudyData, sessions: Vec<Session>) -> Vec<Drawing> {
    let mut drawings = compare::verdict_figures(data);
    for session in &sessions {
        let mut environments: Vec<&Environment> =
            data.study.environments.iter().filter(|e| !session.of(e).is_empty()).collect();
        for environment in &environments {
            drawings.extend(in_space(data, session, environment));
            // In a study with axes there may be no projection on the push, and so nothing of one coordinate.
            let is_of_one = |trial: &&TrialEntry| {
                let signals = &trial.said.signals;
                signals.contains(&Signal::Theta) || signals.contains(&Signal::ForceEx)
            };
            if data.study.axes.is_some() && !session.of(environment).iter().any(is_of_one) {
                continue;
            }
            let subject = session.ids_with(environment);
            let stem = Caption::new(MODES, subject.clone()).stem();
            let alignment = data.study.figures.alignment(&stem);
            // On axes that hold the environments beside it too.
            let beside = environments.iter().filter(|other| other.id != environment.id);
            let parts = [environment].into_iter().chain(beside).map(|other| {
                let trials = session.of(other);
                let conditions = conditions(data, session, other);
                let part = recorded(data, session, other, alignment, &trials, &conditions);
                // The others only widen the axes, and means lie within their trials.
                if other.id == environment.id { part } else { without_means(part) }
            });
            let (all, files): (Vec<_>, Vec<_>) = parts.unzip();
            let n = session.of(environment).len();
            drawings.push(Drawing::new(data, MODES, subject, all, files, draw_modes).of(n));
            drawings.extend(repeats(data, session, environment));
        }
        environments.retain(|e| e.scene.spring().is_some());
        if environments.is_empty() {
            continue;
        }
        let parts = environments.iter().map(|environment| {
            let trials = session.of(environment);
            let conditions = conditions(data, session, environment);
            let (recorded, files) =
                recorded(data, session, environment, Alignment::Onset, &trials, &conditions);
            // Nothing stands against time.
            (recorded, Files { averages: Vec::new(), ..files })
        });
        let (all, files): (Vec<_>, Vec<_>) = parts.unzip();
        let n = environments.iter().map(|environment| session.of(environment).len()).sum();
        drawings.push(Drawing::new(data, LOOPS, session.ids(), all, files, draw_loops).of(n));
    }
    drawings.extend(characterise::actuators(data).into_iter().map(|(actuator, sweeps)| {
        let parameters = (actuator.to_string(), data.study.analysis.confidence);
        let tables = Characterisation::of(&data.layout, actuator);
        let subject = [actuator.to_string()];
        let n = sweeps.len();
        let inputs = (sweeps, tables);
        Drawing::new(data, CHARACTERISTIC, subject, parameters, inputs, characteristic).of(n)
    }));
    drawings.extend(freemotion::planes(data).map(|table| {
        Drawing::new(data, FREE_MOTION, [""; 0], About::of(&data.study), table, free_motion)
    }));
    drawings.extend(sessions.iter().flat_map(|session| replay_figures::of(data, session)));
    drawings.extend(ladder::figures(data));
    drawings.extend(likert_figures::all(data));
    drawings.extend(average::figure(data));
    drawings.extend(compare::figures(data));
    drawings.extend(curves::figures(data));
    drawings.extend(trade::figures(data));
    drawings.extend(scenes::figures(data));
    drawings.extend(design::all(data));
    drawings.extend(schematics::all(data));
    drawings
}

/// The name of every figure of a study, and what it shows.
pub fn captions(data: &StudyData) -> Vec<(String, String)> {
    all(data).into_iter().map(|Drawing { caption, .. }| (caption.stem(), caption.text())).collect()
}

/// The figure of that name, described from what its job reads, and what had to be left out; `None`
/// where the study has no such figure.
pub fn describe(data: &StudyData, stem: &str) -> Option<Result<(Figure, Vec<String>), JobError>> {
    let drawing = all(data).into_iter().find(|drawing| drawing.caption.stem() == stem)?;
    Some((drawing.describe)())
}

/// The choices of study.toml for figures, sessions and metrics that the study does not have. A
/// choice for a kind of figure that the study lacks is not a mistake.
pub fn chosen_in_vain(data: &StudyData) -> Vec<String> {
    let study = &data.study;
    let ids: Vec<&str> = study.figures.choices().map(|(id, _)| id).collect();
    let mut remarks = Vec::new();
    // All figures are planned for this: only if a choice names one.
    if ids.iter().any(|id| id.contains('.')) {
        let captions = captions(data);
        for id in ids.iter().filter(|id| id.contains('.')) {
            if !captions.iter().any(|(name, _)| is_below(name, id)) {
                remarks.push(format!(
                    "the choice figures.{id} of study.toml: the study has no such figure"
                ));
            }
        }
    }
    for id in ids.iter().filter(|id| is_below(id, "loops")) {
        remarks.push(format!(
            "the choice figures.{id} of study.toml: force against position is averaged at the angle, whatever is chosen; \
             remove it"
        ));
    }
    if let OwnFigures::Of(requested) = &study.figures.own {
        let existing: Vec<[String; 2]> = sessions(data).iter().map(Session::ids).collect();
        for ids in requested.iter().filter(|ids| !existing.contains(ids)) {
            let ids = ids.join(".");
            remarks.push(format!("figures.sessions of study.toml: {ids} has no trial that counts"));
        }
    }
    remarks.extend(compare::asked_in_vain(study));
    remarks
}

/// Whether a figure has an id, or one that continues it after a dot.
fn is_below(name: &str, id: &str) -> bool {
    name.strip_prefix(id).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

/// What a figure of one environment of one session depends on besides files.
#[derive(Clone, Serialize)]
struct Recorded {
    about: About,
    environment: Environment,
    who: String,
    trials: Vec<TrialLabel>,
    /// Of means against time.
    alignment: Alignment,
    /// The modes that were averaged, in the order of their tables.
    averaged: Vec<ModeId>,
    /// What decides where the repeats stand behind means aligned by landmarks, and the version of the
    /// stage that computes it.
    average: (zwidth_average::Parameters, u32),
    /// The checks by which trials are to be read with care.
    asked: Asked,
}

/// The files of one environment of one session.
#[derive(Clone)]
struct Files {
    trials: Recordings,
    /// Against time.
    averages: Vec<PathBuf>,
    /// Against position.
    loops: Vec<PathBuf>,
}

impl Inputs for Files {
    fn files(&self) -> Vec<PathBuf> {
        [self.trials.files(), self.averages.clone(), self.loops.clone()].concat()
    }
}

/// One environment of one session, with its means against time aligned so.
fn recorded(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
    alignment: Alignment,
    trials: &[&TrialEntry],
    conditions: &[Repeats],
) -> (Recorded, Files) {
    let parameters =
        zwidth_average::Parameters { analysis: data.study.analysis, scene: environment.scene };
    let recorded = Recorded {
        about: About::of(&data.study),
        environment: environment.clone(),
        who: session.who(),
        trials: label_trials(trials),
        alignment,
        averaged: conditions.iter().map(|r| r.mode.id.clone()).collect(),
        average: (parameters, zwidth_average::VERSION),
        asked: Asked::of(&data.study, &environment.id),
    };
    let files = Files {
        trials: files(trials),
        averages: conditions.iter().map(|r| average::aligned(&data.layout, r, alignment)).collect(),
        loops: conditions.iter().map(|r| average::looped(&data.layout, r)).collect(),
    };
    (recorded, files)
}

/// One environment of one session without means.
fn without_means((recorded, files): (Recorded, Files)) -> (Recorded, Files) {
    let files = Files { averages: Vec::new(), loops: Vec::new(), ..files };
    (Recorded { averaged: Vec::new(), ..recorded }, files)
}

/// The conditions of one environment of a session, in the order of the modes.
fn conditions<'a>(
    data: &'a StudyData,
    session: &Session<'a>,
    environment: &'a Environment,
) -> Vec<Repeats<'a>> {
    data.study.modes.iter().filter_map(|m| session.repeats(environment, m)).collect()
}

/// One environment of one session, read.
struct Read<'r> {
    loaded: Loaded<'r>,
    /// What had to be left out.
    problems: Vec<String>,
    /// Findings in trials that are in the figure all the same.
    findings: Vec<Found>,
    /// How many trials are drawn with fewer samples than they have.
    thinned: usize,
}

/// The figure with notes on the trials in it.
fn with_notes(figure: Figure, about: &About, reads: &[&Read]) -> Figure {
    let figure = with_push(figure, about);
    with_findings(figure, reads)
}

/// The figure with notes on what was found in the trials in it.
fn with_findings(figure: Figure, reads: &[&Read]) -> Figure {
    let findings: Vec<Found> = reads.iter().flat_map(|read| read.findings.clone()).collect();
    let thinned = reads.iter().map(|read| read.thinned).sum();
    with_care(with_thinned(figure, thinned, MOST_DRAWN), &findings)
}

/// Reads one environment of one session.
fn load<'r>(
    recorded: &'r Recorded,
    files: &Files,
    signals: &[Signal],
) -> Result<Read<'r>, JobError> {
    let signals = signals.iter().copied();
    let (drawn, problems) = read_drawn(&files.trials, &recorded.trials, signals)?;
    let thinned = drawn.iter().filter(|(trial, all)| trial.samples.len() < *all).count();
    let trials = drawn.into_iter().map(|(trial, _)| trial).collect();
    // Of trials that are to be read with care. One that cannot be read is reported where it is left out.
    let mut all_findings = Vec::new();
    for (file, label) in files.trials.iter().zip(&recorded.trials) {
        let findings = match check_trial(file, &recorded.asked) {
            // Nothing is wrong with the file itself: the job fails, and the next run makes it again.
            Err(error) if error.by_system => return Err(error.into()),
            findings => findings.unwrap_or_default(),
        };
        all_findings.extend(findings.into_iter().map(|e| Found {
            trial: label.trial,
            column: e.column.unwrap_or_default(),
            what: e.what,
        }));
    }
    let averages = Averages {
        over_time: read_means(
            &recorded.averaged,
            &files.averages,
            &zwidth_figures::average_columns(),
        )?,
        over_position: read_means(
            &recorded.averaged,
            &files.loops,
            &zwidth_figures::loop_columns(),
        )?,
    };
    let Recorded { about, environment, who, alignment, average: (parameters, _), .. } = recorded;
    let about = (about, environment, who.as_str(), *alignment, &parameters.analysis);
    let loaded = Loaded::new(about, trials, averages, |trials| {
        zwidth_average::times_s(trials, parameters, *alignment).ok()
    })?;
    Ok(Read { loaded, problems, findings: all_findings, thinned })
}

/// The columns of each mode's means.
fn read_means(
    modes: &[ModeId],
    paths: &[PathBuf],
    columns: &[String],
) -> Result<BTreeMap<ModeId, Table>, JobError> {
    let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
    let mut means = BTreeMap::new();
    for (mode, path) in modes.iter().zip(paths) {
        means.insert(mode.clone(), Table::columns_from_parquet(path, &columns)?);
    }
    Ok(means)
}

fn draw_modes(recorded: &Vec<Recorded>, files: &Vec<Files>) -> Figured {
    let (all, problems) = load_all(recorded, files)?;
    let scenes: Vec<_> = all.iter().map(|read| read.loaded.scene()).collect();
    let (scene, beside) = scenes.split_first().ok_or("there is no environment")?;
    // The others only widen the axes.
    let own: Vec<&Read> = all.iter().take(1).collect();
    Ok((with_notes(zwidth_figures::modes(scene, beside)?, scene.about, &own), problems))
}

/// Reads several environments of one session, and says what had to be left out.
fn load_all<'r>(
    recorded: &'r [Recorded],
    files: &[Files],
) -> Result<(Vec<Read<'r>>, Vec<String>), JobError> {
    let mut all = Vec::new();
    let mut problems = Vec::new();
    for (recorded, files) in recorded.iter().zip(files) {
        let mut read = load(recorded, files, &SIGNALS)?;
        problems.append(&mut read.problems);
        all.push(read);
    }
    Ok((all, problems))
}

fn repeats<'a>(
    data: &'a StudyData,
    session: &Session<'a>,
    environment: &'a Environment,
) -> Vec<Drawing> {
    let mut conditions = conditions(data, session, environment);
    // One recording is whole in the figure of the modes.
    conditions.retain(|repeats| repeats.trials.len() > 1);
    let drawings = conditions.iter().map(|repeats| {
        let mode = repeats.mode.id.to_string();
        let subject = session.ids_with(environment).into_iter().chain([mode]);
        let trials = &repeats.trials;
        let only = std::slice::from_ref(repeats);
        // Of no mean: every repeat stands at its own time.
        let (recorded, files) =
            without_means(recorded(data, session, environment, Alignment::Onset, trials, only));
        Drawing::new(data, REPEATS, subject, recorded, files, draw_repeats).of(trials.len())
    });
    drawings.collect()
}

fn draw_repeats(recorded: &Recorded, files: &Files) -> Figured {
    let read = load(recorded, files, &SIGNALS)?;
    let scene = read.loaded.scene();
    let problems = read.problems.clone();
    let Some(first) = scene.modes.first() else {
        return Err(format!("no trial could be read: {}", problems.join("; ")).into());
    };
    Ok((with_notes(zwidth_figures::repeats(&scene, first), &recorded.about, &[&read]), problems))
}

/// What the figures of several axes depend on besides files.
#[derive(Serialize)]
struct InSpace {
    recorded: Recorded,
    axes: Axes,
}

/// The paths in space, and the magnitude of the force, of one environment of a session; none in a study
/// without axes.
fn in_space(data: &StudyData, session: &Session, environment: &Environment) -> Vec<Drawing> {
    let Some(axes) = &data.study.axes else { return Vec::new() };
    let subject = session.ids_with(environment);
    let trials = session.of(environment);
    let (recorded, files) = recorded(data, session, environment, Alignment::Onset, &trials, &[]);
    let of = |recorded: Recorded| InSpace { recorded, axes: axes.clone() };
    let n = trials.len();
    // What |F| is at rest is a metric: it knows when nothing moves.
    let metrics = trials.first().map(|trial| metrics::of_session(&data.layout, &trial.meta));
    let with_metrics = (files.clone(), metrics);
    let paths = Drawing::new(data, SPACE, subject.clone(), of(recorded.clone()), files, draw_space);
    let forces =
        Drawing::new(data, FORCE_MAGNITUDE, subject, of(recorded), with_metrics, draw_force);
    vec![paths.of(n), forces.of(n)]
}

fn draw_space(InSpace { recorded, axes }: &InSpace, files: &Files) -> Figured {
    let read = load(recorded, files, &SPACE_SIGNALS)?;
    let figure = zwidth_figures::space(&read.loaded.scene(), axes);
    Ok((with_findings(figure, &[&read]), read.problems.clone()))
}

fn draw_force(
    InSpace { recorded, .. }: &InSpace,
    (files, metrics): &(Files, Option<PathBuf>),
) -> Figured {
    let read = load(recorded, files, &SPACE_SIGNALS)?;
    let mut rest_n = BTreeMap::new();
    if let Some(metrics) = metrics {
        const REST: &str = "force_magnitude_rest_n";
        let measured = Measured::read(metrics, &[REST])?;
        let scene = read.loaded.scene();
        let drawn: Vec<_> = scene.modes.iter().flat_map(|mode| &mode.repeats).collect();
        for (key, value) in measured.trials().iter().zip(measured.numbers(REST)?) {
            let is_drawn = drawn.iter().any(|repeat| {
                let meta = &repeat.trial.meta;
                (&meta.participant, &meta.session, meta.trial)
                    == (&key.participant, &key.session, key.trial)
            });
            rest_n.extend(value.filter(|_| is_drawn).map(|value| (key.trial, value)));
        }
    }
    let figure = zwidth_figures::force_magnitude(&read.loaded.scene(), &rest_n);
    Ok((with_findings(figure, &[&read]), read.problems.clone()))
}

fn draw_loops(recorded: &Vec<Recorded>, files: &Vec<Files>) -> Figured {
    let (all, problems) = load_all(recorded, files)?;
    let scenes: Vec<_> = all.iter().map(|read| read.loaded.scene()).collect();
    let reads: Vec<&Read> = all.iter().collect();
    let about = &recorded.first().ok_or("there is no environment")?.about;
    Ok((with_notes(zwidth_figures::loops(about, &scenes)?, about, &reads), problems))
}

fn characteristic(
    (actuator, level): &(String, f64),
    (files, tables): &(Vec<PathBuf>, Characterisation),
) -> Figured {
    let (sweeps, problems) = characterise::read_sweeps(files)?;
    let Fit { models, parameters, curve, .. } = &tables.read()?;
    let characterised = Characterised { models, parameters, curve, level: *level };
    Ok((zwidth_figures::characteristic(actuator, &sweeps, characterised), problems))
}

fn free_motion(about: &About, fits: &Derived<FreePlane>) -> Figured {
    let (fits, notes) = fits.read_with_notes()?;
    Ok((zwidth_figures::free_motion(about, &fits, &notes), Vec::new()))
}
