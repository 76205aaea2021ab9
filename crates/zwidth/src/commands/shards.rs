//! `zwidth shards`: which shards have made their share, and what is missing.

use super::sharded::{Sharded, line};
use crate::exit::Exit;
use crate::screen::Screen;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_runner::{MOST_SHARDS, Share, survey};
use zwidth_study::StudyId;

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
    survey.remarks.iter().for_each(|remark| screen.warn(remark.to_string()));
    survey.refused.iter().for_each(|error| screen.error(&anyhow::anyhow!("{error}")));
    if command.of.or(survey.count()).is_none() {
        screen.say("The manifests do not say how many shards there are: as one (--of N)");
    }
    let shares = survey.shares(&sharded.jobs, command.of);
    let listed: Vec<&Share> =
        shares.iter().filter(|share| !command.missing || !share.missing.is_empty()).collect();
    if screen.json {
        let entries = listed.iter().map(|share| Entry {
            shard: share.shard.to_string(),
            jobs: share.jobs,
            missing: &share.missing,
        });
        screen.listing(&entries.collect::<Vec<_>>())?;
    } else {
        listed.iter().for_each(|share| screen.result(line(share)));
    }
    let missing: usize = shares.iter().map(|share| share.missing.len()).sum();
    let jobs: usize = shares.iter().map(|share| share.jobs).sum();
    screen.say(format!("{}: {} of {jobs} jobs are there", command.study, jobs - missing));
    sharded.left_out.iter().for_each(|finding| screen.warn(finding.to_string()));
    let has_findings = !survey.remarks.is_empty() || !sharded.left_out.is_empty();
    let is_whole = missing == 0 && survey.refused.is_empty() && !has_findings;
    Ok(if is_whole { Exit::Fine } else { Exit::Partly })
}
