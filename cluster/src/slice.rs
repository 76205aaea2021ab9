//! The tasks of a study: for each part its jobs, and with them as little of the raw data as gives
//! the same plan of these jobs.
//!
//! Most jobs of a condition depend on its own trials and session alone. A few depend also on
//! whether the study has a certain kind of trial at all. Which ones these are is the plan's to know,
//! so nothing is assumed here: a slice is planned, and if a job comes out otherwise, a larger slice
//! is taken, up to the whole study.

use crate::pack::pack;
use crate::task::{MOST_PACKED, RawFile, Task};
use anyhow::{Context as _, ensure};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::path::{Path, PathBuf};
use zwidth_plan as plan;
use zwidth_runner::{Job, PROGRAM};
use zwidth_store::{Findings, MOST_BYTES, StudyData, TrialEntry, file_blake3, read_regular};

/// A study that is shared out.
pub(crate) struct Slices<'d> {
    data: &'d StudyData,
    /// Where executors find the raw files.
    source: String,
    trials: HashMap<&'d Path, &'d TrialEntry>,
    by_session: BTreeMap<String, Vec<&'d TrialEntry>>,
    /// The files of each session, by the beginning of their names: `P01_S01`.
    session_files: BTreeMap<String, Vec<PathBuf>>,
}

impl<'d> Slices<'d> {
    /// A study, and where executors find its raw files.
    ///
    /// # Errors
    /// A folder of sessions that cannot be listed.
    pub(crate) fn of(data: &'d StudyData, source: String) -> anyhow::Result<Self> {
        let mut by_session: BTreeMap<String, Vec<&TrialEntry>> = BTreeMap::new();
        for trial in &data.trials {
            by_session.entry(session_of(data, trial)).or_default().push(trial);
        }
        let mut session_files: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
        let folder = data.layout.sessions();
        if folder.is_dir() {
            let list = || format!("{} cannot be listed", folder.display());
            for entry in std::fs::read_dir(&folder).with_context(list)? {
                let path = entry.with_context(list)?.path();
                if path.is_file() {
                    session_files.entry(stem(&path)).or_default().push(path);
                }
            }
        }
        let trials = data.trials.iter().map(|trial| (&*trial.path, trial)).collect();
        Ok(Self { data, source, trials, by_session, session_files })
    }

    /// The task of a part, packed.
    ///
    /// # Errors
    /// A file that cannot be read; a task that no message can hold.
    pub(crate) fn task(&self, part: &str, due: &[&Job]) -> anyhow::Result<Vec<u8>> {
        let root = self.data.layout.root();
        let shown = |path: &Path| {
            let path = path.strip_prefix(root).unwrap_or(path);
            path.to_string_lossy().replace(std::path::MAIN_SEPARATOR, "/")
        };
        let raw = self.raw_files(due).into_iter().map(|path| {
            let known = self.trials.get(path.as_path()).map(|trial| trial.blake3.clone());
            let hash = known.map_or_else(|| file_blake3(&path), Ok);
            let blake3 = hash.with_context(|| format!("{} cannot be read", path.display()))?;
            Ok(RawFile { path: shown(&path), blake3 })
        });
        let made: HashSet<&PathBuf> = due.iter().flat_map(|job| &job.outputs).collect();
        let inputs: BTreeSet<PathBuf> = due.iter().flat_map(|job| job.inputs()).collect();
        let given: Vec<&PathBuf> = inputs
            .iter()
            .filter(|path| !path.starts_with(self.data.layout.raw()) && !made.contains(*path))
            .collect();
        let task = Task {
            zwidth: PROGRAM.to_owned(),
            study: self.data.layout.study().to_string(),
            part: part.to_owned(),
            jobs: due.iter().map(|job| job.name.clone()).collect(),
            source: self.source.clone(),
            raw: raw.collect::<anyhow::Result<_>>()?,
            given: given.iter().map(|path| shown(path)).collect(),
        };
        let contents = given.iter().map(|path| Ok(read_regular(path, MOST_BYTES)?));
        let packed = pack(&task, &contents.collect::<anyhow::Result<Vec<_>>>()?)?;
        ensure!(
            packed.len() <= MOST_PACKED,
            "what {part} needs has {} bytes, and {MOST_PACKED} fit into a message",
            packed.len()
        );
        Ok(packed)
    }

