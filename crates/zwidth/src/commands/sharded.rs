//! The common parts of the commands about shards: the study's jobs, and the folders of shards.

use super::{hashes_read, join_findings, study};
use anyhow::bail;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_acquire::Unsynced;
use zwidth_plan as plan;
use zwidth_runner::{HashesRead, Job, Results, Share, waiting};
use zwidth_store::{Layout, RealFiles, Seen, StoreError, StudyData, findings};
use zwidth_study::StudyId;

/// A study that was shared out.
pub(super) struct Sharded {
    pub(super) jobs: Vec<Job>,
    /// The hashes of the raw files, as they were read.
    pub(super) hashes: HashesRead,
    pub(super) seen: Arc<Seen>,
    /// Recordings that are left out of it, and why.
    pub(super) left_out: Vec<StoreError>,
    own: Layout,
    others: Vec<Layout>,
}

impl Sharded {
    /// The study, and the data folders in which shards of it were made.
    pub(super) fn load(root: &Path, id: &StudyId, from: &[PathBuf]) -> anyhow::Result<Self> {
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
    pub(super) fn results(&self) -> (Results<'_>, Vec<Results<'_>>) {
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
