//! Terminals that go away while a session runs: closed windows, pipes whose reader is gone.

use crate::acquire::{Desk, Live, TRIALS, ended_after_all, holds_samples, journaling};
use crate::binary::{binary, zwidth};
use crate::folders::files;
use crate::participant::{ends, lines, screen, session};
use crate::small::{Study, repeats};
use serde_json::Value;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Child, Command};
use std::thread;
use zwidth_link::Window;

/// The last line that a window shows after a program has ended in it.
const ENDED: &str = "it has ended";

/// A phase in which a window is closed, as the participant's screen tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum In {
    Wait,
    Ready,
    Trial,
    Question,
    Pause,
    Stopped,
}

const PHASES: [In; 6] = [In::Wait, In::Ready, In::Trial, In::Question, In::Pause, In::Stopped];

fn arguments(root: &Path, more: &[&str]) -> Vec<OsString> {
    let mut all = vec!["--root".into(), root.into()];
    all.extend(more.iter().map(OsString::from));
    all
}

/// The participant's screen as lines, beside a session in a window, once it can be opened.
fn beside(desk: &Desk, window: &Window, child: &mut Child) -> Live {
    while !desk.root().join("raw/small/.participant").exists() {
        if let Some(status) = child.try_wait().unwrap() {
            panic!("it ended with {status}: {}", String::from_utf8_lossy(&window.drawn()));
        }
        thread::yield_now();
    }
    lines(desk)
}

/// Goes on in a window to a phase. Where the machine stands still for so long that safety stops what
/// is done, it is begun again.
fn go_on_to(phase: In, window: &Window, lines: &mut Live, is_plain: bool) {
    let (start, answer, stop) =
        if is_plain { ("start\n", "4\n", "stop\n") } else { ("\r", "4", " ") };
    if phase == In::Wait {
        lines.until("wait: ");
        return;
    }
    loop {
        let line = lines.until_any(&["ready: ", "go: ", "question ", "pause: ", "stopped: "]);
        let is = match line.split([':', ' ']).next() {
            Some("ready") => In::Ready,
            Some("go") => In::Trial,
            Some("question") => In::Question,
            Some("pause") => In::Pause,
            _ => In::Stopped,
        };
        match (is, phase) {
            _ if is == phase => return,
            (In::Ready, In::Stopped) => window.type_keys(stop),
            (In::Question, _) => window.type_keys(answer),
            (In::Trial | In::Pause, _) => {}
            _ => window.type_keys(start),
        }
    }
}

/// What holds however a session was left: nothing is to be recovered, and nobody has its lock.
fn is_in_order(desk: &Desk, what: &str) {
    assert!(files(&desk.root().join("raw/small/journal"), "journal").is_empty(), "{what}");
    let recovered = zwidth(desk.root(), &["--json", "recover", "small"]).exits(0).json();
    assert_eq!(recovered, Value::Array(Vec::new()), "{what}");
    desk.verify();
}

fn a_closed_window_ends_a_session_in_order(is_plain: bool) {
    for (number, phase) in PHASES.into_iter().enumerate() {
        // By turns a window of a shell, whose program is told, and one whose program has to notice.
        let is_told = (number % 2 == 0) != is_plain;
        let what = format!("{phase:?}, told: {is_told}");
        let desk = Desk::slow();
        let mut acquire = arguments(desk.root(), &["acquire", "small", "-p", "P01", "-s", "S01"]);
        acquire.extend(["--key".into(), desk.keys().into()]);
        acquire.extend(is_plain.then(|| "--plain".into()));
        let (window, mut child) = Window::open(binary(), &acquire, is_told).unwrap();
        let _waiting = ended_after_all(child.id());
        let mut lines = beside(&desk, &window, &mut child);
        go_on_to(phase, &window, &mut lines, is_plain);
        while phase == In::Trial && desk.trials() == 0 && !holds_samples(&desk) {
            thread::yield_now();
        }
        window.close();
        assert_eq!(child.wait().unwrap().code(), Some(1), "{what}");
        // The participant's screen says so, unless it did before, and waits for the session to go on.
        if phase != In::Stopped {
            lines.until("stopped: ");
        }
        assert!(lines.child.try_wait().unwrap().is_none(), "{what}");
        lines.child.kill().unwrap();
        lines.child.wait().unwrap();
        is_in_order(&desk, &what);
        let kept = usize::from(!matches!(phase, In::Wait | In::Ready | In::Stopped));
        assert!(desk.trials() >= kept, "{what}");
    }
}

#[test]
fn a_closed_window_ends_a_session_in_order_in_every_phase() {
    a_closed_window_ends_a_session_in_order(false);
}

#[test]
fn a_closed_window_ends_a_session_of_lines_in_order_in_every_phase() {
    a_closed_window_ends_a_session_in_order(true);
}

