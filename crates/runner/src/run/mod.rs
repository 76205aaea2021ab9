//! Runs a plan: each job as soon as its inputs are there, as many at a time as there are cores; but
//! only one at a time of the jobs with large inputs, so that a run's memory does not grow with the
//! number of cores.

use crate::change::{Change, first_change};
use crate::hashes::{Hashes, show_path};
use crate::plan::needs;
use crate::provenance::{origin, provenance};
use crate::record::Record;
use crate::records::Kept;
use crate::{Job, Made, Making, Output, Provenance, Records, Results, strip_root};
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet, VecDeque};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use zwidth_store::{Lately, Seen, StoreError, hex_blake3};

mod options;
mod unplanned;

pub use options::{Options, wanted};
use options::{records_before, save};
use unplanned::{orphans, outputs, remove_unplanned};

/// How a job ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum JobEnd {
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
    pub verdict: JobEnd,
    /// What it left out, now or when it was last made.
    pub problems: Vec<String>,
    /// What in it is to be read with care, likewise.
    pub care: Vec<String>,
    /// How long it took.
    pub took: Duration,
}

/// The outcome of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Done {
    /// How each job ended.
    pub reports: Vec<Report>,
    /// Faults in the records of earlier runs, and files that were not removed although no job makes
    /// them any more.
    pub remarks: Vec<StoreError>,
}

/// Runs the jobs that need it, each as soon as what it reads is there, several at a time. The
/// records are written as work proceeds; `done` is called after each job, from any thread.
///
/// # Errors
/// Another run, a merge or a shard is at work in the folder. An output or the records cannot be
/// written; then no job is begun that was not ready before. Whatever else goes wrong in a job is in
/// its [`Report`].
pub fn run(
    jobs: &[Job],
    results: &Results,
    options: &Options,
    done: &(dyn Fn(&Report) + Sync),
) -> Result<Done, StoreError> {
    // Before records are read: who writes them meanwhile would have them overwritten.
    let _lock = match (options.dry_run, options.shard) {
        (true, _) => None,
        (false, Some(_)) => results.hold_beside_shards()?,
        (false, None) => results.hold()?,
    };
    let wanted = wanted(jobs, results, options)?;
    let begun = Instant::now();
    let (read, mut board) = rayon::join(
        || records_before(jobs, &wanted, results, options),
        || Board::new(jobs, &wanted, &options.seen),
    );
    let (before, mut remarks) = read?;
    board.records = before.clone();
    // Records that are not believed go from their file too, and a shard that has nothing to make says
    // so in a manifest.
    board.unsaved = !remarks.is_empty() || options.shard.is_some();
    let hashes = Hashes::seen(&options.known, options.seen.clone());
    let board = Mutex::new(board);
    let trials = Lately::seeing(options.seen.clone());
    let planned = outputs(jobs);
    // A first estimate: to save records takes about as long as it took to read them.
    let saved = Mutex::new((Instant::now(), begun.elapsed()));
    let run = Run { jobs, before, results, options, done, hashes, trials, planned, board, saved };
    let ready = run.board().begin(|waits| waits == 0);
    rayon::scope(|scope| run.spawn(scope, ready));
    // What is left needs each other in a circle, or a job that does, and fails when it finds an input
    // missing.
    let mut board = run.board();
    let left = if board.disk.is_some() { Vec::new() } else { board.begin(|_| true) };
    drop(board);
    rayon::scope(|scope| run.spawn(scope, left));
    let before = run.before;
    let planned = run.planned;
    let board = run.board;
    let Board { mut records, mut unsaved, reports, stayed, disk, .. } =
        board.into_inner().unwrap_or_else(PoisonError::into_inner);
    if let Some(error) = disk {
        // What was made is remembered where there is room for that; the first error is the one to
        // report.
        let _ = save(&records, results, options);
        return Err(error);
    }
    remarks.extend(stayed);
    if options.only.is_none() && options.shard.is_none() && !options.dry_run {
        let names: HashSet<&str> = jobs.iter().map(|job| job.name.as_str()).collect();
        let all = records.0.len();
        records.0.retain(|name, _| names.contains(name.as_str()));
        unsaved |= records.0.len() < all;
        // Of jobs that are gone all, of those that failed what they no longer make.
        let others = before.0.keys().filter(|name| !records.0.contains_key(*name));
        let others = others.filter_map(|name| before.get(name));
        remarks.extend(others.flat_map(|record| remove_unplanned(&planned, &record, results)));
        remarks.extend(orphans(&planned, results));
    }
    let (saved, ()) = rayon::join(
        || match unsaved && !options.dry_run {
            true => save(&records, results, options).map(drop),
            false => Ok(()),
        },
        || {
            let is_whole = !options.dry_run && options.shard.is_none();
            if is_whole && options.seen.is_worth_writing() {
                // Without it the next run reads more, and is as right.
                let file = Seen::file(results.layout());
                let _ = results.write_by(&file, |out| options.seen.write(out));
            }
        },
    );
    saved?;
    // Of a large study that takes long, and nobody needs it to be over.
    rayon::spawn(move || drop((records, before)));
    Ok(Done { reports: reports.into_iter().flatten().collect(), remarks })
}

