//! Stage `page`: the summary for a browser, `index.html`, and beside it one script of samples per
//! environment of a session, which the page loads when somebody asks for trials in it.

pub(crate) mod counted;
pub(crate) mod methods;
pub(crate) mod people;
pub(crate) mod preregistered;
pub(crate) mod summary;

use crate::compare::ScoreColumn;
use crate::figures::drawing::Drawing;
use crate::replay::courses;
use crate::replay::runs;
use crate::shared::conditions::{Repeats, Session, sessions};
use crate::shared::handle::Derived;
use crate::shared::making::read_shared;
use crate::shared::trials::{OfTrials, Recordings, files as trial_files, read_drawn};
use crate::thresholds::ThresholdColumn;
use crate::{average, compare, identify, likert, metrics, thresholds};
use serde::Serialize;
use std::path::PathBuf;
use zwidth_average::Alignment;
use zwidth_replay::Parameters;
use zwidth_report::{
    Columns, Contents, Course, Estimating, Event, Page, TURNED, TrialValues, condition_script,
    page_html, turned_script,
};
use zwidth_results::{
    CourseSample, CourseSeries, GivenAnswer, PlantRun, PsychometricFit, TrialEvent, TrialScore,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, ORIGIN, Output, Stage, WriteLong};
use zwidth_store::{Findings, Layout, Signal, StudyData, Trial};
use zwidth_study::{Environment, EnvironmentId, ModeId};
use zwidth_tables::Table;

/// Its version is raised when the page would be written differently from the same data.
const STAGE: Stage = Stage { name: "page", version: 31 };

/// The job that makes the page itself.
pub const JOB: &str = "page";

/// What the page shows of a trial.
const SIGNALS: [Signal; 7] = [
    Signal::Time,
    Signal::Theta,
    Signal::ThetaDot,
    Signal::ForceEx,
    Signal::TorqueEx,
    Signal::ForceCmd,
    Signal::StateBits,
];

/// The page's names of these signals, in their order.
const SIGNAL_NAMES: [&str; 7] = [
    "t_s",
    "theta_rad",
    "theta_dot_rad_s",
    "force_ex_n",
    "torque_ex_nm",
    "force_cmd_n",
    "state_bits",
];

/// The page's file.
pub fn file(layout: &Layout) -> PathBuf {
    layout.reports().join("index.html")
}

pub(crate) fn jobs(data: &StudyData, findings: &Findings, figures: &[Drawing]) -> Vec<Job> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            jobs.extend(samples_job(data, &session, environment));
        }
    }
    jobs.extend(sliders_job(data));
    let (summary, files) = summary::inputs(data, findings, figures);
    let settings = &data.study.compare;
    let index = Index {
        summary,
        study: data.layout.study().to_string(),
        turned: runs::turned(data).map(|(session, _)| session.ids()),
        torque: summary::has_torque_alone(data),
        estimating: Estimating {
            level: settings.level,
            alpha: settings.alpha,
            families: settings.families,
            curve_claims: compare::claims_of_both(&data.study)[0],
            has_groups: settings.groups.is_some() && people::participants(data) > 1,
            perception: crate::thresholds::perception(data),
            of_plant: compare::compared(data)
                .into_iter()
                .filter(|metric| zwidth_metrics::is_of_plant(metric))
                .collect(),
            effects: data.study.effects(),
            items: zwidth_metrics::scores(&data.study)
                .map(|(metric, score)| (metric.to_string(), score.questions.clone()))
                .collect(),
        },
        scores: ScoreColumn::compared(&data.study, &compare::compared(data)),
        thresholds: ThresholdColumn::compared(&data.study, &compare::compared(data)),
        version: env!("CARGO_PKG_VERSION"),
    };
    let files = IndexFiles {
        summary: files,
        answers: likert::answers(data),
        scores: likert::scores(data).map(|(scores, _)| scores),
        fits: thresholds::fits(data),
    };
    let output = vec![file(&data.layout)];
    jobs.push(Job::new(STAGE, JOB, index, files, output, make_index).tolerant());
    jobs
}

/// What the script of the model's runs depends on besides files.
#[derive(Serialize)]
struct Turned {
    environments: Vec<EnvironmentId>,
    by_eye: Parameters,
}

