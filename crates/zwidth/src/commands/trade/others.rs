//! Trajectories of other programs, from a table of them, beside our solvers.

use super::super::judge::words::degrees;
use super::super::judge::{faults_table, file_name, table, trajectory};
use super::super::output::Output;
use super::source::Source;
use crate::text;
use anyhow::{Context as _, anyhow, bail};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use zwidth_import::{Mapping, texts};
use zwidth_judge::{Allowed, Judged, Yardstick, judge};
use zwidth_results::{RunTime, TradeSetting};

/// The columns of a table of trajectories.
const COLUMNS: [&str; 5] = ["name", "setting", "file", "cost_s", "map"];

/// A trajectory of another program, and what is said of it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Other {
    /// The program.
    name: String,
    /// Its setting.
    #[serde(default)]
    setting: String,
    /// Its file, from the table's folder on.
    file: PathBuf,
    /// Time that it took, s.
    cost_s: Option<f64>,
    /// A mapping for the file, from the table's folder on.
    map: Option<PathBuf>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Listed {
    trajectories: Vec<Other>,
}

/// A table of trajectories: TOML with `[[trajectories]]`, or any table with these columns.
pub(super) fn listed(path: &Path) -> anyhow::Result<Vec<Other>> {
    let is_toml = path.extension().is_some_and(|extension| extension == "toml");
    let all = match is_toml {
        true => {
            let listed: Listed =
                toml::from_str(&text::scene(path)?).with_context(|| path.display().to_string())?;
            listed.trajectories
        }
        false => {
            let rows = texts(path, COLUMNS)?.into_iter().enumerate();
            rows.map(|(row, cells)| of_row(path, row, cells)).collect::<anyhow::Result<_>>()?
        }
    };
    if all.is_empty() {
        bail!(
            "{}: it lists no trajectory; give it the columns {}",
            path.display(),
            COLUMNS.join(", ")
        );
    }
    Ok(all)
}

fn of_row(
    path: &Path,
    row: usize,
    [name, setting, file, cost_s, map]: [String; 5],
) -> anyhow::Result<Other> {
    let place = || format!("{}, row {}", path.display(), row + 1);
    if name.is_empty() || file.is_empty() {
        bail!("{}: it has no name or no file; fill in the columns name and file", place());
    }
    let cost_s = match cost_s.as_str() {
        "" => None,
        number => Some(number.parse().map_err(|_| {
            anyhow!("{}: cost_s is '{number}', and no number; give it in seconds", place())
        })?),
    };
    let map = (!map.is_empty()).then(|| PathBuf::from(map));
    Ok(Other { name, setting, file: file.into(), cost_s, map })
}

/// Judges the trajectories of a table for a scene; the errors of those that cannot be judged.
pub(super) fn judged(source: &Source, path: &Path) -> anyhow::Result<(Vec<Judged>, Vec<String>)> {
    let yardstick = Yardstick::of(&source.scene, &source.perception)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let one = |other: &Other| -> anyhow::Result<Judged> {
        let mapping = other.map.as_ref().map(|map| Mapping::read(&folder.join(map)));
        let mapping = mapping.transpose().map_err(|findings| super::super::sum_up(&findings))?;
        let file = folder.join(&other.file);
        let read = trajectory::read(&file, mapping.as_ref(), source.scene.plant.lever_m)?;
        let judged = judge(&yardstick, &read.candidate, &Allowed::default(), &source.perception)
            .map_err(|e| anyhow!("{}: {e}", file.display()))?;
        let setting = Some(other.setting.as_str());
        Ok(judged.named(&file_name(&file), Some(&other.name), setting, other.cost_s))
    };
    let mut all = Vec::new();
    let mut errors = Vec::new();
    for other in listed(path)? {
        match one(&other) {
            Ok(judged) => all.push(judged),
            Err(error) => errors.push(format!("{error:#}")),
        }
    }
    if all.is_empty() {
        bail!("{}", errors.join("\n       "));
    }
    Ok((all, errors))
}

/// Writes tables and figure of judged trajectories; a line for each.
pub(super) fn write(
    source: &Source,
    judged: &[Judged],
    settings: &[TradeSetting],
    times: &[RunTime],
    output: &mut Output,
) -> anyhow::Result<Vec<String>> {
    let rows: Vec<_> = judged.iter().map(|judged| judged.trajectory.clone()).collect();
    let faults: Vec<_> = judged.iter().flat_map(|judged| judged.faults.clone()).collect();
    output.table(&format!("{}.others", source.stem), &table(&rows)?)?;
    output.table(&format!("{}.others.faults", source.stem), &faults_table(&faults)?)?;
    let title = format!("{}: other programs beside our solvers", source.title);
    let figure = zwidth_figures::others(&title, settings, times, &rows);
    output.figure(&format!("{}.others", source.stem), figure)?;
    let lines = rows.iter().map(|row| {
        let engine = row.engine.as_deref().unwrap_or_default();
        let setting = row.setting.as_deref().filter(|setting| !setting.is_empty());
        let setting = setting.map_or(String::new(), |setting| format!(", {setting}"));
        format!(
            "{engine}{setting}: {}, θ off by at most {}.",
            row.verdict.as_str(),
            degrees(row.theta_error_max_rad)
        )
    });
    Ok(lines.collect())
}
