//! `verify`: every finding in a study, not only the first.

use crate::disk::walk::{files_below, unfinished_below};
use crate::form::columns::LONG;
use crate::form::journaled::DAMAGED;
use crate::form::read::{OpenColumns, read_whole_trial};
use crate::form::sweep::read_sweep_from;
use crate::judge::beside::altered;
use crate::judge::people::people_findings;
use crate::judge::plausible::Asked;
use crate::judge::samples::{Check, check_samples, import_findings, within_limits};
use crate::judge::study::check_folders;
use crate::judge::tasks::{few_answers, task_findings};
use crate::{
    Files, FirstErrors, LOST, Layout, RealFiles, SessionLog, StoreError, StudyData, SweepEntry,
    TrialEntry,
};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{Condition, Event, PlannedTrial, Question, Source, Study};

/// Checks a whole study: `study.toml`, every file byte by byte, every event. An empty list is a
/// clean study.
pub fn verify(layout: &Layout) -> Vec<StoreError> {
    verify_from(&RealFiles, layout)
}

/// [`verify`] that calls `progress` after each trial and each sweep with the number of them all, from
/// any thread.
pub fn verify_with(layout: &Layout, progress: &(dyn Fn(usize) + Sync)) -> Vec<StoreError> {
    verify_by(&RealFiles, layout, check_samples, progress)
}

/// [`verify`] on any file layer.
pub fn verify_from(files: &dyn Files, layout: &Layout) -> Vec<StoreError> {
    verify_by(files, layout, check_samples, &|_| {})
}

/// [`verify_from`] without the plausibility of recordings: the remaining findings are about files
/// that were not kept as recorded.
pub fn verify_kept(files: &dyn Files, layout: &Layout) -> Vec<StoreError> {
    verify_by(files, layout, within_limits, &|_| {})
}

fn verify_by(
    files: &dyn Files,
    layout: &Layout,
    check: Check,
    progress: &(dyn Fn(usize) + Sync),
) -> Vec<StoreError> {
    let mut all = match StudyData::load_from(files, layout) {
        Ok(data) => {
            let Findings { left_out, with_care } = findings(files, &data);
            let all = data.trials.len() + data.sweeps.len();
            let trials = data.trials.par_iter().flat_map_iter(|entry| {
                let findings = trial(files, &data, entry, check);
                progress(all);
                findings
            });
            let trials: Vec<_> = trials.collect();
            let sweeps = data.sweeps.par_iter().filter_map(|entry| {
                let finding = sweep(files, entry);
                progress(all);
                finding
            });
            let beside = data.beside.par_iter().filter_map(|entry| altered(files, entry));
            [left_out, with_care, trials, sweeps.collect(), beside.collect()].concat()
        }
        // Behind a link nothing is looked at.
        Err(findings) if check_folders(files, layout).is_err() => findings,
        Err(findings) => {
            let Findings { left_out, with_care } = strays(files, layout);
            [findings, left_out, with_care].concat()
        }
    };
    // A fault may be found in two ways, and is told once.
    all.sort_by(|a, b| (&a.path, &a.column, a.row).cmp(&(&b.path, &b.column, b.row)));
    all.dedup();
    all
}

/// What is wrong with a study, divided by the consequences for the results.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Findings {
    /// Something was recorded, and no result has it in it.
    pub left_out: Vec<StoreError>,
    /// It is in the results, and they are to be read with care.
    pub with_care: Vec<StoreError>,
}

/// Every finding that needs no samples: those of loading the study, of its sessions and of things
/// beside its files. [`check_samples`] gives the findings from samples, trial by trial.
pub fn findings(files: &dyn Files, data: &StudyData) -> Findings {
    let mut findings = strays(files, &data.layout);
    findings.left_out.splice(0..0, data.problems.iter().cloned());
    findings.with_care.splice(0..0, data.warnings.iter().cloned());
    findings.with_care.extend(data.sessions.iter().flat_map(|s| session(data, s)));
    findings.with_care.extend(people_findings(
        files,
        &data.layout,
        &data.study,
        &data.people,
        &data.counting().map(|trial| &trial.meta.participant).collect(),
    ));
    findings.with_care.extend(against_plan(data));
    findings.with_care.extend(few_answers(data));
    findings
}

