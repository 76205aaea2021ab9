//! `zwidth simulate --as`: files where they were asked for, what they cannot say, and nothing over a
//! scene.

use crate::binary::zwidth;
use crate::folders::workspace;
use std::fs;

#[test]
fn a_scene_is_written_with_what_its_format_cannot_say_and_never_over_a_scene() {
    let root = tempfile::tempdir().unwrap();
    for name in ["sine.toml", "step.toml", "sine_finger.toml"] {
        fs::copy(workspace().join("scenes").join(name), root.path().join(name)).unwrap();
    }
    let path = |name: &str| root.path().join(name).to_str().unwrap().to_owned();
    let [sine, step, finger, model] =
        ["sine.toml", "step.toml", "sine_finger.toml", "lever.xml"].map(path);
    let written = |arguments: &[&str]| zwidth(root.path(), &[&["simulate"], arguments].concat());
    let ran = written(&[&sine, "--as", "mujoco", "--out", &model]).exits(0);
    ran.prints(&["lever.xml", "lever.py", "MJCF holds no signal of time"]);
    let text = fs::read_to_string(&model).unwrap();
    assert!(text.contains("timestep=\"0.0083\""), "{text}");
    assert!(fs::read_to_string(path("lever.py")).unwrap().contains("import mujoco"));

    let ran = written(&[&sine, &finger, "--as", "sdf", "--step", "0.001"]).exits(3);
    ran.says(&["sine_finger.toml", "set finger.law to \"consistent\""]);
    let text = fs::read_to_string(root.path().join("reports/simulate/sine.sdf")).unwrap();
    assert!(text.contains("<max_step_size>0.001</max_step_size>"), "{text}");

    let two = written(&[&sine, &step, "--as", "urdf", "--out", &model]).exits(1);
    two.says(&["--out names one file"]);
    let before = fs::read(&sine).unwrap();
    written(&[&sine, "--as", "urdf", "--out", &sine]).exits(1).says(&["would be written over"]);
    assert_eq!(fs::read(&sine).unwrap(), before);
}
