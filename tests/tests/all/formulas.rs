//! Studies whose recordings are made by formula, so that anybody can make them again, and imported.

use crate::binary::{Ran, zwidth, zwidth_line};
use serde_json::Value;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const MAP: &str = r#"
kind = "trials"
simulated = true
[name]
pattern = '(?<who>P\d+)_(?<mode>[a-z0-9]+)_(?<repeat>\d+)\.csv$'
[trial]
participant = { name = "who" }
session = "S01"
environment = "task"
mode = { name = "mode" }
repeat = { name = "repeat" }
[time]
from = "t_s"
unit = "s"
[[column]]
to = "theta_rad"
from = "angle_deg"
unit = "deg"
[[column]]
to = "theta_dot_rad_s"
derive = "derivative of theta_rad"
"#;

/// A number between −½ and ½: (h³ mod 9941)/9941 − ½.
pub(crate) fn u(of: &[u64]) -> f64 {
    let weights = [131, 173, 197, 211];
    let h = 1 + of.iter().zip(weights).map(|(value, weight)| value * weight).sum::<u64>();
    (h * h * h % 9941) as f64 / 9941.0 - 0.5
}

/// A recording of a second: the lever goes `largest_deg` far and comes back, with a force over time.
pub(crate) fn record(
    root: &Path,
    [who, mode, repeat]: [&str; 3],
    largest_deg: f64,
    force: impl Fn(f64) -> f64,
) {
    let mut rows = "t_s,angle_deg,force_n\n".to_owned();
    for sample in 0..=50 {
        let t = f64::from(sample) / 50.0;
        let angle = largest_deg * (PI * t).sin().powi(2);
        writeln!(rows, "{t:.2},{angle:.6},{:.9}", force(t)).unwrap();
    }
    let folder = root.join("recordings");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join(format!("{who}_{mode}_{repeat}.csv")), rows).unwrap();
}

/// Imports all recordings into the study of that id, which is this; the force is what `to` says.
pub(crate) fn import(root: &Path, id: &str, study: &str, to: &str) {
    import_by(root, id, study, &format!("{MAP}{to}\nfrom = \"force_n\"\nunit = \"N\"\n"));
}

/// The same of recordings in one mode, whose files name the environment in its place.
pub(crate) fn import_of_environments(root: &Path, id: &str, study: &str, mode: &str) {
    let map = MAP
        .replace("environment = \"task\"", "environment = { name = \"mode\" }")
        .replace("mode = { name = \"mode\" }\nrepeat", &format!("mode = \"{mode}\"\nrepeat"));
    let force = "[[column]]\nto = \"force_ex_n\"\nfrom = \"force_n\"\nunit = \"N\"\n";
    import_by(root, id, study, &(map + force));
}

fn import_by(root: &Path, id: &str, study: &str, map_text: &str) {
    let raw = root.join("raw").join(id);
    fs::create_dir_all(&raw).unwrap();
    fs::write(raw.join("study.toml"), study).unwrap();
    let map = root.join("map.toml");
    fs::write(&map, map_text).unwrap();
    let files = fs::read_dir(root.join("recordings")).unwrap();
    let files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    let files = files.iter().map(|path| path.to_str().unwrap());
    let given = ["import", id, "--map", map.to_str().unwrap()];
    let ran = zwidth(root, &given.into_iter().chain(files).collect::<Vec<_>>());
    assert!(matches!(ran.code, Some(0 | 3)), "{}", ran.err);
}

/// Forces that stand still all along are told, so that the program ends with a warning.
pub(crate) fn ran(root: &Path, line: &str) -> Ran {
    let ran = zwidth_line(root, line);
    assert!(matches!(ran.code, Some(0 | 3)), "{line}: {}", ran.err);
    ran
}

/// A number of a table of `compare --json`.
#[track_caller]
pub(crate) fn near(row: &Value, column: &str, expected: f64) {
    let found = row[column].as_f64().unwrap_or_else(|| panic!("{column}: {row}"));
    assert!((found - expected).abs() <= 1e-6 * expected.abs(), "{column}: {found} {expected}");
}
