//! The participant's own screen beside a session: as lines, beside plain mode.

use crate::acquire::{Desk, Live, TRIALS};
use crate::binary::{Ran, binary, zwidth};
use crate::said::{answers, log};
use std::process::{Command, Stdio};
use zwidth_tables::Table;

/// A session on a simulated clock, ready for its first trial.
pub(crate) fn session(desk: &Desk) -> Live {
    let mut session = Live::new(desk, &["--fast"]);
    session.until("ready 1 ");
    session
}

/// A participant's screen as lines.
pub(crate) fn lines(desk: &Desk) -> Live {
    let mut command = Command::new(binary());
    command.arg("--root").arg(desk.root()).args(["participant", "small", "--plain"]);
    command.env_remove("ZWIDTH_ROOT");
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    Live::of(command)
}

/// A participant's screen that the session has let in.
pub(crate) fn screen(desk: &Desk, session: &mut Live) -> Live {
    let screen = lines(desk);
    session.until("the participant's screen is open");
    screen
}

/// A screen that is not let in.
pub(crate) fn refused(desk: &Desk) -> Ran {
    zwidth(desk.root(), &["participant", "small", "--plain"]).exits(1).one_error()
}

pub(crate) fn ends(mut live: Live, code: i32) {
    assert_eq!(live.child.wait().unwrap().code(), Some(code));
}

#[test]
fn a_whole_session_is_answered_at_the_participants_screen_which_tells_no_mode() {
    let desk = Desk::new(false);
    let mut session = session(&desk);
    let mut screen = screen(&desk, &mut session);
    for trial in 1..=TRIALS {
        screen.say(if trial % 2 == 0 { "2" } else { "4" });
        session.say("start");
        session.until(&format!("trial {trial}: note: felt_"));
        session.until_any(&["ready ", "done "]);
    }
    let told = screen.all_until("done: ");
    session.say("quit");
    session.until("left 7 of 7");
    ends(session, 0);
    screen.until("left: ");
    ends(screen, 0);
    for word in ["active", "passive", "hybrid", "motor", "brake"] {
        assert!(!told.to_lowercase().contains(word), "{word} in {told}");
    }
    for word in ["ready: ", "question ", "1 strongly disagree"] {
        assert!(told.contains(word), "no {word} in {told}");
    }
    desk.verify();
    let typed = Desk::new(false);
    let lines: String = (1..=TRIALS).map(|t| format!("start\n{}\n", 4 - (t + 1) % 2 * 2)).collect();
    typed.acquire(&(lines + "quit\n"), &[]).exits(0);
    assert_eq!(answers(&desk), answers(&typed));
    assert_eq!(answers(&desk).len(), TRIALS - 1, "but for the one to practise");
}

#[test]
fn the_log_says_which_answers_came_from_the_participants_screen_and_how_long_they_took() {
    let desk = Desk::slow();
    desk.edit_study("\nfamiliarisation = 1\n", "\nfamiliarisation = 0\n");
    let mut session = Live::begun(&desk, &[], "ready 1 ");
    let mut screen = screen(&desk, &mut session);
    session.say("start");
    session.on_to("question ");
    screen.until("go: ");
    screen.until("question ");
    // From here on time has gone by since the question was shown.
    session.say("note waiting");
    let waiting = session.until("trial ");
    let (trial, _) = waiting.split_once(": note: waiting").unwrap();
    screen.say("4");
    session.until(&format!("{trial}: note: felt_"));
    session.say("quit");
    ends(session, 3);
    ends(screen, 0);
    let notes: Vec<_> = log(&desk).into_iter().filter(|l| l["what"]["event"] == "note").collect();
    let text = |note: &serde_json::Value| note["what"]["text"].as_str().unwrap().to_owned();
    let there = notes.iter().filter(|n| text(n).ends_with("at the participant's screen"));
    // It is the first one where the machine never stood still for so long that safety stopped it.
    let trial = answers(&desk)[0].0;
    assert_eq!(there.map(|note| note["what"]["trial"].clone()).collect::<Vec<_>>(), [trial]);
    assert_eq!(answers(&desk), [(trial, 4)]);
    let table = Table::from_parquet(&desk.root().join("derived/small/answers.parquet")).unwrap();
    assert!(matches!(table.floats("answer_time_s").unwrap()[..], [Some(_)]));
    desk.verify();
}

#[test]
fn the_session_goes_on_when_the_screen_dies_and_a_screen_may_come_late() {
    let desk = Desk::new(false);
    let mut session = session(&desk);
    let mut first = screen(&desk, &mut session);
    first.child.kill().unwrap();
    first.child.wait().unwrap();
    session.until("the participant's screen was closed");
    session.say("start");
    session.until("question ");
    session.say("3");
    session.until("trial 1 stored");
    session.until("ready 2 ");
    session.say("start");
    session.until("question ");
    let mut late = screen(&desk, &mut session);
    late.until("question ");
    late.say("nothing");
    late.until("'nothing' is not an answer: 1 to 5");
    late.say("5");
    session.until("trial 2 stored");
    session.say("quit");
    ends(session, 3);
    late.until("left: ");
    ends(late, 0);
    desk.verify();
}

#[test]
fn a_second_screen_is_refused_and_one_without_a_session_too() {
    let desk = Desk::new(false);
    refused(&desk).says(&["no session of small is being recorded", "zwidth acquire"]);
    let mut session = session(&desk);
    let first = screen(&desk, &mut session);
    refused(&desk).says(&["another participant's screen is open", "close that one"]);
    session.say("quit");
    ends(session, 3);
    ends(first, 0);
    refused(&desk).says(&["no session of small is being recorded"]);
}

#[test]
fn what_a_killed_session_left_is_no_obstacle() {
    let desk = Desk::new(false);
    let mut killed = session(&desk);
    let mut open = screen(&desk, &mut killed);
    killed.child.kill().unwrap();
    killed.child.wait().unwrap();
    open.until("stopped: finger off the lever");
    assert!(desk.root().join("raw/small/.participant").exists());
    refused(&desk).says(&["no session of this study is being recorded"]);
    desk.verify();
    let mut session = session(&desk);
    session.until("the participant's screen is open");
    open.until("ready: ");
    session.say("start");
    open.until("question ");
    open.say("4");
    session.until("trial 1 stored");
    session.say("quit");
    ends(session, 3);
    open.until("left: ");
    ends(open, 0);
    assert!(!desk.root().join("raw/small/.participant").exists());
    desk.verify();
}

#[test]
#[cfg(unix)]
fn a_session_that_a_signal_ends_is_waited_for() {
    let desk = Desk::new(false);
    let mut first = session(&desk);
    let mut open = screen(&desk, &mut first);
    let id = first.child.id().to_string();
    assert!(Command::new("kill").args(["-HUP", &id]).status().unwrap().success());
    assert!(!first.child.wait().unwrap().success());
    open.until("stopped: finger off the lever");
    let mut second = session(&desk);
    open.until("ready: ");
    second.say("quit");
    ends(second, 3);
    open.until("left: ");
    ends(open, 0);
}
