//! `zwidth why`: what a result was last made from, and whether and why a run would make it again.

use super::locate::{FoundBy, Place, copies, is_a_copy, is_raw, no_job, place, records};
use super::{join_findings, study};
use crate::commands::locate::Traced;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{anyhow, bail};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use zwidth_plan as plan;
use zwidth_runner::{Again, Change, Record, states};
use zwidth_store::{Layout, RealFiles, StudyData, findings};

/// What `--json` prints of a file.
#[derive(Serialize)]
struct Why {
    path: String,
    found_by: FoundBy,
    study: String,
    job: String,
    stage: &'static str,
    again: Again,
    reasons: Vec<Change>,
    last_made: Option<Last>,
    /// Jobs further back that would be made again first.
    first: Vec<Behind>,
}

/// How a job was last made. There is no time in the records, so that they are the same on every
/// machine: the date is the file's own.
#[derive(Serialize)]
struct Last {
    dated: Option<String>,
    #[serde(flatten)]
    record: Record,
}

/// A job that would be made again before the file's own.
#[derive(Serialize)]
struct Behind {
    job: String,
    stage: &'static str,
    again: Again,
    reasons: Vec<Change>,
}

/// The file that the command names: its study, its path relative to the root, and for a copy its
/// job.
struct Target {
    layout: Layout,
    path: String,
    job: Option<String>,
    by: FoundBy,
}

pub(crate) fn why(root: &Path, command: &Traced, screen: &Screen) -> anyhow::Result<Exit> {
    let targets = find_targets(root, &command.path, screen)?;
    let whys = targets.iter().map(|target| one(root, target, screen));
    let whys = whys.collect::<anyhow::Result<Vec<_>>>()?;
    screen.give(&whys, || whys.iter().for_each(|why| screen.result(text(why))))?;
    Ok(Exit::Fine)
}

fn find_targets(root: &Path, typed: &Path, screen: &Screen) -> anyhow::Result<Vec<Target>> {
    match place(root, typed) {
        Place::Raw(path) => bail!(is_raw(&path)),
        Place::Results(id, path) if path.starts_with("reports/simulate/") => {
            bail!(no_job(&path, &id, &[]))
        }
        Place::Results(_, path) if is_a_copy(root, &path) => {
            copy_targets(root, &root.join(path), screen)
        }
        Place::Results(id, path) => {
            Ok(vec![Target { layout: study(root, id)?, path, job: None, by: FoundBy::Path }])
        }
        Place::Outside => copy_targets(root, typed, screen),
    }
}

/// The jobs behind a copy.
fn copy_targets(root: &Path, typed: &Path, screen: &Screen) -> anyhow::Result<Vec<Target>> {
    let makers = copies(root, typed, screen)?.into_iter();
    Ok(makers
        .map(|m| Target { layout: m.layout, path: m.path, job: Some(m.job), by: m.by })
        .collect())
}

fn one(root: &Path, target: &Target, screen: &Screen) -> anyhow::Result<Why> {
    let layout = &target.layout;
    let data = StudyData::load(layout).map_err(|findings| join_findings(&findings))?;
    let mut jobs = plan::jobs(&data, &findings(&RealFiles, &data));
    let file = root.join(&target.path);
    if !jobs.iter().any(|job| job.outputs.contains(&file)) {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        jobs.extend(plan::on_demand(&data, &stem));
    }
    let job = jobs.iter().find(|job| {
        target.job.as_ref().is_some_and(|name| job.name == *name) || job.outputs.contains(&file)
    });
    let job = job.ok_or_else(|| {
        let outputs = jobs.iter().flat_map(|j| &j.outputs);
        let outputs = outputs.map(|o| layout.shown(o).to_string_lossy().into_owned());
        anyhow!(no_job(&target.path, layout.study(), &outputs.collect::<Vec<_>>()))
    })?;
    let records = records(layout, screen)?;
    let mut states = states(&jobs, layout.root(), &records, |j| j.name == job.name);
    let at = states.iter().position(|s| s.job.name == job.name);
    let at = at.ok_or_else(|| anyhow!("{}: {DEFECT}", target.path))?;
    let own = states.remove(at);
    let record = records.get(&job.name).map(Arc::unwrap_or_clone);
    let first = states.into_iter().filter(|state| state.again() != Again::No);
    let first = first.map(|state| Behind {
        job: state.job.name.clone(),
        stage: state.job.stage.name,
        again: state.again(),
        reasons: state.changes,
    });
    Ok(Why {
        path: target.path.clone(),
        found_by: target.by,
        study: layout.study().to_string(),
        job: job.name.clone(),
        stage: job.stage.name,
        again: own.again(),
        reasons: own.changes,
        last_made: record.map(|record| Last { dated: dated(&file), record }),
        first: first.collect(),
    })
}

/// The file's date, in UTC.
fn dated(file: &Path) -> Option<String> {
    let time = std::fs::metadata(file).and_then(|m| m.modified()).ok()?;
    let time = jiff::Timestamp::try_from(time).ok()?;
    Some(time.strftime("%Y-%m-%dT%H:%M:%SZ").to_string())
}

