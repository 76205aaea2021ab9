//! `zwidth simulate`: model runs of scenes, as figures and tables.

mod others;
pub(super) mod scene_file;
mod words;

use super::output::Output;
use crate::exit::Exit;
use crate::limits::{positive, tolerance};
use crate::screen::Screen;
use anyhow::bail;
use clap::builder::PossibleValuesParser;
use others::Request;
use scene_file::SceneFile;
pub(super) use scene_file::stem;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_figures::MOST_SIDE_BY_SIDE;
use zwidth_results::{BowTieSample, ChatteringRun, ModelEvent, ModelRun, Row as _};
use zwidth_simulate::{
    BOW_TIE_NOTE, CHATTERING_NOTE, CHATTERING_STEPS_S, DEFAULT_SOLVER, ModelScene, OtherFormat,
    SOLVERS, Summary, bow_tie, chattering, model_events, model_run, simulate as run_scene, solver,
};
use zwidth_tables::Table;

/// The default of --tolerance: [`zwidth_simulate::DEFAULT_TOLERANCE`] as people
/// write it.
const DEFAULT_TOLERANCE: &str = "1e-9";

#[derive(Debug, clap::Args)]
pub(crate) struct SimulateArgs {
    /// Scenes; of two or more the inputs are drawn beside each other too
    #[arg(required = true, value_name = "SCENE.toml")]
    pub(crate) scenes: Vec<PathBuf>,
    /// The solver
    #[arg(long, value_name = "NAME", default_value = DEFAULT_SOLVER, value_parser = PossibleValuesParser::new(SOLVERS))]
    pub(crate) solver: String,
    /// Time between samples in s, which is the step of solvers of a fixed step [default: the
    /// scene's]
    #[arg(long, value_name = "S", value_parser = positive)]
    pub(crate) step: Option<f64>,
    /// Relative error a step that dormand_prince and tr_bdf2 aim for
    #[arg(long, value_name = "X", value_parser = tolerance, default_value = DEFAULT_TOLERANCE)]
    pub(crate) tolerance: f64,
    /// Folder to write to, or with --as the file [default: reports/simulate]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Every solver at steps from 8.3 ms down: which oscillation is the method's, and which the
    /// model's
    #[arg(long)]
    pub(crate) chattering: bool,
    /// Instead of pushing the lever, move it from stop to stop and back: force against angle
    #[arg(long, conflicts_with = "chattering")]
    pub(crate) bow_tie: bool,
    /// Run nothing: write the scene as a model file or a program for other simulators, with what
    /// the format cannot say
    #[arg(long = "as", value_name = "FORMAT", value_parser = others::format(),
        conflicts_with_all = ["chattering", "bow_tie", "solver", "tolerance"])]
    pub(crate) other: Option<OtherFormat>,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Report {
    scenes: Vec<Outcome>,
    /// Files of figures that show several scenes.
    shared: Vec<PathBuf>,
}

/// What came of a scene.
#[derive(Serialize)]
struct Outcome {
    scene: PathBuf,
    summary: Option<Summary>,
    files: Vec<PathBuf>,
    error: Option<String>,
}

/// A scene that was run; a bow tie has neither summary nor trajectory.
struct Done {
    stem: String,
    run: Option<(Summary, ModelRun)>,
    files: Vec<PathBuf>,
}

pub(crate) fn simulate(
    root: &Path,
    command: &SimulateArgs,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    if let Some(format) = command.other {
        check_stems(&command.scenes, "write them apart")?;
        let request = Request { format, step_s: command.step, out: command.out.as_deref() };
        return others::write(root, &command.scenes, &request, screen);
    }
    let folder = command.out.clone().unwrap_or_else(|| root.join("reports").join("simulate"));
    // Before the first run, which may take long.
    check_stems(&command.scenes, "simulate them apart")?;
    let mut outcomes = Vec::new();
    let mut done = Vec::new();
    let cells = if command.chattering { SOLVERS.len() * CHATTERING_STEPS_S.len() } else { 0 };
    let each = 1 + cells;
    let bar = screen.bar(command.scenes.len() * each);
    for (i, path) in command.scenes.iter().enumerate() {
        let result = one(path, &folder, command, &|| bar.inc(1));
        // A scene that failed has its part behind it too.
        bar.set_position(((i + 1) * each) as u64);
        outcomes.push(outcome(path, &result));
        done.extend(result.ok());
    }
    bar.finish_and_clear();
    if done.is_empty() {
        let errors = outcomes.into_iter().filter_map(|outcome| outcome.error);
        return Err(super::as_lines(errors.collect(), 0));
    }
    let shared = shared(&done, &folder, command)?;
    let exit = if done.len() == outcomes.len() { Exit::Fine } else { Exit::Partly };
    let report = Report { scenes: outcomes, shared };
    screen.give(&report, || {
        for outcome in &report.scenes {
            if let Some(error) = &outcome.error {
                screen.warn(format!("skipped: {error}"));
            }
            if let Some(summary) = &outcome.summary {
                let lines = words::summary_lines(summary);
                screen.result(format!("{}: {lines}", outcome.scene.display()));
            }
            screen.files(&outcome.files, &["png"], "  ");
        }
        screen.files(&report.shared, &["png"], "  ");
    })?;
    Ok(exit)
}

