//! The arguments of `zwidth trade`, and the scenes that they name: from files, or a study's
//! conditions.

use super::super::simulate::scene_file::SceneFile;
use super::super::simulate::{check_stems, stem};
use super::super::{join_findings, no_study, studies};
use super::setups::Study;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::path::{Path, PathBuf};
use zwidth_plan::Traded;
use zwidth_store::{Layout, StudyData};
use zwidth_study::{Perception, StudyId};
use zwidth_trade::{ModelScene, Parameters, VERSION, models};

#[derive(Debug, clap::Args)]
pub(crate) struct TradeArgs {
    /// Scenes, files that end in .toml, or studies, of which every condition is one, and whose
    /// trials are simulated with another loop and other sensors [default: all studies under raw/]
    #[arg(value_name = "SCENE.toml|STUDY")]
    pub(crate) scenes: Vec<PathBuf>,
    /// A study, as above
    #[arg(long, value_name = "STUDY")]
    pub(crate) study: Vec<StudyId>,
    /// Folder to write to [default: reports/trade; for a study reports/STUDY/timing]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Trajectories of other programs for the scene, judged and drawn beside our solvers: a table with
    /// the columns name, setting, file, cost_s and, where a file needs a mapping, map; or TOML with
    /// `[[trajectories]]`. Files are named from the table's folder on
    #[arg(long, value_name = "TABLE")]
    pub(crate) trajectories: Option<PathBuf>,
    /// Do everything again, whether it changed or not
    #[arg(long)]
    pub(crate) fresh: bool,
}

/// A scene, what a person can feel of it, and where its results go.
pub(super) struct Source {
    pub(super) stem: String,
    pub(super) title: String,
    pub(super) scene: ModelScene,
    /// What is measured of it, where it is a study's condition.
    pub(super) traded: Option<Traded>,
    pub(super) perception: Perception,
    pub(super) folder: PathBuf,
}

impl Source {
    /// How many settings are run.
    pub(super) fn settings(&self) -> usize {
        models(&self.scene)
            .iter()
            .map(|model| Parameters::full(model, &self.perception).settings(model))
            .sum()
    }

    /// All that its files depend on, as text.
    pub(super) fn key(&self) -> anyhow::Result<String> {
        let parameters = Parameters::full(&self.scene, &self.perception);
        let key = serde_json::json!({
            "version": [VERSION, zwidth_figures::VERSION],
            "software": env!("CARGO_PKG_VERSION"),
            "scene": self.scene.to_toml()?,
            "metrics": self.traded,
            "parameters": parameters,
            "creep": "under half the friction",
        });
        Ok(format!("{key:#}\n"))
    }
}

/// What a command names.
pub(super) struct Requested {
    pub(super) scenes: Vec<Source>,
    pub(super) studies: Vec<Study>,
}

/// The scenes and studies that a command names; all studies where it names none.
pub(super) fn requested(
    root: &Path,
    command: &TradeArgs,
    screen: &Screen,
) -> anyhow::Result<Requested> {
    let (files, names): (Vec<PathBuf>, Vec<PathBuf>) = command
        .scenes
        .iter()
        .cloned()
        .partition(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let mut named = command.study.clone();
    for name in &names {
        let text = name.to_str().with_context(|| no_study(name))?;
        named.push(StudyId::new(text).with_context(|| {
            format!("{text} is neither a scene, which is a file that ends in .toml, nor a study")
        })?);
    }
    check_stems(&files, "simulate them apart")?;
    if command.trajectories.is_some() && (files.len() != 1 || !named.is_empty()) {
        bail!("--trajectories is of one scene; name that scene alone");
    }
    let folder = command.out.clone().unwrap_or_else(|| root.join("reports").join("trade"));
    let mut requested = Requested { scenes: Vec::new(), studies: Vec::new() };
    for path in &files {
        let scene = SceneFile::read(path)?.scene;
        requested.scenes.push(Source {
            stem: stem(path),
            title: scene.name.clone(),
            scene,
            traded: None,
            perception: Perception::default(),
            folder: folder.clone(),
        });
    }
    if files.is_empty() || !named.is_empty() {
        for layout in studies(root, named)? {
            add_study(&layout, command, screen, &mut requested)?;
        }
    }
    if requested.scenes.is_empty() {
        bail!("there is no scene to trade; name one, for instance scenes/sine.toml");
    }
    Ok(requested)
}

/// Adds the conditions of a study, and its trials.
fn add_study(
    layout: &Layout,
    command: &TradeArgs,
    screen: &Screen,
    requested: &mut Requested,
) -> anyhow::Result<()> {
    let data = StudyData::load(layout).map_err(|findings| join_findings(&findings))?;
    let folder = command.out.clone().unwrap_or_else(|| layout.reports().join("timing"));
    let scenes = zwidth_plan::trade_scenes(&data);
    let perception = zwidth_plan::perception(&data);
    let name = layout.study().to_string();
    if scenes.is_empty() {
        screen.warn(format!(
            "{name} has no condition that a model can be made of (a lever length, a spring without a delay, \
             an actuator and the work space): nothing to trade"
        ));
    }
    requested.scenes.extend(scenes.into_iter().map(|traded| Source {
        stem: traded.scene.name.clone(),
        title: traded.scene.name.clone(),
        scene: traded.scene.clone(),
        traded: Some(traded),
        perception: perception.clone(),
        folder: folder.clone(),
    }));
    requested.studies.push(Study { data, folder, name });
    Ok(())
}