/// The shortest time between two savings of records while jobs end: a run that is killed makes again
/// what came after the last.
const SAVED_EVERY: Duration = Duration::from_secs(1);

/// To save the records of a large study takes long: at most one part in this many of a core's time
/// goes into it.
const PARTS_OF_SAVING: u32 = 30;

/// Whether records are due to be saved, `since` after they were last saved, which `took` as long.
fn is_save_due(since: Duration, took: Duration) -> bool {
    // Those of a thousand participants are 96 MB: saved every second, they took a third of a run.
    since >= SAVED_EVERY.max(took * PARTS_OF_SAVING)
}

/// A job whose input files have more bytes than this reads much (8 MiB): as numbers in memory, or as
/// text, they are some five to ten times as many.
const MUCH: u64 = 1 << 23;

/// Whether a job reads much, as far as its inputs exist.
fn reads_much(job: &Job, seen: &Seen) -> bool {
    let bytes = job.inputs().into_iter().map(|path| {
        seen.length(&path)
            .unwrap_or_else(|| std::fs::metadata(&path).map_or(0, |metadata| metadata.len()))
    });
    // Tables of 36,000 trials that were written as text side by side were the most that a run held.
    bytes.sum::<u64>() > MUCH
}

/// How a run stands.
struct Board<'j> {
    jobs: &'j [Job],
    seen: &'j Seen,
    records: Records,
    /// Whether these differ from those in their file.
    unsaved: bool,
    /// Outputs that could not be made.
    failed: BTreeSet<&'j PathBuf>,
    reports: Vec<Option<Report>>,
    /// For each job those that read its outputs.
    readers: Vec<Vec<usize>>,
    /// For each job how many others it waits for; `None` once it was begun, or if it is not wanted.
    waits: Vec<Option<usize>>,
    /// Those that wait for nothing but a core, and before each whether it reads little.
    ready: BTreeSet<(bool, usize)>,
    /// Those that are being made.
    at_work: BTreeSet<usize>,
    /// Which jobs read much: of those that wait for others it is known when these have ended.
    large: Vec<bool>,
    /// Whether one of these runs.
    large_runs: bool,
    /// Those of them that are ready and wait for it to end.
    held: VecDeque<usize>,
    /// Outputs of failed jobs that could not be removed.
    stayed: Vec<StoreError>,
    /// The first output or record that could not be written.
    disk: Option<StoreError>,
}

impl<'j> Board<'j> {
    fn new(jobs: &'j [Job], wanted: &[bool], seen: &'j Seen) -> Self {
        let needs = needs(jobs, wanted);
        // A job that is not wanted is not waited for: its outputs are taken as they lie.
        let waits = needs.iter().zip(wanted).map(|(makers, is_wanted)| {
            is_wanted.then(|| makers.iter().filter(|maker| wanted[**maker]).count())
        });
        let waits = waits.collect();
        let mut readers = vec![Vec::new(); jobs.len()];
        for (i, makers) in needs.iter().enumerate() {
            makers.iter().for_each(|maker| readers[*maker].push(i));
        }
        Board {
            jobs,
            seen,
            records: Records::default(),
            unsaved: false,
            failed: BTreeSet::new(),
            reports: jobs.iter().map(|_| None).collect(),
            readers,
            waits,
            ready: BTreeSet::new(),
            at_work: BTreeSet::new(),
            large: jobs
                .par_iter()
                .zip(wanted)
                .map(|(job, wanted)| *wanted && reads_much(job, seen))
                .collect(),
            large_runs: false,
            held: VecDeque::new(),
            stayed: Vec::new(),
            disk: None,
        }
    }

    /// The job to begin next: of those that are ready, the first of whose part no other is at work. A
    /// job that comes after another of its part finds the trials read; beside it, it would read them
    /// once more.
    fn next(&mut self) -> Option<usize> {
        let jobs = self.jobs;
        // The stage of metrics takes a fifth less by that.
        let apart = self.ready.iter().find(|(_, i)| {
            jobs[*i].part.is_none()
                || self.at_work.iter().all(|at_work| jobs[*at_work].part != jobs[*i].part)
        });
        let next = *apart.or_else(|| self.ready.first())?;
        self.ready.remove(&next);
        self.at_work.insert(next.1);
        Some(next.1)
    }

