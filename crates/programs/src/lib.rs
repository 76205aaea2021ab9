//! Programs of others: started in a process group of their own, and ended with all that they start.
//!
//! A stage of a study's own and a device by a process are started like this. This is no sandbox: what
//! such a program may do, the user may do.

use std::ffi::OsString;
use std::io;
use std::path::Path;
use std::process::{Child, Command, ExitStatus};

/// What the system is given to start: a path of several parts is a file of the study's own, from that
/// folder on, because where the system would begin it is not the same everywhere. A name is looked up
/// on the path.
pub fn program_at(name: &str, folder: &Path) -> OsString {
    match Path::new(name).components().count() {
        0 | 1 => name.into(),
        _ => folder.join(name).into(),
    }
}

/// A program that was started, with whatever it starts.
pub struct Group {
    child: Child,
}

impl Group {
    /// Starts a program as the first of a group of its own.
    ///
    /// # Errors
    /// A program that the system does not start.
    pub fn start(command: &mut Command) -> io::Result<Self> {
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { child: command.spawn()? })
    }

    /// The program itself, whose pipes may be taken.
    pub fn program(&mut self) -> &mut Child {
        &mut self.child
    }
}

#[cfg(unix)]
impl Group {
    /// Whether the program has ended. Its status is left to be taken by [`Group::end`]: so long the
    /// system gives the number of its group to nobody else.
    ///
    /// # Errors
    /// A system that does not tell.
    pub fn has_ended(&mut self) -> io::Result<bool> {
        use rustix::process::{Pid, WaitId, WaitIdOptions, waitid};
        let options = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        Ok(waitid(WaitId::Pid(Pid::from_child(&self.child)), options)?.is_some())
    }

    /// Ends what is left of the group, and gives the program's status.
    ///
    /// # Errors
    /// A system that does not give it.
    pub fn end(mut self) -> io::Result<ExitStatus> {
        use rustix::process::{Pid, Signal, kill_process_group};
        // Of a group that is empty already nothing is left to end.
        let _ = kill_process_group(Pid::from_child(&self.child), Signal::KILL);
        self.child.wait()
    }
}

#[cfg(not(unix))]
impl Group {
    /// Whether the program has ended.
    ///
    /// # Errors
    /// A system that does not tell.
    pub fn has_ended(&mut self) -> io::Result<bool> {
        Ok(self.child.try_wait()?.is_some())
    }

    /// Ends the program, if it goes on, and gives its status. Its children are left alone: on Windows
    /// that takes a job object.
    ///
    /// # Errors
    /// A system that does not give it.
    pub fn end(mut self) -> io::Result<ExitStatus> {
        // It may have ended by itself.
        let _ = self.child.kill();
        self.child.wait()
    }
}

/// The signal that ended a program.
#[cfg(unix)]
pub fn signal_of(status: ExitStatus) -> i32 {
    std::os::unix::process::ExitStatusExt::signal(&status).unwrap_or_default()
}

/// The signal that ended a program: there are none.
#[cfg(not(unix))]
pub fn signal_of(_: ExitStatus) -> i32 {
    0
}
