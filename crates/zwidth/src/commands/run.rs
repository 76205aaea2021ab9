//! `zwidth run`: the main job, from raw data to every figure, table and summary. It makes only what
//! changed.

use super::alike::once;
use super::cluster::run_on;
use super::consent::scripts;
use super::near::did_you_mean;
use super::twice::compare_twice;
use super::{hashes_read, join_findings, nameless, studies};
use crate::exit::Exit;
use crate::screen::Screen;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use zwidth_acquire::Unsynced;
use zwidth_plan as plan;
use zwidth_runner::{
    Done, Job, JobEnd, Options, Report, Results, Scripts, Shard, run as run_jobs, waiting, wanted,
};
use zwidth_store::{Findings, Layout, RealFiles, Seen, StoreError, StudyData, findings};
use zwidth_study::StudyId;

#[derive(Debug, clap::Args)]
pub(crate) struct RunArgs {
    /// Studies to run [default: all under raw/]
    pub(crate) studies: Vec<StudyId>,
    /// Make everything again
    #[arg(long)]
    pub(crate) fresh: bool,
    /// Only this stage, figure or table, and what it needs
    #[arg(long, value_name = "STAGE|FIGURE|TABLE")]
    pub(crate) only: Option<String>,
    /// Only the share I of N of what is derived from trials, to be merged later: 3/7
    #[arg(long, value_name = "I/N", conflicts_with = "only")]
    pub(crate) shard: Option<Shard>,
    /// Have what is derived from trials made on a Ballista cluster, by its scheduler's address; the
    /// program `zwidth-cluster` must be on the path
    #[arg(long, value_name = "HOST:PORT", conflicts_with_all = ["fresh", "only", "shard", "dry_run", "without_origin"])]
    pub(crate) cluster: Option<String>,
    /// Where the cluster's executors find raw/: a folder that all machines share, or an object store
    /// [default: the same folder as here]
    #[arg(long, value_name = "DIR|s3://BUCKET/PREFIX", requires = "cluster")]
    pub(crate) raw: Option<String>,
    /// Let the study's own stages run, for this run alone; `zwidth allow` remembers it
    #[arg(long)]
    pub(crate) allow_scripts: bool,
    /// Make this stage, figure or table once more, and say whether the same bytes come out
    #[arg(long, value_name = "STAGE|FIGURE|TABLE", conflicts_with_all = ["shard", "cluster", "dry_run", "without_origin"])]
    pub(crate) twice: Option<String>,
    /// Say what would be made, and why; make nothing
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Files say nothing of their making, so that two programs' bytes can be compared
    #[arg(long, hide = true)]
    pub(crate) without_origin: bool,
}

/// What `--json` prints of a study.
#[derive(Serialize)]
struct Outcome {
    study: String,
    made: Vec<Entry>,
    up_to_date: usize,
    failed: Vec<Entry>,
    left_out: Vec<String>,
    read_with_care: Vec<String>,
    seconds: f64,
}

#[derive(Serialize)]
struct Entry {
    stage: &'static str,
    name: String,
    why: String,
    seconds: f64,
}

pub(crate) fn run(root: &Path, command: &RunArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let nameless = nameless(root, &command.studies);
    nameless.iter().for_each(|finding| screen.warn(finding.to_string()));
    let mut exit = if nameless.is_empty() { Exit::Fine } else { Exit::Partly };
    let mut outcomes = Vec::new();
    let mut failed = 0;
    let layouts = studies(root, command.studies.clone())?;
    let several = layouts.len() > 1;
    for layout in layouts {
        // First the parts on the cluster, if there is one; then the rest here.
        let shared_out = match &command.cluster {
            Some(scheduler) => run_on(scheduler, &layout, command.raw.as_deref(), screen),
            None => Ok(Exit::Fine),
        };
        let outcome = shared_out.and_then(|shared| Ok((shared, one(&layout, command, screen)?)));
        let outcome = match outcome {
            Ok((shared, outcome)) => {
                if shared != Exit::Fine {
                    exit = shared;
                }
                outcome
            }
            Err(error) if several => {
                screen.error(&error);
                failed += 1;
                continue;
            }
            Err(error) => return Err(error),
        };
        let Outcome { failed: not_made, left_out, read_with_care, .. } = &outcome;
        if !(not_made.is_empty() && left_out.is_empty() && read_with_care.is_empty()) {
            exit = Exit::Partly;
        }
        outcomes.push(outcome);
    }
    if screen.json {
        screen.listing(&outcomes)?;
    }
    Ok(match failed {
        0 => exit,
        // Of nothing it can be said that it is done.
        _ if outcomes.is_empty() => Exit::Failed,
        _ => Exit::Partly,
    })
}

