//! Stage `ladder`: which terms of the model each condition of a study needs, and whether its
//! recordings confirm that. It is planned if `[replay] model = "auto"`; `zwidth ladder` asks for
//! one condition at a time. Stages do not know each other; they meet here: the scene is the
//! replay's, and the numbers that are compared are the metrics'.

use crate::figures::drawing::{Drawing, Figured};
use crate::replay::replayable::{is_replayable, rendering};
use crate::shared::conditions::{Repeats, repeats};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, write_tables};
use crate::shared::measured::{measured, model_samples};
use crate::shared::trials::{OfTrials, Recordings, files, label_trials, name, read_all};
use serde::{Serialize, Serializer};
use zwidth_device::{TwinParameters, Velocity};
use zwidth_figures::{LADDER, LadderRows};
use zwidth_ladder::{Course, Ladder, Loop, Recorded, Settings};
use zwidth_numerics::series::interpolate;
use zwidth_replay::{Drive, Rendering, replay_with};
use zwidth_results::{
    HeldOutModel, LadderChoice, LadderCondition, LadderModel, LadderTerm, ModelPlant, TermEffect,
    TermPair, TermSet,
};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Analysis, Control, Environment, Mode, Perception, ReplayModel, Study};
use zwidth_tables::TableError;

pub(crate) const STAGE: Stage = Stage { name: "ladder", version: zwidth_ladder::VERSION };

/// Trials of a condition that are fitted or predicted, at most: a fit runs each of them hundreds of
/// times.
const MOST_TRIALS: usize = 12;

/// What the ladder of a condition depends on besides its trials.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Laddered {
    #[serde(rename = "name", serialize_with = "as_text")]
    condition: LadderCondition,
    renderings: Vec<Rendering>,
    metrics: zwidth_metrics::Parameters,
    metrics_version: u32,
    control: Control,
    perception: Perception,
    points: usize,
    synthetic: bool,
}

fn as_text<S: Serializer>(condition: &LadderCondition, into: S) -> Result<S::Ok, S::Error> {
    into.collect_str(condition)
}

/// What a figure is drawn from.
type Drawn = (Derived<LadderModel>, Derived<TermEffect>);

/// The results of a condition's ladder.
type LadderTables = (Derived<LadderModel>, Derived<TermEffect>, Derived<TermPair>);

/// A condition of a study, all sessions together.
struct Condition<'a> {
    environment: &'a Environment,
    mode: &'a Mode,
    trials: Vec<&'a TrialEntry>,
}

impl Condition<'_> {
    fn key(&self) -> String {
        format!("{}.{}", self.environment.id, self.mode.id)
    }

    fn laddered(&self, data: &StudyData, points: usize) -> Laddered {
        let study = &data.study;
        let Self { environment, mode, trials } = self;
        let renderings = trials.iter().map(|t| rendering(data, &t.meta, environment, mode));
        Laddered {
            condition: LadderCondition {
                environment: environment.id.clone(),
                mode: mode.id.clone(),
            },
            renderings: renderings.collect(),
            metrics: zwidth_metrics::Parameters::of(study, environment, mode),
            metrics_version: zwidth_metrics::VERSION,
            control: study.control,
            perception: crate::thresholds::perception(data),
            points,
            synthetic: trials.iter().any(|t| t.meta.source.is_simulated()),
        }
    }
}

/// The conditions with a trial that can be replayed, in the order of the study.
fn conditions(data: &StudyData) -> Vec<Condition<'_>> {
    let all = repeats(data);
    let mut conditions = Vec::new();
    for environment in &data.study.environments {
        for mode in &data.study.modes {
            let own = all
                .iter()
                .filter(|r| r.environment.id == environment.id && r.mode.id == mode.id)
                .flat_map(|r| r.trials.iter().copied());
            let trials: Vec<_> = own.filter(|t| is_replayable(data, t)).take(MOST_TRIALS).collect();
            if !trials.is_empty() {
                conditions.push(Condition { environment, mode, trials });
            }
        }
    }
    conditions
}

