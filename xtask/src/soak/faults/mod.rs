//! Every call of each command to the file system fails once: with a full disk, with a disk error,
//! or with the end of the process. After that the data are the old or the new ones, whole; the exit
//! code tells which; and the same command, given again, succeeds.
//!
//! SQLite is tested in this way (sqlite.org/testing.html, "I/O Error Testing"). The calls fail
//! below the program, in `shim.c`, so calls that bypass the program's file layer fail too.

mod case;

use super::fraction;
use crate::shell::{files, lay_down, program, remove, scratch};
use crate::tried::held;
use anyhow::{Context as _, bail, ensure};
use case::{CASES, Case, Kind};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Instant;
use zwidth_store::{hex_blake3, is_unfinished};

/// How calls fail.
const FAULTS: [&str; 4] = ["full", "once", "broken", "kill"];
/// More calls than any command makes.
const MOST_CALLS: u64 = 100_000;

/// What is below a folder, without what differs from run to run.
type State = BTreeMap<String, String>;

/// A study in which a command is tried, and what it is there before and after.
struct Tried<'a> {
    program: &'a Path,
    shim: &'a Path,
    case: &'a Case,
    /// The study before the command.
    before: PathBuf,
    /// Where it is tried.
    root: PathBuf,
    old: State,
    new: State,
}

/// What a sweep found.
#[derive(Default)]
struct Count {
    faults: u64,
    /// Errors after which the program says that it does not know whether the change was made.
    unknown: u64,
}

/// Tries each command (or those named) with one call in `every` failing.
pub(crate) fn faults(every: u64, named: &[&str]) -> anyhow::Result<()> {
    let program = program()?;
    let folder = scratch("faults");
    let began = Instant::now();
    let shim = compiled(&folder)?;
    let mut all = Count::default();
    for case in CASES.iter().filter(|case| named.is_empty() || named.contains(&case.name)) {
        let tried = Tried::prepare(&program, &shim, &folder, case)
            .with_context(|| format!("before '{}'", case.name))?;
        let mut count = Count::default();
        for fault in FAULTS {
            tried.sweep(fault, every, &mut count)?;
        }
        println!("{}: {} faults, {} of them unclear", case.name, count.faults, count.unknown);
        all.faults += count.faults;
        all.unknown += count.unknown;
    }
    println!("{} faults; {} errors say that the outcome is not known", all.faults, all.unknown);
    let what = "calls of every command to the file system that fail, each with a full disk, with an error once, with \
                errors from then on, and with `kill -9`";
    if every == 1 && named.is_empty() {
        held(what, "cargo xtask soak faults".to_owned(), all.faults, began)?;
    }
    Ok(())
}

/// The library that makes calls fail.
fn compiled(folder: &Path) -> anyhow::Result<PathBuf> {
    std::fs::create_dir_all(folder)?;
    let source = folder.join("shim.c");
    let library = folder.join("shim.so");
    std::fs::write(&source, include_str!("shim.c"))?;
    let built = Command::new("cc")
        .args(["-shared", "-fPIC", "-O1", "-o"])
        .args([&library, &source])
        .arg("-ldl")
        .status()
        .context("faults need a C compiler, `cc`, and Linux")?;
    ensure!(built.success(), "the library of faults does not compile");
    Ok(library)
}

impl<'a> Tried<'a> {
    fn prepare(
        program: &'a Path,
        shim: &'a Path,
        folder: &Path,
        case: &'a Case,
    ) -> anyhow::Result<Self> {
        let before = folder.join("before");
        let root = folder.join("root");
        remove(&before)?;
        (case.prepare)(program, &before)?;
        let mut tried =
            Self { program, shim, case, before, root, old: State::new(), new: State::new() };
        tried.fresh()?;
        tried.old = tried.state()?;
        let output = tried.again()?;
        ensure!(output.status.success(), "it fails without a fault: {}", words(&output));
        tried.new = tried.state()?;
        ensure!(tried.old != tried.new, "it changes nothing");
        Ok(tried)
    }

