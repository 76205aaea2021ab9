//! `zwidth ladder`: which terms of the model a scene, or a study's condition, needs.

use super::output::Output;
use super::simulate::{check_stems, stem};
use super::{as_lines, load, no_study};
use crate::exit::Exit;
use crate::limits::positive;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use zwidth_device::Velocity;
use zwidth_figures::LadderRows;
use zwidth_ladder::{
    Ladder, Loop, Settings, effects, effects_table, interactions_table, ladder as climb, models,
    models_table, own, possible, reason, told,
};
use zwidth_simulate::ModelScene;
use zwidth_study::{Control, Perception, StudyId, counted};

#[derive(Debug, clap::Args)]
pub(crate) struct LadderArgs {
    /// Scenes, files that end in .toml, or studies, of which every condition with a recording is
    /// one [default: all studies under raw/]
    #[arg(value_name = "SCENE.toml|STUDY")]
    pub(crate) scenes: Vec<PathBuf>,
    /// Points of the simulated device's parameters
    #[arg(long, value_name = "N", default_value_t = zwidth_ladder::DEFAULT_POINTS)]
    pub(crate) points: usize,
    /// Rate of the control loop in Hz [default: a scene's is the thesis' 120.5, one sample in 8.3
    /// ms; a study's its own]
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub(crate) rate: Option<f64>,
    /// Folder to write to [default: reports/ladder]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
}

/// The loop of a scene that no study names: the thesis' h, s (Table 3).
const THESIS_PERIOD_S: f64 = 0.0083;

/// What came of a scene.
#[derive(Default, Serialize)]
struct Outcome {
    scene: String,
    /// The words of the terms that it needs; none if it could not be climbed.
    terms: Option<Vec<String>>,
    /// The choice in a sentence, and why each term is in it or not.
    told: Vec<String>,
    files: Vec<PathBuf>,
    error: Option<String>,
}

/// The ladder of a scene or a condition.
struct Climbed {
    /// What its files are called.
    name: String,
    ladder: Ladder,
    /// Whether its force was simulated.
    synthetic: bool,
}

pub(crate) fn ladder(root: &Path, command: &LadderArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let folder = command.out.clone().unwrap_or_else(|| root.join("reports").join("ladder"));
    let mut outcomes = Vec::new();
    for name in named(root, command)? {
        match climb_all(root, &name, command, screen) {
            Ok(ladders) => {
                let rows: Vec<LadderRows> =
                    ladders.iter().map(|climbed| rows(&climbed.ladder)).collect();
                for climbed in &ladders {
                    outcomes.push(write(&folder, command, climbed, &rows)?);
                }
            }
            Err(error) => outcomes.push(Outcome {
                scene: name.display().to_string(),
                error: Some(format!("{error:#}")),
                ..Outcome::default()
            }),
        }
    }
    let failed = outcomes.iter().filter(|outcome| outcome.error.is_some()).count();
    if failed == outcomes.len() {
        let errors = outcomes.into_iter().filter_map(|outcome| outcome.error);
        return Err(as_lines(errors.collect(), 0));
    }
    screen.give(&outcomes, || {
        for Outcome { scene, told, files, error, .. } in &outcomes {
            if let Some(error) = error {
                screen.warn(format!("skipped: {error}"));
            }
            if let Some((first, others)) = told.split_first() {
                screen.result(format!("{scene}: {first}"));
                others.iter().for_each(|line| screen.result(format!("  {line}")));
            }
            screen.files(files, &["png"], "  ");
        }
    })?;
    Ok(if failed == 0 { Exit::Fine } else { Exit::Partly })
}

/// The scenes and studies that the command names, each once; all studies by default.
fn named(root: &Path, command: &LadderArgs) -> anyhow::Result<Vec<PathBuf>> {
    let mut named = if command.scenes.is_empty() {
        let all = super::studies(root, Vec::new())?;
        all.iter().map(|layout| PathBuf::from(layout.study().as_str())).collect()
    } else {
        command.scenes.clone()
    };
    let mut seen = BTreeSet::new();
    named.retain(|name| seen.insert(name.clone()));
    check_stems(&named, "ask for them apart")?;
    Ok(named)
}

