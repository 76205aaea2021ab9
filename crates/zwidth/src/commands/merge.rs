//! `zwidth merge`: the results of shards become the study's.

use super::sharded::{Sharded, line};
use crate::exit::Exit;
use crate::screen::Screen;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_runner::{Share, merge as merge_shards};
use zwidth_study::{StudyId, counted};

#[derive(Debug, clap::Args)]
pub(crate) struct MergeArgs {
    /// The study
    pub(crate) study: StudyId,
    /// Other data folders in which shards were made; nothing there is changed
    #[arg(long, value_name = "DIR", num_args = 1..)]
    pub(crate) from: Vec<PathBuf>,
}

/// What `--json` prints.
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
    survey.remarks.iter().for_each(|remark| screen.warn(remark.to_string()));
    survey.refused.iter().for_each(|error| screen.error(&anyhow::anyhow!("{error}")));
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
    if screen.json {
        screen.listing(&outcome)?;
    } else {
        screen.result(text(&outcome));
    }
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