/// Whether study.toml says `[replay] model = "auto"`.
fn is_requested(study: &Study) -> bool {
    study.replay == ReplayModel::Auto
}

fn tables_of(data: &StudyData, condition: &Condition) -> LadderTables {
    let [models, effects, interactions] = ["models", "effects", "interactions"]
        .map(|kind| derived(&data.layout, format!("ladder/{}.{kind}.parquet", condition.key())));
    (Derived::at(models), Derived::at(effects), Derived::at(interactions))
}

fn held_out_of(data: &StudyData, environment: &Environment, mode: &Mode) -> Derived<HeldOutModel> {
    let name = format!("ladder/{}.{}.held_out.parquet", environment.id, mode.id);
    Derived::at(derived(&data.layout, name))
}

/// The models by which a condition is replayed; `None` if the study replays by eye, or no trial of the
/// condition can be replayed.
pub(crate) fn of_replay(data: &StudyData, repeats: &Repeats) -> Option<Derived<HeldOutModel>> {
    let is_any = repeats.trials.iter().any(|t| is_replayable(data, t));
    (is_requested(&data.study) && is_any)
        .then(|| held_out_of(data, repeats.environment, repeats.mode))
}

/// The choices of all conditions, if the study asks for them.
pub(crate) fn of_study(data: &StudyData) -> Option<Derived<LadderChoice>> {
    (is_requested(&data.study) && !conditions(data).is_empty())
        .then(|| Derived::within(&data.layout.derived()))
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some(whole) = of_study(data) else { return Vec::new() };
    let conditions = conditions(data);
    let mut jobs = Vec::new();
    let mut held_out = Vec::new();
    for condition in &conditions {
        let laddered = condition.laddered(data, zwidth_ladder::DEFAULT_POINTS);
        let tables = tables_of(data, condition);
        let key = condition.key();
        let trials = &condition.trials;
        // A ladder runs each of its models on one recording: the first stands for the condition.
        let first = &trials[..1];
        let parameters = OfTrials::new(laddered.clone(), first);
        let name = format!("ladder {key}");
        let job = Job::new(STAGE, name, parameters, files(first), tables.files(), make);
        jobs.push(job.of_part(&key));
        let output = held_out_of(data, condition.environment, condition.mode);
        let inputs = (files(trials), tables);
        let parameters = OfTrials::new(laddered, trials);
        let name = format!("ladder held out {key}");
        let job = Job::new(STAGE, name, parameters, inputs, output.files(), make_held_out);
        jobs.push(job.of_part(&key));
        held_out.push(output);
    }
    let name = "ladder of the study";
    jobs.push(Job::new(STAGE, name, (), held_out, whole.files(), |(), conditions, making| {
        let models = conditions.iter().map(Derived::read).collect::<Result<Vec<_>, _>>()?;
        let choices = zwidth_ladder::choices(&models);
        write_tables(&[zwidth_ladder::held_out_table(&choices)?], making, Vec::new())
    }));
    jobs
}

pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let conditions = if is_requested(&data.study) { conditions(data) } else { Vec::new() };
    // All conditions have the same axes.
    let mut beside: Vec<Drawn> = Vec::new();
    for condition in &conditions {
        let (models, effects, _) = tables_of(data, condition);
        beside.push((models, effects));
    }
    let mut drawings = Vec::new();
    for (condition, own) in conditions.iter().zip(&beside) {
        let subject = [condition.environment.id.to_string(), condition.mode.id.to_string()];
        let synthetic = condition.trials.iter().any(|t| t.meta.source.is_simulated());
        let inputs = (own.clone(), beside.clone());
        drawings.push(Drawing::new(data, LADDER, subject, synthetic, inputs, draw).of(1));
    }
    drawings
}

fn draw(synthetic: &bool, ((models, effects), beside): &(Drawn, Vec<Drawn>)) -> Figured {
    let (models, notes) = models.read_with_notes()?;
    let own = LadderRows { models, effects: effects.read()? };
    let beside = beside.iter().map(|(models, effects)| -> Result<_, TableError> {
        Ok(LadderRows { models: models.read()?, effects: effects.read()? })
    });
    let beside = beside.collect::<Result<Vec<_>, _>>()?;
    Ok((zwidth_figures::ladder(&own, &beside, &notes, *synthetic), Vec::new()))
}