/// The ladder of a scene's file, or those of a study's conditions.
fn climb_all(
    root: &Path,
    name: &Path,
    command: &LadderArgs,
    screen: &Screen,
) -> anyhow::Result<Vec<Climbed>> {
    if name.extension().is_some_and(|extension| extension == "toml") {
        return Ok(vec![climb_scene(name, command, screen)?]);
    }
    let id = name.to_str().ok_or_else(|| anyhow!("{}", no_study(name)))?;
    let id = StudyId::new(id).with_context(|| {
        format!("{id} is neither a scene, which is a file that ends in .toml, nor a study")
    })?;
    let data = load(root, &id)?;
    let study = data.layout.study();
    let bar = screen.bar(command.points);
    let begin = |condition: &str| {
        let points = counted(command.points, "points");
        // A line that is printed while the bar is drawn would run into it.
        bar.suspend(|| screen.say(format!("{condition}: {points}")));
        bar.reset();
    };
    let ladders = zwidth_plan::ladders(&data, command.points, command.rate, &begin, &|| bar.inc(1));
    bar.finish_and_clear();
    let ladders = ladders.map_err(|error| anyhow!("{study}: {error}"))?;
    if ladders.is_empty() {
        bail!(
            "{study} has no recorded trial in a spring or a constant force, without a delay, whose force could be replayed; name a scene, or record one"
        );
    }
    let ladders = ladders.into_iter().map(|(key, ladder, synthetic)| Climbed {
        name: format!("{study}.{key}"),
        ladder,
        synthetic,
    });
    Ok(ladders.collect())
}

/// The ladder of a scene's file, over the terms that it can have.
fn climb_scene(path: &Path, command: &LadderArgs, screen: &Screen) -> anyhow::Result<Climbed> {
    let text = crate::text::scene(path)?;
    let shown = path.display().to_string();
    let scene = ModelScene::from_toml(&text).with_context(|| shown.clone())?;
    let velocity = Velocity::new(Control::default().velocity)?;
    let settings = Settings {
        looped: Loop { period_s: command.rate.map_or(THESIS_PERIOD_S, |hz| 1.0 / hz), velocity },
        points: command.points,
        bounds: Perception::default(),
        offered: possible(&scene),
    };
    let points = counted(command.points, "points");
    let models = 1_usize << settings.offered.len();
    screen.say(format!("{shown}: {models} models at {points}"));
    let bar = screen.bar(command.points);
    let ladder = climb(&scene, &settings, &own, &|| bar.inc(1));
    bar.finish_and_clear();
    let ladder = ladder.with_context(|| shown)?;
    Ok(Climbed { name: stem(path), ladder, synthetic: false })
}

/// What a figure is drawn from.
fn rows(ladder: &Ladder) -> LadderRows {
    LadderRows { models: models(ladder), effects: effects(ladder) }
}

/// Writes a ladder, its figure on axes that hold those of all conditions, `beside`.
fn write(
    folder: &Path,
    command: &LadderArgs,
    Climbed { name, ladder, synthetic }: &Climbed,
    beside: &[LadderRows],
) -> anyhow::Result<Outcome> {
    let source = match synthetic {
        true => "SYNTHETIC: model runs under a simulated force, not measured",
        false => "model runs, not measured",
    };
    let made_from = [
        ("source", source.to_owned()),
        ("scene", ladder.scene.clone()),
        ("points", ladder.points.to_string()),
        ("version", zwidth_ladder::VERSION.to_string()),
    ];
    let rate_hz = command.rate.map(|rate_hz| ("rate_hz", rate_hz.to_string()));
    let mut output = Output::new(folder, made_from.into_iter().chain(rate_hz));
    let table = models_table(ladder)?;
    let figure = zwidth_figures::ladder(&rows(ladder), beside, table.notes(), *synthetic);
    output.figure(name, figure)?;
    output.table(&format!("{name}.models"), &table)?;
    output.table(&format!("{name}.effects"), &effects_table(ladder)?)?;
    output.table(&format!("{name}.interactions"), &interactions_table(ladder)?)?;
    let choice = ladder.choice();
    let why = choice
        .iter()
        .flat_map(|choice| ladder.offered.terms().map(|term| reason(ladder, choice, term)));
    let told = choice.iter().map(|choice| told(ladder, choice)).chain(why).collect();
    Ok(Outcome {
        scene: name.clone(),
        terms: choice
            .map(|choice| choice.set.terms().map(|term| term.as_str().to_owned()).collect()),
        told,
        files: output.files,
        error: None,
    })
}
