//! `zwidth shards` and `zwidth merge`: which shards have made their share, and what is missing;
//! their results become the study's.

use super::{hashes_read, join_findings, study};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_acquire::Unsynced;
use zwidth_plan as plan;
use zwidth_runner::{
    HashesRead, Job, MOST_SHARDS, Results, Share, Survey, merge as merge_shards, survey, waiting,
};
use zwidth_store::{Layout, RealFiles, Seen, StoreError, StudyData, findings};
use zwidth_study::{StudyId, counted};

#[derive(Debug, clap::Args)]
pub(crate) struct ShardsArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Only shards that something is missing of
    #[arg(long)]
    pub(crate) missing: bool,
    /// How many shards there are [default: as many as the manifests say]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_SHARDS)))]
    pub(crate) of: Option<u32>,
    /// Other data folders in which shards were made
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
}

/// What `--json` prints of a shard.
#[derive(Serialize)]
struct Entry<'a> {
    shard: String,
    jobs: usize,
    missing: &'a [&'a str],
}

pub(crate) fn shards(root: &Path, command: &ShardsArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let sharded = Sharded::load(root, &command.study, &command.from)?;
    let (own, others) = sharded.results();
    let bar = screen.bar(0);
    let survey = survey(&sharded.jobs, &own, &others, &sharded.hashes, &sharded.seen, &|all| {
        bar.set_length(all as u64);
        bar.inc(1);
    })?;
    bar.finish_and_clear();
    warn_of(&survey, screen);
    if command.of.or(survey.count()).is_none() {
        screen.say("The manifests do not say how many shards there are: as one (--of N)");
    }
    let shares = survey.shares(&sharded.jobs, command.of);
    let listed: Vec<&Share> =
        shares.iter().filter(|share| !command.missing || !share.missing.is_empty()).collect();
    let entries = listed.iter().map(|share| Entry {
        shard: share.shard.to_string(),
        jobs: share.jobs,
        missing: &share.missing,
    });
    screen.give(&entries.collect::<Vec<_>>(), || {
        listed.iter().for_each(|share| screen.result(line(share)));
    })?;
    let missing: usize = shares.iter().map(|share| share.missing.len()).sum();
    let jobs: usize = shares.iter().map(|share| share.jobs).sum();
    screen.say(format!("{}: {} of {jobs} jobs are there", command.study, jobs - missing));
    sharded.left_out.iter().for_each(|finding| screen.warn(finding.to_string()));
    let has_findings = !survey.remarks.is_empty() || !sharded.left_out.is_empty();
    let is_whole = missing == 0 && survey.refused.is_empty() && !has_findings;
    Ok(if is_whole { Exit::Fine } else { Exit::Partly })
}

#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Other data folders in which shards were made; nothing there is changed
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
}

/// What `--json` prints of a merge.
#[derive(Serialize)]
struct Outcome {
    study: String,
    merged: Vec<String>,
    jobs: usize,
    copied: usize,
    refused: Vec<String>,
    missing: Vec<String>,
}

pub(crate) fn merge(root: &Path, command: &MergeArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let sharded = Sharded::load(root, &command.study, &command.from)?;
    let (own, others) = sharded.results();
    let bar = screen.bar(0);
    let merged =
        merge_shards(&sharded.jobs, &own, &others, &sharded.hashes, &sharded.seen, &|all| {
            bar.set_length(all as u64);
            bar.inc(1);
        })?;
    bar.finish_and_clear();
    let survey = &merged.survey;
    warn_of(survey, screen);
    let missing: Vec<&Share> = merged.shares.iter().filter(|s| !s.missing.is_empty()).collect();
    sharded.left_out.iter().for_each(|finding| screen.warn(finding.to_string()));
    // Without a manifest nobody knows how many shards there are.
    if survey.count().is_some() {
        missing.iter().for_each(|share| screen.warn(line(share)));
    }
    let outcome = Outcome {
        study: command.study.to_string(),
        merged: merged.shards.iter().map(ToString::to_string).collect(),
        jobs: merged.jobs,
        copied: merged.copied,
        refused: survey.refused.iter().map(ToString::to_string).collect(),
        missing: missing.iter().map(|share| share.shard.to_string()).collect(),
    };
    screen.give(&outcome, || screen.result(text(&outcome)))?;
    // Without a shard at all there was nothing to fail at.
    let nothing = outcome.merged.is_empty() && !outcome.refused.is_empty();
    let has_findings = !survey.remarks.is_empty() || !sharded.left_out.is_empty();
    let is_whole = outcome.refused.is_empty() && missing.is_empty() && !has_findings;
    Ok(match (nothing, is_whole) {
        (true, _) => Exit::Failed,
        (false, true) => Exit::Fine,
        (false, false) => Exit::Partly,
    })
}