/// Two scenes of one name would write to the same files: files are named by the stem alone.
pub(super) fn check_stems(scenes: &[PathBuf], remedy: &str) -> anyhow::Result<()> {
    for (i, path) in scenes.iter().enumerate() {
        if let Some(other) = scenes[..i].iter().find(|other| stem(other) == stem(path)) {
            let a = other.display();
            let b = path.display();
            bail!("{a} and {b} would write to the same files; {remedy}, or rename one");
        }
    }
    Ok(())
}

/// Runs one scene and writes all that is its own. `progress` is called after each run.
fn one(
    path: &Path,
    folder: &Path,
    command: &SimulateArgs,
    progress: &dyn Fn(),
) -> anyhow::Result<Done> {
    let mut file = SceneFile::read(path)?;
    if let Some(step_s) = command.step {
        file.scene.step_s = step_s;
    }
    let stem = stem(path);
    let mut output = Output::new(folder, made_from(command, Some(&file.scene))?);
    if command.bow_tie {
        let samples = bow_tie(&file.scene).map_err(|e| file.error(&e))?;
        let (name, scene) = (format!("{stem}.bow_tie"), file.scene.name.as_str());
        output.figure(&name, zwidth_figures::bow_tie(scene, &samples, BOW_TIE_NOTE))?;
        let table = Table::of_rows(&samples)?.called(BowTieSample::NAME, scene);
        output.table(&name, &table.with_note(BOW_TIE_NOTE))?;
        return Ok(Done { stem, run: None, files: output.files });
    }
    let solver = solver(&command.solver, command.tolerance)?;
    let run = run_scene(file.scene.clone(), solver.as_ref()).map_err(|e| file.error(&e))?;
    progress();
    let shown = model_run(&run);
    let scene = &file.scene.name;
    output.figure(&stem, zwidth_figures::simulation(&[&shown], &[]))?;
    output.table(&format!("{stem}.trajectory"), &Table::of_run(&shown)?)?;
    let events = Table::of_rows(&model_events(&run))?.without_empty_columns();
    let events = events.called(ModelEvent::NAME, format!("{scene}: events"));
    let note = shown.notes.first().cloned().unwrap_or_default();
    output.table(&format!("{stem}.events"), &events.with_note(note))?;
    if command.chattering {
        let runs = chattering(&file.scene, &SOLVERS, &CHATTERING_STEPS_S, progress)
            .map_err(|e| file.error(&e))?;
        let name = format!("{stem}.chattering");
        let title = format!("{scene}: chattering");
        output.figure(&name, zwidth_figures::chattering(&title, &runs, CHATTERING_NOTE))?;
        let table = Table::of_rows(&runs)?.called(ChatteringRun::NAME, title);
        output.table(&name, &table.with_note(CHATTERING_NOTE))?;
    }
    Ok(Done { stem, run: Some((Summary::of(&run), shown)), files: output.files })
}

/// Which solver made the files, and of which scene, word for word.
fn made_from(
    command: &SimulateArgs,
    scene: Option<&ModelScene>,
) -> anyhow::Result<Vec<(&'static str, String)>> {
    let scene = scene.map(ModelScene::to_toml).transpose()?;
    let facts = [
        ("solver", Some(command.solver.clone())),
        ("tolerance", Some(command.tolerance.to_string())),
        ("scene", scene),
    ];
    Ok(facts.into_iter().filter_map(|(key, value)| Some((key, value?))).collect())
}

/// The figures of several scenes: their inputs, and the runs side by side where the page is wide
/// enough.
fn shared(done: &[Done], folder: &Path, command: &SimulateArgs) -> anyhow::Result<Vec<PathBuf>> {
    let runs: Vec<&ModelRun> =
        done.iter().filter_map(|d| d.run.as_ref()).map(|run| &run.1).collect();
    if runs.len() < 2 {
        return Ok(Vec::new());
    }
    let first = done.iter().take(MOST_SIDE_BY_SIDE).map(|d| d.stem.as_str());
    let mut name = first.collect::<Vec<_>>().join("+");
    if let Some(more @ 1..) = done.len().checked_sub(MOST_SIDE_BY_SIDE) {
        name.push_str(&format!("+{more}"));
    }
    let mut output = Output::new(folder, made_from(command, None)?);
    output.figure(&format!("{name}.inputs"), zwidth_figures::inputs(&runs))?;
    if runs.len() <= MOST_SIDE_BY_SIDE {
        output.figure(&name, zwidth_figures::simulation(&runs, &[]))?;
    }
    Ok(output.files)
}

fn outcome(path: &Path, result: &anyhow::Result<Done>) -> Outcome {
    let done = result.as_ref().ok();
    Outcome {
        scene: path.to_owned(),
        summary: done.and_then(|done| done.run.as_ref()).map(|run| run.0.clone()),
        files: done.map(|done| done.files.clone()).unwrap_or_default(),
        error: result.as_ref().err().map(|error| format!("{error:#}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::limits::positive;

    #[test]
    fn the_default_tolerance_is_the_stage_s_own() {
        assert_eq!(positive(DEFAULT_TOLERANCE), Ok(zwidth_simulate::DEFAULT_TOLERANCE));
    }
}
