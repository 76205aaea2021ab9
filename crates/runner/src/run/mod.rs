//! Runs a plan: each job as soon as its inputs are there, as many at a time as there are cores; but
//! only one at a time of the jobs with large inputs, so that a run's memory does not grow with the
//! number of cores.

use crate::change::{Change, first_change};
use crate::hashes::{Hashes, show_path};
use crate::plan::needs;
use crate::provenance::provenance;
use crate::record::Record;
use crate::records::Kept;
use crate::{Job, Made, Making, Output, Provenance, Records, Results, strip_root};
use rayon::prelude::*;
use std::collections::{BTreeSet, HashSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use zwidth_store::{Lately, Seen, StoreError, hex_blake3};

mod options;
mod unplanned;

pub use options::{Options, wanted};
use options::{keep_seen, records_before, save};
use unplanned::{nobodys, outputs, remove_unplanned, take_unplanned};

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

/// What came of a run.
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
    let _held = match (options.dry_run, options.shard) {
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
    // Those that are not believed go from their file too.
    // A shard that has nothing to make says so, too.
    board.unsaved = !remarks.is_empty() || options.shard.is_some();
    let hashes = Hashes::seen(&options.known, options.seen.clone());
    let board = Mutex::new(board);
    let trials = Lately::seeing(options.seen.clone());
    let planned = outputs(jobs);
    // Until they are saved once: to save them takes about as long as it took to read them.
    let saved = Mutex::new((Instant::now(), begun.elapsed()));
    let run = Run { jobs, before, results, options, done, hashes, trials, planned, board, saved };
    for begin in [Board::waiting_for_none, Board::in_a_circle] {
        let ready = begin(&mut run.board());
        rayon::scope(|scope| run.spawn(scope, ready));
    }
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
        unsaved |= take_unplanned(jobs, &mut records);
        // Of jobs that are gone all, of those that failed what they no longer make.
        let others = before.0.keys().filter(|name| !records.0.contains_key(*name));
        let others = others.filter_map(|name| before.get(name));
        remarks.extend(others.flat_map(|record| remove_unplanned(&planned, &record, results)));
        remarks.extend(nobodys(&planned, results));
    }
    let is_unsaved = unsaved && !options.dry_run;
    let save = || if is_unsaved { save(&records, results, options).map(drop) } else { Ok(()) };
    let (saved, ()) = rayon::join(save, || keep_seen(results, options));
    saved?;
    // Of a large study that takes long, and nobody needs it to be over.
    rayon::spawn(move || drop((records, before)));
    Ok(Done { reports: reports.into_iter().flatten().collect(), remarks })
}

/// How often records are saved while jobs end, at most: a run that is killed makes again what came
/// after.
const SAVED_EVERY: Duration = Duration::from_secs(1);

/// To save those of a large study takes long: no more than one part in so many of the time of a core
/// goes into it.
const PARTS_OF_SAVING: u32 = 30;

/// Whether records are saved again, so long after they were last, which took so long.
fn is_save_due(since: Duration, took: Duration) -> bool {
    since >= SAVED_EVERY.max(took * PARTS_OF_SAVING)
}

/// Bytes of input files from which on a job reads much (8 MiB): as numbers in memory, or as text, some
/// five to ten times as many.
const MUCH: u64 = 1 << 23;