/// Says what is wrong with the study's records, and why shards are refused.
fn warn_of(survey: &Survey<'_>, screen: &Screen) {
    survey.remarks.iter().for_each(|remark| screen.warn(remark.to_string()));
    survey.refused.iter().for_each(|error| screen.error(&anyhow::anyhow!("{error}")));
}

fn text(outcome: &Outcome) -> String {
    let Outcome { study, merged, jobs, copied, refused, missing } = outcome;
    if merged.is_empty() {
        let why = if refused.is_empty() { ": there is no manifest of one" } else { "" };
        return format!("{study}: no shard was merged{why}");
    }
    let mut parts =
        vec![format!("{} merged", counted(merged.len(), "shards")), counted(*jobs, "jobs")];
    if *copied > 0 {
        parts.push(format!("{} copied", counted(*copied, "files")));
    }
    let left = [(refused.len(), "refused"), (missing.len(), "incomplete")];
    parts.extend(left.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    format!("{study}: {}; `zwidth run {study}` makes the rest", parts.join(", "))
}

/// A study that was shared out.
struct Sharded {
    jobs: Vec<Job>,
    /// The hashes of the raw files, as they were read.
    hashes: HashesRead,
    seen: Arc<Seen>,
    /// Recordings that are left out of it, and why.
    left_out: Vec<StoreError>,
    own: Layout,
    others: Vec<Layout>,
}

impl Sharded {
    /// The study, and the data folders in which shards of it were made.
    fn load(root: &Path, id: &StudyId, from: &[PathBuf]) -> anyhow::Result<Self> {
        let own = study(root, id.clone())?;
        let mut others: Vec<Layout> = Vec::new();
        for folder in from {
            let other = Layout::new(folder, id.clone());
            let lacking = match waiting(&Results::new(&other, &Unsynced))? {
                _ if !other.derived().is_dir() => Some(other.derived()),
                0 => Some(other.derived().join("shards")),
                _ => None,
            };
            if let Some(lacking) = lacking {
                bail!(
                    "there are no shards of {id} in {}: {} is missing or empty, as it is after a merge there; \
                     name data folders in which `zwidth run {id} --shard I/N` was run",
                    other.root().display(),
                    lacking.display()
                );
            }
            // A folder that is named twice, or is the study's own, has its shards once.
            if !others.iter().chain([&own]).any(|listed| is_same(listed, &other)) {
                others.push(other);
            }
        }
        let seen = Seen::of(&own);
        let data =
            StudyData::load_seen(&seen, &own).map_err(|findings| join_findings(&findings))?;
        let findings = findings(&RealFiles, &data);
        let jobs = plan::jobs(&data, &findings);
        let left_out = findings.left_out;
        Ok(Self { left_out, jobs, hashes: hashes_read(&data), seen: Arc::new(seen), own, others })
    }

    /// The study's own results, and those in the other data folders.
    fn results(&self) -> (Results<'_>, Vec<Results<'_>>) {
        let others = self.others.iter().map(|layout| Results::new(layout, &Unsynced));
        (Results::new(&self.own, &Unsynced), others.collect())
    }
}

/// Whether the results of two layouts lie in one folder.
fn is_same(a: &Layout, b: &Layout) -> bool {
    let [a, b] = [a, b].map(|layout| layout.derived().canonicalize());
    a.is_ok_and(|a| b.is_ok_and(|b| a == b))
}

/// The most names of jobs that are printed of a shard.
const NAMES: usize = 4;

/// How a shard stands, on a line that begins with it.
fn line(share: &Share) -> String {
    let Share { shard, jobs, missing } = share;
    if missing.is_empty() {
        return format!("{shard}  {jobs} of {jobs} jobs are there");
    }
    let mut names: Vec<String> =
        missing.iter().take(NAMES).map(|name| (*name).to_owned()).collect();
    if missing.len() > NAMES {
        names.push(format!("{} more", missing.len() - NAMES));
    }
    format!("{shard}  {} of {jobs} jobs are missing: {}", missing.len(), names.join(", "))
}