/// Deviations from the plan: repeats that count twice, conditions with other numbers of trials,
/// trials far shorter than others.
pub fn against_plan(data: &StudyData) -> Vec<StoreError> {
    [doubled(data), unplanned(data), stumps(data)].concat()
}

fn trial(files: &dyn Files, data: &StudyData, entry: &TrialEntry, check: Check) -> Vec<StoreError> {
    // Whether it fits study.toml and its session's log was told when the study was loaded.
    let expected = Asked::of(&data.study, &entry.meta.environment);
    // A trial cut short may well hold a lever that never left its stop, and what is in no result
    // misleads nobody: excluding a trial settles what was found in it.
    let check = if entry.counts() { check } else { within_limits };
    let doubts = match entry.rows <= LONG {
        true => read_whole_trial(files, &entry.path)
            .map(|trial| check(&expected, &entry.path, &trial.samples)),
        false => OpenColumns::open(files, &entry.path).and_then(|trial| {
            // First, for what it reads is not read once more to be checked.
            let doubts = check(&expected, &entry.path, &trial);
            trial.check()?;
            Ok(doubts)
        }),
    };
    match doubts {
        Ok(doubts) => {
            let imported = entry.counts().then(|| import_findings(&entry.path, &entry.said.file));
            let imported = imported.into_iter().flatten();
            doubts.into_iter().chain(imported).chain(off_scale(&data.study, entry)).collect()
        }
        Err(error) => vec![error],
    }
}

/// The finding of a sweep.
fn sweep(files: &dyn Files, entry: &SweepEntry) -> Option<StoreError> {
    let remedy = "import a whole copy of the recording as another sweep, and remove this one from the study if what is lost \
                  matters";
    match read_sweep_from(files, &entry.path) {
        Ok(sweep) => sweep.file.get(LOST).map(|lost| StoreError::new(&entry.path, lost, remedy)),
        Err(error) => Some(error),
    }
}

/// An answer in a trial's file that the scale of its question does not have.
fn off_scale(study: &Study, entry: &TrialEntry) -> Option<StoreError> {
    let question = study.environment(&entry.meta.environment)?.question.as_ref()?;
    let scale = &study.question(question)?.scale;
    let value = entry.meta.likert.filter(|value| !scale.has(*value))?;
    let what = format!("the answer is {value}; answers to '{question}' are {}", scale.range());
    let remedy = "add an event with the right answer: it takes the place of the file's";
    Some(StoreError::new(&entry.path, what, remedy).column("likert"))
}

/// Two trials that count as one repeat: one of them was meant to be superseded or excluded.
fn doubled(data: &StudyData) -> Vec<StoreError> {
    let mut seen = BTreeMap::new();
    let mut findings = Vec::new();
    for t in data.counting() {
        let m = &t.meta;
        if let Some(first) =
            seen.insert((&m.participant, &m.session, m.condition(), m.repeat), m.trial)
        {
            let what = format!(
                "trials {first} and {} both count as repeat {} of {} × {}",
                m.trial, m.repeat, m.environment, m.mode
            );
            let remedy = "exclude or supersede one of them, or number the repeats";
            findings.push(StoreError::new(&t.path, what, remedy));
        }
    }
    findings
}

