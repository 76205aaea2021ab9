//! Sessions recorded by the program on the simulated device: through plain mode, killed and
//! resumed, refused, blinded; and whole simulated studies.

use crate::binary::{Ran, binary, ran, zwidth, zwidth_line};
use crate::folders::{edit, files, listing};
use serde_json::Value;
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::Duration;
use tempfile::TempDir;
use zwidth_study::template;

/// Trials of the small study: one to practise, and one of each condition.
pub(crate) const TRIALS: usize = 7;

/// A small study in a folder of its own.
pub(crate) struct Desk {
    folder: TempDir,
}

impl Desk {
    /// At the thesis' rate.
    pub(crate) fn new(blinded: bool) -> Self {
        Self::at(120.0, blinded)
    }

    /// For real time on any machine, however busy: safety stops a loop that is late for three
    /// periods.
    pub(crate) fn slow() -> Self {
        Self::at(30.0, false)
    }

    fn at(rate_hz: f64, blinded: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let text = template(&"small".parse().unwrap())
            .replace("\nrepeats = 6\n", "\nrepeats = 1\n")
            .replace("\nfamiliarisation = 3\n", "\nfamiliarisation = 1\n")
            .replace("\npause_s = 5.0\n", "\npause_s = 3.0\n")
            .replace("\nrate_hz = 1000.0\n", &format!("\nrate_hz = {rate_hz:?}\n"))
            .replace("\nblinded = false\n", &format!("\nblinded = {blinded}\n"));
        let path = folder.path().join("raw/small/study.toml");
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
        Self { folder }
    }

    pub(crate) fn root(&self) -> &Path {
        self.folder.path()
    }

    pub(crate) fn keys(&self) -> PathBuf {
        self.root().join("keys")
    }

    pub(crate) fn command(&self, more: &[&str]) -> Command {
        let mut command = Command::new(binary());
        command
            .arg("--root")
            .arg(self.root())
            .args(["acquire", "small", "-p", "P01", "-s", "S01", "--plain"]);
        command.arg("--key").arg(self.keys()).args(more).env_remove("ZWIDTH_ROOT");
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// A session in simulated time, to which these lines are said.
    pub(crate) fn acquire(&self, lines: &str, more: &[&str]) -> Ran {
        let mut child = self.command(more).arg("--fast").spawn().unwrap();
        // A program that refuses to begin reads nothing.
        let _ = child.stdin.take().unwrap().write_all(lines.as_bytes());
        ran(&child.wait_with_output().unwrap())
    }

    /// A session that goes by itself, in simulated time.
    pub(crate) fn finish(&self) -> Ran {
        self.acquire("", &["--auto"])
    }

    /// Changes study.toml.
    pub(crate) fn edit_study(&self, from: &str, to: &str) {
        edit(&self.root().join("raw/small/study.toml"), from, to);
    }

    pub(crate) fn session(&self) -> Value {
        zwidth(self.root(), &["--json", "list", "small"]).json()[0]["sessions"][0].clone()
    }

    pub(crate) fn record(&self) -> Value {
        serde_json::from_str(
            &fs::read_to_string(self.root().join("raw/small/sessions/P01_S01.json")).unwrap(),
        )
        .unwrap()
    }

    pub(crate) fn unseal(&self) -> Ran {
        let session = ["unseal", "small", "-p", "P01", "-s", "S01", "--key"];
        zwidth(self.root(), &[&session[..], &[self.keys().to_str().unwrap()]].concat())
    }

    pub(crate) fn verify(&self) {
        zwidth(self.root(), &["verify", "small"]).exits(0).prints(&["no findings"]);
    }

    pub(crate) fn trials(&self) -> usize {
        files(&self.root().join("raw/small/trials"), "parquet").len()
    }
}

/// A session in real time, one line at a time.
pub(crate) struct Live {
    pub(crate) child: Child,
    says: BufReader<ChildStdout>,
    /// Held open: its end is `quit`.
    hears: ChildStdin,
    /// Nothing is sent: that it is gone says that nobody waits for the program any more.
    _waiting: Sender<()>,
}

/// A program that waits for what never comes would hold up the tests for ever: after so long it is
/// ended, and what it said is told.
const FOR_EVER: Duration = Duration::from_secs(20 * 60);

/// Ends the program with that number, unless nobody waits for it by then.
pub(crate) fn ended_after_all(process: u32) -> Sender<()> {
    let (waiting, gone) = channel();
    thread::spawn(move || {
        if gone.recv_timeout(FOR_EVER) == Err(RecvTimeoutError::Timeout) {
            let _ = Command::new("kill").args(["-KILL", &process.to_string()]).status();
        }
    });
    waiting
}

impl Live {
    pub(crate) fn new(desk: &Desk, more: &[&str]) -> Self {
        Self::of(desk.command(more))
    }

