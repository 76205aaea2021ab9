//! Stage `report`: the tables of what was planned, and the pros and cons beside the results.

use crate::figures::design::{Forces, forces, has_actuators};
use crate::figures::drawing::Drawing;
use crate::shared::conditions::sessions;
use crate::shared::handle::Derived;
use crate::shared::making::{derived, write_tables};
use crate::tables::long;
use crate::{likert, metrics, replay};
use serde::Serialize;
use std::path::PathBuf;
use zwidth_report::{
    Gallery, HOW_JUDGED, Known, WEIGHT_NOTES, components, device_facts, mode_forces, model_facts,
    notes, pros_cons, weight_facts,
};
use zwidth_results::{AnswerTally, Fact, GivenAnswer, JudgedStatement};
use zwidth_runner::{Inputs, Job, JobError, Made, Making, Stage};
use zwidth_simulate::ModelScene;
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Basis, Setup};
use zwidth_tables::{Measured, Table, TableError};

const STAGE: Stage = Stage { name: "report", version: zwidth_report::VERSION };
/// The scene of the thesis' Table 3.
const MODEL: &str = include_str!("../../../scenes/sine_finger.toml");
/// The job that needs it.
const MODEL_JOB: &str = "model and device";

/// The file that is built into the program and that the job of that name takes its parameters from,
/// if any.
pub fn built_in(job: &str) -> Option<&'static str> {
    (job == MODEL_JOB).then_some("scenes/sine_finger.toml (built in)")
}

/// A table of the stage.
fn table_of(layout: &Layout, name: &str) -> PathBuf {
    derived(layout, format!("report/{name}.parquet"))
}

/// The tables that say what the data show: the thesis' statements and Table 1.
pub(crate) fn of_data(data: &StudyData) -> Vec<PathBuf> {
    [statements(data).files(), of_actuators(data, &["pros_cons"])].concat()
}

/// The tables that say what the study is made of.
pub(crate) fn of_design(data: &StudyData) -> Vec<PathBuf> {
    let names: &[&str] = match is_weighed(data) {
        true => &["modes", "model", "device", "components", "weight"],
        false => &["modes", "model", "device", "components"],
    };
    of_actuators(data, names)
}

/// Whether masses and modes allow a table of weights.
fn is_weighed(data: &StudyData) -> bool {
    zwidth_report::is_weighed(&Setup::of(&data.study))
}

/// The table of the thesis' statements, if a mode drives a motor or a brake as the thesis' do.
pub(crate) fn statements(data: &StudyData) -> Option<Derived<JudgedStatement>> {
    has_actuators(data).then(|| Derived::at(table_of(&data.layout, "thesis")))
}

/// Tables that a study with actuators has, by their names.
fn of_actuators(data: &StudyData, names: &[&str]) -> Vec<PathBuf> {
    if !has_actuators(data) {
        return Vec::new();
    }
    names.iter().map(|name| table_of(&data.layout, name)).collect()
}

/// What was planned, and where its forces come from.
#[derive(Serialize)]
struct PlannedForces {
    planned: Setup,
    basis: Basis,
}

/// The figures that there will be.
pub(crate) fn gallery(data: &StudyData, figures: &[Drawing]) -> Gallery {
    let only_session = match sessions(data).as_slice() {
        [one] => Some(one.ids()),
        _ => None,
    };
    let figures = figures.iter().map(|f| f.caption.stem()).collect();
    Gallery { figures, for_programs: long::for_programs(data), only_session }
}

pub(crate) fn jobs(data: &StudyData, figures: &[Drawing]) -> Vec<Job> {
    let Some(statements) = statements(data) else { return Vec::new() };
    let Forces { basis, calibration, .. } = forces(data);
    let planned = || PlannedForces { planned: Setup::of(&data.study), basis };
    let judged = JudgeParameters {
        forces: planned(),
        gallery: gallery(data, figures),
        level: data.study.analysis.confidence,
    };
    let files = Files {
        calibration: calibration.clone(),
        metrics: metrics::of_study(data),
        replays: replay::of_study(data).map(|[replays, _]| replays),
        answers: likert::answers(data),
        tally: likert::tally(data),
    };
    let measured = (calibration.clone(), metrics::of_study(data));
    let compared = of_actuators(data, &["pros_cons"]);
    let weighed: &[&str] = if is_weighed(data) { &["modes", "weight"] } else { &["modes"] };
    let weighed = of_actuators(data, weighed);
    // The text and not its name: with another scene built in, the job is made again.
    let model = (Setup::of(&data.study), MODEL);
    let design = of_actuators(data, &["model", "device", "components"]);
    vec![
        Job::new(STAGE, "thesis' statements", judged, files, statements.files(), make_statements),
        Job::new(STAGE, "pros and cons", planned(), measured, compared, make_pros_cons),
        Job::new(STAGE, "modes and weights", planned(), calibration, weighed, make_forces),
        Job::new(STAGE, MODEL_JOB, model, (), design, make_planned),
    ]
}

/// What the verdicts on the thesis' statements depend on besides files.
#[derive(Serialize)]
struct JudgeParameters {
    #[serde(flatten)]
    forces: PlannedForces,
    gallery: Gallery,
    level: f64,
}

/// What the thesis' statements are judged by.
struct Files {
    calibration: Option<PathBuf>,
    metrics: Option<PathBuf>,
    replays: Option<PathBuf>,
    answers: Option<Derived<GivenAnswer>>,
    tally: Option<Derived<AnswerTally>>,
}

