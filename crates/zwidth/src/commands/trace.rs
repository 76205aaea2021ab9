//! `zwidth trace`: the raw files behind a result, and the jobs between, from the records of the
//! last run.

use super::locate::{
    FoundBy, Maker, Place, Traced, copies, is_a_copy, is_raw, no_job, place, records,
};
use super::study;
use super::why::short;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{anyhow, bail};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use zwidth_plan as plan;
use zwidth_runner::{Record, Source, Trace, trace as follow};
use zwidth_store::{file_blake3, outside_log};

/// What `--json` prints of a file.
#[derive(Serialize)]
struct Behind {
    path: String,
    found_by: FoundBy,
    study: String,
    job: String,
    origin: String,
    /// What the job made, and what the file is now.
    recorded: Option<String>,
    now: Option<String>,
    /// The jobs behind it, its own first, nearest first.
    jobs: Vec<Job>,
    /// The raw files in which the chain ends.
    raw: Vec<Raw>,
    /// Contents of results that were read and have been replaced or taken away since: the chain
    /// ends there.
    lost: Vec<Source>,
    /// Files from which the jobs' parameters are taken.
    parameters_from: Vec<String>,
}

#[derive(Serialize)]
struct Job {
    job: String,
    #[serde(flatten)]
    record: Record,
}

/// A raw file, as it was read.
#[derive(Serialize)]
struct Raw {
    #[serde(flatten)]
    source: Source,
    /// What the file is now; null if it is gone.
    now: Option<String>,
    /// Of a table that was given: the file that it was, and who computed it.
    #[serde(skip_serializing_if = "Option::is_none")]
    given: Option<Given>,
}

/// Where a table of a metric of another program came from.
#[derive(Serialize)]
struct Given {
    file: String,
    blake3: String,
    program: Option<String>,
    utc: String,
}

pub(crate) fn trace(root: &Path, command: &Traced, screen: &Screen) -> anyhow::Result<Exit> {
    let makers = find_makers(root, &command.path, screen)?;
    let traces =
        makers.iter().map(|maker| trace_behind(root, maker)).collect::<anyhow::Result<Vec<_>>>()?;
    screen.give(&traces, || traces.iter().for_each(|behind| screen.result(text(behind))))?;
    Ok(Exit::Fine)
}

/// The job behind the path, or the jobs behind a copy: of a file with several tables in it there
/// are several.
fn find_makers(root: &Path, typed: &Path, screen: &Screen) -> anyhow::Result<Vec<Maker>> {
    let (id, path) = match place(root, typed) {
        Place::Raw(path) => bail!(is_raw(&path)),
        Place::Outside => return copies(root, typed, screen),
        Place::Results(id, path) => (id, path),
    };
    // Not the name of a study, although it stands where one would.
    if path.starts_with("reports/simulate/") {
        bail!(no_job(&path, &id, &[]));
    }
    let layout = study(root, id)?;
    let records = records(&layout, screen)?;
    if let Some(job) = records.maker(&path) {
        let job = job.to_owned();
        return Ok(vec![Maker { layout, records, job, by: FoundBy::Path, path }]);
    }
    if is_a_copy(root, &path) {
        return copies(root, &root.join(&path), screen);
    }
    let id = layout.study();
    let outputs: Vec<String> = records.outputs().map(|(path, _)| path).collect();
    if outputs.is_empty() {
        bail!("{id} has no record of anything made; make it with `zwidth run {id}`");
    }
    bail!(no_job(&path, id, &outputs))
}

fn trace_behind(root: &Path, maker: &Maker) -> anyhow::Result<Behind> {
    let trace = follow(&maker.records, &maker.job)
        .ok_or_else(|| anyhow!("no run recorded {}; run its study again", maker.job))?;
    let parameters_from = parameters_from(maker, &trace);
    // Not a raw file and made by no job any more: the chain ends there, as where it is lost.
    let (raw, gone): (Vec<_>, Vec<_>) =
        trace.sources.into_iter().partition(|s| s.path.starts_with("raw/"));
    // Nearest first: the file's own job is the first step.
    let own = trace.steps[0].record.clone();
    let jobs = trace
        .steps
        .into_iter()
        .map(|step| Job { job: step.job.to_owned(), record: Arc::unwrap_or_clone(step.record) });
    // A log that is damaged is told by `verify`, and tells nothing here.
    let tables = outside_log(&maker.layout).unwrap_or_default();
    let raw = raw.into_iter().map(|source| {
        let path = root.join(&source.path);
        let own = tables.iter().find(|own| own.path == path && own.blake3 == source.blake3);
        let given = own.map(|own| Given {
            file: own.file.clone(),
            blake3: own.file_blake3.clone(),
            program: own.metric.program.clone(),
            utc: own.utc.clone(),
        });
        Raw { now: file_blake3(&path).ok(), source, given }
    });
    Ok(Behind {
        path: maker.path.clone(),
        found_by: maker.by,
        study: maker.layout.study().to_string(),
        job: maker.job.clone(),
        origin: own.origin.clone(),
        recorded: own.outputs.get(&maker.path).cloned(),
        now: file_blake3(&root.join(&maker.path)).ok(),
        parameters_from,
        jobs: jobs.collect(),
        raw: raw.collect(),
        lost: trace.lost.into_iter().chain(gone).collect(),
    })
}

