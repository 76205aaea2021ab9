//! A microcontroller that runs a sketch in an emulator (`tests/interop/avr/board.js`) with its own
//! time.

use anyhow::Context as _;
use std::io::{self, BufRead as _, BufReader, Write as _};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The emulator.
pub(crate) struct Emulator {
    child: Child,
    hears: ChildStdin,
    says: BufReader<ChildStdout>,
    /// What the microcontroller said and nobody has received.
    pub(crate) said: Vec<u8>,
    /// Pulses of motor and brake, and the direction.
    pub(crate) out: [u16; 3],
    /// Levels of the marker pin and of the one that is high in a trial.
    pub(crate) marker: u16,
    pub(crate) trial: u16,
    /// How long it ran, µs.
    pub(crate) us: u64,
}

impl Emulator {
    pub(crate) fn start(command: &[&str]) -> anyhow::Result<Self> {
        let (program, rest) = command.split_first().context("which command runs the emulator?")?;
        let mut command = Command::new(program);
        let piped = command.args(rest).stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut child = piped.spawn().with_context(|| format!("{program} does not run"))?;
        let hears = child.stdin.take().context("it hears nothing")?;
        let says = BufReader::new(child.stdout.take().context("it says nothing")?);
        Ok(Self { child, hears, says, said: Vec::new(), out: [0; 3], marker: 0, trial: 0, us: 0 })
    }

    /// What its sensors see.
    pub(crate) fn set(&mut self, what: &str, value: i32) -> io::Result<()> {
        writeln!(self.hears, "{what} {value}")
    }

    /// Gives it bytes and lets it run; what it has not taken by then waits for it.
    pub(crate) fn run(&mut self, us: u32, bytes: &[u8]) -> io::Result<()> {
        let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        writeln!(self.hears, "run {us} {digits}")?;
        self.hears.flush()?;
        let mut line = String::new();
        self.says.read_line(&mut line)?;
        let bad = || io::Error::other(format!("the emulator says {line:?}"));
        let mut words = line.trim_end_matches('\n').split(' ');
        self.said.extend(words.next().and_then(unhex).ok_or_else(bad)?);
        for out in self.out.iter_mut().chain([&mut self.marker, &mut self.trial]) {
            *out = words.next().and_then(|word| word.parse().ok()).ok_or_else(bad)?;
        }
        self.us += u64::from(us);
        Ok(())
    }

    /// Gives out what it said, as far as there is room.
    pub(crate) fn receive(&mut self, into: &mut [u8]) -> usize {
        let n = into.len().min(self.said.len());
        into[..n].copy_from_slice(&self.said[..n]);
        self.said.drain(..n);
        n
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn unhex(digits: &str) -> Option<Vec<u8>> {
    let pair = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    (0..digits.len()).step_by(2).map(pair).collect()
}
