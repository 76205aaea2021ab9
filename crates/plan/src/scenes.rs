//! Stage `simulate`: runs of the scenes that study.toml lists, and their figures. No recording goes
//! into them.

use crate::drawing::{Drawing, Figured};
use crate::making::{derived, read_tables, write_tables};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use zwidth_figures::{SCENE_BOW_TIE, SCENE_INPUTS, SCENE_RUNS};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_simulate::{
    DEFAULT_SOLVER, DEFAULT_TOLERANCE, ModelScene, bow_tie_table, simulate, solver,
    trajectory_table,
};
use zwidth_store::{StoreError, StudyData, read_regular};
use zwidth_study::{SceneDrawing, SceneFigure};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "simulate", version: zwidth_simulate::VERSION };

/// Bytes of a scene (64 MiB): one may hold a recorded series.
const MOST_BYTES: u64 = 1 << 26;

/// The scene files of a figure.
fn files(data: &StudyData, figure: &SceneFigure) -> Vec<PathBuf> {
    figure.files.iter().map(|file| data.layout.raw().join(file)).collect()
}

/// The results of their runs, one table each.
fn tables(data: &StudyData, figure: &SceneFigure) -> Vec<PathBuf> {
    let of = |n| derived(&data.layout, format!("scenes/{}.{n}.parquet", figure.id));
    (1..=figure.files.len()).map(of).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let job = |figure: &SceneFigure| {
        let name = format!("scenes {}", figure.id);
        Job::new(STAGE, name, figure.clone(), files(data, figure), tables(data, figure), make)
    };
    data.study.scenes.iter().map(job).collect()
}

fn make(figure: &SceneFigure, files: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let mut tables = Vec::new();
    for (path, file) in files.iter().zip(&figure.files) {
        let scene = read_scene(path, file)?;
        tables.push(run(figure, scene).map_err(|error| format!("{file}: {error}"))?);
    }
    write_tables(&tables, making, Vec::new())
}

/// The scene of a file, which study.toml calls `file`.
pub(crate) fn read_scene(path: &Path, file: &str) -> Result<ModelScene, JobError> {
    let bytes = read_regular(path, MOST_BYTES).map_err(|e| StoreError::io(path, "read", &e))?;
    let of_file = |error: &dyn Display| JobError::from(format!("{file}: {error}"));
    let text = std::str::from_utf8(&bytes).map_err(|error| of_file(&error))?;
    ModelScene::from_toml(text).map_err(|error| of_file(&error))
}

/// A scene's run as a table.
fn run(figure: &SceneFigure, mut scene: ModelScene) -> Result<Table, JobError> {
    scene.step_s = figure.step_s.unwrap_or(scene.step_s);
    if figure.draw == SceneDrawing::BowTie {
        return Ok(bow_tie_table(&scene)?);
    }
    let name = figure.solver.as_deref().unwrap_or(DEFAULT_SOLVER);
    let run = simulate(scene, solver(name, DEFAULT_TOLERANCE)?.as_ref())?;
    Ok(trajectory_table(&run)?)
}

pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let drawing = |figure: &SceneFigure| {
        let kind = match figure.draw {
            SceneDrawing::Runs => SCENE_RUNS,
            SceneDrawing::Inputs => SCENE_INPUTS,
            SceneDrawing::BowTie => SCENE_BOW_TIE,
        };
        let (subject, inputs) = ([figure.id.to_string()], tables(data, figure));
        Drawing::new(data, kind, subject, figure.draw, inputs, draw).of(figure.files.len())
    };
    data.study.scenes.iter().map(drawing).collect()
}

fn draw(what: &SceneDrawing, files: &Vec<PathBuf>) -> Figured {
    let tables = read_tables(files)?;
    let tables: Vec<&Table> = tables.iter().collect();
    let figure = match (what, tables.as_slice()) {
        (SceneDrawing::Runs, runs) => zwidth_figures::simulation(runs)?,
        (SceneDrawing::Inputs, runs) => zwidth_figures::inputs(runs)?,
        (SceneDrawing::BowTie, [table]) => zwidth_figures::bow_tie(table)?,
        (SceneDrawing::BowTie, _) => return Err("a bow tie is drawn of one scene".into()),
    };
    Ok((figure, Vec::new()))
}
