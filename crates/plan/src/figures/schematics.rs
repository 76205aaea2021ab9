//! Schematics of the model, of the device and of its control: figures of what was planned. Those of
//! the model are of the first scene that study.toml draws runs of.

use crate::figures::design::has_actuators;
use crate::figures::drawing::{Drawing, Figured};
use crate::scenes::read_scene;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_figures::{FigureKind, Modelled, OF_DEVICE, OF_MODEL};
use zwidth_simulate::DEFAULT_SOLVER;
use zwidth_store::StudyData;
use zwidth_study::{SceneDrawing, SceneFigure, Setup};

pub(crate) fn all(data: &StudyData) -> Vec<Drawing> {
    let mut drawings = Vec::new();
    let runs = data.study.scenes.iter().find(|figure| figure.draw == SceneDrawing::Runs);
    if let Some((figure, file)) = runs.and_then(|figure| Some((figure, figure.files.first()?))) {
        for (kind, _) in OF_MODEL {
            let one = One { kind, of: figure.clone() };
            let path = data.layout.raw().join(file);
            drawings.push(Drawing::new(data, kind, [""; 0], one, path, draw_model));
        }
    }
    if has_actuators(data) {
        for (kind, draw) in OF_DEVICE {
            let one = One { kind, of: Setup::of(&data.study).without_questions() };
            // A schematic of a part that the device lacks cannot be drawn.
            if draw(&one.of).is_some() {
                drawings.push(Drawing::new(data, kind, [""; 0], one, (), draw_device));
            }
        }
    }
    drawings
}

/// One of several schematics, and what it is drawn from besides files.
#[derive(Serialize)]
struct One<T> {
    kind: FigureKind,
    of: T,
}

fn draw_model(One { kind, of }: &One<SceneFigure>, path: &PathBuf) -> Figured {
    let file = of.files.first().ok_or("the figure has no scene")?;
    let solver = of.solver.as_deref().unwrap_or(DEFAULT_SOLVER);
    let model = Modelled::new(read_scene(path, file)?, file, solver, of.step_s)
        .map_err(|error| format!("{file}: {error}"))?;
    let (_, draw) = OF_MODEL.iter().find(|(own, _)| own == kind).ok_or("no such schematic")?;
    Ok((draw(&model), Vec::new()))
}

fn draw_device(One { kind, of }: &One<Setup>, (): &()) -> Figured {
    let (_, draw) = OF_DEVICE.iter().find(|(own, _)| own == kind).ok_or("no such schematic")?;
    Ok((draw(of).ok_or("the device cannot be drawn")?, Vec::new()))
}
