//! Runs a plan, level by level, jobs of a level in parallel.

use crate::change::{Change, changes};
use crate::hashes::{Hashes, shown};
use crate::plan::{levels, wanted};
use crate::provenance::provenance;
use crate::record::Record;
use crate::{Job, Made, Records};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
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

/// Runs the jobs that need it. `records` is updated and written to `records_path` as work proceeds;
/// `done` is called after each job, from any thread. Paths are shown relative to `root`.
///
/// # Errors
/// An output or the records cannot be written; then no further level of jobs is begun. Whatever else goes wrong
/// in a job is in its [`Report`].
pub fn run(
    jobs: &[Job],
    root: &Path,
    records_path: &Path,
    files: &dyn Files,
    options: &Options,
    done: &(dyn Fn(&Report) + Sync),
) -> Result<Vec<Report>, StoreError> {
    let mut records = Records::read(records_path);
    let wanted = wanted(jobs, options.only.as_deref());
    let hashes = Hashes::default();
    let mut failed: BTreeSet<&PathBuf> = BTreeSet::new();
    let mut reports: Vec<Option<Report>> = jobs.iter().map(|_| None).collect();
    for level in levels(jobs) {
        let work: Vec<usize> = level.into_iter().filter(|i| wanted[*i]).collect();
        let results: Vec<Result<(Report, Option<Record>), StoreError>> = work
            .par_iter()
            .map(|i| {
                let before = records.get(&jobs[*i].name);
                let result = one(&jobs[*i], before, root, files, options, &hashes, &failed);
                result.inspect(|(report, _)| done(report))
            })
            .collect();
        let (mut changed, mut disk) = (false, None);
        for (i, result) in work.into_iter().zip(results) {
            let (report, record) = match result {
                Ok(result) => result,
                Err(error) => {
                    disk.get_or_insert(error);
                    continue;
                }
            };
            match (&report.verdict, record) {
                (Verdict::Made(_), Some(record)) => {
                    records.0.insert(jobs[i].name.clone(), record);
                    changed = true;
                }
                (Verdict::Failed(_) | Verdict::Blocked(_), _) => {
                    changed |= records.0.remove(&jobs[i].name).is_some();
                    failed.extend(&jobs[i].outputs);
                    withdraw(&jobs[i], files, options, &hashes);
                }
                _ => {}
            }
            reports[i] = Some(report);
        }
        if let Some(error) = disk {
            // What was made is remembered where there is room for that; the first error is the one to report.
            let _ = records.write(files, records_path);
            return Err(error);
        }
        if changed && !options.dry_run {
            records.write(files, records_path)?;
        }
    }
    if options.only.is_none() && !options.dry_run && remove_unplanned(jobs, &mut records, root, files) {
        records.write(files, records_path)?;
    }
    Ok(reports.into_iter().flatten().collect())
}

fn one(
    job: &Job,
    before: Option<&Record>,
    root: &Path,
    files: &dyn Files,
    options: &Options,
    hashes: &Hashes,
    failed: &BTreeSet<&PathBuf>,
) -> Result<(Report, Option<Record>), StoreError> {
    let report = |verdict, problems| Report { stage: job.stage, name: job.name.clone(), verdict, problems };
    if let Some(input) = job.inputs.iter().find(|i| failed.contains(i) && !job.tolerant) {
        let why = format!("it needs {}, which could not be made", shown(root, input));
        return Ok((report(Verdict::Blocked(why), Vec::new()), None));
    }
    let now = Record::now(job, root, hashes);
    let reason = if options.fresh { Some(Change::Asked) } else { changes(before, &now).into_iter().next() };
    let Some(why) = reason.map(|change| change.to_string()) else {
        let problems = before.map(|b| b.problems.clone()).unwrap_or_default();
        return Ok((report(Verdict::UpToDate, problems), None));
    };
    if options.dry_run {
        hashes.forget(&job.outputs);
        return Ok((report(Verdict::Made(why), Vec::new()), None));
    }
    let mut record = now.with_origin(&job.name);
    Ok(match make(job, &record, files)? {
        Err(error) => (report(Verdict::Failed(error), Vec::new()), None),
        Ok(made) => {
            for (path, bytes) in job.outputs.iter().zip(&made.outputs) {
                let hash = hex_blake3(bytes);
                record.outputs.insert(shown(root, path), hash.clone());
                hashes.set(path, hash);
            }
            record.problems.clone_from(&made.problems);
            (report(Verdict::Made(why), made.problems), Some(record))
        }
    })
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

/// What a failed job made before must not pass for current.
fn withdraw(job: &Job, files: &dyn Files, options: &Options, hashes: &Hashes) {
    if options.dry_run {
        return;
    }
    for path in &job.outputs {
        // A file that is not there is as good as removed.
        let _ = files.remove(path);
        hashes.set(path, String::new());
    }
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
