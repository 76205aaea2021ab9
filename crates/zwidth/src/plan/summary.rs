//! Stage `summary`: the page a person reads first.

use super::{average, likert, metrics, name, plain, sessions};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_report::{Made as Listed, Remark, Shown, Summary, findings, summary_markdown};
use zwidth_runner::{Job, Made, ORIGIN};
use zwidth_store::{Findings, Signal, StoreError, StudyData, TrialEntry};
use zwidth_study::{Kind, Scene};
use zwidth_tables::{Format, Table, TableError};

/// Version of the summary's form.
const VERSION: u32 = 4;

/// The summary's file.
pub(crate) fn file(data: &StudyData) -> PathBuf {
    data.layout.reports().join("summary.md")
}

pub(super) fn job<'a>(data: &'a StudyData, found: &Findings, planned: &[Job]) -> Job<'a> {
    let outputs = |stage: &str, extension: &str| -> Vec<PathBuf> {
        let of_stage = planned.iter().filter(|j| j.stage == stage).flat_map(|j| &j.outputs);
        of_stage.filter(|o| o.extension().is_some_and(|e| e == extension)).cloned().collect()
    };
    let figures = outputs("figures", "png");
    let printed = outputs("tables", "parquet");
    let mut noted = average::all(data);
    noted.extend(
        planned.iter().filter(|j| j.stage == "freemotion").flat_map(|j| j.outputs.iter().cloned()),
    );
    let is_made = |file: PathBuf| planned.iter().any(|j| j.outputs.contains(&file)).then_some(file);
    let numbers = [metrics::of_study(&data.layout), likert::tally_of(&data.layout)].map(is_made);
    let summary = facts(data, found);
    let conditions = metrics::of_conditions(planned);
    let read = noted.iter().chain(&conditions).chain(&printed).chain(&figures);
    let inputs: Vec<PathBuf> = read.chain(numbers.iter().flatten()).cloned().collect();
    let (out, folder) = (file(data), data.layout.reports());
    Job {
        stage: "summary",
        name: "summary".to_owned(),
        version: VERSION,
        parameters: format!("{:?}", (&summary, &data.study.environments, &data.study.modes)),
        inputs,
        outputs: vec![out],
        tolerant: true,
        make: Box::new(move |from| {
            let mut summary = summary.clone();
            summary.limits.extend(notes(&noted)?);
            for note in notes(&conditions)? {
                match metrics::told(&note) {
                    Ok(left_out) => summary.left_out.push(left_out),
                    Err(care) => summary.care.push(care),
                }
            }
            let (there, missing): (Vec<_>, Vec<_>) = figures.iter().partition(|f| f.exists());
            summary.figures = there.into_iter().map(|f| figure(f, &folder)).collect();
            let (there, no_tables): (Vec<_>, Vec<_>) = printed.iter().partition(|f| f.exists());
            let tables =
                there.par_iter().map(|f| table(f, &folder)).collect::<Result<Vec<_>, _>>()?;
            summary
                .left_out
                .extend(tables.iter().filter_map(|(listed, rows)| empty(listed, *rows)));
            summary.tables = tables.into_iter().map(|(listed, _)| listed).collect();
            summary.shown = shown(data, &numbers, &summary)?;
            summary
                .left_out
                .extend(missing.into_iter().chain(no_tables).map(|f| could_not_be_made(f)));
            let origin = from.get(ORIGIN).and_then(|origin| Format::Markdown.comment(origin));
            let text = summary_markdown(&summary) + &origin.unwrap_or_default();
            Ok(Made { outputs: vec![text.into_bytes()], ..Made::default() })
        }),
    }
}

/// What the trials show, each sentence with the figure or table that holds its numbers: metrics of
/// the trials, tally of the answers.
fn shown(
    data: &StudyData,
    numbers: &[Option<PathBuf>; 2],
    made: &Summary,
) -> Result<Vec<Listed>, TableError> {
    let there = |file: &Option<PathBuf>| file.clone().filter(|f| f.exists());
    let [metrics, tally] =
        numbers.each_ref().map(|f| there(f).map(|f| Table::from_parquet(&f)).transpose());
    let (Some(metrics), tally) = (metrics?, tally?) else { return Ok(Vec::new()) };
    let sessions = sessions(data);
    let path = |shown: Shown| {
        let path = match (shown, sessions.as_slice()) {
            (Shown::Modes(environment), [one]) => {
                format!("figures/modes.{}.{environment}.png", one.key())
            }
            (Shown::Answers, _) => "figures/likert.png".to_owned(),
            (Shown::Metrics, _) => "tables/metrics.md".to_owned(),
            _ => CONDITIONS.to_owned(),
        };
        let is_made = made.figures.iter().chain(&made.tables).any(|m| m.path == path);
        if is_made { path } else { CONDITIONS.to_owned() }
    };
    let found = findings(&data.study, &metrics, tally.as_ref())?;
    Ok(found.into_iter().map(|f| Listed { path: path(f.shown), caption: f.text }).collect())
}

/// The table of the metrics by condition, from the summary's folder on.
const CONDITIONS: &str = "tables/conditions.md";