fn text(why: &Why) -> String {
    let mut lines = vec![
        why.path.clone(),
        format!("  made by     {} ({} of {})", why.job, why.stage, why.study),
    ];
    match &why.last_made {
        Some(last) => lines.extend(last_made(last)),
        None => lines.push("  last made   there is no record: never, or it failed".to_owned()),
    }
    lines.push(match why.again {
        Again::No => "Up to date: nothing that it depends on has changed.".to_owned(),
        Again::Yes => "A run would make it again:".to_owned(),
        Again::IfInputsDiffer => {
            "A run would make it again if these come out with another content:".to_owned()
        }
    });
    lines.extend(why.reasons.iter().map(|change| format!("  {}", describe_change(change))));
    if !why.first.is_empty() {
        lines.push("Made again before it:".to_owned());
    }
    for behind in &why.first {
        let perhaps = if behind.again == Again::IfInputsDiffer { ", perhaps" } else { "" };
        lines.push(format!("  {} ({}{perhaps})", behind.job, behind.stage));
        lines
            .extend(behind.reasons.iter().map(|change| format!("    {}", describe_change(change))));
    }
    lines.join("\n")
}

fn last_made(last: &Last) -> Vec<String> {
    let Record { version, parameters, inputs, origin, problems, .. } = &last.record;
    let dated = last
        .dated
        .as_ref()
        .map_or("the file is missing".to_owned(), |d| format!("{d}, by the file's date"));
    let parameters = if parameters.is_empty() { "none" } else { parameters };
    let mut lines = vec![
        format!("  last made   {dated}"),
        format!("  version     {version}"),
        format!("  origin      {origin}"),
        format!("  parameters  {parameters}"),
        format!("  inputs      {}", if inputs.is_empty() { "none" } else { "" })
            .trim_end()
            .to_owned(),
    ];
    lines.extend(inputs.iter().map(|(path, hash)| format!("    {}  {path}", short(Some(hash)))));
    lines.extend(problems.iter().map(|problem| format!("  left out    {problem}")));
    lines
}

/// A change with what it was and what it is.
fn describe_change(change: &Change) -> String {
    match change {
        Change::Input(file) | Change::Output(file) => {
            let [recorded, now] = [file.recorded.as_ref(), file.now.as_ref()].map(short);
            match (&file.recorded, &file.now) {
                (Some(_), Some(_)) => format!("{change} (recorded {recorded}, now {now})"),
                (Some(_), None) => format!("{change} (recorded {recorded})"),
                (None, Some(_)) => format!("{change} (now {now})"),
                (None, None) => change.to_string(),
            }
        }
        Change::Parameters { fields } => {
            let mut differences: Vec<String> =
                fields.iter().take(FIELDS).map(ToString::to_string).collect();
            if fields.len() > FIELDS {
                differences.push(format!("and {} more", fields.len() - FIELDS));
            }
            format!("{change}: {}", differences.join("; "))
        }
        _ => change.to_string(),
    }
}

/// What only a mistake in the program can lead to.
const DEFECT: &str = "it cannot be told whether a run would make this again; this is a defect of zwidth, please report it";

/// Hexadecimal digits of a hash that people are shown: 48 bits, as many as tell a million files
/// apart.
const DIGITS: usize = 12;

/// A hash as people are shown it.
pub(super) fn short(hash: Option<&String>) -> &str {
    hash.map_or("nothing", |hash| hash.get(..DIGITS).unwrap_or("missing"))
}

/// The most parameters that differ which are listed one by one.
const FIELDS: usize = 5;

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_runner::Field;

    #[test]
    fn a_file_of_any_date_has_one_or_none() {
        use std::time::{Duration, SystemTime};
        let file = tempfile::NamedTempFile::new().unwrap();
        // Up to the year 9999, past it, and past all that systems count.
        for seconds in [0, 253_402_300_799, 253_402_300_800, 1 << 40, i64::MAX.unsigned_abs()] {
            let Some(time) = SystemTime::UNIX_EPOCH.checked_add(Duration::from_secs(seconds))
            else {
                continue;
            };
            // A disk may refuse a date, or keep the nearest that it can.
            let _ = file.as_file().set_modified(time);
            assert!(dated(file.path()).is_none_or(|text| text.ends_with('Z')), "{seconds}");
        }
        assert_eq!(dated(Path::new("no such file")), None);
    }

    #[test]
    fn parameters_are_told_by_field_and_many_are_counted() {
        let field = |i: usize| Field { name: format!("f{i}"), recorded: Some(0.into()), now: None };
        let told =
            |n: usize| describe_change(&Change::Parameters { fields: (0..n).map(field).collect() });
        assert_eq!(told(1), "parameter f0 changed: f0: 0 is now nothing");
        assert!(told(7).ends_with("f4: 0 is now nothing; and 2 more"), "{}", told(7));
    }

    #[test]
    fn a_hash_is_shown_short_and_none_is_told() {
        assert_eq!(short(Some(&"0123456789abcdef".to_owned())), "0123456789ab");
        assert_eq!((short(None), short(Some(&String::new()))), ("nothing", "missing"));
    }
}