    /// A program that writes lines and reads some.
    pub(crate) fn of(mut command: Command) -> Self {
        let mut child = command.spawn().unwrap();
        let says = BufReader::new(child.stdout.take().unwrap());
        let hears = child.stdin.take().unwrap();
        let _waiting = ended_after_all(child.id());
        Self { child, says, hears, _waiting }
    }

    /// A session that came as far as the line that begins so. Where the machine stood still for
    /// longer than a control loop may, while the device was checked, it is begun again: nothing was
    /// recorded by then.
    pub(crate) fn begun(desk: &Desk, more: &[&str], start: &str) -> Self {
        const STOOD_STILL: &str = "stopped device check: the control loop missed ";
        loop {
            let mut live = Self::new(desk, more);
            if live.until_any(&[start, STOOD_STILL]).starts_with(start) {
                return live;
            }
            // One that goes by itself has ended.
            let _ = writeln!(live.hears, "quit");
            live.child.wait().unwrap();
        }
    }

    /// Goes on, as often as it takes on a machine that stands still for so long that safety stops
    /// what is done, to the line that begins so.
    #[track_caller]
    pub(crate) fn on_to(&mut self, start: &str) -> String {
        loop {
            let line = self.until_any(&[start, "stopped ", "ready ", "hold "]);
            if line.starts_with(start) {
                return line;
            }
            self.say("start");
        }
    }

    /// Reads on to the line that begins so.
    #[track_caller]
    pub(crate) fn until(&mut self, start: &str) -> String {
        self.until_any(&[start])
    }

    /// Reads on to the line that begins in one of these ways.
    #[track_caller]
    pub(crate) fn until_any(&mut self, starts: &[&str]) -> String {
        self.read_until(starts).1
    }

    /// Reads on to the line that begins so; what came before it.
    #[track_caller]
    pub(crate) fn all_until(&mut self, start: &str) -> String {
        self.read_until(&[start]).0
    }

    /// Reads on to the line that begins in one of these ways: what came before it, and the line.
    #[track_caller]
    fn read_until(&mut self, starts: &[&str]) -> (String, String) {
        let mut all = String::new();
        loop {
            let mut line = String::new();
            if self.says.read_line(&mut line).unwrap() == 0 {
                let mut told = String::new();
                self.child.stderr.as_mut().unwrap().read_to_string(&mut told).unwrap();
                panic!("none of {starts:?} came: {all}{told}");
            }
            if starts.iter().any(|start| line.starts_with(start)) {
                return (all, line);
            }
            all += &line;
        }
    }

    /// Nobody reads what it writes any more; its input stays open.
    pub(crate) fn unread(self) -> (Child, ChildStdin) {
        (self.child, self.hears)
    }