fn one(layout: &Layout, command: &RunArgs, screen: &Screen) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    // --fresh: no file is taken for what an earlier run saw of it.
    let seen = if command.fresh { Seen::nothing(layout) } else { Seen::of(layout) };
    let data = StudyData::load_seen(&seen, layout).map_err(|findings| join_findings(&findings))?;
    let findings = findings(&RealFiles, &data);
    let jobs = needed_jobs(&data, &findings, command);
    for (option, name) in [("--only", &command.only), ("--twice", &command.twice)] {
        check_called(&jobs, layout.study(), option, name.as_deref())?;
    }
    let options = Options {
        fresh: command.fresh,
        dry_run: command.dry_run,
        only: command.only.clone(),
        shard: command.shard,
        // Hashed when the study was loaded: not a second time.
        known: hashes_read(&data),
        seen: Arc::new(seen),
        without_origin: command.without_origin,
        scripts: match command.allow_scripts {
            true => Scripts::All,
            false => scripts(layout)?,
        },
    };
    let of_plan: Vec<StoreError> = plan::plan_finding(layout).into_iter().collect();
    let left_out: Vec<String> =
        words(&findings.left_out).chain(plan::chosen_in_vain(&data)).collect();
    // The jobs have what they need of it.
    drop(data);
    // Not waited for: what a power cut spoils no longer has the hash in its record, and is made
    // again.
    let results = Results::new(layout, &Unsynced);
    // A run does not see what shards have made until it is merged.
    let waiting = if command.shard.is_some() { 0 } else { waiting(&results)? };
    if waiting > 0 {
        let study = layout.study();
        let shards =
            if waiting == 1 { "1 shard is".to_owned() } else { format!("{waiting} shards are") };
        screen.warn(format!(
            "{study}: {shards} not merged, and the results are made again; `zwidth merge {study}` first"
        ));
    }
    let Done { reports, remarks } = run_with_bars(&jobs, &results, &options, screen)?;
    let unlike = match &command.twice {
        Some(name) => compare_twice(&jobs, name, layout, &results, &options.scripts, screen)?,
        None => Vec::new(),
    };
    let with_care = words(&findings.with_care).chain(words(&of_plan)).chain(words(&remarks));
    let problems = reports.iter().flat_map(|r| r.problems.iter().cloned());
    let care = reports.iter().flat_map(|r| r.care.iter().cloned());
    let made = reports.iter().filter_map(|r| match &r.verdict {
        JobEnd::Made(why) => Some(entry(r, why)),
        _ => None,
    });
    let failed = reports.iter().filter_map(|r| match &r.verdict {
        JobEnd::Failed(why) | JobEnd::Blocked(why) => Some(entry(r, why)),
        _ => None,
    });
    let outcome = Outcome {
        study: layout.study().to_string(),
        made: made.collect(),
        up_to_date: reports.iter().filter(|r| r.verdict == JobEnd::UpToDate).count(),
        failed: failed.collect(),
        left_out: sorted(left_out.into_iter().chain(problems)),
        read_with_care: sorted(with_care.chain(care).chain(unlike)),
        seconds: start.elapsed().as_secs_f64(),
    };
    if !screen.json {
        tell(layout, &reports, &outcome, command, screen);
    }
    // Of a large study that takes long, and the command need not wait for it.
    rayon::spawn(move || drop(jobs));
    Ok(outcome)
}

/// Runs what is wanted of the jobs, with a bar for each stage.
pub(super) fn run_with_bars(
    jobs: &[Job],
    results: &Results<'_>,
    options: &Options,
    screen: &Screen,
) -> anyhow::Result<Done> {
    let wanted = wanted(jobs, results, options)?;
    let lengths = plan::STAGES.into_iter().map(|stage| {
        let jobs = jobs.iter().zip(&wanted);
        (stage, jobs.filter(|(job, wanted)| **wanted && job.stage.name == stage).count())
    });
    let bars = screen.bars(lengths.filter(|(_, n)| *n > 0));
    let done = run_jobs(jobs, results, options, &|report| bars.done(report.stage, &report.name));
    // Before an error is returned: it would be printed among the bars.
    bars.clear();
    Ok(done?)
}

