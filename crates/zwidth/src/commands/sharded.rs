//! What the commands about shards share: the study's jobs, and the folders that shards lie in.

use super::{hashes_read, join_findings, study};
use anyhow::ensure;
use std::path::{Path, PathBuf};
use zwidth_acquire::Unsynced;
use zwidth_plan as plan;
use zwidth_runner::{Job, Results, Share};
use zwidth_store::{Layout, RealFiles, StudyData, findings};
use zwidth_study::StudyId;

/// A study that was shared out.
pub(super) struct Sharded {
    pub(super) jobs: Vec<Job>,
    pub(super) known: Vec<(PathBuf, String)>,
    own: Layout,
    others: Vec<Layout>,
}

impl Sharded {
    /// The study, and the data folders in which shards of it were made.
    pub(super) fn load(root: &Path, id: &StudyId, from: &[PathBuf]) -> anyhow::Result<Self> {
        let own = study(root, id.clone())?;
        let others: Vec<Layout> =
            from.iter().map(|folder| Layout::new(folder, id.clone())).collect();
        for other in &others {
            let derived = other.derived();
            ensure!(
                derived.is_dir(),
                "there are no shards of {id} in {}: {} is missing; name data folders in which \
                 `zwidth run {id} --shard I/N` was run",
                other.root().display(),
                derived.display()
            );
        }
        let data = StudyData::load(&own).map_err(|findings| join_findings(&findings))?;
        let jobs = plan::jobs(&data, &findings(&RealFiles, &data));
        Ok(Self { jobs, known: hashes_read(&data), own, others })
    }

    /// The study's own results, and those in the other data folders.
    pub(super) fn results(&self) -> (Results<'_>, Vec<Results<'_>>) {
        let results = |layout| Results::new(layout, &Unsynced);
        (results(&self.own), self.others.iter().map(results).collect())
    }
}

/// Names of jobs that people are shown of a shard.
const NAMES: usize = 4;

/// How a shard stands, on a line that begins with it.
pub(super) fn line(share: &Share) -> String {
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
