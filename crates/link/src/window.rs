//! A terminal's window in software: a program runs in it, keys are typed, and it can be closed at any
//! moment, as a person closes one.

use rustix::io::ioctl_fionbio;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use std::ffi::OsStr;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Write as _};
use std::os::unix::ffi::OsStrExt as _;
use std::process::{Child, Command};
use std::sync::mpsc::{Sender, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Between two looks at what is typed and drawn.
const TURN: Duration = Duration::from_millis(5);
/// Gives the terminal its size, and becomes the program.
const SIZED: &str = "stty rows 30 cols 100 && exec \"$0\" \"$@\"";

/// A window of 100 × 30 cells, until it is closed or dropped.
pub struct Window {
    keys: Option<Sender<Vec<u8>>>,
    drawn: Arc<Mutex<Vec<u8>>>,
    thread: Option<JoinHandle<()>>,
}

impl Window {
    /// Opens a window with a program in it. `is_told`: the system tells the program when its window
    /// is closed (SIGHUP), as it tells one that a shell started; otherwise it has to notice by itself.
    ///
    /// # Errors
    /// A system that gives no pseudo-terminal, or has no `setsid`.
    pub fn open(
        program: impl AsRef<OsStr>,
        arguments: impl IntoIterator<Item = impl AsRef<OsStr>>,
        is_told: bool,
    ) -> io::Result<(Self, Child)> {
        // No other program may get our end: as long as anybody has it, the window is open.
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        ioctl_fionbio(&ours, true)?;
        let name = ptsname(&ours, Vec::new())?;
        let mut ours = File::from(ours);
        let theirs =
            OpenOptions::new().read(true).write(true).open(OsStr::from_bytes(name.as_bytes()))?;
        let mut command = Command::new("setsid");
        command.args(is_told.then_some("--ctty")).args(["sh", "-c", SIZED]);
        command.arg(program).args(arguments).env("TERM", "xterm").env_remove("ZWIDTH_ROOT");
        command.stdin(theirs.try_clone()?).stdout(theirs.try_clone()?).stderr(theirs);
        let child = command.spawn()?;
        // Its ends of the line go with it: only the program has them now.
        drop(command);
        let (keys, typed) = channel::<Vec<u8>>();
        let drawn = Arc::<Mutex<Vec<u8>>>::default();
        let screen = Arc::clone(&drawn);
        let thread = std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            loop {
                match typed.try_recv() {
                    // A program that is gone takes no keys.
                    Ok(keys) => drop(ours.write_all(&keys)),
                    Err(TryRecvError::Empty) => {}
                    Err(TryRecvError::Disconnected) => return,
                }
                match ours.read(&mut bytes) {
                    Ok(length) => {
                        let mut screen = screen.lock().unwrap_or_else(PoisonError::into_inner);
                        screen.extend_from_slice(&bytes[..length]);
                    }
                    // Nothing to be read now, or a program that is gone.
                    Err(_) => std::thread::sleep(TURN),
                }
            }
        });
        Ok((Self { keys: Some(keys), drawn, thread: Some(thread) }, child))
    }

    /// Types keys.
    pub fn type_keys(&self, keys: &str) {
        // The thread takes keys as long as the window is open.
        let _ = self.keys.as_ref().map(|typed| typed.send(keys.as_bytes().to_vec()));
    }

    /// All that the program wrote.
    pub fn drawn(&self) -> Vec<u8> {
        self.drawn.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Closes the window, whatever its program does.
    pub fn close(self) {
        drop(self);
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        drop(self.keys.take());
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