    /// Lays the study down as it was before the command.
    fn fresh(&self) -> anyhow::Result<()> {
        remove(&self.root)?;
        Ok(lay_down(&self.before, &self.root, std::fs::copy)?)
    }

    fn command(&self, line: &str) -> Command {
        let mut command = Command::new(self.program);
        command.current_dir(&self.root).env("HOME", self.root.join("home"));
        command.env_remove("XDG_STATE_HOME").env_remove("ZWIDTH_ROOT").stdin(Stdio::null());
        command.arg("--root").arg(&self.root).args(case::words(line));
        command
    }

    /// The command without a fault.
    fn again(&self) -> anyhow::Result<Output> {
        Ok(self.command(self.case.line).output()?)
    }

    fn sweep(&self, fault: &str, every: u64, count: &mut Count) -> anyhow::Result<()> {
        // Another call of each stretch, so that no call is never tried.
        let words = format!("{} {fault}", self.case.name);
        let first = 1 + (fraction(&words)? * every as f64) as u64;
        let every = every.max(1) * self.case.stride;
        for at in (first..MOST_CALLS).step_by(every as usize) {
            self.fresh()?;
            let Some(output) = self.failing(fault, at)? else { return Ok(()) };
            count.faults += 1;
            let unknown = self.check(fault, &output).with_context(|| {
                format!("'{}', {fault} at call {at}; see {}", self.case.name, self.root.display())
            })?;
            count.unknown += u64::from(unknown);
        }
        bail!("'{}' makes more than {MOST_CALLS} calls", self.case.name)
    }

    /// The command with a fault; nothing if it ran through before the fault came.
    fn failing(&self, fault: &str, at: u64) -> anyhow::Result<Option<Output>> {
        let mark = self.root.with_extension("mark");
        if mark.exists() {
            std::fs::remove_file(&mark)?;
        }
        let output = self
            .command(self.case.line)
            .env("LD_PRELOAD", self.shim)
            .env("FAULTS_KIND", fault)
            .env("FAULTS_AT", at.to_string())
            .env("FAULTS_ROOT", &self.root)
            .env("FAULTS_MARK", &mark)
            .output()?;
        Ok(mark.exists().then_some(output))
    }

    /// Whether what is promised holds; whether the program said that it does not know.
    fn check(&self, fault: &str, output: &Output) -> anyhow::Result<bool> {
        let said = words(output);
        let code = output.status.code();
        ensure!(!said.contains("has a defect") && !said.contains("panicked"), "it panics: {said}");
        match code {
            Some(0 | 1 | 3) => {}
            None if fault == "kill" => {}
            other => bail!("it ends with {other:?}: {said}"),
        }
        ensure!(code != Some(1) || said.contains("error"), "it fails without a word");
        let unknown = said.contains("is not known");
        if self.case.recovers {
            let recovered = self.command("recover demo").output()?;
            let is_done = recovered.status.success() || !self.case.verifies;
            ensure!(is_done, "recover: {}", words(&recovered));
        }
        if self.case.verifies {
            let verified = self.command("verify demo").output()?;
            ensure!(verified.status.success(), "after {said}\nverify: {}", words(&verified));
        }
        let state = self.state()?;
        match (self.case.kind, code) {
            (Kind::Steps, _) => {}
            (Kind::Session, _) => return self.check_session(&said, &state).map(|()| unknown),
            (Kind::Whole, Some(1)) if !unknown => is(&state, &self.old, &said)?,
            (Kind::Whole, Some(0)) => is(&state, &self.new, &said)?,
            (Kind::Whole, _) => ensure!(
                state == self.old || state == self.new,
                "neither the old state nor the new one: {}\n{said}",
                difference(&state, &self.old)
            ),
        }
        if state != self.new {
            let again = self.again()?;
            ensure!(again.status.success(), "after {said}\nagain: {}", words(&again));
            is(&self.state()?, &self.new, &words(&again))?;
        }
        Ok(unknown)
    }

