//! A front end that may disappear: a window is closed, or the reader of a pipe ends.
//!
//! The session then ends as after a signal that ends the program: the running trial is cut short
//! and kept, the device is at 0 V, and the session can be resumed.

use crate::{AcquireError, Front, Input, View};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A front end, which the session outlives.
pub(super) struct Lasting<'a> {
    front: &'a mut dyn Front,
    /// The running trial ends at its next tick.
    stop: &'a AtomicBool,
    /// The session is left.
    quit: &'a AtomicBool,
    /// Why it is gone.
    gone: Option<String>,
}

impl<'a> Lasting<'a> {
    pub(super) fn new(
        front: &'a mut dyn Front,
        stop: &'a AtomicBool,
        quit: &'a AtomicBool,
    ) -> Self {
        Self { front, stop, quit, gone: None }
    }

    /// Why the front end is gone, if it is.
    pub(super) fn gone(&self) -> Option<&str> {
        self.gone.as_deref()
    }

    fn outlive<T: Default>(&mut self, done: Result<T, AcquireError>) -> Result<T, AcquireError> {
        match done {
            Err(AcquireError::Front(error)) => {
                // The first reason: later ones follow from it.
                self.gone.get_or_insert(error.to_string());
                self.stop.store(true, Ordering::SeqCst);
                self.quit.store(true, Ordering::SeqCst);
                Ok(T::default())
            }
            done => done,
        }
    }
}

impl Front for Lasting<'_> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        // Also to one that is gone: a participant's screen may be beside it.
        let shown = self.front.show(view);
        self.outlive(shown)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        if self.gone.is_some() {
            return Ok(None);
        }
        let input = self.front.next(wait);
        self.outlive(input)
    }
}
