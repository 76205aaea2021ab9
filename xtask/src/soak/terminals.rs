//! Terminals that disappear at random instants of a session in real time: windows that are closed,
//! with or without a signal to their program, and pipes whose reader ends. However that happens,
//! the program ends by itself, no journal is left that should be a trial, the study is not locked,
//! and the session can be resumed. The participant's screen ends likewise, and another one is
//! accepted.

use super::{SESSION, STUDY, fraction, fresh, run, started};
use crate::shell::{program, scratch, words};
use crate::tried::held;
use anyhow::{Context as _, bail, ensure};
use std::ffi::OsString;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::process::ExitStatusExt as _;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};
use zwidth_link::Window;
use zwidth_store::Layout;

/// A session of seven trials, slow enough for real time on a busy machine.
const SHORT: [(&str, &str); 4] = [
    ("\nrepeats = 6\n", "\nrepeats = 1\n"),
    ("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n"),
    ("\npause_s = 5.0\n", "\npause_s = 1.0\n"),
    ("\nrate_hz = 1000.0\n", "\nrate_hz = 120.0\n"),
];
/// Longest time from a program's first word to the end of its terminal, s: the device check, homing
/// and some two trials.
const LONGEST_S: f64 = 15.0;
/// A program that still runs so long after its terminal went away hangs.
const HANGS: Duration = Duration::from_secs(30);
/// A program says its first word within this time.
const BEGINS: Duration = Duration::from_secs(60);
/// Between two looks.
const LOOK: Duration = Duration::from_millis(10);
/// How often it tells how far it is.
const TOLD_EVERY: u32 = 10;

/// What goes away.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// The experimenter's screen.
    Screen,
    /// The experimenter's window with lines.
    Lines,
    /// The reader of the experimenter's lines.
    Reader,
    /// The window of a session under nohup.
    Nohup,
    /// The participant's screen.
    Participant,
    /// The participant's window with lines.
    ParticipantLines,
}

const KINDS: [Kind; 6] = [
    Kind::Screen,
    Kind::Participant,
    Kind::Lines,
    Kind::Reader,
    Kind::ParticipantLines,
    Kind::Nohup,
];

/// Lets so many terminals go away.
pub(crate) fn terminals(tries: u32, seed: u64) -> anyhow::Result<()> {
    let program = &program()?;
    let root = scratch("terminals").join("closed");
    let began = Instant::now();
    let mut within = 0;
    let mut longest = Duration::ZERO;
    let mut codes = String::new();
    for number in 0..tries {
        let kind = KINDS[number as usize % KINDS.len()];
        // Those of a kind by turns.
        let is_told = (number as usize / KINDS.len()).is_multiple_of(2);
        let after = LONGEST_S * fraction(&format!("terminals {seed} {number}"))?;
        let layout = fresh(&root, &SHORT)?;
        let what = format!(
            "try {number} of seed {seed}, {kind:?} (told: {is_told}), {after:.3} s after its first word; see {}",
            root.display()
        );
        let closed =
            Closed { program, layout: &layout, is_told, after: Duration::from_secs_f64(after) };
        let ended = match kind {
            Kind::Participant => closed.participant(""),
            Kind::ParticipantLines => closed.participant(" --plain"),
            _ => closed.session(kind),
        };
        let ended = ended.with_context(|| what.clone())?;
        within += u32::from(ended.within_trial);
        longest = longest.max(ended.took);
        write!(codes, " {}", ended.code)?;
        is_in_order(program, &layout).with_context(|| what.clone())?;
        if (number + 1) % TOLD_EVERY == 0 {
            println!("{} of {tries} terminals, {within} of sessions within a trial", number + 1);
        }
    }
    println!(
        "{tries} terminals went away, {within} of sessions within a trial; the programs ended after at most {:.2} s, with the codes{codes}",
        longest.as_secs_f64()
    );
    let what = "terminals that go away at random instants of a session: the program ends in order";
    held(what, format!("cargo xtask soak terminals {tries}"), tries.into(), began)
}

/// A terminal that is to go away.
struct Closed<'a> {
    program: &'a Path,
    layout: &'a Layout,
    is_told: bool,
    after: Duration,
}

/// How its program ended.
struct Ended {
    code: i32,
    took: Duration,
    /// A trial was being recorded.
    within_trial: bool,
}