/// The jobs among which are all that a run needs.
fn needed_jobs(data: &StudyData, findings: &Findings, command: &RunArgs) -> Vec<Job> {
    let only = command.only.as_deref();
    if let Some(jobs) = only.and_then(|stage| plan::jobs_of_stage(data, stage)) {
        return jobs;
    }
    let mut jobs = plan::jobs(data, findings);
    if let Some(only) = only
        && !plan::STAGES.contains(&only)
        && !jobs.iter().any(|job| job.is_called(only))
    {
        jobs.extend(plan::on_demand(data, only));
    }
    jobs
}

/// `--only` and `--twice` must name something that exists.
fn check_called(
    jobs: &[Job],
    study: &StudyId,
    option: &str,
    name: Option<&str>,
) -> anyhow::Result<()> {
    let Some(only) = name else { return Ok(()) };
    if jobs.iter().any(|job| job.is_called(only)) {
        return Ok(());
    }
    let mut stages = plan::STAGES.to_vec();
    stages.retain(|stage| jobs.iter().any(|job| job.stage.name == *stage));
    if plan::STAGES.contains(&only) {
        anyhow::bail!(
            "{option} {only}: this study has nothing for that stage to make; those that have are {}",
            stages.join(", ")
        );
    }
    let has_stem = |job: &&Job| ["figures", "tables"].contains(&job.stage.name);
    let stems = jobs.iter().filter(has_stem).filter_map(Job::stem);
    let names = stages.iter().copied().chain(stems);
    anyhow::bail!(
        "{option} {only}: there is no such stage, figure or table{} (stages: {}; `zwidth figure {study}` lists the \
         figures, `zwidth table {study}` the tables)",
        did_you_mean(only, names),
        stages.join(", "),
    )
}

fn words(findings: &[StoreError]) -> impl Iterator<Item = String> {
    findings.iter().map(ToString::to_string)
}

/// Each once, in order.
fn sorted(lines: impl Iterator<Item = String>) -> Vec<String> {
    lines.collect::<BTreeSet<_>>().into_iter().collect()
}

fn entry(report: &Report, why: &str) -> Entry {
    Entry {
        stage: report.stage,
        name: report.name.clone(),
        why: why.to_owned(),
        seconds: report.took.as_secs_f64(),
    }
}

fn tell(
    layout: &Layout,
    reports: &[Report],
    outcome: &Outcome,
    command: &RunArgs,
    screen: &Screen,
) {
    let verb = if command.dry_run { "to make" } else { "made" };
    for stage in plan::STAGES {
        let of_stage: Vec<_> = reports.iter().filter(|r| r.stage == stage).collect();
        if !of_stage.is_empty() {
            let made = of_stage.iter().filter(|r| matches!(r.verdict, JobEnd::Made(_))).count();
            let fresh = of_stage.iter().filter(|r| r.verdict == JobEnd::UpToDate).count();
            let took = of_stage.iter().map(|r| r.took.as_secs_f64()).sum::<f64>();
            let took = if screen.verbose { format!("  {took:>8.2} s") } else { String::new() };
            screen.say(format!("{stage:>13}  {made:>3} {verb}  {fresh:>3} up to date{took}"));
        }
    }
    if screen.verbose || command.dry_run {
        for Entry { name, why, seconds, .. } in &outcome.made {
            let took = if screen.verbose { format!("{seconds:>8.2} s  ") } else { String::new() };
            screen.say(format!("  {took}{name}: {why}"));
        }
    }
    // Failures are summed up too: one file can stop every figure.
    let failed = outcome.failed.iter().map(|e| format!("{} could not be made: {}", e.name, e.why));
    let failed: Vec<String> = failed.collect();
    let warnings = [
        ("left out: ", &outcome.left_out),
        ("read with care: ", &outcome.read_with_care),
        ("", &failed),
    ];
    for (prefix, lines) in warnings {
        for line in once(lines, screen.verbose) {
            screen.warn(format!("{prefix}{line}"));
        }
    }
    let shard = command.shard.map(|shard| format!(", shard {shard}")).unwrap_or_default();
    screen.result(format!(
        "{}{shard}: {} {verb}, {} up to date, in {:.2} s",
        outcome.study,
        outcome.made.len(),
        outcome.up_to_date,
        outcome.seconds
    ));
    let page = plan::page_file(layout);
    if !command.dry_run
        && reports.iter().any(|r| {
            r.name == plan::PAGE && matches!(r.verdict, JobEnd::Made(_) | JobEnd::UpToDate)
        })
    {
        screen.result(format!(
            "Look first at {} (`zwidth open {}`)",
            layout.shown(&page).display(),
            layout.study()
        ));
    }
}
