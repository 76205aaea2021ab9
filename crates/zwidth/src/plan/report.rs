//! Stage `report`: the tables of what was planned, and the pros and cons beside what came out.

use super::design::{Forces, forces, has_actuators, inputs, sources};
use super::{derived, made, metrics};
use std::path::PathBuf;
use zwidth_report::{Known, device_table, model_table, modes_table, pros_cons_table, weight_table};
use zwidth_runner::Job;
use zwidth_simulate::Scene;
use zwidth_store::{Layout, StudyData};
use zwidth_study::Calibration;
use zwidth_tables::Table;

const STAGE: &str = "report";
/// The scene of the thesis' Table 3.
const MODEL: &str = include_str!("../../../../scenes/sine_finger.toml");

/// The job that needs it.
const MODEL_JOB: &str = "model and device";

/// The file that is built into the program and that the job of that name takes its parameters from,
/// if any.
pub(crate) fn built_in(job: &str) -> Option<&'static str> {
    (job == MODEL_JOB).then_some("scenes/sine_finger.toml (built in)")
}

/// A table of the stage.
fn table_of(layout: &Layout, name: &str) -> PathBuf {
    derived(layout, format!("report/{name}.parquet"))
}

/// Every table of the stage, the thesis' Table 1 in front.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    ["pros_cons", "modes", "model", "device", "weight"]
        .iter()
        .map(|name| table_of(layout, name))
        .collect()
}

pub(super) fn jobs<'a>(data: &'a StudyData, planned: &[Job]) -> Vec<Job<'a>> {
    if !has_actuators(data) {
        return Vec::new();
    }
    let metrics = metrics::of_study(&data.layout);
    let metrics = planned.iter().any(|j| j.outputs.contains(&metrics)).then_some(metrics);
    vec![pros_cons_job(data, metrics), forces_job(data), plan_job(data)]
}

/// What the tables depend on besides files.
fn parameters(data: &StudyData) -> String {
    let study = &data.study;
    let planned = (&study.device, &study.control, &study.masses, &study.environments, &study.modes);
    format!("{planned:?}")
}

fn pros_cons_job(data: &StudyData, metrics: Option<PathBuf>) -> Job<'_> {
    let outputs = vec![table_of(&data.layout, "pros_cons")];
    let out = outputs.clone();
    Job {
        stage: STAGE,
        name: "pros and cons".to_owned(),
        version: zwidth_report::VERSION,
        parameters: format!("{}; {:?}", parameters(data), sources(data)),
        inputs: inputs(data).into_iter().chain(metrics.clone()).collect(),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let Forces { calibration, footnote, .. } = forces(data)?;
            let metrics = metrics.as_deref().map(Table::from_parquet).transpose()?;
            let known =
                Known { study: &data.study, calibration: &calibration, metrics: metrics.as_ref() };
            made(&[pros_cons_table(known)?.with_note(footnote)], &out, from, Vec::new())
        }),
    }
}

/// What the forces of the actuators decide: the modes as used, and the weights.
fn forces_job(data: &StudyData) -> Job<'_> {
    let weighed = weight_table(&data.study, &Calibration::thesis()).is_some();
    let names = ["modes", "weight"].into_iter().take(if weighed { 2 } else { 1 });
    let outputs: Vec<PathBuf> = names.map(|name| table_of(&data.layout, name)).collect();
    let out = outputs.clone();
    Job {
        stage: STAGE,
        name: "modes and weights".to_owned(),
        version: zwidth_report::VERSION,
        parameters: format!("{}; {:?}", parameters(data), sources(data)),
        inputs: inputs(data),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let Forces { calibration, footnote, .. } = forces(data)?;
            let mut tables = vec![modes_table(&data.study, &calibration, footnote)?];
            let weight = weight_table(&data.study, &calibration).transpose()?;
            tables.extend(weight.map(|table| table.with_note(footnote)));
            made(&tables, &out, from, Vec::new())
        }),
    }
}

/// What stands before anything is recorded: the model's parameters and the device.
fn plan_job(data: &StudyData) -> Job<'_> {
    let outputs = ["model", "device"].map(|name| table_of(&data.layout, name)).to_vec();
    let out = outputs.clone();
    Job {
        stage: STAGE,
        name: MODEL_JOB.to_owned(),
        version: zwidth_report::VERSION,
        parameters: format!("{}; {MODEL}", parameters(data)),
        inputs: Vec::new(),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let tables = [model_table(&Scene::from_toml(MODEL)?)?, device_table(&data.study)?];
            made(&tables, &out, from, Vec::new())
        }),
    }
}