/// Sessions in which more trials of a condition count than are planned, and imported ones, which are there as a
/// whole, in which fewer do.
fn unplanned(data: &StudyData) -> Vec<StoreError> {
    let planned = data.study.design.repeats;
    let mut counts: BTreeMap<_, BTreeMap<Condition, u32>> = BTreeMap::new();
    for t in data.counting() {
        // An environment of tasks has their presentations, and no repeats.
        if data.study.tasks_in(&t.meta.environment).next().is_some() {
            continue;
        }
        let session = counts.entry((&t.meta.participant, &t.meta.session)).or_default();
        *session.entry(t.meta.condition()).or_default() += 1;
    }
    let mut findings = Vec::new();
    for log in &data.sessions {
        let Some(counts) = counts.get(&(&log.record.participant, &log.record.session)) else {
            continue;
        };
        let is_whole = matches!(log.record.source, Source::Imported | Source::Simulated);
        let odd = counts.iter().filter(|(_, n)| **n > planned || (is_whole && **n < planned));
        let odd: Vec<String> =
            odd.map(|(c, n)| format!("{n} of {} × {}", c.environment, c.mode)).collect();
        if odd.is_empty() {
            continue;
        }
        let more = match odd.len().saturating_sub(MOST_NAMED) {
            0 => String::new(),
            n => format!(" and {n} more conditions"),
        };
        let what = format!(
            "other trials count than are planned (design.repeats = {planned} of each condition): {}{more}",
            odd[..odd.len().min(MOST_NAMED)].join(", ")
        );
        let remedy = "exclude the trials that are not meant (attempts, practice, a label that changed within a file), or set \
                      repeats in study.toml to what was done";
        findings.push(StoreError::new(&log.path, what, remedy));
    }
    findings
}

/// Conditions that a finding names.
const MOST_NAMED: usize = 6;
/// A trial is taken for a stump if it has less than this share of the samples of the others …
const STUMP: f64 = 0.2;
/// … of which there are at least so many in its session.
const LEAST_OTHERS: usize = 3;

/// Trials far shorter than the others of their environment in the session.
fn stumps(data: &StudyData) -> Vec<StoreError> {
    let mut alike: BTreeMap<_, Vec<&TrialEntry>> = BTreeMap::new();
    for t in data.counting() {
        let m = &t.meta;
        alike.entry((&m.participant, &m.session, &m.environment)).or_default().push(t);
    }
    let mut findings = Vec::new();
    for trials in alike.into_values().filter(|trials| trials.len() > LEAST_OTHERS) {
        let mut rows: Vec<usize> = trials.iter().map(|t| t.rows).collect();
        let middle = rows.len() / 2;
        let usual = *rows.select_nth_unstable(middle).1;
        for t in trials.iter().filter(|t| (t.rows as f64) < STUMP * usual as f64) {
            let what = format!(
                "it has {} samples, and the trials of {} in its session have {usual} (their median): does it hold a whole \
                 trial?",
                t.rows, t.meta.environment
            );
            let remedy = "look at it, and exclude it if it is a stump or an attempt";
            findings.push(StoreError::new(&t.path, what, remedy));
        }
    }
    findings
}

fn session(data: &StudyData, log: &SessionLog) -> Vec<StoreError> {
    let mut findings = Vec::new();
    findings.extend(record(data, log));
    let trials: BTreeSet<u32> = log.trials.iter().map(|t| t.trial).collect();
    // A log may be wrong in each of its lines.
    let mut events = FirstErrors::default();
    for (row, event) in log.events.iter().enumerate() {
        events.extend(event_finding(data, log, &trials, event).map(|e| e.row0(row)));
    }
    findings.extend(Vec::from(events));
    findings.extend(task_findings(data, log));
    findings
}