impl Closed<'_> {
    fn arguments(&self, line: &str) -> Vec<OsString> {
        let root: [OsString; 2] = ["--root".into(), self.layout.root().into()];
        root.into_iter().chain(line.split(' ').map(OsString::from)).collect()
    }

    fn acquire(&self, more: &str) -> Vec<OsString> {
        self.arguments(&format!("acquire {STUDY} {SESSION} {more}"))
    }

    /// The terminal of a session that runs by itself.
    fn session(&self, kind: Kind) -> anyhow::Result<Ended> {
        let log = self.layout.root().join("log");
        if kind == Kind::Reader {
            let line = format!("acquire {STUDY} {SESSION} --plain --auto");
            let mut child = started(self.program, self.layout.root(), &line)?;
            let mut reader = BufReader::new(child.stdout.take().context("no output")?);
            let mut line = String::new();
            reader.read_line(&mut line)?;
            std::thread::sleep(self.after);
            return self.ended(child, || drop(reader), &[1]);
        }
        let (window, child) = match kind {
            Kind::Screen => Window::open(self.program, self.acquire("--auto"), self.is_told)?,
            Kind::Nohup => {
                let script = "log=$1; shift; exec nohup \"$0\" \"$@\" >\"$log\" 2>&1";
                let mut all: Vec<OsString> = vec!["-c".into(), script.into()];
                all.extend([self.program.into(), log.clone().into()]);
                all.extend(self.acquire("--plain --auto"));
                // Nothing but the system can tell it: it has no end of the window.
                Window::open("sh", all, true)?
            }
            _ => Window::open(self.program, self.acquire("--plain --auto"), self.is_told)?,
        };
        let said = || std::fs::metadata(&log).is_ok_and(|log| log.len() > 0);
        wait_until(BEGINS, || Ok(!window.drawn().is_empty() || said()))?;
        std::thread::sleep(self.after);
        self.ended(child, || window.close(), &[1])
    }

    /// The participant's terminal beside a session, which goes on, and lets another one in.
    fn participant(&self, more: &str) -> anyhow::Result<Ended> {
        let mut session = Beside(
            Command::new(self.program)
                .args(self.acquire("--plain"))
                .stdin(Stdio::piped())
                .stdout(File::create(self.layout.root().join("log"))?)
                .stderr(Stdio::null())
                .spawn()?,
        );
        let mut lines = session.0.stdin.take().context("no input")?;
        for _ in 0..20 {
            writeln!(lines, "start\n4")?;
        }
        wait_until(BEGINS, || Ok(self.layout.raw().join(".participant").exists()))?;
        let screen = self.arguments(&format!("participant {STUDY}{more}"));
        let (window, child) = Window::open(self.program, screen, self.is_told)?;
        wait_until(BEGINS, || Ok(!window.drawn().is_empty()))?;
        std::thread::sleep(self.after);
        let ended = self.ended(child, || window.close(), &[0])?;
        ensure!(session.0.try_wait()?.is_none(), "the session ended with it");
        // Another participant's screen is let in.
        let line = format!("participant {STUDY} --plain");
        let mut another = Beside(started(self.program, self.layout.root(), &line)?);
        let mut line = String::new();
        BufReader::new(another.0.stdout.take().context("no output")?).read_line(&mut line)?;
        ensure!(!line.is_empty(), "no other participant's screen was let in");
        drop(another);
        Command::new("kill").args(["-TERM", &session.0.id().to_string()]).status()?;
        wait_until(HANGS, || Ok(session.0.try_wait()?.is_some()))?;
        Ok(ended)
    }

    /// Takes the terminal away, and waits for the program's end.
    fn ended(
        &self,
        child: Child,
        go_away: impl FnOnce(),
        allowed: &[i32],
    ) -> anyhow::Result<Ended> {
        let mut child = Beside(child);
        let within_trial = !journals(self.layout)?.is_empty();
        let gone = Instant::now();
        go_away();
        let mut status = None;
        wait_until(HANGS, || {
            status = child.0.try_wait()?;
            Ok(status.is_some())
        })
        .context("the program hangs")?;
        let code = match status.map(|status: ExitStatus| (status.code(), status.signal())) {
            // One whose session had come to its end by itself, or that safety had stopped.
            Some((Some(code), _)) if allowed.contains(&code) || code == 0 || code == 3 => code,
            other => bail!("the program ended with {other:?}"),
        };
        Ok(Ended { code, took: gone.elapsed(), within_trial })
    }
}

/// A process that does not outlive what it is beside.
struct Beside(Child);

impl Drop for Beside {
    fn drop(&mut self) {
        // One that has ended already is not there to be killed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn wait_until(
    longest: Duration,
    mut holds: impl FnMut() -> anyhow::Result<bool>,
) -> anyhow::Result<()> {
    let began = Instant::now();
    while !holds()? {
        ensure!(began.elapsed() < longest, "nothing came of it within {} s", longest.as_secs());
        std::thread::sleep(LOOK);
    }
    Ok(())
}

fn journals(layout: &Layout) -> anyhow::Result<Vec<OsString>> {
    if !layout.journals().exists() {
        return Ok(Vec::new());
    }
    let entries = std::fs::read_dir(layout.journals())?;
    Ok(entries.map(|entry| entry.map(|entry| entry.file_name())).collect::<Result<_, _>>()?)
}

/// What holds however a session was left: nothing is to be recovered, nobody has its lock, and it can
/// be gone on with.
fn is_in_order(program: &Path, layout: &Layout) -> anyhow::Result<()> {
    let left = journals(layout)?;
    ensure!(left.is_empty(), "journals were left: {left:?}");
    run(program, layout.root(), &["recover", STUDY], &[0])?;
    run(program, layout.root(), &["verify", STUDY], &[0])?;
    let again = format!("acquire {STUDY} {SESSION} --plain --auto --fast");
    run(program, layout.root(), &words(&again), &[0])?;
    run(program, layout.root(), &["verify", STUDY], &[0])?;
    Ok(())
}
