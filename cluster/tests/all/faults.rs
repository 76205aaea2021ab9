//! Whatever goes wrong with a cluster ends in a result or in a clear error.

use crate::hosts::{Ran, Running, executor, executor_with, fetch, free_port, run, scheduler};
use crate::stored::{URL, settings, silent_store, store, store_without};
use crate::studies::{is_as_without_a_cluster, merge_here, raw};
use ballista_core::config::TaskSchedulingPolicy;
use ballista_executor::executor_process::{ExecutorProcessConfig, start_executor_process};
use log::{LevelFilter, Log, Metadata, Record};
use std::fs::{self, File};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use zwidth_store::{Layout, StudyData};

#[test]
fn without_a_scheduler_a_run_says_so() {
    let root = raw();
    let address = format!("127.0.0.1:{}", free_port());
    run(root.path(), &address, &[])
        .end()
        .ends(1, &["no scheduler answers", "zwidth-cluster scheduler"]);
    // Something else listens there.
    let other = store(root.path());
    let other = other.strip_prefix("http://").unwrap();
    run(root.path(), other, &[]).end().ends(1, &["no scheduler of Ballista"]);
    assert!(!root.path().join("derived").exists());
}

#[test]
fn without_an_executor_a_run_says_so() {
    let (_scheduler, address) = scheduler();
    let root = raw();
    let words = ["has no executor", "zwidth-cluster executor --scheduler"];
    run(root.path(), &address, &["--patience", "1"]).end().ends(1, &words);
}

#[test]
fn when_all_executors_are_killed_in_the_middle_a_run_ends_and_says_so() {
    let (_scheduler, address) = scheduler();
    let (endpoint, asked) = silent_store();
    let mut executors = [(); 2].map(|()| executor(&address, &settings(&endpoint)));
    let root = raw();
    let running = run(root.path(), &address, &["--raw", URL, "--patience", "1"]);
    let _open = [asked.recv().unwrap(), asked.recv().unwrap()];
    executors.iter_mut().for_each(|executor| executor.kill());
    running.end().ends(1, &["what came back of thesis-twin is merged", "run it again"]);
    // The same study, with executors that live: nothing of the run that failed is in the way.
    let _executor = executor(&address, &[]);
    run(root.path(), &address, &[]).end().ends(0, &[]);
    is_as_without_a_cluster(root.path());
}

#[test]
fn when_one_executor_is_killed_in_the_middle_the_other_does_its_tasks_and_the_bytes_are_the_same() {
    let (_scheduler, address) = scheduler();
    let root = raw();
    let (silent, asked) = silent_store();
    let mut dies = executor(&address, &settings(&silent));
    let running = run(root.path(), &address, &["--raw", URL]);
    let _open = asked.recv().unwrap();
    // It has a task, and the other one comes only now.
    let lives = store(root.path());
    let _lives = executor(&address, &settings(&lives));
    dies.kill();
    running.end().ends(0, &["13 of 13 jobs came back"]);
    is_as_without_a_cluster(root.path());
}

#[test]
fn when_the_scheduler_is_killed_in_the_middle_a_run_ends_and_says_so() {
    let (mut scheduler, address) = scheduler();
    let (endpoint, asked) = silent_store();
    let _executor = executor(&address, &settings(&endpoint));
    let root = raw();
    let running = run(root.path(), &address, &["--raw", URL, "--patience", "1"]);
    let _open = asked.recv().unwrap();
    scheduler.kill();
    let ran = running.end();
    ran.ends(1, &["what came back of thesis-twin is merged", "no scheduler answers"]);
    // Nothing is wrong with the executors.
    ran.says_nothing_of("version");
}

#[test]
fn what_comes_back_while_another_run_goes_on_in_the_folder_is_kept_and_the_command_merges_it() {
    let (_scheduler, address) = scheduler();
    let _executor = executor(&address, &[]);
    let root = raw();
    let derived = root.path().join("derived/thesis-twin");
    fs::create_dir_all(&derived).unwrap();
    // As a run does it.
    let held = File::open(&derived).unwrap();
    held.lock().unwrap();
    let ran = run(root.path(), &address, &[]).end();
    drop(held);
    let merges = format!("`zwidth --root {} merge thesis-twin --from ", root.path().display());
    ran.ends(1, &["what came back of thesis-twin is kept", "goes on here", &merges]);
    assert_eq!(fs::read_dir(&derived).unwrap().count(), 0);
    let kept = ran.err.split_once(&merges).unwrap().1.split_once('`').unwrap().0;
    merge_here(root.path(), &[Path::new(kept)]);
    fs::remove_dir_all(kept).unwrap();
    // Of what came back nothing is made again.
    let ran = run(root.path(), &address, &[]).end();
    ran.ends(0, &[]);
    ran.says_nothing_of("13 of 13 jobs came back");
    is_as_without_a_cluster(root.path());
}

#[test]
fn an_executor_that_takes_too_long_is_not_waited_for_and_its_tasks_are_taken_back() {
    let late = gives_up(&["--deadline", "1"], |_| {});
    late.ends(1, &["gave no answer within 1 s", "--deadline"]);
}

#[test]
fn what_an_interrupted_run_asked_is_taken_back() {
    let interrupted = gives_up(&[], Running::interrupt);
    interrupted.ends(1, &["what came back of thesis-twin is merged", "interrupted"]);
}

