//! Strangers at the participant's door: any user of the machine can connect to it.

use crate::acquire::{Desk, Live};
use crate::participant::{ends, refused, screen, session};
use std::fs;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// Between two bytes of somebody slow.
const BETWEEN: Duration = Duration::from_millis(100);
/// Bytes after which they give up: half a minute's.
const MOST: usize = 300;

fn file(desk: &Desk) -> PathBuf {
    desk.root().join("raw/small/.participant")
}

fn port(desk: &Desk) -> u16 {
    let text = fs::read_to_string(file(desk)).unwrap();
    text.split_once(' ').unwrap().0.parse().unwrap()
}

/// Somebody who holds the door: sends a byte now and then, on a new line whenever one is closed.
/// Whether they gave up before they were told to go.
fn holding(port: u16) -> (Sender<()>, JoinHandle<bool>) {
    let (go, told) = channel();
    let thread = thread::spawn(move || {
        let mut line = TcpStream::connect(("127.0.0.1", port)).ok();
        for _ in 0..MOST {
            let taken = line.as_mut().is_some_and(|line| line.write_all(b"z").is_ok());
            if !taken {
                line = TcpStream::connect(("127.0.0.1", port)).ok();
            }
            if told.recv_timeout(BETWEEN) != Err(RecvTimeoutError::Timeout) {
                return false;
            }
        }
        true
    });
    (go, thread)
}

fn end(session: &mut Live, how: &str) {
    if how == "quit" {
        return session.say(how);
    }
    let process = session.child.id().to_string();
    Command::new("kill").args([how, &process]).status().unwrap();
}

#[test]
fn whoever_sends_a_byte_now_and_then_holds_up_neither_quit_nor_a_signal() {
    for (how, code) in [("quit", 3), ("-INT", 1), ("-TERM", 1)] {
        let desk = Desk::new(false);
        let mut session = session(&desk);
        let (go, holder) = holding(port(&desk));
        end(&mut session, how);
        ends(session, code);
        drop(go);
        assert!(!holder.join().unwrap(), "{how} was held up");
        assert!(!file(&desk).exists());
        desk.finish().exits(0);
    }
}

#[test]
fn three_hundred_who_say_nothing_do_not_shut_the_screen_out() {
    let desk = Desk::new(false);
    let mut session = session(&desk);
    let port = port(&desk);
    let idle: Vec<_> = (0..300).map(|_| TcpStream::connect(("127.0.0.1", port))).collect();
    let mut screen = screen(&desk, &mut session);
    screen.until("ready: ");
    drop(idle);
    session.say("quit");
    ends(session, 3);
    ends(screen, 0);
}

#[test]
fn a_liar_at_the_port_of_an_earlier_session_gets_no_secret_and_is_not_shown() {
    let desk = Desk::new(false);
    let secret = "5".repeat(64);
    for lie in ["\"taken\"\n", "{\"sight\":{}}\n", "\u{1b}[2Jtype your password\n", "zw\u{7}"] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let _ = fs::remove_file(file(&desk));
        let mut new = fs::OpenOptions::new();
        let mut stale = new.write(true).create_new(true).mode(0o600).open(file(&desk)).unwrap();
        writeln!(stale, "{port} {secret}").unwrap();
        let liar = thread::spawn(move || {
            let mut line = listener.accept().unwrap().0;
            let mut heard = String::new();
            BufReader::new(&line).read_line(&mut heard).unwrap();
            let _ = line.write_all(lie.as_bytes());
            // What comes after a lie is nothing, or the end.
            let _ = line.shutdown(std::net::Shutdown::Write);
            let _ = line.read_to_string(&mut heard);
            heard
        });
        let ran = refused(&desk).says(&["no session of this study is being recorded"]);
        let heard = liar.join().unwrap();
        assert!(heard.lines().count() == 1 && !heard.contains(&secret), "{heard}");
        let shown = ran.out + &ran.err;
        assert!(!shown.contains(['\u{1b}', '\u{7}']) && !shown.contains("password"), "{shown}");
    }
}

#[test]
fn a_file_that_others_can_read_is_not_followed() {
    let desk = Desk::new(false);
    let mut session = session(&desk);
    fs::set_permissions(file(&desk), fs::Permissions::from_mode(0o644)).unwrap();
    refused(&desk).says(&["others can read or write it", "remove it"]);
    session.say("quit");
    ends(session, 3);
}

/// Reads the file named first; holds the door at the port named second.
const STRANGER: &str = r#"
    trap '' PIPE
    if cat "$1" 2>/dev/null; then echo read; else echo refused; fi
    exec 3<>"/dev/tcp/127.0.0.1/$2" && echo connected
    while true; do printf z >&3 || exec 3<>"/dev/tcp/127.0.0.1/$2"; sleep 0.1; done
"#;

#[test]
fn another_user_of_the_machine_reads_no_secret_and_holds_up_nothing() {
    const ANOTHER: [&str; 5] = ["--reuid", "65534", "--regid", "65534", "--clear-groups"];
    let possible = Command::new("setpriv").args(ANOTHER).arg("true").status();
    if !possible.is_ok_and(|status| status.success()) {
        println!("skipped: only root becomes another user (setpriv --reuid)");
        return;
    }
    let desk = Desk::new(false);
    // The file has to protect itself: its folders are open to all.
    fs::set_permissions(desk.root(), fs::Permissions::from_mode(0o755)).unwrap();
    let mut session = session(&desk);
    let mut stranger = Command::new("setpriv")
        .args(ANOTHER)
        .args(["bash", "-c", STRANGER, "bash"])
        .args([file(&desk), port(&desk).to_string().into()])
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(stranger.stdout.take().unwrap()).lines();
    assert_eq!(said.next().unwrap().unwrap(), "refused");
    assert_eq!(said.next().unwrap().unwrap(), "connected");
    let screen = screen(&desk, &mut session);
    session.say("quit");
    ends(session, 3);
    ends(screen, 0);
    stranger.kill().unwrap();
    stranger.wait().unwrap();
    desk.finish().exits(0);
}