/// Values that a session's record must not have.
fn record(data: &StudyData, log: &SessionLog) -> Vec<StoreError> {
    let record = &log.record;
    let mut damage = Vec::new();
    if let Some(error) = record.calibration.as_ref().and_then(|c| c.check().err()) {
        damage.push(error.to_string());
    }
    if record.rate_hz.is_some_and(|rate| !(rate.is_finite() && rate > 0.0)) {
        damage.push("rate_hz must be a number above 0".to_owned());
    }
    let commitment = record.commitment.as_ref();
    if commitment.is_some_and(|c| c.len() != 64 || !c.bytes().all(|b| b.is_ascii_hexdigit())) {
        let what =
            "the commitment is not 64 hexadecimal digits, so that nothing can unseal the session";
        damage.push(what.to_owned());
    }
    // Either tells the modes to whoever reads the record while the session runs.
    let mut unblinding = Vec::new();
    let mut trials = record.trials.iter().filter(|_| commitment.is_some());
    if let Some(t) = trials.find(|t| data.study.mode(&t.mode).is_some()) {
        let trial = t.trial;
        unblinding
            .push(format!("the session is sealed, but its record names the mode of trial {trial}"));
    }
    let tells = |t: &&PlannedTrial| t.task.as_ref().is_some_and(|own| own.is_standard.is_some());
    if let Some(t) = record.trials.iter().filter(|_| commitment.is_some()).find(tells) {
        unblinding.push(format!(
            "the session is sealed, but its record says whether trial {} holds the standard",
            t.trial
        ));
    }
    if commitment.is_some() && record.seed.is_some() {
        let what = "the session is sealed, but its record holds the seed its order was drawn with";
        unblinding.push(what.to_owned());
    }
    let damage = damage.into_iter().map(|what| (what, "restore the record from a copy"));
    let remedy = "the session was not blind: say so where it is reported";
    let findings = damage.chain(unblinding.into_iter().map(|what| (what, remedy)));
    findings.map(|(what, remedy)| StoreError::new(&log.path, what, remedy)).collect()
}

fn event_finding(
    data: &StudyData,
    log: &SessionLog,
    trials: &BTreeSet<u32>,
    event: &Event,
) -> Option<StoreError> {
    let stranger = event.trial().filter(|trial| !trials.contains(trial));
    let what = match (stranger, event) {
        (Some(trial), _) => {
            format!("the event is about trial {trial}, which is not in the session's record")
        }
        (None, Event::Answer { trial, question, value, .. }) => {
            match data.study.question(question) {
                None => format!("question '{question}' is not in study.toml"),
                Some(Question { scale, .. }) if !scale.has(*value) => {
                    let range = scale.range();
                    format!("the answer to trial {trial} is {value}; answers are {range}")
                }
                Some(_) => return None,
            }
        }
        (None, Event::Superseded { by, .. }) if !trials.contains(by) => {
            format!("trial {by}, said to take a trial's place, is not in the session's record")
        }
        _ => return None,
    };
    let remedy = "the log only grows: add an event that puts it right";
    Some(StoreError::new(&log.events_path, what, remedy))
}

/// Files that do not belong where they lie, and left-overs of unfinished writes.
fn strays(files: &dyn Files, layout: &Layout) -> Findings {
    let mut findings = Findings::default();
    let (others, unfinished) = rayon::join(
        || {
            let trees =
                [layout.trials(), layout.sweeps(), layout.own(), layout.beside()].into_iter();
            let paths = trees.flat_map(|tree| files_below(files, &tree).unwrap_or_default());
            let others = paths.filter(|path| path.extension().is_none_or(|e| e != "parquet"));
            others.collect::<Vec<_>>()
        },
        || unfinished_below(files, &layout.raw()),
    );
    for path in others {
        let what = "only Parquet files belong in this tree";
        let remedy = "move the file elsewhere; other tools read the whole tree";
        findings.with_care.push(StoreError::new(&path, what, remedy));
    }
    let recover = format!("run `zwidth recover {}`", layout.study());
    for path in unfinished {
        findings.left_out.push(StoreError::new(&path, "a write was cut short here", &*recover));
    }
    if files.kind(&layout.unfinished()).is_some() {
        let what =
            "a change of several files was cut short here, or runs now: none of it is there yet";
        let remedy = format!("give the command again, or run `zwidth recover {}`", layout.study());
        findings.with_care.push(StoreError::new(&layout.unfinished(), what, remedy));
    }
    for path in files_below(files, &layout.journals()).unwrap_or_default() {
        let damaged = path.to_string_lossy().contains(DAMAGED);
        if damaged {
            let what = "a journal that could not be read to its end";
            let remedy =
                "what could be read of it is a trial; remove the file when nobody needs it";
            findings.with_care.push(StoreError::new(&path, what, remedy));
        } else {
            let what = "a trial was cut short here, or is being recorded now";
            findings.left_out.push(StoreError::new(&path, what, &*recover));
        }
    }
    findings
}