/// The script of the model's runs over its parameters, if there are any.
fn sliders_job(data: &StudyData) -> Option<Job> {
    let (session, turned) = runs::turned(data)?;
    let environments = turned.iter().map(|turned| turned.environment.id.clone()).collect();
    let files: Vec<_> = turned.into_iter().map(|turned| turned.file).collect();
    let inputs = (files, identify::plant_of(&data.layout));
    let parameters = Turned { environments, by_eye: Parameters::BY_EYE };
    let output = data.layout.reports().join(format!("report-data/{TURNED}.js"));
    let name = format!("sliders {}", session.who());
    Some(Job::new(STAGE, name, parameters, inputs, vec![output], make_sliders))
}

fn make_sliders(
    Turned { environments, by_eye }: &Turned,
    (files, plant): &(Vec<Derived<PlantRun>>, PathBuf),
    making: &Making,
) -> Result<Made, JobError> {
    let fitted = identify::fitted(&*read_shared(plant, making)?)?;
    let mut runs: Vec<(&str, Vec<PlantRun>)> = Vec::new();
    for (environment, file) in environments.iter().zip(files) {
        runs.push((environment.as_str(), file.read()?));
    }
    let script = turned_script(&runs, knobs(by_eye), fitted.as_ref().map(knobs))?;
    Ok(Made::of(vec![with_origin(script, making).into_bytes()]))
}

/// The parameters that have sliders.
fn knobs(plant: &Parameters) -> [f64; 3] {
    [plant.mass_kg, plant.damping_ns_per_rad, plant.friction_n]
}

/// A script with where it comes from.
fn with_origin(script: String, making: &Making) -> String {
    let origin = making.from.get(ORIGIN).map(|origin| format!("// {origin}\n"));
    script + &origin.unwrap_or_default()
}

/// What the script of an environment's conditions depends on besides files.
#[derive(Serialize)]
struct Conditions {
    conditions: Vec<OfTrials<Condition>>,
}

#[derive(Serialize)]
struct Condition {
    key: String,
    mode: ModeId,
}

/// The files of the conditions of one environment in a session.
struct Files {
    /// Of each condition its trials, and if they are several their means in the order of [`Alignment::ALL`].
    conditions: Vec<(Recordings, Vec<PathBuf>)>,
    /// The events in all trials of the session.
    events: Derived<TrialEvent>,
    /// The models' runs of a typical trial of each mode, where one could be replayed.
    courses: Option<Derived<CourseSample>>,
}

impl Inputs for Files {
    fn files(&self) -> Vec<PathBuf> {
        [self.conditions.files(), self.events.files(), self.courses.files()].concat()
    }
}

/// The script of an environment's conditions, in one: people look at all modes of an environment at
/// once, and a large study would have thousands of files more.
fn samples_job(data: &StudyData, session: &Session, environment: &Environment) -> Option<Job> {
    let modes = data.study.modes.iter();
    let all: Vec<Repeats> = modes.filter_map(|mode| session.repeats(environment, mode)).collect();
    let events = metrics::events_of(&data.layout, &all.first()?.trials[0].meta);
    let mut conditions = Vec::new();
    let mut files = Vec::new();
    for repeats in &all {
        // The mean of one repeat is that repeat.
        let averaged = if repeats.trials.len() > 1 { &Alignment::ALL[..] } else { &[] };
        let means = averaged.iter().map(|a| average::aligned(&data.layout, repeats, *a));
        files.push((trial_files(&repeats.trials), means.collect()));
        let condition = Condition { key: repeats.key.clone(), mode: repeats.mode.id.clone() };
        conditions.push(OfTrials::new(condition, &repeats.trials));
    }
    let script = format!("report-data/{}.js", session.ids_with(environment).join("."));
    let outputs = vec![data.layout.reports().join(script)];
    let courses = courses::file(data, session, environment);
    let files = Files { conditions: files, events, courses };
    let name = format!("samples {} {}", session.who(), environment.id);
    let parameters = Conditions { conditions };
    Some(Job::new(STAGE, name, parameters, files, outputs, make_samples).tolerant())
}