/// Where the parameters come from: what was planned, the record and the log of each session whose
/// trials are behind it (they tell which trials count, their modes, and the calibration in force),
/// and scenes that are built in.
fn parameters_from(maker: &Maker, trace: &Trace) -> Vec<String> {
    let layout = &maker.layout;
    let shown = |path: &Path| layout.shown(path).to_string_lossy().replace('\\', "/");
    let mut files = Vec::new();
    if trace.steps.iter().any(|step| !step.record.parameters.is_empty()) {
        files.push(shown(&layout.study_toml()));
    }
    let own = layout.own();
    if trace.sources.iter().any(|source| layout.root().join(&source.path).starts_with(&own)) {
        files.push(shown(&layout.own_events()));
    }
    let trials = trace.sources.iter().filter_map(|s| trial(&s.path));
    let sessions: BTreeSet<_> = trials.map(|t| (t.participant, t.session)).collect();
    for (participant, session) in sessions {
        if let (Ok(participant), Ok(session)) = (participant.parse(), session.parse()) {
            files.push(shown(&layout.session(&participant, &session)));
            files.push(shown(&layout.events(&participant, &session)));
        }
    }
    files.extend(trace.steps.iter().filter_map(|step| plan::built_in(step.job)).map(str::to_owned));
    files
}

/// A trial, from its path.
#[derive(Debug, PartialEq, Eq)]
struct Trial<'a> {
    participant: &'a str,
    session: &'a str,
    number: u32,
}

fn trial(path: &str) -> Option<Trial<'_>> {
    let (_, rest) = path.split_once("/trials/participant=")?;
    let (participant, rest) = rest.split_once("/session=")?;
    let (session, file) = rest.split_once("/trial-")?;
    let number = file.strip_suffix(".parquet")?.parse().ok()?;
    Some(Trial { participant, session, number })
}

fn text(b: &Behind) -> String {
    let mut lines = vec![
        b.path.clone(),
        format!("  made by  {} of {}", b.job, b.study),
        format!("  origin   {}", b.origin),
    ];
    lines.push(format!("  content  {}", content(b)));
    lines.push("Jobs behind it, nearest first".to_owned());
    for Job { job, record } in &b.jobs {
        lines.push(format!("  {job} ({} {})", record.stage, record.version));
        lines.extend(inputs(&record.inputs).into_iter().map(|line| format!("    {line}")));
    }
    lines.push(format!("Raw files in which it ends: {}", b.raw.len()));
    for raw in &b.raw {
        let is_unchanged = raw.now.as_ref() == Some(&raw.source.blake3);
        let since = if is_unchanged { "" } else { "  changed since" };
        lines.push(format!("  {}  {}{since}", short(Some(&raw.source.blake3)), raw.source.path));
        if let Some(Given { file, blake3, program, utc }) = &raw.given {
            let program = program.as_ref().map(|program| format!(" by {program}"));
            let by = program.unwrap_or_default();
            let hash = short(Some(blake3));
            lines.push(format!("    computed outside of zwidth{by}: {hash}  {file}, given {utc}"));
        }
    }
    if !b.lost.is_empty() {
        lines.push(
            "Made again since with another content, so that nothing is known of what was behind it:"
                .to_owned(),
        );
    }
    lines.extend(b.lost.iter().map(|s| format!("  {}  {}", short(Some(&s.blake3)), s.path)));
    if !b.parameters_from.is_empty() {
        lines.push(format!("Parameters are from {}", b.parameters_from.join(", ")));
    }
    lines.join("\n")
}

fn content(b: &Behind) -> String {
    let recorded = short(b.recorded.as_ref());
    match &b.now {
        now if *now == b.recorded => format!("{recorded}, as it was made"),
        None => format!("{recorded} when it was made; the file is gone"),
        now => format!("{recorded} when it was made; edited since: now {}", short(now.as_ref())),
    }
}

/// Derived files with their hashes, one per line; trials by session, in one line each: the chain's
/// end has their hashes.
fn inputs(inputs: &BTreeMap<String, String>) -> Vec<String> {
    let mut trials: BTreeMap<(&str, &str), Vec<String>> = BTreeMap::new();
    let mut lines = Vec::new();
    for (path, hash) in inputs {
        match trial(path) {
            Some(t) => {
                trials.entry((t.participant, t.session)).or_default().push(t.number.to_string())
            }
            None => lines.push(format!("{}  {path}", short(Some(hash)))),
        }
    }
    lines.extend(trials.into_iter().map(|((p, s), numbers)| {
        let plural = if numbers.len() == 1 { "" } else { "s" };
        format!("{} trial{plural} of {p} {s}: {}", numbers.len(), numbers.join(", "))
    }));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_is_told_from_its_path_and_nothing_else_is_one() {
        let path = "raw/s/trials/participant=P01/session=S02/trial-017.parquet";
        assert_eq!(trial(path), Some(Trial { participant: "P01", session: "S02", number: 17 }));
        for other in
            ["raw/s/sweeps/actuator=motor/sweep-03.parquet", "derived/s/metrics.parquet", ""]
        {
            assert_eq!(trial(other), None, "{other}");
        }
    }

    #[test]
    fn trials_stand_in_one_line_a_session() {
        let trial = |p, n| format!("raw/s/trials/participant={p}/session=S01/trial-{n:03}.parquet");
        let paths =
            [trial("P01", 4), trial("P01", 10), trial("P02", 1), "derived/s/a.parquet".to_owned()];
        let map = paths.into_iter().map(|path| (path, "0123456789abcdef".to_owned())).collect();
        let expect = [
            "0123456789ab  derived/s/a.parquet",
            "2 trials of P01 S01: 4, 10",
            "1 trial of P02 S01: 1",
        ];
        assert_eq!(inputs(&map), expect);
    }
}