/// A run that gives up while an executor holds a task. Nothing of it may be left at the scheduler: an
/// executor that comes only then would ask its store for recordings.
fn gives_up(more: &[&str], why: impl Fn(&Running)) -> Ran {
    let (_scheduler, address) = scheduler();
    let (silent, asked) = silent_store();
    let mut holds = executor(&address, &settings(&silent));
    let root = raw();
    let running = run(root.path(), &address, &[&["--raw", URL], more].concat());
    let _open = asked.recv().unwrap();
    why(&running);
    let ran = running.end();
    holds.kill();

    let (silent, asked) = silent_store();
    let _comes = executor_with(&address, &settings(&silent), &["--store-timeout", "1"]);
    // It does the tasks of another run, whose recordings lie in a folder.
    run(root.path(), &address, &[]).end().ends(0, &["13 of 13 jobs came back"]);
    assert!(asked.try_recv().is_err(), "a task of the run that gave up was begun");
    ran
}

#[test]
fn an_object_store_that_does_not_answer_is_named() {
    let (_scheduler, address) = scheduler();
    let root = raw();
    let (silent, _asked) = silent_store();
    let refuses = format!("http://127.0.0.1:{}", free_port());
    let words = [(silent, "2", "no answer within 2 s"), (refuses, "60", "Connection refused")];
    for (endpoint, timeout, why) in words {
        let timeout = ["--store-timeout", timeout];
        let _executor = executor_with(&address, &settings(&endpoint), &timeout);
        let ran = run(root.path(), &address, &["--raw", URL]).end();
        let store = format!("{URL} at {endpoint}");
        ran.ends(1, &["warning: P01.S01.", &store, why, "the executors could make nothing"]);
    }
    // Without a cluster.
    let empty = tempfile::tempdir().unwrap();
    let (silent, _asked) = silent_store();
    let ran = fetch(empty.path(), &silent, &["--store-timeout", "1"]);
    ran.ends(1, &[URL, &silent, "no answer within 1 s"]);
}

#[test]
fn a_part_whose_recordings_do_not_come_is_named_and_the_others_are_made() {
    let (_scheduler, address) = scheduler();
    let root = raw();
    let layout = Layout::new(root.path(), "thesis-twin".parse().unwrap());
    let data = StudyData::load(&layout).unwrap();
    let missing = data.counting().last().unwrap();
    let endpoint = store_without(root.path(), Some(missing.path.to_path_buf()));
    let _executor = executor_with(&address, &settings(&endpoint), &["--store-timeout", "1"]);
    let ran = run(root.path(), &address, &["--raw", URL]).end();
    let file = missing.path.file_name().unwrap().to_str().unwrap();
    ran.ends(
        3,
        &["warning: P01.S01.", file, "no answer within 1 s", "jobs came back and are merged"],
    );
    is_as_without_a_cluster(root.path());
}

#[test]
fn a_task_that_an_executor_cannot_decode_ends_the_run_and_says_what_executors_must_be() {
    let (_scheduler, address) = scheduler();
    let (host, port) = address.split_once(':').unwrap();
    let work = tempfile::tempdir().unwrap();
    // Ballista's own, which does not have our function.
    let config = ExecutorProcessConfig {
        port: free_port(),
        scheduler_host: host.to_owned(),
        scheduler_port: port.parse().unwrap(),
        external_host: Some(host.to_owned()),
        vcores: 1,
        task_scheduling_policy: TaskSchedulingPolicy::PullStaged,
        work_dir: Some(work.path().to_str().unwrap().to_owned()),
        ..ExecutorProcessConfig::default()
    };
    thread::spawn(move || {
        let runtime = tokio::runtime::Runtime::new().unwrap();
        runtime.block_on(start_executor_process(Arc::new(config)))
    });
    let failures = Failures::listen();
    let root = raw();
    let words = ["failed 3 times", "zwidth_part", "must be a `zwidth-cluster executor`"];
    run(root.path(), &address, &["--at-once", "1"]).end().ends(1, &words);
    // The scheduler does not try it again by itself.
    assert_eq!(failures.load(Ordering::SeqCst), 3);
}

/// Counts the tasks that an executor in this process could not begin, by what it logs.
struct Failures(AtomicUsize);

impl Failures {
    fn listen() -> &'static AtomicUsize {
        static LISTENS: Failures = Failures(AtomicUsize::new(0));
        log::set_logger(&LISTENS).unwrap();
        log::set_max_level(LevelFilter::Warn);
        &LISTENS.0
    }
}

impl Log for Failures {
    fn enabled(&self, _: &Metadata) -> bool {
        true
    }

    fn log(&self, record: &Record) {
        if record.args().to_string().contains("Executor failed to run task") {
            self.0.fetch_add(1, Ordering::SeqCst);
        }
    }

    fn flush(&self) {}
}

#[test]
fn recordings_that_are_others_than_the_clients_are_refused_by_their_part() {
    let (_scheduler, address) = scheduler();
    let (root, other) = (raw(), raw());
    let changed = other.path().join("raw/thesis-twin/study.toml");
    let text = fs::read_to_string(&changed).unwrap();
    fs::write(&changed, format!("{text}\n# another\n")).unwrap();
    let _executor = executor(&address, &[]);
    let there = other.path().to_str().unwrap();
    let words = ["P01.S01.", "study.toml is another file", "the executors could make nothing"];
    run(root.path(), &address, &["--raw", there]).end().ends(1, &words);
    let words = ["there is no folder", "/no/such/folder"];
    run(root.path(), &address, &["--raw", "/no/such/folder"]).end().ends(1, &words);
}
