//! The scenes of a trade: from files, or a study's conditions.

use super::super::simulate::scene_file::SceneFile;
use super::super::simulate::{check_stems, stem};
use super::super::{join_findings, studies};
use crate::args::Trade as Command;
use crate::screen::Screen;
use anyhow::bail;
use std::path::{Path, PathBuf};
use zwidth_store::StudyData;
use zwidth_study::Perception;
use zwidth_trade::{ModelScene, Parameters, VERSION, models};

/// A scene, what a person can feel of it, and where its results go.
pub(super) struct Source {
    pub(super) stem: String,
    pub(super) title: String,
    pub(super) scene: ModelScene,
    pub(super) perception: Perception,
    pub(super) folder: PathBuf,
}

impl Source {
    /// How many settings are run.
    pub(super) fn settings(&self) -> usize {
        let of = |model: &ModelScene| Parameters::full(model, &self.perception).settings(model);
        models(&self.scene).iter().map(of).sum()
    }

    /// All that its files depend on, as text.
    pub(super) fn key(&self) -> anyhow::Result<String> {
        let parameters = Parameters::full(&self.scene, &self.perception);
        let key = serde_json::json!({
            "version": [VERSION, zwidth_figures::VERSION],
            "software": env!("CARGO_PKG_VERSION"),
            "scene": self.scene.to_toml()?,
            "parameters": parameters,
        });
        Ok(format!("{key:#}\n"))
    }
}

/// The scenes that a command names.
pub(super) fn sources(
    root: &Path,
    command: &Command,
    screen: &Screen,
) -> anyhow::Result<Vec<Source>> {
    if !command.scenes.is_empty() {
        check_stems(&command.scenes)?;
        let folder = command.out.clone().unwrap_or_else(|| root.join("reports").join("trade"));
        return command.scenes.iter().map(|path| of_file(path, &folder)).collect();
    }
    let mut found = Vec::new();
    for layout in studies(root, command.study.clone())? {
        let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
        let folder = command.out.clone().unwrap_or_else(|| layout.reports().join("timing"));
        let scenes = zwidth_plan::trade_scenes(&data);
        if scenes.is_empty() {
            let id = layout.study();
            screen.warn(format!(
                "{id} has no condition that a model can be made of (a lever length, a spring, an actuator and the \
                 work space): nothing to trade"
            ));
        }
        found.extend(scenes.into_iter().map(|scene| Source {
            stem: scene.name.clone(),
            title: scene.name.clone(),
            scene,
            perception: data.study.perception.clone(),
            folder: folder.clone(),
        }));
    }
    if found.is_empty() {
        bail!("there is no scene to trade; name one, for instance scenes/sine.toml");
    }
    Ok(found)
}

fn of_file(path: &Path, folder: &Path) -> anyhow::Result<Source> {
    let file = SceneFile::read(path)?;
    Ok(Source {
        stem: stem(path),
        title: file.scene.name.clone(),
        scene: file.scene,
        perception: Perception::default(),
        folder: folder.to_owned(),
    })
}