fn make_samples(
    Conditions { conditions }: &Conditions,
    files: &Files,
    making: &Making,
) -> Result<Made, JobError> {
    let events = files.events.read_if_made()?.unwrap_or_default();
    let samples = files.courses.as_ref().map(Derived::read_if_made).transpose()?.flatten();
    let samples = samples.unwrap_or_default();
    let mut script = String::new();
    let mut problems = Vec::new();
    // One after the other: of long trials no more are in memory than those of one condition.
    for (condition, (recordings, averages)) in conditions.iter().zip(&files.conditions) {
        let OfTrials { stage: Condition { key, mode }, trials: labels } = condition;
        let (trials, unread) = read_drawn(recordings, labels, SIGNALS.into_iter())?;
        problems.extend(unread);
        let courses: Vec<Course> = trials.iter().map(|drawn| course(drawn, &events)).collect();
        let mut means = Vec::new();
        // The files stand in the order of `Alignment::ALL`.
        for (name, file) in ["onset", "landmarks"].into_iter().zip(averages) {
            if file.exists() {
                let table = Table::columns_from_parquet(file, &MEANS.map(|(_, column)| column))?;
                means.extend((table.height() > 0).then(|| (name, mean_columns(&table))));
            }
        }
        let mut replays = replays(&samples, mode);
        for (_, number, columns) in &mut replays {
            in_time_of(&trials, *number, columns);
        }
        script += &condition_script(key, &courses, &means, &replays)?;
    }
    Ok(Made { problems, ..Made::of(vec![with_origin(script, making).into_bytes()]) })
}

/// A trial's samples and events for the page.
fn course((trial, recorded): &(Trial, usize), events: &[TrialEvent]) -> Course {
    let mut columns = Vec::new();
    for (signal, name) in SIGNALS.into_iter().zip(SIGNAL_NAMES) {
        columns.extend(trial.samples.get(signal).map(|values| (name, values.to_vec())));
    }
    let own = events.iter().filter(|event| event.trial == trial.meta.trial);
    Course {
        trial: trial.meta.trial,
        repeat: trial.meta.repeat,
        recorded: *recorded,
        columns,
        events: own.map(|own| Event { kind: own.event.as_str(), t_s: own.t_s }).collect(),
    }
}

/// The page's names of means, and their columns.
const MEANS: [(&str, &str); 6] = [
    ("t_s", "t_s"),
    ("theta_rad", "theta_mean_rad"),
    ("theta_dot_rad_s", "theta_dot_mean_rad_s"),
    ("force_ex_n", "force_ex_mean_n"),
    ("torque_ex_nm", "torque_ex_mean_nm"),
    ("force_cmd_n", "force_cmd_mean_n"),
];

/// The columns of a table of means by the page's names.
fn mean_columns(table: &Table) -> Columns {
    let mut columns = Columns::new();
    for (name, column) in MEANS {
        // A signal that was not recorded has no column, or an empty one. Not a number stands for null.
        if let Ok(values) = table.floats(column)
            && values.iter().any(Option::is_some)
        {
            columns.push((name, values.iter().map(|value| value.unwrap_or(f64::NAN)).collect()));
        }
    }
    columns
}

/// A value of a sample.
type Value = fn(&CourseSample) -> f64;

/// The models' runs of the mode's typical trial, and which trial that is.
fn replays(courses: &[CourseSample], mode: &ModeId) -> Vec<(&'static str, u32, Columns)> {
    let mut replays = Vec::new();
    for series in [CourseSeries::ByEye, CourseSeries::Fitted] {
        let own: Vec<&CourseSample> =
            courses.iter().filter(|row| row.mode == *mode && row.series == series).collect();
        let Some(first) = own.first() else { continue };
        let columns: [(_, Value); 5] = [
            ("t_s", |row| row.t_s),
            ("theta_rad", |row| row.theta_rad),
            ("theta_dot_rad_s", |row| row.theta_dot_rad_s),
            ("force_ex_n", |row| row.force_ex_n),
            ("force_cmd_n", |row| row.feedback_n.unwrap_or(f64::NAN)),
        ];
        let columns = columns.map(|(name, get)| (name, own.iter().map(|row| get(row)).collect()));
        replays.push((series.as_str(), first.trial, Vec::from(columns)));
    }
    replays
}

/// Moves a model's times, which count from its trial's first sample, to the trial's own, which count
/// from the trial's start.
fn in_time_of(trials: &[(Trial, usize)], number: u32, columns: &mut Columns) {
    let own = trials.iter().find(|(trial, _)| trial.meta.trial == number);
    let begins_s =
        own.and_then(|(t, _)| t.samples.get(Signal::Time)?.first().copied()).unwrap_or(0.0);
    let times = columns.iter_mut().filter(|(name, _)| *name == "t_s").flat_map(|(_, t_s)| t_s);
    times.for_each(|t_s| *t_s += begins_s);
}

/// What the page depends on besides files.
#[derive(Serialize)]
struct Index {
    #[serde(flatten)]
    summary: summary::Page,
    study: String,
    /// Whose trials' model can be turned.
    turned: Option<[String; 2]>,
    /// The user's torque was recorded, and no force.
    torque: bool,
    estimating: Estimating,
    /// The scores among the metrics compared.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    scores: Vec<ScoreColumn>,
    /// What tasks tell, among them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    thresholds: Vec<ThresholdColumn>,
    version: &'static str,
}

