//! The study that comes with the software, in temporary folders, and what is made of it without a
//! cluster.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;
use zwidth_plan as plan;
use zwidth_runner::{HashesRead, Options, Results, Shard, merge, run};
use zwidth_store::{Layout, RealFiles, StudyData, findings};

/// Contents of files, by their paths.
pub(crate) type Files = BTreeMap<String, Vec<u8>>;

/// The workspace that this one stands beside.
pub(crate) fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// A data folder with the study's raw data alone.
pub(crate) fn raw() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    for (path, bytes) in files(&workspace().join("raw/thesis-twin")) {
        let to = root.path().join("raw/thesis-twin").join(path);
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::write(to, bytes).unwrap();
    }
    root
}

/// Every file below a folder, except locks, and what a run knows of the times of files.
pub(crate) fn files(folder: &Path) -> Files {
    let mut found = Files::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in fs::read_dir(&next).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                folders.push(entry);
            } else if entry
                .file_name()
                .is_some_and(|name| name != ".lock" && name != ".hashes.json")
            {
                let path = entry.strip_prefix(folder).unwrap().to_str().unwrap().to_owned();
                found.insert(path, fs::read(entry).unwrap());
            }
        }
    }
    found
}

/// All that was derived in a data folder, with the records of how.
pub(crate) fn derived(root: &Path) -> Files {
    files(&root.join("derived/thesis-twin"))
}

/// Runs the study in this process, or a shard of it; what was made.
pub(crate) fn run_here(root: &Path, only: Option<&str>, shard: Option<Shard>) -> usize {
    let layout = Layout::new(root, "thesis-twin".parse().unwrap());
    let data = StudyData::load(&layout).unwrap();
    let jobs = plan::jobs(&data, &findings(&RealFiles, &data));
    let options = Options { only: only.map(str::to_owned), shard, ..Options::default() };
    let done = run(&jobs, &Results::new(&layout, &RealFiles), &options, &|_| {}).unwrap();
    let is_made = |end: &zwidth_runner::JobEnd| matches!(end, zwidth_runner::JobEnd::Made(_));
    done.reports.iter().filter(|report| is_made(&report.verdict)).count()
}

/// Merges the shards of a data folder, and those of other ones.
pub(crate) fn merge_here(root: &Path, from: &[&Path]) {
    let layout = Layout::new(root, "thesis-twin".parse().unwrap());
    let data = StudyData::load(&layout).unwrap();
    let jobs = plan::jobs(&data, &findings(&RealFiles, &data));
    let layouts: Vec<Layout> =
        from.iter().map(|root| Layout::new(root, layout.study().clone())).collect();
    let from: Vec<Results> = layouts.iter().map(|of| Results::new(of, &RealFiles)).collect();
    let own = Results::new(&layout, &RealFiles);
    let merged =
        merge(&jobs, (&own, &from), &HashesRead::default(), &std::sync::Arc::default(), &|_| {}).unwrap();
    assert!(merged.survey.refused.is_empty());
}

/// What a run without a cluster derives, records included.
pub(crate) static LOCAL: LazyLock<Files> = LazyLock::new(|| {
    let root = raw();
    run_here(root.path(), None, None);
    derived(root.path())
});

/// Holds what was derived, after a run has made the rest, against a run without a cluster.
#[track_caller]
pub(crate) fn is_as_without_a_cluster(root: &Path) {
    run_here(root, None, None);
    let there = derived(root);
    let differ: Vec<&String> = LOCAL
        .iter()
        .filter(|(path, bytes)| there.get(*path) != Some(bytes))
        .map(|(path, _)| path)
        .collect();
    assert!(differ.is_empty(), "{differ:?}");
    assert_eq!(there.len(), LOCAL.len());
    assert!(there.len() > 60, "{}", there.len());
}
