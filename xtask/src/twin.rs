//! `raw/thesis-twin`: the study that comes with the clone, made by the program itself from a seed.

use crate::shell::{program, remove};
use anyhow::{Context as _, ensure};
use std::path::Path;
use std::process::Command;

/// One participant, one session, at the thesis' 120 Hz.
const LINE: &str = "twin thesis-twin --participants 1 --sessions 1 --seed 1 --rate 120";

/// The scenes that its figures of the model are drawn from: copies of those in `scenes/`, so that
/// the study holds all that its results rest on.
const SCENES: &str = "figure_11 ramp ramp_finger sine sine_finger step step_finger two_actuators";

/// What stands at the end of its study.toml.
const FIGURES: &str = r#"
# The thesis' figures of its model, from the scenes beside this file. Fig. 11 by the thesis' own method and step, and solved
# exactly; a step of 1 ms draws the finger's 27 Hz smoothly.
[[scenes]]
id = "figure_8"
files = ["scenes/step.toml", "scenes/ramp.toml", "scenes/sine.toml"]
draw = "inputs"

[[scenes]]
id = "figure_11"
files = ["scenes/figure_11.toml"]
solver = "rk4_per_step"

[[scenes]]
id = "figure_11_exact"
files = ["scenes/figure_11.toml"]
step_s = 0.001

[[scenes]]
id = "figure_12"
files = ["scenes/step_finger.toml"]
step_s = 0.001

[[scenes]]
id = "figure_31"
files = ["scenes/two_actuators.toml"]
draw = "bow_tie"

[[scenes]]
id = "figure_33"
files = ["scenes/step_finger.toml", "scenes/step.toml"]
step_s = 0.001

[[scenes]]
id = "figure_34"
files = ["scenes/ramp_finger.toml", "scenes/ramp.toml"]
step_s = 0.001

[[scenes]]
id = "figure_35"
files = ["scenes/sine_finger.toml", "scenes/sine.toml"]
step_s = 0.001
"#;

/// Writes `raw/thesis-twin` under `root`, replacing what stands there.
pub(crate) fn write(root: &Path) -> anyhow::Result<()> {
    let program = program()?;
    let folder = root.join("raw/thesis-twin");
    remove(&folder).context("cannot remove the old raw/thesis-twin")?;
    let status = Command::new(program).arg("--root").arg(root).args(LINE.split(' ')).status()?;
    ensure!(status.success(), "the study could not be made");
    std::fs::create_dir(folder.join("scenes"))?;
    for scene in SCENES.split(' ') {
        let file = format!("{scene}.toml");
        std::fs::copy(Path::new("scenes").join(&file), folder.join("scenes").join(file))?;
    }
    let study = folder.join("study.toml");
    let text = std::fs::read_to_string(&study)? + FIGURES;
    Ok(std::fs::write(&study, text)?)
}
