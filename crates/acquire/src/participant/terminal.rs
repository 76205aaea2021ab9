//! The participant's screen on a terminal. One thread does it all: nothing waits for it.

use super::draw::render;
use super::guest::Guest;
use super::keys::{Pressed, press};
use super::sight::{Now, Sight};
use crate::AcquireError;
use crate::screen::look::Look;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event};
use std::io::{self, IsTerminal as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Longest wait for a key, and for the session, each time: more often than a person follows.
const WAIT: Duration = Duration::from_millis(20);

/// Shows a session on the terminal until it is over, the screen is closed, or `quit` is raised;
/// whether the session is over. The terminal is given back in any case.
///
/// # Errors
/// There is no terminal, or it is gone; the session is gone.
pub fn show_screen(guest: Guest, look: Look, quit: &AtomicBool) -> Result<bool, AcquireError> {
    if !(io::stdin().is_terminal() && io::stdout().is_terminal()) {
        return Err(AcquireError::Refused {
            what: "the screen needs a terminal, and input or output is not one".into(),
            remedy: "use --plain in scripts and pipes".into(),
        });
    }
    let mut terminal = ratatui::try_init().map_err(lost)?;
    let shown = show(guest, &mut terminal, look, quit);
    // A terminal that is gone cannot be given back.
    let _ = ratatui::try_restore();
    shown
}

fn show(
    mut guest: Guest,
    terminal: &mut DefaultTerminal,
    look: Look,
    quit: &AtomicBool,
) -> Result<bool, AcquireError> {
    let (mut sight, mut typed, mut answered) = (Sight::default(), String::new(), None);
    let mut fresh = true;
    while !quit.load(Ordering::SeqCst) {
        while let Some(next) = guest.next(Duration::ZERO)? {
            // What was typed belongs to its question.
            if next.asked() != sight.asked() {
                typed.clear();
            }
            (sight, fresh) = (next, true);
            if sight.now == Now::Left {
                return Ok(true);
            }
        }
        let number = sight.asked().map(|asked| asked.number);
        let is_answered = number.is_some() && number == answered;
        if std::mem::take(&mut fresh) {
            let frame = terminal.draw(|frame| render(&sight, &typed, is_answered, look, frame));
            frame.map_err(lost)?;
        }
        if !event::poll(WAIT).map_err(lost)? {
            continue;
        }
        fresh = true;
        let Event::Key(key) = event::read().map_err(lost)? else { continue };
        let open = sight.asked().filter(|_| !is_answered);
        let (after, pressed) = press(key, open, std::mem::take(&mut typed));
        typed = after;
        match (pressed, number) {
            (Some(Pressed::Close), _) => return Ok(false),
            (Some(Pressed::Answer(value)), Some(number)) => {
                guest.answer(number, value)?;
                answered = Some(number);
            }
            _ => {}
        }
    }
    Ok(false)
}

fn lost(error: io::Error) -> AcquireError {
    AcquireError::Refused {
        what: format!("this terminal cannot be used ({error})"),
        remedy: "open the participant's screen in another one; the session goes on".into(),
    }
}
