//! The plan: which jobs a study's data give. Each file binds one stage, a pure function, to the
//! files it reads and makes.

mod average;
mod characterise;
mod design;
mod figures;
mod freemotion;
mod identify;
mod likert;
mod likert_figures;
mod metrics;
mod replay;
mod replay_figures;
mod report;
mod summary;
mod tables;

use rayon::prelude::*;
use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};
use zwidth_runner::{Job, Made, Provenance};
use zwidth_store::{Findings, Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Environment, Mode, ParticipantId, SessionId, TrialMeta};
use zwidth_tables::{Table, TableError};

/// What a job's function can fail with.
type JobError = Box<dyn Error + Send + Sync>;

/// Every job of a study, of which this was found.
pub(crate) fn jobs<'a>(data: &'a StudyData, found: &Findings) -> Vec<Job<'a>> {
    let mut jobs = Vec::new();
    jobs.extend(characterise::jobs(data));
    jobs.extend(metrics::jobs(data));
    jobs.extend(average::jobs(data));
    jobs.extend(freemotion::jobs(data));
    jobs.extend(replay::jobs(data));
    jobs.extend(identify::jobs(data));
    jobs.extend(likert::jobs(data));
    jobs.extend(figures::jobs(data));
    let report = report::jobs(data, &jobs);
    jobs.extend(report);
    let tables = tables::jobs(data, &jobs);
    jobs.extend(tables);
    let summary = summary::job(data, found, &jobs);
    jobs.push(summary);
    jobs
}

/// The stages, in the order in which a person thinks of them.
pub(crate) const STAGES: [&str; 11] = [
    "characterise",
    "metrics",
    "average",
    "freemotion",
    "replay",
    "identify",
    "likert",
    "figures",
    "report",
    "tables",
    "summary",
];

/// One session's trials that count.
struct Session<'a> {
    participant: &'a ParticipantId,
    session: &'a SessionId,
    trials: Vec<&'a TrialEntry>,
}

impl<'a> Session<'a> {
    /// `P01 S01`, for people.
    fn who(&self) -> String {
        format!("{} {}", self.participant, self.session)
    }

    /// `P01.S01`: ids have no dots, so names made from them cannot collide.
    fn key(&self) -> String {
        format!("{}.{}", self.participant, self.session)
    }

    /// The trials of one environment.
    fn of(&self, environment: &Environment) -> Vec<&'a TrialEntry> {
        self.trials.iter().copied().filter(|t| t.meta.environment == environment.id).collect()
    }

    /// The repeats of one condition; `None` if it has none.
    fn repeats(&self, environment: &Environment, mode: &Mode) -> Option<Repeats<'a>> {
        let mut trials = self.of(environment);
        trials.retain(|t| t.meta.mode == mode.id);
        let (who, key) = (self.who(), self.key());
        let (who, key) = (
            format!("{who} {} {}", environment.id, mode.id),
            format!("{key}.{}.{}", environment.id, mode.id),
        );
        (!trials.is_empty()).then_some(Repeats { who, key, trials })
    }
}

/// The trials of one condition in one session.
struct Repeats<'a> {
    /// `P01 S01 spring hybrid`, for people.
    who: String,
    /// `P01.S01.spring.hybrid`.
    key: String,
    trials: Vec<&'a TrialEntry>,
}

/// The conditions of every session that have trials, in the study's order.
fn repeats(data: &StudyData) -> Vec<Repeats<'_>> {
    let mut found = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            found.extend(
                data.study.modes.iter().filter_map(|mode| session.repeats(environment, mode)),
            );
        }
    }
    found
}

/// The sessions with trials that count, each trial in a known condition.
fn sessions(data: &StudyData) -> Vec<Session<'_>> {
    let mut sessions: BTreeMap<_, Vec<&TrialEntry>> = BTreeMap::new();
    for trial in data.counting() {
        sessions.entry((&trial.meta.participant, &trial.meta.session)).or_default().push(trial);
    }
    let session = |((participant, session), trials)| Session { participant, session, trials };
    sessions.into_iter().map(session).collect()
}

/// The jobs of single conditions, and the job of the study that reads what they make; none for no
/// condition.
fn joined<'a>(
    conditions: Vec<Job<'a>>,
    study: impl FnOnce(Vec<PathBuf>) -> Job<'a>,
) -> Vec<Job<'a>> {
    let tables: Vec<PathBuf> =
        conditions.iter().flat_map(|job| job.outputs.iter().cloned()).collect();
    let whole = (!tables.is_empty()).then(|| study(tables));
    conditions.into_iter().chain(whole).collect()
}

/// `P01 S01 trial 2`.
fn name(trial: &TrialMeta) -> String {
    format!("{} {} trial {}", trial.participant, trial.session, trial.trial)
}

/// A text without the folder of the data in it, so that results have the same bytes wherever that
/// lies.
fn plain(data: &StudyData, text: &str) -> String {
    let root = data.layout.root().join("").to_string_lossy().into_owned();
    if root.is_empty() { text.to_owned() } else { text.replace(&root, "") }
}

fn paths(trials: &[&TrialEntry]) -> Vec<PathBuf> {
    trials.iter().map(|t| t.path.clone()).collect()
}

/// What the session knows of trials beside their files: an unsealed trial's mode and repeat. Part
/// of the parameters of every job that reads trials.
fn known(trials: &[&TrialEntry]) -> String {
    let known: Vec<_> =
        trials.iter().map(|t| (t.meta.trial, t.meta.mode.as_str(), t.meta.repeat)).collect();
    format!("{known:?}")
}

/// Reads trials in parallel, with these signals; what cannot be read is left out and told.
fn read_all(
    trials: &[&TrialEntry],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> (Vec<Trial>, Vec<String>) {
    let results: Vec<_> = trials.par_iter().map(|trial| trial.read(signals.clone())).collect();
    split(results)
}

/// The good results, and the bad ones in words.
fn split<T, E: ToString>(results: Vec<Result<T, E>>) -> (Vec<T>, Vec<String>) {
    let mut problems = Vec::new();
    let good = results
        .into_iter()
        .filter_map(|r| r.map_err(|e| problems.push(e.to_string())).ok())
        .collect();
    (good, problems)
}

/// A job's result: tables as Parquet files, in the order of its outputs.
fn made(
    tables: &[Table],
    outputs: &[PathBuf],
    from: &Provenance,
    problems: Vec<String>,
) -> Result<Made, JobError> {
    let bytes = |(t, path): (&Table, &PathBuf)| t.to_parquet(from, path);
    let outputs = tables.iter().zip(outputs).map(bytes).collect::<Result<_, TableError>>()?;
    Ok(Made { outputs, problems, ..Made::default() })
}

/// Whatever the analysis of a trial depends on besides its file.
fn analysis_parameters(data: &StudyData) -> String {
    let s = &data.study;
    let scenes: Vec<_> = s.environments.iter().map(|e| (e.id.as_str(), e.scene)).collect();
    let d = &s.device;
    let device = (d.lever_m, d.theta_min_rad, d.theta_max_rad, d.force_rate_hz);
    format!("{:?}", (s.analysis, device, s.coordinate, scenes))
}

/// A file under `derived/<study>`.
fn derived(layout: &Layout, name: impl AsRef<Path>) -> PathBuf {
    layout.derived().join(name)
}

pub(crate) use figures::chosen_in_vain;
pub(crate) use report::built_in;
pub(crate) use summary::file as summary_file;
pub(crate) use tables::printed as printed_tables;
