//! The wire to a program: its standard input and output.

use super::Process;
use crate::Wire;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::ioctl_fionbio;
use std::collections::VecDeque;
use std::fmt::Display;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsFd;
use std::process::{ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use zwidth_device::DeviceError;
use zwidth_programs::{Group, program_at, signal_of};

/// A write is given up after this long: the program takes nothing.
const WRITE: Duration = Duration::from_millis(20);
/// A program whose input was closed may take so long to bring its device to rest and to end.
const GRACE: Duration = Duration::from_millis(500);
/// Between two looks whether it has ended.
const LOOK: Duration = Duration::from_millis(2);
/// Of what it prints on its standard error so much is kept, bytes.
const KEPT: usize = 4096;

/// A program, started again when it is opened again, and ended with all that it started.
pub(crate) struct Program {
    table: Process,
    running: Option<Running>,
    /// Why it does not run any more: told again whenever it is asked, because who was told first may
    /// have had nobody to tell it to.
    ended: String,
}

struct Running {
    group: Group,
    /// Closed when it is to end.
    input: Option<ChildStdin>,
    output: ChildStdout,
    printed: Arc<Mutex<VecDeque<u8>>>,
    /// It hangs up when all that was printed has come.
    all_printed: Receiver<()>,
}

impl Program {
    /// Starts a program.
    ///
    /// # Errors
    /// One that the system does not start.
    pub(crate) fn start(table: &Process) -> Result<Self, DeviceError> {
        let running = Running::start(table).map_err(|why| DeviceError::Unable {
            device: table.command.join(" "),
            what: format!("it cannot be started: {why}"),
            remedy: "correct process.command in rig.toml; a program of your own in analysis/STUDY is written ./NAME".to_owned(),
        })?;
        Ok(Self { table: table.clone(), running: Some(running), ended: String::new() })
    }

    fn running(&mut self) -> io::Result<&mut Running> {
        let ended = &self.ended;
        self.running.as_mut().ok_or_else(|| io::Error::new(ErrorKind::BrokenPipe, ended.clone()))
    }

    /// Ends it, and says why.
    fn over(&mut self, why: impl Display) -> io::Error {
        let how = self.running.take().map_or_else(String::new, Running::end);
        self.ended = format!("{why}{how}");
        io::Error::new(ErrorKind::BrokenPipe, self.ended.clone())
    }
}

impl Running {
    fn start(table: &Process) -> io::Result<Self> {
        let [program, arguments @ ..] = table.command.as_slice() else {
            return Err(io::Error::other("the command is empty"));
        };
        // Relative to a folder that is not absolute, the system would look from that folder on again.
        let folder = std::path::absolute(&table.folder)?;
        let mut command = Command::new(program_at(program, &folder));
        command.args(arguments).current_dir(&folder);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut group = Group::start(&mut command)?;
        let program = group.program();
        let pipes = (program.stdin.take(), program.stdout.take(), program.stderr.take());
        let (Some(input), Some(output), Some(errors)) = pipes else {
            return Err(io::Error::other("the system gave no pipes"));
        };
        ioctl_fionbio(&input, true)?;
        ioctl_fionbio(&output, true)?;
        let printed = Arc::default();
        let all_printed = keep(errors, Arc::clone(&printed));
        Ok(Self { group, input: Some(input), output, printed, all_printed })
    }

    /// Closes its input, gives it the time to end by itself, and ends it with all that it started; how
    /// it ended.
    fn end(mut self) -> String {
        drop(self.input.take());
        let began = Instant::now();
        let mut ended = false;
        while !ended && began.elapsed() < GRACE {
            // One of which the system does not tell is ended at once.
            ended = self.group.has_ended().unwrap_or(true);
            if !ended {
                std::thread::sleep(LOOK);
            }
        }
        let how = match self.group.end() {
            Ok(status) if ended => told(status),
            _ => "; it did not end by itself when its input was closed, and was ended".to_owned(),
        };
        // What it printed last may still be on its way; something that left its group may keep the pipe open.
        let _ = self.all_printed.recv_timeout(GRACE);
        let printed = self.printed.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes: Vec<u8> = printed.iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        match text.lines().rev().find(|line| !line.trim().is_empty()) {
            Some(last) => format!("{how}; it printed last: {}", last.trim()),
            None => how,
        }
    }
}

fn told(status: ExitStatus) -> String {
    match status.code() {
        Some(code) => format!("; it ended with exit code {code}"),
        None => format!("; it was ended by signal {}", signal_of(status)),
    }
}

/// Keeps the last that comes. Nobody waits long for this thread: a child of the program may keep the pipe
/// open. What is given back hangs up when all has come.
fn keep(mut errors: ChildStderr, printed: Arc<Mutex<VecDeque<u8>>>) -> Receiver<()> {
    let (ends, all_printed) = channel();
    std::thread::spawn(move || {
        let _ends: Sender<()> = ends;
        let mut bytes = [0; 1024];
        while let Ok(came @ 1..) = errors.read(&mut bytes) {
            let mut printed = printed.lock().unwrap_or_else(PoisonError::into_inner);
            printed.extend(&bytes[..came]);
            let old = printed.len().saturating_sub(KEPT);
            printed.drain(..old);
        }
    });
    all_printed
}

/// Waits until something can be read or written there, for so long at most.
fn wait_for(pipe: &impl AsFd, what: PollFlags, wait: Duration) -> io::Result<()> {
    let wait = Timespec::try_from(wait).map_err(io::Error::other)?;
    match poll(&mut [PollFd::new(pipe, what)], Some(&wait)) {
        Err(rustix::io::Errno::INTR) | Ok(_) => Ok(()),
        Err(why) => Err(why.into()),
    }
}

impl Wire for Program {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        let output = &mut self.running()?.output;
        let mut came = output.read(into);
        if came.as_ref().is_err_and(|why| why.kind() == ErrorKind::WouldBlock) && !wait.is_zero() {
            wait_for(output, PollFlags::IN, wait)?;
            came = output.read(into);
        }
        match came {
            Ok(0) if !into.is_empty() => Err(self.over("it closed its standard output")),
            Err(why) if matches!(why.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                Ok(0)
            }
            Err(why) => Err(self.over(why)),
            came => came,
        }
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        let began = Instant::now();
        let mut left = bytes;
        while !left.is_empty() {
            let running = self.running()?;
            let Some(input) = &mut running.input else {
                return Err(ErrorKind::NotConnected.into());
            };
            match input.write(left) {
                Ok(sent) => left = &left[sent..],
                Err(why) if why.kind() == ErrorKind::WouldBlock => {
                    let Some(more) = WRITE.checked_sub(began.elapsed()) else {
                        return Err(self.over("it does not read its standard input"));
                    };
                    wait_for(input, PollFlags::OUT, more)?;
                }
                Err(why) if why.kind() == ErrorKind::Interrupted => {}
                Err(_) => return Err(self.over("it closed its standard input")),
            }
        }
        Ok(())
    }

    fn reopen(&mut self) -> io::Result<()> {
        if let Some(running) = self.running.take() {
            running.end();
        }
        self.running = Some(Running::start(&self.table)?);
        Ok(())
    }
}

/// It gets the time to bring its device to rest, and nothing that it started is left.
impl Drop for Program {
    fn drop(&mut self) {
        if let Some(running) = self.running.take() {
            running.end();
        }
    }
}
