//! `zwidth ladder`: which terms of the model a scene, or a study's condition, needs.

use super::output::Output;
use super::{no_study, study};
use crate::exit::Exit;
use crate::limits::positive;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use zwidth_device::Velocity;
use zwidth_figures::LadderRows;
use zwidth_ladder::{
    Ladder, Loop, Settings, effects, effects_table, interactions_table, ladder as climb, models,
    models_table, own, possible, reason, told,
};
use zwidth_runner::Provenance;
use zwidth_simulate::ModelScene;
use zwidth_store::StudyData;
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
#[derive(Serialize)]
struct Outcome {
    scene: String,
    /// The words of the terms that it needs; none if it could not be climbed.
    terms: Option<Vec<String>>,
    /// The choice in a sentence, and why each term is in it or not.
    told: Vec<String>,
    files: Vec<PathBuf>,
    error: Option<String>,
}

/// A ladder, what its files are called, and whether its force was simulated.
type Climbed = (String, Ladder, bool);

pub(crate) fn ladder(root: &Path, asked: &LadderArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let folder = asked.out.clone().unwrap_or_else(|| root.join("reports").join("ladder"));
    let mut outcomes = Vec::new();
    for name in named(root, asked)? {
        match climbed(root, &name, asked, screen) {
            Ok(ladders) => {
                let rows: Vec<LadderRows> =
                    ladders.iter().map(|(_, ladder, _)| rows(ladder)).collect();
                for ladder in &ladders {
                    outcomes.push(written(&folder, asked, ladder, &rows)?);
                }
            }
            Err(error) => outcomes.push(Outcome {
                scene: name.display().to_string(),
                terms: None,
                told: Vec::new(),
                files: Vec::new(),
                error: Some(format!("{error:#}")),
            }),
        }
    }
    let failed = outcomes.iter().filter(|outcome| outcome.error.is_some()).count();
    if failed == outcomes.len() {
        let errors = outcomes.into_iter().filter_map(|outcome| outcome.error);
        bail!("{}", errors.collect::<Vec<_>>().join("\n       "));
    }
    if screen.json {
        screen.listing(&outcomes)?;
    } else {
        outcomes.iter().for_each(|outcome| tell(outcome, screen));
    }
    Ok(if failed == 0 { Exit::Fine } else { Exit::Partly })
}

/// What is asked for, each once; all studies by default.
fn named(root: &Path, asked: &LadderArgs) -> anyhow::Result<Vec<PathBuf>> {
    let mut named = if asked.scenes.is_empty() {
        let all = super::studies(root, Vec::new())?;
        all.iter().map(|layout| PathBuf::from(layout.study().as_str())).collect()
    } else {
        asked.scenes.clone()
    };
    let mut seen: Vec<PathBuf> = Vec::new();
    named.retain(|name| {
        !seen.contains(name) && {
            seen.push(name.clone());
            true
        }
    });
    for (i, name) in named.iter().enumerate() {
        if let Some(other) = named[..i].iter().find(|other| stem(other) == stem(name)) {
            let a = other.display();
            let b = name.display();
            bail!("{a} and {b} would write to the same files; ask for them apart, or rename one");
        }
    }
    Ok(named)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

fn climbed(
    root: &Path,
    name: &Path,
    asked: &LadderArgs,
    screen: &Screen,
) -> anyhow::Result<Vec<Climbed>> {
    if name.extension().is_some_and(|extension| extension == "toml") {
        return Ok(vec![of_scene(name, asked, screen)?]);
    }
    let id = name.to_str().ok_or_else(|| anyhow!("{}", no_study(name)))?;
    let id = StudyId::new(id).with_context(|| {
        format!("{id} is neither a scene, which is a file that ends in .toml, nor a study")
    })?;
    let layout = study(root, id)?;
    let data = StudyData::load(&layout).map_err(|findings| super::join_findings(&findings))?;
    let bar = screen.bar(asked.points);
    let begun = |condition: &str| {
        let points = counted(asked.points, "points");
        bar.suspend(|| screen.say(format!("{condition}: {points}")));
        bar.reset();
    };
    let point = || bar.inc(1);
    let ladders = zwidth_plan::ladders(&data, asked.points, asked.rate, &begun, &point);
    bar.finish_and_clear();
    let ladders = ladders.map_err(|error| anyhow!("{}: {error}", layout.study()))?;
    if ladders.is_empty() {
        bail!(
            "{} has no recorded trial in a spring whose force could be replayed; name a scene, or record one",
            layout.study()
        );
    }
    let named = |(key, ladder, synthetic)| (format!("{}.{key}", layout.study()), ladder, synthetic);
    Ok(ladders.into_iter().map(named).collect())
}

/// The ladder of a scene's file, over the terms that it can have.
fn of_scene(path: &Path, asked: &LadderArgs, screen: &Screen) -> anyhow::Result<Climbed> {
    let text = crate::text::scene(path)?;
    let at = || path.display().to_string();
    let scene = ModelScene::from_toml(&text).with_context(at)?;
    let velocity = Velocity::new(Control::default().velocity)?;
    let settings = Settings {
        looped: Loop { period_s: asked.rate.map_or(THESIS_PERIOD_S, |hz| 1.0 / hz), velocity },
        points: asked.points,
        bounds: Perception::default(),
        offered: possible(&scene),
    };
    let points = counted(asked.points, "points");
    let models = 1_usize << settings.offered.len();
    screen.say(format!("{}: {models} models at {points}", at()));
    let bar = screen.bar(asked.points);
    let ladder = climb(&scene, &settings, &own, &|| bar.inc(1));
    bar.finish_and_clear();
    let ladder = ladder.with_context(at)?;
    Ok((stem(path), ladder, false))
}

/// What a figure is drawn from.
fn rows(ladder: &Ladder) -> LadderRows {
    LadderRows { models: models(ladder), effects: effects(ladder) }
}

/// Writes a ladder, its figure on axes that hold those of all conditions, `beside`.
fn written(
    folder: &Path,
    asked: &LadderArgs,
    (name, ladder, synthetic): &Climbed,
    beside: &[LadderRows],
) -> anyhow::Result<Outcome> {
    let mut output = Output::new(folder, origin(ladder, asked, *synthetic));
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

fn tell(outcome: &Outcome, screen: &Screen) {
    if let Some(error) = &outcome.error {
        screen.warn(format!("skipped: {error}"));
    }
    let mut lines = outcome.told.iter();
    if let Some(first) = lines.next() {
        screen.result(format!("{}: {first}", outcome.scene));
    }
    lines.for_each(|line| screen.result(format!("  {line}")));
    let pictures = outcome.files.iter().filter(|path| path.extension().is_some_and(|e| e == "png"));
    pictures.for_each(|path| screen.result(format!("  {}", path.display())));
}

/// What the files of a ladder say of their making.
fn origin(ladder: &Ladder, asked: &LadderArgs, synthetic: bool) -> Provenance {
    let source = match synthetic {
        true => "SYNTHETIC: model runs under a simulated force, not measured",
        false => "model runs, not measured",
    };
    let mut provenance = BTreeMap::from([
        ("source".to_owned(), source.to_owned()),
        ("scene".to_owned(), ladder.scene.clone()),
        ("points".to_owned(), ladder.points.to_string()),
        ("version".to_owned(), zwidth_ladder::VERSION.to_string()),
    ]);
    if let Some(rate_hz) = asked.rate {
        provenance.insert("rate_hz".to_owned(), rate_hz.to_string());
    }
    provenance
}
