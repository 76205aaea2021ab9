//! `kill -9` at random instants of a running acquisition: nothing finished is lost, the trial in
//! progress keeps its samples, `verify` is clean after `recover`, and the session continues in the
//! same order.

use super::{SESSION, STUDY, fraction, fresh, run, started};
use crate::shell::{program, scratch, words};
use crate::tried::held;
use anyhow::{Context as _, ensure};
use jiff::Timestamp;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use zwidth_store::{Layout, Signal, StudyData, TrialEntry};
use zwidth_study::Status;

/// A short session: one familiarisation trial, and each condition once.
const SHORT: [(&str, &str); 3] = [
    ("\nrepeats = 6\n", "\nrepeats = 1\n"),
    ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"),
    ("\npause_s = 5.0\n", "\npause_s = 0.5\n"),
];
/// How often it tells how far it is.
const TOLD_EVERY: u32 = 10;
/// Every tenth acquisition runs in real time, the others as fast as the machine can.
const LIVE_EVERY: u32 = 10;
/// Longest a session in real time runs before it is killed, s: the device check, and about four
/// trials.
const LIVE_S: f64 = 40.0;
/// What a kill may take from the trial in progress (docs/data.md, "Promises"), s.
const LOST_S: f64 = 0.1;
/// A trial's file tells its start a moment before its first sample, while its journal is laid down;
/// and a write that is under way is lost whole. What a loaded machine may make of both, s.
const SLACK_S: f64 = 0.05;

pub(crate) fn kill(kills: u32, seed: u64) -> anyhow::Result<()> {
    let program = &program()?;
    let folder = scratch("kill");
    let reference = folder.join("reference");
    let started = Instant::now();
    let whole = fresh(&reference, &SHORT)?;
    run(program, &reference, &words(&line(seed, false)), &[0])?;
    let length = started.elapsed();
    let began = Instant::now();
    let mut cut = 0;
    let mut worst_s = 0.0_f64;
    for number in 1..=kills {
        let live = number % LIVE_EVERY == 0;
        let longest = if live { Duration::from_secs_f64(LIVE_S) } else { length };
        let after = longest.mul_f64(fraction(&format!("kill {seed} {number}"))?);
        let root = folder.join("killed");
        let layout = fresh(&root, &SHORT)?;
        let (lines, killed) = killed(program, &root, &line(seed, live), after)?;
        let lost_s =
            inspect(program, &layout, &whole, &lines, killed, live).with_context(|| {
                format!(
                    "kill {number} of seed {seed}, {after:?} after the start; see {}",
                    root.display()
                )
            })?;
        cut += u32::from(lost_s.is_some());
        worst_s = worst_s.max(lost_s.unwrap_or(0.0));
        go_on(program, &root, &layout, seed)
            .with_context(|| format!("after kill {number} of seed {seed}"))?;
        if number % TOLD_EVERY == 0 {
            println!("{number} of {kills} kills, {cut} within a trial in real time");
        }
    }
    println!(
        "{kills} kills, {cut} of them within a trial in real time; most that was lost of one: {:.0} ms; nothing finished was lost",
        worst_s * 1e3
    );
    let what = "`kill -9` of the program at random instants of a session, on the real disk";
    held(what, format!("cargo xtask soak kill {kills}"), kills.into(), began)
}

/// The command of a session that runs by itself.
fn line(seed: u64, live: bool) -> String {
    let fast = if live { "" } else { " --fast" };
    format!("acquire {STUDY} {SESSION} --plain --auto --seed {seed}{fast}")
}

/// Starts a session, kills it after a while, and returns what it had said until then.
pub(super) fn killed(
    program: &Path,
    root: &Path,
    line: &str,
    after: Duration,
) -> anyhow::Result<(Vec<String>, Timestamp)> {
    let mut child = started(program, root, line)?;
    let pipe = BufReader::new(child.stdout.take().context("the acquisition has no output")?);
    // Read while it runs: a full pipe would stop it. The pipe ends with it.
    let heard = std::thread::spawn(|| pipe.lines().map_while(Result::ok).collect());
    std::thread::sleep(after);
    let killed = Timestamp::now();
    child.kill()?;
    child.wait()?;
    Ok((heard.join().unwrap_or_default(), killed))
}

/// Checks what a kill left, after `recover`; gives what the trial in progress lost, where that can
/// be told.
fn inspect(
    program: &Path,
    layout: &Layout,
    whole: &Layout,
    lines: &[String],
    killed: Timestamp,
    live: bool,
) -> anyhow::Result<Option<f64>> {
    let journals = journals(layout)?;
    run(program, layout.root(), &["recover", STUDY], &[0])?;
    run(program, layout.root(), &["verify", STUDY], &[0])?;
    let data = load(layout)?;
    expect_nothing_vanished(&data, layout, &journals, killed)?;
    let mut current = None;
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        match words.as_slice() {
            ["trial", number, "stored"] => {
                expect_complete(&data, number.parse()?)?;
                current = None;
            }
            // Safety cut the trial, as it does where a loaded machine misses deadlines, and the
            // session was left.
            ["stopped" | "left", ..] => current = None,
            ["trial", number, "(place", ..] => current = Some(number.parse::<u32>()?),
            ["question", ..] => {
                let number = current.take().context("a question before any trial")?;
                expect_complete(&data, number)?;
            }
            _ => {}
        }
    }
    if !live {
        for trial in &data.trials {
            expect_same_beginning(trial, whole)?;
        }
        return Ok(None);
    }
    current.map_or(Ok(None), |number| lost(&data, number, killed))
}

