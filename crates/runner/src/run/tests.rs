use super::*;
use crate::Stage;
use std::fs;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use zwidth_store::{Layout, RealFiles};

/// a.txt → upper (A.txt) → both (with b.txt: AB.txt); b.txt → other (B.txt).
fn jobs(root: &Path, version: u32) -> Vec<Job> {
    let job = |name: &'static str, inputs: &[&str], output: &str, version| {
        let inputs: Vec<PathBuf> = inputs.iter().map(|i| root.join(i)).collect();
        let (stage, outputs) = (Stage { name, version }, vec![root.join(output)]);
        Job::new(stage, name, (), inputs, outputs, |(), inputs, _| {
            let texts = inputs.iter().map(fs::read_to_string).collect::<Result<Vec<_>, _>>()?;
            let text = texts.concat();
            if text.contains("bad") {
                return Err("a bad input".into());
            }
            Ok(Made::of(vec![text.to_uppercase().into_bytes()]))
        })
    };
    vec![
        job("both", &["A.txt", "b.txt"], "AB.txt", 1),
        job("upper", &["a.txt"], "A.txt", version),
        job("other", &["b.txt"], "B.txt", 1),
    ]
}

fn go(root: &Path, version: u32, options: &Options) -> Vec<(&'static str, JobEnd)> {
    let reports = reports(root, &jobs(root, version), options).unwrap();
    reports.into_iter().map(|r| (r.stage, r.verdict)).collect()
}