fn facts(data: &StudyData, found: &Findings) -> Summary {
    let counting: Vec<_> = data.counting().collect();
    let asked = data.answers();
    let with_samples =
        counting.iter().map(|t| (t.meta.participant.clone(), t.meta.session.clone(), t.meta.trial));
    let with_answers = asked.iter().map(|a| (a.participant.clone(), a.session.clone(), a.trial));
    let trials: BTreeSet<_> = with_samples.chain(with_answers).collect();
    let sessions: BTreeSet<_> = trials.iter().map(|(p, s, _)| (p, s)).collect();
    let people: BTreeSet<_> = trials.iter().map(|(p, _, _)| p).collect();
    let mut sources = BTreeMap::new();
    // By the footers, wherever there is one.
    for trial in &data.trials {
        *sources.entry(trial.meta.source).or_default() += 1;
    }
    for log in &data.sessions {
        *sources.entry(log.record.source).or_default() +=
            log.record.trials.iter().filter(|t| !t.samples).count();
    }
    for sweep in &data.sweeps {
        *sources.entry(sweep.source).or_default() += 1;
    }
    let moves = |c: &TrialEntry| {
        data.study.environment(&c.meta.environment).is_some_and(|e| !matches!(e.scene, Scene::None))
    };
    let no_lever = data.study.device.lever_m.is_none() && counting.iter().any(|t| moves(t));
    let limit = "No lever length is known (device.lever_m), so torque stays torque: N·m on axes and in tables.";
    Summary {
        title: data.study.title.clone(),
        device: data.study.device.name.clone(),
        participants: people.len(),
        sessions: sessions.len(),
        trials: trials.len(),
        sweeps: data.sweeps.len(),
        sources,
        left_out: left_out(data, found),
        care: found.with_care.iter().map(|finding| remark(data, finding)).collect(),
        limits: no_lever
            .then(|| limit.to_owned())
            .into_iter()
            .chain(not_recorded(&counting))
            .collect(),
        ..Summary::default()
    }
}

/// Every trial of the experiment that does not count, and whatever else was found and is in no
/// result.
fn left_out(data: &StudyData, found: &Findings) -> Vec<Remark> {
    let mut found_of: BTreeMap<&Path, Vec<Remark>> = BTreeMap::new();
    for finding in &found.left_out {
        found_of.entry(&finding.path).or_default().push(remark(data, finding));
    }
    let mut all = Vec::new();
    for trial in data.trials.iter().filter(|t| t.meta.kind == Kind::Trial) {
        let Some(why) = trial.why_not() else { continue };
        let found = found_of.remove(trial.path.as_path()).unwrap_or_default();
        let found: Vec<String> = found.into_iter().map(|remark| remark.why).collect();
        let why = if found.is_empty() { why } else { found.join("; ") };
        all.push(Remark { what: name(&trial.meta), why });
    }
    all.extend(found_of.into_values().flatten());
    all
}

/// A finding as the page has it.
fn remark(data: &StudyData, finding: &StoreError) -> Remark {
    let path = data.layout.shown(&finding.path).to_string_lossy().replace('\\', "/");
    let column =
        finding.column.as_ref().map(|column| format!(", column {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    Remark { what: format!("{path}{column}{row}"), why: plain(data, &finding.what) }
}

/// A table that has nothing in it, and so shows nothing.
fn empty(table: &Listed, rows: usize) -> Option<Remark> {
    (rows == 0).then(|| Remark { what: table.path.clone(), why: "the table has no row".to_owned() })
}

/// What figures and metrics must do without, because some trial was recorded without it.
fn not_recorded(counting: &[&TrialEntry]) -> Vec<String> {
    let force = [Signal::ForceEx, Signal::TorqueEx];
    let needed: [(&str, &[Signal], &str); 3] = [
        (
            "angle",
            &[Signal::Theta],
            "there is no panel of θ, no force against θ, and no metric of either",
        ),
        ("velocity", &[Signal::ThetaDot], "there is no onset, and so no average over time"),
        ("force and no torque", &force, "there is no force panel"),
    ];
    let lacks = |signals: &[Signal]| {
        counting.iter().filter(|t| !signals.iter().any(|s| t.signals.contains(s))).count()
    };
    let sentence = |(what, signals, so): (&str, &[Signal], &str)| {
        let n = lacks(signals);
        (n > 0).then(|| {
            format!("No {what} was recorded in {n} of {} trials: for them {so}.", counting.len())
        })
    };
    needed.into_iter().filter_map(sentence).collect()
}

/// What averages and plane fits say against themselves, each note once. Where an average ends is no
/// limit of the study.
fn notes(tables: &[PathBuf]) -> Result<Vec<String>, TableError> {
    let mut notes = BTreeSet::new();
    for path in tables.iter().filter(|p| p.exists()) {
        let (_, about) = Table::title_and_notes(path)?;
        notes.extend(about.into_iter().filter(|n| !n.contains(zwidth_average::ENDS_AT)));
    }
    Ok(notes.into_iter().collect())
}

/// A table, and how many rows it has.
fn table(file: &Path, folder: &Path) -> Result<(Listed, usize), TableError> {
    let table = Table::from_parquet(file)?;
    let path = relative(&file.with_extension("md"), folder);
    Ok((Listed { path, caption: table.title().to_owned() }, table.height()))
}

fn figure(file: &Path, folder: &Path) -> Listed {
    Listed { path: relative(file, folder), caption: figure_caption(&stem(file)) }
}

fn could_not_be_made(file: &Path) -> Remark {
    Remark { what: stem(file), why: "it could not be made; `zwidth run` says why".to_owned() }
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
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
        "rendering_range" => "forces that each mode can render, compressing and decompressing",
        "environment" => "device, spring and wall at the study's own angles",
        "free_motion" => "plane fits of free motion, sessions and modes side by side",
        other => other,
    };
    if of.is_empty() { what.to_owned() } else { format!("{what} ({of})") }
}