/// The journals a kill left, each with the time of its last write.
fn journals(layout: &Layout) -> anyhow::Result<Vec<(PathBuf, Timestamp)>> {
    if !layout.journals().exists() {
        return Ok(Vec::new());
    }
    let mut found = Vec::new();
    for entry in std::fs::read_dir(layout.journals())? {
        let entry = entry?;
        found.push((entry.path(), Timestamp::try_from(entry.metadata()?.modified()?)?));
    }
    Ok(found)
}

/// A journal becomes a trial. One may be empty only if it was laid down a moment before the kill:
/// an older one had samples, and its trial is lost whole if there is no file.
fn expect_nothing_vanished(
    data: &StudyData,
    layout: &Layout,
    journals: &[(PathBuf, Timestamp)],
    killed: Timestamp,
) -> anyhow::Result<()> {
    for (path, written) in journals {
        let is_of = |t: &TrialEntry| {
            layout.journal(&t.meta.participant, &t.meta.session, t.meta.trial) == *path
        };
        let silent_s = killed.duration_since(*written).as_secs_f64();
        ensure!(
            data.trials.iter().any(is_of) || silent_s <= LOST_S + SLACK_S,
            "{} was {silent_s} s without a write when it was killed, and no trial came of it",
            path.display()
        );
    }
    Ok(())
}

fn load(layout: &Layout) -> anyhow::Result<StudyData> {
    let data = StudyData::load(layout).map_err(|errors| anyhow::anyhow!("{errors:?}"))?;
    ensure!(data.problems.is_empty(), "the study has problems: {:?}", data.problems);
    Ok(data)
}

fn expect_complete(data: &StudyData, number: u32) -> anyhow::Result<()> {
    let status = data.trials.iter().find(|t| t.meta.trial == number).map(|t| t.meta.status);
    ensure!(status == Some(Status::Complete), "trial {number} was finished and now is {status:?}");
    Ok(())
}

/// The same seed makes the same trial: what is left of one is its beginning, bit for bit.
fn expect_same_beginning(trial: &TrialEntry, whole: &Layout) -> anyhow::Result<()> {
    let path = whole.trial(&trial.meta.participant, &trial.meta.session, trial.meta.trial);
    for signal in [Signal::Time, Signal::Theta, Signal::ForceEx, Signal::VoltageBrake] {
        let column = |path: &Path| -> anyhow::Result<Vec<u64>> {
            let trial = zwidth_store::read_trial(path, [signal])?;
            Ok(trial.samples.get(signal).unwrap_or_default().iter().map(|x| x.to_bits()).collect())
        };
        let found = column(&trial.path)?;
        let all = column(&path)?;
        ensure!(
            all.starts_with(&found),
            "{signal:?} of {} is not what was sampled",
            trial.path.display()
        );
        let complete = trial.meta.status == Status::Complete;
        ensure!(!complete || all.len() == found.len(), "{} is not complete", trial.path.display());
    }
    Ok(())
}

/// What the trial in progress lost, s: the time it had run less the time that was recovered. None
/// if it had not begun (no journal, see [`expect_nothing_vanished`]), or had ended by itself.
fn lost(data: &StudyData, number: u32, killed: Timestamp) -> anyhow::Result<Option<f64>> {
    let Some(trial) = data.trials.iter().find(|t| t.meta.trial == number) else { return Ok(None) };
    if trial.meta.status == Status::Complete {
        return Ok(None);
    }
    let read = zwidth_store::read_trial(&trial.path, [Signal::Time])?;
    let began: Timestamp =
        read.file.get("start_utc").context("the trial does not tell its start")?.parse()?;
    let recovered_s =
        read.samples.get(Signal::Time).and_then(<[f64]>::last).copied().unwrap_or(0.0);
    let lost_s = killed.duration_since(began).as_secs_f64() - recovered_s;
    ensure!(
        lost_s <= LOST_S + SLACK_S,
        "trial {number} was killed {lost_s} s after the last sample that is left"
    );
    Ok(Some(lost_s.max(0.0)))
}

/// The session resumes, keeps its order, and ends with every condition recorded once.
fn go_on(program: &Path, root: &Path, layout: &Layout, seed: u64) -> anyhow::Result<()> {
    let record = layout.session(&"P01".parse()?, &"S01".parse()?);
    let before = std::fs::read(&record).ok();
    run(program, root, &words(&line(seed, false)), &[0])?;
    run(program, root, &["verify", STUDY], &[0])?;
    let after = std::fs::read(&record)?;
    ensure!(before.is_none_or(|before| before == after), "the session's record changed");
    let data = load(layout)?;
    let mut met: Vec<_> = data.counting().map(|t| (t.meta.condition(), t.meta.repeat)).collect();
    met.sort();
    let mut planned: Vec<_> = data.study.conditions().into_iter().map(|c| (c, 1)).collect();
    planned.sort();
    ensure!(met == planned, "the session holds {met:?} where {planned:?} was planned");
    Ok(())
}