/// Models, effects and interactions of each condition of a study that has a recording, with `points`
/// points: what `zwidth ladder STUDY` prints. `begin` is called with each condition before its ladder
/// is made, and `progress` after each of its points.
///
/// # Errors
/// A condition for which no model can be made.
pub fn ladders(
    data: &StudyData,
    points: usize,
    rate_hz: Option<f64>,
    begin: &dyn Fn(&str),
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<(String, Ladder, bool)>, JobError> {
    let mut ladders = Vec::new();
    for condition in conditions(data) {
        begin(&format!("{} {}", data.layout.study(), condition.key()));
        let mut laddered = condition.laddered(data, points);
        laddered.control.rate_hz = rate_hz.unwrap_or(laddered.control.rate_hz);
        let first = &condition.trials[..1];
        let (trials, problems) = read_all(&files(first), &label_trials(first), Signal::all())?;
        let trial = trials.into_iter().next().ok_or_else(|| problems.join("; "))?;
        let ladder = ladder_of(&laddered, &trial, progress)?;
        ladders.push((condition.key(), ladder, laddered.synthetic));
    }
    Ok(ladders)
}

/// The terms that may explain a recording: without the finger, which is on the far side of the force
/// sensor.
const OFFERED: TermSet = TermSet::ALL.without(LadderTerm::Finger);

fn looped(control: &Control) -> Result<Loop, JobError> {
    Ok(Loop { period_s: 1.0 / control.rate_hz, velocity: Velocity::new(control.velocity)? })
}

/// The scene of a recorded trial, with the twin's plant in place of the thesis'.
fn recorded(
    laddered: &Laddered,
    trial: &Trial,
    rendering: &Rendering,
) -> Result<Recorded, JobError> {
    let drive = Drive::new(trial, rendering)?;
    let mut scene = drive.scene().clone();
    scene.name = laddered.condition.to_string();
    let twin = TwinParameters::default().plant(None);
    // The scene moves the lever's end: the inertia there is a mass.
    scene.plant.mass_kg = twin.inertia_kg_m2 / (twin.lever_m * twin.lever_m);
    let course = drive.recorded();
    Ok(Recorded { scene, t_s: course.t_s.clone(), theta_rad: course.theta_rad.clone() })
}

fn ladder_of(
    laddered: &Laddered,
    trial: &Trial,
    progress: &(dyn Fn() + Sync),
) -> Result<Ladder, JobError> {
    let rendering = laddered.renderings.first().ok_or("there is no trial")?;
    let scene = recorded(laddered, trial, rendering)?.scene;
    let settings = Settings {
        looped: looped(&laddered.control)?,
        points: laddered.points,
        bounds: laddered.perception.clone(),
        offered: OFFERED.both(zwidth_ladder::possible(&scene)),
    };
    // The study's own metrics of a course.
    let measure = |course: &Course| {
        let Course { t_s, theta_rad, theta_dot_rad_s, force_ex_n, feedback_n, lever_m } = course;
        let samples = model_samples([t_s, theta_rad, theta_dot_rad_s, force_ex_n, feedback_n]);
        let lever_m = Some(*lever_m);
        let parameters = zwidth_metrics::Parameters { lever_m, ..laddered.metrics.clone() };
        let trial = Trial { meta: trial.meta.clone(), file: trial.file.clone(), samples };
        measured(&trial, &parameters)
    };
    Ok(zwidth_ladder::ladder(&scene, &settings, &measure, progress)?)
}

fn make(
    parameters: &OfTrials<Laddered>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let (trials, problems) = read_all(files, &parameters.trials, Signal::all())?;
    let trial = trials.first().ok_or_else(|| problems.join("; "))?;
    let ladder = ladder_of(&parameters.stage, trial, &|| ())?;
    let tables = [
        zwidth_ladder::models_table(&ladder)?,
        zwidth_ladder::effects_table(&ladder)?,
        zwidth_ladder::interactions_table(&ladder)?,
    ];
    write_tables(&tables, making, problems)
}

fn make_held_out(
    parameters: &OfTrials<Laddered>,
    (files, (models, ..)): &(Recordings, LadderTables),
    making: &Making,
) -> Result<Made, JobError> {
    let OfTrials { stage: laddered, trials: labels } = parameters;
    let choice = zwidth_ladder::chosen(&models.read()?);
    let choice = choice.ok_or("the ladder has no choice")?;
    let looped = looped(&laddered.control)?;
    let mut recordings = Vec::new();
    let mut problems = Vec::new();
    for (i, rendering) in laddered.renderings.iter().enumerate().take(files.len()) {
        let (trial, more) = read_all(&files[i..=i], &labels[i..=i], Signal::all())?;
        problems.extend(more);
        for trial in &trial {
            match recorded(laddered, trial, rendering) {
                Ok(recording) => recordings.push(recording),
                Err(error) => problems.push(format!("{}: {error}", name(&trial.meta))),
            }
        }
    }
    let tried = zwidth_ladder::tried(&recordings, choice, OFFERED, &looped);
    let Laddered { condition, perception, .. } = laddered;
    let models = zwidth_ladder::held_out_models(condition, &tried, recordings.len(), perception);
    write_tables(&[zwidth_ladder::held_out_table(&models)?], making, problems)
}

/// The model that the ladder chose, as replays depend on it; its terms and its fit are read.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Auto {
    control: Control,
    version: u32,
}

