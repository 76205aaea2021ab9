//! The participant's screen on a terminal. One thread does it all: nothing waits for it.

use super::draw::render;
use super::guest::Guest;
use super::keys::{Pressed, press};
use super::sight::{Now, Sight};
use crate::AcquireError;
use crate::screen::look::Look;
use crate::screen::window::{Window, next_event};
use ratatui::crossterm::event::Event;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Longest wait for a key, and for the session, each time: more often than a person follows.
const WAIT: Duration = Duration::from_millis(20);

/// Shows a session on the terminal until it is over, the screen is closed, the terminal is gone, or
/// `quit` is raised; whether the session is over. The terminal is given back in any case.
///
/// # Errors
/// There is no terminal; the session is gone.
pub fn show_screen(mut guest: Guest, look: Look, quit: &AtomicBool) -> Result<bool, AcquireError> {
    let mut window = Window::take()?;
    let mut sight = Sight::default();
    let mut typed = String::new();
    let mut answered = None;
    let mut fresh = true;
    while !quit.load(Ordering::SeqCst) {
        while let Some(next) = guest.next(Duration::ZERO)? {
            // What was typed belongs to its question.
            if next.question() != sight.question() {
                typed.clear();
            }
            // Numbers begin again in a session that goes on after a crash; its questions were closed before.
            answered = answered.filter(|_| next.question().is_some());
            (sight, fresh) = (next, true);
            if sight.now == Now::Left {
                return Ok(true);
            }
        }
        let number = sight.question().map(|question| question.number);
        let is_answered = number.is_some() && number == answered;
        if std::mem::take(&mut fresh)
            && window.draw(|frame| render(&sight, &typed, is_answered, look, frame)).is_err()
        {
            break;
        }
        let event = match next_event(WAIT) {
            Ok(Some(event)) => event,
            Ok(None) => continue,
            Err(_) => break,
        };
        fresh = true;
        let Event::Key(key) = event else { continue };
        let open = sight.question().filter(|_| !is_answered);
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