    /// Whether what was said to be stored is there, and the session goes on to its end.
    fn check_session(&self, said: &str, state: &State) -> anyhow::Result<()> {
        let stored =
            said.lines().filter_map(|line| line.strip_prefix("trial ")?.strip_suffix(" stored"));
        for trial in stored {
            let file = format!("/trial-{:03}.parquet", trial.parse::<u32>()?);
            ensure!(
                state.keys().any(|name| name.ends_with(&file)),
                "trial {trial} is lost: {said}"
            );
        }
        let again = self.again()?;
        ensure!(again.status.success(), "after {said}\nagain: {}", words(&again));
        let end = self.state()?;
        ensure!(!end.keys().any(|name| name.contains("/journal/")), "a journal stays");
        let is_kept = |(name, content): (&String, &String)| {
            end.get(name).is_some_and(|at_end| at_end.starts_with(content.as_str()))
        };
        ensure!(state.iter().all(is_kept), "what was kept is not: {}", difference(state, &end));
        Ok(())
    }

    /// The files that are looked at, each by what is in it, without what differs from run to run.
    fn state(&self) -> anyhow::Result<State> {
        let mut state = State::new();
        for path in files(&self.root)? {
            let name = path.strip_prefix(&self.root)?.to_string_lossy().into_owned();
            if self.case.looked_at.iter().any(|top| name.starts_with(top))
                && let Some(content) = content(&name, &std::fs::read(&path)?)
            {
                state.insert(name, content);
            }
        }
        Ok(state)
    }
}

fn is(state: &State, wanted: &State, said: &str) -> anyhow::Result<()> {
    ensure!(state == wanted, "{}\n{said}", difference(state, wanted));
    Ok(())
}

fn words(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    format!("{}\n{}", text(&output.stdout), text(&output.stderr))
}

/// Which files differ.
fn difference(state: &State, wanted: &State) -> String {
    let names: std::collections::BTreeSet<&String> = state.keys().chain(wanted.keys()).collect();
    let differ = names.into_iter().filter(|name| state.get(*name) != wanted.get(*name));
    let told = differ
        .map(|name| format!("{name}: {:?}, and should be {:?}", state.get(name), wanted.get(name)));
    told.take(5).collect::<Vec<_>>().join("\n")
}

/// A file's content, without when it was written; nothing of what is no data.
fn content(name: &str, bytes: &[u8]) -> Option<String> {
    let last = name.rsplit('/').next().unwrap_or(name);
    match last {
        // A lock, what was hashed before; a head may be behind its log. What a write that was cut
        // short left is a finding of `verify`.
        ".lock" | ".participant" | ".hashes.json" => None,
        _ if is_unfinished(Path::new(last)) => None,
        _ if last.ends_with(".head") => None,
        _ if last.ends_with(".events.jsonl") => {
            let lines = String::from_utf8_lossy(bytes);
            // A sweep's or a trial's hash follows from when it was recorded.
            let event = |line: &str| match serde_json::from_str::<Value>(line) {
                Ok(Value::Object(mut line)) => {
                    let mut what = line.remove("what").unwrap_or_default();
                    if let Some(what) = what.as_object_mut() {
                        what.retain(|key, _| !key.contains("blake3"));
                        for inner in what.values_mut().filter_map(Value::as_object_mut) {
                            inner.retain(|key, _| !key.contains("blake3") && key != "time_ms");
                        }
                    }
                    what.to_string()
                }
                _ => line.to_owned(),
            };
            let events: Vec<String> = lines.lines().map(event).collect();
            (!events.is_empty()).then(|| events.join("\n"))
        }
        _ if last.ends_with(".parquet") && name.starts_with("raw/") => Some("recorded".to_owned()),
        _ if name.starts_with("raw/") && last.ends_with(".json") && last != "plan.json" => {
            Some("record".to_owned())
        }
        "records.json" => None,
        _ => Some(hex_blake3(bytes)[..12].to_owned()),
    }
}
