//! Stage `thresholds`: what the answers to tasks tell of everybody, and over people.

pub(crate) mod figures;
pub(crate) mod over_people;
#[cfg(test)]
mod tests;

use crate::shared::handle::{Derived, write_named};
use crate::shared::making::derived;
use crate::shared::trials::origins;
use crate::tables::printed::Printed;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_results::{FittedShare, LevelTally, PeopleThreshold, Presentation, PsychometricFit};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_store::{StudyData, TaskAnswer};
use zwidth_study::{Asks, Method, MetricId, Perception, Study, Task, TaskQuantity};
use zwidth_tables::{Column, Measured, Table, TableError};
use zwidth_thresholds::{Answered, Parameters, Response};

const STAGE: Stage = Stage { name: "thresholds", version: zwidth_thresholds::VERSION };

/// The tables of everybody's answers.
#[derive(Clone)]
pub(crate) struct OfPeople {
    pub(crate) presentations: Derived<Presentation>,
    pub(crate) by_level: Derived<LevelTally>,
    pub(crate) curves: Derived<FittedShare>,
    pub(crate) fits: Derived<PsychometricFit>,
}

impl Inputs for OfPeople {
    fn files(&self) -> Vec<PathBuf> {
        let of_answers = [self.presentations.files(), self.by_level.files()].concat();
        [of_answers, self.curves.files(), self.fits.files()].concat()
    }
}

/// The tables of everybody's answers, if a task was answered.
pub(crate) fn of_study(data: &StudyData) -> Option<OfPeople> {
    let is_any = !data.study.tasks.is_empty() && !answered(data).is_empty();
    let folder = derived(&data.layout, STAGE.name);
    is_any.then(|| OfPeople {
        presentations: Derived::within(&folder),
        by_level: Derived::within(&folder),
        curves: Derived::within(&folder),
        fits: Derived::within(&folder),
    })
}

/// Everybody's fits, if a task was answered.
pub(crate) fn fits(data: &StudyData) -> Option<Derived<PsychometricFit>> {
    of_study(data).map(|tables| tables.fits)
}

/// Thresholds over people, if a task was answered.
pub(crate) fn over_people(data: &StudyData) -> Option<Derived<PeopleThreshold>> {
    of_study(data).map(|_| Derived::within(&derived(&data.layout, STAGE.name)))
}

/// Whether several people answered the task of a metric: one has a value in each mode, of which there is no test.
pub(crate) fn has_answers(data: &StudyData, metric: &str) -> bool {
    let Some((task, _)) = data.study.task_metric(metric) else { return false };
    let own = data.answers.iter().filter(|answer| answer.question == task.id);
    own.map(|answer| &answer.participant).collect::<BTreeSet<_>>().len() > 1
}

/// The tables that people read.
pub(crate) fn printed(data: &StudyData) -> Vec<Printed> {
    let Some(tables) = of_study(data) else { return Vec::new() };
    let files = [over_people(data).files(), tables.fits.files(), tables.by_level.files()].concat();
    let simulated = is_simulated(&answered(data));
    // A method has no numbers of another.
    let table = |file: &PathBuf| Printed::without_empty_columns(file).marked(simulated);
    files.iter().map(table).collect()
}

/// The answers that count, as the stage takes them. Of adaptive methods without those of the presentations at the standard
/// that are added to it, whose levels do not follow from answers.
pub(crate) fn answered(data: &StudyData) -> Vec<Answered> {
    let answers = data.task_answers().into_iter();
    let all = answers.filter_map(|answer| {
        let task = data.study.task(&answer.task)?;
        (!is_catch(data, task, &answer)).then(|| Answered {
            response: response(task, &answer),
            participant: answer.participant,
            session: answer.session,
            trial: answer.trial,
            task: answer.task,
            environment: answer.condition.environment,
            mode: answer.condition.mode,
            presentation: answer.presentation,
            track: answer.track,
            level: answer.level,
            source: answer.source,
        })
    });
    all.collect()
}

fn response(task: &Task, answer: &TaskAnswer) -> Response {
    /// Who sets the level and wants less of it answers so.
    const LESS: i64 = 2;
    match (task.asks, answer.is_positive) {
        (Asks::Set, true) => Response::Set,
        (Asks::Set, false) if answer.value.whole().map(i64::from) == Some(LESS) => {
            Response::Positive
        }
        (Asks::Set, false) | (_, false) => Response::Negative,
        (_, true) => Response::Positive,
    }
}