    /// Those of these jobs that may run now. If a job that reads much runs, others that do wait for it.
    fn admit(&mut self, ready: Vec<usize>) -> Vec<usize> {
        let mut now = Vec::new();
        for i in ready {
            if self.large[i] && self.large_runs {
                self.held.push_back(i);
            } else {
                self.large_runs |= self.large[i];
                now.push(i);
            }
        }
        now
    }

    /// Jobs that may run once this one has ended: of those that read much the next, and those that
    /// waited for this one alone, from now on begun.
    fn after(&mut self, i: usize) -> Vec<usize> {
        self.at_work.remove(&i);
        let mut next = Vec::new();
        if self.large[i] {
            self.large_runs = false;
            next.extend(self.held.pop_front().filter(|_| self.disk.is_none()));
        }
        if self.disk.is_none() {
            for reader in self.readers[i].clone() {
                self.waits[reader] = self.waits[reader].and_then(|n| n.checked_sub(1));
                if self.waits[reader] == Some(0) {
                    self.waits[reader] = None;
                    // Only now are its inputs as long as they will be.
                    self.large[reader] = reads_much(&self.jobs[reader], self.seen);
                    next.push(reader);
                }
            }
        }
        self.admit(next)
    }

    /// Begins the jobs that wait for such a number of others, and returns those that may run now.
    fn begin(&mut self, is_such: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut begun = Vec::new();
        for (i, waits) in self.waits.iter_mut().enumerate() {
            if waits.take_if(|waits| is_such(*waits)).is_some() {
                begun.push(i);
            }
        }
        self.admit(begun)
    }
}

/// The outcome of a job.
struct Ended {
    report: Report,
    /// Its record, if that is another than before.
    record: Option<Record>,
    /// What it made before, makes no more, and could not be removed.
    stayed: Vec<StoreError>,
}

/// What the jobs of a run share.
struct Run<'j> {
    jobs: &'j [Job],
    /// The records that the run began with.
    before: Records,
    results: &'j Results<'j>,
    options: &'j Options,
    done: &'j (dyn Fn(&Report) + Sync),
    hashes: Hashes,
    trials: Lately,
    /// What all jobs of the plan make.
    planned: HashSet<&'j PathBuf>,
    board: Mutex<Board<'j>>,
    /// When records were last saved, and how long it took; locked while they are.
    saved: Mutex<(Instant, Duration)>,
}

impl<'j> Run<'j> {
    fn board(&self) -> MutexGuard<'_, Board<'j>> {
        self.board.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs jobs that are ready, and then those that each was the last to make ready. Of all that are
    /// ready those that read much begin first, because they run one at a time and all others can run
    /// beside them; then the one that is planned first, for jobs that look at the same are planned
    /// together.
    fn spawn<'s>(&'s self, scope: &rayon::Scope<'s>, ready: Vec<usize>) {
        let mut board = self.board();
        for i in ready {
            // `false` sorts first: with large ones begun first a thousand participants take 7½ minutes
            // instead of 9.
            let is_small = !board.large[i];
            board.ready.insert((is_small, i));
            scope.spawn(move |scope| {
                let Some(i) = self.board().next() else { return };
                let begun = Instant::now();
                let mut result = self.run_job(&self.jobs[i]);
                if let Ok(ended) = &mut result {
                    ended.report.took = begun.elapsed();
                    // Before the board is locked: whoever listens may take long.
                    (self.done)(&ended.report);
                }
                let mut board = self.board();
                match result {
                    Ok(ended) => self.note(&mut board, i, ended),
                    Err(error) => _ = board.disk.get_or_insert(error),
                }
                let next = board.after(i);
                drop(board);
                self.spawn(scope, next);
                if let Err(error) = self.save_when_due() {
                    self.board().disk.get_or_insert(error);
                }
            });
        }
    }

    /// Remembers how a job ended.
    fn note(&self, board: &mut Board<'j>, i: usize, Ended { report, record, stayed }: Ended) {
        let job = &self.jobs[i];
        board.stayed.extend(stayed);
        match (&report.verdict, record) {
            (JobEnd::Made(_) | JobEnd::UpToDate, Some(record)) => {
                board.records.0.insert(job.name.clone(), Kept::here(record));
                board.unsaved = true;
            }
            (JobEnd::Failed(_) | JobEnd::Blocked(_), _) => {
                board.unsaved |= board.records.0.remove(&job.name).is_some();
                board.failed.extend(&job.outputs);
                // What it made before must not pass for current.
                for path in job.outputs.iter().filter(|_| !self.options.dry_run) {
                    self.hashes.set(path, "");
                    board.stayed.extend(self.results.remove(path).err());
                }
            }
            _ => {}
        }
        board.reports[i] = Some(report);
    }