fn made(results: &[(&'static str, JobEnd)]) -> Vec<&'static str> {
    results.iter().filter(|(_, v)| matches!(v, JobEnd::Made(_))).map(|(s, _)| *s).collect()
}

/// `derived/s` of a folder of its own, in which the inputs lie too.
struct Folder {
    _root: TempDir,
    path: PathBuf,
}

impl std::ops::Deref for Folder {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.path
    }
}

fn folder() -> Folder {
    let root = tempfile::tempdir().unwrap();
    let path = root.path().join("derived/s");
    fs::create_dir_all(&path).unwrap();
    fs::write(path.join("a.txt"), "a").unwrap();
    fs::write(path.join("b.txt"), "b").unwrap();
    Folder { _root: root, path }
}

fn done(root: &Path, jobs: &[Job], options: &Options) -> Result<Done, StoreError> {
    let layout = Layout::new(root.ancestors().nth(2).unwrap(), "s".parse().unwrap());
    run(jobs, &Results::new(&layout, &RealFiles), options, &|_| {})
}

fn reports(root: &Path, jobs: &[Job], options: &Options) -> Result<Vec<Report>, StoreError> {
    done(root, jobs, options).map(|done| done.reports)
}

#[test]
fn a_second_run_makes_nothing_and_a_changed_file_only_what_depends_on_it() {
    let root = folder();
    let plain = Options::default();
    assert_eq!(made(&go(&root, 1, &plain)), ["both", "upper", "other"]);
    assert_eq!(fs::read_to_string(root.join("AB.txt")).unwrap(), "AB");
    assert!(made(&go(&root, 1, &plain)).is_empty());
    fs::write(root.join("a.txt"), "x").unwrap();
    assert_eq!(made(&go(&root, 1, &plain)), ["both", "upper"]);
    fs::write(root.join("a.txt"), "X").unwrap();
    assert_eq!(made(&go(&root, 1, &plain)), ["upper"], "the same output stops the chain");
}

#[test]
fn a_new_version_a_missing_and_an_edited_output_are_made_again_and_say_why() {
    let root = folder();
    let plain = Options::default();
    go(&root, 1, &plain);
    assert_eq!(go(&root, 2, &plain)[1].1, JobEnd::Made("algorithm version 1 is now 2".to_owned()));
    fs::remove_file(root.join("B.txt")).unwrap();
    assert_eq!(
        go(&root, 2, &plain)[2].1,
        JobEnd::Made("output derived/s/B.txt is missing".to_owned())
    );
    fs::write(root.join("B.txt"), "edited").unwrap();
    assert_eq!(
        go(&root, 2, &plain)[2].1,
        JobEnd::Made("output derived/s/B.txt changed".to_owned())
    );
    assert_eq!(made(&go(&root, 2, &Options { fresh: true, ..plain })).len(), 3);
}

/// The names of jobs that were made.
type Names = Arc<Mutex<Vec<&'static str>>>;

#[derive(serde::Serialize)]
struct Noted {
    name: &'static str,
    #[serde(skip)]
    made: Names,
}

/// A job of a stage that writes down its name, and how often it was made.
fn noted(root: &Path, (name, inputs, output): (&'static str, &[&str], &str), made: &Names) -> Job {
    let inputs: Vec<PathBuf> = inputs.iter().map(|i| root.join(i)).collect();
    let (stage, outputs) = (Stage { name, version: 1 }, vec![root.join(output)]);
    let parameters = Noted { name, made: made.clone() };
    Job::new(stage, name, parameters, inputs, outputs, |noted, inputs, _| {
        noted.made.lock().unwrap().push(noted.name);
        let texts: Result<Vec<String>, _> = inputs.iter().map(fs::read_to_string).collect();
        Ok(Made::of(vec![texts?.concat().into_bytes()]))
    })
}

fn verdicts(root: &Path, jobs: &[Job], options: &Options) -> Vec<JobEnd> {
    reports(root, jobs, options).unwrap().into_iter().map(|r| r.verdict).collect()
}

#[test]
fn a_job_that_waits_for_two_is_begun_once_after_both() {
    let folder = folder();
    let made = Arc::new(Mutex::new(Vec::new()));
    let jobs = [
        ("last", &["left", "right"][..], "last"),
        ("left", &["first"], "left"),
        ("right", &["first", "a.txt"], "right"),
        ("first", &["a.txt"], "first"),
    ];
    let jobs: Vec<Job> = jobs.into_iter().map(|job| noted(&folder, job, &made)).collect();
    verdicts(&folder, &jobs, &Options::default());
    let made = made.lock().unwrap();
    assert_eq!((made.len(), made[0], made[3]), (4, "first", "last"), "{made:?}");
    assert_eq!(fs::read_to_string(folder.join("last")).unwrap(), "aaa");
}

#[test]
fn what_waits_for_a_blocked_job_is_blocked_and_what_waits_for_a_circle_ends_with_it() {
    let folder = folder();
    let made = Arc::new(Mutex::new(Vec::new()));
    let chain = [("c", &["b"][..], "c"), ("b", &["a"], "b"), ("a", &["nothing"], "a")];
    let circle =
        [("x", &["y"][..], "x"), ("y", &["x"], "y"), ("z", &["x"], "z"), ("w", &["a.txt"], "w")];
    let jobs: Vec<Job> =
        chain.into_iter().chain(circle).map(|job| noted(&folder, job, &made)).collect();
    let found = verdicts(&folder, &jobs, &Options::default());
    assert!(
        matches!(found[..3], [JobEnd::Blocked(_), JobEnd::Blocked(_), JobEnd::Failed(_)]),
        "{found:?}"
    );
    assert!(
        found[3..6].iter().all(|v| matches!(v, JobEnd::Blocked(_) | JobEnd::Failed(_))),
        "{found:?}"
    );
    assert!(matches!(found[6], JobEnd::Made(_)), "{found:?}");
    let only = Options { only: Some("z".to_owned()), ..Options::default() };
    assert_eq!(verdicts(&folder, &jobs, &only).len(), 3, "with the circle that it waits for");
}

#[test]
fn the_hash_of_a_file_that_was_read_already_counts() {
    let root = folder();
    let hash = |text: &str| hex_blake3(text.as_bytes());
    let knowing = |text: &str| Options {
        known: [(root.join("a.txt"), hash(text))].into_iter().collect(),
        ..Options::default()
    };
    go(&root, 1, &Options::default());
    assert!(made(&go(&root, 1, &knowing("a"))).is_empty(), "as it is");
    assert_eq!(made(&go(&root, 1, &knowing("as it was a moment ago"))), ["upper"]);
}

#[test]
fn a_failed_job_fails_alone_what_needs_it_says_so_and_what_they_made_before_does_not_stay() {
    let root = folder();
    fs::write(root.join("a.txt"), "bad").unwrap();
    let results = go(&root, 1, &Options::default());
    assert!(matches!(&results[0].1, JobEnd::Blocked(why) if why.contains("A.txt")));
    assert_eq!(results[1].1, JobEnd::Failed("a bad input".to_owned()));
    assert!(matches!(results[2].1, JobEnd::Made(_)));
    fs::write(root.join("a.txt"), "a").unwrap();
    go(&root, 1, &Options::default());
    assert!(root.join("A.txt").exists() && root.join("AB.txt").exists());
    fs::write(root.join("a.txt"), "bad").unwrap();
    go(&root, 1, &Options::default());
    assert!(!root.join("A.txt").exists() && !root.join("AB.txt").exists());
    assert!(root.join("B.txt").exists());
}

#[test]
fn an_output_that_cannot_be_written_ends_the_run_with_one_error() {
    let root = folder();
    fs::create_dir(root.join("A.txt")).unwrap();
    let run = || reports(&root, &jobs(&root, 1), &Options::default());
    assert_eq!(run().unwrap_err().path, root.join("A.txt"));
    assert!(root.join("B.txt").exists() && !root.join("AB.txt").exists());
    fs::remove_dir(root.join("A.txt")).unwrap();
    let made =
        run().unwrap().into_iter().filter(|r| r.verdict != JobEnd::UpToDate).map(|r| r.stage);
    assert_eq!(made.collect::<Vec<_>>(), ["both", "upper"], "what was made before is remembered");
}

#[test]
fn a_tolerant_job_is_made_without_the_inputs_that_could_not_be() {
    let root = folder();
    fs::write(root.join("a.txt"), "bad").unwrap();
    let mut jobs = jobs(&root, 1);
    let Job { stage, name, outputs, .. } = jobs.remove(0);
    let inputs = vec![root.join("A.txt"), root.join("b.txt")];
    let job = Job::new(stage, name, (), inputs, outputs, |(), _, _| {
        Ok(Made::of(vec![b"without".to_vec()]))
    });
    jobs.insert(0, job.tolerant());
    let reports = reports(&root, &jobs, &Options::default()).unwrap();
    assert!(matches!(reports[0].verdict, JobEnd::Made(_)));
}

#[test]
fn a_dry_run_says_what_would_be_made_and_touches_nothing() {
    let root = folder();
    let dry = Options { dry_run: true, ..Options::default() };
    assert_eq!(made(&go(&root, 1, &dry)).len(), 3);
    assert!(!root.join("A.txt").exists() && !root.join("records.json").exists());
}

#[test]
fn only_makes_a_stage_and_what_it_needs() {
    let folder = folder();
    let only = Options { only: Some("both".to_owned()), ..Options::default() };
    assert_eq!(made(&go(&folder, 1, &only)), ["both", "upper"]);
}

#[test]
fn outputs_of_jobs_no_longer_planned_are_removed_unless_they_were_changed_by_hand() {
    let root = folder();
    go(&root, 1, &Options::default());
    let mut fewer = jobs(&root, 1);
    fewer.pop();
    let remarks = || done(&root, &fewer, &Options::default()).unwrap().remarks;
    assert!(remarks().is_empty());
    assert!(!root.join("B.txt").exists());
    assert!(root.join("AB.txt").exists());
    go(&root, 1, &Options::default());
    fs::write(root.join("B.txt"), "edited").unwrap();
    assert_eq!(remarks()[0].path, root.join("B.txt"));
    assert_eq!(fs::read_to_string(root.join("B.txt")).unwrap(), "edited");
    assert!(remarks().is_empty(), "told once, then forgotten");
}

#[test]
fn what_is_to_be_read_with_care_is_remembered_and_told_at_every_run() {
    let root = folder();
    let mut jobs = jobs(&root, 1);
    let Job { stage, name, outputs, .. } = jobs.remove(2);
    jobs.push(Job::new(stage, name, (), root.join("b.txt"), outputs, |(), _, _| {
        let care = vec!["b is strange".to_owned()];
        Ok(Made { care, ..Made::of(vec![b"B".to_vec()]) })
    }));
    for _ in 0..2 {
        assert_eq!(reports(&root, &jobs, &Options::default()).unwrap()[2].care, ["b is strange"]);
    }
}

#[test]
fn a_job_whose_output_is_no_result_of_the_study_writes_nothing() {
    let root = folder();
    let mut jobs = jobs(&root, 1);
    jobs[2].outputs = vec![root.join("../t/B.txt")];
    let error = reports(&root, &jobs, &Options::default()).unwrap_err();
    assert!(error.what.contains("not a result of the study"), "{error}");
    assert!(!root.join("../t").exists());
}

#[test]
fn a_file_that_only_parameters_come_from_is_traced_and_remakes_nothing() {
    let root = folder();
    let stage = Stage { name: "tally", version: 1 };
    let job = |answer: u8| {
        let job =
            Job::new(stage, "tally", answer, (), vec![root.join("tally")], |answer, (), _| {
                Ok(Made::of(vec![answer.to_string().into_bytes()]))
            });
        [job.told_by(vec![root.join("a.txt").into()])]
    };
    let origin = || {
        let layout = Layout::new(root.ancestors().nth(2).unwrap(), "s".parse().unwrap());
        let (records, _) = Records::read(&Results::new(&layout, &RealFiles)).unwrap();
        crate::trace(&records, "tally").unwrap().sources
    };
    let plain = Options::default();
    assert!(matches!(verdicts(&root, &job(4), &plain)[0], JobEnd::Made(_)));
    let before = origin();
    assert_eq!(before[0].path, "derived/s/a.txt");
    fs::write(root.join("a.txt"), "changed").unwrap();
    assert_eq!(verdicts(&root, &job(4), &plain), [JobEnd::UpToDate]);
    assert_ne!(origin(), before, "the trace tells the file as it is");
    let parameters = JobEnd::Made("1 of its parameters changed".to_owned());
    assert_eq!(verdicts(&root, &job(5), &plain), [parameters]);
}

#[test]
fn without_origin_outputs_are_told_nothing_of_their_making() {
    let folder = folder();
    let stage = Stage { name: "said", version: 1 };
    let output = folder.join("said");
    let jobs = [Job::new(stage, "said", (), (), vec![output.clone()], |(), (), making| {
        let said = serde_json::to_vec(making.from)?;
        Ok(Made::of(vec![said]))
    })];
    verdicts(&folder, &jobs, &Options { without_origin: true, ..Options::default() });
    assert_eq!(fs::read_to_string(&output).unwrap(), "{}");
    verdicts(&folder, &jobs, &Options { fresh: true, ..Options::default() });
    assert!(fs::read_to_string(&output).unwrap().contains("\"origin\":\"zwidth:said:1:"));
}

/// Makes a file of so many lines part by part, and fails where it is asked for none.
fn long(lines: &usize, output: PathBuf) -> Job {
    let stage = Stage { name: "long", version: 1 };
    Job::new(stage, "long", *lines, (), vec![output], |lines, (), _| {
        let lines = *lines;
        let write: crate::WriteLong = Box::new(move |out| {
            (0..lines).try_for_each(|line| writeln!(out, "{line}"))?;
            if lines == 0 { Err("there is no line".into()) } else { Ok(()) }
        });
        Ok(Made { outputs: vec![Output::Long(write)], ..Made::default() })
    })
}

#[test]
fn a_file_written_in_parts_is_one_like_any_other() {
    let folder = folder();
    let output = folder.join("long");
    let plain = Options::default();
    let made = |lines| verdicts(&folder, &[long(&lines, output.clone())], &plain)[0].clone();
    assert_eq!(made(3), JobEnd::Made("never made".to_owned()));
    assert_eq!(fs::read_to_string(&output).unwrap(), "0\n1\n2\n");
    assert_eq!(made(3), JobEnd::UpToDate);
    fs::write(&output, "0\n").unwrap();
    assert_eq!(made(3), JobEnd::Made("output derived/s/long changed".to_owned()));
    // What was made before must not pass for current.
    assert_eq!(made(0), JobEnd::Failed("there is no line".to_owned()));
    assert!(fs::read_dir(&*folder).unwrap().all(|f| !f.unwrap().path().ends_with("long")));
}

#[test]
fn a_long_file_that_cannot_be_written_ends_the_run() {
    let folder = folder();
    let job = long(&3, folder.join("a.txt/long"));
    let error = done(&folder, &[job], &Options::default()).unwrap_err();
    assert!(error.path.ends_with("a.txt"), "{error}");
}

/// A job that makes files of these names.
fn several(root: &Path, names: &[&str]) -> Job {
    let outputs = names.iter().map(|name| root.join(name)).collect();
    let stage = Stage { name: "tally", version: 1 };
    Job::new(stage, "tally", names.len(), (), outputs, |n, (), _| {
        Ok(Made::of(vec![b"made".to_vec(); *n]))
    })
}

#[test]
fn an_output_that_a_job_no_longer_makes_goes() {
    let folder = folder();
    let job = |names: &[&str]| [several(&folder, names)];
    let there = |name: &str| folder.join(name).exists();
    verdicts(&folder, &job(&["modes", "weight"]), &Options::default());
    assert!(there("modes") && there("weight"));
    let one = Options { only: Some("modes".to_owned()), ..Options::default() };
    verdicts(&folder, &job(&["modes"]), &Options::default());
    assert!(there("modes") && !there("weight"), "no table of weights without masses");
    verdicts(&folder, &job(&["modes"]), &one);
    assert!(there("modes"));
}

/// Else a run that is killed after it saved its records leaves it for good.
#[test]
fn what_a_job_no_longer_makes_goes_when_the_job_is_made_and_not_at_the_end_of_a_whole_run() {
    let root = folder();
    let job = |names: &[&str]| several(&root, names);
    let mut all = jobs(&root, 1);
    all.push(job(&["likert", "blinding", "moved"]));
    done(&root, &all, &Options::default()).unwrap();
    all.pop();
    all.push(job(&["likert"]));
    // What another job makes now is that one's.
    let moved = vec![root.join("moved")];
    all.push(Job::new(Stage { name: "other", version: 1 }, "moved", (), (), moved, |(), (), _| {
        Ok(Made::of(vec![b"moved".to_vec()]))
    }));
    let only = Options { only: Some("tally".to_owned()), ..Options::default() };
    done(&root, &all, &only).unwrap();
    let there = ["likert", "blinding", "moved"].map(|name| root.join(name).exists());
    assert_eq!(there, [true, false, true]);
}

#[test]
fn a_table_of_ours_that_no_record_names_is_told_and_stays_and_others_are_not_looked_at() {
    let root = folder();
    let origin = format!("zwidth:metrics:1:{}", hex_blake3(b"x"));
    fs::write(root.join("P03.parquet"), format!("PAR1 {origin} PAR1")).unwrap();
    fs::write(root.join("own.parquet"), "somebody's").unwrap();
    fs::write(root.join("notes.txt"), origin).unwrap();
    let all = jobs(&root, 1);
    let told = |options: &Options| done(&root, &all, options).unwrap().remarks;
    let remarks = told(&Options::default());
    assert_eq!(remarks.iter().map(|r| &r.path).collect::<Vec<_>>(), [&root.join("P03.parquet")]);
    assert!(root.join("P03.parquet").exists());
    assert!(told(&Options { only: Some("both".to_owned()), ..Options::default() }).is_empty());
}

/// What a run begins with must be what it writes over.
#[test]
fn two_runs_of_a_study_do_not_go_on_beside_each_other() {
    let root = folder();
    let layout = Layout::new(root.ancestors().nth(2).unwrap(), "s".parse().unwrap());
    let results = Results::new(&layout, &RealFiles);
    let [alone, shard] =
        [None, Some("1/2".parse().unwrap())].map(|shard| Options { shard, ..Options::default() });
    let refused =
        |options: &Options| done(&root, &jobs(&root, 1), options).unwrap_err().to_string();
    let other = results.hold_alone().unwrap();
    assert!(refused(&alone).contains("a run, a merge or a shard of the study goes on here"));
    assert!(refused(&shard).contains("a run or a merge of the study goes on here"));
    done(&root, &jobs(&root, 1), &Options { dry_run: true, ..Options::default() }).unwrap();
    drop(other);
    let other = results.hold_beside_shards().unwrap();
    assert!(refused(&alone).contains("a run, a merge or a shard"));
    done(&root, &jobs(&root, 1), &shard).unwrap();
    drop(other);
    assert_eq!(made(&go(&root, 1, &alone)).len(), 3);
}

#[test]
fn problems_are_told_without_the_folder_that_holds_the_data() {
    let folder = folder();
    let output = vec![folder.join("x")];
    let job = Job::new(Stage { name: "x", version: 1 }, "x", (), (), output, |(), (), making| {
        let problems = vec![format!("{}: damaged", making.root.join("raw/s/t.parquet").display())];
        Ok(Made { care: problems.clone(), problems, ..Made::of(vec![b"x".to_vec()]) })
    });
    let reports = reports(&folder, &[job], &Options::default()).unwrap();
    assert_eq!(reports[0].problems, ["raw/s/t.parquet: damaged"]);
    assert_eq!(reports[0].care, reports[0].problems);
}

#[test]
fn of_jobs_that_read_much_one_runs_at_a_time_and_all_are_made() {
    use std::sync::atomic::{AtomicUsize, Ordering};
    static RUNNING: AtomicUsize = AtomicUsize::new(0);
    static MOST: AtomicUsize = AtomicUsize::new(0);
    let folder = folder();
    let [large, made] = ["large.txt", "made.large.txt"].map(|name| folder.join(name));
    // Of its bytes none is on the disk.
    fs::File::create(&large).unwrap().set_len(MUCH + 1).unwrap();
    let makes = Job::new(
        Stage { name: "large", version: 1 },
        "makes",
        (),
        (),
        vec![made.clone()],
        |(), (), _| {
            let bytes = vec![b'x'; usize::try_from(MUCH)? + 1];
            Ok(Made::of(vec![bytes]))
        },
    );
    let job = |i: usize, input: &Path| {
        let stage = Stage { name: "large", version: 1 };
        let output = folder.join(format!("L{i}.txt"));
        let inputs = vec![input.to_owned()];
        Job::new(stage, format!("large {i}"), i, inputs, vec![output], |i, inputs, _| {
            let much = inputs[0].to_string_lossy().ends_with("large.txt");
            let running = if much { RUNNING.fetch_add(1, Ordering::SeqCst) + 1 } else { 0 };
            MOST.fetch_max(running, Ordering::SeqCst);
            for _ in 0..1000 {
                std::thread::yield_now();
            }
            if much {
                RUNNING.fetch_sub(1, Ordering::SeqCst);
            }
            Ok(Made::of(vec![i.to_string().into_bytes()]))
        })
    };
    let small = folder.join("a.txt");
    let read = [&small, &large, &made];
    let jobs: Vec<Job> = (0..12).map(|i| job(i, read[i % 3])).chain([makes]).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    let made = pool.install(|| verdicts(&folder, &jobs, &Options::default()));
    assert!(made.iter().all(|verdict| matches!(verdict, JobEnd::Made(_))) && made.len() == 13);
    assert_eq!(MOST.load(Ordering::SeqCst), 1);
}

#[test]
fn records_are_saved_every_second_and_less_often_where_that_takes_long() {
    let due = |since_ms, took_ms| {
        is_save_due(Duration::from_millis(since_ms), Duration::from_millis(took_ms))
    };
    assert!(!due(999, 0) && due(1000, 0) && due(1000, 20));
    assert!(!due(11_999, 400) && due(12_000, 400), "of 12.4 s, 0.4 s");
}

#[test]
fn of_a_part_one_job_after_the_other_is_made_while_there_are_others() {
    let folder = folder();
    let made = Arc::default();
    let of = |(name, part): (&'static str, Option<&str>)| {
        let job = noted(&folder, (name, &["a.txt"], name), &made);
        part.into_iter().fold(job, Job::of_part)
    };
    let (a, b) = (Some("P01.S01"), Some("P02.S01"));
    let jobs = [("a1", a), ("a2", a), ("b1", b), ("b2", b), ("c1", None), ("c2", None)].map(of);
    let seen = Seen::default();
    let mut board = Board::new(&jobs, &[true; 6], &seen);
    let ready = board.begin(|waits| waits == 0);
    board.ready.extend(ready.into_iter().map(|i| (true, i)));
    let mut next = |ended: &[usize]| {
        ended.iter().for_each(|i| assert!(board.after(*i).is_empty()));
        board.next()
    };
    assert_eq!([next(&[]), next(&[])], [Some(0), Some(2)]);
    assert_eq!(next(&[2]), Some(3), "before another one of the part of the first");
    assert_eq!(
        [next(&[]), next(&[])],
        [Some(4), Some(5)],
        "those of no part are beside each other"
    );
    assert_eq!(next(&[]), Some(1), "nothing else is left");
    assert_eq!(next(&[0, 1, 3, 4, 5]), None);
}