/// The files of the page.
struct IndexFiles {
    summary: summary::Files,
    answers: Option<Derived<GivenAnswer>>,
    scores: Option<Derived<TrialScore>>,
    fits: Option<Derived<PsychometricFit>>,
}

impl Inputs for IndexFiles {
    fn files(&self) -> Vec<PathBuf> {
        let mut files = self.summary.files();
        files.extend(self.answers.files());
        files.extend(self.scores.files());
        files.extend(self.fits.files());
        files
    }
}

fn make_index(index: &Index, files: &IndexFiles, making: &Making) -> Result<Made, JobError> {
    let summary::Gathered { summary, compared, metrics } =
        summary::gather(&index.summary, &files.summary, making)?;
    let answers = files.answers.as_ref().filter(|answers| answers.path().exists());
    let answers = answers.map(likert::read_counting).transpose()?.unwrap_or_default();
    let planned = &index.summary.planned;
    let mut scores = Vec::new();
    if let Some(rows) = files.scores.as_ref().map(Derived::read_if_made).transpose()?.flatten() {
        for score in &index.scores {
            scores.push(score.measured(&rows)?);
        }
    }
    if let Some(rows) = files.fits.as_ref().map(Derived::read_if_made).transpose()?.flatten() {
        for own in &index.thresholds {
            scores.push(own.measured(&rows)?);
        }
    }
    let has_values = metrics.is_some() || !scores.is_empty();
    let contents = has_values.then(|| {
        let compared = compared.by_metric(index.summary.primary);
        let contents = Contents::of(
            index.study.as_str(),
            &summary.title,
            planned,
            &index.estimating,
            TrialValues { recorded: metrics.as_ref(), scores: &scores },
            &compared,
            &answers,
        );
        let contents = contents.with_turned(index.turned.clone(), planned.coordinate);
        if index.torque { contents.with_torque() } else { contents }
    });
    let html = page_html(&Page {
        summary: &summary,
        planned,
        study: &index.study,
        contents: contents.as_ref(),
        origin: making.from.get(ORIGIN).map(String::as_str),
        version: index.version,
    });
    // In parts: a page has the metrics of every trial of a study.
    let write: WriteLong = Box::new(move |out| Ok(html.write(contents.as_ref(), out)?));
    Ok(Made { outputs: vec![Output::Long(write)], ..Made::default() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_store::{Samples, TrialFile};

    #[test]
    fn both_models_of_a_mode_reach_the_page_with_the_trial_that_they_are_of() {
        let sample = |mode: &str, series| CourseSample {
            trial: 4,
            mode: mode.parse().unwrap(),
            source: zwidth_study::Source::Twin,
            series,
            t_s: 0.5,
            theta_rad: 0.25,
            theta_dot_rad_s: 1.0,
            force_ex_n: 2.0,
            feedback_n: None,
        };
        let series = CourseSeries::ALL.iter().copied();
        let courses: Vec<_> = series
            .flat_map(|series| [sample("hybrid", series), sample("active", series)])
            .collect();
        let found = replays(&courses, &"hybrid".parse().unwrap());
        let told: Vec<_> = found.iter().map(|(name, trial, _)| (*name, *trial)).collect();
        assert_eq!(told, [("by_eye", 4), ("fitted", 4)]);
        assert_eq!(found[0].2[1], ("theta_rad", vec![0.25]));
    }

    #[test]
    fn a_models_run_stands_at_its_own_trials_time() {
        let trial = |number, begins_s: f64| {
            let mut samples = Samples::default();
            samples.set(Signal::Time, vec![begins_s, begins_s + 1.0]);
            let meta = zwidth_testing::meta(number, "hybrid");
            (Trial { meta, file: TrialFile::new(), samples }, 2)
        };
        let trials = [trial(3, 0.0), trial(7, 11e-6)];
        let run = || vec![("t_s", vec![0.0, 1.0]), ("theta_rad", vec![0.5, 0.6])];
        let moved = |number| {
            let mut columns = run();
            in_time_of(&trials, number, &mut columns);
            columns
        };
        assert_eq!((moved(3), moved(9)), (run(), run()), "of a trial that is not there: as it was");
        let expect = vec![("t_s", vec![11e-6, 1.0 + 11e-6]), ("theta_rad", vec![0.5, 0.6])];
        assert_eq!(moved(7), expect);
    }
}