/// Whether a presentation was planned at the standard beside those of an adaptive method.
fn is_catch(data: &StudyData, task: &Task, answer: &TaskAnswer) -> bool {
    if matches!(task.method, Method::Constant { .. }) || task.catch <= 0.0 {
        return false;
    }
    let who = (&answer.participant, &answer.session);
    let mut sessions = data.sessions.iter();
    let log = sessions.find(|log| (&log.record.participant, &log.record.session) == who);
    let mut planned = log.into_iter().flat_map(|log| &log.trials);
    let place = planned.find(|planned| planned.trial == answer.trial);
    let level = place.and_then(|planned| planned.task.as_ref()?.level);
    level.is_some() && level == task.standard
}

/// A number of a task as a metric.
#[derive(Serialize)]
pub(crate) struct ThresholdColumn {
    pub(crate) metric: MetricId,
    task: zwidth_study::QuestionId,
    quantity: TaskQuantity,
    unit: String,
    words: String,
}

impl ThresholdColumn {
    /// The numbers of a study's tasks that are among the metrics compared.
    pub(crate) fn compared(study: &Study, compared: &[String]) -> Vec<Self> {
        let all = study.task_metrics().map(|(metric, task, quantity)| Self {
            metric,
            task: task.id.clone(),
            quantity,
            unit: task.metric_unit(quantity),
            words: task.metric_in_words(quantity),
        });
        all.filter(|own| compared.iter().any(|name| name == own.metric.as_str())).collect()
    }

    /// Everybody's number in each session and mode, as a table of metrics has it.
    pub(crate) fn measured(&self, fits: &[PsychometricFit]) -> Result<Measured, TableError> {
        use zwidth_results::Row as _;
        let (keys, values) = zwidth_thresholds::values(fits, &self.task, self.quantity);
        let mut columns = zwidth_results::TrialKey::columns(&keys);
        let mut column = Column::float("", "", "", values);
        column.field.unit = self.unit.clone().into();
        column.field.name = self.metric.to_string().into();
        column.field.description = self.words.clone().into();
        columns.push(column);
        Measured::of(Table::new(PsychometricFit::NAME, PsychometricFit::TITLE, columns)?)
    }
}

/// What everybody's thresholds depend on. The answers are joined from several files, and are not a file themselves.
#[derive(Serialize)]
struct Fitting {
    #[serde(flatten)]
    parameters: Parameters,
    answers: Vec<Answered>,
    simulated: bool,
}

fn is_simulated(answers: &[Answered]) -> bool {
    answers.iter().any(|answer| answer.source.is_simulated())
}

fn fitting(study: &Study, draws: usize) -> Parameters {
    Parameters {
        tasks: study.tasks.clone(),
        modes: study.modes.iter().map(|mode| mode.id.clone()).collect(),
        level: study.analysis.confidence,
        draws,
    }
}

/// What people of the study can feel: others' findings, or where `[perception] jnd` says so what its tasks measured.
pub fn perception(data: &StudyData) -> Perception {
    let own = &data.study.perception;
    if !own.is_measured || data.study.tasks.is_empty() {
        return own.clone();
    }
    let found = zwidth_thresholds::thresholds(&answered(data), &fitting(&data.study, 0));
    let level = data.study.compare.level;
    own.with_measured(zwidth_thresholds::measured(&data.study.tasks, &found.fits, level))
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some(tables) = of_study(data) else { return Vec::new() };
    let answers = answered(data);
    let parameters = Fitting {
        parameters: fitting(&data.study, Parameters::DRAWS),
        simulated: is_simulated(&answers),
        answers,
    };
    let job = Job::new(STAGE, "thresholds", parameters, (), tables.files(), make);
    vec![job.told_by(origins(data))]
}

fn make(fitting: &Fitting, (): &(), making: &Making) -> Result<Made, JobError> {
    let Fitting { parameters, answers, simulated } = fitting;
    let found = zwidth_thresholds::thresholds(answers, parameters);
    let notes = zwidth_thresholds::notes(&parameters.tasks, &found.fits);
    let mut fits = Table::of_rows(&found.fits)?;
    for note in notes {
        fits = fits.with_note_of(zwidth_tables::NoteKind::Care, note);
    }
    let tables = vec![
        Table::of_rows(&found.presentations)?,
        Table::of_rows(&found.by_level)?,
        Table::of_rows(&found.curves)?,
        fits,
    ];
    write_named(tables, making, *simulated)
}
