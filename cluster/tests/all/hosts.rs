//! The processes of a cluster. Each ends with the test that began it.

use crate::stored::{URL, settings};
use std::io::{BufRead as _, BufReader, Read as _};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// Longest that a process of a test may take: one that takes longer hangs, which is a failure.
const HANGS: Duration = Duration::from_secs(1500);

/// A process that is killed when its test ends.
pub(crate) struct Host(Child);

impl Host {
    /// Kills it where it stands.
    pub(crate) fn kill(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        self.kill();
    }
}

/// `zwidth-cluster`.
pub(crate) fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_zwidth-cluster"));
    command.env_remove("ZWIDTH_ROOT");
    command
}

/// A scheduler and its address.
pub(crate) fn scheduler() -> (Host, String) {
    let mut command = program();
    command.args(["scheduler", "--bind", "127.0.0.1:0", "--executor-timeout", "15"]);
    let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
    let address = line.trim().rsplit(' ').next().unwrap().to_owned();
    (Host(child), address)
}

/// An executor, with these settings of its environment.
pub(crate) fn executor(scheduler: &str, environment: &[(&str, &str)]) -> Host {
    executor_with(scheduler, environment, &[])
}

/// An executor with these arguments too.
pub(crate) fn executor_with(scheduler: &str, environment: &[(&str, &str)], more: &[&str]) -> Host {
    let bind = format!("127.0.0.1:{}", free_port());
    let mut command = program();
    command.args(["executor", "--scheduler", scheduler, "--bind", &bind]).args(more);
    command.envs(environment.iter().copied());
    Host(command.spawn().unwrap())
}

/// A port that nobody listens at.
pub(crate) fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// What a finished process said.
#[derive(Debug)]
pub(crate) struct Ran {
    pub(crate) code: Option<i32>,
    pub(crate) err: String,
}

impl Ran {
    /// The exit code must be this one, and each of these words must have been said.
    #[track_caller]
    pub(crate) fn ends(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}", self.err);
        for word in words {
            assert!(self.err.contains(word), "{word:?} is not in {}", self.err);
        }
    }

    /// This must not have been said.
    #[track_caller]
    pub(crate) fn says_nothing_of(&self, word: &str) {
        assert!(!self.err.contains(word), "{word:?} is in {}", self.err);
    }
}

/// A process that goes on beside the test.
pub(crate) struct Running {
    id: u32,
    ended: mpsc::Receiver<Ran>,
}

impl Running {
    /// Begins it.
    pub(crate) fn begin(mut command: Command) -> Self {
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let (id, (end, ended)) = (child.id(), mpsc::channel());
        thread::spawn(move || {
            let mut err = String::new();
            child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
            let code = child.wait().unwrap().code();
            let _ = end.send(Ran { code, err });
        });
        Self { id, ended }
    }

    /// Interrupts it, as Ctrl-C does.
    pub(crate) fn interrupt(&self) {
        let sent = Command::new("kill").args(["-INT", &self.id.to_string()]).status().unwrap();
        assert!(sent.success());
    }

    /// Waits for its end.
    #[track_caller]
    pub(crate) fn end(self) -> Ran {
        self.ended.recv_timeout(HANGS).expect("it hangs")
    }
}

/// `zwidth-cluster fetch thesis-twin` into a data folder, from the store at an endpoint.
pub(crate) fn fetch(root: &Path, endpoint: &str, more: &[&str]) -> Ran {
    let mut command = program();
    command.args(["fetch", "thesis-twin", "--raw", URL, "--root"]).arg(root).args(more);
    command.envs(settings(endpoint));
    Running::begin(command).end()
}

/// `zwidth-cluster run thesis-twin` in a data folder.
pub(crate) fn run(root: &Path, scheduler: &str, more: &[&str]) -> Running {
    let mut command = program();
    command.args(["run", "thesis-twin", "--scheduler", scheduler, "--root"]).arg(root).args(more);
    Running::begin(command)
}