    /// Saves the records of the jobs that have ended, unless they were a moment ago or are being saved.
    /// Other jobs go on meanwhile.
    fn save_when_due(&self) -> Result<(), StoreError> {
        // Locked already: another thread saves them, and this one need not wait for that.
        let Ok(mut saved) = self.saved.try_lock() else { return Ok(()) };
        if self.options.dry_run || !is_save_due(saved.0.elapsed(), saved.1) {
            return Ok(());
        }
        let records = {
            let mut board = self.board();
            if !std::mem::take(&mut board.unsaved) {
                return Ok(());
            }
            board.records.clone()
        };
        let begun = Instant::now();
        let written = save(&records, self.results, self.options)?;
        self.board().records.settle(&records, written);
        *saved = (Instant::now(), begun.elapsed());
        Ok(())
    }

    /// Makes a job if it needs it.
    fn run_job(&self, job: &Job) -> Result<Ended, StoreError> {
        let ended = |verdict| Ended {
            report: Report {
                stage: job.stage.name,
                name: job.name.clone(),
                verdict,
                problems: Vec::new(),
                care: Vec::new(),
                took: Duration::ZERO,
            },
            record: None,
            stayed: Vec::new(),
        };
        let root = self.results.root();
        let before = self.before.get(&job.name);
        // The first of its inputs that could not be made. Most runs have none: then they are not listed.
        let failed = {
            let board = self.board();
            let inputs = if board.failed.is_empty() { Vec::new() } else { job.inputs() };
            inputs.into_iter().find(|input| board.failed.contains(input))
        };
        if let Some(input) = failed.filter(|_| !job.tolerant) {
            let why = format!("it needs {}, which could not be made", show_path(root, &input));
            return Ok(ended(JobEnd::Blocked(why)));
        }
        let now = Record::now(job, root, &self.hashes);
        let reason = match &before {
            _ if self.options.fresh => Some(Change::Asked),
            None => Some(Change::NeverMade),
            Some(before) => first_change(before, &now, || self.hashes.of(root, &job.outputs)),
        };
        let Some(why) = reason.map(|change| change.to_string()) else {
            let before = before.map(Arc::unwrap_or_clone).unwrap_or_default();
            let mut ended = ended(JobEnd::UpToDate);
            ended.report.problems.clone_from(&before.problems);
            ended.report.care.clone_from(&before.care);
            // No reason to make it again, but `trace` should name the files of this run.
            let moved = before.origins != now.origins;
            ended.record = moved.then_some(Record { origins: now.origins, ..before });
            return Ok(ended);
        };
        if self.options.dry_run {
            self.hashes.forget(&job.outputs);
            return Ok(ended(JobEnd::Made(why)));
        }
        let mut record = now;
        record.origin = origin(&job.name, &record);
        let from = match self.options.without_origin {
            true => Provenance::new(),
            false => provenance(&job.name, &record),
        };
        let making = Making {
            from: &from,
            outputs: &job.outputs,
            root,
            trials: &self.trials,
            scripts: &self.options.scripts,
        };
        let (Made { mut problems, mut care, .. }, hashes) = match make(job, &making, self.results)?
        {
            Ok(result) => result,
            Err(error) => return Ok(ended(JobEnd::Failed(error))),
        };
        for text in problems.iter_mut().chain(&mut care) {
            *text = strip_root(root, text);
        }
        for (path, hash) in job.outputs.iter().zip(hashes) {
            self.hashes.written(path, &hash);
            record.outputs.insert(show_path(root, path), hash);
        }
        record.problems.clone_from(&problems);
        record.care.clone_from(&care);
        let mut ended = ended(JobEnd::Made(why));
        ended.report.problems = problems;
        ended.report.care = care;
        ended.record = Some(record);
        if let Some(before) = before {
            // Now: once its record is saved nobody knows that it made them.
            ended.stayed = remove_unplanned(&self.planned, &before, self.results);
        }
        Ok(ended)
    }
}

/// Makes a job's outputs and writes them; returns what else it made, and the hash of each output. The
/// job's own failure is the inner error: the others go on. An output that cannot be written is the
/// outer one: the disk is full or read-only, for the others too.
fn make(
    job: &Job,
    making: &Making,
    results: &Results,
) -> Result<Result<(Made, Vec<String>), String>, StoreError> {
    let mut result = match job.make(making) {
        Ok(result) => result,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let n = result.outputs.len();
    let declared = job.outputs.len();
    if n != declared {
        return Ok(Err(format!("it made {n} outputs and declares {declared}")));
    }
    let mut hashes = Vec::new();
    for (path, output) in job.outputs.iter().zip(std::mem::take(&mut result.outputs)) {
        hashes.push(match output {
            Output::Whole(bytes) => {
                results.write(path, &bytes)?;
                hex_blake3(&bytes)
            }
            Output::Long(write) => match results.write_by(path, write)? {
                Ok(hash) => hash,
                Err(error) => return Ok(Err(error.to_string())),
            },
        });
    }
    Ok(Ok((result, hashes)))
}

#[cfg(test)]
mod tests;