impl Inputs for Files {
    fn files(&self) -> Vec<PathBuf> {
        let paths = [&self.calibration, &self.metrics, &self.replays].map(Inputs::files).concat();
        [paths, self.answers.files(), self.tally.files()].concat()
    }
}

fn make_statements(
    parameters: &JudgeParameters,
    files: &Files,
    making: &Making,
) -> Result<Made, JobError> {
    let JudgeParameters { forces: PlannedForces { planned, basis }, gallery, level } = parameters;
    let calibration = &Forces::read(files.calibration.as_deref())?;
    let columns = zwidth_report::replayed_columns();
    let columns: Vec<&str> = columns.iter().map(|name| &**name).collect();
    // Part by part: of a large study the table of replays as a whole would fill the memory.
    let replays = files.replays.as_deref().map(|file| {
        Table::gathered(file, &columns, |part| zwidth_report::replayed(&part))
            .and_then(Measured::of)
    });
    let metrics = files.metrics.as_deref().map(|file| metrics::read_for_report(file, &[]));
    let metrics = metrics.transpose()?;
    let replays = replays.transpose()?;
    let answers = files.answers.as_ref().filter(|answers| answers.path().exists());
    let answers = answers.map(likert::read_counting).transpose()?;
    let tally = files.tally.as_ref().map(Derived::read).transpose()?;
    let derived = zwidth_report::Derived {
        known: Known { study: planned, calibration, metrics: metrics.as_ref() },
        basis: *basis,
        replays: replays.as_ref(),
        answers: answers.as_deref(),
        tally: tally.as_deref(),
        gallery,
        level: *level,
    };
    let table = Table::of_rows(&zwidth_report::statements(&derived)?)?;
    let table = notes(metrics.as_ref()).into_iter().fold(table, Table::with_note);
    let table = table.with_note(HOW_JUDGED).with_note(basis.footnote());
    write_tables(&[table], making, Vec::new())
}

fn make_pros_cons(
    PlannedForces { planned, basis }: &PlannedForces,
    (calibration, metrics): &(Option<PathBuf>, Option<PathBuf>),
    making: &Making,
) -> Result<Made, JobError> {
    let calibration = &Forces::read(calibration.as_deref())?;
    let metrics = metrics.as_deref().map(|file| metrics::read_for_report(file, &[])).transpose()?;
    let known = Known { study: planned, calibration, metrics: metrics.as_ref() };
    let table = Table::of_rows(&pros_cons(known)?)?;
    let table = notes(metrics.as_ref()).into_iter().fold(table, Table::with_note);
    write_tables(&[table.with_note(basis.footnote())], making, Vec::new())
}

/// What the forces of the actuators decide: the modes as used, and the weights.
fn make_forces(
    PlannedForces { planned, basis }: &PlannedForces,
    calibration: &Option<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let calibration = &Forces::read(calibration.as_deref())?;
    let modes = Table::of_rows(&mode_forces(planned, calibration))?.with_note(basis.footnote());
    let mut tables = vec![modes];
    if let Some(weighed) = weight_facts(planned, calibration) {
        let title = "Weight of a hybrid against a motor alone (Appendix A)";
        let weight = facts("weight", title, &weighed)?;
        let weight = WEIGHT_NOTES.into_iter().fold(weight, Table::with_note);
        tables.push(weight.with_note(basis.footnote()));
    }
    write_tables(&tables, making, Vec::new())
}

/// What is known before anything is recorded: the model's parameters, the device and its components.
fn make_planned(
    (planned, model): &(Setup, &str),
    (): &(),
    making: &Making,
) -> Result<Made, JobError> {
    let scene = ModelScene::from_toml(model)?;
    let title = format!("Parameters of the simulation model: {}", scene.name);
    let model = facts("model", &title, &model_facts(&scene))?;
    let name = &planned.device.name;
    let device = facts("device", &format!("Device: {name}"), &device_facts(planned))?;
    let parts = Table::of_rows(&components(planned))?.without_empty_columns();
    let parts = parts.called("components", format!("Components: {name}"));
    let parts = parts.with_note(
        "Boards, amplifier, driver and supply are left out, and so are makers and types: the study does \
         not know them.",
    );
    write_tables(&[model, device, parts], making, Vec::new())
}

/// Facts in their order; the thesis' numbers and the remarks only where there are any.
fn facts(name: &str, title: &str, facts: &[Fact]) -> Result<Table, TableError> {
    Ok(Table::of_rows(facts)?.without_empty_columns().called(name, title))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_that_reports_look_at_are_those_of_the_stages_that_make_them() {
        let metrics = zwidth_metrics::table(&[], &[], false).unwrap();
        let plant = zwidth_metrics::plant_table(&[], false).unwrap();
        let replays = Table::of_rows::<zwidth_results::ReplayedTrial>(&[]).unwrap();
        let made = |tables: &[&Table]| -> Vec<String> {
            tables.iter().flat_map(|of| of.fields()).map(|field| field.name.to_string()).collect()
        };
        let metrics = made(&[&metrics, &plant]);
        for name in zwidth_report::metric_columns() {
            assert!(metrics.iter().any(|made| made == name), "{name}");
        }
        let replays = made(&[&replays]);
        for name in zwidth_report::replayed_columns() {
            assert!(replays.iter().any(|made| *made == name), "{name}");
        }
    }
}
