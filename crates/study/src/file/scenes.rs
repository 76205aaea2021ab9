//! `[[scenes]]` of a `study.toml`.

use super::check::Check;
use crate::SceneFigure;
use std::path::{Component, Path};

/// No step of a run is longer, s.
const LONGEST_STEP_S: f64 = 10.0;

impl Check<'_> {
    pub(super) fn scenes(&mut self, scenes: Vec<SceneFigure>) -> Vec<SceneFigure> {
        self.unique("scenes", scenes.iter().map(|figure| figure.id.as_str()));
        for (i, figure) in scenes.iter().enumerate() {
            let files_key = format!("scenes[{i}].files");
            let n = figure.files.len();
            let most = figure.draw.most();
            if !(1..=most).contains(&n) {
                self.error(&files_key, format!("has {n} files; such a figure takes 1 to {most}"));
            }
            for file in figure.files.iter().filter(|file| !is_below(file, &["toml"])) {
                let problem = format!(
                    "'{file}' is not a scene file in the study's folder; write a path such as \"scenes/sine.toml\""
                );
                self.error(&files_key, problem);
            }
            let solver = figure.solver.as_deref().unwrap_or_default();
            self.line(&format!("scenes[{i}].solver"), solver);
            if let Some(step_s) = figure.step_s {
                self.within(&format!("scenes[{i}].step_s"), step_s, LONGEST_STEP_S);
            }
        }
        scenes
    }
}

/// Whether a path stays below the folder it is read from, on any machine, and ends in one of these
/// extensions.
pub(super) fn is_below(file: &str, extensions: &[&str]) -> bool {
    let path = Path::new(file);
    file.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c))
        && path.components().all(|part| matches!(part, Component::Normal(_)))
        && path.extension().is_some_and(|e| extensions.iter().any(|extension| e == *extension))
        && path.file_stem().is_some()
}

#[cfg(test)]
mod tests {
    use crate::tests::with;
    use crate::{SceneDrawing, Study};

    #[test]
    fn a_figure_of_scenes_has_files_and_may_have_solver_and_step() {
        let text = "id = \"figure_8\"\nfiles = [\"scenes/a.toml\", \"b-2.toml\"]\ndraw = \"inputs\"\n\
                    solver = \"rk4\"\nstep_s = 0.001";
        let study = with("[[scenes]]", text).unwrap();
        let [figure] = study.scenes.as_slice() else { panic!("{:?}", study.scenes) };
        assert_eq!((figure.id.as_str(), figure.draw), ("figure_8", SceneDrawing::Inputs));
        assert_eq!((figure.solver.as_deref(), figure.step_s), (Some("rk4"), Some(0.001)));
        let again = Study::from_toml(&study.to_toml().unwrap()).unwrap();
        assert_eq!(again.scenes, study.scenes);
        let plain = with("[[scenes]]", "id = \"a\"\nfiles = [\"a.toml\"]").unwrap();
        assert_eq!(plain.scenes[0].draw, SceneDrawing::Runs);
    }

    #[test]
    fn what_cannot_be_drawn_is_told_with_its_line() {
        for (text, key, words) in [
            (
                "id = \"a\"\nfiles = []",
                "scenes[0].files",
                "has 0 files; such a figure takes 1 to 3",
            ),
            (
                "id = \"a\"\nfiles = [\"a.toml\", \"b.toml\"]\ndraw = \"bow_tie\"",
                "scenes[0].files",
                "takes 1 to 1",
            ),
            (
                "id = \"a\"\nfiles = [\"../a.toml\"]",
                "scenes[0].files",
                "'../a.toml' is not a scene file",
            ),
            ("id = \"a\"\nfiles = [\"/a.toml\"]", "scenes[0].files", "not a scene file"),
            ("id = \"a\"\nfiles = [\"c:\\\\a.toml\"]", "scenes[0].files", "not a scene file"),
            ("id = \"a\"\nfiles = [\"a.json\"]", "scenes[0].files", "not a scene file"),
            (
                "id = \"a\"\nfiles = [\"a.toml\"]\nstep_s = 0",
                "scenes[0].step_s",
                "must be a number above 0",
            ),
            (
                "id = \"a\"\nfiles = [\"a.toml\"]\n[[scenes]]\nid = \"A\"\nfiles = [\"b.toml\"]",
                "scenes[1].id",
                "stands twice",
            ),
        ] {
            let errors = with("[[scenes]]", text).unwrap_err();
            assert_eq!(errors[0].key, key, "{errors:?}");
            assert!(errors[0].problem.contains(words) && errors[0].line > 0, "{errors:?}");
        }
    }
}
