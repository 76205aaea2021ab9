//! The screen on a terminal: one thread reads keys, one draws, and neither waits for the other.

use super::keys::{Entry, press};
use super::look::Look;
use super::render::render;
use super::window::{Window, next_event};
use crate::{AcquireError, Front, Input, View};
use ratatui::crossterm::event::Event;
use ratatui::crossterm::terminal::size;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::Duration;

/// Shortest time between two frames: 30 a second, more than a person follows and little for a slow
/// line.
const FRAME: Duration = Duration::from_millis(33);

/// Longest wait for a key before the key thread looks whether the screen closes.
const KEY_WAIT: Duration = Duration::from_millis(50);

/// The screen of a session. The terminal is given back when it is dropped, and on a panic.
///
/// [`Front::show`] leaves the newest view for the drawing thread and returns; views that come
/// faster than frames are skipped. The screen does not handle signals: the handler of a signal
/// drops the screen.
#[derive(Debug)]
pub struct Screen {
    shared: Arc<Shared>,
    inputs: Receiver<Input>,
    keys: Option<JoinHandle<()>>,
    drawing: Option<JoinHandle<()>>,
}

/// What the threads share. The lock is held for a copy, never for input or output.
#[derive(Debug)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
    /// Raised by the stop key before anything else, for the control loop to see at its next tick.
    stop: Arc<AtomicBool>,
}

#[derive(Debug, Default)]
struct State {
    view: View,
    entry: Option<Entry>,
    fresh: bool,
    closing: bool,
    /// Why drawing or reading ended, if it did.
    lost: Option<io::Error>,
}

impl State {
    fn why_lost(&mut self) -> io::Error {
        self.lost.take().unwrap_or_else(|| io::ErrorKind::BrokenPipe.into())
    }
}

impl Screen {
    /// Takes the terminal. The stop key raises `stop` at once, before its [`Input::Stop`] is
    /// queued.
    ///
    /// # Errors
    /// There is no terminal, or it refuses.
    pub fn open(look: Look, stop: Arc<AtomicBool>) -> Result<Self, AcquireError> {
        let window = Window::take()?;
        let shared = Arc::new(Shared { state: Mutex::default(), changed: Condvar::new(), stop });
        let (sender, inputs) = channel();
        let mut screen = Self { shared: Arc::clone(&shared), inputs, keys: None, drawing: None };
        let shared_by_keys = Arc::clone(&shared);
        let keys = Builder::new().name("keys".into());
        screen.keys = Some(keys.spawn(move || shared_by_keys.read_keys(&sender))?);
        let drawing = Builder::new().name("screen".into());
        screen.drawing = Some(drawing.spawn(move || shared.draw_frames(window, look))?);
        Ok(screen)
    }
}

impl Front for Screen {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        let mut state = self.shared.lock();
        if self.drawing.as_ref().is_none_or(JoinHandle::is_finished) {
            return Err(state.why_lost().into());
        }
        state.view.clone_from(view);
        state.fresh = true;
        drop(state);
        self.shared.changed.notify_one();
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        match self.inputs.recv_timeout(wait) {
            Ok(input) => Ok(Some(input)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(self.shared.lock().why_lost().into()),
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        self.shared.lock().closing = true;
        self.shared.changed.notify_one();
        // The drawing thread gives the terminal back. One that hangs holds the output: the terminal
        // takes nothing more, and would hang this as well.
        wait_for(self.drawing.as_ref());
        wait_for(self.keys.as_ref());
    }
}

/// Waits for a thread's end for a while. The rest is left to the end of the program.
fn wait_for(thread: Option<&JoinHandle<()>>) {
    /// Half a second in all: some ten times what an orderly end takes.
    const LOOKS: u32 = 50;
    const BETWEEN: Duration = Duration::from_millis(10);
    for _ in 0..LOOKS {
        if thread.is_none_or(JoinHandle::is_finished) {
            return;
        }
        std::thread::sleep(BETWEEN);
    }
}

impl Shared {
    /// A panic elsewhere leaves plain values behind: they can still be shown.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn read_keys(&self, inputs: &Sender<Input>) {
        while !self.lock().closing {
            let input = match next_event(KEY_WAIT) {
                Ok(event) => event.and_then(|event| self.take(&event)),
                Err(error) => {
                    self.lock().lost = Some(error);
                    return;
                }
            };
            if input.is_some_and(|input| inputs.send(input).is_err()) {
                return;
            }
        }
    }

    /// What an event of the terminal asks of the session; the stop flag is raised here.
    fn take(&self, event: &Event) -> Option<Input> {
        let mut state = self.lock();
        let mut input = None;
        if let Event::Key(key) = event {
            let entry = state.entry.take();
            (state.entry, input) = press(*key, &state.view.phase, entry);
        }
        if input == Some(Input::Stop) {
            self.stop.store(true, Ordering::SeqCst);
        }
        state.fresh = true;
        drop(state);
        self.changed.notify_one();
        input
    }

    fn draw_frames(&self, mut window: Window, look: Look) {
        while let Some((view, entry)) = self.wait_for_change() {
            let drawn = window.draw(|frame| render(&view, entry.as_ref(), look, frame));
            if let Err(error) = drawn {
                self.lock().lost = Some(error);
                return;
            }
            std::thread::sleep(FRAME);
        }
    }

    /// What is to be drawn next; none when the screen closes.
    fn wait_for_change(&self) -> Option<(View, Option<Entry>)> {
        let mut state = self
            .changed
            .wait_while(self.lock(), |state| !state.fresh && !state.closing)
            .unwrap_or_else(PoisonError::into_inner);
        state.fresh = false;
        (!state.closing).then(|| (state.view.clone(), state.entry.clone()))
    }
}

/// Letters in a line of the terminal that this program runs in, if it does in one.
pub fn terminal_width() -> Option<usize> {
    size().ok().map(|(columns, _)| columns.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Phase;
    use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

    fn shared(phase: Phase) -> Shared {
        let state = State { view: View { phase, ..View::default() }, ..State::default() };
        Shared { state: Mutex::new(state), changed: Condvar::new(), stop: Arc::default() }
    }

    fn key(code: KeyCode) -> Event {
        Event::Key(KeyEvent::new(code, KeyModifiers::NONE))
    }

    #[test]
    fn the_stop_key_raises_the_flag_before_its_input_is_handed_over() {
        let shared = shared(Phase::Trial { t_s: 0.5, limit_s: 4.0 });
        assert_eq!(shared.take(&key(KeyCode::Char('5'))), None);
        assert!(!shared.stop.load(Ordering::SeqCst));
        assert_eq!(shared.take(&key(KeyCode::Char(' '))), Some(Input::Stop));
        assert!(shared.stop.load(Ordering::SeqCst));
    }

    #[test]
    fn a_new_size_asks_for_a_frame_and_nothing_else() {
        let shared = shared(Phase::Ready);
        assert_eq!(shared.take(&Event::Resize(80, 24)), None);
        assert!(shared.wait_for_change().is_some());
    }

    #[test]
    fn what_is_typed_is_kept_between_keys_and_drawn() {
        let shared = shared(Phase::Ready);
        shared.take(&key(KeyCode::Char('n')));
        shared.take(&key(KeyCode::Char('a')));
        let (_, entry) = shared.wait_for_change().unwrap();
        assert_eq!(entry, Some(Entry::Note(None, "a".into())));
    }

    #[test]
    fn a_screen_that_closes_draws_no_more() {
        let shared = shared(Phase::Ready);
        shared.lock().closing = true;
        assert!(shared.wait_for_change().is_none());
    }
}