    pub(crate) fn say(&mut self, line: &str) {
        writeln!(self.hears, "{line}").unwrap();
    }
}

/// A session in the middle of its first trial, whose journal holds samples, and its desk. Where the
/// machine stood still for so long that safety stopped that trial, another desk has its turn.
pub(crate) fn journaling(more: &[&str]) -> (Desk, Live) {
    loop {
        let desk = Desk::slow();
        let mut live = if more.contains(&"--auto") {
            Live::begun(&desk, more, "trial 1 ")
        } else {
            let mut live = Live::begun(&desk, more, "ready 1 ");
            live.say("start");
            live.until("trial 1 ");
            live
        };
        if waits_for_samples(&desk, &mut live) {
            return (desk, live);
        }
        let _ = live.child.kill();
        live.child.wait().unwrap();
    }
}

/// Whether the journal of the trial that runs holds samples.
pub(crate) fn holds_samples(desk: &Desk) -> bool {
    let held = |path: &PathBuf| fs::metadata(path).is_ok_and(|m| m.len() > 3000);
    files(&desk.root().join("raw/small/journal"), "journal").iter().any(held)
}

/// Waits until a trial's journal holds samples; whether it does before the trial is over.
fn waits_for_samples(desk: &Desk, live: &mut Live) -> bool {
    while !holds_samples(desk) {
        if desk.trials() > 0 || live.child.try_wait().unwrap().is_some() {
            return false;
        }
        thread::yield_now();
    }
    true
}

#[test]
fn a_session_said_line_by_line_leaves_every_trial_with_its_answer() {
    let desk = Desk::new(false);
    let lines = "start\nanswer 4\n".repeat(2)
        + "repeat\n"
        + &"start\n5\n".repeat(TRIALS - 1)
        + "note well done\nquit\n";
    desk.acquire(&lines, &[]).exits(0).prints(&[
        "ready 1 (place 1 of 7)",
        "\ndone 7 of 7\n",
        "trial 2 does not count: it is done again as trial 8",
    ]);
    desk.verify();
    let session = desk.session();
    assert_eq!((&session["trials_that_count"], &session["to_go"]), (&6.into(), &0.into()));
    let log =
        fs::read_to_string(desk.root().join("raw/small/sessions/P01_S01.events.jsonl")).unwrap();
    assert!(log.contains("well done"), "{log}");
    assert_eq!(desk.acquire("quit\n", &[]).exits(0).out.lines().last(), Some("left 7 of 7"));
}

#[test]
fn a_session_that_is_quit_says_how_to_go_on_and_goes_on_in_the_same_order() {
    let desk = Desk::new(false);
    desk.acquire("start\n3\nstart\n3\nquit\n", &[])
        .exits(3)
        .says(&["2 of 7 trials", "zwidth acquire small -p P01 -s S01"]);
    let before = (desk.record(), desk.session());
    assert_eq!(before.1["to_go"], 5);
    desk.finish().exits(0);
    assert_eq!(desk.record(), before.0);
    assert_eq!((desk.trials(), &desk.session()["trials_that_count"]), (TRIALS, &6.into()));
    desk.verify();
}

#[test]
fn a_killed_session_loses_no_trial_and_resumes_in_the_same_order() {
    let (desk, mut live) = journaling(&["--auto"]);
    live.child.kill().unwrap();
    live.child.wait().unwrap();
    let order = desk.record();
    zwidth(desk.root(), &["recover", "small"])
        .exits(0)
        .prints(&["recovered from its journal: incomplete"]);
    desk.verify();
    assert_eq!(desk.trials(), 1);
    desk.finish().exits(0).prints(&["resumed: 0 of 7", "again for trial 1"]);
    assert_eq!(desk.record(), order);
    assert_eq!((desk.trials(), &desk.session()["trials_that_count"]), (TRIALS + 1, &6.into()));
    desk.verify();
    let again = zwidth(desk.root(), &["--json", "recover", "small"]).exits(0);
    assert_eq!(again.json(), Value::Array(Vec::new()));
}

#[cfg(unix)]
#[test]
fn a_signal_that_ends_the_program_ends_its_trial_and_leaves_everything_in_order() {
    for signal in ["-TERM", "-QUIT", "-HUP", "-INT"] {
        let (desk, mut live) = journaling(&["--auto"]);
        Command::new("kill").args([signal, &live.child.id().to_string()]).status().unwrap();
        live.until("left 0 of 7");
        assert_eq!(live.child.wait().unwrap().code(), Some(1), "{signal}");
        desk.verify();
        assert_eq!(desk.trials(), 1, "{signal}");
    }
}

#[test]
fn a_stop_is_obeyed_while_a_trial_runs_and_homing_comes_before_the_next() {
    let (desk, mut live) = journaling(&[]);
    live.say("stop");
    live.until("trial 1 does not count");
    live.until("stopped ");
    live.say("start");
    live.until("homing");
    live.until("ready 8 (place 1 of 7)");
    live.say("quit");
    assert_eq!(live.child.wait().unwrap().code(), Some(3));
    desk.verify();
}

#[test]
fn a_second_process_is_refused_and_told_who_is_there() {
    let desk = Desk::slow();
    let mut live = Live::begun(&desk, &[], "ready 1 ");
    desk.finish()
        .exits(1)
        .one_error()
        .says(&["in use: zwidth acquire, process ", &live.child.id().to_string()]);
    zwidth(desk.root(), &["recover", "small"]).exits(1).one_error().says(&["in use"]);
    live.say("quit");
    live.child.wait().unwrap();
    desk.finish().exits(0);
}

#[test]
fn a_study_of_several_axes_is_not_recorded_with_a_device_of_one() {
    let desk = Desk::new(false);
    desk.edit_study("schema = 2", "schema = 3");
    let axes = "[axes]\nframe = \"x right, y up, z to the person\"\npush = [0.0, 0.0, -1.0]\n";
    desk.edit_study("[coordinate]", &format!("{axes}\n[coordinate]"));
    desk.acquire("start\n3\nquit\n", &[]).exits(1).one_error().says(&["[axes]", "import"]);
    assert!(!desk.root().join("raw/small/trials").exists());
}

#[test]
fn a_session_refuses_what_is_not_what_it_began_with() {
    let desk = Desk::new(false);
    desk.acquire("start\n3\nquit\n", &[]).exits(3);
    let refuses = |more: &[&str], words: &str| {
        desk.acquire("", more).exits(1).one_error().says(&[words]);
    };
    refuses(&["--rate", "60"], "the rate is 60 Hz, and was 120 Hz");
    refuses(&["--seed", "5"], "the seed is 5, and was ");
    let trial = files(&desk.root().join("raw/small/trials"), "parquet").remove(0);
    refuses(&["--device", &format!("playback:{}", trial.display())], "the device is playback");
    let calibration = desk.root().join("raw/small/calibration.toml");
    let other = zwidth_study::Calibration::thesis().to_toml().unwrap().replace("4.16", "4.0");
    fs::write(&calibration, other).unwrap();
    refuses(&[], "the calibration is ");
    fs::remove_file(calibration).unwrap();
    desk.finish().exits(0);
}

#[test]
fn a_bad_device_and_a_screen_without_a_terminal_are_one_clear_error_each() {
    let desk = Desk::new(false);
    let live = |more: &[&str]| ran(&desk.command(more).output().unwrap());
    live(&["--device", "robot"]).exits(2).says(&["twin|rig[:PORT]|playback:FILE"]);
    let acquire =
        |participant| zwidth(desk.root(), &["acquire", "small", "-p", participant, "-s", "S01"]);
    acquire("P/1").exits(2).says(&["participant id"]);
    acquire("P01").exits(1).one_error().says(&["--plain"]);
}

#[test]
fn a_blinded_session_tells_no_mode_until_it_is_unsealed() {
    let desk = Desk::new(true);
    let begun = desk.acquire("start\n3\nquit\n", &[]).exits(3);
    desk.unseal().exits(1).one_error().says(&["6 trials to go", "--unfinished"]);
    let ended = desk.finish().exits(0);
    let listed = zwidth(desk.root(), &["list"])
        .exits(0)
        .prints(&["sealed: `zwidth unseal small -p P01 -s S01`"]);
    let names = listing(&desk.root().join("raw")).into_keys().collect::<Vec<_>>().join("\n");
    let record = desk.record().to_string();
    for word in ["active", "passive", "hybrid"] {
        for text in [&begun.out, &begun.err, &ended.out, &ended.err, &listed.out, &names, &record] {
            assert!(!text.to_lowercase().contains(word), "{word} in {text}");
        }
    }
    desk.verify();
    zwidth(desk.root(), &["unseal", "small", "-p", "P01", "-s", "S01", "--key", "elsewhere"])
        .exits(1)
        .says(&["--key"]);
    desk.unseal().exits(0);
    desk.unseal().exits(0).says(&["already"]);
    let session = desk.session();
    assert_eq!((&session["sealed"], &session["trials_that_count"]), (&false.into(), &6.into()));
    desk.verify();
}

#[test]
fn a_simulated_study_is_the_same_bytes_on_one_thread_and_on_many_and_other_bytes_from_another_seed()
{
    let make = |threads: &str, seed: &str| {
        let desk = Desk::new(false);
        let twin = "twin small --participants 2 --sessions 2 --key none";
        zwidth_line(desk.root(), &format!("--threads {threads} {twin} --seed {seed}")).exits(0);
        desk.verify();
        let raw = listing(&desk.root().join("raw"));
        assert_eq!(raw.keys().filter(|name| name.contains("/trial-")).count(), 4 * TRIALS);
        assert_eq!(raw.keys().filter(|name| name.contains("/sweep-")).count(), 45);
        (desk, raw)
    };
    let (desk, one) = make("1", "2");
    assert_eq!(make("4", "2").1, one);
    assert_ne!(make("4", "3").1, one);
    let words = ["exists already", "choose another study", "remove all of", "raw/small"];
    let again = zwidth_line(desk.root(), "twin small --participants 1 --sessions 1");
    again.exits(1).one_error().says(&words);
}

#[test]
fn a_study_that_is_not_there_is_made_from_the_template() {
    let root = tempfile::tempdir().unwrap();
    let twin = "twin made --participants 1 --sessions 1 --seed 1 --rate 120";
    zwidth_line(root.path(), twin).exits(0);
    let listed = zwidth(root.path(), &["--json", "list", "made"]).exits(0).json();
    let session = &listed[0]["sessions"][0];
    let counts = (&session["trials_that_count"], &session["familiarisation"]);
    assert_eq!(counts, (&36.into(), &3.into()));
    assert_eq!(session["missing"], Value::Array(Vec::new()));
    zwidth(root.path(), &["verify", "made"]).exits(0).prints(&["no findings"]);
}

#[test]
fn the_device_check_and_sweeps_are_recorded_on_the_simulated_device() {
    let desk = Desk::new(false);
    let checks = zwidth(desk.root(), &["--json", "check", "small", "--fast"]).exits(0).json();
    assert!(checks.as_array().unwrap().iter().all(|c| c["ok"] == true), "{checks:#}");
    zwidth(desk.root(), &["characterise", "small", "motor", "--sweeps", "2"]).exits(0);
    zwidth_line(desk.root(), "characterise small motor").exits(0).prints(&["sweep-03.parquet"]);
    zwidth_line(desk.root(), "characterise small motor --device playback:x").exits(1).one_error();
    desk.verify();
    desk.finish().exits(0);
    assert!(desk.record()["checks"].as_array().is_some_and(|checks| checks.len() > 5));
}
