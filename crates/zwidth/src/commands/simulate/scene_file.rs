//! A scene from its file, and errors that name the file and the line.

use anyhow::anyhow;
use std::path::{Path, PathBuf};
use zwidth_simulate::{DynamicsError, ModelScene, SimulateError};

/// A scene with the text it came from.
pub(in super::super) struct SceneFile {
    path: PathBuf,
    text: String,
    pub(in super::super) scene: ModelScene,
}

impl SceneFile {
    pub(in super::super) fn read(path: &Path) -> anyhow::Result<Self> {
        let text = crate::text::scene(path)?;
        let scene = ModelScene::from_toml(&text).map_err(|e| anyhow!("{}: {e}", path.display()))?;
        Ok(Self { path: path.to_owned(), text, scene })
    }

    /// The error with file and, where it names a parameter of the file, line.
    pub(in super::super) fn error(&self, error: &SimulateError) -> anyhow::Error {
        let line = match error {
            SimulateError::Dynamics(DynamicsError::Parameter { name, .. }) => {
                line_of(&self.text, name)
            }
            _ => None,
        };
        let line = line.map_or(String::new(), |line| format!(":{line}"));
        anyhow!("{}{line}: {error}", self.path.display())
    }
}

/// What the files of a scene are named by.
pub(in super::super) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// The line, from 1, where `plant.mass_kg` or `environment.zones[1].from_rad` stands; none where
/// its key is not alone at the head of a line in its section.
fn line_of(text: &str, name: &str) -> Option<usize> {
    let (section, key) = name.rsplit_once('.').unwrap_or(("", name));
    let (section, _) = section.split_once('[').unwrap_or((section, ""));
    let mut here = "";
    let mut lines = Vec::new();
    for (i, line) in text.lines().map(str::trim).enumerate() {
        if let Some(header) = line.strip_prefix('[') {
            here = header.trim_start_matches('[').split(']').next().unwrap_or_default();
        }
        let is_key = line.split_once('=').is_some_and(|(left, _)| left.trim() == key);
        if is_key
            && (here == section || !section.is_empty() && here.starts_with(&format!("{section}.")))
        {
            lines.push(i + 1);
        }
    }
    // Of several zones of an array each has the key: no line is better than a wrong one.
    if let [line] = lines[..] { Some(line) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "step_s = 1\n[plant]\nmass_kg = 1 # M_O\n[finger]\nmass_kg = 2\n[[environment.zones]]\n\
                        [environment.zones.demand.spring]\nrest_rad = 3\n[[environment.zones]]\nfrom_rad = 4\n";

    #[test]
    fn a_parameter_is_found_in_its_own_section() {
        for (name, line) in [
            ("step_s", Some(1)),
            ("plant.mass_kg", Some(3)),
            ("finger.mass_kg", Some(5)),
            ("environment.zones[0].rest_rad", Some(8)),
            ("environment.zones[1].from_rad", Some(10)),
            ("plant.lever_m", None),
        ] {
            assert_eq!(line_of(TEXT, name), line, "{name}");
        }
    }

    #[test]
    fn a_parameter_that_could_stand_on_two_lines_is_on_none() {
        let twice = format!("{TEXT}[environment.zones.demand.spring]\nrest_rad = 5\n");
        assert_eq!(line_of(&twice, "environment.zones[1].rest_rad"), None);
    }
}
