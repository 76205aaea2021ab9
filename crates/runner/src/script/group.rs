//! A program and its children: a process group.

use std::io;
use std::process::{Child, Command, ExitStatus};

/// A program that was started, with whatever it starts.
pub(super) struct Group {
    child: Child,
}

impl Group {
    /// Starts a program as the first of a group of its own.
    pub(super) fn start(command: &mut Command) -> io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { child: command.spawn()? })
    }
}

#[cfg(unix)]
impl Group {
    /// Whether the program has ended. Its status is left to be taken by [`Group::end`]: so long the
    /// system gives the number of its group to nobody else.
    pub(super) fn has_ended(&mut self) -> io::Result<bool> {
        use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(Pid::from_child(&self.child)), options)?.is_some())
    }

    /// Ends what is left of the group, and gives the program's status.
    pub(super) fn end(mut self) -> io::Result<ExitStatus> {
        use rustix::process::{Pid, Signal, kill_process_group};
        // Of a group that is empty already nothing is left to end.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        self.child.wait()
    }
}

#[cfg(not(unix))]
impl Group {
    /// Whether the program has ended.
    pub(super) fn has_ended(&mut self) -> io::Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Ends the program, if it goes on, and gives its status. Its children are left alone: on Windows
    /// that takes a job object.
    pub(super) fn end(mut self) -> io::Result<ExitStatus> {
        // It may have ended by itself.
        let _ = self.child.kill();
        self.child.wait()
    }
}

/// The signal that ended a program.
#[cfg(unix)]
pub(super) fn signal_of(status: ExitStatus) -> i32 {
    std::os::unix::process::ExitStatusExt::signal(&status).unwrap_or_default()
}

/// The signal that ended a program: there are none.
#[cfg(not(unix))]
pub(super) fn signal_of(_: ExitStatus) -> i32 {
    0
}
