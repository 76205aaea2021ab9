//! Local, sharded and merged, and clustered: the same bytes.

use crate::hosts::{Running, executor, program, run, scheduler};
use crate::studies::{derived, files, is_as_without_a_cluster, merge_here, raw, run_here};
use std::fs;
use std::path::Path;
use std::process::Command;
use zwidth_runner::Shard;
use zwidth_store::{Layout, StudyData};

#[test]
fn what_two_executors_make_is_what_shards_make_and_what_a_run_makes_bit_for_bit() {
    let (_scheduler, address) = scheduler();
    let _executors = [executor(&address, &[]), executor(&address, &[])];
    let clustered = raw();
    run(clustered.path(), &address, &[]).end().ends(0, &["jobs came back and are merged"]);
    let parts = ["metrics/", "average/", "replay/", "courses/"];
    let of_trials: Vec<String> = derived(clustered.path()).into_keys().collect();
    for part in parts {
        assert!(of_trials.iter().any(|path| path.starts_with(part)), "{part}: {of_trials:?}");
    }
    assert!(!clustered.path().join("derived/thesis-twin/shards").exists());
    // Again: nothing is left to do.
    let again = run(clustered.path(), &address, &[]).end();
    assert!(!again.err.contains("on the cluster"), "{again:?}");
    again.ends(0, &[]);
    is_as_without_a_cluster(clustered.path());

    let sharded = raw();
    for _ in 0..2 {
        Shard::all(3).for_each(|shard| _ = run_here(sharded.path(), None, Some(shard)));
        merge_here(sharded.path(), &[]);
        run_here(sharded.path(), Some("identify"), None);
    }
    is_as_without_a_cluster(sharded.path());
}

#[test]
fn if_a_trial_is_gone_only_its_condition_and_the_metrics_of_its_session_are_made_again() {
    let (_scheduler, address) = scheduler();
    let _executor = executor(&address, &[]);
    let root = raw();
    run(root.path(), &address, &[]).end().ends(0, &[]);
    let layout = Layout::new(root.path(), "thesis-twin".parse().unwrap());
    let data = StudyData::load(&layout).unwrap();
    fs::remove_file(&data.counting().next().unwrap().path).unwrap();
    run(root.path(), &address, &[]).end().ends(0, &["3 jobs of 2 parts on the cluster"]);
}

/// The program as people call it, with a cluster of this build on its path: `ZWIDTH` names it.
fn zwidth(root: &Path, args: &[&str]) {
    let zwidth = std::env::var_os("ZWIDTH").expect("ZWIDTH names the program");
    let mut command = Command::new(zwidth);
    let own = Path::new(program().get_program()).parent().unwrap().to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let path = std::iter::once(own).chain(std::env::split_paths(&path));
    command.env("PATH", std::env::join_paths(path).unwrap()).env_remove("ZWIDTH_ROOT");
    command.arg("--root").arg(root).args(args);
    Running::begin(command).end().ends(0, &[]);
}

/// Two folders must have the same files, byte for byte; how many.
#[track_caller]
fn same_files(one: &Path, other: &Path) -> usize {
    let (one, other) = (files(one), files(other));
    let differ: Vec<_> =
        one.iter().filter(|(path, bytes)| other.get(*path) != Some(bytes)).map(|f| f.0).collect();
    assert!(differ.is_empty() && one.len() == other.len(), "{differ:?}");
    one.len()
}

#[test]
#[ignore = "needs the program zwidth in ZWIDTH"]
fn a_run_of_zwidth_on_a_cluster_gives_all_files_of_a_run_without() {
    let (_scheduler, address) = scheduler();
    let _executors = [executor(&address, &[]), executor(&address, &[])];
    let (alone, clustered) = (raw(), raw());
    zwidth(alone.path(), &["run", "thesis-twin"]);
    zwidth(clustered.path(), &["run", "thesis-twin", "--cluster", &address]);
    for folder in ["derived", "reports"] {
        assert!(same_files(&alone.path().join(folder), &clustered.path().join(folder)) > 60);
    }
}

#[test]
#[ignore = "needs the program zwidth in ZWIDTH, and takes long"]
fn what_a_cluster_derives_of_fifty_participants_is_what_one_machine_derives() {
    let (_scheduler, address) = scheduler();
    let _executors = [executor(&address, &[]), executor(&address, &[])];
    let root = tempfile::tempdir().unwrap();
    let study = ["--participants", "50", "--sessions", "1", "--rate", "1000"];
    zwidth(root.path(), &[&["--quiet", "twin", "fifty"][..], &study].concat());
    zwidth(root.path(), &["--quiet", "run", "fifty"]);
    let (derived, alone) = (root.path().join("derived"), root.path().join("alone"));
    fs::rename(&derived, &alone).unwrap();
    fs::remove_dir_all(root.path().join("reports")).unwrap();
    zwidth(root.path(), &["--quiet", "run", "fifty", "--cluster", &address]);
    assert!(same_files(&alone, &derived) > 1000);
}