/// Whether a job reads much, as far as its inputs are there.
fn reads_much(job: &Job, seen: &Seen) -> bool {
    let found = |path: &Path| std::fs::metadata(path).map_or(0, |found| found.len());
    let bytes = |path: &Path| seen.length(path).unwrap_or_else(|| found(path));
    job.inputs().iter().map(|path| bytes(path)).sum::<u64>() > MUCH
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
    /// For each job how many others it waits for; `None` once it was begun, or if nobody asked for
    /// it.
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
        // What nobody asked for is not waited for: it lies there.
        let waits_for = |i: usize| needs[i].iter().filter(|maker| wanted[**maker]).count();
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
            waits: (0..jobs.len()).map(|i| wanted[i].then(|| waits_for(i))).collect(),
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

    /// The job to begin next, of those that are ready the first of whose part no other is at work: who
    /// comes after that one finds its trials read, and who runs beside it reads them once more.
    fn next(&mut self) -> Option<usize> {
        let jobs = self.jobs;
        let is_apart = |i: usize| {
            jobs[i].part.is_none()
                || self.at_work.iter().all(|at_work| jobs[*at_work].part != jobs[i].part)
        };
        let apart = self.ready.iter().find(|(_, i)| is_apart(*i));
        let next = *apart.or_else(|| self.ready.first())?;
        self.ready.remove(&next);
        self.at_work.insert(next.1);
        Some(next.1)
    }

    /// Those of these jobs that may run now; others that read much wait for the one that runs.
    fn admitted(&mut self, ready: Vec<usize>) -> Vec<usize> {
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

    /// Jobs that may run once this one has ended.
    fn after(&mut self, i: usize) -> Vec<usize> {
        self.at_work.remove(&i);
        let mut next = Vec::new();
        if self.large[i] {
            self.large_runs = false;
            next.extend(self.held.pop_front().filter(|_| self.disk.is_none()));
        }
        next.extend(self.freed_by(i));
        self.admitted(next)
    }

    /// Jobs that wait for nothing, from now on begun.
    fn waiting_for_none(&mut self) -> Vec<usize> {
        self.begin(|waits| waits == 0)
    }

    /// Jobs that nothing which is left could make ready: they need each other, or one that does,
    /// and fail when they find an input missing.
    fn in_a_circle(&mut self) -> Vec<usize> {
        if self.disk.is_some() { Vec::new() } else { self.begin(|_| true) }
    }

    fn begin(&mut self, which: impl Fn(usize) -> bool) -> Vec<usize> {
        let found: Vec<usize> =
            (0..self.waits.len()).filter(|i| self.waits[*i].is_some_and(&which)).collect();
        found.iter().for_each(|i| self.waits[*i] = None);
        self.admitted(found)
    }

    /// The first of a job's inputs that could not be made.
    fn first_failed(&self, job: &Job) -> Option<PathBuf> {
        if self.failed.is_empty() {
            return None;
        }
        job.inputs().into_iter().find(|input| self.failed.contains(input))
    }

    /// Jobs that waited for this one alone, from now on begun.
    fn freed_by(&mut self, i: usize) -> Vec<usize> {
        if self.disk.is_some() {
            return Vec::new();
        }
        let mut freed: Vec<usize> = Vec::new();
        for reader in self.readers[i].clone() {
            self.waits[reader] = match self.waits[reader] {
                Some(1) => {
                    freed.push(reader);
                    None
                }
                waits => waits.map(|n| n - 1),
            };
        }
        freed.iter().for_each(|i| self.large[*i] = reads_much(&self.jobs[*i], self.seen));
        freed
    }
}

/// What came of a job.
struct Ended {
    report: Report,
    /// Its record, if that is another than before.
    record: Option<Record>,
    /// What it made before, makes no more, and could not be removed.
    stayed: Vec<StoreError>,
}

impl Ended {
    fn of(report: Report) -> Self {
        Self { report, record: None, stayed: Vec::new() }
    }
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
            let is_small = !board.large[i];
            board.ready.insert((is_small, i));
            self.spawn_one(scope);
        }
    }

    fn spawn_one<'s>(&'s self, scope: &rayon::Scope<'s>) {
        scope.spawn(move |scope| {
            let Some(i) = self.board().next() else { return };
            let begun = Instant::now();
            let mut result = self.one(&self.jobs[i]);
            result.iter_mut().for_each(|ended| ended.report.took = begun.elapsed());
            // Before the board is locked: whoever listens may take long.
            if let Ok(ended) = &result {
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
                let stayed = self.withdraw(job);
                board.stayed.extend(stayed);
            }
            _ => {}
        }
        board.reports[i] = Some(report);
    }

    /// Saves the records of the jobs that have ended, unless they were a moment ago or are being saved.
    /// Other jobs go on meanwhile.
    fn save_when_due(&self) -> Result<(), StoreError> {
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
    fn one(&self, job: &Job) -> Result<Ended, StoreError> {
        let report = |verdict, problems, care| Report {
            stage: job.stage.name,
            name: job.name.clone(),
            verdict,
            problems,
            care,
            took: Duration::ZERO,
        };
        let without = |verdict| Ended::of(report(verdict, Vec::new(), Vec::new()));
        let root = self.results.root();
        let before = self.before.get(&job.name);
        let failed = self.board().first_failed(job);
        if let Some(input) = failed.filter(|_| !job.tolerant) {
            let why = format!("it needs {}, which could not be made", show_path(root, &input));
            return Ok(without(JobEnd::Blocked(why)));
        }
        let now = Record::now(job, root, &self.hashes);
        let reason = match &before {
            _ if self.options.fresh => Some(Change::Asked),
            None => Some(Change::NeverMade),
            Some(before) => first_change(before, &now, || self.hashes.of(root, &job.outputs)),
        };
        let Some(why) = reason.map(|change| change.to_string()) else {
            let before = before.map(Arc::unwrap_or_clone).unwrap_or_default();
            let report = report(JobEnd::UpToDate, before.problems.clone(), before.care.clone());
            // No reason to make it again, but who asks later is told of the files of this run.
            let moved = before.origins != now.origins;
            let record = moved.then_some(Record { origins: now.origins, ..before });
            return Ok(Ended { record, ..Ended::of(report) });
        };
        if self.options.dry_run {
            self.hashes.forget(&job.outputs);
            return Ok(without(JobEnd::Made(why)));
        }
        let mut record = now.with_origin(&job.name);
        let from = match self.options.without_origin {
            true => Provenance::new(),
            false => provenance(&job.name, &record),
        };
        let making = Making { from: &from, outputs: &job.outputs, root, trials: &self.trials };
        Ok(match make(job, &making, self.results)? {
            Err(error) => without(JobEnd::Failed(error)),
            Ok((mut made, hashes)) => {
                for text in made.problems.iter_mut().chain(&mut made.care) {
                    *text = strip_root(root, text);
                }
                for (path, hash) in job.outputs.iter().zip(hashes) {
                    self.hashes.written(path, &hash);
                    record.outputs.insert(show_path(root, path), hash);
                }
                record.problems.clone_from(&made.problems);
                record.care.clone_from(&made.care);
                // Now: once its record is saved nobody knows that it made them.
                let gone =
                    |before: Arc<Record>| remove_unplanned(&self.planned, &before, self.results);
                Ended {
                    report: report(JobEnd::Made(why), made.problems, made.care),
                    record: Some(record),
                    stayed: before.map(gone).unwrap_or_default(),
                }
            }
        })
    }

    /// What a failed job made before must not pass for current; what could not be removed.
    fn withdraw(&self, job: &Job) -> Vec<StoreError> {
        if self.options.dry_run {
            return Vec::new();
        }
        let removed = job.outputs.iter().map(|path| {
            self.hashes.set(path, "");
            self.results.remove(path)
        });
        removed.filter_map(Result::err).collect()
    }
}

/// Makes a job's outputs and writes them: what else it made, and the hash of each. The job's own
/// failure is the inner error: the others go on. An output that cannot be written is the outer one:
/// the disk is full or read-only, for the others too.
fn make(
    job: &Job,
    making: &Making,
    results: &Results,
) -> Result<Result<(Made, Vec<String>), String>, StoreError> {
    let mut made = match job.make(making) {
        Ok(made) => made,
        Err(error) => return Ok(Err(error.to_string())),
    };
    let n = made.outputs.len();
    let declared = job.outputs.len();
    if n != declared {
        return Ok(Err(format!("it made {n} outputs and declares {declared}")));
    }
    let mut hashes = Vec::new();
    for (path, output) in job.outputs.iter().zip(std::mem::take(&mut made.outputs)) {
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
    Ok(Ok((made, hashes)))
}

#[cfg(test)]
mod tests;
