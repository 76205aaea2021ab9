//! Stage `simulate`: runs of the scenes that study.toml lists, and their figures. No recordings go
//! into them.

use crate::figures::drawing::{Drawing, Figured};
use crate::shared::making::{derived, read_tables, write_tables};
use serde::Serialize;

use std::path::{Path, PathBuf};
use zwidth_figures::{SCENE_BOW_TIE, SCENE_INPUTS, SCENE_RUNS};
use zwidth_results::{BowTieSample, ModelRun, Row as _};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_simulate::{
    BOW_TIE_NOTE, DEFAULT_SOLVER, DEFAULT_TOLERANCE, ModelScene, bow_tie, model_run, simulate,
    solver,
};
use zwidth_store::{StoreError, StudyData, read_regular};
use zwidth_study::{SceneDrawing, SceneFigure};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "simulate", version: zwidth_simulate::VERSION };

/// Bytes of a scene (64 MiB): one may hold a recorded series.
const MOST_BYTES: u64 = 1 << 26;

/// The results of the runs of a figure's scenes, one table each.
fn tables(data: &StudyData, figure: &SceneFigure) -> Vec<PathBuf> {
    (1..=figure.files.len())
        .map(|n| derived(&data.layout, format!("scenes/{}.{n}.parquet", figure.id)))
        .collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let scenes = data.study.scenes.iter().map(|figure| {
        let name = format!("scenes {}", figure.id);
        let files = figure.files.iter().map(|file| data.layout.raw().join(file));
        let files: Vec<PathBuf> = files.collect();
        Job::new(STAGE, name, figure.clone(), files, tables(data, figure), make)
    });
    scenes.collect()
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
    let text = std::str::from_utf8(&bytes).map_err(|error| format!("{file}: {error}"))?;
    Ok(ModelScene::from_toml(text).map_err(|error| format!("{file}: {error}"))?)
}

/// A scene's run as a table.
fn run(figure: &SceneFigure, mut scene: ModelScene) -> Result<Table, JobError> {
    scene.step_s = figure.step_s.unwrap_or(scene.step_s);
    if figure.draw == SceneDrawing::BowTie {
        let samples = Table::of_rows(&bow_tie(&scene)?)?;
        return Ok(samples.called(BowTieSample::NAME, scene.name).with_note(BOW_TIE_NOTE));
    }
    let name = figure.solver.as_deref().unwrap_or(DEFAULT_SOLVER);
    let run = simulate(scene, solver(name, DEFAULT_TOLERANCE)?.as_ref())?;
    Ok(Table::of_run(&model_run(&run))?)
}

/// How the runs that a job reads are drawn.
#[derive(Serialize)]
struct Drawn {
    draw: SceneDrawing,
    /// How many of the tables are the figure's own; the others are of figures that it is compared
    /// with, whose axes it shares.
    own: usize,
}

pub(crate) fn figures(data: &StudyData) -> Vec<Drawing> {
    let drawings = data.study.scenes.iter().map(|figure| {
        let kind = match figure.draw {
            SceneDrawing::Runs => SCENE_RUNS,
            SceneDrawing::Inputs => SCENE_INPUTS,
            SceneDrawing::BowTie => SCENE_BOW_TIE,
        };
        let mut inputs = tables(data, figure);
        let drawn = Drawn { draw: figure.draw, own: inputs.len() };
        let compared = compared_with(figure, &data.study.scenes);
        inputs.extend(compared.into_iter().flat_map(|other| tables(data, other)));
        let subject = [figure.id.to_string()];
        Drawing::new(data, kind, subject, drawn, inputs, draw).of(figure.files.len())
    });
    drawings.collect()
}

/// The other figures of runs that show a scene of this one, such as the same scene by another
/// solver, and those that show a scene of these: all of them have the same axes.
fn compared_with<'a>(figure: &'a SceneFigure, all: &'a [SceneFigure]) -> Vec<&'a SceneFigure> {
    // `alike` grows while it is gone through: a figure found late may lead to further ones.
    let mut alike = vec![figure];
    let mut next = 0;
    while let Some(one) = alike.get(next).copied() {
        next += 1;
        for other in all {
            let is_listed = alike.iter().any(|listed| listed.id == other.id);
            let are_runs = [one, other].iter().all(|figure| figure.draw == SceneDrawing::Runs);
            if are_runs && !is_listed && other.files.iter().any(|file| one.files.contains(file)) {
                alike.push(other);
            }
        }
    }
    alike.split_off(1)
}

fn draw(drawn: &Drawn, files: &Vec<PathBuf>) -> Figured {
    let tables = read_tables(files)?;
    if drawn.draw == SceneDrawing::BowTie {
        let [table] = tables.as_slice() else {
            return Err("a bow tie is drawn of one scene".into());
        };
        let figure = zwidth_figures::bow_tie(table.title(), &table.to_rows()?, BOW_TIE_NOTE);
        return Ok((figure, Vec::new()));
    }
    let runs: Vec<ModelRun> = tables.iter().map(Table::to_run).collect::<Result<_, _>>()?;
    let runs: Vec<&ModelRun> = runs.iter().collect();
    // `split_at` would panic on a number from the plan that the files do not bear out.
    let (own, compared) = runs.split_at(drawn.own.min(runs.len()));
    let figure = match drawn.draw {
        SceneDrawing::Inputs => zwidth_figures::inputs(own),
        _ => zwidth_figures::simulation(own, compared),
    };
    Ok((figure, Vec::new()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(id: &str, files: &[&str]) -> SceneFigure {
        SceneFigure {
            id: id.parse().unwrap(),
            files: files.iter().map(|file| (*file).to_owned()).collect(),
            draw: SceneDrawing::Runs,
            solver: None,
            step_s: None,
        }
    }

    #[test]
    fn figures_that_share_a_scene_are_compared_whichever_way_one_looks() {
        let inputs = SceneFigure { draw: SceneDrawing::Inputs, ..figure("inputs", &["a", "b"]) };
        let all = [
            figure("thesis", &["a"]),
            figure("exact", &["a"]),
            figure("both", &["a", "b"]),
            figure("last", &["b"]),
            figure("other", &["c"]),
            inputs,
        ];
        let ids = |figure: &SceneFigure| -> Vec<String> {
            let mut ids: Vec<String> =
                compared_with(figure, &all).into_iter().map(|one| one.id.to_string()).collect();
            ids.sort();
            ids
        };
        assert_eq!(ids(&all[0]), ["both", "exact", "last"]);
        assert_eq!(ids(&all[3]), ["both", "exact", "thesis"]);
        assert!(ids(&all[4]).is_empty() && ids(&all[5]).is_empty());
    }
}
