//! Runs a plan: each job as soon as what it reads is there, as many at a time as there are cores.

use crate::change::{Change, first_change};
use crate::hashes::{Hashes, shown};
use crate::plan::{needs, wanted};
use crate::provenance::provenance;
use crate::record::Record;
use crate::{Job, Made, Records};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;
use zwidth_store::{Files, StoreError, hex_blake3, replace};

/// How to run.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Make everything again.
    pub fresh: bool,
    /// Say what would be made, and why; make nothing.
    pub dry_run: bool,
    /// Only jobs that are called so ([`Job::is_called`]), and what they need.
    pub only: Option<String>,
    /// BLAKE3 of files that were read already, hexadecimal.
    pub known: Vec<(PathBuf, String)>,
}

/// How a job ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing to do.
    UpToDate,
    /// Made (or, in a dry run, to be made); why.
    Made(String),
    /// It failed; why.
    Failed(String),
    /// Passed over, because a job it needs failed.
    Blocked(String),
}

/// How one job ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Report {
    /// The job's stage.
    pub stage: &'static str,
    /// The job's name.
    pub name: String,
    /// How it ended.
    pub verdict: Verdict,
    /// What it left out, now or when it was last made.
    pub problems: Vec<String>,
}

/// Runs the jobs that need it, each as soon as what it reads is there, several at a time. `records` is updated and written
/// to `records_path` as work proceeds; `done` is called after each job, from any thread. Paths are shown relative to
/// `root`.
///
/// # Errors
/// An output or the records cannot be written; then no job is begun that was not ready before. Whatever else goes wrong
/// in a job is in its [`Report`].
pub fn run(
    jobs: &[Job],
    root: &Path,
    records_path: &Path,
    files: &dyn Files,
    options: &Options,
    done: &(dyn Fn(&Report) + Sync),
) -> Result<Vec<Report>, StoreError> {
    let (before, mut board) = rayon::join(|| Records::read(records_path), || Board::new(jobs, options));
    board.records = before.clone();
    let (hashes, board) = (Hashes::new(&options.known), Mutex::new(board));
    let run = Run { jobs, before, root, records_path, files, options, done, hashes, board };
    for begun in [Board::ready, Board::in_a_circle] {
        let begun = begun(&mut run.board());
        rayon::scope_fifo(|scope| begun.into_iter().for_each(|i| run.spawn(scope, i)));
    }
    let Board { mut records, mut unsaved, reports, disk, .. } =
        run.board.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(error) = disk {
        // What was made is remembered where there is room for that; the first error is the one to report.
        let _ = records.write(files, records_path);
        return Err(error);
    }
    if options.only.is_none() && !options.dry_run {
        unsaved |= remove_unplanned(jobs, &mut records, root, files);
    }
    if unsaved && !options.dry_run {
        records.write(files, records_path)?;
    }
    Ok(reports.into_iter().flatten().collect())
}

/// How often records are saved while jobs end, s: a run that is killed makes again what came after.
const SAVED_EVERY_S: f64 = 1.0;

/// How a run stands.
struct Board<'j> {
    records: Records,
    /// Whether these differ from those in their file.
    unsaved: bool,
    saved: Instant,
    /// Outputs that could not be made.
    failed: BTreeSet<&'j PathBuf>,
    reports: Vec<Option<Report>>,
    /// For each job those that read its outputs.
    readers: Vec<Vec<usize>>,
    /// For each job how many others it waits for; `None` once it was begun, or if nobody asked for it.
    waits: Vec<Option<usize>>,
    /// The first output or record that could not be written.
    disk: Option<StoreError>,
}

impl Board<'_> {
    fn new(jobs: &[Job], options: &Options) -> Self {
        let wanted = wanted(jobs, options.only.as_deref());
        let needs = needs(jobs);
        let mut readers = vec![Vec::new(); jobs.len()];
        for i in (0..jobs.len()).filter(|i| wanted[*i]) {
            needs[i].iter().for_each(|maker| readers[*maker].push(i));
        }
        Board {
            records: Records::default(),
            unsaved: false,
            saved: Instant::now(),
            failed: BTreeSet::new(),
            reports: jobs.iter().map(|_| None).collect(),
            readers,
            waits: needs.iter().zip(wanted).map(|(needs, wanted)| wanted.then_some(needs.len())).collect(),
            disk: None,
        }
    }

    /// Jobs that wait for nothing, from now on begun.
    fn ready(&mut self) -> Vec<usize> {
        self.begin(|waits| waits == 0)
    }

    /// Jobs that nothing which is left could make ready: they need each other, or one that does, and fail when they find an
    /// input missing.
    fn in_a_circle(&mut self) -> Vec<usize> {
        if self.disk.is_some() { Vec::new() } else { self.begin(|_| true) }
    }

    fn begin(&mut self, which: impl Fn(usize) -> bool) -> Vec<usize> {
        let found: Vec<usize> =
            (0..self.waits.len()).filter(|i| self.waits[*i].is_some_and(&which)).collect();
        found.iter().for_each(|i| self.waits[*i] = None);
        found
    }

    /// Jobs that waited for this one alone, from now on begun.
    fn freed_by(&mut self, i: usize) -> Vec<usize> {
        if self.disk.is_some() {
            return Vec::new();
        }
        let mut freed = Vec::new();
        for reader in self.readers[i].clone() {
            self.waits[reader] = match self.waits[reader] {
                Some(1) => {
                    freed.push(reader);
                    None
                }
                waits => waits.map(|n| n - 1),
            };
        }
        freed
    }
}