    /// The raw files of the smallest slice by which these jobs come out as they are.
    fn raw_files(&self, due: &[&Job]) -> BTreeSet<PathBuf> {
        let raw = self.data.layout.raw();
        let needed = due.iter().flat_map(|job| {
            [job.inputs(), job.origins.iter().map(|path| path.to_path_buf()).collect()].concat()
        });
        let needed: BTreeSet<PathBuf> = needed.filter(|path| path.starts_with(&raw)).collect();
        let own: Vec<&TrialEntry> =
            needed.iter().filter_map(|path| self.trials.get(path.as_path()).copied()).collect();
        let sessions: BTreeSet<String> =
            own.iter().map(|trial| session_of(self.data, trial)).collect();
        let beside: Vec<&TrialEntry> =
            sessions.iter().filter_map(|s| self.by_session.get(s)).flatten().copied().collect();
        let slices = [own.clone(), [own, one_of_each(&beside)].concat(), beside];
        let slice = slices.iter().find(|trials| {
            let of_these = |log: &&zwidth_store::SessionLog| sessions.contains(&stem(&log.path));
            let sliced = StudyData {
                layout: self.data.layout.clone(),
                study: self.data.study.clone(),
                trials: in_order(trials),
                sweeps: self
                    .data
                    .sweeps
                    .iter()
                    .filter(|s| needed.contains(&s.path))
                    .cloned()
                    .collect(),
                sessions: self.data.sessions.iter().filter(of_these).cloned().collect(),
                problems: Vec::new(),
                warnings: Vec::new(),
                answers: Vec::new(),
                answers_left_out: Vec::new(),
            };
            comes_out_alike(&sliced, due)
        });
        let (trials, sessions): (Vec<&TrialEntry>, Vec<&Vec<PathBuf>>) = match slice {
            Some(trials) => (
                trials.clone(),
                sessions.iter().filter_map(|s| self.session_files.get(s)).collect(),
            ),
            None => (self.data.trials.iter().collect(), self.session_files.values().collect()),
        };
        let trials = trials.into_iter().map(|trial| trial.path.to_path_buf());
        let files = trials.chain(sessions.into_iter().flatten().cloned());
        files.chain([self.data.layout.study_toml()]).chain(needed).collect()
    }
}

/// The first trial of each condition.
fn one_of_each<'d>(trials: &[&'d TrialEntry]) -> Vec<&'d TrialEntry> {
    let mut seen = HashSet::new();
    let counting = trials.iter().copied().filter(|trial| trial.counts());
    counting.filter(|t| seen.insert((&t.meta.environment, &t.meta.mode))).collect()
}

/// Trials as a study lists them, each once.
fn in_order(trials: &[&TrialEntry]) -> Vec<TrialEntry> {
    let by_id = trials.iter().map(|trial| {
        let meta = &trial.meta;
        ((&meta.participant, &meta.session, meta.trial), *trial)
    });
    by_id.collect::<BTreeMap<_, _>>().into_values().cloned().collect()
}

/// Whether the plan of a slice has these jobs as they are.
fn comes_out_alike(slice: &StudyData, due: &[&Job]) -> bool {
    let jobs = plan::jobs(slice, &Findings::default());
    let by_name: HashMap<&str, &Job> = jobs.iter().map(|job| (job.name.as_str(), job)).collect();
    let key = |job: &Job| {
        (job.stage, job.parameters(), job.inputs(), job.origins.clone(), job.outputs.clone())
    };
    due.iter().all(|job| by_name.get(job.name.as_str()).is_some_and(|other| key(other) == key(job)))
}

/// The beginning of the names of the files of a trial's session: `P01_S01`.
fn session_of(data: &StudyData, trial: &TrialEntry) -> String {
    stem(&data.layout.session(&trial.meta.participant, &trial.meta.session))
}

/// A file's name up to its first dot.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').next().unwrap_or_default().to_owned()
}
