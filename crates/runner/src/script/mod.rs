//! Programs of a study's own, which jobs may start: the stated exception to the rule that a job's
//! function does nothing but compute.
//!
//! A program runs in a folder of its own, in a process group of its own, with an environment that
//! names no more than it needs. What it prints goes into a file and not through a pipe, so that no
//! process that keeps a pipe open is waited for. When it ends, is ended after its time, or zwidth
//! itself is told to end, the whole group is killed: the program and its children. This is no
//! sandbox: what the program may do, the user may do.

mod signals;

pub use signals::HeldSignals;

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use zwidth_programs::{Group, program_at, signal_of};

/// Which programs of a study may be started.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Scripts {
    /// None.
    #[default]
    None,
    /// Those whose commands and files have one of these digests.
    Allowed(BTreeSet<String>),
    /// All.
    All,
}

impl Scripts {
    /// Whether a program with that digest may be started.
    pub fn allow(&self, digest: &str) -> bool {
        match self {
            Self::None => false,
            Self::Allowed(digests) => digests.contains(digest),
            Self::All => true,
        }
    }
}

/// A program to be started.
pub struct Script<'a> {
    /// Its name and its arguments; no shell reads them.
    pub command: &'a [String],
    /// The folder that it works in.
    pub folder: &'a Path,
    /// The file that receives what it prints, on both streams.
    pub printed: &'a Path,
    /// It is ended after this time.
    pub timeout: Duration,
}

/// Why a program gave nothing.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ScriptError {
    /// It could not be started; what the system says.
    NotStarted(String),
    /// It ended with this exit code.
    ExitCode(i32),
    /// It was ended by this signal, which zwidth did not send.
    Signal(i32),
    /// It was ended after its time.
    TooLong,
    /// It was ended because it printed more than [`MOST_PRINTED`].
    PrintedTooMuch,
    /// It was ended because zwidth was told to end.
    Stopped,
    /// The system does not tell how it fares.
    Lost(String),
}

/// The most that a program may print, bytes (64 MiB).
pub const MOST_PRINTED: u64 = 1 << 26;

/// The last that it printed, which errors show, bytes (64 KiB).
const SHOWN: u64 = 1 << 16;

/// What is waited between two looks at a program, at first and at most.
const LOOKS: [Duration; 2] = [Duration::from_millis(1), Duration::from_millis(20)];

/// The environment that a program gets besides `PATH` and `HOME`: whatever depends on the place, the
/// language or the time is the same everywhere.
pub const ENVIRONMENT: [(&str, &str); 4] =
    [("TZ", "UTC"), ("LC_ALL", "C.UTF-8"), ("SOURCE_DATE_EPOCH", "0"), ("PYTHONHASHSEED", "0")];

/// Runs a program to its end. Nothing of its process group is left when this returns.
///
/// # Errors
/// Whatever keeps it from ending with exit code 0.
pub fn run_script(script: &Script, signals: &HeldSignals) -> Result<(), ScriptError> {
    let not_started = |error: io::Error| ScriptError::NotStarted(error.to_string());
    let [program, arguments @ ..] = script.command else {
        return Err(ScriptError::NotStarted("the command is empty".to_owned()));
    };
    let printed = OpenOptions::new().create(true).append(true).open(script.printed);
    let printed = printed.map_err(not_started)?;
    let mut command = Command::new(program_at(program, script.folder));
    command.args(arguments).current_dir(script.folder).env_clear().envs(ENVIRONMENT);
    for name in ["PATH", "HOME"] {
        command.envs(std::env::var_os(name).map(|value| (name, value)));
    }
    command.stdin(Stdio::null());
    command.stdout(printed.try_clone().map_err(not_started)?);
    command.stderr(printed.try_clone().map_err(not_started)?);
    if signals.have_come() {
        return Err(ScriptError::Stopped);
    }
    let begun = Instant::now();
    let mut group = Group::start(&mut command).map_err(not_started)?;
    let mut pause = LOOKS[0];
    let cut_short = loop {
        match group.has_ended() {
            Ok(true) => break None,
            Ok(false) => {}
            Err(error) => break Some(ScriptError::Lost(error.to_string())),
        }
        if signals.have_come() {
            break Some(ScriptError::Stopped);
        }
        if begun.elapsed() >= script.timeout {
            break Some(ScriptError::TooLong);
        }
        if printed.metadata().is_ok_and(|file| file.len() > MOST_PRINTED) {
            break Some(ScriptError::PrintedTooMuch);
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(LOOKS[1]);
    };
    // Also after an orderly end: children may go on.
    let status = group.end();
    if let Some(error) = cut_short {
        return Err(error);
    }
    let status = status.map_err(|error| ScriptError::Lost(error.to_string()))?;
    match (status.success(), status.code()) {
        (true, _) => Ok(()),
        (false, Some(code)) => Err(ScriptError::ExitCode(code)),
        (false, None) => Err(ScriptError::Signal(signal_of(status))),
    }
}

/// The last that a program printed, at most 64 KiB, and whether there was more before it.
///
/// # Errors
/// A file that cannot be read.
pub fn last_printed(file: &Path) -> io::Result<(String, bool)> {
    let mut file = File::open(file)?;
    let length = file.metadata()?.len();
    file.seek(SeekFrom::Start(length.saturating_sub(SHOWN)))?;
    let mut bytes = Vec::new();
    // No more, whoever still writes.
    file.take(SHOWN).read_to_end(&mut bytes)?;
    Ok((String::from_utf8_lossy(&bytes).into_owned(), length > SHOWN))
}

#[cfg(test)]
#[cfg(unix)]
mod tests;
