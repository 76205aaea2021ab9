//! Stage `trade`: speed against accuracy of a study's conditions as scenes, in counts alone; what
//! less of a recording does to its metrics; and their figures.

use crate::drawing::{Drawing, write_figure};
use crate::making::{derived, write_tables};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_figures::{FigureKind, WORK_PRECISION};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Calibration, Perception};
use zwidth_tables::Table;
use zwidth_trade::{
    ModelScene, Parameters, Trade, condition_scene, settings_table, summary_table, trade,
};

const STAGE: Stage = Stage { name: "trade", version: zwidth_trade::VERSION };

/// Every condition of a study that a model can be made of, as a scene. Its forces are those of a
/// session's calibration, or else the thesis'.
pub fn scenes(data: &StudyData) -> Vec<ModelScene> {
    let study = &data.study;
    let of_session = data.sessions.iter().find_map(|s| s.record.calibration.clone());
    let calibration = of_session.unwrap_or_else(Calibration::thesis);
    let modes = |e| study.modes.iter().map(move |mode| (e, mode));
    let conditions = study.environments.iter().flat_map(modes);
    conditions.filter_map(|(e, m)| condition_scene(study, e, m, &calibration)).collect()
}

/// Every setting of every scene, and what is recommended.
fn files(layout: &Layout) -> [PathBuf; 2] {
    ["trade.parquet", "trade_summary.parquet"].map(|name| derived(layout, name))
}

/// The derived tables, where there are scenes.
pub(crate) fn tables(data: &StudyData) -> Vec<PathBuf> {
    if scenes(data).is_empty() { Vec::new() } else { files(&data.layout).to_vec() }
}

/// What the trade of a study depends on: no recording.
#[derive(Serialize)]
struct OfStudy {
    scenes: Vec<ModelScene>,
    perception: Perception,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let of = OfStudy { scenes: scenes(data), perception: data.study.perception.clone() };
    if of.scenes.is_empty() {
        return Vec::new();
    }
    let outputs = files(&data.layout).to_vec();
    vec![Job::new(STAGE, "trade of the study's conditions", of, (), outputs, make)]
}

fn make(of: &OfStudy, (): &(), making: &Making) -> Result<Made, JobError> {
    let one =
        |scene: &ModelScene| trade(scene, &Parameters::reduced(scene, &of.perception), &|| ());
    let trades: Vec<Trade> = of.scenes.par_iter().map(one).collect::<Result<_, _>>()?;
    let title = "Speed against accuracy";
    let tables =
        [settings_table("trade", title, &trades)?, summary_table("trade_summary", title, &trades)?];
    write_tables(&tables, making, Vec::new())
}

/// A figure a scene.
pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    const KIND: FigureKind = WORK_PRECISION;
    let [settings, summary] = files(&data.layout);
    let one = |scene: ModelScene| {
        let inputs = vec![settings.clone(), summary.clone()];
        Drawing::new(data, KIND, [scene.name.replace('.', "_")], scene.name, inputs, draw)
    };
    scenes(data).into_iter().map(one).collect()
}

fn draw(scene: &String, files: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let [settings, summary] = files.as_slice() else { return Err("a trade has two tables".into()) };
    let (settings, summary) = (Table::from_parquet(settings)?, Table::from_parquet(summary)?);
    let figure = zwidth_figures::work_precision_of(scene, &settings, &summary)?;
    write_figure(figure, Vec::new(), making)
}
