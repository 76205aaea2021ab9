//! The terminal that a screen has taken, until it is given back or goes away.

use crate::AcquireError;
use ratatui::crossterm::event::{self, Event};
use ratatui::crossterm::execute;
use ratatui::crossterm::terminal::{
    EnterAlternateScreen, LeaveAlternateScreen, disable_raw_mode, enable_raw_mode,
};
use ratatui::prelude::CrosstermBackend;
use ratatui::{Frame, Terminal};
use std::io::{self, ErrorKind, IsTerminal as _, Stdout, Write};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// A terminal that is drawn on. It is given back when this is dropped, also by a panic.
pub(crate) struct Window {
    terminal: Terminal<CrosstermBackend<Output>>,
    lost: Lost,
    /// Dropped after the terminal, which shows its cursor again.
    _taken: Taken,
}

/// Why the output failed, if it did.
type Lost = Arc<Mutex<Option<io::Error>>>;

impl Window {
    /// Takes the terminal.
    ///
    /// # Errors
    /// There is no terminal, or it refuses.
    pub(crate) fn take() -> Result<Self, AcquireError> {
        if !(io::stdin().is_terminal() && io::stdout().is_terminal()) {
            return Err(AcquireError::refused(
                "the screen needs a terminal, and input or output is not one",
                "use --plain in scripts and pipes",
            ));
        }
        let lost = Lost::default();
        enable_raw_mode()?;
        let mut taken = Taken(Output::new(&lost));
        execute!(taken.0, EnterAlternateScreen)?;
        let terminal = Terminal::new(CrosstermBackend::new(Output::new(&lost)))?;
        Ok(Self { terminal, lost, _taken: taken })
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// The terminal is gone.
    pub(crate) fn draw(&mut self, render: impl FnOnce(&mut Frame<'_>)) -> io::Result<()> {
        self.terminal.draw(render)?;
        match self.lost.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// Gives the terminal back.
struct Taken(Output);

impl Drop for Taken {
    fn drop(&mut self) {
        // A terminal that is gone cannot be given back.
        let _ = disable_raw_mode();
        let _ = execute!(self.0, LeaveAlternateScreen);
    }
}

/// Standard output that takes everything: why it failed is kept for [`Window::draw`]. ratatui prints
/// on standard error what it cannot do when it is dropped, which panics where that has gone with the
/// terminal, and so would end the program in the middle of a trial.
struct Output {
    out: Stdout,
    lost: Lost,
}

impl Output {
    fn new(lost: &Lost) -> Self {
        Self { out: io::stdout(), lost: Arc::clone(lost) }
    }

    /// What was done, or `otherwise` if it failed; why is kept.
    fn keep<T>(&self, done: io::Result<T>, otherwise: T) -> io::Result<T> {
        done.or_else(|error| {
            // The caller tries again by itself.
            if error.kind() == ErrorKind::Interrupted {
                return Err(error);
            }
            self.lost.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
            Ok(otherwise)
        })
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.out.write(bytes);
        self.keep(done, bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.out.flush();
        self.keep(done, ())
    }
}

/// The next event of the terminal, waiting for it at most `wait`.
///
/// # Errors
/// The terminal is gone.
pub(crate) fn next_event(wait: Duration) -> io::Result<Option<Event>> {
    if event::poll(wait)? {
        return event::read().map(Some);
    }
    // One that was hung up has nothing to say for ever, and is no terminal any more.
    if io::stdin().is_terminal() { Ok(None) } else { Err(ErrorKind::BrokenPipe.into()) }
}