/// What the jobs of a run share.
struct Run<'j, 'a> {
    jobs: &'j [Job<'a>],
    /// The records that the run began with.
    before: Records,
    root: &'j Path,
    records_path: &'j Path,
    files: &'j dyn Files,
    options: &'j Options,
    done: &'j (dyn Fn(&Report) + Sync),
    hashes: Hashes,
    board: Mutex<Board<'j>>,
}

impl<'j> Run<'j, '_> {
    fn board(&self) -> MutexGuard<'_, Board<'j>> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs a job, and then those that it was the last to make ready.
    fn spawn<'s>(&'s self, scope: &rayon::ScopeFifo<'s>, i: usize) {
        scope.spawn_fifo(move |scope| {
            let result = self.one(&self.jobs[i]);
            if let Ok((report, _)) = &result {
                (self.done)(report);
            }
            let mut board = self.board();
            if let Err(error) = result.and_then(|result| self.note(&mut board, i, result)) {
                board.disk.get_or_insert(error);
            }
            let freed = board.freed_by(i);
            drop(board);
            freed.into_iter().for_each(|next| self.spawn(scope, next));
        });
    }

    /// Remembers how a job ended.
    fn note(
        &self,
        board: &mut Board<'j>,
        i: usize,
        (report, record): (Report, Option<Record>),
    ) -> Result<(), StoreError> {
        let job = &self.jobs[i];
        match (&report.verdict, record) {
            (Verdict::Made(_), Some(record)) => {
                board.records.0.insert(job.name.clone(), record);
                board.unsaved = true;
            }
            (Verdict::Failed(_) | Verdict::Blocked(_), _) => {
                board.unsaved |= board.records.0.remove(&job.name).is_some();
                board.failed.extend(&job.outputs);
                self.withdraw(job);
            }
            _ => {}
        }
        board.reports[i] = Some(report);
        if board.unsaved && !self.options.dry_run && board.saved.elapsed().as_secs_f64() >= SAVED_EVERY_S {
            board.records.write(self.files, self.records_path)?;
            (board.unsaved, board.saved) = (false, Instant::now());
        }
        Ok(())
    }

    /// Makes a job if it needs it.
    fn one(&self, job: &Job) -> Result<(Report, Option<Record>), StoreError> {
        let report =
            |verdict, problems| Report { stage: job.stage, name: job.name.clone(), verdict, problems };
        let before = self.before.get(&job.name);
        let failed = |board: &Board| job.inputs.iter().find(|i| board.failed.contains(i)).cloned();
        if let Some(input) = failed(&self.board()).filter(|_| !job.tolerant) {
            let why = format!("it needs {}, which could not be made", shown(self.root, &input));
            return Ok((report(Verdict::Blocked(why), Vec::new()), None));
        }
        let now = Record::now(job, self.root, &self.hashes);
        let outputs = || self.hashes.of(self.root, &job.outputs);
        let reason = match before {
            _ if self.options.fresh => Some(Change::Asked),
            None => Some(Change::NeverMade),
            Some(before) => first_change(before, &now, outputs),
        };
        let Some(why) = reason.map(|change| change.to_string()) else {
            let problems = before.map(|b| b.problems.clone()).unwrap_or_default();
            return Ok((report(Verdict::UpToDate, problems), None));
        };
        if self.options.dry_run {
            self.hashes.forget(&job.outputs);
            return Ok((report(Verdict::Made(why), Vec::new()), None));
        }
        let mut record = now.with_origin(&job.name);
        Ok(match make(job, &record, self.files)? {
            Err(error) => (report(Verdict::Failed(error), Vec::new()), None),
            Ok(made) => {
                for (path, bytes) in job.outputs.iter().zip(&made.outputs) {
                    let hash = hex_blake3(bytes);
                    record.outputs.insert(shown(self.root, path), hash.clone());
                    self.hashes.set(path, hash);
                }
                record.problems.clone_from(&made.problems);
                (report(Verdict::Made(why), made.problems), Some(record))
            }
        })
    }

    /// What a failed job made before must not pass for current.
    fn withdraw(&self, job: &Job) {
        if self.options.dry_run {
            return;
        }
        for path in &job.outputs {
            // A file that is not there is as good as removed.
            let _ = self.files.remove(path);
            self.hashes.set(path, String::new());
        }
    }
}

