//! Stage `summary`: the page a person reads first.

use super::average;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_report::{LeftOut, Made as Listed, Summary, summary_markdown};
use zwidth_runner::{Job, Made};
use zwidth_store::{StudyData, TrialEntry, left_out, read_sweep};
use zwidth_study::Scene;
use zwidth_tables::{Table, TableError};

/// Version of the summary's form.
const VERSION: u32 = 1;

/// The summary's file.
pub(crate) fn file(data: &StudyData) -> PathBuf {
    data.layout.reports().join("summary.md")
}

pub(super) fn job<'a>(data: &'a StudyData, planned: &[Job]) -> Job<'a> {
    let outputs = |stage: &str, extension: &str| -> Vec<PathBuf> {
        let of_stage = planned.iter().filter(|j| j.stage == stage).flat_map(|j| &j.outputs);
        of_stage.filter(|o| o.extension().is_some_and(|e| e == extension)).cloned().collect()
    };
    let figures = listed(&outputs("figures", "png"), &data.layout.reports(), figure_caption);
    let printed = outputs("tables", "parquet");
    let mut noted = average::all(data);
    noted.extend(planned.iter().filter(|j| j.stage == "freemotion").flat_map(|j| j.outputs.iter().cloned()));
    let sweeps: Vec<PathBuf> = data.sweeps.iter().map(|s| s.path.clone()).collect();
    let summary = Summary { figures, ..facts(data) };
    let inputs: Vec<PathBuf> = noted.iter().chain(&printed).chain(&sweeps).cloned().collect();
    let out = file(data);
    Job {
        stage: "summary",
        name: "summary".to_owned(),
        version: VERSION,
        parameters: format!("{summary:?}"),
        inputs,
        outputs: vec![out.clone()],
        make: Box::new(move |_| {
            let mut summary = summary.clone();
            summary.limits.extend(notes(&noted)?);
            for sweep in sweeps.iter().filter_map(|path| read_sweep(path).ok()) {
                *summary.sources.entry(sweep.source).or_default() += 1;
            }
            summary.tables = tables(&printed, out.parent().unwrap_or(Path::new("")))?;
            Ok(Made { outputs: vec![summary_markdown(&summary).into_bytes()], problems: Vec::new() })
        }),
    }
}

fn facts(data: &StudyData) -> Summary {
    let counting: Vec<_> = data.counting().collect();
    let asked = data.answers();
    let with_samples =
        counting.iter().map(|t| (t.meta.participant.clone(), t.meta.session.clone(), t.meta.trial));
    let with_answers = asked.iter().map(|a| (a.participant.clone(), a.session.clone(), a.trial));
    let trials: BTreeSet<_> = with_samples.chain(with_answers).collect();
    let sessions: BTreeSet<_> = trials.iter().map(|(p, s, _)| (p, s)).collect();
    let people: BTreeSet<_> = trials.iter().map(|(p, _, _)| p).collect();
    let mut sources = BTreeMap::new();
    for log in &data.sessions {
        *sources.entry(log.record.source).or_default() += log.record.trials.len();
    }
    let moves = |c: &TrialEntry| {
        data.study.environment(&c.meta.environment).is_some_and(|e| !matches!(e.scene, Scene::None))
    };
    let no_lever = data.study.device.lever_m.is_none() && counting.iter().any(|t| moves(t));
    let limit =
        "No lever length is known (device.lever_m), so torque stays torque: N·m on axes and in tables.";
    Summary {
        title: data.study.title.clone(),
        device: data.study.device.name.clone(),
        participants: people.len(),
        sessions: sessions.len(),
        trials: trials.len(),
        sweeps: data.sweeps.len(),
        sources,
        left_out: left_out(data).into_iter().map(split).collect(),
        limits: no_lever.then(|| limit.to_owned()).into_iter().collect(),
        ..Summary::default()
    }
}

fn split(line: String) -> LeftOut {
    let (what, why) = line.split_once(": ").unwrap_or((&line, ""));
    LeftOut { what: what.to_owned(), why: why.to_owned() }
}

/// What averages and plane fits say against themselves, each note once. Where an average ends is no
/// limit of the study.
fn notes(tables: &[PathBuf]) -> Result<Vec<String>, TableError> {
    let mut notes = BTreeSet::new();
    for path in tables {
        let table = Table::from_parquet(path)?;
        notes.extend(table.notes().iter().filter(|n| !n.contains(zwidth_average::ENDS_AT)).cloned());
    }
    Ok(notes.into_iter().collect())
}

fn tables(printed: &[PathBuf], folder: &Path) -> Result<Vec<Listed>, TableError> {
    let titles: BTreeMap<PathBuf, String> = printed
        .iter()
        .map(|p| Ok((p.clone(), Table::from_parquet(p)?.title().to_owned())))
        .collect::<Result<_, TableError>>()?;
    let shown = |p: &PathBuf| p.with_extension("md");
    Ok(printed
        .iter()
        .map(|p| Listed { path: relative(&shown(p), folder), caption: titles[p].clone() })
        .collect())
}

fn listed(files: &[PathBuf], folder: &Path, caption: fn(&str) -> String) -> Vec<Listed> {
    let stem = |p: &PathBuf| p.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    files.iter().map(|p| Listed { path: relative(p, folder), caption: caption(&stem(p)) }).collect()
}

fn relative(path: &Path, folder: &Path) -> String {
    path.strip_prefix(folder).unwrap_or(path).to_string_lossy().replace('\\', "/")
}

/// What a figure shows, from its name: `modes.P01.S01.spring`.
fn figure_caption(stem: &str) -> String {
    let mut words = stem.split('.');
    let kind = words.next().unwrap_or_default();
    let of = words.collect::<Vec<_>>().join(" ");
    let what = match kind {
        "modes" => "position, force and velocity against time, force against position",
        "repeats" => "every repeat of one condition",
        "loops" => "force against position, all environments",
        "characteristic" => "response to the command, with the chosen fit",
        "likert" => "answers, diverging bars with counts",
        "likert_items" => "answers to each question",
        "free_motion" => "plane fits of free motion, sessions and modes side by side",
        other => other,
    };
    if of.is_empty() { what.to_owned() } else { format!("{what} ({of})") }
}
