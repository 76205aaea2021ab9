//! A session that runs by itself: it gives the inputs that nobody else gives.

use crate::{AcquireError, Front, Input, Phase, View};
use std::time::Duration;

/// Another front end, and somebody who starts each trial, skips a question that the device's own
/// participant did not answer, and ends the session when it is done or stopped. Nobody holds the
/// lever against its stop, so this is for devices whose lever gets there by itself.
#[derive(Debug)]
pub struct Auto<F> {
    front: F,
    phase: Phase,
}

impl<F: Front> Auto<F> {
    /// Before that front end.
    pub fn new(front: F) -> Self {
        Self { front, phase: Phase::Check }
    }
}

impl<F: Front> Front for Auto<F> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        self.phase.clone_from(&view.phase);
        self.front.show(view)
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        let own = match self.phase {
            Phase::Ready | Phase::AtStop | Phase::Step { moves: false, .. } => Some(Input::Start),
            // Nobody is there to consent.
            Phase::Step { moves: true, .. } | Phase::Question { .. } => Some(Input::Skip),
            Phase::Stopped { .. } | Phase::Done => Some(Input::Quit),
            _ => None,
        };
        // An input of its own waits for nobody; what the front end says comes before it.
        let wait = if own.is_some() { Duration::ZERO } else { wait };
        Ok(self.front.next(wait)?.or(own))
    }
}

/// Nobody: shows nothing and says nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Nobody;

impl Front for Nobody {
    fn show(&mut self, _view: &View) -> Result<(), AcquireError> {
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        std::thread::sleep(wait);
        Ok(None)
    }
}