/// Makes a job's outputs and writes them. The job's own failure is the inner error: the others go on. An output
/// that cannot be written is the outer one: the disk is full or read-only, for the others too.
fn make(job: &Job, record: &Record, files: &dyn Files) -> Result<Result<Made, String>, StoreError> {
    let made = match (job.make)(&provenance(&job.name, record)) {
        Ok(made) => made,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let (n, declared) = (made.outputs.len(), job.outputs.len());
    if n != declared {
        return Ok(Err(format!("it made {n} outputs and declares {declared}")));
    }
    for (path, bytes) in job.outputs.iter().zip(&made.outputs) {
        replace(files, path, bytes)?;
    }
    Ok(Ok(made))
}

/// Removes the outputs and records of jobs that are no longer planned, unless a planned job makes them.
fn remove_unplanned(jobs: &[Job], records: &mut Records, root: &Path, files: &dyn Files) -> bool {
    let names: BTreeSet<&str> = jobs.iter().map(|j| j.name.as_str()).collect();
    let planned: BTreeSet<String> = jobs.iter().flat_map(|j| &j.outputs).map(|o| shown(root, o)).collect();
    let gone: Vec<String> = records.0.keys().filter(|n| !names.contains(n.as_str())).cloned().collect();
    for name in &gone {
        let Some(record) = records.0.remove(name) else { continue };
        for path in record.outputs.keys().filter(|p| !planned.contains(*p)) {
            // A file that is already gone is as good as removed.
            let _ = files.remove(&root.join(path));
        }
    }
    !gone.is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_store::RealFiles;

    /// a.txt → upper (A.txt) → both (with b.txt: AB.txt); b.txt → other (B.txt).
    fn jobs(root: &Path, version: u32) -> Vec<Job<'static>> {
        let job = |stage: &'static str, inputs: &[&str], output: &str, version| {
            let inputs: Vec<PathBuf> = inputs.iter().map(|i| root.join(i)).collect();
            let read = inputs.clone();
            let make: crate::job::Make = Box::new(move |_| {
                let mut text = String::new();
                for path in &read {
                    text += &fs::read_to_string(path)?;
                }
                if text.contains("bad") {
                    return Err("a bad input".into());
                }
                Ok(Made { outputs: vec![text.to_uppercase().into_bytes()], problems: Vec::new() })
            });
            let outputs = vec![root.join(output)];
            let (name, parameters) = (stage.to_owned(), String::new());
            Job { stage, name, version, parameters, inputs, outputs, tolerant: false, make }
        };
        vec![
            job("both", &["A.txt", "b.txt"], "AB.txt", 1),
            job("upper", &["a.txt"], "A.txt", version),
            job("other", &["b.txt"], "B.txt", 1),
        ]
    }

    fn go(root: &Path, version: u32, options: &Options) -> Vec<(&'static str, Verdict)> {
        let records = root.join("records.json");
        let reports = run(&jobs(root, version), root, &records, &RealFiles, options, &|_| {}).unwrap();
        reports.into_iter().map(|r| (r.stage, r.verdict)).collect()
    }

    fn made(results: &[(&'static str, Verdict)]) -> Vec<&'static str> {
        results.iter().filter(|(_, v)| matches!(v, Verdict::Made(_))).map(|(s, _)| *s).collect()
    }

    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.txt"), "a").unwrap();
        fs::write(folder.path().join("b.txt"), "b").unwrap();
        folder
    }

    #[test]
    fn a_second_run_makes_nothing_and_a_changed_file_only_what_depends_on_it() {
        let folder = folder();
        let root = folder.path();
        let plain = Options::default();
        assert_eq!(made(&go(root, 1, &plain)), ["both", "upper", "other"]);
        assert_eq!(fs::read_to_string(root.join("AB.txt")).unwrap(), "AB");
        assert!(made(&go(root, 1, &plain)).is_empty());
        fs::write(root.join("a.txt"), "x").unwrap();
        assert_eq!(made(&go(root, 1, &plain)), ["both", "upper"]);
        fs::write(root.join("a.txt"), "X").unwrap();
        assert_eq!(made(&go(root, 1, &plain)), ["upper"], "the same output stops the chain");
    }

    #[test]
    fn a_new_version_a_missing_and_an_edited_output_are_made_again_and_say_why() {
        let folder = folder();
        let root = folder.path();
        let plain = Options::default();
        go(root, 1, &plain);
        assert_eq!(go(root, 2, &plain)[1].1, Verdict::Made("algorithm version 1 is now 2".to_owned()));
        fs::remove_file(root.join("B.txt")).unwrap();
        assert_eq!(go(root, 2, &plain)[2].1, Verdict::Made("output B.txt is missing".to_owned()));
        fs::write(root.join("B.txt"), "edited").unwrap();
        assert_eq!(go(root, 2, &plain)[2].1, Verdict::Made("output B.txt changed".to_owned()));
        assert_eq!(made(&go(root, 2, &Options { fresh: true, ..plain })).len(), 3);
    }

    /// A job of a stage that writes down its name, and how often it was made.
    fn noted<'a>(
        root: &Path,
        (stage, inputs, output): (&'static str, &[&str], &str),
        made: &'a Mutex<Vec<&'static str>>,
    ) -> Job<'a> {
        let inputs: Vec<PathBuf> = inputs.iter().map(|i| root.join(i)).collect();
        let read = inputs.clone();
        let make: crate::job::Make = Box::new(move |_| {
            made.lock().unwrap().push(stage);
            let texts: Result<Vec<String>, _> = read.iter().map(fs::read_to_string).collect();
            Ok(Made { outputs: vec![texts?.concat().into_bytes()], problems: Vec::new() })
        });
        let outputs = vec![root.join(output)];
        let (name, parameters) = (stage.to_owned(), String::new());
        Job { stage, name, version: 1, parameters, inputs, outputs, tolerant: false, make }
    }

    fn verdicts(root: &Path, jobs: &[Job], options: &Options) -> Vec<Verdict> {
        let records = root.join("records.json");
        let reports = run(jobs, root, &records, &RealFiles, options, &|_| {}).unwrap();
        reports.into_iter().map(|r| r.verdict).collect()
    }

    #[test]
    fn a_job_that_waits_for_two_is_begun_once_after_both() {
        let folder = folder();
        let made = Mutex::new(Vec::new());
        let jobs = [
            ("last", &["left", "right"][..], "last"),
            ("left", &["first"], "left"),
            ("right", &["first", "a.txt"], "right"),
            ("first", &["a.txt"], "first"),
        ];
        let jobs: Vec<Job> = jobs.into_iter().map(|job| noted(folder.path(), job, &made)).collect();
        verdicts(folder.path(), &jobs, &Options::default());
        let made = made.lock().unwrap();
        assert_eq!((made.len(), made[0], made[3]), (4, "first", "last"), "{made:?}");
        assert_eq!(fs::read_to_string(folder.path().join("last")).unwrap(), "aaa");
    }

    #[test]
    fn what_waits_for_a_blocked_job_is_blocked_and_what_waits_for_a_circle_ends_with_it() {
        let folder = folder();
        let made = Mutex::new(Vec::new());
        let chain = [("c", &["b"][..], "c"), ("b", &["a"], "b"), ("a", &["nothing"], "a")];
        let circle = [("x", &["y"][..], "x"), ("y", &["x"], "y"), ("z", &["x"], "z"), ("w", &["a.txt"], "w")];
        let jobs: Vec<Job> =
            chain.into_iter().chain(circle).map(|job| noted(folder.path(), job, &made)).collect();
        let found = verdicts(folder.path(), &jobs, &Options::default());
        assert!(
            matches!(found[..3], [Verdict::Blocked(_), Verdict::Blocked(_), Verdict::Failed(_)]),
            "{found:?}"
        );
        assert!(
            found[3..6].iter().all(|v| matches!(v, Verdict::Blocked(_) | Verdict::Failed(_))),
            "{found:?}"
        );
        assert!(matches!(found[6], Verdict::Made(_)), "{found:?}");
        let only = Options { only: Some("z".to_owned()), ..Options::default() };
        assert_eq!(verdicts(folder.path(), &jobs, &only).len(), 3, "with the circle that it waits for");
    }

    #[test]
    fn the_hash_of_a_file_that_was_read_already_counts() {
        let folder = folder();
        let root = folder.path();
        let hash = |text: &str| hex_blake3(text.as_bytes());
        let knowing =
            |text: &str| Options { known: vec![(root.join("a.txt"), hash(text))], ..Options::default() };
        go(root, 1, &Options::default());
        assert!(made(&go(root, 1, &knowing("a"))).is_empty(), "as it is");
        assert_eq!(made(&go(root, 1, &knowing("as it was a moment ago"))), ["upper"]);
    }

    #[test]
    fn jobs_that_need_each_other_fail_and_the_others_go_on() {
        let folder = folder();
        let mut jobs = jobs(folder.path(), 1);
        jobs[1].inputs.push(folder.path().join("AB.txt"));
        jobs[1].make = Box::new(|_| Err("AB.txt is missing".into()));
        let records = folder.path().join("records.json");
        let reports = run(&jobs, folder.path(), &records, &RealFiles, &Options::default(), &|_| {}).unwrap();
        for report in &reports[..2] {
            // whichever fails first blocks the other
            let ended = matches!(report.verdict, Verdict::Failed(_) | Verdict::Blocked(_));
            assert!(ended, "{report:?}");
        }
        assert!(matches!(reports[2].verdict, Verdict::Made(_)));
    }

    #[test]
    fn a_failed_job_fails_alone_and_what_needs_it_says_so() {
        let folder = folder();
        let root = folder.path();
        fs::write(root.join("a.txt"), "bad").unwrap();
        let results = go(root, 1, &Options::default());
        assert!(matches!(&results[0].1, Verdict::Blocked(why) if why.contains("A.txt")));
        assert_eq!(results[1].1, Verdict::Failed("a bad input".to_owned()));
        assert!(matches!(results[2].1, Verdict::Made(_)));
    }

    #[test]
    fn an_output_that_cannot_be_written_ends_the_run_with_one_error() {
        let folder = folder();
        let root = folder.path();
        fs::create_dir(root.join("A.txt")).unwrap();
        let records = root.join("records.json");
        let run = || run(&jobs(root, 1), root, &records, &RealFiles, &Options::default(), &|_| {});
        assert_eq!(run().unwrap_err().path, root.join("A.txt"));
        assert!(root.join("B.txt").exists() && !root.join("AB.txt").exists());
        fs::remove_dir(root.join("A.txt")).unwrap();
        let made = run().unwrap().into_iter().filter(|r| r.verdict != Verdict::UpToDate).map(|r| r.stage);
        assert_eq!(made.collect::<Vec<_>>(), ["both", "upper"], "what was made before is remembered");
    }

    #[test]
    fn what_a_failed_job_made_before_does_not_stay() {
        let folder = folder();
        let root = folder.path();
        go(root, 1, &Options::default());
        fs::write(root.join("a.txt"), "bad").unwrap();
        go(root, 1, &Options::default());
        assert!(!root.join("A.txt").exists() && !root.join("AB.txt").exists());
        assert!(root.join("B.txt").exists());
    }

    #[test]
    fn a_tolerant_job_is_made_without_the_inputs_that_could_not_be() {
        let folder = folder();
        let root = folder.path();
        fs::write(root.join("a.txt"), "bad").unwrap();
        let mut jobs = jobs(root, 1);
        jobs[0].tolerant = true;
        jobs[0].make = Box::new(|_| Ok(Made { outputs: vec![b"without".to_vec()], problems: Vec::new() }));
        let records = root.join("records.json");
        let reports = run(&jobs, root, &records, &RealFiles, &Options::default(), &|_| {}).unwrap();
        assert!(matches!(reports[0].verdict, Verdict::Made(_)));
    }

    #[test]
    fn a_dry_run_says_what_would_be_made_and_touches_nothing() {
        let folder = folder();
        let root = folder.path();
        let dry = Options { dry_run: true, ..Options::default() };
        assert_eq!(made(&go(root, 1, &dry)).len(), 3);
        assert!(!root.join("A.txt").exists() && !root.join("records.json").exists());
    }

    #[test]
    fn only_makes_a_stage_and_what_it_needs() {
        let folder = folder();
        let only = Options { only: Some("both".to_owned()), ..Options::default() };
        assert_eq!(made(&go(folder.path(), 1, &only)), ["both", "upper"]);
    }

    #[test]
    fn outputs_of_jobs_no_longer_planned_are_removed() {
        let folder = folder();
        let root = folder.path();
        go(root, 1, &Options::default());
        let mut fewer = jobs(root, 1);
        fewer.pop();
        let records = root.join("records.json");
        run(&fewer, root, &records, &RealFiles, &Options::default(), &|_| {}).unwrap();
        assert!(!root.join("B.txt").exists());
        assert!(root.join("AB.txt").exists());
    }
}