#[test]
fn a_closed_window_of_the_participant_ends_its_program_and_another_can_be_opened() {
    let desk = Desk::new(false);
    let mut session = session(&desk);
    let phases = [("", "ready "), ("start", "question "), ("4", "ready "), ("stop", "stopped ")];
    for (number, (word, line)) in phases.into_iter().enumerate() {
        if !word.is_empty() {
            session.say(word);
            session.until(line);
        }
        for (more, is_told) in [(None, number % 2 == 0), (Some("--plain"), number % 2 != 0)] {
            let mut command = arguments(desk.root(), &["participant", "small"]);
            command.extend(more.map(OsString::from));
            let (window, mut child) = Window::open(binary(), &command, is_told).unwrap();
            let _waiting = ended_after_all(child.id());
            session.until("the participant's screen is open");
            while window.drawn().is_empty() {
                assert_eq!(child.try_wait().unwrap(), None);
                thread::yield_now();
            }
            window.close();
            assert_eq!(child.wait().unwrap().code(), Some(0), "{line}, {more:?}, told: {is_told}");
            session.until("the participant's screen was closed");
        }
    }
    let open = screen(&desk, &mut session);
    session.say("quit");
    session.until("left ");
    session.child.wait().unwrap();
    ends(open, 0);
    is_in_order(&desk, "participant");
}

#[test]
fn a_reader_that_is_gone_ends_a_session_as_a_closed_window_does() {
    let (desk, live) = journaling(&["--auto"]);
    let (mut child, _input) = live.unread();
    let _waiting = ended_after_all(child.id());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    is_in_order(&desk, "a pipe");
    assert_eq!(desk.trials(), 1);
    let head = Desk::new(false);
    let command = "\"$0\" \"$@\" | head -n 1; exit \"${PIPESTATUS[0]}\"";
    let mut bash = Command::new("bash");
    bash.args(["-c", command]).arg(binary());
    let acquire = ["acquire", "small", "-p", "P01", "-s", "S01", "--plain", "--auto", "--fast"];
    bash.args(arguments(head.root(), &acquire)).env_remove("ZWIDTH_ROOT");
    let ran = bash.output().unwrap();
    assert_eq!(ran.status.code(), Some(1), "{ran:?}");
    assert!(String::from_utf8_lossy(&ran.stderr).contains("the terminal is gone"), "{ran:?}");
    is_in_order(&head, "head");
    head.finish().exits(0);
}

#[test]
fn a_session_without_any_output_is_recorded_to_its_end() {
    let desk = Desk::new(false);
    let acquire = ["acquire", "small", "-p", "P01", "-s", "S01", "--plain", "--auto", "--fast"];
    let ran = Command::new("sh")
        .args(["-c", "exec \"$0\" \"$@\" <&- >&- 2>&-"])
        .arg(binary())
        .args(arguments(desk.root(), &acquire))
        .env_remove("ZWIDTH_ROOT")
        .status();
    assert_eq!(ran.unwrap().code(), Some(0));
    assert_eq!(desk.trials(), TRIALS);
    is_in_order(&desk, "closed output");
}

#[test]
fn a_closed_window_ends_a_session_under_nohup_in_order() {
    let desk = Desk::slow();
    let log = desk.root().join("log");
    let script = "log=$1; shift; exec nohup \"$0\" \"$@\" >\"$log\" 2>&1";
    let acquire = ["acquire", "small", "-p", "P01", "-s", "S01", "--plain", "--auto"];
    let mut all: Vec<OsString> = vec!["-c".into(), script.into(), binary().into()];
    all.push(log.clone().into());
    all.extend(arguments(desk.root(), &acquire));
    let (window, mut child) = Window::open("sh", &all, true).unwrap();
    let _waiting = ended_after_all(child.id());
    while !holds_samples(&desk) && desk.trials() == 0 {
        assert_eq!(child.try_wait().unwrap(), None);
        thread::yield_now();
    }
    window.close();
    assert_eq!(child.wait().unwrap().code(), Some(1));
    is_in_order(&desk, "nohup");
    assert!(desk.trials() > 0);
}

/// What a command writes to a terminal, until it has ended.
fn drawn_by(root: &Path, more: &[&str]) -> String {
    let script = format!("\"$0\" \"$@\"; echo {ENDED}");
    let mut all: Vec<OsString> = vec!["-c".into(), script.into(), binary().into()];
    all.extend(arguments(root, more));
    let (window, mut child) = Window::open("sh", &all, false).unwrap();
    loop {
        let drawn = String::from_utf8_lossy(&window.drawn()).into_owned();
        if drawn.contains(ENDED) {
            child.wait().unwrap();
            return drawn;
        }
        thread::yield_now();
    }
}

#[test]
fn what_may_take_long_tells_the_time_left_on_a_terminal_and_quiet_people_nothing() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "active", 1..=2));
    let root = study.root();
    zwidth(root, &["run", "demo", "--shard", "1/1"]).exits(0);
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/step.toml");
    let sds = ["--participant-mode-sd", "0.1", "--residual-sd", "0.1", "--studies", "100"];
    let power = [&["power", "demo", "--difference", "0.1"][..], &sds].concat();
    for command in [
        &["verify", "demo"][..],
        &["shards", "demo"],
        &["merge", "demo"],
        &["simulate", scene],
        &power,
    ] {
        let drawn = drawn_by(root, command);
        assert!(drawn.contains("s left"), "{command:?}: {drawn:?}");
        let quiet = drawn_by(root, &[&["--quiet"], command].concat());
        assert!(!quiet.contains("s left"), "{command:?}: {quiet:?}");
    }
}