impl Auto {
    pub(crate) fn of(study: &Study) -> Self {
        Self { control: study.control, version: zwidth_ladder::VERSION }
    }

    /// A recorded trial by the model that fits the condition best of those in `held_out`.
    pub(crate) fn replay(
        &self,
        trial: &Trial,
        rendering: &Rendering,
        analysis: &Analysis,
        held_out: &[HeldOutModel],
    ) -> Result<Vec<zwidth_results::ReplayedTrial>, JobError> {
        let Some((set, knobs)) = zwidth_ladder::fitted(held_out) else {
            return Err("no trial could be fitted, so there is no model: say [replay] model = \"by_eye\" in study.toml".into());
        };
        let looped = looped(&self.control)?;
        let twin = zwidth_ladder::plant(set, knobs);
        let parameters = zwidth_replay::Parameters {
            mass_kg: twin.mass_kg,
            damping_ns_per_rad: twin.viscous_ns_per_rad,
            friction_n: twin.dry_n,
            motor_lag_s: twin.motor_lag_s,
            brake_on_s: twin.brake_lag_s[0],
            brake_off_s: twin.brake_lag_s[1],
        };
        let force_driven = |drive: &Drive| -> Result<zwidth_replay::Course, _> {
            let mut scene = drive.scene().clone();
            scene.plant.mass_kg =
                zwidth_ladder::plant(TermSet::NONE, zwidth_ladder::Knobs::USUAL).mass_kg;
            let course = zwidth_ladder::predict(&scene, set, &looped, knobs)?;
            // The course at the recording's times.
            let zwidth_replay::Course { t_s, force_ex_n, .. } = drive.recorded();
            let [theta_rad, theta_dot_rad_s, feedback_n] =
                [&course.theta_rad, &course.theta_dot_rad_s, &course.feedback_n].map(|values| {
                    // The recording's last sample may lie behind the course's last step.
                    let last = values.last().copied().unwrap_or(f64::NAN);
                    let at = |t: &f64| interpolate(&course.t_s, values, *t).unwrap_or(last);
                    t_s.iter().map(at).collect::<Vec<f64>>()
                });
            Ok(zwidth_replay::Course {
                theta_rad,
                theta_dot_rad_s,
                feedback_n: Some(feedback_n),
                force_ex_n: force_ex_n.clone(),
                t_s: t_s.clone(),
            })
        };
        Ok(replay_with(trial, rendering, analysis, ModelPlant::Auto, &parameters, &force_driven)?)
    }
}
